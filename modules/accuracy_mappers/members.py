"""Other traces that the errors allow: a few members, drawn beside the one that was computed."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, Term, accuracy_mapper
from modules.data.operators import Floats


@accuracy_mapper("Members", aliases=("spaghetti", "draws", "ensemble", "other traces"), output="members")
def members(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    count: Annotated[int, Range(1, 50)] = 7,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    seed: int = 1,
) -> Geometry:
    """Where else a trace may run: draws of one source of error, each carried through as one; of a signed error, the other line.

    What the points of a trace have in common moves together, so each member is a line that could be, not a cloud.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest of the position
    count : of draws; an ensemble gives its own members, the first so many; a signed error gives one
    exaggeration : errors are drawn so many times as large; printed in the picture
    seed : of the draws

    Raises
    ------
    ValueError : no such error, a bound, which says nothing of what is likely, or a factor that is not above zero

    Accuracy: draws of normal errors with the stated standard deviations, to first order. The term that is shown goes on; all
        others end here.
    Source: members inside a band are misread less than its edge (Ruginski and others, Spatial Cognition and
        Computation 16(2), 2016).
    """
    vector.checked(exaggeration)
    if count < 1:
        raise ValueError(f"count must be at least 1, not {count}")
    known = traces.accept(accuracy)
    term = vector.chosen(traces, known, source)
    if term.quantity != "position":
        raise ValueError(f"{term.name!r} is an error of the {term.quantity}: it is not where another trace runs")
    places = vector.along(traces, known, [term], 2)
    draws = _draws(term, count, seed)
    n, runs = len(places.where), len(places.offsets) - 1
    at = np.concatenate([traces.points[places.where] - exaggeration * d[places.where] for d in draws])
    offsets = np.concatenate([[0], *(places.offsets[1:] + i * n for i in range(len(draws)))]).astype(np.int64)
    note = {"signed": "the trace that the estimate puts in its place", "linear": f"{len(draws)} draws"}.get(
        term.kind, f"{len(draws)} members"
    )
    return Geometry(
        points=at,
        lines=Cells(offsets, np.arange(len(at), dtype=np.int64)),
        values={"member": Field(np.repeat(np.arange(len(draws)), runs), "cell")},
        origin=np.tile(len(traces.vertices) + places.line[places.offsets[:-1]], len(draws)),
        shows=vector.words(term, exaggeration, None, note, places),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points([term], np.tile(places.where, len(draws)), known, traces, "members"),
    )


def _draws(term: Term, count: int, seed: int) -> list[Floats]:
    """Errors (n, 3) of all points, draw by draw."""
    if term.kind == "signed":
        return [term.error()]
    if term.kind == "members":
        mean = term.value.mean(axis=0)
        return [term.operator.apply(one - mean).reshape(-1, 3) for one in term.value[:count]]
    if term.kind != "linear":
        raise ValueError(f"{term.name!r} is a {term.kind}: it says nothing of what is likely, so there are no members")
    random = np.random.default_rng(seed)
    sigma = np.broadcast_to(term.value, (term.operator.shape[1],))
    return [term.operator.apply(sigma * random.standard_normal(len(sigma))).reshape(-1, 3) for _ in range(count)]
