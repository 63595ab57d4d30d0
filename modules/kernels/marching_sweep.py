"""A slab of layers: find the cells that the surface passes, then write their patches with shared vertices.

A vertex is known by its place in the grid: edge, face and arc, or cell; never by its coordinates. The numbers of the
vertices of two planes and the layer between them are kept; one of an earlier layer is told by being too small.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import inlined, jit
from modules.kernels.marching_cases import INNER, Cell, Floats, Integers
from modules.kernels.marching_cell import joined_faces, patch
from modules.kernels.marching_inner import bi_shoulder
from modules.kernels.marching_points import keep_inside, place_crossing, place_shoulder


def _places() -> Integers:
    place = np.zeros((24, 4), np.int64)  # 0 lower plane, 1 upper plane, 2 layer between; steps in x and y; which there
    for u in (0, 1):
        for v in (0, 1):
            place[2 * u + v] = [v, 0, u, 0]
            place[4 + 2 * u + v] = [v, u, 0, 1]
            place[8 + 2 * u + v] = [2, u, v, 0]
    for side in (0, 1):
        for slot in (0, 1):
            place[12 + 2 * side + slot] = [2, side, 0, 1 + slot]
            place[16 + 2 * side + slot] = [2, 0, side, 3 + slot]
            place[20 + 2 * side + slot] = [side, 0, 0, 2 + slot]
    return place


PLACE = _places()

Row = Any
"""A record of `marching_cases.SIMPLE`."""


class Slab(NamedTuple):
    """Where a slab is written.

    Attributes
    ----------
    point : (n, 3)
    triangle : (m, 3) vertices by their number in the slab
    origin : (m,) cell of each triangle
    ids : (3, ny, nx, 5) numbers of the vertices of the two planes, by parity, and of the layer
    bottom : (b, 2) vertices in the lowest plane: their place there, and their number
    state : points, triangles, bottom vertices; first number of the layer before and of this one; tunnels, special cells
    """

    point: Floats
    triangle: Integers
    origin: Integers
    ids: npt.NDArray[np.int32]
    bottom: Integers
    state: Integers


class Lattice(NamedTuple):
    """The samples: (nz, ny, nx) values and the coordinates along each axis."""

    values: Floats
    x: Floats
    y: Floats
    z: Floats


@jit
def find(values: Floats, level: float, first: int, last: int, active: Integers, crossings: Integers) -> tuple[int, int]:
    """The cells of layers first to last - 1 with corners on both sides, and their code; how many, and their crossings.

    Parameters
    ----------
    active : gets 256 times the number of the cell in the slab, plus its code
    crossings : (256,) of each code
    """
    _, ny, nx = values.shape
    above = np.empty((2, ny, nx), np.uint8)
    four = np.empty(nx, np.uint8)
    found, total = 0, 0
    for k in range(first, last + 1):
        upper, lower = above[k & 1], above[(k + 1) & 1]
        for j in range(ny):
            for i in range(nx):
                upper[j, i] = values[k, j, i] >= level
        if k == first:
            continue
        for j in range(ny - 1):
            for i in range(nx):
                four[i] = lower[j, i] | (upper[j, i] << 1) | (lower[j + 1, i] << 2) | (upper[j + 1, i] << 3)
            row = ((k - 1 - first) * (ny - 1) + j) * (nx - 1)
            for i in range(nx - 1):
                code = four[i] | (four[i + 1] << 4)
                active[found] = ((row + i) << 8) | code
                if code != 0 and code != 255:
                    found += 1
                    total += crossings[code]
    return found, total


@jit
def write(
    lattice: Lattice, level: float, first: int, active: Integers, table: npt.NDArray[np.void], cell: Cell, slab: Slab
) -> None:
    """The patches of the active cells of a slab that starts at layer `first`.

    Cells with a corner that is not finite are left out.
    """
    _, ny, nx = lattice.values.shape
    corner, local, state, layer = np.empty(8), np.empty(32, np.int64), slab.state, -1
    for entry in active:
        number, code = entry >> 8, entry & 255
        row, i = number // (nx - 1), number % (nx - 1)
        k, j = first + row // (ny - 1), row % (ny - 1)
        if k != layer:
            state[3] = state[4] if k == layer + 1 else state[0]
            state[4] = state[0]
            layer = k
        finite = 0.0
        for c in range(8):
            corner[c] = lattice.values[k + (c & 1), j + ((c >> 1) & 1), i + (c >> 2)]
            cell.value[c] = corner[c] - level
            finite += 0.0 * corner[c]
        if finite != 0.0:
            continue
        origin = (k * (ny - 1) + j) * (nx - 1) + i
        if not (table[code].length > 0 and _write_simple(lattice, (i, j, k), first, origin, table[code], cell, slab)):
            _write_patch(lattice, (i, j, k), first, origin, code, joined_faces(corner, level, code), cell, slab, local)


@jit
def _write_simple(
    lattice: Lattice, at: tuple[int, int, int], first: int, origin: int, row: Row, cell: Cell, slab: Slab
) -> bool:
    """A fan over the one polygon; whether its bi-shoulder point was found."""
    low, high = row.side[0], row.side[1]
    place = cell.at[12 + 2 * high]
    place_shoulder(cell.value, high, row.first[0], row.first[1], place)
    if not bi_shoulder(cell, row.alone, low, high, place[low // 2], cell.at[INNER]):
        return False
    n = 2 * row.length
    keep_inside(cell.at[INNER])
    centre = _new_point(lattice, at, cell.at[INNER], slab)
    triangle = slab.state[1]
    for i in range(n):
        arc = row.arc[i // 2]
        known = _vertex(lattice, at, first, row.around[i], arc[0], arc[1], cell, slab)
        slab.triangle[triangle + i, 0] = known
        slab.triangle[triangle + (i + n - 1) % n, 1] = known
        slab.triangle[triangle + i, 2] = centre
        slab.origin[triangle + i] = origin
    slab.state[1] = triangle + n
    return True


@jit
def _write_patch(
    lattice: Lattice, at: tuple[int, int, int], first: int, origin: int, code: int, joined: int, cell: Cell, slab: Slab,
    local: Integers,
) -> None:
    """The patch of a cell that is not simple."""
    met = patch(cell, code, joined)
    slab.state[5] += met != 0 and cell.count[1] > 0 and (met & (met - 1)) != 0
    slab.state[6] += 1
    local[:] = -1
    for m in range(cell.count[0]):
        keep_inside(cell.at[INNER + m])
        local[INNER + m] = _new_point(lattice, at, cell.at[INNER + m], slab)
    for n in range(cell.count[1]):
        triangle = slab.state[1]
        for m in range(3):
            v = cell.triangle[n, m]
            if local[v] < 0:
                face, slot = (v - 12) // 2, v % 2
                p, q = (cell.arc[face, slot, 0], cell.arc[face, slot, 1]) if v >= 12 else (0, 0)
                local[v] = _vertex(lattice, at, first, v, p, q, cell, slab)
            slab.triangle[triangle, m] = local[v]
        slab.origin[triangle] = origin
        slab.state[1] = triangle + 1


@inlined
def _vertex(
    lattice: Lattice, at: tuple[int, int, int], first: int, v: int, p: int, q: int, cell: Cell, slab: Slab
) -> int:
    """The number of a vertex on an edge or, with the edges p and q of its arc, on a face; made if it is not known."""
    i, j, k = at
    which, state = PLACE[v, 0], slab.state
    ids = slab.ids[2 if which == 2 else (k + which) & 1, j + PLACE[v, 2], i + PLACE[v, 1]]
    known = ids[PLACE[v, 3]]
    if known >= (state[3] if which == 0 else state[4]):
        result: int = known
        return result
    place = cell.at[v]
    if v < 12:
        place_crossing(cell.value, v, place)
    else:
        place_shoulder(cell.value, (v - 12) // 2, p, q, place)
    n = _new_point(lattice, at, place, slab)
    ids[PLACE[v, 3]] = n
    if k == first and which == 0:
        nx = lattice.x.size
        slab.bottom[state[2], 0] = ((j + PLACE[v, 2]) * nx + i + PLACE[v, 1]) * 5 + PLACE[v, 3]
        slab.bottom[state[2], 1] = n
        state[2] += 1
    return n


@inlined
def _new_point(lattice: Lattice, at: tuple[int, int, int], place: Floats, slab: Slab) -> int:
    """One more vertex, at a place of a cell."""
    n = slab.state[0]
    i, j, k = at
    slab.point[n, 0] = (1.0 - place[0]) * lattice.x[i] + place[0] * lattice.x[i + 1]
    slab.point[n, 1] = (1.0 - place[1]) * lattice.y[j] + place[1] * lattice.y[j + 1]
    slab.point[n, 2] = (1.0 - place[2]) * lattice.z[k] + place[2] * lattice.z[k + 1]
    slab.state[0] = n + 1
    result: int = n
    return result


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
