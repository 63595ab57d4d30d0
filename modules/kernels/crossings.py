"""The crossings of a level with the edges of a grid, and how they are linked into contour lines.

A sweep over the cells enters each crossed grid edge once and links the two ends of each arc; a walk along the links
writes the lines. A crossing is known by its grid edge: only those on the upper edges of the last row of cells and on the
last cell's right edge are looked up again. `modules.kernels.contour` gives the arrays and cuts the work into slabs.
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import inlined, jit
from modules.kernels.arcs import STRAIGHT, TURN, shoulder_share
from modules.kernels.bilinear import determinant, twist

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]
Records = npt.NDArray[np.void]
Edges = tuple[int, int, int, int]

HOLE = 16
"""Side of a node that is not finite; 0 is below the level, 1 above. Cell codes from 16 on touch a hole."""

ALL_ABOVE = 0x0F0F0F0F0F0F0F0F
"""Eight cells without a crossing; the other such word is 0."""

CROSSING = np.dtype([("x", "f8"), ("y", "f8"), ("bend", "f8"), ("cell", "i8"), ("next", "i4"), ("entered", "i4")], align=True)
"""A crossed grid edge, and the arc that starts there: its bend, its cell and the crossing where it ends (-1: none)."""

SADDLE = np.dtype([("cell", "i8"), ("margin", "f8")])
"""An ambiguous cell, and |F(S) - level|."""


def _ends_of_arcs() -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """For each cell code the edge where its (first) arc starts and the one where it ends.

    A code has bit 1 for corner 00, 2 for 10, 4 for 01, 8 for 11 above the level. Edges are numbered anticlockwise: 0
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
    code: Bytes,
    top: Integers,
    crossings: Records,
    saddles: Records,
    tally: Integers,
) -> int:
    """Find and link the crossings of the rows of cells from `row` on; returns the row that comes next.

    Stops before `stop` if `crossings` or `saddles` might not hold another row. Carried from call to call: `side` of
    the last two rows of nodes, `top` the crossings on the upper edges of the last row of cells, `tally` the numbers of
    crossings, ambiguous cells and curved arcs so far. `code` is room for one row of cells, a multiple of eight, zero.
    """
    nx = x.size
    if row == 0:
        classify(values[0], level, side[0])
    while row < stop and tally[0] + 3 * nx <= crossings.size and tally[1] + nx <= saddles.size:
        lower, upper = side[row & 1], side[(row + 1) & 1]
        classify(values[row + 1], level, upper)
        for i in range(nx - 1):
            code[i] = lower[i] | lower[i + 1] << 1 | upper[i] << 2 | upper[i + 1] << 3
        sweep_row(values, x, y, level, row, code, top, crossings, saddles, tally)
        row += 1
    return row


@jit
def sweep_row(
    values: Floats,
    x: Floats,
    y: Floats,
    level: float,
    row: int,
    code: Bytes,
    top: Integers,
    crossings: Records,
    saddles: Records,
    tally: Integers,
) -> None:
    """Find and link the crossings of one row of cells."""
    words = code.view(np.int64)
    below, tally[3] = tally[3], tally[0]
    last, right = -2, -1  # the last cell that was crossed, and the crossing on its right edge
    for word in range(words.size):
        if words[word] == 0 or words[word] == ALL_ABOVE:
            continue
        for i in range(8 * word, 8 * word + 8):
            if code[i] == 0 or code[i] >= 15:
                continue
            left = right if last == i - 1 else -1
            edges = enter_edges(values, x, y, level, row, i, code[i], left, below, top, crossings, tally)
            link_edges(values, level, row, i, code[i], edges, crossings, saddles, tally)
            last, right = i, edges[1]


@inlined
def enter_edges(
    values: Floats,
    x: Floats,
    y: Floats,
    level: float,
    row: int,
    i: int,
    code: int,
    left: int,
    below: int,
    top: Integers,
    crossings: Records,
    tally: Integers,
) -> Edges:
    """The crossings on the bottom, right, top and left edge of a cell (-1: none), entered if no other cell has done so.

    The cell below has entered its upper edge if `top` says so with a crossing of the last row, one from `below` on; an
    older one is left over. `left` is -1 if the cell on the left was not crossed: there is a hole or the border.
    """
    f00, f10, f01, f11 = values[row, i], values[row, i + 1], values[row + 1, i], values[row + 1, i + 1]
    bottom = right = upper = -1
    if (code ^ code >> 1) & 1:
        bottom = top[i]
        if bottom < below:
            bottom = enter(crossings, tally, between(f00, f10, level, x[i], x[i + 1]), y[row])
    if (code ^ code >> 2) & 1 and left < 0:
        left = enter(crossings, tally, x[i], between(f00, f01, level, y[row], y[row + 1]))
    if (code >> 1 ^ code >> 3) & 1:
        right = enter(crossings, tally, x[i + 1], between(f10, f11, level, y[row], y[row + 1]))
    if (code >> 2 ^ code >> 3) & 1:
        upper = enter(crossings, tally, between(f01, f11, level, x[i], x[i + 1]), y[row + 1])
        top[i] = upper
    return bottom, right, upper, left


