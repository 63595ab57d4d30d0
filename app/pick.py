"""What lies under a pixel of a view: which layer, which cell of it, and with which weights of its points.

The scene and the camera are enough: nothing is drawn, so that every back end, and a script, picks the same. Lines and
points are met within a few pixels, surfaces and images exactly; what a surface hides is not met.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from app.draw import charts
from app.draw.looks import chart_columns
from app.draw.sight import Sight
from modules.data.geometry import Geometry
from modules.data.grid import Rectilinear, Regular
from modules.data.scene import ChartLook, ImageLook, Layer, LineLook, PointLook, Scene, SurfaceLook
from modules.data.wires import Samples, Table

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Check = Callable[[float], object]

REACH = 6.0
"""Pixels within which a line or a point is met."""
CLEAR = 0.5
"""What is drawn with less opacity hides nothing; with a twentieth it is not met."""
SLACK = 2e-3
"""Of the distance: what lies on a surface is not hidden by it."""
TRIED = 12
"""Lines and points near the pixel of which it is asked whether something hides them."""


@dataclass(frozen=True)
class Hit:
    """What was met.

    Parameters
    ----------
    layer : index in the scene
    kind : vertex, line or polygon of a geometry, a place between samples, or a row of a table
    cell : of a geometry, with vertices, lines and polygons counted in this order; of a grid its cell; the row
    points, weights : the points of the shape around the place, and their weights, which add up to 1
    at : the place in the world, without exaggeration
    segment : of a line, else -1
    off : pixels between the place and the pixel that was asked for
    """

    layer: int
    kind: Literal["vertex", "line", "polygon", "sample", "row"]
    cell: int
    points: tuple[int, ...]
    weights: tuple[float, ...]
    at: tuple[float, float, float]
    segment: int = -1
    off: float = 0.0


@dataclass(frozen=True)
class _Found:
    hit: Hit
    depth: float
    fill: bool


def pick(
    scene: Scene,
    camera: Mapping[str, Any],
    size: tuple[float, float],
    at: tuple[float, float],
    *,
    reach: float = REACH,
    check: Check | None = None,
) -> Hit | None:
    """What lies under a pixel.

    Parameters
    ----------
    camera : where the scene is seen from, as a viewport gives it
    size : width and height of the window in pixels
    at : the pixel, from the upper left corner
    reach : pixels within which lines and points are met
    check : called with the fraction done; what it raises ends the work

    Returns
    -------
    The nearest thing that is seen there; None for the bare view, and for volumes, which have no surface
    """
    look = _Look(scene, Sight(camera, size), at, reach)
    found: list[_Found] = []
    for i, layer in enumerate(scene.layers):
        if check is not None:
            check(i / len(scene.layers))
        found += look.into(i, layer)
    near = sorted((f for f in found if not f.fill), key=lambda f: (round(f.hit.off), f.depth))
    for one in near[:TRIED]:
        if not look.hidden(one):
            return one.hit
    filled = [f for f in found if f.fill]
    return min(filled, key=lambda f: f.depth).hit if filled else None


class _Look:
    """One look along one line of sight."""

    def __init__(self, scene: Scene, sight: Sight, at: tuple[float, float], reach: float) -> None:
        self.scene, self.sight, self.at, self.reach = scene, sight, np.asarray(at, float), reach
        self.flat = scene.look.dimensions == 2
        self.factor = np.array([1.0, 1.0, 1.0 if self.flat else scene.look.exaggeration])
        self.fills: list[tuple[int, float, Floats]] = []

    def into(self, i: int, layer: Layer) -> list[_Found]:
        """What of a layer is near the line of sight."""
        shape, look = layer.shape, layer.look
        if getattr(look, "opacity", 1.0) < CLEAR / 10:
            return []
        if isinstance(shape, Geometry):
            if isinstance(look, SurfaceLook):
                return self._polygons(i, shape, look)
            if isinstance(look, LineLook):
                return self._lines(i, shape, look)
            return self._points(i, shape, look) if isinstance(look, PointLook) else []
        if isinstance(shape, Samples) and isinstance(look, ImageLook):
            return self._image(i, shape, look)
        return self._rows(i, shape, look) if isinstance(shape, Table) and isinstance(look, ChartLook) else []

    def _depth(self, i: int, depth: float) -> float:
        """What orders things before each other: layers in the plane, distance in space."""
        return -float(i) if self.flat else depth

    # --- surfaces

    def _polygons(self, i: int, shape: Geometry, look: SurfaceLook) -> list[_Found]:
        corners, owner = _fans(shape)
        if not len(corners):
            return []
        drawn = shape.points * self.factor
        place, _ = self.sight.pixels(drawn)
        near = _around(place, corners, self.at, self.reach + 1)
        corners, owner = corners[near], owner[near]
        if look.opacity >= CLEAR:
            self.fills.append((i, look.opacity, drawn[corners]))
        depth, weights = _through(drawn[corners], *self.sight.ray(*self.at))
        if not np.isfinite(depth).any():
            return []
        which = int(np.nanargmin(depth))
        first = len(shape.vertices) + len(shape.lines)
        hit = self._hit(i, "polygon", first + int(owner[which]), corners[which], weights[which], shape.points)
        return [_Found(hit, self._depth(i, float(depth[which])), True)]

    def hidden(self, one: _Found) -> bool:
        """Whether a surface lies before a line or point that was found."""
        at = np.asarray(one.hit.at) * self.factor
        (pixel,), (mine,) = self.sight.pixels(at[None])
        for i, _, triangles in self.fills:
            depth, _ = _through(triangles, *self.sight.ray(*pixel))
            if not np.isfinite(depth).any():
                continue
            before = i > one.hit.layer if self.flat else float(np.nanmin(depth)) < mine * (1 - SLACK)
            if before:
                return True
        return False

    # --- lines and points

    def _lines(self, i: int, shape: Geometry, look: LineLook) -> list[_Found]:
        ends = shape.segments()
        if not len(ends):
            return []
        place, depth = self.sight.pixels(shape.points * self.factor)
        a, b = place[ends[:, 0]], place[ends[:, 1]]
        along = b - a
        length = (along**2).sum(axis=1)
        part = np.clip(((self.at - a) * along).sum(axis=1) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        off = np.hypot(*(a + part[:, None] * along - self.at).T)
        near = _nearest(off, self.reach + look.width / 2)
        owner = np.repeat(np.arange(len(shape.lines)), np.maximum(shape.lines.sizes() - 1, 0))
        found = []
        for s in near:
            z0, z1 = depth[ends[s]]
            t = float(part[s])
            share = t if self.sight.parallel else t * z0 / (z1 + t * (z0 - z1))
            cell = len(shape.vertices) + int(owner[s])
            hit = self._hit(i, "line", cell, ends[s], np.array([1 - share, share]), shape.points, float(off[s]), int(s))
            found.append(_Found(hit, self._depth(i, float((1 - share) * z0 + share * z1)), False))
        return found

    def _points(self, i: int, shape: Geometry, look: PointLook) -> list[_Found]:
        index = shape.vertices.connectivity if len(shape.vertices) else np.arange(len(shape.points))
        place, depth = self.sight.pixels(shape.points[index] * self.factor)
        off = np.hypot(*(place - self.at).T)
        cells = np.repeat(np.arange(len(shape.vertices)), shape.vertices.sizes()) if len(shape.vertices) else index
        return [
            _Found(
                self._hit(i, "vertex", int(cells[n]), index[n : n + 1], np.ones(1), shape.points, float(off[n])),
                self._depth(i, float(depth[n])), False,
            )
            for n in _nearest(off, self.reach + look.size / 2)
        ]  # fmt: skip

    def _rows(self, i: int, table: Table, look: ChartLook) -> list[_Found]:
        named = zip(chart_columns(table, look), charts.logs(look), strict=True)
        x, y = (charts.drawn(table.columns[column], log) for column, log in named)
        points = np.column_stack([x, y, np.zeros(len(x))])
        place, depth = self.sight.pixels(points)
        off = np.hypot(*(place - self.at).T)
        rows = _nearest(off, 2 * self.reach)
        hits = [self._hit(i, "row", int(n), [int(n)], np.ones(1), points, float(off[n])) for n in rows]
        return [_Found(hit, self._depth(i, float(depth[hit.cell])), False) for hit in hits]

    # --- images

    def _image(self, i: int, samples: Samples, look: ImageLook) -> list[_Found]:
        grid = samples.grid
        if not isinstance(grid, Regular | Rectilinear):
            return []
        start, along = self.sight.ray(*self.at)
        level = float(grid.bounds[4]) * self.factor[2]
        if along[2] == 0:
            return []
        depth = (level - start[2]) / along[2]
        place = (start + depth * along) / self.factor
        if look.opacity >= CLEAR:
            x0, x1, y0, y1 = grid.bounds[:4]
            corners = np.array([[x0, y0, level], [x1, y0, level], [x1, y1, level], [x0, y1, level]])
            self.fills.append((i, look.opacity, corners[[[0, 1, 2], [0, 2, 3]]]))
        around = _bilinear(grid, place)
        if around is None or (depth <= 0 and not self.sight.parallel):
            return []
        points, weights, cell = around
        if not look.interpolate:
            points, weights = points[[np.argmax(weights)]], np.ones(1)
        value = np.asarray(samples.values, float).ravel()[points][weights > 0]
        if not np.isfinite(value).all():
            return []
        hit = Hit(i, "sample", cell, *_whole(points, weights), at=_three(place))
        return [_Found(hit, self._depth(i, float(depth)), True)]

    def _hit(
        self, i: int, kind: Any, cell: int, points: Any, weights: Floats, where: Floats, off: float = 0.0, segment: int = -1
    ) -> Hit:
        index, shares = _whole(points, weights)
        at = np.asarray(shares) @ where[list(index)]
        return Hit(i, kind, cell, index, shares, _three(at), segment, off)


def _whole(points: Any, weights: Floats) -> tuple[tuple[int, ...], tuple[float, ...]]:
    return tuple(int(p) for p in points), tuple(float(w) for w in weights)


def _three(at: Sequence[float] | Floats) -> tuple[float, float, float]:
    return float(at[0]), float(at[1]), float(at[2])


def _fans(shape: Geometry) -> tuple[Ints, Ints]:
    """(m, 3) corners of the triangles that polygons consist of, and (m,) the polygon of each."""
    sizes = np.maximum(shape.polygons.sizes() - 2, 0)
    return shape.triangles, np.repeat(np.arange(len(sizes)), sizes)


def _around(place: Floats, corners: Ints, at: Floats, reach: float) -> NDArray[np.bool_]:
    """(m,) whether the box of a triangle in the window holds a pixel; true where a corner is behind the eye."""
    inside = np.ones(len(corners), bool)
    for axis in (0, 1):
        ends = place[:, axis][corners]
        low, high = ends.min(axis=1), ends.max(axis=1)
        inside &= ~(low > at[axis] + reach) & ~(high < at[axis] - reach)
    return inside


def _through(triangles: Floats, start: Floats, along: Floats) -> tuple[Floats, Floats]:
    """(m,) how far along a ray each triangle is met, NaN where it is not, and (m, 3) the weights of its corners there.

    Source: Möller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997.
    """
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(along, e2)
    area = (e1 * p).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = start - a
        u = (s * p).sum(axis=1) / area
        q = np.cross(s, e1)
        v = q @ along / area
        depth = (e2 * q).sum(axis=1) / area
        edge = -1e-9
        met = (area != 0) & (u >= edge) & (v >= edge) & (u + v <= 1 - edge)
    weights = np.clip(np.stack([1 - u - v, u, v], axis=1), 0.0, 1.0)
    return np.where(met, depth, np.nan), weights


def _nearest(off: Floats, reach: float) -> Ints:
    """Those within reach, the nearest first."""
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(off <= reach)
    return near[np.argsort(off[near], kind="stable")][:TRIED]


def _bilinear(grid: Regular | Rectilinear, place: Floats) -> tuple[Ints, Floats, int] | None:
    """(4,) samples around a place of the plane, (4,) their weights, and the cell; None outside."""
    x, y = (np.asarray(axis, float) for axis in grid.axes)
    index, part = [], []
    for axis, value in ((x, place[0]), (y, place[1])):
        if not axis[0] <= value <= axis[-1]:
            return None
        left = int(np.clip(np.searchsorted(axis, value, side="right") - 1, 0, len(axis) - 2))
        index.append(left)
        part.append(float((value - axis[left]) / (axis[left + 1] - axis[left])))
    (i, j), (s, t) = index, part
    corner = j * len(x) + i
    points = np.array([corner, corner + 1, corner + len(x), corner + len(x) + 1])
    weights = np.array([(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t])
    return points, weights, j * (len(x) - 1) + i
