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
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import lean, lean_part

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]
Masks = npt.NDArray[np.int32]

INNER = 24
"""The first inner point among the vertices of a cell."""

MOST_INNER = 8


CELL = np.dtype(
    [
        ("value", np.float64, (8,)),  # less the level
        ("given", np.float64, (8,)),  # the values as they are
        ("loop", np.int64, (12,)),  # the edges of the polygons, one polygon after the other
        ("face", np.int64, (12,)),  # of the arc from each edge to the next
        ("slot", np.int64, (12,)),
        ("start", np.int64, (6,)),  # where each polygon starts, and after the last its end
        ("arc", np.int64, (6, 2, 3)),  # of each face and slot: two edges as the polygon runs, and the polygon; -1: none
        ("at", np.float64, (32, 3)),  # places of the vertices in the unit cell
        ("probe", np.float64, (3, 3)),  # places of a search
        ("count", np.int64, (2,)),  # inner points and triangles
        ("triangle", np.int64, (48, 3)),  # vertices
        ("bend", np.float64, (6, 3)),  # inflection points, two an axis; nan: none inside
        ("hexagon", np.float64, (6, 3)),  # the inflection points in cyclic order
        ("ray", np.int64, (12, 3)),  # ends of straight lines of the surface: inner point, face, slot
        ("ray_at", np.float64, (12, 3)),
        ("token", np.int64, (36, 2)),  # vertices (0) and ends of lines (1) in their order around a polygon
        ("ring", np.int64, (24,)),  # the inner point that each vertex around a polygon belongs to
        ("chain", np.float64, (6, 3)),  # the inflection points of a loop-back polygon
        ("kind", np.int64, (6,)),  # their axes
        ("order", np.int64, (24,)),  # in which a polygon meets them
        ("box", np.float64, (3, 3)),  # least, largest and mean place of the crossings of a polygon
        ("spot", np.float64, (16,)),  # places along an arc
    ],
    align=True,
)
"""What is known of one cell while its patch is made."""

Cell = Any
"""A record of `CELL`."""

int64: Any = np.int64
"""For a number whose type would else depend on the call: a kernel is compiled once more for each literal."""

index: Any = np.uintp
"""For a place that is never negative: nothing is then done to count from the end."""


