"""Where the items of a wire value are: what a flag or a term speaks of, as positions."""

from __future__ import annotations

from typing import Any

import numpy as np

from modules.data.accuracy import Place
from modules.data.geometry import Geometry
from modules.data.grid import Grid, Rectilinear, Regular
from modules.data.operators import Floats, Ints


def where(value: Any, place: Place, items: Ints) -> Floats | None:
    """(n, 3) positions of points, of the middles of cells or of segments; None if the value does not say.

    Parameters
    ----------
    value : Geometry, Samples or Model
    place : point, cell or segment
    items : (n,) indices
    """
    items = np.asarray(items, np.int64)
    if isinstance(value, Geometry):
        return _in_shape(value, place, items)
    grid = getattr(getattr(value, "samples", value), "grid", None)
    return _in_grid(grid, place, items) if isinstance(grid, Grid) else None


def _in_shape(shape: Geometry, place: Place, items: Ints) -> Floats | None:
    if place == "point":
        return np.asarray(shape.points[items])
    if place == "segment":
        return np.asarray(shape.points[shape.segments()[items]].mean(axis=1))
    if place != "cell":
        return None
    parts = (shape.vertices, shape.lines, shape.polygons)
    starts = np.concatenate([[0], np.cumsum([len(p) for p in parts])])
    at = np.empty((len(items), 3))
    for row, cell in enumerate(items):
        kind = int(np.searchsorted(starts, cell, "right")) - 1
        part, inner = parts[kind], int(cell - starts[kind])
        at[row] = shape.points[part.connectivity[part.offsets[inner] : part.offsets[inner + 1]]].mean(axis=0)
    return at


def _in_grid(grid: Grid, place: Place, items: Ints) -> Floats | None:
    if not isinstance(grid, Rectilinear | Regular):
        return np.asarray(grid.points()[items]) if place == "point" else None
    if place not in ("point", "cell"):
        return None
    middle = place == "cell"
    index = np.unravel_index(items, tuple(n - middle for n in grid.shape))
    at = np.zeros((len(items), 3))
    for i, (axis, along) in enumerate(zip(grid.axes, reversed(index), strict=True)):
        at[:, i] = (axis[along] + axis[along + 1]) / 2 if middle else axis[along]
    return at
