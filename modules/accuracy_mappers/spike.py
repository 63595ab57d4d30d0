"""Spikes from the points of a trace to where an error puts the particle (thesis figure 5.4 c)."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, accuracy_mapper


@accuracy_mapper("Spikes", version=2, aliases=("error vectors", "needles", "trace error"), output="spikes")
def spike(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    every: Annotated[int, Range(1, 100)] = 1,
) -> Geometry:
    """A line from each point of a trace to where one source of error puts the particle.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest of the position
    exaggeration : spikes are so many times as long as the error; printed in the picture. Of a velocity: time for which it
        is drawn
    k : standard deviations that a spread is drawn to
    every : a spike at every so-many-th point

    Raises
    ------
    ValueError : no such error, or a factor that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed. The term that is shown goes on; all others end here. A
        standard deviation or a bound has no sign: its spike shows the sizes along the axes. Where the estimate is not
        credible there is no spike.
    Source: Lopes 1999, 5.2.5 and figure 5.4.
    """
    vector.checked(exaggeration, k)
    known = traces.accept(accuracy)
    term = vector.chosen(traces, known, source)
    places = vector.along(traces, known, [term])
    kept = places.every(every)
    where = places.where[kept]
    p = traces.points[where]
    points = np.stack([p, p - vector.sizes(term, exaggeration, k)[where]], axis=1).reshape(-1, 3)
    note = {"signed": "to where the estimate puts the particle", "bound": "bound"}.get(term.kind, "")
    return Geometry(
        points=points,
        lines=Cells.of(np.arange(len(points)).reshape(-1, 2)),
        values={"error": Field(term.size()[where], "cell", term.unit)},
        origin=len(traces.vertices) + places.line[kept],
        shows=vector.words(term, exaggeration, k, note, places),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points([term], np.repeat(where, 2), known, traces, "spikes"),
    )
