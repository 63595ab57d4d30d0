"""The second pass over a slab of layers: points and triangles, written where the first pass made room for them.

A vertex is known by its place in the grid: edge, or face and arc; never by its coordinates. The numbers of the vertices
of two planes and of two rows between them are kept.
"""

from importlib import import_module

import numpy as np

from modules.kernels._jit import inlined, jit
from modules.kernels.marching_cases import EDGE_ENDS, FACE_CORNERS, FACE_EDGES, INNER, Bytes, Floats, Integers, Masks, int64
from modules.kernels.marching_centres import (
    ACROSS_IT,
    ALONG,
    AT,
    BEFORE,
    CLOSE,
    GAP,
    LANES,
    MOST_SWEEPS,
    NEAR,
    ROUNDS,
    ROWS,
    TURNS,
    begin,
    from_corner,
    sweep,
)
from modules.kernels.marching_find import UPPER
from modules.kernels.marching_points import crossing, place_shoulder
from modules.kernels.marching_tables import AMBIGUOUS

TAGS = 5
"""Rows of what is known of the cell in a lane: its point, column, row, layer, code."""



def _places() -> Integers:
    place = np.zeros((24, 4), np.int64)  # 0 lower plane, 1 upper plane, 2 row below, 3 row above, 4 this row; steps; item
    for u in (0, 1):
        for v in (0, 1):
            place[2 * u + v] = [v, 0, u, 0]
            place[4 + 2 * u + v] = [v, u, 0, 1]
            place[8 + 2 * u + v] = [2 + v, u, 0, 0]
    for side in (0, 1):
        for slot in (0, 1):
            place[12 + 2 * side + slot] = [4, side, 0, slot]
            place[16 + 2 * side + slot] = [2 + side, 0, 0, 1 + slot]
            place[20 + 2 * side + slot] = [side, 0, 0, 2 + slot]
    return place


REST, UP, TRIANGLE, STRANGE, INNER_AT, PATCH_AT, FILLED = range(7)
"""What is kept of the state: numbers of the next vertices and triangle; places in the patches; lanes in use."""

PLACE = _places()
"""Of each vertex: where its number is kept."""


@inlined
def _starts(start: Integers, j: int, k: int, nx: int, ny: int) -> None:
    """Where the numbers of the vertices of the first cell of a row are kept; those of the i-th lie 4 i further."""
    for v in range(24):
        kind = PLACE[v, 0]
        if kind < 2:
            base = (((k + kind) & 1) * ny + j + PLACE[v, 2]) * nx
        elif kind < 4:
            base = (2 * ny + ((j + kind) & 1)) * nx
        else:
            base = (2 * ny + 2) * nx
        start[v] = 4 * (base + PLACE[v, 1]) + PLACE[v, 3]


@inlined
def _place_edge(f: Floats, edge: int, ends: Floats, point: Floats, n: int) -> None:
    """The crossing on an edge."""
    axis, low = edge >> 2, EDGE_ENDS[edge, 0]
    t = crossing(f[low], f[EDGE_ENDS[edge, 1]])
    point[n, 0], point[n, 1], point[n, 2] = ends[low >> 2], ends[2 + ((low >> 1) & 1)], ends[4 + (low & 1)]
    point[n, axis] = (1.0 - t) * ends[2 * axis] + t * ends[2 * axis + 1]


@inlined
def _place_face(
    f: Floats, face: int, slot: int, joined: int, rows: Bytes, row: int, ends: Floats, point: Floats, n: int
) -> None:
    """The shoulder point of an arc on a face."""
    if rows[row + 4] != AMBIGUOUS:
        own, along, across = rows[row], rows[row + 5], rows[row + 6]
        p, q = from_corner(f[own], f[rows[row + 1]], f[rows[row + 2]], f[rows[row + 3]], rows[row + 4] == 1)
        if NEAR < p < 1.0 - NEAR and NEAR < q < 1.0 - NEAR:
            p = 1.0 - p if own & (4 >> along) else p
            q = 1.0 - q if own & (4 >> across) else q
            point[n, face >> 1] = ends[face]
            point[n, along] = (1.0 - p) * ends[2 * along] + p * ends[2 * along + 1]
            point[n, across] = (1.0 - q) * ends[2 * across] + q * ends[2 * across + 1]
            return
    _place_face_carefully(f, face, slot, joined, ends, point, n)


