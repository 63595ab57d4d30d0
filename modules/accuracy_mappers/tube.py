"""The tube around a trace in which the particle could lie (thesis figures 5.4 d, 5.5 and 5.7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.accuracy_mappers import _vector
from modules.api import Accuracy, Annotated, Cells, Field, Geometry, Range, accuracy_mapper

Floats = NDArray[np.float64]


@accuracy_mapper("Tube", aliases=("error tube", "trace error", "uncertainty tube"), output="tube")
def tube(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: str = "",
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    sides: Annotated[int, Range(3, 64)] = 20,
) -> Geometry:
    """A tube through each point P of a trace and the place Q where one source of error puts the particle.

    Across the direction u of the trace the circle has its centre half way to Q, P + (I - u u^T)(Q - P) / 2, and runs
    through P. A source that knows no direction, a standard deviation or a bound, gives a circle around P.

    Parameters
    ----------
    traces : lines with an error of their positions as a vector
    accuracy : of the same traces; their own by default
    source : name of the error to show; automatic: the largest
    exaggeration : errors are drawn so many times as large; printed in the picture
    sides : of each circle

    Raises
    ------
    ValueError : no such error, or an exaggeration that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed. The term that is shown goes on; all others end here. An
        error along the trace has no width: it does not show in a tube.
    Source: Lopes 1999, figure 5.5; radius |(I - u u^T)(Q - P)| / 2.
    """
    if not exaggeration > 0:
        raise ValueError(f"errors {exaggeration:g} times as large are no picture: give a number above zero")
    if sides < 3:
        raise ValueError(f"a circle of {sides} sides is none: give at least 3")
    known = traces.accept(accuracy)
    term = _vector.chosen(traces, known, source)
    where = traces.lines.connectivity
    u, line = _vector.directions(traces)
    centre, radius = rings(traces.points[where], u, exaggeration * term.error(), where, term.kind == "signed")
    across = _across(u, line)
    turn = 2 * np.pi * np.arange(sides) / sides
    other = np.cross(u, across)
    circle = np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * other[:, None]
    points = (centre[:, None] + radius[:, None, None] * circle).reshape(-1, 3)
    first = np.flatnonzero(line[1:] == line[:-1])
    j = np.arange(sides)
    k = (j + 1) % sides
    a, b = first[:, None] * sides, (first[:, None] + 1) * sides
    quads = np.stack([a + j, a + k, b + k, b + j], axis=-1).reshape(-1, 4)
    drawn = np.repeat(where, sides)
    return Geometry(
        points=points,
        polygons=Cells.of(quads),
        values={"error": Field(np.repeat(term.size()[where], sides), "point", term.unit)},
        origin=np.repeat(line[first], sides).astype(np.int64),
        shows=_vector.words(term, exaggeration),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=_vector.at_points(term, drawn, known, traces, "tube"),
    )


def rings(p: Floats, u: Floats, error: Floats, where: NDArray[np.int64], signed: bool) -> tuple[Floats, Floats]:
    """Centre and radius of the circle at each point p of direction u, by the error (position - true) of point `where`.

    Source: Lopes 1999, figure 5.5.
    """
    away = -error[where]
    if signed:
        across = 0.5 * (away - (away * u).sum(axis=1, keepdims=True) * u)
        return p + across, np.linalg.norm(across, axis=1)
    return p, np.sqrt((away**2 * (1 - u**2)).sum(axis=1))


def _across(u: Floats, line: NDArray[np.int64]) -> Floats:
    """A unit vector across each direction, carried along the line with as little twist as can be."""
    across = np.zeros_like(u)
    for i in range(len(u)):
        before = across[i - 1] if i and line[i] == line[i - 1] else np.eye(3)[np.argmin(np.abs(u[i]))]
        part = before - (before @ u[i]) * u[i]
        size = np.linalg.norm(part)
        if size < 1e-6:  # the trace turns back along the vector carried
            part = np.cross(u[i], np.eye(3)[np.argmin(np.abs(u[i]))])
            size = np.linalg.norm(part)
        across[i] = part / size
    return across
