"""The combinatorics of a cell: corners, edges, faces, and the polygons in which a surface cuts the faces.

Numbers
-------
- Corner 4x + 2y + z, the thesis's order 000, 001, 010, ..., 111 of xyz; a *code* has bit c set where corner c is above.
- Edge 4 axis + 2u + v, with u and v the places across, in the order of the other two axes.
- Face 2 axis + side; its corners and edges run around it: edge i lies between corners i and i + 1.
- A face holds up to two arcs, in *slots*: slot 0 has the face's edge 0, or is the only one.
- A vertex of a cell: 0-11 a crossing by its edge, 12-23 a shoulder point by 12 + 2 face + slot, 24-31 an inner point.

Source: Lopes 1999, sections 4.1 and 4.2.1 (topological polygons).
"""

import functools
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

INNER = 24
"""The first inner point among the vertices of a cell."""

MOST_INNER = 8


CELL = np.dtype(
    [
        ("value", np.float64, (8,)),  # less the level
        ("loop", np.int64, (12,)),  # the edges of the polygons, one polygon after the other
        ("face", np.int64, (12,)),  # of the arc from each edge to the next
        ("slot", np.int64, (12,)),
        ("start", np.int64, (6,)),  # where each polygon starts, and after the last its end
        ("arc", np.int64, (6, 2, 3)),  # of each face and slot: two edges as the polygon runs, and the polygon; -1: none
        ("at", np.float64, (32, 3)),  # places of the vertices in the unit cell
        ("probe", np.float64, (2, 3)),  # places of a search
        ("count", np.int64, (2,)),  # inner points and triangles
        ("triangle", np.int64, (48, 3)),  # vertices
        ("bend", np.float64, (6, 3)),  # inflection points, two an axis; nan: none inside
        ("hexagon", np.float64, (6, 3)),  # the inflection points in cyclic order
        ("ray", np.int64, (12, 3)),  # ends of straight lines of the surface: inner point, face, slot
        ("ray_at", np.float64, (12, 3)),
        ("token", np.int64, (36, 2)),  # vertices (0) and ends of lines (1) in their order around a polygon
        ("ring", np.int64, (24,)),  # the inner point that each vertex around a polygon belongs to
    ],
    align=True,
)
"""What is known of one cell while its patch is made."""

Cell = Any
"""A record of `CELL`."""

SIMPLE = np.dtype(
    [
        ("length", np.int64),  # of the one polygon; 0: no polygon; -1: the cell needs more thought
        ("around", np.int64, (12,)),  # its vertices
        ("arc", np.int64, (6, 2)),  # the edges of its arcs
        ("side", np.int64, (2,)),  # the faces between which its bi-shoulder point is sought
        ("first", np.int64, (2,)),  # the edges of the arc on the second of them
        ("alone", np.int64),  # -1, for the cell has no other polygon
        ("crossings", np.int64),
    ],
    align=True,
)
"""A code with one polygon and no ambiguous face: no loop-back face and no tunnel."""


def new_cell() -> Cell:
    """Room for one cell."""
    return np.zeros(1, CELL)[0]


def _across(axis: int) -> tuple[int, int]:
    p, q = (a for a in range(3) if a != axis)
    return p, q


def _corner(places: dict[int, int]) -> int:
    return 4 * places[0] + 2 * places[1] + places[2]


def _edge(along: int, places: dict[int, int]) -> int:
    p, q = _across(along)
    return 4 * along + 2 * places[p] + places[q]


def _edge_ends() -> Integers:
    ends = np.zeros((12, 2), np.int64)
    for axis in range(3):
        p, q = _across(axis)
        for u in (0, 1):
            for v in (0, 1):
                ends[4 * axis + 2 * u + v] = [_corner({axis: s, p: u, q: v}) for s in (0, 1)]
    return ends


