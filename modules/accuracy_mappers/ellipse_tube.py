"""The tube of ellipses across a trace that holds the particle by the spread of its errors."""

from __future__ import annotations

import numpy as np

from modules.accuracy_mappers import _vector as vector
from modules.accuracy_mappers._nested import nested
from modules.api import Accuracy, Annotated, Cells, Choice, Field, Geometry, Range, Shown, Term, accuracy_mapper
from modules.data import sweep
from modules.data.operators import Floats


@accuracy_mapper("Ellipse tube", aliases=("covariance tube", "uncertainty ellipse", "confidence tube"), output="tube")
def ellipse_tube(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    source: Annotated[str | None, Choice(of="traces.vectors")] = None,
    exaggeration: Annotated[float, Range(1, 1e6, log=True)] = 1.0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    steps: Annotated[int, Range(1, 20)] = 4,
    sides: Annotated[int, Range(3, 64)] = 24,
) -> Geometry:
    """Ellipses across a trace at k standard deviations, by the covariance of the errors of its points.

    The covariance of each point, of all spreads together or of one, is cut by the plane across the trace: an error along
    the trace only puts the particle elsewhere on it. Other kinds of errors are not in the ellipses.

    Parameters
    ----------
    traces : lines with errors of their positions as vectors
    accuracy : of the same traces; their own by default
    source : name of one spread; automatic: all of them together
    exaggeration : errors are drawn so many times as large; printed in the picture
    k : standard deviations that the widest ellipse reaches
    steps : nested tubes; drawn translucent, several give a soft edge: dense where the particle is likely
    sides : of each ellipse

    Raises
    ------
    ValueError : no spread of the position is known, or a factor that is not above zero

    Accuracy: true to scale unless exaggerated, which is printed; of a normal error in the plane k = 2 holds 86 %, k = 2.45
        holds 95 %. The spreads that are shown go on; all other terms end here. To first order in the errors.
    Source: covariance C of independent sources together; half axes from the square root of (I - u u^T) C (I - u u^T).
    """
    vector.checked(exaggeration, k)
    if sides < 3 or steps < 1:
        raise ValueError(f"a tube has at least 3 sides and one step, not {sides} and {steps}")
    known = traces.accept(accuracy)
    terms = _spreads(traces, known, source)
    places = vector.along(traces, known, terms, 2)
    first, second, covariance = vector.sections(traces, terms, places)
    root = exaggeration * _root(covariance)
    a, b = (root[:, 0, i, None] * first + root[:, 1, i, None] * second for i in (0, 1))
    reach = nested(k, steps)
    points = [sweep.rings(traces.points[places.where], r * a, r * b, sides) for r in reach]
    quads, n = sweep.quads(places.offsets, sides), len(places.where)
    drawn = np.tile(np.repeat(places.where, sides), steps)
    widest = np.sqrt(np.linalg.eigvalsh(covariance)[:, 1].clip(min=0.0)) if n else np.zeros(0)
    line = len(traces.vertices) + places.line[sweep.chunks(places.offsets)]
    return Geometry(
        points=np.concatenate(points),
        polygons=Cells.of(np.concatenate([quads + i * n * sides for i in range(steps)])),
        values={
            "error": Field(np.tile(np.repeat(widest, sides), steps), "point", terms[0].unit),
            "k": Field(np.repeat(reach, len(quads)), "cell"),
        },
        origin=np.tile(np.repeat(line, sides), steps),
        shows=tuple(Shown(t.name, "position", f"ellipses to k = {k:g}", exaggeration) for t in terms),
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=vector.at_points(terms, drawn, known, traces, "tube"),
    )


def _spreads(traces: Geometry, known: Accuracy, source: str | None) -> list[Term]:
    """The standard deviations of the position that are asked for."""
    if source:
        term = vector.chosen(traces, known, source)
        if not (vector.spread(term) and term.quantity == "position"):
            raise ValueError(f"{source!r} is no spread of positions: it has no ellipse; 'tube' and 'strip' show it")
        return [term]
    terms = [t for t in vector.vectors(known) if vector.spread(t) and t.quantity == "position"]
    if not terms or not len(traces.lines):
        raise ValueError("no spread of the positions is known, so there is no ellipse: state the deviation of the data")
    return terms


def _root(covariance: Floats) -> Floats:
    """(m, 2, 2) the symmetric square root: it has no axes that could change places along a trace."""
    variance, axes = np.linalg.eigh(covariance)
    return np.asarray((axes * np.sqrt(np.maximum(variance, 0.0))[:, None]) @ axes.transpose(0, 2, 1))
