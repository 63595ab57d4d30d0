"""The box that a scene fills, and how it lies in a view."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from app.draw import charts
from modules.data.geometry import Geometry, Primitive
from modules.data.grid import Frame
from modules.data.scene import ChartLook, Layer
from modules.data.wires import Samples, Table

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """Bounds in world units, x, y, z.

    Parameters
    ----------
    known : whether anything lies in it
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    known: bool = True

    @property
    def bounds(self) -> tuple[float, ...]:
        """xmin, xmax, ymin, ymax, zmin, zmax."""
        return tuple(v for pair in zip(self.low, self.high, strict=True) for v in pair)

    @property
    def sides(self) -> tuple[float, float, float]:
        """Lengths along x, y, z."""
        x, y, z = (h - low for low, h in zip(self.low, self.high, strict=True))
        return x, y, z

    @property
    def centre(self) -> tuple[float, float, float]:
        """Its middle."""
        x, y, z = ((low + h) / 2 for low, h in zip(self.low, self.high, strict=True))
        return x, y, z

    @property
    def diagonal(self) -> float:
        """From corner to corner; 1 for a single point."""
        return math.sqrt(sum(s * s for s in self.sides)) or 1.0

    def corners(self) -> Floats:
        """(8, 3) its corners."""
        return np.array(list(product(*zip(self.low, self.high, strict=True))))

    def lifted(self, factor: float) -> Box:
        """With heights times a factor."""
        return replace(self, low=(*self.low[:2], self.low[2] * factor), high=(*self.high[:2], self.high[2] * factor))

    def padded(self, share: float, *, each: bool = False) -> Box:
        """Wider in the plane, by a share of the longer side; or of each side, where the axes have no common scale."""
        longer = max(self.sides[:2])
        x, y = (share * ((side or longer) if each else longer) for side in self.sides[:2])
        low = (self.low[0] - x, self.low[1] - y, self.low[2])
        return replace(self, low=low, high=(self.high[0] + x, self.high[1] + y, self.high[2]))

    def near_corner(self, eye: Sequence[float]) -> tuple[int, int, int]:
        """For each axis, which end is nearer to the eye: 0 the low, 1 the high."""
        x, y, z = (int(e > c) for e, c in zip(eye, self.centre, strict=True))
        return x, y, z

    def seen_from(self, away: Sequence[float], angle: float, aspect: float, margin: float) -> tuple[Floats, Floats]:
        """(position, focal) of a camera in a direction that sees all corners, in the middle of its picture.

        Parameters
        ----------
        away : unit vector from the box to the camera
        angle : of view, upright, in degrees
        aspect : width over height
        margin : room around the box, as a factor
        """
        back = np.asarray(away, float)
        right = np.cross([0.0, 0.0, 1.0], back)
        right /= np.linalg.norm(right)
        up = np.cross(back, right)
        tangent = math.tan(math.radians(angle) / 2)
        focal, corners = np.asarray(self.centre, float), self.corners()
        distance = self.distance(away, angle, aspect)
        for _ in range(6):
            relative = corners - (focal + distance * back)
            depth = -(relative @ back)
            x, y = relative @ right / depth / tangent, relative @ up / depth / tangent
            focal = focal + distance * tangent * ((x.max() + x.min()) / 2 * right + (y.max() + y.min()) / 2 * up)
            distance *= margin * max((x.max() - x.min()) / 2 / aspect, (y.max() - y.min()) / 2)
        return focal + distance * back, focal

    def distance(self, away: Sequence[float], angle: float, aspect: float) -> float:
        """How far from the centre a camera in a direction must be to see every corner.

        Parameters
        ----------
        away : unit vector from the centre to the camera
        angle : of view, upright, in degrees
        aspect : width over height
        """
        back = np.asarray(away, float)
        right = np.cross([0.0, 0.0, 1.0], back)
        right /= np.linalg.norm(right)
        up = np.cross(back, right)
        relative = self.corners() - np.asarray(self.centre)
        tangent = math.tan(math.radians(angle) / 2)
        depth = relative @ back
        needed = np.maximum(np.abs(relative @ up) / tangent, np.abs(relative @ right) / (tangent * aspect)) + depth
        return float(needed.max())


def of_layers(layers: Iterable[Layer]) -> Box:
    """The box that all layers fill; one of unit size where there is nothing."""
    found = [b for layer in layers if (b := _bounds(layer)) is not None]
    if not found:
        return Box((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), known=False)
    array = np.array(found, float)
    low, high = array[:, 0].min(axis=0), array[:, 1].max(axis=0)
    return Box((float(low[0]), float(low[1]), float(low[2])), (float(high[0]), float(high[1]), float(high[2])))


def _bounds(layer: Layer) -> tuple[Floats, Floats] | None:
    shape = layer.shape
    if isinstance(shape, Samples):
        return np.array(shape.grid.bounds[::2]), np.array(shape.grid.bounds[1::2])
    if isinstance(shape, Geometry):
        parts = [shape.points] if len(shape.points) else []
        parts += [_primitive(p) for p in shape.primitives]
        if not parts:
            return None
        points = np.concatenate(parts)
        points = points[np.isfinite(points).all(axis=1)]
        return (points.min(axis=0), points.max(axis=0)) if len(points) else None
    if isinstance(shape, Table) and isinstance(layer.look, ChartLook) and shape.rows:
        return _chart(shape, layer.look)
    return None


def _primitive(primitive: Primitive) -> Floats:
    """Points that a primitive reaches to."""
    values = {name: np.asarray(v, float).ravel() for name, v in primitive.values.items()}
    at = np.array([v for v in values.values() if len(v) == 3])
    if primitive.kind == "sphere" and "radius" in values:
        return np.concatenate([at - values["radius"][0], at + values["radius"][0]])
    if primitive.kind == "plane":
        half = float(values.get("size", np.ones(1))[0]) / 2
        centre = values.get("origin", values.get("centre", at[0]))
        return np.stack([centre - half, centre + half])
    return at


def _chart(table: Table, look: ChartLook) -> tuple[Floats, Floats]:
    names = [*table.columns, *table.columns]
    logs = charts.logs(look)
    x, y = charts.drawn(table.columns[look.x or names[0]], logs[0]), charts.drawn(table.columns[look.y or names[1]], logs[1])
    floor = min(0.0, float(np.nanmin(y))) if look.kind == "bars" else float(np.nanmin(y))
    low = np.array([float(np.nanmin(x)), floor, 0.0])
    top = np.fmax(y, charts.drawn(table.columns[look.upper], logs[1])) if look.upper else y
    return low, np.array([float(np.nanmax(x)), float(np.nanmax(top)), 0.0])


def frame_of(layers: Iterable[Layer]) -> Frame:
    """Names and units of the axes: of the first layer that has them."""
    for layer in layers:
        shape = layer.shape
        if isinstance(shape, Samples):
            return shape.grid.frame
        if isinstance(shape, Geometry):
            return shape.frame
        if isinstance(shape, Table) and isinstance(layer.look, ChartLook):
            names = [*shape.columns, *shape.columns]
            x, y = layer.look.x or names[0], layer.look.y or names[1]
            return Frame(axes=(x, y, "z"), units=(shape.units.get(x, ""), shape.units.get(y, ""), ""))
    return Frame()
