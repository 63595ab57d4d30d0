"""One field less another, sample by sample, also from another grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import (
    Accuracy,
    Annotated,
    Identity,
    Model,
    NamedTuple,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Samples,
    Table,
    modeller,
    uniform,
)
from modules.data.laws import axial
from modules.data.operators import Floats
from modules.data.places import where
from modules.data.sampling import at_places, within
from modules.data.units import UnitError, linear, parse
from modules.modellers._linear import extra_of, flat, incoming, lattice_of
from modules.modellers._sampling import sampled
from modules.modellers._statistic import summed, total

CELLS = "it speaks of cells, and samples have none of these"


class Difference(NamedTuple):
    """The difference at the samples of the first, and how large it is."""

    samples: Samples
    metrics: Table


@modeller("Difference of fields", aliases=("subtract", "compare fields", "residual", "anomaly", "change", "minus", "rms"))
def difference(
    first: Samples,
    second: Model,
    progress: Progress,
    *,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
) -> Difference:
    """The first field less the second, at the samples of the first; and in a table how large the difference is.

    A second field on the same samples is taken as it stands; from another grid it is sampled by its law. Where it has no value
    there is a hole. The metrics are the mean (bias), the mean size, the root mean square, the largest size with its place, and
    which share of the samples differs by more than their total error.

    Parameters
    ----------
    first : of any grid
    second : a model in the same frame; 'interpolate' makes one of samples
    k : standard deviations that spreads count with in the metrics

    Raises
    ------
    ValueError : different components, frames or quantities, or no place in common

    Accuracy: errors of both go on; what both have in common is known, so that a field less itself has none. From another grid
    errors go through the weights of the law, which adds its own with its sign. Of the metrics the mean is linear, others are to
    first order, too low where the difference is within its error.
    Source: JCGM 100:2008, 5.2; ASME V&V 20, comparison error.
    """
    _check(first, second)
    unit, (scale_1, plus_1), (scale_2, plus_2) = _units(first.unit, second.unit)
    values, known = _second(first, second, progress)
    c, lattice = first.components, lattice_of(first)

    def times(accuracy: Accuracy, factor: float) -> Accuracy:
        operator = Identity(first.values.size) if factor == 1 else uniform(lattice, factor)
        return accuracy.push(operator, unit=unit, components=c)

    flags = tuple(f for f in known.flags if f.place == "point")
    accuracy = Accuracy.join([(times(incoming(first), scale_1), None), (times(known, -scale_2), None)]).flag(*flags)
    accuracy = accuracy.end_from(replace(second.accuracy, of=None), CELLS)
    name = f"{first.name or 'first'} less {second.samples.name or 'second'}"
    off = (scale_1 * first.values.astype(float) + plus_1) - (scale_2 * values + plus_2)
    made = Samples(grid=first.grid, values=off, unit=unit, name=name, accuracy=accuracy, time=first.time)
    return Difference(made, _metrics(made, k))


def _check(first: Samples, second: Model) -> None:
    if extra_of(first) != extra_of(second.samples):
        raise ValueError(f"the first has {first.components} numbers a sample, the second {second.samples.components}")
    d = max(first.grid.dimensions, second.grid.dimensions)
    one, other = first.grid.frame, second.grid.frame
    if one.axes[:d] != other.axes[:d] or one.units[:d] != other.units[:d]:
        raise ValueError("the two lie in different frames (names or units of axes): transform one of them first")


def _units(first: str, second: str) -> tuple[str, tuple[float, float], tuple[float, float]]:
    """The unit of the difference, and what brings either to it; temperatures with a zero of their own differ in kelvin."""
    if first == second and not _own_zero(first):
        return first, (1.0, 0.0), (1.0, 0.0)
    unit = "K" if _own_zero(first) or _own_zero(second) else first
    try:
        return unit, linear(first, unit), linear(second, unit)
    except UnitError:
        raise ValueError(
            f"the first is in {first or 'plain numbers'}, the second in {second or 'plain numbers'}: "
            "these have no difference; 'transform' changes a unit"
        ) from None


def _own_zero(unit: str) -> bool:
    try:
        return parse(unit).offset != 0
    except UnitError:
        return False


def _second(first: Samples, second: Model, progress: Progress) -> tuple[Floats, Accuracy]:
    """Values of the second at the samples of the first, and their accuracy."""
    if second.grid.same_place(first.grid):
        return second.samples.values.astype(float), incoming(second.samples)
    source = axial(second.grid)
    boxes = isinstance(first.grid, Regular | Rectilinear) and first.grid.dimensions == source.dimensions
    if boxes and within(second, first.grid.points()).all():
        found = sampled(second, first.grid, progress)
        return found.values, found.accuracy
    values, accuracy, _ = at_places(second, first.grid.points())
    return values.reshape(first.values.shape), accuracy


def _metrics(made: Samples, k: float) -> Table:
    """How large the difference is, with the error of each number and where the largest is."""
    values, c = flat(made), made.components
    size = np.abs(values) if c == 1 else np.sqrt((values.reshape(-1, c) ** 2).sum(axis=1))
    known = np.isfinite(size)
    n = max(int(known.sum()), 1)
    largest = int(np.nanargmax(np.where(known, size, -1.0)))
    names = ["mean", "mean size", "root mean square", "largest", "beyond its error", "samples"]
    rms = float(np.sqrt((size[known] ** 2).mean())) if known.any() else np.nan
    by = made.accuracy.total(k, "value") if made.accuracy.select("value", "point") else np.zeros(len(size))
    numbers = np.array([
        float(values.reshape(-1, c)[known].mean()) if c == 1 and known.any() else np.nan,
        float(size[known].mean()) if known.any() else np.nan,
        rms,
        float(size[largest]) if known.any() else np.nan,
        float((size[known] > by[known]).mean()) if known.any() else np.nan,
        float(known.sum()),
    ])  # fmt: skip
    along = np.zeros(len(values))
    some = np.repeat(known & (size > 0), c)
    along[some] = values[some] / np.repeat(size, c)[some]
    weights = np.zeros((6, len(values)))
    held = np.repeat(known, c)
    if c == 1:
        weights[0, held] = 1 / n
    weights[1, held] = along[held] / n
    if rms > 0:
        weights[2, held] = values[held] / (n * rms)
    weights[3, largest * c : largest * c + c] = along[largest * c : largest * c + c]
    told = replace(made, accuracy=replace(made.accuracy, of=None))
    accuracy = summed(told, weights, "value", made.unit)
    accuracy = replace(accuracy, terms=tuple(replace(t, components=1) for t in accuracy.terms))
    errors = total(accuracy, k, "value", 6)
    errors[4:] = np.nan, 0.0
    if c > 1:
        errors[0] = np.nan
    at = np.full((6, 3), np.nan)
    found = where(made, "point", np.array([largest]))
    if found is not None and known.any():
        at[3] = found[0]
    frame, d = made.grid.frame, made.grid.dimensions
    columns = {
        "metric": np.array(names, dtype=str), "value": numbers, "error": errors,
        "unit": np.array([made.unit] * 4 + ["", ""], dtype=str), **{frame.axes[i]: at[:, i] for i in range(d)},
    }  # fmt: skip
    units = {frame.axes[i]: frame.units[i] for i in range(d) if frame.units[i]}
    return Table(columns=columns, units=units, name=f"size of {made.name}", accuracy=accuracy)
