"""The border of a grid between two levels, cut so that it closes the two isosurfaces, with their very vertices.

Each face of a cell on the border is a disc; the arcs of both levels cut it into parts. The parts between the levels are
triangulated over the corners of the face and the vertices of the isosurfaces on it, which are known by place: a crossing by
its edge and level, an arc by the edges of the mesh that have one triangle.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modules.api import Progress
from modules.mappers._isosurface_methods import open_edges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mesh = tuple[Floats, Ints]
Axes = tuple[Floats, ...]


def caps(values: Floats, axes: Axes, levels: tuple[float, float], meshes: Sequence[Mesh], progress: Progress) -> Mesh:
    """Further points, and triangles over the points of both meshes and these, that look out of the grid.

    Parameters
    ----------
    values : (nz, ny, nx)
    levels : low, high
    meshes : points and triangles of the isosurfaces, which look to the low side
    """
    shape = np.array(values.shape[::-1])
    arcs: dict[tuple[int, int, int, int], list[list[int]]] = {}
    places = np.concatenate([meshes[0][0], meshes[1][0]])
    start = 0
    for points, triangles in meshes:
        for arc in _arcs(points, open_edges(points, triangles), axes):
            arcs.setdefault(_face_of(points[arc[1:-1]], axes), []).append([start + v for v in arc])
        start += len(points)
    cut, plain = [], [np.zeros((0, 4), np.int64)]
    inside = (values >= levels[0]) & (values < levels[1])
    number = len(places) + np.arange(values.size)
    for axis in range(3):
        for side in (0, 1):
            progress.check()
            mine = {key[2:]: arc for key, arc in arcs.items() if key[:2] == (axis, side)}
            plain.append(_whole_faces(inside, axis, side, list(mine)))
            for at in sorted(mine):
                face = _Face(axis, side, *at, shape)
                cut += face.cut(mine[at], number[face.nodes()].tolist(), values, axes, levels, places)
    faces = number[np.concatenate(plain)]
    triangles = np.concatenate([faces[:, [3, 0, 1]], faces[:, [1, 2, 3]], np.array(cut, np.int64).reshape(-1, 3)])
    used = np.unique(triangles[triangles >= len(places)]) - len(places)
    row, i = np.divmod(used, shape[0])
    k, j = np.divmod(row, shape[1])
    place = np.arange(len(places) + values.size)
    place[len(places) + used] = len(places) + np.arange(len(used))
    return np.column_stack([axes[0][i], axes[1][j], axes[2][k]]), place[triangles]


def _whole_faces(inside: NDArray[np.bool_], axis: int, side: int, but: list[tuple[int, ...]]) -> Ints:
    """(n, 4) the corners, anticlockwise as seen from outside, of the faces on a side of the grid that are between the levels.

    Parameters
    ----------
    but : places of faces that an arc cuts
    """
    _, ny, nx = inside.shape
    step = (1, nx, nx * ny)
    p, q = (axis + 1) % 3, (axis + 2) % 3
    here = np.moveaxis(np.moveaxis(inside.T, axis, 0)[-side], (0, 1), (0, 1) if p < q else (1, 0))[:-1, :-1].copy()
    for at in but:
        here[at] = False
    u, v = np.nonzero(here)
    first = side * (inside.shape[2 - axis] - 1) * step[axis] + u * step[p] + v * step[q]
    ring = np.stack([first, first + step[p], first + step[p] + step[q], first + step[q]], axis=1)
    return ring if side else ring[:, ::-1]


def _on_lines(points: Floats, axes: Axes) -> NDArray[np.bool_]:
    """(n, 3) whether each coordinate of points is one of the grid's."""
    return np.stack([np.isin(points[:, a], axes[a]) for a in range(3)], axis=1)


def _arcs(points: Floats, edges: Ints, axes: Axes) -> list[list[int]]:
    """Runs of border edges from crossing to crossing, within one face each."""
    crossing = _on_lines(points, axes).sum(axis=1) >= 2
    beside: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    found = []
    for a in beside:
        if not crossing[a]:
            continue
        for b in beside[a]:
            run = [a, b]
            while not crossing[run[-1]]:
                run.append(next(n for n in beside[run[-1]] if n != run[-2]))
            if run[0] < run[-1]:
                found.append(run)
    return found


def _face_of(inner: Floats, axes: Axes) -> tuple[int, int, int, int]:
    """Axis, side, and place of the face in which the inner points of an arc lie."""
    point = inner[0]
    axis = int(np.argmax([point[a] in (axes[a][0], axes[a][-1]) for a in range(3)]))
    side = int(point[axis] == axes[axis][-1])
    p, q = ((axis + 1) % 3, (axis + 2) % 3)
    u, v = (int(np.searchsorted(axes[a], point[a], side="right")) - 1 for a in (p, q))
    return axis, side, u, v


