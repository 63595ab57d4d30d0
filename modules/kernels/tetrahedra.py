"""Marching tetrahedra: the surface of a field that is linear in tetrahedra, which is exact for it.

A grid's cells are cut in 5, 6, 12 or 24 tetrahedra, so that neighbours agree on their common face. The linear pieces are
not the trilinear field, and which way the diagonals run shows in the surface: this is for comparison (Lopes 1999, 4.1.1).

Rules: a node on the level counts as above it, normals point to the low side, vertices are known by the two nodes of their
edge.

Source: Doi and Koide 1991; Carr, Theussl and Moeller 2003 (the cuts).
"""

import functools
import itertools
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.straight import Mesh, active, place

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

PIECES = (5, 6, 12, 24)
"""In how many tetrahedra a cell may be cut."""


@functools.cache
def _cases() -> Integers:
    """(16, 2, 3, 2) for each pattern of corners above (bit i: corner i): triangles of edges of two corners; -1: none."""
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    cases = np.full((16, 2, 3, 2), -1, np.int64)
    for code in range(1, 15):
        up = [c for c in range(4) if code >> c & 1]
        down = [c for c in range(4) if not code >> c & 1]
        if len(up) == 2:
            (a, b), (c, d) = up, down
            found = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        else:
            found = [[(u, d) for u in up for d in down]]
        to_low = corner[down].mean(axis=0) - corner[up].mean(axis=0)
        for n, triangle in enumerate(found):
            p, q, r = (corner[list(edge)].mean(axis=0) for edge in triangle)
            turned = triangle if np.cross(q - p, r - p) @ to_low > 0 else triangle[::-1]
            cases[code, n] = [sorted(edge) for edge in turned]
    return cases


class Linear(NamedTuple):
    """A surface, and how its points come about.

    Attributes
    ----------
    mesh
        Its cells are tetrahedra.
    ends : (n, 2)
        The nodes between which each point lies.
    share : (n,)
        How far from the first to the second.
    """

    mesh: Mesh
    ends: Integers
    share: Floats


def surface(nodes: Floats, tetrahedra: Integers, values: Floats, level: float) -> Linear:
    """The surface F = level of a field that is linear in each tetrahedron.

    Parameters
    ----------
    nodes : (n, 3)
    tetrahedra : (t, 4)
        Nodes, in either sense.
    values : (n,)
        At the nodes. Not finite: a hole.

    Returns
    -------
    Linear

    Accuracy: exact for the linear field, to rounding.
    """
    above = values >= level
    code = (above[tetrahedra] * np.array([1, 2, 4, 8])).sum(axis=1)
    at = np.flatnonzero((code > 0) & (code < 15) & np.isfinite(values[tetrahedra]).all(axis=1))
    corner = tetrahedra[at]
    p = nodes[corner]
    turned = np.linalg.det(p[:, 1:] - p[:, :1]) < 0
    corner[turned] = corner[turned][:, [0, 1, 3, 2]]
    found = _cases()[(above[corner] * np.array([1, 2, 4, 8])).sum(axis=1)]
    row, which = np.nonzero(found[:, :, 0, 0] >= 0)
    ends = np.sort(corner[row[:, None, None], found[row, which]], axis=2)
    keys, triangles = np.unique(ends[..., 0] * len(nodes) + ends[..., 1], return_inverse=True)
    low, high = np.divmod(keys, len(nodes))
    t = np.clip((level - values[low]) / (values[high] - values[low]), 0.0, 1.0)
    points = nodes[low] + t[:, None] * (nodes[high] - nodes[low])
    return Linear(Mesh(points, triangles.reshape(-1, 3), at[row]), np.column_stack([low, high]), t)


