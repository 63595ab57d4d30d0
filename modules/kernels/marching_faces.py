"""Shoulder points of faces, many at once, in lanes that run on whole vector registers.

Source: Lopes 1999, equations (3.6) and (3.7), in the closed form of `marching_centres.from_corner`.
"""

from importlib import import_module

from modules.kernels._jit import lean_inlined, lean_part
from modules.kernels.marching_cases import FACE_CORNERS, FACE_EDGES, Bytes, Floats, Integers, index, int64
from modules.kernels.marching_centres import NEAR, from_corner
from modules.kernels.marching_points import place_shoulder
from modules.kernels.marching_tables import AMBIGUOUS

FACE_LANES = 128
FACE_ROWS = 9
"""Rows of the lanes: four corner values, of which the first is cut off or starts a cut side; whether it is cut off; the
ends of the two sides from it in space."""

FACE_TAGS = 5
"""Rows of what is known of a lane: its point, the axes of the two sides, the first node of the cell, the face."""


@lean_inlined
def seek_face(
    f: Floats, face: int, slot: int, joined: int, rows: Bytes, row: int, ends: Floats, point: Floats, n: int, node: int,
    lane: Floats, tag: Integers, filled: int, at: Floats,
) -> int:
    """A lane for the shoulder point of an arc on a face; how many are filled. A face with two arcs is done at once."""
    if rows[index(row + 4)] == AMBIGUOUS:
        place_face_carefully(f, face, slot, joined, ends, point, n, at)
        return filled
    m, own = index(filled), int64(rows[index(row)])
    along, across = int64(rows[index(row + 5)]), int64(rows[index(row + 6)])
    lane[m], lane[index(FACE_LANES) + m] = f[index(own)], f[rows[index(row + 1)]]
    lane[index(2 * FACE_LANES) + m], lane[index(3 * FACE_LANES) + m] = f[rows[index(row + 2)]], f[rows[index(row + 3)]]
    lane[index(4 * FACE_LANES) + m] = float(rows[index(row + 4)])
    far_along, far_across = (own >> (2 - along)) & 1, (own >> (2 - across)) & 1
    lane[index(5 * FACE_LANES) + m] = ends[index(2 * along + far_along)]
    lane[index(6 * FACE_LANES) + m] = ends[index(2 * along + 1 - far_along)]
    lane[index(7 * FACE_LANES) + m] = ends[index(2 * across + far_across)]
    lane[index(8 * FACE_LANES) + m] = ends[index(2 * across + 1 - far_across)]
    tag[m], tag[index(FACE_LANES) + m], tag[index(2 * FACE_LANES) + m] = n, along, across
    tag[index(3 * FACE_LANES) + m], tag[index(4 * FACE_LANES) + m] = node, face
    point[index(n), index(face >> 1)] = ends[index(face)]
    return filled + 1


@lean_part
def settle_faces(
    lane: Floats, tag: Integers, filled: int, values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats,
    spare: Floats,
) -> None:
    """The points of all lanes; `spare` is room for a cell."""
    for m in range(FACE_LANES):
        v, va, vb, vc = lane[m], lane[FACE_LANES + m], lane[2 * FACE_LANES + m], lane[3 * FACE_LANES + m]
        p, q = from_corner(v, va, vb, vc, lane[4 * FACE_LANES + m] == 1.0)
        good = (p > NEAR) & (p < 1.0 - NEAR) & (q > NEAR) & (q < 1.0 - NEAR)
        lane[m] = (1.0 - p) * lane[5 * FACE_LANES + m] + p * lane[6 * FACE_LANES + m]
        lane[FACE_LANES + m] = (1.0 - q) * lane[7 * FACE_LANES + m] + q * lane[8 * FACE_LANES + m]
        lane[2 * FACE_LANES + m] = 1.0 if good else 0.0
    nx, ny, f, ends, at = x.size, y.size, spare[0:8], spare[8:14], spare[14:17]
    for m in range(filled):
        n = index(tag[m])
        if lane[2 * FACE_LANES + m] == 1.0:
            point[n, index(tag[FACE_LANES + m])] = lane[m]
            point[n, index(tag[2 * FACE_LANES + m])] = lane[FACE_LANES + m]
            continue
        node, face = tag[3 * FACE_LANES + m], tag[4 * FACE_LANES + m]
        i, j, k = node % nx, node // nx % ny, node // nx // ny
        for c in range(8):
            f[c] = values[node + ((c & 1) * ny + ((c >> 1) & 1)) * nx + (c >> 2)] - level
        ends[0], ends[1], ends[2], ends[3], ends[4], ends[5] = x[i], x[i + 1], y[j], y[j + 1], z[k], z[k + 1]
        place_face_carefully(f, face, int64(0), int64(0), ends, point, tag[m], at)


@lean_part
def place_face_carefully(
    f: Floats, face: int, slot: int, joined: int, ends: Floats, point: Floats, n: int, at: Floats
) -> None:
    """The shoulder point of one arc, whatever its face looks like."""
    first, second, around = -1, -1, 0
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


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
