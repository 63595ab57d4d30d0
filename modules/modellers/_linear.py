"""A linear step: values and errors go through one operator, and the step tells its own error from the data."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from modules.api import Accuracy, Flag, Grid, Identity, Missing, Operator, Rectilinear, Regular, Samples, Source, Sum, Term
from modules.data.grid import Axial
from modules.data.operators import Floats
from modules.data.units import product
from modules.data.wires import TOO_FEW

GLANCE = 300
"""Samples that are looked at to tell the noise."""

AXES = {"x": 0, "y": 1, "z": 2}


def flat(samples: Samples) -> Floats:
    """The values as one column of float64, components fastest."""
    return samples.values.astype(np.float64, copy=False).ravel()


def extra_of(samples: Samples) -> tuple[int, ...]:
    """() of a scalar, (3,) of a vector, (3, 3) of a tensor."""
    return samples.values.shape[len(samples.grid.shape) :]


def lattice_of(samples: Samples) -> tuple[int, ...]:
    """Shape of the samples, and one more axis of components unless they are scalar."""
    return samples.grid.shape if samples.components == 1 else (*samples.grid.shape, samples.components)


def axial(samples: Samples, what: str) -> Axial:
    """The grid, if its cells are boxes along the axes; else a sentence."""
    if isinstance(samples.grid, Regular | Rectilinear):
        return samples.grid
    raise ValueError(f"{what} needs a regular or rectilinear grid, not a {samples.grid.kind} one: resample it first")


def chosen(grid: Grid, axis: str) -> tuple[int, ...]:
    """The axes that a word names: x, y, z, or all."""
    if axis == "all":
        return tuple(range(len(grid.shape)))
    if AXES[axis] >= len(grid.shape):
        raise ValueError(f"the data has no axis {axis}: it has {', '.join('xyz'[: len(grid.shape)])}")
    return (AXES[axis],)


def dimension(grid: Grid, axis: int) -> int:
    """Where the axis x (0), y (1) or z (2) stands in an array."""
    return len(grid.shape) - 1 - axis


def per(unit: str, lengths: str, power: int = 1) -> str:
    """The unit of a derivative: m per km is m/km, m/s per m is 1/s."""
    return product(unit, lengths, -power)


def incoming(samples: Samples) -> Accuracy:
    """The errors of the samples; what speaks of the cells between them ends."""
    accuracy = samples.accuracy
    for term in accuracy.terms:
        if term.place != "point":
            accuracy = accuracy.end(term, "it speaks of places between samples; this step works on samples")
    return accuracy


def carried(
    samples: Samples,
    operator: Operator,
    grid: Grid | None = None,
    *,
    extra: tuple[int, ...] | None = None,
    unit: str | None = None,
    name: str | None = None,
) -> Samples:
    """Values and errors after a linear operator.

    Parameters
    ----------
    operator : samples x components -> samples of `grid` x components of `extra`
    grid, extra, unit, name : of the result; those of the samples by default
    """
    grid, extra = grid or samples.grid, extra_of(samples) if extra is None else extra
    unit = samples.unit if unit is None else unit
    return Samples(
        grid=grid,
        values=np.asarray(operator.apply(flat(samples))).reshape(*grid.shape, *extra),
        unit=unit,
        name=samples.name if name is None else name,
        accuracy=incoming(samples).push(operator, unit=unit, components=math.prod(extra)),
        time=samples.time,
    )


def estimated(result: Samples, before: Samples, operator: Operator, source: Source) -> Samples:
    """The result with the step's own error as a signed estimate, flagged where noise could make as much.

    Parameters
    ----------
    before : the data
    operator : data -> result - truth, as far as the data tells
    """
    error = np.asarray(operator.apply(flat(before)))
    return with_own(result, error, source, noise_in(before, operator, result.components))


def with_own(result: Samples, error: Floats, source: Source, noise: float) -> Samples:
    """The result with a signed error of its own; NaN is not known, and below `noise` it is not resolvable."""
    c = result.components
    known = np.isfinite(error)
    own = Term(source, "signed", "value", result.unit, np.where(known, error, 0.0), Identity(len(error)), components=c)
    accuracy = result.accuracy.add(own)
    if (~known & np.isfinite(flat(result))).any():
        accuracy = accuracy.miss(Missing(source.name, TOO_FEW))
    size = np.sqrt((np.where(known, error, np.inf).reshape(-1, c) ** 2).sum(axis=1))
    below = np.flatnonzero(size <= noise) if noise > 0 else np.zeros(0, np.int64)
    if len(below):
        words = f"the step's own error cannot be told from the noise at {len(below)} of {result.grid.count} samples"
        accuracy = accuracy.flag(Flag("not resolvable", words, "point", below))
    return replace(result, accuracy=accuracy)


def noise_in(before: Samples, operator: Operator, components: int) -> float:
    """How large the outcome of an operator may be by the errors of the data alone: bounds and two deviations.

    Of several ways the sizes are added, which is never too small.
    """
    items = operator.shape[0] // components
    looked = np.unique(np.random.default_rng(0).integers(0, max(items, 1), GLANCE)) if items > GLANCE else np.arange(items)
    bounds, variance = 0.0, 0.0
    for term in before.accuracy.select("value", "point"):
        if term.kind not in ("bound", "linear", "members"):
            continue
        ways = operator.parts if isinstance(operator, Sum) else (operator,)
        size = sum(float(term.push(way, components=components).size(looked).max(initial=0.0)) for way in ways)
        if term.kind == "bound":
            bounds += size
        else:
            variance += size**2
    return bounds + 2 * math.sqrt(variance)