def cut_grid(
    values: Floats, axes: tuple[Floats, Floats, Floats], level: float, pieces: int
) -> tuple[Floats, Integers, Floats, Integers]:
    """The cells of a grid that a level passes, cut in tetrahedra.

    Parameters
    ----------
    values : (nz, ny, nx)
    axes : along x, y, z
    pieces : 5 (alternating), 6 (around a diagonal), 12 (to the middle), 24 (to the middle and those of the faces)

    Returns
    -------
    (n, 3), (t, 4), (n,), (t,)
        Nodes, tetrahedra, values, and the cell of each tetrahedron. Middles of cells and faces have the mean of their
        corners, which is the trilinear field's value there.
    """
    found = active(values, level)
    _, ny, nx = values.shape
    low = found.node[:, 0]
    odd = (low % nx + low // nx % ny + low // (nx * ny)) % 2 == 1
    if pieces == 5:
        corner = np.where(odd[:, None, None], found.node[:, _five()[1]], found.node[:, _five()[0]])
        keys = corner
    elif pieces == 6:
        keys = found.node[:, _six()]
    else:
        keys = _about_the_middle(found.node, (nx, nx * ny), values.size, pieces)
    known, tetrahedra = np.unique(keys, return_inverse=True)
    nodes, at = _middles(known, values, axes)
    return nodes, tetrahedra.reshape(-1, 4), at, np.repeat(found.cell, keys.shape[1])


@functools.cache
def _five() -> tuple[Integers, Integers]:
    """Four corners cut off and a tetrahedron between them, in both ways."""
    ways = []
    for parity in (0, 1):
        middle = [c for c in range(8) if c.bit_count() % 2 == parity]
        rest = [[c, c ^ 1, c ^ 2, c ^ 4] for c in range(8) if c.bit_count() % 2 != parity]
        ways.append(np.array([middle, *rest]))
    return ways[0], ways[1]


@functools.cache
def _six() -> Integers:
    """Around the diagonal from 000 to 111: one for each order of the axes (Kuhn, Freudenthal)."""
    return np.array([[0, p, p | q, 7] for p, q, _ in itertools.permutations((1, 2, 4))])


def _about_the_middle(node: Integers, steps: tuple[int, int], size: int, pieces: int) -> Integers:
    """(c, 12 or 24, 4) from the middle of each cell to half or quarter faces.

    Keys: a node; size + node for the middle of the cell from there; (2 + axis) size + node for that of the face.
    """
    middle, found = size + node[:, 0], []
    for axis in range(3):
        p, q = (4 >> a for a in range(3) if a != axis)
        for side in (0, 1):
            first = side * (4 >> axis)
            around = [node[:, first + c] for c in (0, p, p + q, q)]
            centre = (2 + axis) * size + around[0]
            if pieces == 24:
                found += [np.stack([middle, centre, around[n], around[(n + 1) % 4]], axis=1) for n in range(4)]
            else:
                found += [np.stack([middle, around[0], around[n], around[n + 1]], axis=1) for n in (1, 2)]
    return np.stack(found, axis=1)


def _middles(known: Integers, values: Floats, axes: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    """Places and values of nodes and middles by their keys."""
    kind, low = np.divmod(known, values.size)
    _, ny, nx = values.shape
    step = np.array([1, nx, nx * ny])
    points, at = place(low, values.shape, axes), values.ravel()[low]
    for k in range(1, 5):
        mine = kind == k
        across = [a for a in range(3) if k == 1 or a != k - 2]
        corners = [sum(step[a] for a in some) for n in range(len(across) + 1) for some in itertools.combinations(across, n)]
        ids = low[mine][:, None] + np.array(corners, np.int64)
        at[mine] = values.ravel()[ids].mean(axis=1)
        points[mine] = 0.5 * (points[mine] + place(ids[:, -1], values.shape, axes))
    return points, at


def grid_surface(values: Floats, x: Floats, y: Floats, z: Floats, level: float, pieces: int) -> Mesh:
    """The surface F = level on a grid whose cells are cut in 5, 6, 12 or 24 tetrahedra.

    Accuracy: exact for the linear pieces; how far these are from the trilinear field is not told here.
    """
    nodes, tetrahedra, at, cell = cut_grid(values, (x, y, z), level, pieces)
    mesh = surface(nodes, tetrahedra, at, level).mesh
    return Mesh(mesh.points, mesh.triangles, cell[mesh.cell])