@jit
def _place_face_carefully(f: Floats, face: int, slot: int, joined: int, ends: Floats, point: Floats, n: int) -> None:
    first, second, around, at = -1, -1, 0, np.empty(3)
    for c in range(4):
        around |= (f[FACE_CORNERS[face, c]] >= 0.0) << c
    if around == 5 or around == 10:
        first, second = (2 * slot, 2 * slot + 1) if (joined >> face) & 1 else ((3, 0) if slot == 0 else (1, 2))
    else:
        for c in range(4):
            if ((around >> c) ^ (around >> ((c + 1) % 4))) & 1:
                first, second = (c, second) if first < 0 else (first, c)
    place_shoulder(f, face, FACE_EDGES[face, first], FACE_EDGES[face, second], at)
    for axis in range(3):
        point[n, axis] = (1.0 - at[axis]) * ends[2 * axis] + at[axis] * ends[2 * axis + 1]


@jit
def _settle(
    lane: Floats, tag: Integers, state: Integers, point: Floats, failed: Integers, axes: Bytes, x: Floats, y: Floats, z: Floats
) -> None:
    """Search in all lanes; the points of those that are done are written, the others moved together."""
    begin(lane)
    for _ in range(ROUNDS):
        sweep(lane)
    at, left = np.empty(3), 0
    for n in range(state[FILLED]):
        t, p, q = lane[BEFORE * LANES + n], lane[ALONG * LANES + n], lane[ACROSS_IT * LANES + n]
        gap, turns = abs(lane[GAP * LANES + n]), lane[TURNS * LANES + n] + 1.0
        if gap >= CLOSE and turns < MOST_SWEEPS:
            for row in range(ROWS):
                lane[row * LANES + left] = lane[row * LANES + n]
            for row in range(TAGS):
                tag[row * LANES + left] = tag[row * LANES + n]
            lane[TURNS * LANES + left] = turns
            left += 1
            continue
        number, i, j = tag[n], tag[LANES + n], tag[2 * LANES + n]
        k, code = tag[3 * LANES + n], tag[4 * LANES + n]
        if NEAR < t < 1.0 - NEAR and NEAR < p < 1.0 - NEAR and NEAR < q < 1.0 - NEAR:
            at[axes[3 * code]], at[axes[3 * code + 1]], at[axes[3 * code + 2]] = t, p, q
            point[number, 0] = (1.0 - at[0]) * x[i] + at[0] * x[i + 1]
            point[number, 1] = (1.0 - at[1]) * y[j] + at[1] * y[j + 1]
            point[number, 2] = (1.0 - at[2]) * z[k] + at[2] * z[k + 1]
        else:
            failed[0] += 1
            failed[2 * failed[0]], failed[2 * failed[0] + 1] = number, (k * y.size + j) * x.size + i
    state[FILLED] = left


@inlined
def _number_again(i: int, mask: int, start: Integers, ids: Masks, state: Integers) -> None:
    """The numbers that the slab below gave to new vertices of a cell in its upper plane."""
    upper = (mask & UPPER) >> 1
    for v in range(1, 24):
        if upper & 1:
            ids[start[v] + 4 * i] = state[UP]
            state[UP] += 1
        upper >>= 1


@inlined
def _vertices(
    f: Floats, i: int, mask: int, code: int, joined: int, lowest: Bytes, face: Bytes, start: Integers,
    ids: Masks, state: Integers, ends: Floats, point: Floats,
) -> None:
    """The new vertices of a cell."""
    edges, faces = mask & 4095, mask >> 12
    while edges:
        v = int64(lowest[edges])
        edges &= edges - 1
        upper = (UPPER >> v) & 1
        number = state[upper]
        state[upper] = number + 1
        ids[start[v] + 4 * i] = number
        _place_edge(f, v, ends, point, number)
    while faces:
        v = int64(lowest[faces])
        faces &= faces - 1
        upper = (UPPER >> (v + 12)) & 1
        number = state[upper]
        state[upper] = number + 1
        ids[start[v + 12] + 4 * i] = number
        _place_face(f, v >> 1, v & 1, joined, face, (6 * code + (v >> 1)) * 8, ends, point, number)


@inlined
def _fan(
    i: int, code: int, sides: Bytes, around: Bytes, start: Integers, ids: Masks, state: Integers, triangle: Integers
) -> int:
    """The triangles about the inner point of a simple cell; the point's number."""
    centre: int = state[REST]
    t, m = state[TRIANGLE], 2 * int64(sides[code])
    previous = ids[start[around[12 * code + m - 1]] + 4 * i]
    for c in range(m):
        this = ids[start[around[12 * code + c]] + 4 * i]
        triangle[t, 0], triangle[t, 1], triangle[t, 2] = previous, this, centre
        previous = this
        t += 1
    state[REST], state[TRIANGLE] = centre + 1, t
    return centre