def frozen(values: Floats, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Values and axes as one-dimensional arrays for a kernel: one signature for arrays that may and may not be written."""
    flat = tuple(np.ascontiguousarray(array, np.float64).reshape(-1).view() for array in (values, x, y, z))
    for array in flat:
        array.flags.writeable = False
    return flat[0], flat[1], flat[2], flat[3]


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


def around_face(code: int, face: int) -> int:
    """Bit i set where the face's corner i is above."""
    return sum(((code >> int(corner)) & 1) << i for i, corner in enumerate(FACE_CORNERS[face]))


def ambiguous_faces(code: int) -> int:
    """A bit for each face whose corners are above and below by turns."""
    return sum(1 << face for face in range(6) if around_face(code, face) in (5, 10))


def polygons(code: int, joined: int, cell: Cell) -> int:
    """The closed polygons around the cell, the side above on the right as seen from outside; their number.

    Parameters
    ----------
    code : bits of the corners above
    joined : bits of the ambiguous faces whose corners 0 and 2 are joined
    cell : gets loop, face, slot, start and arc
    """
    after: dict[int, tuple[int, int, int]] = {}  # of each edge: the next one, face, slot
    for face in range(6):
        for slot, (i, j) in enumerate(_arcs(around_face(code, face), (joined >> face) & 1)):
            edge, following = _directed(face, i, j, around_face(code, face))
            after[edge] = following, face, slot
    cell["arc"] = -1
    found, n = 0, 0
    for first in range(12):
        edge = first
        cell["start"][found] = n
        while edge in after:
            following, face, slot = after.pop(edge)
            cell["loop"][n], cell["face"][n], cell["slot"][n] = edge, face, slot
            cell["arc"][face, slot] = edge, following, found
            n, edge = n + 1, following
        if n > cell["start"][found]:
            found += 1
    cell["start"][found] = n
    return found


def _arcs(around: int, joined: int) -> list[tuple[int, int]]:
    """The edges, numbered around a face, between which its arcs run."""
    if around in (5, 10):
        return [(0, 1), (2, 3)] if joined else [(3, 0), (1, 2)]
    cut = [i for i in range(4) if ((around >> i) ^ (around >> ((i + 1) % 4))) & 1]
    return [(cut[0], cut[1])] if cut else []


def _directed(face: int, i: int, j: int, around: int) -> tuple[int, int]:
    """The edges of an arc as the polygon runs; going from i to j, corner i + 1 is on the right."""
    outward = (face % 2 == 1) == (face // 2 != 1)  # the face runs counter-clockwise as seen from outside
    if (((around >> ((i + 1) % 4)) & 1) == 1) != outward:
        i, j = j, i
    return int(FACE_EDGES[face, i]), int(FACE_EDGES[face, j])


class Polygons(NamedTuple):
    """The polygons of all codes.

    Attributes
    ----------
    row : (256 * 64,) where those of a code and bits of its joined faces are
    shape : (n, 79) their number; loop, face, slot, start and arc as in `CELL`
    ambiguous : (256,) a bit for each ambiguous face
    """

    row: npt.NDArray[np.int16]
    shape: npt.NDArray[np.int8]
    ambiguous: Bytes


@functools.cache
def all_polygons() -> Polygons:
    """The polygons of all codes, by `polygons`."""
    cell, rows = new_cell(), np.zeros(256 * 64, np.int16)
    shapes, ambiguous = [np.zeros(79, np.int8)], np.array([ambiguous_faces(code) for code in range(256)], np.uint8)
    for code in range(1, 255):
        faces = int(ambiguous[code])
        joined = faces
        while True:
            found = polygons(code, joined, cell)
            parts = [cell[name].ravel() for name in ("loop", "face", "slot", "start", "arc")]
            rows[64 * code + joined] = len(shapes)
            shapes.append(np.concatenate([[found], *parts]).astype(np.int8))
            if not joined:
                break
            joined = (joined - 1) & faces
    return Polygons(rows, np.array(shapes), ambiguous)


@lean_part
def take_polygons(cell: Cell, shape: npt.NDArray[np.int8]) -> int:
    """Put a row of `Polygons.shape` into a cell; the number of polygons."""
    for n in range(12):
        cell.loop[n], cell.face[n], cell.slot[n] = shape[1 + n], shape[13 + n], shape[25 + n]
    for n in range(6):
        cell.start[n] = shape[37 + n]
        for slot in range(2):
            for m in range(3):
                cell.arc[n, slot, m] = shape[43 + 6 * n + 3 * slot + m]
    number: int = shape[0]
    return number


@lean_part
def bent_back(cell: Cell, polygon: int) -> int:
    """A bit for each axis on a face of which the polygon has two arcs (a loop-back face)."""
    axes = 0
    for face in range(6):
        if cell.arc[face, 0, 2] == polygon and cell.arc[face, 1, 2] == polygon:
            axes |= 1 << (face // 2)
    return axes


@lean
def shoulder_faces(cell: Cell, polygon: int) -> tuple[int, int]:
    """The two faces, on other axes, between which the bi-shoulder point is sought: opposite pairs first.

    Source: thesis 4.2.2.2; the first that its rule admits.
    """
    has = 0
    for face in range(6):
        has |= (cell.arc[face, 0, 2] == polygon or cell.arc[face, 1, 2] == polygon) << face
    first, second = -1, -1
    for single in range(2):
        for face in range(6):
            if first < 0 and (has >> face) & 1 and (single or (has >> (face ^ 1)) & 1):
                first = face
    for single in range(2):
        for face in range(6):
            if second < 0 and face // 2 != first // 2 and (has >> face) & 1 and (single or (has >> (face ^ 1)) & 1):
                second = face
    return first, second


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
