"""The edges at which a surface ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import Cells, Geometry, mapper, select
from modules.mappers._isosurface_methods import open_edges as single


@mapper("Open edges", aliases=("holes", "rims", "boundary edges", "borders of a surface"), output="edges")
def open_edges(geometry: Geometry) -> Geometry:
    """The edges with only one polygon: where a surface meets the border of its grid, a hole in the data, or has a hole itself.

    Polygons of more than three sides are taken as fans of triangles.

    Parameters
    ----------
    geometry : with polygons

    Accuracy: points go on with all that is known of them; what belongs to polygons ends.
    Source: each edge of a closed surface has two polygons (Lopes 1999, 4.1.1).
    """
    ends = single(geometry.points, geometry.triangles) if len(geometry.polygons) else np.zeros((0, 2), np.int64)
    used, lines = np.unique(ends, return_inverse=True)
    here = select(used, len(geometry.points))
    terms = [t for t in geometry.accuracy.terms if t.place == "point"]
    accuracy = replace(geometry.accuracy, terms=tuple(terms), of=None).push(here)
    accuracy = accuracy.end_from(geometry.accuracy, "it belongs to polygons; edges have none")
    return Geometry(
        points=geometry.points[used],
        lines=Cells.of(lines.reshape(-1, 2)),
        cell=geometry.cell,
        frame=geometry.frame,
        name="open edges",
        time=geometry.time,
        accuracy=accuracy,
    )
