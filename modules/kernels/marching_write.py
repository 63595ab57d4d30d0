"""The second pass over a slab of layers: points and triangles, written where the first pass made room for them.

A vertex is known by its place in the grid: edge, or face and arc; never by its coordinates. The numbers of the vertices
of two planes and of two rows between them are kept.
"""

from importlib import import_module

import numpy as np

from modules.kernels._jit import lean, lean_inlined, lean_part
from modules.kernels.marching_cases import EDGE_ENDS, INNER, Bytes, Floats, Integers, Masks, index, int64
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
    sweep,
)
from modules.kernels.marching_faces import FACE_LANES, FACE_ROWS, FACE_TAGS, seek_face, settle_faces
from modules.kernels.marching_find import UPPER
from modules.kernels.marching_points import crossing

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


REST, UP, TRIANGLE, STRANGE, INNER_AT, PATCH_AT, FILLED, FACES = range(8)
"""What is kept of the state: numbers of the next vertices and triangle; places in the patches; lanes in use, for inner
points and for faces."""

FACE_ROOM, FACE_ROOMS = 48 + FACE_ROWS * FACE_LANES, 48 + FACE_TAGS * FACE_LANES

PLACE = _places()
"""Of each vertex: where its number is kept."""


@lean_inlined
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


@lean_inlined
def _place_edge(f: Floats, edge: int, ends: Floats, point: Floats, n: int) -> None:
    """The crossing on an edge."""
    axis, low = edge >> 2, EDGE_ENDS[index(edge), 0]
    t = crossing(f[index(low)], f[index(EDGE_ENDS[index(edge), 1])])
    point[index(n), 0], point[index(n), 1] = ends[index(low >> 2)], ends[index(2 + ((low >> 1) & 1))]
    point[index(n), 2] = ends[index(4 + (low & 1))]
    point[index(n), index(axis)] = (1.0 - t) * ends[index(2 * axis)] + t * ends[index(2 * axis + 1)]


@lean_part
def _settle(
    lane: Floats, tag: Integers, state: Integers, point: Floats, failed: Integers, axes: Bytes, x: Floats, y: Floats, z: Floats,
    at: Floats,
) -> None:
    """Search in all lanes; the points of those that are done are written, the others moved together."""
    begin(lane)
    for _ in range(ROUNDS):
        sweep(lane)
    left = 0
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


@lean_inlined
def _make_room(
    lane: Floats, tag: Integers, state: Integers, values: Floats, level: float, x: Floats, y: Floats, z: Floats,
    point: Floats, spare: Floats,
) -> None:
    """Lanes for all faces of a cell."""
    if state[FACES] > FACE_LANES - 12:
        settle_faces(lane, tag, state[FACES], values, level, x, y, z, point, spare)
        state[FACES] = 0


@lean_inlined
def _number_again(i: int, mask: int, start: Integers, ids: Masks, state: Integers) -> None:
    """The numbers that the slab below gave to new vertices of a cell in its upper plane."""
    upper = (mask & UPPER) >> 1
    for v in range(1, 24):
        if upper & 1:
            ids[start[v] + 4 * i] = state[UP]
            state[UP] += 1
        upper >>= 1


@lean_inlined
def _vertices(
    f: Floats, i: int, node: int, mask: int, code: int, joined: int, lowest: Bytes, face: Bytes, start: Integers,
    ids: Masks, state: Integers, ends: Floats, point: Floats, lane: Floats, tag: Integers, at: Floats,
) -> None:
    """The new vertices of a cell."""
    edges, faces = mask & 4095, mask >> 12
    while edges:
        v = int64(lowest[index(edges)])
        edges &= edges - 1
        upper = (UPPER >> v) & 1
        number = state[index(upper)]
        state[index(upper)] = number + 1
        ids[index(start[index(v)] + 4 * i)] = number
        _place_edge(f, v, ends, point, number)
    while faces:
        v = int64(lowest[index(faces)])
        faces &= faces - 1
        upper = (UPPER >> (v + 12)) & 1
        number = state[index(upper)]
        state[index(upper)] = number + 1
        ids[index(start[index(v + 12)] + 4 * i)] = number
        state[FACES] = seek_face(
            f, v >> 1, v & 1, joined, face, (6 * code + (v >> 1)) * 8, ends, point, number, node, lane, tag, state[FACES], at
        )


