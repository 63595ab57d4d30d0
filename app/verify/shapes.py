"""How far shapes are from where they should be, by the field alone: level sets by Newton's method, chords and triangles by
points on them. None of the modules' formulas is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modules.data.geometry import Geometry
from modules.data.laws import Law
from modules.data.wires import LAWS, Model

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STEPS = 8
"""Of Newton's method."""
ALONG = 64
"""Pieces of a chord, for its area and its farthest point."""
WITHIN = np.array([[a, b, 6 - a - b] for a in range(1, 6) for b in range(1, 6 - a)], float) / 6
"""Barycentric coordinates of the points of a triangle that are looked at."""


@dataclass(frozen=True, eq=False)
class Level:
    """The set where a model has given values.

    Parameters
    ----------
    model : the field
    law : between its samples
    measure : (3,) what counts as a unit of length along each axis
    """

    model: Model
    law: Law
    measure: Floats

    @classmethod
    def of(cls, model: Model, exact: bool, measure: Floats) -> Level:
        """By the model's own law; as the truth (`exact`) a jumping law counts as linear."""
        return cls(model, LAWS["linear"] if exact and model.law.name == "nearest" else model.law, measure)

    def value(self, points: Floats) -> tuple[Floats, Floats]:
        """(n,) values and (n, 3) slopes per unit of length."""
        flat = np.asarray(self.model.samples.values, float).ravel()
        slopes = np.zeros((len(points), 3))
        for axis, slope in enumerate(self.law.slopes(self.model.grid, points)):
            slopes[:, axis] = slope.apply(flat) * self.measure[axis]
        return np.asarray(self.law.weights(self.model.grid, points).apply(flat)), slopes

    def distance(self, points: Floats, level: Floats, along: Floats | None = None) -> Floats:
        """(n,) signed distance to where the field has its level, positive where it is below; NaN where none is near.

        Parameters
        ----------
        along : (n, 3) unit directions to look in; down the slope by default
        """
        low, high = np.array(self.model.grid.bounds).reshape(3, 2).T
        inside = np.isfinite(points).all(axis=1)
        if not inside.all():
            partly = np.full(len(points), np.nan)
            partly[inside] = self.distance(points[inside], level[inside], None if along is None else along[inside])
            return partly
        points = np.clip(points, low, high)
        at, first = points.copy(), np.zeros(len(points))
        scale = np.zeros(len(points))
        for step in range(STEPS):
            value, slope = self.value(at)
            rest = level - value
            if step == 0:
                first, scale = rest, np.linalg.norm(slope, axis=1)
            if along is None:
                move = slope * (rest / np.maximum((slope**2).sum(axis=1), 1e-300))[:, None]
            else:
                rate = (slope * along).sum(axis=1)
                move = along * (rest / np.where(np.abs(rate) > 1e-300, rate, np.inf))[:, None]
            move = np.where(np.isfinite(move), move, 0.0)  # beside a hole there is nowhere to go
            at = np.clip(at + move * self.measure, low, high)
        size = np.linalg.norm((at - points) / self.measure, axis=1)
        rest = np.abs(level - self.value(at)[0])
        found: Floats = np.sign(first) * size
        found[~(rest <= 1e-6 * np.abs(first) + 1e-12 * scale * np.linalg.norm((high - low) / self.measure))] = np.nan
        return found


def measure_of(model: Model) -> Floats:
    """(3,) the unit of lengths along each axis: one for all, or the cells where axes have different units."""
    measure: Floats = np.ones(3)
    try:
        model.grid.frame.length_unit(model.grid.dimensions)
    except ValueError:
        for axis, along in enumerate(model.grid.axes):  # type: ignore[attr-defined]  # a box, as the caller has seen
            measure[axis] = np.median(np.diff(along))
    return measure


def levels_of(geometry: Geometry) -> Floats | None:
    """(points,) the level of each point of lines or polygons that know theirs; None for other shapes."""
    known = geometry.values.get("level")
    if known is None or known.place != "cell" or not len(geometry.points) or len(geometry.vertices):
        return None
    if "low" in geometry.values or "k" in geometry.values:
        return None  # regions between levels
    found = np.full(len(geometry.points), np.nan)
    start = 0
    for cells in (geometry.lines, geometry.polygons):
        values = np.asarray(known.values[start : start + len(cells)], float)
        found[cells.connectivity] = np.repeat(values, cells.sizes())
        start += len(cells)
    return found


@dataclass(frozen=True, eq=False)
class Chords:
    """Segments of lines against the level set: farthest point, area, and by how much the curve is longer."""

    farthest: Floats
    area: Floats
    longer: Floats


def chords(geometry: Geometry, segments: Ints, level: Floats, truth: Level) -> Chords:
    """What lies between some segments and the level set, by `ALONG` + 1 points on each; NaN where it is not met.

    Parameters
    ----------
    segments : (s, 2) points
    level : (s,)
    """
    a, b = (geometry.points[segments[:, i]] / truth.measure for i in (0, 1))
    long = np.linalg.norm(b - a, axis=1)
    safe = np.where(long > 0, long, 1.0)
    normal = np.column_stack([-(b - a)[:, 1], (b - a)[:, 0], np.zeros(len(a))]) / safe[:, None]
    t = np.linspace(0, 1, ALONG + 1)[1:-1]
    points = (a[:, None] * (1 - t[:, None]) + b[:, None] * t[:, None]).reshape(-1, 3)
    along = np.repeat(normal, len(t), axis=0)
    off = np.abs(truth.distance(points * truth.measure, np.repeat(level, len(t)), along)).reshape(len(a), -1)
    off = np.pad(off, ((0, 0), (1, 1)))
    width = long / ALONG
    area = (off[:, 1:] + off[:, :-1]).sum(axis=1) / 2 * width
    curve = np.hypot(np.diff(off, axis=1), width[:, None]).sum(axis=1)
    return Chords(off.max(axis=1), area, curve - long)


def triangle_reach(geometry: Geometry, triangles: Ints, level: Floats, truth: Level) -> Floats:
    """(m,) the farthest of some points of each triangle from the level set; NaN where it is not met."""
    corner = geometry.points[geometry.triangles[triangles]]
    points = np.einsum("kc,mcd->mkd", WITHIN, corner).reshape(-1, 3)
    off = np.abs(truth.distance(points, np.repeat(level, len(WITHIN))))
    return np.asarray(off.reshape(len(triangles), -1).max(axis=1))
