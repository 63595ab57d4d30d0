"""The patch of one cell: its triangles with the topology of the trilinear interpolant.

Source: Lopes 1999, section 4.2.2; triangles 2 i + 2 m - 2 for a polygon of i crossings and m inner points, 2 i + 6 for
each polygon of a tunnel.
"""

from importlib import import_module

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_part
from modules.kernels.bilinear import determinant
from modules.kernels.marching_cases import (
    FACE_CORNERS,
    INNER,
    Bytes,
    Cell,
    Floats,
    Integers,
    bent_back,
    int64,
    take_polygons,
)
from modules.kernels.marching_inner import inner_point
from modules.kernels.marching_points import (
    has_double_inflection,
    hexagon,
    inflections,
    keep_inside,
    place_crossing,
    place_shoulder,
)
from modules.kernels.marching_tunnels import fan, hexagon_patch, loop_back_patch


@jit
def joined_faces(corner: Floats, level: float, code: int, faces: int) -> tuple[int, bool]:
    """Bits of the ambiguous faces whose corners 0 and 2 are joined, and whether a saddle is on the level: it is above.

    Parameters
    ----------
    corner : (8,) values as they were given
    faces : bits of the ambiguous faces
    """
    joined, tied = 0, False
    for face in range(6):
        if (faces >> face) & 1:
            c0, c1, c2, c3 = FACE_CORNERS[face]
            det = determinant(corner[c0], corner[c1], corner[c3], corner[c2], level)
            if det > 0.0 or (det == 0.0 and (code >> c0) & 1):
                joined |= 1 << face
            tied |= det == 0.0
    return joined, tied


@lean_part
def patch(cell: Cell, number: int, bent: bool) -> int:
    """The inner points and triangles of a cell of known values and polygons; bits of the polygons joined through it.

    Without inflection points (`bent` is false) each polygon is closed by itself.
    """
    for polygon in range(number):
        for k in range(cell.start[polygon], cell.start[polygon + 1]):
            edge, face, slot = cell.loop[k], cell.face[k], cell.slot[k]
            place_crossing(cell.value, edge, cell.at[edge])
            place_shoulder(cell.value, face, cell.arc[face, slot, 0], cell.arc[face, slot, 1], cell.at[12 + 2 * face + slot])
    cell.count[0] = cell.count[1] = 0
    met = 0
    if inflections(cell.value, cell.bend) == 6 and bent and hexagon(cell):
        met = hexagon_patch(cell, number)
    for polygon in range(number):
        if (met >> polygon) & 1:
            continue
        size, axes = cell.start[polygon + 1] - cell.start[polygon], bent_back(cell, polygon)
        if axes and bent and loop_back_patch(cell, polygon, size, axes):
            continue
        centre = INNER + cell.count[0]
        inner_point(cell, polygon, size, cell.at[centre])
        cell.count[0] += 1
        fan(cell, polygon, size, centre)
    return met


@jit
def patches(
    values: Floats, nx: int, ny: int, level: float, nodes: Integers, cell: Cell,
    row: npt.NDArray[np.int16], shape: npt.NDArray[np.int8], ambiguous: Bytes, joined: Integers, counts: Integers,
    inner: Floats, triangle: Bytes, tunnels: Integers, tied: Floats, bent: bool,
) -> None:
    """The patches of some cells, each known by its first node.

    Parameters
    ----------
    row, shape, ambiguous : of `all_polygons`
    joined : (n,) gets the bits of the ambiguous faces whose corners 0 and 2 are joined
    counts : (n, 2) gets the number of inner points and of triangles
    inner, triangle : get the places of the inner points and the vertices of the triangles, cell after cell
    tunnels : its item is raised for each tunnel
    tied : its item is lowered to the largest |value - level| of each cell where the level meets a corner, a saddle of a
        face or a double inflection point exactly
    bent : whether inflection points are used
    """
    corner, points, corners = cell.given, 0, 0
    for n in range(len(nodes)):
        code, size, tie = int64(0), 0.0, False
        for c in range(8):
            corner[c] = values[nodes[n] + ((c & 1) * ny + ((c >> 1) & 1)) * nx + (c >> 2)]
            cell.value[c] = corner[c] - level
            code |= (corner[c] >= level) << c
            size, tie = max(size, abs(cell.value[c])), tie or corner[c] == level
        joined[n], saddle = joined_faces(corner, level, code, int64(ambiguous[code]))
        if size < tied[0] and (tie or saddle or has_double_inflection(cell.value)):
            tied[0] = size
        met = patch(cell, take_polygons(cell, shape[row[64 * code + joined[n]]]), bent)
        tunnels[0] += met != 0 and cell.count[1] > 0 and (met & (met - 1)) != 0
        counts[2 * n], counts[2 * n + 1] = cell.count[0], cell.count[1]
        for m in range(cell.count[0]):
            keep_inside(cell.at[INNER + m])
            for axis in range(3):
                inner[points] = cell.at[INNER + m, axis]
                points += 1
        for m in range(cell.count[1]):
            for c in range(3):
                triangle[corners] = cell.triangle[m, c]
                corners += 1


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
