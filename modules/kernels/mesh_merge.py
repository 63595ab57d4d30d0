"""A mesh of an isosurface with fewer triangles, each still proven to be within a tolerance.

A point within a cell may be merged into any neighbour; one in a face into the next along its arc, so that both cells see
the same face; crossings of grid edges stay. What the merge makes must be proven, must lie in no face, and the two ends may
have no other common neighbours than those of their edge, so that the topology stays. An edge within a cell is turned to the
other diagonal where that lies nearer to the surface. The mesh remains one of triangles within cells.

Source: Lopes 1999, 4.5 (flat pairs at shoulder points merged); Hoppe 1993 and Dey 1999 (edges whose collapse keeps the
topology). The order, from small distances to the tolerance, is ours.
"""

import math
from typing import Any

import numpy as np

from modules.kernels._jit import lean, lean_inlined, lean_part
from modules.kernels.marching_cases import Floats, Integers
from modules.kernels.mesh_proof import FAR, ROOM, Field, within
from modules.kernels.mesh_split import Mesh, planes

SHARES = (0.05, 0.2, 0.5, 0.8, 1.0)
"""Of the tolerance: points whose removal costs little go first."""

PASSES = 3
RING = 64
"""A point with more triangles stays."""

BETTER = 0.9
"""An edge is turned where that brings the farther of its two triangles below this part of what it was."""


@lean_inlined
def _next(h: int) -> int:
    return h - 2 if h % 3 == 2 else h + 1


@lean_inlined
def _before(h: int) -> int:
    return h + 2 if h % 3 == 0 else h - 1


@lean_part
def _walk(corner: Integers, twin: Integers, start: int, ring: Integers, sides: Integers) -> int:
    """The half-edges that leave a point, one a triangle, and their ends; how many, or 0 for too many.

    An open ring has one end more than half-edges: sides[RING] is 1 then.
    """
    n, h = 0, start
    while n < RING - 1:
        sides[n], ring[n] = h, corner[_next(h)]
        n += 1
        back = _before(h)
        if twin[back] < 0:
            ring[n], sides[RING] = corner[back], 1
            return n
        h = twin[back]
        if h == start:
            sides[RING] = 0
            return n
    return 0


@lean_part
def _in_face(point: Floats, plane: Integers, p: int, q: int) -> bool:
    """Whether two points lie in one plane of the grid."""
    both = plane[p] & plane[q]
    if both == 0:
        return False
    for a in range(3):
        if (both >> a) & 1 and point[p, a] == point[q, a]:
            return True
    return False


@lean_inlined
def _place(point: Floats, a: int, b: int, c: int, p: Floats) -> None:
    for axis in range(3):
        p[axis], p[3 + axis], p[6 + axis] = point[a, axis], point[b, axis], point[c, axis]


@lean_part
def _common(ring: Integers, ends: int, other: Integers, others: int) -> int:
    count = 0
    for a in range(ends):
        for b in range(others):
            if ring[a] == other[b]:
                count += 1
    return count


