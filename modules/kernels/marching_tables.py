"""What is known of a cell from its code alone: its vertices, which of them are new, its polygon, the arcs on its faces.

The cells come row by row. A vertex is made by the first cell that has it; that is known from which of the nine earlier
neighbours that share an edge or a face with the cell exist.
"""

import functools
from typing import NamedTuple

import numpy as np

from modules.kernels.marching_cases import (
    ACROSS,
    EDGE_ENDS,
    FACE_CORNERS,
    Bytes,
    Integers,
    Masks,
    ambiguous_faces,
    around_face,
    new_cell,
    polygons,
    shoulder_faces,
)

EARLIER = ((-1, 0, 0), (0, -1, 0), (0, 0, -1), (-1, -1, 0), (1, -1, 0), (-1, 0, -1), (1, 0, -1), (0, -1, -1), (0, 1, -1))
"""Steps in x, y, z to the earlier neighbours that share an edge or a face."""

AMBIGUOUS = 2
"""The kind of a face with two arcs; 0: its arc joins opposite edges, 1: it cuts off a corner."""


class Tables(NamedTuple):
    """One row or item a code.

    Attributes
    ----------
    used : (256,) bits of the 24 vertices on edges and faces
    shared : (9,) bits of the vertices shared with each earlier neighbour
    open : (8,) bits of the vertices that are new where the cell is the first in x (1), y (2), z (4)
    ones, lowest : (4096,) number of bits set, and the lowest of them
    sides : (256,) crossings of the one polygon; 0: the cell has several, or an ambiguous face
    around : (256, 12) vertices of the one polygon
    turned : (256, 8) corners, and (256, 3) axes, in the order in which the bi-shoulder point is sought
    axes : see turned
    start : (256, 2) number of crossings, and of those at the far end of the first axis
    face : (256, 6, 8) of the one arc on a face: four corners, its own first; kind; the two axes
    """

    used: Masks
    shared: Masks
    open: Masks
    ones: Bytes
    lowest: Bytes
    sides: Bytes
    around: Bytes
    turned: Bytes
    axes: Bytes
    start: Bytes
    face: Bytes


def _shared() -> Masks:
    """Bits of the vertices that a cell has in common with each earlier neighbour."""
    shared = np.zeros(9, np.int32)
    for n, step in enumerate(EARLIER):
        for edge in range(12):
            ends = [[(c >> 2) & 1, (c >> 1) & 1, c & 1] for c in EDGE_ENDS[edge]]
            if all(all(0 <= place - s <= 1 for place, s in zip(end, step, strict=True)) for end in ends):
                shared[n] |= 1 << edge
        for face in range(6):
            if sum(map(abs, step)) == 1 and step[face // 2] == 2 * (face % 2) - 1:
                shared[n] |= 3 << (12 + 2 * face)
    return shared


def _open(shared: Masks) -> Masks:
    new = np.full(8, (1 << 24) - 1, np.int32)
    for border in range(8):
        for n, step in enumerate(EARLIER):
            if not any(s < 0 and (border >> axis) & 1 for axis, s in enumerate(step)):
                new[border] &= ~shared[n]
    return new


def _face_rows(code: int) -> Integers:
    """Of each face: four corners, of which the first is cut off or starts a cut edge; kind; the axes to the next two."""
    rows = np.zeros((6, 8), np.int64)
    for face in range(6):
        around, corners, (p, q) = around_face(code, face), FACE_CORNERS[face], ACROSS[face // 2]
        differs = [((around >> i) ^ (around >> ((i + 1) % 4))) & 1 for i in range(4)]  # edge i is cut
        if sum(differs) == 4:
            rows[face, 4] = AMBIGUOUS
        if sum(differs) != 2:
            continue
        if differs[0] != differs[2]:
            own = next(i for i in range(4) if differs[i] and differs[i - 1])
            along = q if own % 2 else p  # from a corner to the next one around
            rows[face, :4] = corners[[own, (own + 1) % 4, (own + 3) % 4, (own + 2) % 4]]
            rows[face, 4:7] = 1, along, p + q - along
        elif differs[1]:  # between the edges across p
            rows[face, :4] = corners[[0, 1, 3, 2]]
            rows[face, 4:7] = 0, p, q
        else:
            rows[face, :4] = corners[[0, 3, 1, 2]]
            rows[face, 4:7] = 0, q, p
    return rows


@functools.cache
def tables() -> Tables:
    """The tables, made from `marching_cases.polygons`."""
    cell, shared = new_cell(), _shared()
    used = np.zeros(256, np.int32)
    sides, around = np.zeros(256, np.uint8), np.zeros((256, 12), np.uint8)
    turned, axes, start = np.zeros((256, 8), np.uint8), np.zeros((256, 3), np.uint8), np.zeros((256, 2), np.uint8)
    face = np.zeros((256, 6, 8), np.uint8)
    for code in range(1, 255):
        found, n = polygons(code, 0, cell), 0
        n = int(cell["start"][found])
        edges, faces = cell["loop"][:n], cell["face"][:n]
        for edge, f, slot in zip(edges, faces, cell["slot"][:n], strict=True):
            used[code] |= 1 << int(edge) | 1 << (12 + 2 * int(f) + int(slot))
        face[code] = _face_rows(code)
        if found != 1 or ambiguous_faces(code):
            continue
        sides[code] = n
        around[code, : 2 * n : 2], around[code, 1 : 2 * n : 2] = edges, 12 + 2 * faces
        first, second = (f // 2 for f in shoulder_faces(cell, 0))
        axes[code] = first, second, 3 - first - second
        steps = [4 >> int(axis) for axis in axes[code]]
        turned[code] = [sum(s for s, bit in zip(steps, (4, 2, 1), strict=True) if c & bit) for c in range(8)]
        across = [e for e in edges if e // 4 != first]
        start[code] = n, sum(bool(int(EDGE_ENDS[e, 0]) & steps[0]) for e in across)
    bits = np.array([[(m >> b) & 1 for b in range(12)] for m in range(4096)], np.uint8)
    ones, lowest = bits.sum(axis=1, dtype=np.uint8), bits.argmax(axis=1).astype(np.uint8)
    return Tables(
        used, shared, _open(shared), ones, lowest, sides, around.ravel(), turned.ravel(), axes.ravel(), start.ravel(),
        face.ravel(),
    )  # fmt: skip
