"""A mesh of an isosurface refined to a tolerance: edges of triangles that are too far are cut at points on the surface.

An edge between two cells, or on the border, lies in a face and is cut once, at the shoulder point of the arc above it: both
cells see the same bilinear face, so they stay joined. An edge within a cell is cut where the line through its middle along
the gradient meets the surface. Cutting an edge never changes the topology.

Source: shoulder points, Lopes 1999, 3.3 in division-free form; the stop is a proof [mesh_proof].
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import lean, lean_inlined
from modules.kernels.marching_cases import Floats, Integers, index
from modules.kernels.marching_distance import corners
from modules.kernels.mesh_proof import Field, Slabs, reaches, slope_in, value_in

MOST_CUTS = 2
"""Of a triangle, one within another, before folds are looked for."""

INSIDE = 2.0**-20
"""Of a cell: new points within it stay so far from its faces."""

STRAIGHT = 0.25
"""Of the tolerance: where no edge is farther than this from the surface, the longest one is cut."""

MOST_AWAY = 0.5
"""Of an edge: a point of the surface that is farther from its middle belongs to another part."""

HALVINGS = 60
STEPS = 5
"""A zero is sought at 1/16, 1/8, ... of the way."""

EDGES_A_SLAB = 1 << 13


Bools = npt.NDArray[np.bool_]


class Mesh(NamedTuple):
    """Triangles within cells of a grid.

    Attributes
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,)
    reach : (m,) proven distance from the surface
    """

    points: Floats
    triangles: Integers
    cell: Integers
    reach: Floats


@lean_inlined
def _share(p: float, q: float) -> float:
    """Weight of the second of two ends whose slopes across are p and q."""
    a, b = math.sqrt(abs(p)), math.sqrt(abs(q))
    return a / (a + b) if a + b > 0 else 0.5


@lean_inlined
def _shoulder(f: Floats, axis: int, s: Floats, t: Floats, low: Floats, size: Floats) -> None:
    """The shoulder point of the arc above s t (both (3,), in a face across the axis) put into s.

    f holds the cell's corners, low and size where it begins and how large it is.
    """
    b, c = (axis + 1) % 3, (axis + 2) % 3
    up = 1 if s[axis] - low[axis] > 0.5 * size[axis] else 0
    # corners of the face: bit of axis x is 4, of y 2, of z 1
    one, two, base = 4 >> b, 4 >> c, up * (4 >> axis)
    f00, f10, f01, f11 = f[base], f[base + one], f[base + two], f[base + one + two]
    sb, sc = (s[b] - low[b]) / size[b], (s[c] - low[c]) / size[c]
    tb, tc = (t[b] - low[b]) / size[b], (t[c] - low[c]) / size[c]
    u = _share((1 - sb) * (f01 - f00) + sb * (f11 - f10), (1 - tb) * (f01 - f00) + tb * (f11 - f10))
    v = _share((1 - sc) * (f10 - f00) + sc * (f11 - f01), (1 - tc) * (f10 - f00) + tc * (f11 - f01))
    s[b] += u * (t[b] - s[b])
    s[c] += v * (t[c] - s[c])


@lean_inlined
def _along(f: Floats, level: float, at: Floats, d: Floats, low: Floats, size: Floats, s: float) -> float:
    """F - level so far along a direction."""
    u, v, w = at[0] + s * d[0] - low[0], at[1] + s * d[1] - low[1], at[2] + s * d[2] - low[2]
    return value_in(f, u / size[0], v / size[1], w / size[2]) - level


@lean_inlined
def _leaves(at: Floats, d: Floats, low: Floats, size: Floats, sign: float, most: float) -> float:
    """How far along a direction, or back, one may go within the cell."""
    far = most
    for a in range(3):
        step = sign * d[a]
        if step > 0:
            far = min(far, (low[a] + (1.0 - INSIDE) * size[a] - at[a]) / step)
        elif step < 0:
            far = min(far, (low[a] + INSIDE * size[a] - at[a]) / step)
    return far


@lean
def on_surface(f: Floats, level: float, at: Floats, d: Floats, low: Floats, size: Floats, most: float) -> bool:
    """Move a place (3,) within a cell along a unit direction (3,), or back, to a zero of F - level; whether there is one.

    Sought within the cell and no farther than `most`, near first; the bracket is then halved.
    """
    start = _along(f, level, at, d, low, size, 0.0)
    if start == 0.0:
        return True
    ahead, behind = _leaves(at, d, low, size, 1.0, most), _leaves(at, d, low, size, -1.0, most)
    near_ahead, near_behind = 0.0, 0.0
    for n in range(2 * STEPS):
        sign, far = (1.0, ahead) if n % 2 == 0 else (-1.0, behind)
        if not far > 0:
            continue
        there, near = far / (1 << (STEPS - 1 - n // 2)), near_ahead if n % 2 == 0 else near_behind
        if (_along(f, level, at, d, low, size, sign * there) > 0) == (start > 0):
            if n % 2 == 0:
                near_ahead = there
            else:
                near_behind = there
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (near + there)
            if middle == near or middle == there:
                break
            if (_along(f, level, at, d, low, size, sign * middle) > 0) == (start > 0):
                near = middle
            else:
                there = middle
        for a in range(3):
            at[a] += sign * there * d[a]
        return True
    return False


@lean
def _inward(f: Floats, level: float, at: Floats, d: Floats, low: Floats, size: Floats, most: float) -> bool:
    """Move a place to the surface along a gradient d; where that leaves the cell, along the faces that are near."""
    for _ in range(3):
        steep = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
        if not steep > 0:
            return False
        for a in range(3):
            d[a] /= steep
        if on_surface(f, level, at, d, low, size, most):
            return True
        near, which = 2.0, 0
        for a in range(3):
            gap = min(at[a] - low[a], low[a] + size[a] - at[a]) / size[a]
            if d[a] != 0.0 and gap < near:
                near, which = gap, a
        d[which] = 0.0
    return False


@lean
def _cuts(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats, edge: Integers, cell: Integers,
    axis: Integers, first: int, last: int, new: Floats, away: Floats, room: Floats,
) -> None:
    """New points of edges first to last - 1, and how far they lie from the edge; -1 where none was found."""
    f, low, size, s, t, d = room[0:8], room[8:11], room[11:14], room[14:17], room[17:20], room[20:23]
    for m in range(first, last):
        i, row = cell[m] % (x.size - 1), cell[m] // (x.size - 1)
        j, k = row % (y.size - 1), row // (y.size - 1)
        corners(values, x.size, y.size, i, j, k, f)
        low[0], low[1], low[2] = x[i], y[j], z[k]
        size[0], size[1], size[2] = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
        length = 0.0
        for a in range(3):
            s[a], t[a] = point[index(edge[m, 0]), a], point[index(edge[m, 1]), a]
            length += (t[a] - s[a]) ** 2
        found = True
        if axis[m] >= 0:
            _shoulder(f, axis[m], s, t, low, size)
        else:
            for a in range(3):
                s[a] = 0.5 * (s[a] + t[a])
            u, v, w = (s[0] - low[0]) / size[0], (s[1] - low[1]) / size[1], (s[2] - low[2]) / size[2]
            slope_in(f, u, v, w, size, d)
            found = _inward(f, level, s, d, low, size, MOST_AWAY * math.sqrt(length))
        way = 0.0
        for a in range(3):
            d[a] = t[a] - point[index(edge[m, 0]), a]
            way += d[a] * (s[a] - point[index(edge[m, 0]), a])
        share, gap = way / length if length > 0 else 0.0, 0.0
        for a in range(3):
            new[m, a] = s[a]
            gap += (s[a] - point[index(edge[m, 0]), a] - share * d[a]) ** 2
        away[m] = math.sqrt(gap) if found and 0.0 < share < 1.0 else -1.0


def planes(field: Field, points: Floats) -> Integers:
    """(n,) bits 1, 2, 4: the point lies on a plane of the grid across x, y, z."""
    on = [np.isin(points[:, a], axis) << a for a, axis in enumerate((field.x, field.y, field.z))]
    return np.asarray(on[0] | on[1] | on[2], np.int64)


class Edges(NamedTuple):
    """The edges of some triangles, each once.

    Attributes
    ----------
    ends : (e, 2) points, the lower first
    cell : (e,) of a triangle beside it
    axis : (e,) across which the face lies that holds it; -1 within a cell
    of : (m, 3) edge of each side of each triangle
    """

    ends: Integers
    cell: Integers
    axis: Integers
    of: Integers


def edges_of(field: Field, points: Floats, triangles: Integers, cell: Integers) -> Edges:
    """The edges of all triangles; side c runs from corner c to the next."""
    pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    key = pairs[:, 0] * len(points) + pairs[:, 1]
    order = np.argsort(key, kind="stable")
    sorted_key, own = key[order], np.repeat(cell, 3)[order]
    start = np.flatnonzero(np.diff(sorted_key, prepend=-1))
    of = np.empty(len(key), np.int64)
    of[order] = np.repeat(np.arange(len(start)), np.diff(np.append(start, len(key))))
    ends, first = pairs[order[start]], own[start]
    alone = np.diff(np.append(start, len(key))) == 1
    other = np.where(alone, -1, own[np.minimum(start + 1, len(key) - 1)]) if len(key) else first
    outer = np.flatnonzero(other != first)
    p, q = points[ends[outer, 0]], points[ends[outer, 1]]
    shared = planes(field, p) & planes(field, q)
    axis = np.full(len(ends), -1, np.int64)
    for a in (2, 1, 0):
        axis[outer[((shared >> a) & 1 > 0) & (p[:, a] == q[:, a])]] = a
    lost = outer[axis[outer] < 0]
    if len(lost):
        raise ValueError(f"{len(lost)} edges between cells lie in no face: wire a surface whose triangles lie in cells")
    return Edges(ends, first, axis, of.reshape(-1, 3))


def cut_points(
    field: Field, points: Floats, edges: Edges, which: Integers, slabs: Slabs | None = None
) -> tuple[Floats, Floats]:
    """(k, 3) points at which some edges are cut, and (k,) how far they lie from the edge; -1 where there is none."""
    ends, cell, axis = (np.ascontiguousarray(a[which]) for a in (edges.ends, edges.cell, edges.axis))
    new, away, at = np.empty((len(which), 3)), np.empty(len(which)), np.ascontiguousarray(points)

    def some(first: int) -> None:
        _cuts(*field.given, at, ends, cell, axis, first, min(first + EDGES_A_SLAB, len(which)), new, away, np.empty(23))

    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    each(some, range(0, len(which), EDGES_A_SLAB))
    return new, away


def cut(
    field: Field, mesh: Mesh, tolerance: float, most: int, *, left: Integers | None = None, slabs: Slabs | None = None
) -> Mesh:
    """The mesh with triangles cut until each is within the tolerance, or `MOST_CUTS` times.

    Parameters
    ----------
    mesh : its triangles whose reach is beyond the tolerance are looked at
    tolerance : distance, as `Field.asked` gives it
    most : triangles
    left : cells whose triangles are left as they are, but for cuts on their faces

    Raises
    ------
    ValueError : there would be more triangles than `most`
    """
    points, triangles, cell, reach = mesh
    depth = np.where(np.isin(cell, left), MOST_CUTS, 0) if left is not None else np.zeros(len(triangles), np.int64)
    while True:
        far = (reach > tolerance) & (depth < MOST_CUTS)
        if not far.any():
            return Mesh(points, triangles, cell, reach)
        edges = edges_of(field, points, triangles, cell)
        asked = np.unique(edges.of[far])
        new, away = cut_points(field, points, edges, asked, slabs)
        chosen = _chosen(points, edges, far, asked, away, tolerance)
        at = np.full(len(edges.ends), -1, np.int64)
        at[asked[chosen]] = len(points) + np.arange(len(chosen))
        depth[far & (at[edges.of] < 0).all(axis=1)] = MOST_CUTS  # no edge of it can be cut
        points = np.concatenate([points, new[chosen]])
        parent, made = pieces(triangles, at[edges.of], points)
        if len(made) > most:
            raise ValueError(
                f"more than {most} triangles would be needed: choose a larger tolerance, a larger limit, or a part of the grid"
            )
        changed = np.bincount(parent, minlength=len(triangles))[parent] > 1
        triangles, cell, reach, depth = made, cell[parent], reach[parent], depth[parent] + changed
        which = np.flatnonzero(changed)
        reach[which] = reaches(field, points, triangles, cell, tolerance, which=which, slabs=slabs)


def _chosen(points: Floats, edges: Edges, far: Bools, asked: Integers, away: Floats, tolerance: float) -> Integers:
    """Which of the asked edges are cut: of each triangle that is too far the farthest, and those beyond the tolerance."""
    gap = np.full(len(edges.ends), -1.0)
    gap[asked] = away
    length = np.linalg.norm(points[edges.ends[:, 0]] - points[edges.ends[:, 1]], axis=1)
    sides = edges.of[far]
    mine = gap[sides]
    bent = mine.max(axis=1) >= STRAIGHT * tolerance
    mine = np.where(bent[:, None] | (mine < 0), mine, length[sides])
    best = sides[np.arange(len(sides)), mine.argmax(axis=1)]
    wanted = np.zeros(len(edges.ends), bool)
    wanted[best] = True
    wanted &= gap >= 0
    wanted |= gap > tolerance
    return np.flatnonzero(wanted[asked])


def pieces(triangles: Integers, new: Integers, points: Floats) -> tuple[Integers, Integers]:
    """Triangles cut at new points on their sides: which each was, and its corners.

    Parameters
    ----------
    triangles : (m, 3)
    new : (m, 3) the point on the side from each corner to the next; -1 for none
    points : (n, 3)
    """
    count = (new >= 0).sum(axis=1)
    rows = np.arange(len(triangles))
    parents, made = [rows[count == 0]], [triangles[count == 0]]
    for n in (1, 2, 3):
        which = rows[count == n]
        # turned so that the first side is cut, and with two cuts the second too
        whole, odd = new[which] < 0, (new[which] < 0) == (n == 2)
        turn = odd.argmax(axis=1) + (n == 2) if n < 3 else whole.argmax(axis=1)
        at = (turn[:, None] + np.arange(3)) % 3
        (a, b, c), (p, q, r) = (np.take_along_axis(array[which], at, axis=1).T for array in (triangles, new))
        if n == 1:
            parts = [(a, p, c), (p, b, c)]
        elif n == 2:
            long = np.linalg.norm(points[a] - points[q], axis=1) > np.linalg.norm(points[p] - points[c], axis=1)
            parts = [(p, b, q), (a, p, np.where(long, c, q)), (np.where(long, p, a), q, c)]
        else:
            parts = [(a, p, r), (p, b, q), (q, c, r), (p, q, r)]
        for part in parts:
            parents.append(which)
            made.append(np.column_stack(part))
    parent = np.concatenate(parents)
    order = np.argsort(parent, kind="stable")
    return parent[order], np.ascontiguousarray(np.concatenate(made)[order])


def warm() -> None:
    """Compile the kernels of this file."""
    axis = np.arange(2.0)
    field = Field(np.array([0.0, 1, 1, 2, 1, 2, 2, 4]).reshape(2, 2, 2), axis, axis, axis, 0.5)
    points = np.array([[0.0, 0, 0.5], [0.5, 0, 0], [0, 0.5, 0]])
    cut(field, Mesh(points, np.array([[0, 2, 1]]), np.array([0]), np.full(1, np.inf)), 1e-3, 10**6)
