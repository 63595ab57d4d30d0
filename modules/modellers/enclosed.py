"""The volume that a field is at or above a level in, and the area of the surface around it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Matrix,
    Missing,
    Model,
    NamedTuple,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    Value,
    modeller,
)
from modules.data.operators import Identity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FLATTEST = 1e-150
NEWTON = 3
"""Steps to the surface; each squares what is left."""

INNER = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6
"""Three points within a triangle whose mean integrates parabolas exactly."""

BOXES = Source(
    "Volume between bounds", "mapping", "proven", "boxes of the cells and planes moved by the rest of the field [solid-boxes/1]"
)
HALVED = Source(
    "Triangles instead of the curved surface", "mapping", "estimated",
    "a third of what cutting each triangle in four on the surface changes; that much is put right [area-by-halving/1]",
)  # fmt: skip


class Enclosed(NamedTuple):
    """Volume at or above the level, and area of the surface."""

    volume: Value
    area: Value


@modeller("Enclosed volume", aliases=("volume", "surface area", "measure", "integral"))
def enclosed(
    model: Model,
    progress: Progress,
    *,
    level: Annotated[float | None, Range(of="model.range")] = None,
    cuts: Annotated[int, Range(1, 16)] = 4,
) -> Enclosed:
    """How large the region is in which a field is at or above a level, and how large the surface at the level.

    The volume is the middle between two proven bounds. The area is that of the accurate isosurface's triangles, each cut in
    four by points on the surface, and put right by what that changes; where the region meets the border of the grid, the
    border does not count.

    Parameters
    ----------
    level : in the unit of the field; automatic: the middle of its range
    cuts : boxes along each axis of a cell that the surface passes; twice as many give bounds a quarter as far apart

    Raises
    ------
    ValueError : the model is not a linear one of single values on a regular or rectilinear grid of three dimensions

    Accuracy: the volume of the trilinear region is proven to lie within the bound; errors of the model change it by the
        integral of error / slope over the surface, to first order, with their correlation. What they change of the area is
        not known.
    Source: transport theorem; Lopes 1999, 4.5 (future work).
    """
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or min(grid.shape) < 2:
        raise ValueError(f"a volume is measured on a regular or rectilinear grid of 3 dimensions, not on this {grid.kind} one")
    if model.samples.components != 1 or model.law.name != "linear":
        raise ValueError("a volume is measured of a linear model of one value a sample: choose law 'linear' and a component")
    values, unit = np.ascontiguousarray(model.samples.values, dtype=float), grid.frame.length_unit(3)
    finite = values[np.isfinite(values)]
    if level is None:
        level = float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0
    if not np.isfinite(level) or cuts < 1:
        raise ValueError(f"give a level that is a number, not {level}, and 1 or more cuts, not {cuts}")
    x, y, z = grid.axes
    part = kernels.solid.volume(values, x, y, z, level, cuts)
    progress(0.3)
    drawn = kernels.marching.surface(values, x, y, z, level, slabs=progress.part(0.3, 0.8).map)
    where, weight = _measured(model, drawn.points, drawn.triangles)
    one, four = _areas(model, level, drawn.points, drawn.triangles)
    holes = () if part.whole >= _box(grid.axes) * (1 - 1e-12) else (Missing("Holes", "cells that are not known do not count"),)
    return Enclosed(_volume(model, part, where, weight, unit, holes), _area(model, one, four, unit, holes))


def _box(axes: Sequence[Floats]) -> float:
    return float(np.prod([axis[-1] - axis[0] for axis in axes]))


def _measured(model: Model, points: Floats, triangles: Ints) -> tuple[Floats, Floats]:
    """Points within the triangles, and by how much the volume changes with an error there."""
    corner = points[triangles]
    size = _sizes(corner)
    where = np.einsum("qc,mca->mqa", INNER, corner).reshape(-1, 3)
    steep = np.maximum(np.linalg.norm(model.gradient(where)[0], axis=1), FLATTEST)
    return where, np.repeat(size / 3, 3) / steep


def _sizes(corner: Floats) -> Floats:
    """(m,) areas of triangles (m, 3, 3)."""
    double = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.asarray(np.linalg.norm(double, axis=1) / 2)


def _areas(model: Model, level: float, points: Floats, triangles: Ints) -> tuple[float, float]:
    """Area of the triangles, and of those in which points of the surface above the middles of their edges cut them."""
    ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, which = np.unique(ends, axis=0, return_inverse=True)
    start = points[edges].mean(axis=1)
    most = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)[:, None] / 2
    low, high = np.array(model.grid.bounds).reshape(3, 2).T
    middle = start
    for _ in range(NEWTON):
        slope = model.gradient(middle)[0]
        steep = np.maximum((slope**2).sum(axis=1), FLATTEST)
        moved = np.clip(middle - ((model.at(middle)[0] - level) / steep)[:, None] * slope, low, high)
        middle = np.where(np.linalg.norm(moved - start, axis=1, keepdims=True) <= most, moved, middle)
    p, q, r = (points[triangles[:, c]] for c in range(3))
    pq, qr, rp = (middle[which.reshape(-1, 3)[:, c]] for c in range(3))
    four = sum(float(_sizes(np.stack(t, axis=1)).sum()) for t in ((p, pq, rp), (q, qr, pq), (r, rp, qr), (pq, qr, rp)))
    return float(_sizes(points[triangles]).sum()), four


def _volume(
    model: Model, part: kernels.solid.Part, where: Floats, weight: Floats, unit: str, holes: Sequence[Missing]
) -> Value:
    known = model.at(where)[1] if len(where) else Accuracy().end_from(model.accuracy, "the surface does not meet the grid")
    row = Matrix(csr_array(weight[None])) if len(where) else None
    cubic = f"{unit}³" if unit else ""
    accuracy = known.push(row, quantity="volume", unit=cubic) if row is not None else known
    if model.accuracy.missing:
        accuracy = accuracy.miss(*model.accuracy.missing)
    half = np.asarray([(part.high - part.low) / 2])
    accuracy = accuracy.add(Term(BOXES, "bound", "volume", cubic, half, Identity(1))).miss(*holes)
    return Value(value=(part.low + part.high) / 2, unit=cubic, name="volume", accuracy=accuracy)


def _area(model: Model, one: float, four: float, unit: str, holes: Sequence[Missing]) -> Value:
    square = f"{unit}²" if unit else ""
    why = "what an error of values changes of the area is not known"
    accuracy = Accuracy().end_from(model.accuracy, why).miss(Missing("Errors of the model", why), *model.accuracy.missing)
    left = (four - one) / 3
    accuracy = accuracy.add(Term(HALVED, "bound", "area", square, np.asarray([abs(left)]), Identity(1))).miss(*holes)
    return Value(value=four + left, unit=square, name="area", accuracy=accuracy)
