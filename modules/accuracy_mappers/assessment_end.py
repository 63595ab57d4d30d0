"""Where along a trace the estimate of its error ends, said in words beside the place."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Cells, Field, Geometry, accuracy_mapper


@accuracy_mapper("End of assessment", aliases=("no assessment", "credible", "global error"), output="ends")
def assessment_end(
    traces: Geometry, accuracy: Accuracy | None = None, *, words: str = "no assessment from here on"
) -> Geometry:
    """A point where the estimate of the integration's error is first not credible, with words for 'names' to write.

    Parameters
    ----------
    traces : lines whose estimate may end
    accuracy : of the same traces; their own by default
    words : written beside the points; "" writes nothing

    Accuracy: says where the estimate of one source ends; beyond, its size is not known. The errors of the position go on, all
        other terms end here.
    Source: Lopes 1999, 5.2.4 and figure 5.10: what is not credible is discarded from there on.
    """
    known = traces.accept(accuracy)
    bad = np.zeros(len(traces.points), bool)
    for flag in known.flags:
        if flag.name == vector.UNCREDITED and flag.items is not None:
            bad[flag.items] = True
    c, o = traces.lines.connectivity, traces.lines.offsets
    begins = np.zeros(len(c), bool)
    begins[o[:-1][np.diff(o) > 0]] = True
    before = np.append(False, bad[c][:-1]) & ~begins
    first = np.flatnonzero(bad[c] & ~before)
    where = c[first]
    line = np.searchsorted(o, first, side="right") - 1
    return Geometry(
        points=traces.points[where],
        vertices=Cells.of(np.arange(len(where))[:, None]),
        values={"name": Field(np.full(len(where), words, dtype=f"U{max(1, len(words))}"))},
        origin=len(traces.vertices) + line,
        cell=traces.cell,
        frame=traces.frame,
        name=words or "end of assessment",
        time=traces.time,
        accuracy=vector.at_points(vector.vectors(known), where, known, traces, "end of assessment"),
    )
