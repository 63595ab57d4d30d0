"""The patch of one cell: its triangles with the topology of the trilinear interpolant.

Source: Lopes 1999, section 4.2.2; triangles 2 i + 2 m - 2 for a polygon of i crossings and m inner points, 2 i + 6 for
each polygon of a tunnel.
"""

from importlib import import_module

from modules.kernels._jit import jit
from modules.kernels.bilinear import determinant
from modules.kernels.marching_cases import FACE_CORNERS, INNER, Cell, Floats, ambiguous_faces, bent_back, polygons
from modules.kernels.marching_inner import inner_point
from modules.kernels.marching_points import hexagon, inflections, place_crossing, place_shoulder
from modules.kernels.marching_tunnels import fan, hexagon_patch, loop_back_patch


@jit
def joined_faces(corner: Floats, level: float, code: int) -> int:
    """Bits of the ambiguous faces whose corners 0 and 2 are joined; a saddle on the level counts as above.

    Parameters
    ----------
    corner : (8,) values as they were given
    """
    joined, faces = 0, ambiguous_faces(code)
    for face in range(6):
        if (faces >> face) & 1:
            c0, c1, c2, c3 = FACE_CORNERS[face]
            det = determinant(corner[c0], corner[c1], corner[c3], corner[c2], level)
            if det > 0.0 or (det == 0.0 and (code >> c0) & 1):
                joined |= 1 << face
    return joined


@jit
def patch(cell: Cell, code: int, joined: int) -> int:
    """The inner points and triangles of a cell whose `value` is given; bits of the polygons joined through it.

    Parameters
    ----------
    code : bits of the corners above
    joined : bits of the ambiguous faces whose corners 0 and 2 are joined
    """
    number = polygons(code, joined, cell)
    for polygon in range(number):
        for k in range(cell.start[polygon], cell.start[polygon + 1]):
            edge, face, slot = cell.loop[k], cell.face[k], cell.slot[k]
            place_crossing(cell.value, edge, cell.at[edge])
            place_shoulder(cell.value, face, cell.arc[face, slot, 0], cell.arc[face, slot, 1], cell.at[12 + 2 * face + slot])
    cell.count[0] = cell.count[1] = 0
    met = 0
    if inflections(cell.value, cell.bend) == 6 and hexagon(cell):
        met = hexagon_patch(cell, number)
    for polygon in range(number):
        if (met >> polygon) & 1:
            continue
        size, axes = cell.start[polygon + 1] - cell.start[polygon], bent_back(cell, polygon)
        if axes and loop_back_patch(cell, polygon, size, axes):
            continue
        centre = INNER + cell.count[0]
        inner_point(cell, polygon, size, cell.at[centre])
        cell.count[0] += 1
        fan(cell, polygon, size, centre)
    return met


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
