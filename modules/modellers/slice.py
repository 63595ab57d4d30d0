"""A plane of a volume, or a line of a map."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from modules.api import Literal, Progress, Rectilinear, Regular, Samples, Stencil, modeller
from modules.data.grid import Axial, Frame
from modules.modellers._linear import AXES, axial, carried, dimension, lattice_of
from modules.modellers._sampling import sampled
from modules.modellers.interpolate import interpolate

NEAR = 3
"""Samples on either side of the plane that the law and its error may ask for."""


@modeller("Slice", output="samples", aliases=("orthoslice", "plane", "section", "cut", "cross section", "profile"))
def slice(
    samples: Samples,
    progress: Progress,
    *,
    axis: Literal["x", "y", "z"] = "z",
    position: float | None = None,
    law: Literal["linear", "nearest", "cubic"] = "linear",
) -> Samples:
    """The samples where one coordinate has a value: a map of a volume, a line of a map.

    The axes that remain become x and y in their old order and keep their names; the components of a vector go with them,
    the one across the plane last.

    Parameters
    ----------
    samples : of a regular or rectilinear grid of two or three axes
    axis : the coordinate that is held
    position : its value, in the unit of the coordinates; automatic takes the middle sample
    law : between two samples: linear, nearest or cubic

    Raises
    ------
    ValueError : a bent or unstructured grid, an axis that the data does not have, a position outside

    Accuracy: at a sample of the axis nothing is added. Between two the errors of the samples go through the law's weights,
    and the law's own error is added with its sign.
    Source: Lopes 1999, 2.3.1; error of the law as that of interpolate.
    """
    grid = axial(samples, "a slice")
    held = AXES[axis]
    if len(grid.axes) < 2 or held >= len(grid.axes):
        raise ValueError(f"data with {len(grid.axes)} axes has no slice across {axis}")
    x = grid.axes[held]
    where = float(x[len(x) // 2]) if position is None else position
    slack = 1e-9 * float(x[-1] - x[0])
    if not (math.isfinite(where) and x[0] - slack <= where <= x[-1] + slack):
        raise ValueError(f"position = {where:g} lies outside the data: {axis} goes from {x[0]:g} to {x[-1]:g}")
    nearest = int(np.abs(x - where).argmin())
    if abs(x[nearest] - where) <= slack:
        plane = _part(samples, grid, held, nearest, nearest + 1)
    else:
        cell = int(np.searchsorted(x, where))
        thin = _part(samples, grid, held, max(0, cell - 1 - NEAR), min(len(x), cell + 1 + NEAR))
        axes = tuple(np.array([where]) if a == held else one for a, one in enumerate(grid.axes))
        plane = sampled(interpolate(thin, law=law), Rectilinear(axes, frame=grid.frame), progress)
    return _flattened(plane, grid, held)


def _part(samples: Samples, grid: Axial, axis: int, first: int, end: int) -> Samples:
    """The samples first..end - 1 of an axis."""
    columns = np.arange(first, end)[:, None]
    operator = Stencil(lattice_of(samples), dimension(grid, axis), columns, np.ones(columns.shape))
    axes = tuple(one[first:end] if a == axis else one for a, one in enumerate(grid.axes))
    return carried(samples, operator, Rectilinear(axes, frame=grid.frame))


def _flattened(plane: Samples, grid: Axial, held: int) -> Samples:
    """Without the axis of one sample; components in the order of the axes that remain, the one across last."""
    order = [a for a in range(3) if a != held] + [held]
    turned = order == [0, 2, 1]
    i, j, k = order
    names, units = grid.frame.axes, grid.frame.units
    frame = replace(
        grid.frame,
        axes=(names[i], names[j], names[k]),
        units=(units[i], units[j], units[k]),
        handed={"right": "left", "left": "right"}.get(grid.frame.handed, grid.frame.handed) if turned else grid.frame.handed,
    )
    rest = [a for a in range(len(grid.axes)) if a != held]
    if plane.components > 1:
        places = np.array(order) if plane.components == 3 else (3 * np.array(order)[:, None] + np.array(order)).ravel()
        lattice = lattice_of(plane)
        plane = carried(plane, Stencil(lattice, len(lattice) - 1, places[:, None], np.ones((len(places), 1))))
    values = plane.values.reshape(*[len(grid.axes[a]) for a in reversed(rest)], *plane.values.shape[len(grid.shape) :])
    return replace(plane, grid=_grid(grid, rest, frame), values=values, accuracy=replace(plane.accuracy, of=None))


def _grid(grid: Axial, rest: list[int], frame: Frame) -> Axial:
    if isinstance(grid, Regular):
        spacing, origin = (tuple(v[a] for a in rest) for v in (grid.spacing, grid.origin))
        return Regular(tuple(len(grid.axes[a]) for a in reversed(rest)), spacing, origin, frame=frame)
    return Rectilinear(tuple(grid.axes[a] for a in rest), frame=frame)
