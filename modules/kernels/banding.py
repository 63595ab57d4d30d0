"""The pieces of a band {low <= F < high} in one bilinear cell, traced around as polygons.

The border of a piece runs anticlockwise: along the cell's edges where these lie in the band, and along an arc of the low
or of the high contour where it leaves the band, as the asymptotic decider joins the crossings. No arc closes within a
cell, so a piece has no hole. `modules.kernels.bands` gives the arrays and cuts the work into slabs.

Corners and edges are numbered anticlockwise: corners 00, 10, 11, 01; edges bottom, right, top, left.
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import inlined, jit
from modules.kernels.bilinear import determinant
from modules.kernels.crossings import END, START, bend_of_arc, between

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Records = npt.NDArray[np.void]
Box = tuple[float, float, float, float]
"""x0, x1, y0, y1 of a cell."""
Place = tuple[int, int, int, int]
"""Number of a cell and of its corner 00, nodes in a row, nodes in all."""

MOST_HALVINGS = 12
"""An arc becomes at most 4096 pieces."""

VERTEX = np.dtype([("x", "f8"), ("y", "f8"), ("key", "i8"), ("on", "i8")])
"""A corner of a polygon: its place, what it is on the grid, the level whose contour it lies on (-1: none)."""

POLYGON = np.dtype([("band", "i8"), ("cell", "i8"), ("area", "f8"), ("left", "f8"), ("end", "i8")])
"""A polygon: its band and (first) cell, the exact area of what it stands for, the area between it and its arcs, and where
its vertices end."""


@jit
def fill_rows(
    values: Floats,
    upper_values: Floats,
    x: Floats,
    y: Floats,
    levels: Floats,
    tolerance: float,
    merged: bool,
    first: int,
    stop: int,
    state: Integers,
    polygons: Records,
    vertices: Records,
) -> None:
    """The polygons of the rows of cells `first` to `stop` of all blocks, counted in `state` and written if there is room.

    A band has its low border where `values` are on its low level and its high one where `upper_values` are on its high
    level: one field, or, for a single band, two of which the upper is nowhere larger. `state` is (polygons, vertices) so
    far; with empty arrays nothing is written.
    """
    rows, nx = values.shape[1] - 1, values.shape[2]
    one_field = levels[0] < levels[levels.size - 1]
    events, at = np.zeros((4, 12), np.int64), np.zeros(8, np.int64)
    corner, ring = np.empty((2, 4)), np.empty(16 + (4 << MOST_HALVINGS), VERTEX)
    for line in range(first, stop):
        block, row = line // rows, line % rows
        lower, upper = values[block, row], values[block, row + 1]
        lower_high, upper_high = upper_values[block, row], upper_values[block, row + 1]
        run = 0
        for i in range(nx - 1):
            if run:
                run -= 1
                continue
            c, d = corner[0], corner[1]
            c[0], c[1], c[2], c[3] = lower[i], lower[i + 1], upper[i + 1], upper[i]
            d[0], d[1], d[2], d[3] = lower_high[i], lower_high[i + 1], upper_high[i + 1], upper_high[i]
            least = min(min(c[0], c[1]), min(c[2], c[3]))
            most = max(max(d[0], d[1]), max(d[2], d[3]))
            if not (c[0] - c[0] + c[1] - c[1] + c[2] - c[2] + c[3] - c[3] + most - most == 0.0):
                continue
            if one_field:
                band = band_of(levels, least)
                whole = band >= 0 and band < levels.size - 1 and most < levels[band + 1]
            else:
                band, whole = 0, least >= levels[0] and most < levels[1]
            place = (line * (nx - 1) + i, (block * (rows + 1) + row) * nx + i, nx, values.size)
            if whole:
                low, high = levels[band], levels[band + 1]
                while merged and i + run + 2 < nx and is_whole(lower, upper, lower_high, upper_high, i + run + 1, low, high):
                    run += 1
                box = (x[block, i], x[block, i + 1 + run], y[block, row], y[block, row + 1])
                enter_whole(box, place, run, band, state, polygons, vertices)
                continue
            box = (x[block, i], x[block, i + 1], y[block, row], y[block, row + 1])
            for one in range(max(band, 0), levels.size - 1):
                if one_field and levels[one] > most:
                    break
                list_events(corner, levels[one], levels[one + 1], events, at)
                trace(corner, box, place, one, levels, tolerance, events, at, ring, state, polygons, vertices)


@inlined
def band_of(levels: Floats, value: float) -> int:
    """The band of a value: that of the last level at or below it; -1 below all."""
    low, high = 0, levels.size
    while low < high:
        middle = (low + high) // 2
        if levels[middle] <= value:
            low = middle + 1
        else:
            high = middle
    return low - 1


@inlined
def is_whole(
    lower: Floats, upper: Floats, lower_high: Floats, upper_high: Floats, i: int, low: float, high: float
) -> bool:
    """Whether all corners of a cell lie in the band; then all of it does."""
    for k in (i, i + 1):
        if not (lower[k] >= low and lower_high[k] < high and upper[k] >= low and upper_high[k] < high):
            return False
    return True


@inlined
def enter_whole(
    box: Box, place: Place, run: int, band: int, state: Integers, polygons: Records, vertices: Records
) -> None:
    """Enter a rectangle: a cell, or a run of cells of a row, that lies in the band as a whole."""
    x0, x1, y0, y1 = box
    cell, node, nx, _ = place
    enter(vertices, state, x0, y0, node, -1)
    enter(vertices, state, x1, y0, node + 1 + run, -1)
    enter(vertices, state, x1, y1, node + nx + 1 + run, -1)
    enter(vertices, state, x0, y1, node + nx, -1)
    close(polygons, state, band, cell, (x1 - x0) * (y1 - y0), 0.0)


@inlined
def enter(vertices: Records, state: Integers, x: float, y: float, key: int, on: int) -> None:
    """Enter a vertex, or only count it."""
    n = state[1]
    if n < vertices.size:
        vertices[n].x = x
        vertices[n].y = y
        vertices[n].key = key
        vertices[n].on = on
    state[1] = n + 1


@inlined
def close(polygons: Records, state: Integers, band: int, cell: int, area: float, left: float) -> None:
    """Enter a polygon of the vertices since the last one, or only count it."""
    n = state[0]
    if n < polygons.size:
        polygons[n].band = band
        polygons[n].cell = cell
        polygons[n].area = area
        polygons[n].left = left
        polygons[n].end = state[1]
    state[0] = n + 1


@inlined
def list_events(corner: Floats, low: float, high: float, events: Integers, at: Integers) -> None:
    """What a walk around the cell meets: corners, and crossings with the low and the high level.

    Rows of `events`: kind (0 corner, 1 low, 2 high; -1 after the last), corner or edge, whether the way on from there is
    in the band, 0 (it has not been walked). `at` is the event of the low crossing on each edge, then of the high one.
    """
    n = 0
    for k in range(4):
        j = (k + 1) & 3
        was_low, is_low = corner[0, k] >= low, corner[0, j] >= low
        was_high, is_high = corner[1, k] >= high, corner[1, j] >= high
        events[0, n], events[1, n], events[2, n], events[3, n] = 0, k, 1 if was_low and not was_high else 0, 0
        n += 1
        for turn in range(2):
            if (turn == 0) != was_high and was_low != is_low:  # the low level is met first unless the way comes from above
                at[k] = n
                events[0, n], events[1, n], events[2, n], events[3, n] = 1, k, 1 if is_low else 0, 0
                n += 1
            if (turn == 0) == was_high and was_high != is_high:
                at[4 + k] = n
                events[0, n], events[1, n], events[2, n], events[3, n] = 2, k, 0 if is_high else 1, 0
                n += 1
    if n < 12:
        events[0, n] = -1


@jit
def trace(
    corner: Floats,
    box: Box,
    place: Place,
    band: int,
    levels: Floats,
    tolerance: float,
    events: Integers,
    at: Integers,
    ring: Records,
    state: Integers,
    polygons: Records,
    vertices: Records,
) -> None:
    """Walk around each piece of a band in a cell; `ring` is room for the vertices of one."""
    n = 12
    for k in range(12):
        if events[0, k] < 0:
            n = k
            break
    for start in range(n):
        if not events[2, start] or events[3, start]:
            continue
        used, surplus, left = 0, 0.0, 0.0
        here = start
        while not events[3, here]:
            events[3, here] = 1
            x, y, key, on = vertex(corner, box, place, events[0, here], events[1, here], band, levels)
            used = push(ring, used, x, y, key, on)
            there = here + 1 if here + 1 < n else 0
            kind, edge = events[0, there], events[1, there]
            if kind == 0:
                here = there
                continue
            x, y, key, on = vertex(corner, box, place, kind, edge, band, levels)
            used = push(ring, used, x, y, key, on)
            other = other_end(corner[kind - 1], levels[on], edge)
            here = at[4 * (kind - 1) + other]
            used, bit = arc(corner, box, place, edge, other, kind, on, levels, tolerance, ring, used)
            surplus += bit
            left += abs(bit)
        first, used = cut_tails(ring, used)
        if used - first > 2:
            area = enter_ring(ring, first, used, box, state, vertices)
            close(polygons, state, band, place[0], area - surplus, left)


@jit
def push(ring: Records, used: int, x: float, y: float, key: int, on: int) -> int:
    """With one more vertex, unless it lies where the last one does; without a last one that led out and back."""
    while used > 1 and is_tail(ring, used - 2, used - 1, x, y):
        used -= 1
    if used > 0 and ring[used - 1].x == x and ring[used - 1].y == y:
        ring[used - 1].on = max(on, ring[used - 1].on)  # a node that a contour touches lies on its border
        return used
    ring[used].x = x
    ring[used].y = y
    ring[used].key = key
    ring[used].on = on
    return used + 1


@inlined
def is_tail(ring: Records, a: int, b: int, x: float, y: float) -> bool:
    """Whether from a to b and on to (x, y) is out and back along one grid direction: a contour that is a grid edge."""
    if ring[a].x == ring[b].x and ring[b].x == x:
        return bool((ring[b].y > ring[a].y) == (ring[b].y > y) and ring[b].y != y)
    if ring[a].y == ring[b].y and ring[b].y == y:
        return bool((ring[b].x > ring[a].x) == (ring[b].x > x) and ring[b].x != x)
    return False


@inlined
def cut_tails(ring: Records, used: int) -> tuple[int, int]:
    """The first and one past the last vertex, without what `push` would leave out where the ring closes."""
    first = 0
    while used - first > 2:
        if ring[used - 1].x == ring[first].x and ring[used - 1].y == ring[first].y:
            ring[first].on = max(ring[first].on, ring[used - 1].on)
            used -= 1
        elif is_tail(ring, used - 2, used - 1, ring[first].x, ring[first].y):
            used -= 1
        elif is_tail(ring, used - 1, first, ring[first + 1].x, ring[first + 1].y):
            first += 1
        else:
            break
    return first, used


@inlined
def enter_ring(ring: Records, first: int, used: int, box: Box, state: Integers, vertices: Records) -> float:
    """Enter the vertices of a ring; returns its area."""
    twice = 0.0
    before = used - 1
    for k in range(first, used):
        p, q = ring[before], ring[k]
        twice += (p.x - box[0]) * (q.y - box[2]) - (q.x - box[0]) * (p.y - box[2])
        enter(vertices, state, q.x, q.y, q.key, q.on)
        before = k
    return 0.5 * twice


@jit
def vertex(
    corner: Floats, box: Box, place: Place, kind: int, k: int, band: int, levels: Floats
) -> tuple[float, float, int, int]:
    """Place, key and level of an event: a corner, or the crossing of a level with an edge (a node if it falls on one)."""
    x0, x1, y0, y1 = box
    _, node, nx, nodes = place
    if kind == 0:
        right, up = (k == 1 or k == 2), k >= 2
        return x1 if right else x0, y1 if up else y0, node + int(right) + int(up) * nx, -1
    on, f = band + kind - 1, corner[kind - 1]
    if k == 0 or k == 2:
        px, py = between(f[0 if k == 0 else 3], f[1 if k == 0 else 2], levels[on], x0, x1), y0 if k == 0 else y1
        if px == x0 or px == x1:
            return px, py, node + int(px == x1) + int(k == 2) * nx, on
        edge = node + int(k == 2) * nx
    else:
        px, py = x1 if k == 1 else x0, between(f[1 if k == 1 else 0], f[2 if k == 1 else 3], levels[on], y0, y1)
        if py == y0 or py == y1:
            return px, py, node + int(k == 1) + int(py == y1) * nx, on
        edge = nodes + node + int(k == 1)
    return px, py, nodes + edge * levels.size + on, on


@jit
def other_end(corner: Floats, level: float, edge: int) -> int:
    """The edge where the arc through `edge` ends, as the asymptotic decider joins the crossings."""
    code = int(corner[0] >= level) | int(corner[1] >= level) << 1 | int(corner[3] >= level) << 2 | int(corner[2] >= level) << 3
    start, end = int(START[code]), int(END[code])
    if code == 6 or code == 9:
        det = determinant(corner[0], corner[1], corner[3], corner[2], level)
        ahead = 1 if ((det >= 0.0) if code == 9 else (det <= 0.0)) else 3
        return (edge + ahead) & 3 if (edge - start) & 1 == 0 else (edge - ahead) & 3
    return end if edge == start else start


@jit
def arc(
    corner: Floats,
    box: Box,
    place: Place,
    edge: int,
    other: int,
    kind: int,
    on: int,
    levels: Floats,
    tolerance: float,
    ring: Records,
    used: int,
) -> tuple[int, float]:
    """Add the points between the ends of an arc, which is halved until no more than the tolerance is left.

    An arc is always computed with the high side on its left, so that the bands on both sides get the same numbers.
    Returns the vertices used, and the area that the chords give the polygon too much (or, negative, too little).
    """
    start, end = (edge, other) if kind == 1 else (other, edge)
    px, py, _, _ = vertex(corner, box, place, kind, start, on + 1 - kind, levels)
    qx, qy, _, _ = vertex(corner, box, place, kind, end, on + 1 - kind, levels)
    dx, dy = qx - px, qy - py
    if dx == 0.0 or dy == 0.0:
        return used, 0.0
    f = corner[kind - 1]
    w = bend_of_arc(f[0], f[1], f[3], f[2], levels[on], start, end)
    size = abs(dx * dy)
    whole = size * bulge(abs(w))
    if whole == 0.0:
        return used, 0.0
    n = 0
    if whole > tolerance:
        n = min(MOST_HALVINGS, math.ceil(0.5 * math.log2(whole / tolerance) - 1e-9))
    pieces = 1 << n
    early, late = shares(abs(w), 1.0 / pieces)
    left = pieces * size * early * late * bulge(abs(w) / pieces)
    cell, node, nx, nodes = place
    key = nodes * (1 + 2 * levels.size) + (((2 * cell + (start >> 1)) * levels.size + on) << MOST_HALVINGS)
    for j in range(1, pieces):
        t = j if kind == 1 else pieces - j
        early, late = shares(abs(w), t / pieces)
        sx, sy = (late, early) if w > 0 else (early, late)
        x = px + sx * dx if sx <= 0.5 else qx - (1.0 - sx) * dx
        y = py + sy * dy if sy <= 0.5 else qy - (1.0 - sy) * dy
        if (x == box[0] or x == box[1]) and (y == box[2] or y == box[3]):
            used = push(ring, used, x, y, node + int(x == box[1]) + int(y == box[3]) * nx, on)
        else:
            used = push(ring, used, x, y, key + t, on)
    return used, left if (w * dx * dy > 0.0) == (kind == 1) else -left


@inlined
def shares(a: float, t: float) -> tuple[float, float]:
    """The parts of the chord covered at t along the axis that comes first, and along the other (`arcs.point`)."""
    if a == 0.0:
        return t, t
    early = math.expm1(-a * t) / math.expm1(-a)
    return early, early * math.exp(-a * (1.0 - t))


@inlined
def bulge(a: float) -> float:
    """(sinh a - a) / (4 sinh^2(a/2)): the area between arc and chord over that of their box (`arcs.area`)."""
    if a < 0.5:
        s = a * a
        top = 1.0 / 6.0 + s * (1.0 / 120.0 + s * (1.0 / 5040.0 + s * (1.0 / 362880.0 + s / 39916800.0)))
        under = 1.0 + s * (1.0 / 12.0 + s * (1.0 / 360.0 + s * (1.0 / 20160.0 + s / 1814400.0)))
        return a * top / under
    q = math.exp(-a)
    return (0.5 * (1.0 - q * q) - a * q) / (1.0 - q) ** 2
