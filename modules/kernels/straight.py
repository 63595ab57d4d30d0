"""Marching cubes with straight polygons: one table of cells, three rules for ambiguous faces.

Rules
-----
- `classic`: the fifteen cases of 1987. The corners of which a cell has at most four are cut off, so two cells may cut a
  common face differently: the surface has holes.
- `decider`: the asymptotic decider on each face (exact): as the trilinear interpolant, no hole; tunnels are not seen.
- `four_triangles`: the mean of a face's corners decides: no hole, but wrong where mean and saddle differ.

Polygons are cut by chords that lie in no face of the cell. Where there are none (Lopes 1999, proposition 4.1.2.1) the mean
of its vertices becomes one more vertex. A node on the level counts as above; normals point to the low side.

Source: Lorensen and Cline 1987; Nielson and Hamann 1991; Wyvill, McPheeters and Wyvill 1986; Lopes 1999, section 4.1.
"""

import functools
from fractions import Fraction
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.marching_cases import ACROSS, EDGE_ENDS, FACE_CORNERS, new_cell, polygons

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Rule = Literal["classic", "decider", "four_triangles"]

CLEAR = 1e-14
"""Of its two products: a larger determinant has the right sign as it stands; a smaller one is told by fractions."""

EXTRA = 12
"""The first extra vertex of a cell, after its twelve edges."""


class Mesh(NamedTuple):
    """A surface of n points and m triangles.

    Attributes
    ----------
    points : (n, 3)
        x, y, z.
    triangles : (m, 3)
        Points; the right-handed normal points to the low side.
    cell : (m,)
        The grid cell of each triangle, row-major over (nz - 1, ny - 1, nx - 1).
    """

    points: Floats
    triangles: Integers
    cell: Integers


class Active(NamedTuple):
    """The cells of a grid that a surface passes.

    Attributes
    ----------
    cell : (c,)
        Numbers, row-major over (nz - 1, ny - 1, nx - 1).
    node : (c, 8)
        Numbers of the corners 000, 001, 010, ..., 111 of xyz.
    value : (c, 8)
        At the corners, as they were given.
    code : (c,)
        Bit i set where corner i is at or above the level.
    """

    cell: Integers
    node: Integers
    value: Floats
    code: Integers


def active(values: Floats, level: float) -> Active:
    """The cells with finite corners on both sides of a level."""
    nz, ny, nx = values.shape
    above = values >= level
    code = np.zeros((nz - 1, ny - 1, nx - 1), np.uint8)
    for c in range(8):
        x, y, z = c >> 2, (c >> 1) & 1, c & 1
        code |= above[z : nz - 1 + z, y : ny - 1 + y, x : nx - 1 + x].astype(np.uint8) << c
    cell = np.flatnonzero((code != 0) & (code != 255))
    row, i = np.divmod(cell, nx - 1)
    k, j = np.divmod(row, ny - 1)
    first = (k * ny + j) * nx + i
    steps = np.array([(c & 1) * ny * nx + ((c >> 1) & 1) * nx + (c >> 2) for c in range(8)])
    node = first[:, None] + steps
    value = values.ravel()[node]
    known = np.isfinite(value).all(axis=1)
    return Active(cell[known], node[known], value[known], code.ravel()[cell[known]].astype(np.int64))


def joined(found: Active, level: float, rule: Rule) -> Integers:
    """(c,) bits of the ambiguous faces whose corners 0 and 2 are joined."""
    bits = np.zeros(len(found.cell), np.int64)
    few = np.bitwise_count(found.code.astype(np.uint8)) <= 4
    for face in range(6):
        corner = FACE_CORNERS[face]
        side = (found.code[:, None] >> corner) & 1
        at = np.flatnonzero((side[:, 0] == side[:, 2]) & (side[:, 1] == side[:, 3]) & (side[:, 0] != side[:, 1]))
        first_above = side[at, 0] == 1
        if rule == "classic":
            cut_off_above = few[at]
            join = first_above != cut_off_above
        elif rule == "four_triangles":
            join = (found.value[at][:, corner].mean(axis=1) >= level) == first_above
        else:
            f = found.value[at][:, corner] - level
            join = _saddle_above(f, found.value[at][:, corner], level) == first_above
        bits[at] |= join.astype(np.int64) << face
    return bits


def _saddle_above(f: Floats, given: Floats, level: float) -> npt.NDArray[np.bool_]:
    """(n,) whether the saddle of ambiguous faces is at or above the level; f = values less the level, (n, 4) around."""
    one, two = f[:, 0] * f[:, 2], f[:, 1] * f[:, 3]
    joins = one > two
    for n in np.flatnonzero(~(np.abs(one - two) > CLEAR * (np.abs(one) + np.abs(two)))):
        p, q, r, s = (Fraction(float(v)) - Fraction(level) for v in given[n])
        exact = p * r - q * s
        joins[n] = exact > 0 or (exact == 0 and given[n, 0] >= level)
    result: npt.NDArray[np.bool_] = joins == (given[:, 0] >= level)
    return result


@functools.cache
def loops(code: int, faces: int) -> tuple[tuple[int, ...], ...]:
    """The polygons of a cell as lists of edges, the side above on the right as seen from outside."""
    cell = new_cell()
    number = polygons(code, faces, cell)
    start = cell["start"]
    return tuple(tuple(int(e) for e in cell["loop"][start[n] : start[n + 1]]) for n in range(number))