@inlined
def link_edges(
    values: Floats,
    level: float,
    row: int,
    i: int,
    code: int,
    edges: Edges,
    crossings: Records,
    saddles: Records,
    tally: Integers,
) -> None:
    """Link the crossings of a cell by one arc, or by two if it is ambiguous."""
    f00, f10, f01, f11 = values[row, i], values[row, i + 1], values[row + 1, i], values[row + 1, i + 1]
    cell = row * (values.shape[1] - 1) + i
    start, end = START[code], END[code]
    if code == 6 or code == 9:
        det = determinant(f00, f10, f01, f11, level)
        if (det >= 0.0) if code == 9 else (det <= 0.0):
            end = (start + 1) & 3  # the high corners are joined: the arc goes around the low corner ahead
        else:
            end = (start + 3) & 3  # or back around the high one
        size = abs(f00 - level) + abs(f10 - level) + abs(f01 - level) + abs(f11 - level)  # |c|: signs alternate
        saddles[tally[1]].cell = cell
        saddles[tally[1]].margin = abs(det) / size
        tally[1] += 1
        bend = bend_of_arc(f00, f10, f01, f11, level, start ^ 2, end ^ 2)
        tally[2] += link(crossings, edges[start ^ 2], edges[end ^ 2], bend, cell)
    bend = bend_of_arc(f00, f10, f01, f11, level, start, end)
    tally[2] += link(crossings, edges[start], edges[end], bend, cell)


@jit
def classify(values: Floats, level: float, side: Bytes) -> None:
    """The side of each node of a row: 1 on or above the level, 0 below, `HOLE` if not finite."""
    for i in range(values.size):
        side[i] = (1 if values[i] >= level else 0) + (0 if values[i] - values[i] == 0.0 else HOLE)


@inlined
def between(f0: float, f1: float, level: float, p0: float, p1: float) -> float:
    """Where F = level between p0 and p1, measured from the nearer end: exact where a node is on the level."""
    before, after = level - f0, f1 - level
    if abs(before) < abs(after):
        return p0 + before / (f1 - f0) * (p1 - p0)
    return p1 - after / (f1 - f0) * (p1 - p0)


@inlined
def enter(crossings: Records, tally: Integers, x: float, y: float) -> int:
    """Enter a crossing that no arc has reached yet."""
    at: int = tally[0]
    tally[0] = at + 1
    crossings[at].x = x
    crossings[at].y = y
    crossings[at].next = -1
    crossings[at].entered = 0
    return at


@inlined
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


@inlined
def bend_of_arc(f00: float, f10: float, f01: float, f11: float, level: float, start: int, end: int) -> float:
    """ln(F_y(Q) / F_y(P)) of the arc between two edges, from differences along edges and F_x F_y = ab - cd.

    Between opposite edges the derivative along each is known; around a corner of value g the derivatives along its two
    edges are p and q, and F_x F_y = p q - c g. Where the saddle is on the level it is +-TURN.
    """
    c = twist(f00, f10, f01, f11)
    if (start + end) & 1 == 0:
        if start & 1 == 0:
            p, q = (f11 - f01, f10 - f00) if start == 0 else (f10 - f00, f11 - f01)
        else:
            p, q = (f01 - f00, f11 - f10) if start == 3 else (f11 - f10, f01 - f00)
        bend = log_ratio(q, p, c / p if start >= 2 else -c / p)
    else:
        if start + end == 1:
            g, p, q, c = f10, f00 - f10, f11 - f10, -c
        elif start * end == 2:
            g, p, q = f11, f01 - f11, f10 - f11
        elif start * end == 6:
            g, p, q, c = f01, f11 - f01, f00 - f01, -c
        else:
            g, p, q = f00, f10 - f00, f01 - f00
        s = c * (g - level) / (p * q)
        if abs(s) < 0.5:
            bend = -math.log1p(-s)
        else:
            bend = -log_ratio(abs(determinant(f00, f10, f01, f11, level) / p), abs(q), 1.0)
        if start & 1:
            bend = -bend
    return bend if abs(bend) >= STRAIGHT else 0.0


@inlined
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
