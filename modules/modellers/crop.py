"""A box out of the data."""

from __future__ import annotations

import math

import numpy as np

from modules.api import Rectilinear, Regular, Samples, modeller
from modules.data.grid import Axial
from modules.modellers._lattice import taken
from modules.modellers._linear import axial, lattice_of


@modeller("Crop", output="samples", aliases=("clip", "box", "subset", "region of interest", "extract"))
def crop(
    samples: Samples,
    *,
    low: tuple[float, ...] | None = None,
    high: tuple[float, ...] | None = None,
) -> Samples:
    """The samples within a box, its faces included.

    Parameters
    ----------
    samples : of a regular or rectilinear grid
    low : smallest x, y[, z] of the box, in the unit of the coordinates; automatic takes the data's
    high : largest x, y[, z] of the box, in the unit of the coordinates; automatic takes the data's

    Raises
    ------
    ValueError : a bent or unstructured grid, a box that holds no sample along an axis

    Accuracy: the samples keep their errors, and what they have in common; nothing is added.
    Source: a choice of rows.
    """
    grid = axial(samples, "cropping")
    n = len(grid.axes)
    first = (-math.inf,) * n if low is None else low
    last = (math.inf,) * n if high is None else high
    if len(first) != n or len(last) != n:
        raise ValueError(f"low and high should have {n} numbers each, as the data has {n} axes")
    columns = []
    for name, x, a, b in zip(grid.frame.axes, grid.axes, first, last, strict=False):
        slack = 1e-9 * float(x[-1] - x[0])
        inside = np.flatnonzero((x >= a - slack) & (x <= b + slack))
        if not len(inside):
            raise ValueError(f"no sample lies between {a:g} and {b:g} along {name}, which goes from {x[0]:g} to {x[-1]:g}")
        columns.append(inside[:, None])
    weights = [np.ones(c.shape) for c in columns]
    return taken(samples, _box(grid, [c[:, 0] for c in columns]), list(zip(columns, weights, strict=True)), lattice_of(samples))


def _box(grid: Axial, kept: list[np.ndarray[tuple[int, ...], np.dtype[np.intp]]]) -> Axial:
    if isinstance(grid, Regular):
        origin = tuple(float(x[k[0]]) for x, k in zip(grid.axes, kept, strict=True))
        return Regular(tuple(len(k) for k in reversed(kept)), grid.spacing, origin, frame=grid.frame)
    return Rectilinear(tuple(x[k] for x, k in zip(grid.axes, kept, strict=True)), frame=grid.frame)