@functools.cache
def faces_of(edge: int) -> frozenset[int]:
    """The two faces at an edge."""
    axis, u, v = edge // 4, (edge // 2) % 2, edge % 2
    p, q = ACROSS[axis]
    return frozenset((int(2 * p + u), int(2 * q + v)))


@functools.cache
def cut(loop: tuple[int, ...]) -> tuple[tuple[int, int, int], ...] | None:
    """A polygon cut into triangles by chords that lie in no face of the cell; None if there is no such cut."""
    n = len(loop)

    @functools.cache
    def between(i: int, j: int) -> tuple[tuple[int, int, int], ...] | None:
        """The part between the vertices i and j > i."""
        if j == i + 1:
            return ()
        if (i, j) != (0, n - 1) and faces_of(loop[i]) & faces_of(loop[j]):
            return None
        for k in range(i + 1, j):
            low, high = between(i, k), between(k, j)
            if low is not None and high is not None:
                return (*low, (loop[i], loop[k], loop[j]), *high)
        return None

    return between(0, n - 1)


@functools.cache
def table(code: int, faces: int, centred: bool = False) -> tuple[tuple[tuple[int, int, int], ...], tuple[tuple[int, ...], ...]]:
    """The triangles of a cell over its edges and extra vertices, and the edges whose mean each extra vertex is.

    Parameters
    ----------
    centred : every polygon that cannot be cut gets an extra vertex; if not, it is cut as a fan, perhaps in a face
    """
    triangles: list[tuple[int, int, int]] = []
    extra: list[tuple[int, ...]] = []
    for loop in loops(code, faces):
        found = cut(loop)
        if found is not None:
            triangles += found
        elif centred:
            centre = EXTRA + len(extra)
            triangles += [(loop[n], loop[(n + 1) % len(loop)], centre) for n in range(len(loop))]
            extra.append(loop)
        else:
            triangles += [(loop[0], loop[n], loop[n + 1]) for n in range(1, len(loop) - 1)]
    return tuple(triangles), tuple(extra)


def surface(values: Floats, x: Floats, y: Floats, z: Floats, level: float, rule: Rule) -> Mesh:
    """The surface F = level in straight polygons.

    Parameters
    ----------
    values : (nz, ny, nx)
        At the nodes. Not finite: a hole.
    x, y, z : (nx,), (ny,), (nz,)
    rule
        For ambiguous faces.

    Returns
    -------
    Mesh

    Accuracy: crossings of edges to rounding; the rest is as far from the surface as a chord.
    """
    found = active(values, level)
    faces = joined(found, level, rule)
    kinds, which = np.unique(found.code * 64 + faces, return_inverse=True)
    keys, origin, extra = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    size, made = values.size, 0
    for kind, packed in enumerate(kinds.tolist()):
        cells = np.flatnonzero(which.ravel() == kind)
        triangles, means = table(packed // 64, packed % 64, centred=rule != "classic")
        local = np.empty((len(cells), EXTRA + len(means)), np.int64)
        ends = found.node[cells][:, EDGE_ENDS]
        local[:, :EXTRA] = 3 * ends[:, :, 0] + np.arange(12) // 4
        for n, loop in enumerate(means):
            local[:, EXTRA + n] = 3 * size + made + np.arange(len(cells))
            at = [_crossings(found.node[cells][:, EDGE_ENDS[e]], values, (x, y, z), level) for e in loop]
            extra.append(np.mean(at, axis=0))
            made += len(cells)
        keys.append(local[:, np.array(triangles)].reshape(-1, 3))
        origin.append(np.repeat(found.cell[cells], len(triangles)))
    return _mesh(np.concatenate(keys), np.concatenate(origin), np.concatenate(extra), values, (x, y, z), level)


def _mesh(
    keys: Integers, origin: Integers, extra: Floats, values: Floats, axes: tuple[Floats, ...], level: float
) -> Mesh:
    """The mesh of triangles over keys: 3 node + axis for a crossing, then the extra points."""
    order = np.argsort(origin, kind="stable")
    known, triangles = np.unique(keys[order].ravel(), return_inverse=True)
    crossing = known[known < 3 * values.size]
    _, ny, nx = values.shape
    low = crossing // 3
    high = low + np.array([1, nx, nx * ny])[crossing % 3]
    points = np.concatenate([_crossings(np.column_stack([low, high]), values, axes, level), extra])
    return Mesh(points, triangles.reshape(-1, 3), origin[order])


def _crossings(ends: Integers, values: Floats, axes: tuple[Floats, ...], level: float) -> Floats:
    """(n, 3) where F is at the level between two nodes of an edge."""
    f = values.ravel()[ends] - level
    t = np.clip(f[:, 0] / (f[:, 0] - f[:, 1]), 0.0, 1.0)[:, None]
    low, high = (place(ends[:, n], values.shape, axes) for n in (0, 1))
    return low + t * (high - low)


def place(nodes: Integers, shape: tuple[int, ...], axes: tuple[Floats, ...]) -> Floats:
    """(n, 3) x, y, z of some nodes of a grid of a shape [z, y, x]."""
    row, i = np.divmod(nodes, shape[2])
    k, j = np.divmod(row, shape[1])
    return np.column_stack([axes[0][i], axes[1][j], axes[2][k]])
