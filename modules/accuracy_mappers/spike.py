"""Spikes from the points of a trace to where an error puts the particle (thesis figure 5.4 c)."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector
from modules.api import Accuracy, Annotated, Cells, Field, Geometry, Range, accuracy_mapper


@accuracy_mapper("Spikes", aliases=("error vectors", "needles", "trace error"), output="spikes")
def spike(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: str = "",
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    every: Annotated[int, Range(1, 100)] = 1,
) -> Geometry:
    """A line from each point of a trace to where one source of error puts the particle.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest
    exaggeration : spikes are so many times as long as the error; printed in the picture
    every : a spike at every so-many-th point

    Raises
    ------
    ValueError : no such error, or an exaggeration that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed. The term that is shown goes on; all others end here. A
        standard deviation or a bound has no sign: its spike shows the sizes along the axes.
    Source: Lopes 1999, 5.2.5 and figure 5.4.
    """
    if not exaggeration > 0:
        raise ValueError(f"errors {exaggeration:g} times as large are no picture: give a number above zero")
    if every < 1:
        raise ValueError(f"every must be at least 1, not {every}")
    known = traces.accept(accuracy)
    term = _vector.chosen(traces, known, source)
    where = traces.lines.connectivity[::every]
    p = traces.points[where]
    ends = p - exaggeration * term.error()[where]
    points = np.stack([p, ends], axis=1).reshape(-1, 3)
    return Geometry(
        points=points,
        lines=Cells.of(np.arange(len(points)).reshape(-1, 2)),
        values={"error": Field(term.size()[where], "cell", term.unit)},
        origin=where.astype(np.int64),
        shows=_vector.words(term, exaggeration),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=_vector.at_points(term, np.repeat(where, 2), known, traces, "spikes"),
    )