@inlined
def _seek(
    f: Floats, code: int, turned: Bytes, start_of: Bytes, centre: int, i: int, j: int, k: int, lane: Floats, tag: Integers,
    state: Integers,
) -> None:
    """A lane for the inner point of a simple cell."""
    n = state[FILLED]
    for c in range(8):
        lane[c * LANES + n] = f[turned[8 * code + c]]
    lane[AT * LANES + n], lane[GAP * LANES + n] = float(start_of[2 * code + 1]), 1.0 / float(start_of[2 * code])
    lane[TURNS * LANES + n] = 0.0
    tag[n], tag[LANES + n], tag[2 * LANES + n], tag[3 * LANES + n], tag[4 * LANES + n] = centre, i, j, k, code
    state[FILLED] = n + 1


@inlined
def _patch(
    i: int, patch_count: Integers, inner: Floats, patch: Bytes, start: Integers, ids: Masks, state: Integers, ends: Floats,
    point: Floats, triangle: Integers,
) -> None:
    """The patch, made before, of a cell that is not simple."""
    strange, points, corners, first, t = state[STRANGE], state[INNER_AT], state[PATCH_AT], state[REST], state[TRIANGLE]
    for c in range(patch_count[2 * strange]):
        for axis in range(3):
            u = inner[points + axis]
            point[first + c, axis] = (1.0 - u) * ends[2 * axis] + u * ends[2 * axis + 1]
        points += 3
    for _ in range(patch_count[2 * strange + 1]):
        for c in range(3):
            v = int64(patch[corners + c])
            triangle[t, c] = ids[start[v] + 4 * i] if v < INNER else first + v - INNER
        corners += 3
        t += 1
    state[REST] = first + patch_count[2 * strange]
    state[TRIANGLE], state[STRANGE], state[INNER_AT], state[PATCH_AT] = t, strange + 1, points, corners


@jit
def write(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, first: int, last: int, base: Integers,
    below: Integers, below_start: Integers, active: Integers, row_start: Integers, joined: Integers, patch_count: Integers,
    inner: Floats, patch: Bytes, lowest: Bytes, sides: Bytes, around: Bytes, turned: Bytes, axes: Bytes,
    start_of: Bytes, face: Bytes, ids: Masks, failed: Integers, point: Floats, triangle: Integers,
) -> None:
    """The points and triangles of layers first to last - 1.

    Parameters
    ----------
    base : (last - first + 1, 3) of the layer below and of each: first vertex in its upper plane, other vertex, triangle
    below, below_start : active cells and rows of the layer below, whose upper vertices are counted again
    ids : where the numbers of vertices are kept
    failed : gets how many inner points were not found and, from its item 2 on, the number and first node of each
    """
    nx, ny = x.size, y.size
    step, start, f, ends, state = np.empty(8, np.int64), np.empty(24, np.int64), np.empty(8), np.empty(6), np.zeros(8, np.int64)
    lane, tag = np.zeros(ROWS * LANES), np.zeros(TAGS * LANES, np.int64)
    for c in range(8):
        step[c] = ((c & 1) * ny + ((c >> 1) & 1)) * nx + (c >> 2)
    for k in range(max(first - 1, 0), last):
        b, rows, cells, shift = 3 * (k - first + 1), row_start, active, (k - first) * (ny - 1)
        if k < first:
            rows, cells, shift = below_start, below, 0
        state[UP], state[REST], state[TRIANGLE] = base[b], base[b + 1], base[b + 2]
        ends[4], ends[5] = z[k], z[k + 1]
        for j in range(ny - 1):
            begin_at, end_at = rows[shift + j], rows[shift + j + 1]
            if begin_at == end_at:
                continue
            _starts(start, j, k, nx, ny)
            ends[2], ends[3] = y[j], y[j + 1]
            for n in range(begin_at, end_at):
                entry = cells[n]
                i, mask, code = entry >> 32, (entry >> 8) & 0xFFFFFF, entry & 255
                if k < first:
                    _number_again(i, mask, start, ids, state)
                    continue
                node = (k * ny + j) * nx + i
                for c in range(8):
                    f[c] = values[node + step[c]] - level
                ends[0], ends[1] = x[i], x[i + 1]
                join = 0 if sides[code] else joined[state[STRANGE]]
                _vertices(f, i, mask, code, join, lowest, face, start, ids, state, ends, point)
                if sides[code]:
                    centre = _fan(i, code, sides, around, start, ids, state, triangle)
                    _seek(f, code, turned, start_of, centre, i, j, k, lane, tag, state)
                    while state[FILLED] == LANES:
                        _settle(lane, tag, state, point, failed, axes, x, y, z)
                else:
                    _patch(i, patch_count, inner, patch, start, ids, state, ends, point, triangle)
    while state[FILLED]:
        _settle(lane, tag, state, point, failed, axes, x, y, z)


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
