"""A model sampled anew, on a lattice of its own or on the grid of other data."""

from __future__ import annotations

import math

import numpy as np

from modules.api import Annotated, Model, Progress, Range, Rectilinear, Regular, Samples, modeller, regular
from modules.data.grid import Axial, Grid
from modules.modellers._linear import axial
from modules.modellers._sampling import sampled


@modeller(
    "Resample",
    output="samples",
    aliases=("regrid", "refine", "coarsen", "interpolate onto", "probe with"),
    independent={"samples": ("onto",)},
)
def resample(
    model: Model,
    progress: Progress,
    onto: Samples | None = None,
    *,
    samples: Annotated[tuple[int, ...] | None, Range(2, 1024)] = None,
    low: tuple[float, ...] | None = None,
    high: tuple[float, ...] | None = None,
) -> Samples:
    """The values of a model on another grid: evenly spaced in a box, or where other data has its samples.

    Parameters
    ----------
    model : of a regular or rectilinear grid
    onto : data whose grid is taken; it lies within the model, in the same frame
    samples : numbers along x, y[, z]; automatic takes as many as the model has
    low : smallest x, y[, z] of the box, in the unit of the coordinates; automatic takes the model's
    high : largest x, y[, z] of the box, in the unit of the coordinates; automatic takes the model's

    Raises
    ------
    ValueError : the grid reaches beyond the model, has other axes, or does not fit into memory

    Accuracy: errors of the samples go through the law's weights; the law's own error is added at each new sample with its
    sign, and where it could not be told from the noise it stays flagged.
    Source: Lopes 1999, 2.3.1; error of the law as that of interpolate.
    """
    grid = axial(model.samples, "resampling")
    if onto is None:
        return sampled(model, _box(grid, samples, low, high), progress)
    if samples is not None or low is not None or high is not None:
        raise ValueError("a grid is wired: pull the wire, or leave samples, low and high automatic")
    _check(grid, onto.grid)
    return sampled(model, onto.grid, progress)


def _box(
    grid: Axial, samples: tuple[int, ...] | None, low: tuple[float, ...] | None, high: tuple[float, ...] | None
) -> Regular:
    n = len(grid.shape)
    counts = tuple(reversed(grid.shape)) if samples is None else samples
    first = tuple(float(a[0]) for a in grid.axes) if low is None else low
    last = tuple(float(a[-1]) for a in grid.axes) if high is None else high
    if not len(counts) == len(first) == len(last) == n:
        raise ValueError(f"samples, low and high should have {n} numbers each, as the data has {n} axes")
    if min(counts) < 2:
        raise ValueError(f"samples {counts} should be 2 or more along each axis; slice gives a single plane")
    for name, a, b, axis in zip("xyz", first, last, grid.axes, strict=False):
        if not (math.isfinite(a) and math.isfinite(b) and a < b):
            raise ValueError(f"the box goes from {a:g} to {b:g} along {name}: high should be larger than low")
        slack = 1e-9 * float(axis[-1] - axis[0])
        if a < axis[0] - slack or b > axis[-1] + slack:
            raise ValueError(f"the box goes from {a:g} to {b:g} along {name}, the data from {axis[0]:g} to {axis[-1]:g}")
    spacing = [(b - a) / (k - 1) for a, b, k in zip(first, last, counts, strict=True)]
    return regular(tuple(reversed(counts)), spacing, first, grid.frame)


def _check(grid: Axial, target: Grid) -> None:
    if target.frame != grid.frame:
        raise ValueError("the two lie in different frames (names or units of axes): transform one of them first")
    inside = np.array(grid.bounds).reshape(3, 2)[: len(grid.shape)]
    wanted = np.array(target.bounds).reshape(3, 2)[: len(grid.shape)]
    slack = 1e-9 * (inside[:, 1] - inside[:, 0])
    for name, (a, b), (c, d), s in zip("xyz", inside, wanted, slack, strict=False):
        if c < a - s or d > b + s:
            raise ValueError(f"the grid goes from {c:g} to {d:g} along {name}, the model from {a:g} to {b:g}: crop it first")
    if isinstance(target, Regular | Rectilinear) and len(target.shape) != len(grid.shape):
        raise ValueError(f"the grid has {len(target.shape)} axes, the model {len(grid.shape)}: slice the model first")
