"""The tube around a trace in which the particle could lie (thesis figures 5.4 d, 5.5 and 5.7)."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, accuracy_mapper
from modules.data import sweep
from modules.data.operators import Floats


@accuracy_mapper("Tube", version=2, aliases=("error tube", "trace error", "uncertainty tube"), output="tube")
def tube(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    steps: Annotated[int, Range(1, 20)] = 1,
    sides: Annotated[int, Range(3, 64)] = 20,
) -> Geometry:
    """A tube through each point P of a trace and the place Q where one source of error puts the particle.

    Across the direction u of the trace the circle has its centre half way to Q, P + (I - u u^T)(Q - P) / 2, and runs
    through P. A source that knows no direction, a standard deviation or a bound, gives a circle around P.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest of the position
    exaggeration : errors are drawn so many times as large; printed in the picture. Of a velocity: time for which it is drawn
    k : standard deviations that a spread is drawn to
    steps : nested tubes; drawn translucent, several give a soft edge: dense where the particle is likely
    sides : of each circle

    Raises
    ------
    ValueError : no such error, or a factor that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed. The term that is shown goes on; all others end here. An
        error along the trace has no width: it does not show in a tube. Where the estimate is not credible there is no tube.
    Source: Lopes 1999, figure 5.5; radius |(I - u u^T)(Q - P)| / 2.
    """
    vector.checked(exaggeration, k)
    if sides < 3:
        raise ValueError(f"a circle of {sides} sides is none: give at least 3")
    known = traces.accept(accuracy)
    term = vector.chosen(traces, known, source)
    places = vector.along(traces, known, [term], 2)
    u = vector.directions(traces, places)
    error = vector.sizes(term, exaggeration, k)[places.where]
    centre, radius = circles(traces.points[places.where], u, error, term.kind == "signed")
    first = sweep.across(u, places.offsets)
    second = np.cross(u, first)
    shares = vector.shares(term, k, steps)
    points = [sweep.rings(centre, r[:, None] * first, r[:, None] * second, sides) for r in (s * radius for s in shares)]
    quads, n = sweep.quads(places.offsets, sides), len(places.where)
    drawn = np.tile(np.repeat(places.where, sides), steps)
    line = len(traces.vertices) + places.line[sweep.chunks(places.offsets)]
    note = "between trace and estimate" if term.kind == "signed" else ""
    return Geometry(
        points=np.concatenate(points),
        polygons=Cells.of(np.concatenate([quads + i * n * sides for i in range(steps)])),
        values={
            "error": Field(term.size()[drawn], "point", term.unit),
            "share": Field(np.repeat(shares, len(quads)), "cell"),
        },
        origin=np.tile(np.repeat(line, sides), steps),
        shows=vector.words(term, exaggeration, k, note, places),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points([term], drawn, known, traces, "tube"),
    )


def circles(p: Floats, u: Floats, error: Floats, signed: bool) -> tuple[Floats, Floats]:
    """Centre and radius of the circle at each point p of direction u, by its error (position - true).

    Source: Lopes 1999, figure 5.5.
    """
    if signed:
        across = -0.5 * (error - (error * u).sum(axis=1, keepdims=True) * u)
        return p + across, np.linalg.norm(across, axis=1)
    return p, np.sqrt((error**2 * (1 - u**2)).sum(axis=1))
