"""Cuboids along the axes between the points of a trace and where an error puts the particle (thesis figure 5.4 b)."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, accuracy_mapper

CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
FACES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


@accuracy_mapper("Cuboids", aliases=("error boxes", "trace error", "axis errors"), output="cuboids")
def cuboid(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    every: Annotated[int, Range(1, 100)] = 1,
) -> Geometry:
    """A cuboid at each point of a trace, with an edge along each axis as long as the error along it.

    From the point to where the source puts the particle, its opposite corner; around the point if the source knows no
    direction, a standard deviation or a bound.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest of the position
    exaggeration : edges are so many times as long as the error; printed in the picture. Of a velocity: time for which it is
        drawn
    k : standard deviations that a spread is drawn to
    every : a cuboid at every so-many-th point

    Raises
    ------
    ValueError : no such error, or a factor that is not above zero

    Accuracy: edges are true to scale unless exaggerated, which is printed; a volume then grows by the cube of the factor, so
        edges alone can be compared (thesis figure 5.9). The term that is shown goes on; all others end here. Where the
        estimate is not credible there is no cuboid.
    Source: Lopes 1999, 5.2.5, figures 5.4 and 5.9.
    """
    vector.checked(exaggeration, k)
    known = traces.accept(accuracy)
    term = vector.chosen(traces, known, source)
    places = vector.along(traces, known, [term])
    kept = places.every(every)
    where = places.where[kept]
    p, error = traces.points[where], vector.sizes(term, exaggeration, k)[where]
    low, high = (p, p - error) if term.kind == "signed" else (p - error, p + error)
    points = (low[:, None] + CORNERS * (high - low)[:, None]).reshape(-1, 3)
    faces = (8 * np.arange(len(where))[:, None, None] + FACES).reshape(-1, 4)
    note = {"signed": "opposite corner where the estimate puts the particle", "bound": "bound"}.get(term.kind, "")
    warning = "read the edges, not the volumes" if exaggeration != 1 else ""
    return Geometry(
        points=points,
        polygons=Cells.of(faces),
        values={"error": Field(np.repeat(term.size()[where], 6), "cell", term.unit)},
        origin=np.repeat(len(traces.vertices) + places.line[kept], 6),
        shows=vector.words(term, exaggeration, k, note, places, warning),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points([term], np.repeat(where, 8), known, traces, "cuboids"),
    )