class _Face:
    """A face of a cell on the border; p and q are the axes along it, so that p, q and its axis are right-handed."""

    def __init__(self, axis: int, side: int, u: int, v: int, shape: Ints) -> None:
        self.axis, self.side, self.at, self.shape = axis, side, (u, v), shape
        self.p, self.q = (axis + 1) % 3, (axis + 2) % 3

    def nodes(self) -> list[int]:
        """The four corners, anticlockwise as seen from the side to which the axis points."""
        step = (1, int(self.shape[0]), int(self.shape[0] * self.shape[1]))
        across = self.side * (int(self.shape[self.axis]) - 1) * step[self.axis]
        first = across + self.at[0] * step[self.p] + self.at[1] * step[self.q]
        return [first, first + step[self.p], first + step[self.p] + step[self.q], first + step[self.q]]

    def cut(
        self, arcs: list[list[int]], ids: list[int], values: Floats, axes: Axes, levels: tuple[float, float], places: Floats
    ) -> list[tuple[int, int, int]]:
        """The triangles of the parts between the levels."""
        f = values.ravel()[self.nodes()]
        corner = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
        flat = {i: corner[n] for n, i in enumerate(ids)}
        low = np.array([axes[self.p][self.at[0]], axes[self.q][self.at[1]]])
        size = np.array([axes[self.p][self.at[0] + 1], axes[self.q][self.at[1] + 1]]) - low
        for i in {v for arc in arcs for v in arc}:
            flat[i] = (places[i][[self.p, self.q]] - low) / size
        parts = [self._around(arcs, ids, f, flat)]
        for arc in arcs:
            n = next(n for n, part in enumerate(parts) if arc[0] in part and arc[-1] in part)
            parts[n : n + 1] = _split(parts[n], arc)
        found = []
        for part in parts:
            if self._between(part, ids, f, flat, levels):
                found += _ears(part, flat)
        return found if self.side else [(a, c, b) for a, b, c in found]

    def _around(self, arcs: list[list[int]], ids: list[int], f: Floats, flat: dict[int, Floats]) -> list[int]:
        """Corners and crossings around the face, anticlockwise."""
        ends = {v for arc in arcs for v in (arc[0], arc[-1])}
        around: list[int] = []
        for n in range(4):
            here, there = flat[ids[n]], flat[ids[(n + 1) % 4]]
            axis = int(np.argmax(np.abs(there - here)))
            on = [v for v in ends if flat[v][1 - axis] == here[1 - axis] and 0 < flat[v][axis] < 1]
            rising = f[(n + 1) % 4] > f[n]
            # of two crossings at one place that of the lower level (with the lower number) is met first on the way up
            on.sort(key=lambda v: (abs(flat[v][axis] - here[axis]), v if rising else -v))
            around += [ids[n], *on]
        return around

    def _between(
        self, part: list[int], ids: list[int], f: Floats, flat: dict[int, Floats], levels: tuple[float, float]
    ) -> bool:
        """Whether a part lies between the levels, by a piece of the border of the face in it."""
        for n, v in enumerate(part):
            if v in ids:
                return bool(levels[0] <= f[ids.index(v)] < levels[1])
            w = part[(n + 1) % len(part)]
            same = flat[v] == flat[w]
            if same.any() and w not in ids and flat[v][int(np.argmax(same))] in (0.0, 1.0):
                u, t = 0.5 * (flat[v] + flat[w])
                value = (1 - t) * ((1 - u) * f[0] + u * f[1]) + t * ((1 - u) * f[3] + u * f[2])
                return bool(levels[0] <= value < levels[1])
        return False


def _split(part: list[int], arc: list[int]) -> list[list[int]]:
    """A part cut in two along an arc between two of its vertices."""
    i, j = part.index(arc[0]), part.index(arc[-1])
    if i > j:
        i, j, arc = j, i, arc[::-1]
    return [[*part[: i + 1], *arc[1:-1], *part[j:]], [*part[i : j + 1], *arc[1:-1][::-1]]]


def _ears(part: list[int], flat: dict[int, Floats]) -> list[tuple[int, int, int]]:
    """Triangles of a simple polygon, by cutting ears; the rest as a fan where rounding leaves none."""
    ring, found = list(part), []
    while len(ring) > 3:
        for n in range(len(ring)):
            a, b, c = ring[n - 1], ring[n], ring[(n + 1) % len(ring)]
            if _turn(flat[a], flat[b], flat[c]) > 0 and not any(
                _within(flat[v], flat[a], flat[b], flat[c]) for v in ring if v not in (a, b, c)
            ):
                found.append((a, b, c))
                del ring[n]
                break
        else:
            break
    return found + [(ring[0], ring[n], ring[n + 1]) for n in range(1, len(ring) - 1)]


def _turn(a: Floats, b: Floats, c: Floats) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _within(v: Floats, a: Floats, b: Floats, c: Floats) -> bool:
    return _turn(a, b, v) >= 0 and _turn(b, c, v) >= 0 and _turn(c, a, v) >= 0
