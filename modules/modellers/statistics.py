"""Mean, median, extremes and others of a field, with the error of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import (
    Accuracy,
    Annotated,
    Flag,
    Identity,
    Missing,
    Range,
    Rectilinear,
    Regular,
    Samples,
    Source,
    Table,
    Term,
    modeller,
)
from modules.data.grid import Axial
from modules.data.laws import second_derivative
from modules.data.operators import Floats, Ints
from modules.data.places import where
from modules.data.units import product
from modules.modellers._linear import dimension, flat
from modules.modellers._statistic import bounds_of, deviation_of, summed, total

BEYOND = Source(
    "Bounds of order statistics", "model", "proven",
    "a quantile lies between those of the values less and more their bounds [quantile-bounds/1]",
)  # fmt: skip
TRAPEZOID = Source(
    "Straight lines in the integral", "model", "estimated",
    "h^3/12 times the second derivative of each cell along each axis [trapezoid/1]",
)  # fmt: skip
NOISY = 0.1
"""Share of the variance that may be noise before it is flagged."""


@modeller(
    "Statistics",
    output="table",
    aliases=("mean", "median", "percentile", "minimum", "maximum", "average", "integral", "standard deviation", "summary"),
)
def statistics(
    samples: Samples,
    *,
    percentiles: tuple[float, ...] = (5.0, 50.0, 95.0),
    k: Annotated[float, Range(0.5, 4)] = 2.0,
) -> Table:
    """Mean, standard deviation, extremes with their places, percentiles and integral of a field, with the error of each.

    Holes do not count. The integral is that of straight lines between samples, of regular and rectilinear grids without holes.

    Parameters
    ----------
    samples : single numbers
    percentiles : from 0 to 100; 50 is the median
    k : standard deviations that spreads count with in the column of the total

    Raises
    ------
    ValueError : vectors, no number at all, or a percentile outside 0 to 100

    Accuracy: mean and integral are linear: what samples have in common is known, so independent errors average out and common
    ones do not. Percentiles take the mean error of the samples that noise may carry over them, extremes their own; what bounds
    do to them is proven. Where samples are within the noise of an extreme it is flagged, and so is a spread that is noise.
    Members go through each number itself. The integral adds what straight lines leave, estimated with its sign.
    Source: JCGM 100:2008, 5.2; influence of a quantile, Huber 1981, 3.2.
    """
    if samples.components != 1:
        raise ValueError("statistics are of single numbers: take a component, or a length, with 'calculator'")
    if not all(0 <= p <= 100 for p in percentiles):
        raise ValueError(f"percentiles {percentiles} should be from 0 to 100")
    values = flat(samples)
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        raise ValueError("the field has no number at all: every sample is a hole")
    ranks = [0.0, *(p / 100 for p in percentiles), 1.0]
    names = ["mean", "standard deviation", "minimum", *map(_called, percentiles), "maximum", "integral", "samples"]
    m = len(names)

    def statistic(field: Floats) -> Floats:
        told = field[known]
        spread = told.std(ddof=1) if len(told) > 1 else 0.0
        return np.array([told.mean(), spread, *np.quantile(told, ranks), 0.0, 0.0])

    numbers, noise = statistic(values), deviation_of(samples)
    weights = np.zeros((m, len(values)))
    weights[0], weights[1] = _mean(values, known), _spread(values, known, numbers)
    for i, q in enumerate(ranks):
        weights[2 + i] = _rank(values, known, noise, q)
    accuracy = summed(samples, weights, "value", samples.unit, statistic)
    accuracy = _bounded(accuracy, samples, weights, known, ranks, numbers)
    accuracy = accuracy.flag(*_doubtful(values, known, noise, numbers, m - 3))
    errors = total(accuracy, k, "value", m)
    numbers[-2:] = np.nan, len(known)
    errors[-2:] = np.nan, 0.0
    units = [samples.unit] * (m - 2) + ["", ""]
    whole = _integral(samples, m)
    if whole is None:
        words = "there is no integral of a bent grid, of a grid with holes, or over axes of different units"
        accuracy = accuracy.flag(Flag("no value", words, "point", np.array([m - 2])))
    else:
        numbers[-2], units[-2], own = whole
        errors[-2] = total(own, k, "integral", m)[-2]
        accuracy = replace(accuracy, terms=(*accuracy.terms, *own.terms)).miss(*own.missing)
    places = {2: int(known[values[known].argmin()]), m - 3: int(known[values[known].argmax()])}
    return _table(samples, names, numbers, errors, units, places, accuracy)


def _called(p: float) -> str:
    return "median" if p == 50 else f"{p:g} %"


def _mean(values: Floats, known: Ints) -> Floats:
    weights = np.zeros(len(values))
    weights[known] = 1 / len(known)
    return weights


def _spread(values: Floats, known: Ints, numbers: Floats) -> Floats:
    weights = np.zeros(len(values))
    if numbers[1] > 0:
        weights[known] = (values[known] - numbers[0]) / ((len(known) - 1) * numbers[1])
    return weights


def _rank(values: Floats, known: Ints, noise: Floats, q: float) -> Floats:
    """How each sample counts in a quantile: those that noise may carry over it; of few, the one or two that it is made of."""
    told = values[known]
    order = np.argsort(told, kind="stable")
    place = q * (len(told) - 1)
    low = int(np.floor(place))
    high = min(low + 1, len(told) - 1)
    weights = np.zeros(len(values))
    at = told[order[low]] + (place - low) * (told[order[high]] - told[order[low]])
    wide = noise[known] / 2
    if 0 < q < 1 and (wide > 0).all():
        near = np.exp(-0.5 * np.minimum(np.abs((told - at) / wide), 30.0) ** 2) / wide
        if (near > 1e-3 * near.max()).sum() > 2:
            weights[known] = near / near.sum()
            return weights
    weights[known[order[low]]] += 1 - (place - low)
    weights[known[order[high]]] += place - low
    return weights


def _bounded(
    accuracy: Accuracy, samples: Samples, weights: Floats, known: Ints, ranks: list[float], numbers: Floats
) -> Accuracy:
    """With what bounds may do to quantiles beyond their weights, proven."""
    bounds = bounds_of(samples)
    if not bounds.any():
        return accuracy
    values, last = flat(samples), 2 + len(ranks)
    first = np.abs(weights) @ bounds
    up, down = (np.quantile((values + s * bounds)[known], ranks) for s in (1, -1))
    most = np.maximum(up - numbers[2:last], numbers[2:last] - down)
    rest = np.zeros(len(numbers))
    rest[1], rest[2:last] = _spread_rest(bounds[known], first[1]), most + first[2:last]
    return accuracy.add(Term(BEYOND, "bound", "value", samples.unit, rest, Identity(len(rest))))


def _spread_rest(bounds: Floats, first: float) -> float:
    """A standard deviation is a length: it changes by no more than the length of the change."""
    return float(np.sqrt((bounds**2).sum() / max(len(bounds) - 1, 1)) + first)


def _doubtful(values: Floats, known: Ints, noise: Floats, numbers: Floats, last: int) -> list[Flag]:
    told, sigma = values[known], noise[known]
    flags = []
    ends = ((2, told - told.min(), int(told.argmin())), (last, told.max() - told, int(told.argmax())))
    for row, away, mine in ends:
        near = int((away <= 2 * np.hypot(sigma, sigma[mine])).sum()) - 1
        if near > 0 and sigma.any():
            word = "smallest" if row == 2 else "largest"
            words = f"{near} other samples may be the {word}: noise makes the {word} value more extreme than the truth"
            flags.append(Flag("not linear", words, "point", np.array([row])))
    if numbers[1] > 0 and float((sigma**2).mean()) > NOISY * numbers[1] ** 2:
        words = f"{float((sigma**2).mean()) / numbers[1] ** 2:.0%} of the variance may be noise of the samples"
        flags.append(Flag("not linear", words, "point", np.array([1])))
    return flags


def _trapezoid(x: Floats) -> Floats:
    h = np.diff(x)
    return np.asarray((np.append(h, 0.0) + np.append(0.0, h)) / 2)


def _product_of(parts: list[Floats]) -> Floats:
    whole = np.ones(())
    for one in parts:
        whole = np.multiply.outer(whole, one)
    return whole.ravel()


def _integral(samples: Samples, rows: int) -> tuple[float, str, Accuracy] | None:
    """The integral, its unit, and its errors in the row before the last of a table; None where there is none."""
    grid, values = samples.grid, flat(samples)
    d = grid.dimensions
    if not isinstance(grid, Regular | Rectilinear) or min(grid.shape) < 2 or not np.isfinite(values).all():
        return None
    if len(set(grid.frame.units[:d])) > 1:
        return None
    plain = [_trapezoid(x) for x in reversed(grid.axes)]
    weights = np.zeros((rows, len(values)))
    weights[-2] = _product_of(plain)
    unit = product(samples.unit, grid.frame.units[0], d)
    accuracy = summed(samples, weights, "integral", unit)
    if min(grid.shape) < 3:
        accuracy = accuracy.miss(Missing(TRAPEZOID.name, "not estimated where an axis has fewer than three samples"))
    else:
        left = np.zeros(rows)
        left[-2] = _left_by_lines(grid, values, plain)
        accuracy = accuracy.add(Term(TRAPEZOID, "signed", "integral", unit, left, Identity(rows)))
    return float(weights[-2] @ values), unit, accuracy


def _left_by_lines(grid: Axial, values: Floats, plain: list[Floats]) -> float:
    """Trapezoids less the integral of a smooth field."""
    error = 0.0
    for axis, x in enumerate(grid.axes):
        cube = np.diff(x) ** 3 / 24
        parts = list(plain)
        parts[dimension(grid, axis)] = np.append(cube, 0.0) + np.append(0.0, cube)
        bend = np.nan_to_num(second_derivative(grid, values.reshape(grid.shape), axis)).ravel()
        error += float(_product_of(parts) @ bend)
    return error


def _table(
    samples: Samples, names: list[str], numbers: Floats, errors: Floats, units: list[str], places: dict[int, int],
    accuracy: Accuracy,
) -> Table:
    at = np.full((len(names), 3), np.nan)
    found = where(samples, "point", np.array(list(places.values())))
    if found is not None:
        at[list(places)] = found
    frame, d = samples.grid.frame, samples.grid.dimensions
    columns = {
        "statistic": np.array(names, dtype=str),
        "value": numbers,
        "error": errors,
        "unit": np.array(units, dtype=str),
        **{frame.axes[i]: at[:, i] for i in range(d)},
    }
    axes = {frame.axes[i]: frame.units[i] for i in range(d) if frame.units[i]}
    title = f"statistics of {samples.name}" if samples.name else "statistics"
    return Table(columns=columns, units=axes, name=title, accuracy=accuracy)
