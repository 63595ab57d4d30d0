"""Where particles end, as the beginning of another run: back to where they came from, or on through another flow."""

from __future__ import annotations

import numpy as np

from modules.api import Accuracy, Cells, Field, Geometry, Missing, mapper, select


@mapper("Ends of traces", aliases=("exit points", "backward run", "last positions", "seeds"), output="seeds")
def trace_ends(traces: Geometry, *, first: bool = False) -> Geometry:
    """The last point of each trace, or the first; wired as seeds of another trace, it goes on from there.

    Parameters
    ----------
    traces : lines with times, as 'trace' gives them
    first : the points where the traces begin in place of those where they end

    Raises
    ------
    ValueError : lines without times

    Values: all that the traces know at these points, `time` among them.

    Accuracy: errors of the points go on. What belongs to other cells ends here. A trace that left no line, since it could not
        begin, has no end: it is missing.
    Source: Lopes 1999, figure 5.8: a second integration backwards from where the first one ended.
    """
    if "time" not in traces.values or traces.values["time"].place != "point":
        raise ValueError("the lines have no times: wire the traces of 'trace'")
    o, c = traces.lines.offsets, traces.lines.connectivity
    drawn = np.flatnonzero(np.diff(o) > 0)
    where = c[o[:-1][drawn]] if first else c[o[1:][drawn] - 1]
    rows = (where[:, None] * 3 + np.arange(3)).ravel()
    kept = []
    for term in traces.accuracy.select(place="point"):
        kept.append(term.push(select(where if term.components == 1 else rows, term.components * term.count), place="point"))
    accuracy = Accuracy(tuple(kept), traces.accuracy.missing, (), traces.accuracy.ended).end_from(
        traces.accuracy, "it is of other places than the ends of the lines"
    )
    if not len(where):
        accuracy = accuracy.miss(Missing("Ends", "no particle could begin, so no trace has an end"))
    return Geometry(
        points=traces.points[where],
        vertices=Cells.of(np.arange(len(where))[:, None]),
        values={n: Field(v.values[where], "point", v.unit) for n, v in traces.values.items() if v.place == "point"},
        origin=len(traces.vertices) + drawn,
        cell=traces.cell,
        frame=traces.frame,
        name="ends",
        time=traces.time,
        accuracy=accuracy,
    )
