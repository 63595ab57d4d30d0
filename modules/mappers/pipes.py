"""Lines as pipes of one thickness, lit: streamlines that are seen in space."""

from __future__ import annotations

import numpy as np

from modules.api import Annotated, Cells, Geometry, Range, mapper
from modules.data import sweep
from modules.mappers._carried import Carried, size_of

SHARE = 0.004
"""Automatic radius, as a part of the diagonal of all points."""


@mapper("Pipes", aliases=("stream tubes", "thick lines", "wires", "streamlines"), output="pipes")
def pipes(
    geometry: Geometry,
    *,
    radius: Annotated[float | None, Range(low=0)] = None,
    sides: Annotated[int, Range(3, 48)] = 12,
) -> Geometry:
    """A pipe around each line. Its thickness says nothing: where a particle may be is shown by the accuracy mappers.

    Parameters
    ----------
    geometry : lines
    radius : of the pipes; automatic: 0.4 % of the diagonal of all points
    sides : of each pipe

    Raises
    ------
    ValueError : no lines, or a radius that is not above zero

    Accuracy: errors of points and segments go on, for all points around a place of the line as for the place; the surface
        itself lies a radius away from the line by design.
    Source: circles across the line, in frames carried along without twist.
    """
    if not len(geometry.lines) and len(geometry.points):
        raise ValueError("the geometry has no lines to put pipes around")
    if sides < 3:
        raise ValueError(f"a pipe of {sides} sides is none: give at least 3")
    size = size_of(geometry, radius, SHARE, "radius")
    where, offsets = geometry.lines.connectivity, geometry.lines.offsets
    centre = geometry.points[where]
    u = sweep.directions(centre, offsets)
    across = sweep.across(u, offsets)
    line = np.repeat(np.arange(len(geometry.lines)), geometry.lines.sizes())
    begins = sweep.chunks(offsets)
    cell = np.repeat(len(geometry.vertices) + line[begins], sides)
    carried = Carried(geometry, np.repeat(where, sides), cell, np.repeat(np.arange(len(begins)), sides))
    return Geometry(
        points=sweep.rings(centre, size * across, size * np.cross(u, across), sides),
        polygons=Cells.of(sweep.quads(offsets, sides)),
        values=carried.values(),
        origin=cell,
        shows=geometry.shows,
        cell=geometry.cell,
        frame=geometry.frame,
        name=geometry.name,
        time=geometry.time,
        accuracy=carried.accuracy("pipes are made of lines; this speaks of something else"),
    )
