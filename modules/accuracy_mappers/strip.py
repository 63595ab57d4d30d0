"""The strip between a trace and where an error puts the particle (thesis figures 5.4 e, 5.6 and 5.8)."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, Term, accuracy_mapper
from modules.data import sweep
from modules.data.operators import Floats


@accuracy_mapper("Strip", aliases=("error ribbon", "trace error", "difference of traces"), output="strip")
def strip(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    steps: Annotated[int, Range(1, 20)] = 1,
) -> Geometry:
    """A surface from each point of a trace to where one source of error puts the particle, all along.

    The strip of a spread lies along its longest axis across the trace, on both sides.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest of the position
    exaggeration : errors are drawn so many times as large; printed in the picture. Of a velocity: time for which it is drawn
    k : standard deviations that a spread is drawn to
    steps : nested strips; drawn translucent, several give a soft edge

    Raises
    ------
    ValueError : no such error, a bound, which has no direction, or a factor that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed. The term that is shown goes on; all others end here. Of a
        spread only its largest direction is seen. Where the estimate is not credible there is no strip.
    Source: Lopes 1999, 5.2.5 and figure 5.4.
    """
    vector.checked(exaggeration, k)
    known = traces.accept(accuracy)
    term = vector.chosen(traces, known, source)
    if term.kind not in ("signed", "linear", "members"):
        raise ValueError(f"{term.name!r} is a {term.kind} without a direction: show it with 'cuboid' or 'tube'")
    places = vector.along(traces, known, [term], 2)
    p, where = traces.points[places.where], places.where
    shares = vector.shares(term, k, steps)
    if term.kind == "signed":
        away = -exaggeration * term.error()[where]
        ends = [(p, p + s * away) for s in shares]
    else:
        away = exaggeration * k * _widest(traces, term, places)
        ends = [(p - s * away, p + s * away) for s in shares]
    quads, n = sweep.quads(places.offsets, 2, closed=False), len(where)
    drawn = np.tile(np.repeat(where, 2), steps)
    note = "from the trace to the estimate" if term.kind == "signed" else "along its longest axis"
    return Geometry(
        points=np.concatenate([np.stack(pair, axis=1).reshape(-1, 3) for pair in ends]),
        polygons=Cells.of(np.concatenate([quads + 2 * n * i for i in range(steps)])),
        values={
            "error": Field(term.size()[drawn], "point", term.unit),
            "share": Field(np.repeat(shares, len(quads)), "cell"),
        },
        origin=np.tile(len(traces.vertices) + places.line[sweep.chunks(places.offsets)], steps),
        shows=vector.words(term, exaggeration, k, note, places),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points([term], drawn, known, traces, "strip"),
    )


def _widest(traces: Geometry, term: Term, places: vector.Along) -> Floats:
    """(m, 3) the largest standard deviation across the trace as a vector, which keeps its side along a run."""
    first, second, covariance = vector.sections(traces, [term], places)
    variance, axes = np.linalg.eigh(covariance)
    axis = axes[:, :, 1]
    turned = np.sign((axis[1:] * axis[:-1]).sum(axis=1))
    sides = np.cumprod(np.append(1.0, np.where(turned == 0, 1.0, turned)))
    half = np.sqrt(np.maximum(variance[:, 1], 0.0)) * sides
    return np.asarray(half[:, None] * (axis[:, :1] * first + axis[:, 1:] * second))