@lean_inlined
def _fan(
    i: int, code: int, sides: Bytes, around: Bytes, start: Integers, ids: Masks, state: Integers, triangle: Integers
) -> int:
    """The triangles about the inner point of a simple cell; the point's number."""
    centre: int = state[REST]
    t, m = state[TRIANGLE], 2 * int64(sides[code])
    previous = ids[index(start[around[index(12 * code + m - 1)]] + 4 * i)]
    for c in range(m):
        this = ids[index(start[around[index(12 * code + c)]] + 4 * i)]
        triangle[index(t), 0], triangle[index(t), 1], triangle[index(t), 2] = previous, this, centre
        previous = this
        t += 1
    state[REST], state[TRIANGLE] = centre + 1, t
    return centre


@lean_inlined
def _seek(
    f: Floats, code: int, turned: Bytes, start_of: Bytes, centre: int, i: int, j: int, k: int, lane: Floats, tag: Integers,
    state: Integers,
) -> None:
    """A lane for the inner point of a simple cell."""
    n = index(state[FILLED])
    for c in range(8):
        lane[index(c * LANES) + n] = f[turned[index(8 * code + c)]]
    lane[index(AT * LANES) + n] = float(start_of[index(2 * code + 1)])
    lane[index(GAP * LANES) + n] = 1.0 / float(start_of[index(2 * code)])
    lane[index(TURNS * LANES) + n] = 0.0
    tag[n], tag[index(LANES) + n], tag[index(2 * LANES) + n] = centre, i, j
    tag[index(3 * LANES) + n], tag[index(4 * LANES) + n] = k, code
    state[FILLED] += 1


@lean_inlined
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


def room_to_work() -> tuple[Floats, Integers]:
    """Room for the lanes and one cell."""
    return np.zeros(FACE_ROOM + ROWS * LANES), np.zeros(FACE_ROOMS + TAGS * LANES, np.int64)


@lean
def write(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, first: int, last: int, base: Integers,
    below: Integers, below_start: Integers, active: Integers, row_start: Integers, joined: Integers, patch_count: Integers,
    inner: Floats, patch: Bytes, lowest: Bytes, sides: Bytes, around: Bytes, turned: Bytes, axes: Bytes,
    start_of: Bytes, face: Bytes, ids: Masks, failed: Integers, point: Floats, triangle: Integers, room: Floats,
    rooms: Integers,
) -> None:
    """The points and triangles of layers first to last - 1.

    Parameters
    ----------
    base : (last - first + 1, 3) of the layer below and of each: first vertex in its upper plane, other vertex, triangle
    below, below_start : active cells and rows of the layer below, whose upper vertices are counted again
    ids : where the numbers of vertices are kept
    room, rooms : as of `room_to_work`
    failed : gets how many inner points were not found and, from its item 2 on, the number and first node of each
    """
    nx, ny = x.size, y.size
    lane, face_lane, f, ends, at = room[FACE_ROOM:], room[48:FACE_ROOM], room[0:8], room[8:14], room[16:19]
    spare = room[24:41]
    tag, face_tag, step, start, state = rooms[FACE_ROOMS:], rooms[48:FACE_ROOMS], rooms[0:8], rooms[8:32], rooms[32:40]
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
                entry = cells[index(n)]
                i, mask, code = entry >> 32, (entry >> 8) & 0xFFFFFF, entry & 255
                if k < first:
                    _number_again(i, mask, start, ids, state)
                    continue
                node = (k * ny + j) * nx + i
                for c in range(8):
                    f[c] = values[index(node + step[c])] - level
                ends[0], ends[1] = x[i], x[i + 1]
                join = 0 if sides[code] else joined[state[STRANGE]]
                _make_room(face_lane, face_tag, state, values, level, x, y, z, point, spare)
                _vertices(
                    f, i, node, mask, code, join, lowest, face, start, ids, state, ends, point, face_lane, face_tag, at
                )
                if sides[code]:
                    centre = _fan(i, code, sides, around, start, ids, state, triangle)
                    _seek(f, code, turned, start_of, centre, i, j, k, lane, tag, state)
                    while state[FILLED] == LANES:
                        _settle(lane, tag, state, point, failed, axes, x, y, z, at)
                else:
                    _patch(i, patch_count, inner, patch, start, ids, state, ends, point, triangle)
    settle_faces(face_lane, face_tag, state[FACES], values, level, x, y, z, point, spare)
    while state[FILLED]:
        _settle(lane, tag, state, point, failed, axes, x, y, z, at)


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