def _around_faces() -> tuple[Integers, Integers]:
    corners, edges = np.zeros((6, 4), np.int64), np.zeros((6, 4), np.int64)
    for axis in range(3):
        p, q = _across(axis)
        for side in (0, 1):
            corners[2 * axis + side] = [_corner({axis: side, p: u, q: v}) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
            edges[2 * axis + side] = [
                _edge(along, {axis: side, across: place})
                for along, across, place in ((p, q, 0), (q, p, 1), (p, q, 1), (q, p, 0))
            ]
    return corners, edges


ACROSS = np.array([_across(axis) for axis in range(3)])
EDGE_ENDS = _edge_ends()
FACE_CORNERS, FACE_EDGES = _around_faces()


@jit
def around_face(code: int, face: int) -> int:
    """Bit i set where the face's corner i is above."""
    around = 0
    for i in range(4):
        around |= ((code >> FACE_CORNERS[face, i]) & 1) << i
    return around


@jit
def ambiguous_faces(code: int) -> int:
    """A bit for each face whose corners are above and below by turns."""
    faces = 0
    for face in range(6):
        around = around_face(code, face)
        if around == 5 or around == 10:
            faces |= 1 << face
    return faces


@jit
def polygons(code: int, joined: int, cell: Cell) -> int:
    """The closed polygons around the cell, the side above on the right as seen from outside; their number.

    Parameters
    ----------
    code : bits of the corners above
    joined : bits of the ambiguous faces whose corners 0 and 2 are joined
    cell : gets loop, face, slot, start and arc
    """
    after = np.full((12, 3), -1, np.int64)  # of each edge: the next one, face, slot
    for face in range(6):
        _arcs(after, face, around_face(code, face), (joined >> face) & 1)
    cell.arc[:] = -1
    found, n = 0, 0
    for first in range(12):
        edge = first
        cell.start[found] = n
        while after[edge, 0] >= 0:
            cell.loop[n], cell.face[n], cell.slot[n] = edge, after[edge, 1], after[edge, 2]
            arc = cell.arc[cell.face[n], cell.slot[n]]
            arc[0], arc[1], arc[2] = edge, after[edge, 0], found
            n += 1
            following = after[edge, 0]
            after[edge, 0] = -1
            edge = following
        if n > cell.start[found]:
            found += 1
    cell.start[found] = n
    return found


@jit
def _arcs(after: Integers, face: int, around: int, joined: int) -> None:
    """The one or two arcs on a face."""
    if around == 5 or around == 10:
        if joined:
            _direct(after, face, 0, 1, 0, around)
            _direct(after, face, 2, 3, 1, around)
        else:
            _direct(after, face, 3, 0, 0, around)
            _direct(after, face, 1, 2, 1, around)
        return
    first, second = -1, -1
    for i in range(4):
        if ((around >> i) ^ (around >> ((i + 1) % 4))) & 1:
            if first < 0:
                first = i
            else:
                second = i
    if first >= 0:
        _direct(after, face, first, second, 0, around)


@jit
def _direct(after: Integers, face: int, i: int, j: int, slot: int, around: int) -> None:
    """The arc between the face's edges i and j, directed; going from i to j, corner i + 1 is on the right."""
    outward = (face % 2 == 1) == (face // 2 != 1)  # the face runs counter-clockwise as seen from outside
    if (((around >> ((i + 1) % 4)) & 1) == 1) != outward:
        i, j = j, i
    edge = FACE_EDGES[face, i]
    after[edge, 0], after[edge, 1], after[edge, 2] = FACE_EDGES[face, j], face, slot


@jit
def bent_back(cell: Cell, polygon: int) -> int:
    """A bit for each axis on a face of which the polygon has two arcs (a loop-back face)."""
    axes = 0
    for face in range(6):
        if cell.arc[face, 0, 2] == polygon and cell.arc[face, 1, 2] == polygon:
            axes |= 1 << (face // 2)
    return axes


@jit
def shoulder_faces(cell: Cell, polygon: int) -> tuple[int, int]:
    """The two faces, on other axes, between which the bi-shoulder point is sought: opposite pairs first.

    Source: thesis 4.2.2.2; the first that its rule admits.
    """
    has = np.zeros(6, np.bool_)
    for face in range(6):
        has[face] = cell.arc[face, 0, 2] == polygon or cell.arc[face, 1, 2] == polygon
    first, second = -1, -1
    for single in range(2):
        for face in range(6):
            if first < 0 and has[face] and (single or has[face ^ 1]):
                first = face
    for single in range(2):
        for face in range(6):
            if second < 0 and face // 2 != first // 2 and has[face] and (single or has[face ^ 1]):
                second = face
    return first, second


@functools.cache
def simple() -> npt.NDArray[np.void]:
    """(256,) records of `SIMPLE`, made from `polygons`."""
    cell = new_cell()
    table = np.zeros(256, SIMPLE)
    table["alone"] = -1
    for code in range(1, 255):
        found, row = polygons(code, 0, cell), table[code]
        row["crossings"], row["length"] = cell["start"][found], -1
        if found == 1 and not ambiguous_faces(code):
            n = int(cell["start"][1])
            row["length"] = n
            for i in range(n):
                face = int(cell["face"][i])
                row["around"][2 * i : 2 * i + 2] = cell["loop"][i], 12 + 2 * face
                row["arc"][i] = cell["arc"][face, 0, :2]
            row["side"] = shoulder_faces(cell, 0)
            row["first"] = cell["arc"][row["side"][1], 0, :2]
    return table


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