@lean_part
def _may(
    point: Floats, plane: Integers, corner: Integers, twin: Integers, cell: Integers, m: int, n: int, ring: Integers,
    sides: Integers, other: Integers, other_sides: Integers, out: Integers,
) -> bool:
    """Whether a point may be merged into the m-th of its ring and all stays joined as it is."""
    opened = sides[RING] == 1
    u, v = corner[sides[0]], ring[m]
    beside = twin[sides[m]] if m < n else -1
    outer = beside < 0 or cell[sides[m] // 3] != cell[beside // 3]
    if plane[u] != 0 and not (outer and _in_face(point, plane, u, v)):
        return False
    if opened and beside >= 0:
        return False
    count = _walk(corner, twin, out[v], other, other_sides)
    ends, others = n + sides[RING], count + other_sides[RING]
    return count > 0 and _common(ring, ends, other, others) == (1 if beside < 0 else 2)


@lean_part
def _flat(
    point: Floats, plane: Integers, twin: Integers, cell: Integers, u: int, v: int, w: int, e: int
) -> bool:
    """Whether a new edge v w, in place of u w (half-edge e), would lie in a face though the arc of the face does not."""
    if not _in_face(point, plane, v, w):
        return False
    f = twin[e]
    return not ((f < 0 or cell[f // 3] != cell[e // 3]) and _in_face(point, plane, u, w))


@lean
def _cost(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, size: float, tolerance: float, point: Floats,
    plane: Integers, corner: Integers, twin: Integers, cell: Integers, m: int, n: int, ring: Integers, sides: Integers,
    other: Integers, other_sides: Integers, out: Integers, fresh: Floats, room: Floats,
) -> float:
    """The farthest of the triangles that would be there were a point merged into the m-th of its ring; infinite if it may not.

    fresh gets their distances, in the order of the ring; -1 for those that go.
    """
    if not _may(point, plane, corner, twin, cell, m, n, ring, sides, other, other_sides, out):
        return math.inf
    opened = sides[RING] == 1
    u, v, ends, worst = corner[sides[0]], ring[m], n + sides[RING], 0.0
    for a in range(n):
        h = sides[a]
        p, q = ring[a], ring[a + 1] if a + 1 < ends else ring[0]
        fresh[a] = -1.0
        if p == v or q == v:
            continue
        if not _joined(ring, ends, m, p, opened) and _flat(point, plane, twin, cell, u, v, p, h):
            return math.inf
        if not _joined(ring, ends, m, q, opened) and _flat(point, plane, twin, cell, u, v, q, _before(h)):
            return math.inf
        if plane[v] & plane[p] & plane[q] and _in_face(point, plane, v, p) and _in_face(point, plane, v, q):
            return math.inf
        _place(point, v, p, q, room[0:9])
        far = within(values, level, x, y, z, cell[h // 3], room[0:9], tolerance, size, room[9 : 9 + ROOM])
        if not far <= tolerance:
            return math.inf
        fresh[a] = far
        worst = max(worst, far)
    return worst


@lean_inlined
def _joined(ring: Integers, ends: int, m: int, w: int, opened: bool) -> bool:
    """Whether a point of a ring is next to its m-th: these two are joined already."""
    after, before = m + 1, m - 1
    if not opened:
        after, before = after % ends, (before + ends) % ends
    return (after < ends and ring[after] == w) or (before >= 0 and ring[before] == w)


@lean_inlined
def _glue(twin: Integers, a: int, b: int) -> None:
    if a >= 0:
        twin[a] = b
    if b >= 0:
        twin[b] = a


@lean_inlined
def _set(twin: Integers, h: int, other: int) -> None:
    """The half-edge beside one that is there; -1 for none."""
    twin[h] = other
    if other >= 0:
        twin[other] = h


@lean
def _merge(
    corner: Integers, twin: Integers, reach: Floats, out: Integers, stamp: Integers, m: int, n: int, ring: Integers,
    sides: Integers, fresh: Floats,
) -> None:
    """Merge a point into the m-th of its ring."""
    opened = sides[RING] == 1
    u, v = corner[sides[0]], ring[m]
    ends = n + 1 if opened else n
    for a in range(n):
        if fresh[a] >= 0.0:
            corner[sides[a]], reach[sides[a] // 3] = v, fresh[a]
    for a in range(n):
        if fresh[a] >= 0.0:
            continue
        h = sides[a]
        p, q = ring[a], ring[a + 1] if a + 1 < ends else ring[0]
        # the triangle u p q goes: its two sides that are not u v become one
        across, along = twin[_next(h)], twin[_before(h)] if p == v else twin[h]
        _glue(twin, across, along)
        keep = across if across >= 0 else along
        for c in range(3):
            corner[3 * (h // 3) + c] = -1
        w = q if p == v else p
        if keep >= 0:
            out[v] = keep if corner[keep] == v else _next(keep)
            out[w] = keep if corner[keep] == w else _next(keep)
    out[u] = -1
    for a in range(ends):
        w = ring[a]
        stamp[w] = 0
        _to_the_border(twin, out, w)


@lean_part
def _to_the_border(twin: Integers, out: Integers, w: int) -> None:
    """The half-edge at which the ring of a point begins: on the border if it has one."""
    start = out[w]
    h = start
    for _ in range(2 * RING):
        if twin[h] < 0:
            out[w] = h
            return
        h = _next(twin[h])
        if h == start:
            return


@lean_inlined
def _any_unproven(reach: Floats, sides: Integers, n: int) -> bool:
    for m in range(n):
        if reach[sides[m] // 3] == math.inf:
            return True
    return False


@lean
def _pass(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, size: float, tolerance: float, mark: int, point: Floats,
    plane: Integers, fixed: Integers, corner: Integers, twin: Integers, cell: Integers, reach: Floats, out: Integers,
    stamp: Integers, work: Integers, room: Floats, folds: bool,
) -> int:
    """Merge what may be merged, once through all points, or through those beside unproven triangles; how many were."""
    ring, sides, other, other_sides = work[0:65], work[65:130], work[130:195], work[195:260]
    fresh, best_fresh, rest = room[0:65], room[65:130], room[130 : 139 + ROOM]
    merged = 0
    for u in range(len(out)):
        if out[u] < 0 or fixed[u] != 0 or stamp[u] >= mark:
            continue
        n = _walk(corner, twin, out[u], ring, sides)
        stamp[u] = mark
        if n == 0 or (folds and not _any_unproven(reach, sides, n)):
            continue
        best, at = math.inf, -1
        for m in range(n + 1 if sides[RING] == 1 else n):
            cost = _cost(
                values, level, x, y, z, size, tolerance, point, plane, corner, twin, cell, m, n, ring, sides, other,
                other_sides, out, fresh, rest,
            )  # fmt: skip
            if cost < best:
                best, at = cost, m
                for a in range(n):
                    best_fresh[a] = fresh[a]
        if at >= 0:
            _merge(corner, twin, reach, out, stamp, at, n, ring, sides, best_fresh)
            merged += 1
    return merged


@lean
def _turn(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, size: float, tolerance: float, point: Floats,
    plane: Integers, corner: Integers, twin: Integers, cell: Integers, reach: Floats, out: Integers, stamp: Integers,
    work: Integers, room: Floats,
) -> int:
    """Turn edges within cells to the other diagonal where that is nearer to the surface; how many were."""
    ring, sides, p, rest = work[0:65], work[65:130], room[0:9], room[9 : 9 + ROOM]
    turned = 0
    for h in range(len(twin)):
        g = twin[h]
        if corner[h] < 0 or g < h or cell[h // 3] != cell[g // 3]:
            continue
        a, b = corner[h], corner[g]
        c, d = corner[_before(h)], corner[_before(g)]
        before = max(reach[h // 3], reach[g // 3])
        if c == d or before < 0.1 * tolerance or _in_face(point, plane, c, d):
            continue
        if _walk(corner, twin, out[a], ring, sides) <= 3 or _walk(corner, twin, out[b], ring, sides) <= 3:
            continue
        n = _walk(corner, twin, out[c], ring, sides)
        known = n == 0
        for m in range(n + sides[RING]):
            known = known or ring[m] == d
        if known:
            continue
        goal = min(BETTER * before, BETTER * FAR)
        _place(point, c, a, d, p)
        one = within(values, level, x, y, z, cell[h // 3], p, tolerance, size, rest)
        if not one < goal:
            continue
        _place(point, d, b, c, p)
        two = within(values, level, x, y, z, cell[h // 3], p, tolerance, size, rest)
        if not two < goal:
            continue
        # h: a b c, g: b a d  ->  h's: c a d, g's: d b c
        ca, bc, ad, db = twin[_before(h)], twin[_next(h)], twin[_next(g)], twin[_before(g)]
        s, t = 3 * (h // 3), 3 * (g // 3)
        corner[s], corner[s + 1], corner[s + 2] = c, a, d
        corner[t], corner[t + 1], corner[t + 2] = d, b, c
        _set(twin, s, ca)
        _set(twin, s + 1, ad)
        _set(twin, t, db)
        _set(twin, t + 1, bc)
        _set(twin, s + 2, t + 2)
        reach[s // 3], reach[t // 3] = one, two
        out[c], out[a], out[d], out[b] = s, s + 1, t, t + 1
        for w in (a, b, c, d):
            stamp[w] = 0
            _to_the_border(twin, out, w)
        turned += 1
    return turned


def twins(triangles: Integers) -> Integers:
    """(3 m,) the half-edge that runs the other way; half-edge 3 t + c leaves corner c of triangle t. -1 on the border."""
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    n = int(triangles.max(initial=0)) + 1
    key, back = start * n + end, end * n + start
    order = np.argsort(key, kind="stable")
    place = np.minimum(np.searchsorted(key[order], back), max(0, len(key) - 1))
    found = order[place] if len(key) else order
    return np.ascontiguousarray(np.where(key[found] == back, found, -1))


class _Work:
    """A mesh while it is changed, and the room that its kernels need."""

    def __init__(self, field: Field, mesh: Mesh) -> None:
        self.field, self.cell = field, np.ascontiguousarray(mesh.cell)
        self.points = np.ascontiguousarray(mesh.points)
        self.plane = planes(field, self.points)
        self.fixed = (np.bitwise_count(self.plane.astype(np.uint8)) > 1).astype(np.int64)
        self.corner, self.twin = mesh.triangles.ravel().copy(), twins(mesh.triangles)
        self.out = np.full(len(self.points), -1, np.int64)
        self.out[self.corner[::-1]] = np.arange(len(self.corner))[::-1]
        border = np.flatnonzero(self.twin < 0)
        self.out[self.corner[border]] = border
        self.reach, self.stamp = mesh.reach.copy(), np.zeros(len(self.points), np.int64)
        self.work, self.room = np.empty(260, np.int64), np.empty(139 + ROOM)

    def change(self, tolerance: float, most: float, mark: int, folds: bool) -> int:
        """Turn edges and merge points, once; how many."""
        arrays: Any = (self.corner, self.twin, self.cell, self.reach, self.out, self.stamp, self.work, self.room)
        given = (*self.field.given, self.field.size)
        turned = _turn(*given, tolerance, self.points, self.plane, *arrays)
        rest: Any = (*arrays, folds)
        return turned + _pass(*given, most, mark, self.points, self.plane, self.fixed, *rest)

    def done(self) -> Mesh:
        """What is left, without the points that are gone."""
        alive = self.corner[::3] >= 0
        used, ids = np.unique(self.corner.reshape(-1, 3)[alive], return_inverse=True)
        return Mesh(self.points[used], ids.reshape(-1, 3).astype(np.int64), self.cell[alive], self.reach[alive])


def unfolded(field: Field, mesh: Mesh) -> Mesh:
    """The mesh without the points about which triangles lie one above another, as far as that leaves a proof.

    Parameters
    ----------
    mesh : its reach is infinite just where nothing can be proven
    """
    if np.isfinite(mesh.reach).all():
        return mesh
    work = _Work(field, mesh)
    for mark in range(1, 2 * PASSES):
        if not work.change(math.inf, math.inf, mark, True):
            break
    return work.done()


def merged(field: Field, mesh: Mesh, tolerance: float) -> Mesh:
    """The mesh with as many points merged as the tolerance allows.

    Parameters
    ----------
    mesh : triangles within cells, such as `mesh_split.refined` gives
    tolerance : distance, as `Field.asked` gives it

    Returns
    -------
    Mesh
        Triangles that were within the tolerance, and those made of them, are.
    """
    if not len(mesh.triangles):
        return mesh
    work = _Work(field, mesh)
    for mark, share in enumerate(SHARES, start=1):
        for _ in range(PASSES):
            if work.change(tolerance, share * tolerance, mark, False) < 0.002 * len(mesh.points):
                break
    return work.done()


def warm() -> None:
    """Compile the kernels of this file."""
    axis = np.arange(2.0)
    field = Field(np.array([0.0, 1, 1, 2, 1, 2, 2, 4]).reshape(2, 2, 2), axis, axis, axis, 0.5)
    points = np.array([[0.0, 0, 0.5], [0.5, 0, 0], [0, 0.5, 0]])
    merged(field, Mesh(points, np.array([[0, 2, 1]]), np.array([0]), np.zeros(1)), 0.1)
