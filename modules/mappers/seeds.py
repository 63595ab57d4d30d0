"""Where particles begin: a point, a rake, a plane, a grid or random places within the domain of a model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Annotated, Cells, Geometry, Identity, Literal, Model, Position, Range, Source, Term, mapper

Floats = NDArray[np.float64]

MOST = 2_000_000
INSET = 0.1
"""Part of the domain that automatic corners leave at each side: particles at a border leave at once, or rest."""


@mapper("Seeds", aliases=("rake", "start points", "particles", "release"), output="seeds")
def seeds(
    model: Model,
    *,
    arrangement: Literal["line", "point", "plane", "grid", "ring", "sphere", "random"] = "line",
    first: Annotated[tuple[float, ...] | None, Position(of="model")] = None,
    last: Annotated[tuple[float, ...] | None, Position(of="model")] = None,
    count: Annotated[int, Range(1, 1000, log=True)] = 10,
    seed: int = 1,
) -> Geometry:
    """Positions in the domain of a model where particles begin.

    Parameters
    ----------
    model : whose domain is seeded
    arrangement : point (first alone); line, a rake from first to last; plane and grid, with `count` positions along each
        side of the rectangle or box between first and last; ring, a closed rake on the ellipse in that rectangle; sphere,
        even over the ellipsoid in that box; random, evenly spread in the box
    first, last : x, y[, z] of opposite corners; automatic: the domain less a tenth at each side, and for a plane or
        ring its middle along x; for a point the centre. A view can set both
    count : positions of a line, ring or sphere or at random, or along each side of a plane or grid
    seed : of the random places

    Raises
    ------
    ValueError : corners of the wrong length, a plane or ring whose corners agree in no coordinate, or too many seeds

    Accuracy: seeds are where they are said to be, up to rounding. Errors of the model's values end here: seeds do not look
        at them.
    Source: rake and plane of seeds are common practice; Lopes 1999, 5.1 begins with one position.
    """
    if count < 1:
        raise ValueError(f"count must be at least 1, not {count}")
    low, high = _corners(model, arrangement, first, last)
    points = _places(arrangement, low, high, count, model.grid.dimensions, seed)
    unit = model.grid.frame.units[0]
    source = Source("Seeds", "mapping", "exact", "where they are said to be [seeds/1]")
    exact = Term(source, "bound", "position", unit, np.asarray(0.0), Identity(3 * len(points)), "point", 3)
    why = "seeds do not look at the values of the model"
    return Geometry(
        points=points,
        vertices=Cells.of(np.arange(len(points))[:, None]),
        frame=model.grid.frame,
        name="seeds",
        accuracy=Accuracy((exact,)).end_from(model.accuracy, why),
    )


def _corners(
    model: Model, arrangement: str, first: tuple[float, ...] | None, last: tuple[float, ...] | None
) -> tuple[Floats, Floats]:
    """(3,) opposite corners, those given or automatic ones."""
    d = model.grid.dimensions
    bounds = np.asarray(model.grid.bounds).reshape(3, 2)
    span = bounds[:, 1] - bounds[:, 0]
    low, high = bounds[:, 0] + INSET * span, bounds[:, 1] - INSET * span
    if arrangement in ("plane", "ring") and d == 3:
        low[0] = high[0] = bounds[0].mean()
    if arrangement == "point":
        low = bounds.mean(axis=1)
    for name, given, corner in (("first", first, low), ("last", last, high)):
        if given is not None:
            if len(given) < d:
                raise ValueError(f"{name} = {given} must have {d} coordinates, as the model has")
            corner[:d] = given[:d]
    return low, high


def _places(arrangement: str, low: Floats, high: Floats, count: int, d: int, seed: int) -> Floats:
    if arrangement == "point":
        return low[None]
    if arrangement == "line":
        part = np.linspace(0.0, 1.0, count) if count > 1 else np.array([0.5])
        return np.asarray(low + part[:, None] * (high - low))
    if arrangement in ("random", "ring", "sphere") and count > MOST:
        raise ValueError(f"{count} seeds are too many: at most {MOST}")
    if arrangement == "random":
        return np.asarray(low + np.random.default_rng(seed).random((count, 3)) * (high - low))
    flat = low[:d] == high[:d]
    if arrangement in ("plane", "ring") and d == 3 and not flat.any():
        raise ValueError(f"first and last of a {arrangement} must agree in one coordinate: it lies across it")
    if arrangement == "ring":
        return _ring(low, high, count, int(np.argmax(low == high)))
    if arrangement == "sphere":
        return _sphere(low, high, count)
    if float(count) ** int((~flat).sum()) > MOST:
        raise ValueError(f"{count} seeds along each side are too many")
    ends = zip(low, high, strict=True)
    sides = [np.array([0.5 * (a + b)]) if a == b or count == 1 else np.linspace(a, b, count) for a, b in ends]
    z, y, x = np.meshgrid(sides[2], sides[1], sides[0], indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def _ring(low: Floats, high: Floats, count: int, across: int) -> Floats:
    """Positions on the ellipse between two corners of a rectangle that lies across an axis."""
    turn = 2 * np.pi * np.arange(count) / count
    circle = np.zeros((count, 3))
    circle[:, [a for a in range(3) if a != across]] = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.asarray((low + high) / 2 + circle * (high - low) / 2)


def _sphere(low: Floats, high: Floats, count: int) -> Floats:
    """Positions on the ellipsoid between two corners of a box: a spiral of equal areas of the sphere."""
    up = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (1 + math.sqrt(5)) * np.arange(count)
    flat = np.sqrt(1 - up**2)
    ball = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    return np.asarray((low + high) / 2 + ball * (high - low) / 2)
