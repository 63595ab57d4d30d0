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
- Order: first the lines with ends, then the closed ones, each in the order in which their first crossing is met row by row.

Source: thesis chapter 3; the sweep keeps the crossings of one row of cells, and a crossing is known by its grid edge.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit
from modules.kernels.arcs import STRAIGHT, TURN, shoulder_share
from modules.kernels.bilinear import determinant

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]
Records = npt.NDArray[np.void]

CELLS_A_SLAB = 1 << 18
"""Cells swept, and crossings walked, between two calls of `check`: a few milliseconds."""

HOLE = 16
"""Side of a node that is not finite; 0 is below the level, 1 above. Cell codes from 16 on touch a hole."""

CROSSING = np.dtype(
    [("x", "f8"), ("y", "f8"), ("bend", "f8"), ("cell", "i8"), ("next", "i4"), ("entered", "i4")], align=True
)
"""A crossed grid edge, and the arc that starts there: its bend, its cell and the crossing where it ends (-1: none)."""

SADDLE = np.dtype([("cell", "i8"), ("margin", "f8")])


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
    return _walk_all(crossings, saddles, curved, shoulder, check or _no_check)


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
    crossings, saddles = np.empty(8 * nx, CROSSING), np.empty(2 * nx, SADDLE)
    side, top = np.empty((2, nx), np.uint8), np.full(nx - 1, -1, np.int64)
    code = np.zeros((nx + 6) // 8 * 8, np.uint8)
    tally = np.zeros(4, np.int64)
    rows, row = max(1, CELLS_A_SLAB // nx), 0
    while row < ny - 1:
        check(0.8 * row / (ny - 1))
        row = sweep(
            values, x, y, level, row, min(row + rows, ny - 1), side, top, code, code.view(np.int64), crossings, saddles, tally
        )
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


def _walk_all(
    crossings: Records, saddles: Records, curved: int, shoulder: bool, check: Callable[[float], None]
) -> ContourLines:
    """The linked crossings as lines, in arrays of exact size."""
    arcs = int(np.count_nonzero(crossings["next"] >= 0))
    segments = arcs + (curved if shoulder else 0)
    most = crossings.size - arcs + arcs // 4  # ends that no arc enters; a closed line has at least four arcs
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


def _ends_of_arcs() -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """For each cell code the edge where its (first) arc starts and the one where it ends.

    A code has bit 1 for corner 00, 2 for 10, 4 for 01, 8 for 11 above the level. Edges are numbered around the cell, anticlockwise: 0
    bottom, 1 right, 2 top, 3 left. With the high side on the left an arc starts where a walk around the cell goes
    from above to below.
    """
    start, end = np.zeros(16, np.int64), np.zeros(16, np.int64)
    for code in range(1, 15):
        around = [code & 1, code >> 1 & 1, code >> 3 & 1, code >> 2 & 1]
        falls = [around[k] - around[(k + 1) % 4] for k in range(4)]
        start[code], end[code] = falls.index(1), falls.index(-1)
    return start, end


START, END = _ends_of_arcs()


@jit
def sweep(
    values: Floats,
    x: Floats,
    y: Floats,
    level: float,
    row: int,
    stop: int,
    side: Bytes,
    top: Integers,
    code: Bytes,
    words: Integers,
    crossings: Records,
    saddles: Records,
    tally: Integers,
) -> int:
    """Find and link the crossings of the rows of cells from `row` on; returns the row that comes next.

    Stops before `stop` if `crossings` or `saddles` might not hold another row. Carried from call to call: `side` of the
    last two rows of nodes, `top` the crossings on the upper edges of the last row of cells, `tally` the numbers of
    crossings, ambiguous cells and curved arcs and the first crossing of the last row. `words` is `code`, eight at a time.
    """
    nx = x.size
    used, risky, curved, below = tally[0], tally[1], tally[2], tally[3]
    if row == 0:
        classify(values[0], level, side[0])
    while row < stop and used + 3 * nx <= crossings.size and risky + nx <= saddles.size:
        classify(values[row + 1], level, side[(row + 1) & 1])
        encode(side[row & 1], side[(row + 1) & 1], code)
        first, last, before = used, -2, -1  # `before`: the crossing on the right edge of cell `last`
        for word in range(words.size):
            if words[word] == 0 or words[word] == 0x0F0F0F0F0F0F0F0F:
                continue
            for i in range(8 * word, 8 * word + 8):
                now = code[i]
                if now == 0 or now >= 15:
                    continue
                f00, f10, f01, f11 = values[row, i], values[row, i + 1], values[row + 1, i], values[row + 1, i + 1]
                bottom = right = upper = left = -1
                if (now ^ now >> 1) & 1:
                    bottom = top[i]
                    if bottom < below:  # left by an older row, or by none: there is a hole or the border below
                        bottom = used
                        used = place(crossings, used, between(f00, f10, level, x[i], x[i + 1]), y[row])
                if (now ^ now >> 2) & 1:
                    if last == i - 1:
                        left = before
                    else:  # there is a hole or the border on the left
                        left = used
                        used = place(crossings, used, x[i], between(f00, f01, level, y[row], y[row + 1]))
                if (now >> 1 ^ now >> 3) & 1:
                    right = used
                    used = place(crossings, used, x[i + 1], between(f10, f11, level, y[row], y[row + 1]))
                if (now >> 2 ^ now >> 3) & 1:
                    upper = used
                    top[i] = used
                    used = place(crossings, used, between(f01, f11, level, x[i], x[i + 1]), y[row + 1])
                last, before = i, right
                start, end, cell = START[now], END[now], row * (nx - 1) + i
                edges = (bottom, right, upper, left)
                if now == 6 or now == 9:
                    det = determinant(f00, f10, f01, f11, level)
                    joined = det >= 0 if now == 9 else det <= 0
                    end = (start + 1) & 3 if joined else (start + 3) & 3
                    saddles[risky].cell = cell
                    saddles[risky].margin = abs(det / (abs(f00 - level) + abs(f10 - level) + abs(f01 - level) + abs(f11 - level)))
                    risky += 1
                    w = bend_of_arc(f00, f10, f01, f11, level, start ^ 2, end ^ 2)
                    curved += link(crossings, edges[start ^ 2], edges[end ^ 2], w, cell)
                w = bend_of_arc(f00, f10, f01, f11, level, start, end)
                curved += link(crossings, edges[start], edges[end], w, cell)
        below = first
        row += 1
    tally[0], tally[1], tally[2], tally[3] = used, risky, curved, below
    return row


@jit
def classify(values: Floats, level: float, side: Bytes) -> None:
    """The side of each node of a row: 1 on or above the level, 0 below, `HOLE` if not finite."""
    for i in range(values.size):
        side[i] = (values[i] >= level) | (0 if abs(values[i]) < np.inf else HOLE)


@jit
def encode(lower: Bytes, upper: Bytes, code: Bytes) -> None:
    """The code of each cell between two rows of nodes."""
    for i in range(lower.size - 1):
        code[i] = lower[i] | lower[i + 1] << 1 | upper[i] << 2 | upper[i + 1] << 3


@jit
def between(f0: float, f1: float, level: float, p0: float, p1: float) -> float:
    """Where F = level between p0 and p1, measured from the nearer end: exact where a node is on the level."""
    t = (level - f0) / (f1 - f0)
    if t < 0.5:
        return p0 + t * (p1 - p0)
    return p1 - (f1 - level) / (f1 - f0) * (p1 - p0)


@jit
def place(crossings: Records, at: int, x: float, y: float) -> int:
    """Enter a crossing that no arc has reached; returns the number of crossings."""
    crossings[at].x = x
    crossings[at].y = y
    crossings[at].next = -1
    crossings[at].entered = 0
    return at + 1


@jit
def link(crossings: Records, start: int, end: int, bend: float, cell: int) -> int:
    """Enter an arc; returns whether it is curved."""
    p, q = crossings[start], crossings[end]
    if p.x == q.x or p.y == q.y:
        bend = 0.0
    p.bend = bend
    p.cell = cell
    p.next = end
    q.entered = 1
    return 1 if bend != 0.0 else 0


@jit
def bend_of_arc(f00: float, f10: float, f01: float, f11: float, level: float, start: int, end: int) -> float:
    """ln(F_y(Q) / F_y(P)) of the arc from edge `start` to edge `end`, from differences along edges and F_x F_y = ab - cd.

    Between opposite edges the derivative along each is known; around a corner of value g the derivatives along its two
    edges are p and q, and F_x F_y = p q - c g. Where the saddle is on the level it is +-TURN.
    """
    if (start + end) & 1 == 0:
        if start & 1 == 0:
            p, q = (f11 - f01, f10 - f00) if start == 0 else (f10 - f00, f11 - f01)
        else:
            p, q = (f01 - f00, f11 - f10) if start == 3 else (f11 - f10, f01 - f00)
        bend = log_ratio(q, p, (q - p) / p)
    else:
        if start + end == 1:
            g, p, q, c = f10, f00 - f10, f11 - f10, (f01 - f00) - (f11 - f10)
        elif start * end == 2:
            g, p, q, c = f11, f01 - f11, f10 - f11, (f00 - f01) - (f10 - f11)
        elif start * end == 6:
            g, p, q, c = f01, f11 - f01, f00 - f01, (f10 - f11) - (f00 - f01)
        else:
            g, p, q, c = f00, f10 - f00, f01 - f00, (f11 - f10) - (f01 - f00)
        s = c * (g - level) / (p * q)
        if abs(s) < 0.5:
            bend = -math.log1p(-s)
        else:
            bend = -log_ratio(abs(determinant(f00, f10, f01, f11, level) / p), abs(q), 1.0)
        if start & 1:
            bend = -bend
    return bend if abs(bend) >= STRAIGHT else 0.0


@jit
def log_ratio(q: float, p: float, excess: float) -> float:
    """ln(q / p), by `excess` = q / p - 1 if that is small, and not beyond +-TURN."""
    if abs(excess) < 0.5:
        return math.log1p(excess)
    ratio = q / p
    if ratio <= 0.0:
        return -TURN
    return min(max(math.log(ratio), -TURN), TURN)


@jit
def walk(
    crossings: Records,
    shoulder: bool,
    budget: int,
    state: Integers,
    points: Floats,
    offsets: Integers,
    bend: Floats,
    cell: Integers,
) -> None:
    """Write out lines along the links, which are used up, for about `budget` steps.

    Carried from call to call in `state`: points and lines written, the crossing looked at next for a start, whether
    the closed lines are on, the crossing where the present line stands (-1: between lines), whether all is done.
    """
    n, k, scan, closed, here = state[0], state[1], state[2], state[3], state[4]
    while budget > 0:
        budget -= 1
        if here < 0:
            if scan == crossings.size:
                if closed:
                    state[5] = 1
                    break
                closed, scan = 1, 0
                continue
            if crossings[scan].next >= 0 and (closed or not crossings[scan].entered):
                here = scan
                points[n, 0], points[n, 1] = crossings[here].x, crossings[here].y
                n += 1
            scan += 1
            continue
        p = crossings[here]
        there = p.next
        if there < 0:
            if n - offsets[k] == 1:
                n -= 1
            else:
                k += 1
                offsets[k] = n
            here = -1
            continue
        p.next = -1
        q = crossings[there]
        dx, dy, w = q.x - p.x, q.y - p.y, p.bend
        if dx != 0.0 or dy != 0.0:
            if shoulder and w != 0.0:
                small = shoulder_share(w)
                rx = p.x + small * dx if w > 0 else q.x - small * dx
                ry = q.y - small * dy if w > 0 else p.y + small * dy
                if (rx != p.x or ry != p.y) and (rx != q.x or ry != q.y):
                    w = 0.5 * w
                    points[n, 0], points[n, 1] = rx, ry
                    bend[n - 1 - k] = w if rx != p.x and ry != p.y else 0.0
                    cell[n - 1 - k] = p.cell
                    n += 1
                    w = w if rx != q.x and ry != q.y else 0.0
            points[n, 0], points[n, 1] = q.x, q.y
            bend[n - 1 - k] = w
            cell[n - 1 - k] = p.cell
            n += 1
        here = there
    state[0], state[1], state[2], state[3], state[4] = n, k, scan, closed, here


def warm() -> None:
    """Compile the kernels of this file."""
    values = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, 0.5]])
    lines(values, np.arange(3.0), np.arange(3.0), 0.4)
