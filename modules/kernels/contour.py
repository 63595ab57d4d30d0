"""Contour lines of the bilinear interpolant on a rectilinear grid of the plane.

The contour of a level within a cell is one or two arcs of a hyperbola. `lines` draws each as its chord, or through its
shoulder point, and tells the exact arc that each segment stands for (`modules.kernels.arcs`).

Rules
-----
- A node or a saddle *exactly on the level counts as above* it: the lines are the limit of those just below the level.
- In an ambiguous cell the asymptotic decider joins the corners of the saddle's side (exact, without a division). With
  the saddle on the level the arcs are bent at a right angle at the saddle, which is then the shoulder point.
- The high side lies to the *left* of a line (x to the right, y up). A line closes, or runs from border to border; the
  border of a hole (cells with a corner that is not finite) is a border.
- Points that coincide exactly with the one before are dropped, with their segment; a line that shrinks to one point is
  dropped; a closed line stays closed.
- Order: first the lines with ends, by their starts, then the closed ones, by the first of their crossings, as met row by
  row.

Source: thesis chapter 3.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.crossings import CROSSING, SADDLE, sweep, walk

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Records = npt.NDArray[np.void]

CELLS_A_SLAB = 1 << 18
"""Cells swept, and crossings walked, between two calls of `check`: a few milliseconds."""


class ContourLines(NamedTuple):
    """Contour lines of one level: n points in k lines, n - k segments.

    Attributes
    ----------
    points : (n, 2) float64
        x, y. A closed line repeats its first point at its end.
    offsets : (k + 1,) int64
        Line i is points[offsets[i]:offsets[i + 1]].
    bend : (n - k,) float64
        Of the exact arc from each point to the next of its line, ln(F_y(Q) / F_y(P)); 0 where it is straight.
    cell : (n - k,) int64
        The grid cell of each segment, row-major over (ny - 1, nx - 1).
    saddle_cell : (m,) int64
        The ambiguous cells (corners above and below alternate), each once, ascending.
    saddle_margin : (m,) float64
        |F(S) - level| there: a change of the field by less cannot change which corners are joined.
    """

    points: Floats
    offsets: Integers
    bend: Floats
    cell: Integers
    saddle_cell: Integers
    saddle_margin: Floats


def lines(
    values: Floats,
    x: Floats,
    y: Floats,
    level: float,
    shoulder: bool = True,
    *,
    check: Callable[[float], None] | None = None,
) -> ContourLines:
    """The contour lines F = level.

    Parameters
    ----------
    values : (ny, nx)
        At the nodes; row by row in y. Not finite: a hole.
    x, y : (nx,), (ny,)
        Strictly ascending coordinates of the nodes.
    level
        In units of the values.
    shoulder
        Whether each curved arc gets its shoulder point, or only its chord is drawn.
    check
        Called with the fraction done between slabs of a few milliseconds; what it raises ends the work.

    Returns
    -------
    ContourLines
        The same, to the bit, on every call and in every thread.

    Raises
    ------
    ValueError
        If the shapes do not fit, the grid has no cell, a coordinate is not ascending, or the level is not finite.

    Accuracy: topology of the bilinear interpolant, exact for the given floats; crossings and shoulder points lie on the
    exact contour to rounding; the area left between the lines and the contour is `arcs.area` of each segment.
    Source: thesis section 3.3, without divisions by c.
    """
    values, x, y = _at_the_door(values, x, y, level)
    crossings, saddles, curved = _sweep_all(values, x, y, float(level), check or _no_check)
    return walked(crossings, saddles, curved, shoulder, check or _no_check)


def _no_check(fraction: float) -> None:
    pass


def _at_the_door(values: Floats, x: Floats, y: Floats, level: float) -> tuple[Floats, Floats, Floats]:
    values, x, y = (np.ascontiguousarray(array, np.float64).view() for array in (values, x, y))
    if x.ndim != 1 or y.ndim != 1 or values.shape != (y.size, x.size):
        raise ValueError(f"values of shape {values.shape} do not fit {y.shape} rows and {x.shape} columns")
    if x.size < 2 or y.size < 2:
        raise ValueError(f"a grid of {y.size} x {x.size} nodes has no cell")
    for name, axis in (("x", x), ("y", y)):
        if not (np.isfinite(axis).all() and (np.diff(axis) > 0).all()):
            raise ValueError(f"the {name} coordinates must ascend strictly")
    if not math.isfinite(level):
        raise ValueError(f"the level must be a finite number, not {level}")
    for array in (values, x, y):
        array.flags.writeable = False  # one signature for arrays that may and may not be written
    return values, x, y


def _sweep_all(
    values: Floats, x: Floats, y: Floats, level: float, check: Callable[[float], None]
) -> tuple[Records, Records, int]:
    """All crossings, linked; all ambiguous cells; the number of curved arcs."""
    ny, nx = values.shape
    # memory that no crossing needs is never touched; if it is not enough it grows
    crossings, saddles = np.empty(8 * nx + values.size // 16, CROSSING), np.empty(2 * nx, SADDLE)
    side, code = np.empty((2, nx), np.uint8), np.zeros((nx + 6) // 8 * 8, np.uint8)
    top, tally = np.full(nx - 1, -1, np.int64), np.zeros(4, np.int64)
    rows, row = max(1, CELLS_A_SLAB // nx), 0
    while row < ny - 1:
        check(0.8 * row / (ny - 1))
        stop = min(row + rows, ny - 1)
        row = sweep(values, x, y, level, row, stop, side, code, top, crossings, saddles, tally)
        crossings = _with_room(crossings, int(tally[0]), 3 * nx)
        saddles = _with_room(saddles, int(tally[1]), nx)
    return crossings[: tally[0]], saddles[: tally[1]], int(tally[2])


def _with_room(records: Records, used: int, needed: int) -> Records:
    """The records, moved to twice the room if there is not enough for the next row."""
    if used + needed <= records.size:
        return records
    if used + needed > np.iinfo(np.int32).max:
        raise MemoryError(f"a contour of more than {used} crossings is not supported")
    more = np.empty(2 * records.size + needed, records.dtype)
    more[:used] = records[:used]
    return more


def walked(
    crossings: Records, saddles: Records, curved: int, shoulder: bool, check: Callable[[float], None]
) -> ContourLines:
    """The linked crossings as lines, in arrays of exact size."""
    arcs = int(np.count_nonzero(crossings["next"] >= 0))
    segments = arcs + (curved if shoulder else 0)
    most = crossings.size - arcs + arcs // 3  # ends that no arc enters; a closed line has at least three arcs
    points, offsets = np.empty((segments + most, 2)), np.zeros(most + 1, np.int64)
    bend, cell = np.empty(segments), np.empty(segments, np.int64)
    state = np.array([0, 0, 0, 0, -1, 0], np.int64)
    while not state[5]:
        check(0.8 + 0.2 * state[0] / max(1, points.shape[0]))
        walk(crossings, shoulder, CELLS_A_SLAB, state, points, offsets, bend, cell)
    n, k = int(state[0]), int(state[1])
    points.resize((n, 2), refcheck=False)
    offsets.resize(k + 1, refcheck=False)
    bend.resize(n - k, refcheck=False)
    cell.resize(n - k, refcheck=False)
    return ContourLines(points, offsets, bend, cell, saddles["cell"].copy(), saddles["margin"].copy())


def warm() -> None:
    """Compile the kernels of this file."""
    values = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, 0.5]])
    lines(values, np.arange(3.0), np.arange(3.0), 0.4)
