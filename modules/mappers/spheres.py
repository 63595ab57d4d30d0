"""Points as spheres: beads on a trace at equal times, seeds, sites."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import Annotated, Cells, Geometry, Range, mapper
from modules.data.operators import Floats
from modules.mappers._carried import Carried, size_of

Ints = NDArray[np.int64]

SHARE = 0.006
"""Automatic radius, as a part of the diagonal of all points."""
MOST = 5_000_000
"""More polygons are refused: they would fill the memory and no picture shows them."""


@mapper("Spheres", aliases=("beads", "balls", "glyphs", "particles"), output="spheres")
def spheres(
    geometry: Geometry,
    *,
    radius: Annotated[float | None, Range(low=0)] = None,
    every: Annotated[int, Range(1, 100)] = 1,
    facets: Annotated[int, Range(4, 48)] = 16,
) -> Geometry:
    """A sphere at each point: at the vertices, else at the points of the lines.

    On traces with an interval the spheres stand at equal times, so that where they lie apart the particle is fast.

    Parameters
    ----------
    geometry : points, or lines
    radius : of the spheres, which says nothing of the particle; automatic: 0.6 % of the diagonal of all points
    every : at every so-many-th point of each line, from its first
    facets : around each sphere

    Raises
    ------
    ValueError : a radius or a stride that is not above zero, or too many polygons

    Accuracy: errors of the points go on, for all points of a sphere as for its centre; a sphere with f facets lies up to
        1 - cos(pi / f) of its radius inside the true one.
    Source: Lopes 1999, 5.2.5: a sphere at each position, joined by straight lines.
    """
    if every < 1 or facets < 4:
        raise ValueError(f"every = {every} and facets = {facets}: at least 1 and 4 give spheres")
    where, cell = _centres(geometry, every)
    unit, quads = ball(facets)
    if len(where) * len(quads) > MOST:
        raise ValueError(f"{len(where)} spheres of {len(quads)} polygons are too many: fewer facets, or a larger 'every'")
    size = size_of(geometry, radius, SHARE, "radius")
    points = (geometry.points[where, None] + size * unit).reshape(-1, 3)
    faces = (len(unit) * np.arange(len(where))[:, None, None] + quads).reshape(-1, 4)
    carried = Carried(geometry, np.repeat(where, len(unit)), np.repeat(cell, len(quads)))
    return Geometry(
        points=points,
        polygons=Cells.of(faces),
        values=carried.values(),
        origin=np.repeat(cell, len(quads)) if len(cell) == len(where) else None,
        shows=geometry.shows,
        cell=geometry.cell,
        frame=geometry.frame,
        name=geometry.name,
        time=geometry.time,
        accuracy=carried.accuracy("spheres stand for points, not for what lies between them"),
    )


def _centres(geometry: Geometry, every: int) -> tuple[Ints, Ints]:
    """(n,) points that get a sphere, and the cell of each; no cells if there are neither vertices nor lines."""
    cells, first = (geometry.vertices, 0) if len(geometry.vertices) else (geometry.lines, len(geometry.vertices))
    if not len(cells):
        return np.arange(len(geometry.points), dtype=np.int64)[::every], np.zeros(0, np.int64)
    sizes = cells.sizes()
    step = 1 if len(geometry.vertices) else every
    within = np.arange(len(cells.connectivity)) - np.repeat(cells.offsets[:-1], sizes)
    kept = np.flatnonzero(within % step == 0)
    kept = kept[::every] if len(geometry.vertices) else kept
    return cells.connectivity[kept], first + np.repeat(np.arange(len(cells)), sizes)[kept]


def ball(facets: int) -> tuple[Floats, Ints]:
    """Points of a unit sphere in rings of `facets` from pole to pole, and its faces; at the poles two corners fall on one."""
    rows = max(2, facets // 2)
    up = np.pi * np.arange(rows + 1) / rows
    turn = 2 * np.pi * np.arange(facets) / facets
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    points = np.concatenate([np.column_stack([np.sin(a) * ring, np.full(facets, np.cos(a))]) for a in up])
    j = np.arange(facets)
    first = (facets * np.arange(rows))[:, None]
    quads = np.stack([first + j, first + facets + j, first + facets + (j + 1) % facets, first + (j + 1) % facets], axis=-1)
    return points, quads.reshape(-1, 4).astype(np.int64)
