"""Streamlines as ribbons that turn and widen with the fluid beside them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from modules.api import Annotated, Cells, Field, Geometry, Missing, Model, Range, mapper
from modules.data import sweep
from modules.data.operators import Floats
from modules.mappers._carried import Carried, size_of

SHARE = 0.02
"""Automatic width, as a part of the diagonal of all points."""
SLOWEST = 1e-12
"""Of the largest speed: a slower particle has no direction to turn about."""


@mapper("Ribbons", aliases=("stream ribbons", "twist", "vorticity", "streamlines"), output="ribbons")
def ribbons(
    traces: Geometry,
    model: Model | None = None,
    *,
    width: Annotated[float | None, Range(low=0)] = None,
    widen: bool = False,
    start: Annotated[float, Range(0, 360, unit="°")] = 0.0,
) -> Geometry:
    """A ribbon along each trace. With the velocity it turns as the fluid does around the trace, by half the vorticity along it.

    Parameters
    ----------
    traces : lines with their times
    model : velocity that the traces follow; without it a ribbon twists as little as can be
    width : of the ribbons; automatic: 2 % of the diagonal of all points
    widen : whether the width grows as the fluid spreads across the trace: its square as the area of a thread of fluid
    start : angle of all ribbons at their first point, in degrees

    Raises
    ------
    ValueError : no lines, lines without times where a velocity is wired, or a model that is no velocity

    Accuracy: errors of the points of the traces go on for both edges; the error of twist and width is not estimated.
    Source: Ueng, Sikorski and Ma 1996, after Lopes 1999, 2.5.3: twist rate (curl V . u) / 2, spread (div V - u . J u) / 2.
    """
    if not len(traces.lines) and len(traces.points):
        raise ValueError("the geometry has no lines to make ribbons of: wire the traces of 'trace'")
    size = size_of(traces, width, SHARE, "width")
    where, offsets = traces.lines.connectivity, traces.lines.offsets
    centre = traces.points[where]
    u = sweep.directions(centre, offsets)
    first = sweep.across(u, offsets)
    twist, spread = _turned(traces, model)
    angle = np.radians(start) + twist
    side = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(u, first)
    half = 0.5 * size * (np.exp(spread) if widen else np.ones(len(where)))[:, None] * side
    begins = sweep.chunks(offsets)
    line = np.repeat(np.arange(len(traces.lines)), traces.lines.sizes())
    cell = len(traces.vertices) + line[begins]
    carried = Carried(traces, np.repeat(where, 2), cell, np.arange(len(begins)))
    accuracy = carried.accuracy("ribbons are made of lines; this speaks of something else")
    if model is not None:
        why = "the twist looks at differences of the velocity, whose errors are not estimated"
        accuracy = accuracy.miss(Missing("Twist of the ribbons", why)).end_from(model.accuracy, why)
    return Geometry(
        points=np.stack([centre - half, centre + half], axis=1).reshape(-1, 3),
        polygons=Cells.of(sweep.quads(offsets, 2, closed=False)),
        values={**carried.values(), "twist": Field(np.repeat(np.degrees(twist), 2), "point", "°")},
        origin=cell,
        shows=traces.shows,
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=accuracy,
    )


def _turned(traces: Geometry, model: Model | None) -> tuple[Floats, Floats]:
    """(m,) angle by which the fluid has turned around each place of the lines, and the logarithm of how it has spread."""
    where, offsets = traces.lines.connectivity, traces.lines.offsets
    if model is None:
        return np.zeros(len(where)), np.zeros(len(where))
    if model.samples.components != 3:
        raise ValueError("ribbons turn with a velocity: wire the model of vectors that the traces follow")
    if "time" not in traces.values or traces.values["time"].place != "point":
        raise ValueError("the lines have no times, so nothing turns along them: wire the traces of 'trace'")
    time = np.asarray(traces.values["time"].values, float)[where]
    jacobian = _jacobian(model, traces.points[where])
    velocity, _ = model.at(traces.points[where])
    speed = np.linalg.norm(velocity, axis=1)
    moving = speed > SLOWEST * speed.max(initial=0.0)
    u = np.where(moving[:, None], velocity / np.where(moving, speed, 1.0)[:, None], 0.0)
    curl = np.stack([jacobian[:, i, j] - jacobian[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
    rates = np.stack([
        0.5 * (curl * u).sum(axis=1),
        0.5 * (np.trace(jacobian, axis1=1, axis2=2) - np.einsum("ni,nij,nj->n", u, jacobian, u)),
    ])  # fmt: skip
    total = np.zeros_like(rates)
    for a, b in pairwise(offsets):
        steps = 0.5 * (rates[:, a : b - 1] + rates[:, a + 1 : b]) * np.diff(time[a:b])
        total[:, a + 1 : b] = np.cumsum(steps, axis=1)
    return total[0], total[1]


def _jacobian(model: Model, points: Floats) -> Floats:
    """(n, 3, 3) derivative of component i of the velocity along axis j."""
    flat = model.samples.values.reshape(model.grid.count, 3).astype(float, copy=False)
    found = np.zeros((len(points), 3, 3))
    for j, slope in enumerate(model.law.slopes(model.grid, points)):
        for i in range(3):
            found[:, i, j] = slope.apply(flat[:, i])
    return found
