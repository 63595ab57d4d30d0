"""Filled bands {low <= F < high} of the bilinear interpolant on a rectilinear grid of the plane, as polygons.

Rules
-----
- A node or a saddle *exactly on a level counts as above* it, as in `modules.kernels.contour`: a band has its low border,
  not its high one.
- In an ambiguous cell the asymptotic decider joins what it joins in the contour lines (exact, without a division).
- The borders of a band are arcs of hyperbolas; each is halved at its shoulder points until the area between the chords
  and the arc is within the tolerance. The bands on both sides of a level share these points to the bit, so bands tile
  the domain without a gap and without overlap.
- Polygons are simple, run anticlockwise and lie in one cell each; cells, or runs of cells of a row, that lie in a band as
  a whole are rectangles.
- A cell with a corner that is not finite is a hole.
- Order: by row, cell and band.

Source: thesis section 3.3; 2.4.2 for the bands.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.banding import POLYGON, VERTEX, fill_rows

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Records = npt.NDArray[np.void]

CELLS_A_SLAB = 1 << 15
"""Cells filled between two calls of `check`: a few milliseconds."""


class Bands(NamedTuple):
    """Polygons of bands: n vertices of k polygons over p points.

    Attributes
    ----------
    points : (p, 2) float64
        x, y, each place once.
    on : (p,) int64
        The level whose contour a point lies on, -1 for none.
    offsets : (k + 1,) int64
        Polygon i is connectivity[offsets[i]:offsets[i + 1]].
    connectivity : (n,) int64
        Points of the polygons, anticlockwise, without repeating the first.
    band : (k,) int64
        Band i lies between levels i and i + 1.
    cell : (k,) int64
        The grid cell of each polygon, row-major over (blocks, ny - 1, nx - 1); the first of a run of cells.
    area : (k,) float64
        The exact area of what the polygon stands for, its borders as arcs.
    left : (k,) float64
        The area between its sides and those arcs, exact: the polygon's own area differs from `area` by no more.
    """

    points: Floats
    on: Integers
    offsets: Integers
    connectivity: Integers
    band: Integers
    cell: Integers
    area: Floats
    left: Floats


def fill(
    values: Floats,
    x: Floats,
    y: Floats,
    levels: npt.ArrayLike,
    tolerance: float,
    *,
    merged: bool = False,
    check: Callable[[float], None] | None = None,
) -> Bands:
    """The bands between consecutive levels.

    Parameters
    ----------
    values : (ny, nx) or (blocks, ny, nx)
        At the nodes; row by row in y. Not finite: a hole. Blocks are grids of their own that share no points.
    x, y : (nx,), (ny,), or (blocks, nx), (blocks, ny)
        Strictly ascending coordinates of the nodes.
    levels : (m,)
        Strictly ascending, m >= 2; the ends may be infinite.
    tolerance
        Largest area left between an arc and its chords, in the product of the units of x and y.
    merged
        Whether runs of cells of a row that lie in one band as a whole become one rectangle.
    check
        Called with the fraction done between slabs of a few milliseconds; what it raises ends the work.

    Returns
    -------
    Bands
        The same, to the bit, on every call.

    Raises
    ------
    ValueError
        If the shapes do not fit, the grid has no cell, coordinates or levels do not ascend, or the tolerance is not
        positive.

    Accuracy: topology and areas of the bilinear interpolant; areas to rounding (1e-14 of a cell's area a polygon).
    Source: thesis section 3.3 and (3.28), (3.29), the latter in closed form without divisions by c.
    """
    values, x, y, marks = _at_the_door(values, x, y, levels, tolerance)
    if not (np.diff(marks) > 0).all():
        raise ValueError("a band lies between two levels that ascend strictly")
    return _filled(values, values, x, y, marks, tolerance, merged, check)


def between(
    lower: Floats,
    upper: Floats,
    x: Floats,
    y: Floats,
    tolerance: float,
    *,
    merged: bool = False,
    check: Callable[[float], None] | None = None,
) -> Bands:
    """The region where one field is not below zero and another, nowhere larger, is below it: lower >= 0 > upper.

    Parameters
    ----------
    lower, upper : (ny, nx) or (blocks, ny, nx)
        At the nodes, upper <= lower. With F + e - L and F - e - L it is where F is within e of L.
    x, y, tolerance, merged, check
        As for `fill`.

    Returns
    -------
    Bands
        Of one band; `on` is 0 where a point lies on the border lower = 0, 1 on upper = 0.

    Raises
    ------
    ValueError
        As `fill`; or if the upper field is larger somewhere.

    Accuracy: topology and areas of the two bilinear interpolants.
    Source: thesis section 3.3; 3.5.2 for the region.
    """
    high = np.ascontiguousarray(upper, np.float64)
    low, x, y, marks = _at_the_door(lower, x, y, [0.0, 0.0], tolerance)
    if high.size != low.size or (high.reshape(low.shape) > low).any():
        raise ValueError("the upper field must be as large as the lower one, and nowhere above it")
    high = high.reshape(low.shape)
    high.flags.writeable = False
    return _filled(low, high, x, y, marks, tolerance, merged, check)


def _filled(
    values: Floats,
    upper: Floats,
    x: Floats,
    y: Floats,
    marks: Floats,
    tolerance: float,
    merged: bool,
    check: Callable[[float], None] | None,
) -> Bands:
    lines = values.shape[0] * (values.shape[1] - 1)
    slab = max(1, CELLS_A_SLAB // (values.shape[2] - 1))
    state, polygons, vertices = np.zeros(2, np.int64), np.empty(0, POLYGON), np.empty(0, VERTEX)
    for half in (0.0, 0.5):
        for first in range(0, lines, slab):
            if check:
                check(half + 0.5 * first / lines)
            stop = min(first + slab, lines)
            fill_rows(values, upper, x, y, marks, float(tolerance), merged, first, stop, state, polygons, vertices)
        if half == 0.0:
            polygons, vertices = np.empty(state[0], POLYGON), np.empty(state[1], VERTEX)
            state[:] = 0
    return _gathered(polygons, vertices)


def _at_the_door(
    values: Floats, x: Floats, y: Floats, levels: npt.ArrayLike, tolerance: float
) -> tuple[Floats, Floats, Floats, Floats]:
    values, x, y = (np.ascontiguousarray(array, np.float64) for array in (values, x, y))
    if values.ndim == 2:
        values, x, y = values[None], x[None], y[None]
    if values.ndim != 3 or x.shape != values.shape[::2] or y.shape != values.shape[:2]:
        raise ValueError(f"values of shape {values.shape} do not fit {y.shape[-1:]} rows and {x.shape[-1:]} columns")
    if min(values.shape[1:]) < 2:
        raise ValueError(f"a grid of {values.shape[1]} x {values.shape[2]} nodes has no cell")
    for name, axis in (("x", x), ("y", y)):
        if not (np.isfinite(axis).all() and (np.diff(axis, axis=1) > 0).all()):
            raise ValueError(f"the {name} coordinates must ascend strictly")
    marks = np.ascontiguousarray(levels, np.float64)
    if marks.ndim != 1 or marks.size < 2:
        raise ValueError("a band lies between two levels that ascend strictly")
    if not tolerance > 0:
        raise ValueError("the tolerance of an area must be positive")
    read_only = values.view(), x.view(), y.view(), marks.view()
    for array in read_only:
        array.flags.writeable = False  # one signature for arrays that may and may not be written
    return read_only


def _gathered(polygons: Records, vertices: Records) -> Bands:
    """Vertices of one key become one point."""
    _, first, connectivity = np.unique(vertices["key"], return_index=True, return_inverse=True)
    on = np.full(first.size, -1, np.int64)
    np.maximum.at(on, connectivity, vertices["on"])
    return Bands(
        np.column_stack([vertices["x"][first], vertices["y"][first]]),
        on,
        np.concatenate([[0], polygons["end"]]).astype(np.int64),
        connectivity.astype(np.int64).reshape(-1),
        *(np.ascontiguousarray(polygons[name]) for name in ("band", "cell", "area", "left")),
    )


def warm() -> None:
    """Compile the kernels of this file."""
    values = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, 0.5]])
    fill(values, np.arange(3.0), np.arange(3.0), [0.2, 0.4, 0.9], 1e-3)
