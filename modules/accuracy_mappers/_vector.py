"""The error of a position as a vector at each point of a trace: which term, and how it is drawn to scale."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Geometry, Shown, Term, select

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def chosen(traces: Geometry, known: Accuracy, source: str) -> Term:
    """The vector term of the position by the name of its source, or the largest.

    Raises
    ------
    ValueError : there is none, or none of that name
    """
    terms = [t for t in known.select("position", "point") if t.components == 3]
    if not terms or not len(traces.lines):
        raise ValueError("the lines know no error of their positions as a vector: wire the traces of 'trace'")
    if not source:
        return max(terms, key=lambda t: float(np.nan_to_num(t.size()).max(initial=0.0)))
    found = [t for t in terms if t.name == source]
    if not found:
        raise ValueError(f"there is no source {source!r}; vector terms are {', '.join(repr(t.name) for t in terms)}")
    return found[0]


def at_points(term: Term, where: Ints, known: Accuracy, traces: Geometry, what: str) -> Accuracy:
    """The term on the points of a glyph, and the end of all others."""
    rows = (where[:, None] * 3 + np.arange(3)).ravel()
    only = Accuracy((term.push(select(rows, 3 * term.count), place="point"),), known.missing, (), known.ended)
    why = f"the {what} shows one source only: {term.name}"
    return only.end_from(known, why).end_from(traces.accuracy, why)


def words(term: Term, factor: float) -> tuple[Shown, ...]:
    """For the legend: what is shown, in which sense, and the exaggeration."""
    note = {
        "signed": "to where the estimate puts the particle", "linear": "one standard deviation",
        "members": "one standard deviation", "bound": "bound",
    }.get(term.kind, "")  # fmt: skip
    return (Shown(term.name, "position", note, factor),)


def directions(traces: Geometry) -> tuple[Floats, Ints]:
    """(n, 3) unit direction of the line at each place in its list of points, and (n,) the line of each."""
    lines = traces.lines
    p = traces.points[lines.connectivity]
    along = np.zeros_like(p)
    line = np.repeat(np.arange(len(lines)), lines.sizes())
    for a, b in zip(lines.offsets[:-1], lines.offsets[1:], strict=True):
        if b - a > 1:
            step = np.diff(p[a:b], axis=0)
            along[a : b - 1] = step
            along[b - 1] = step[-1]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    return np.where(length > 0, along / np.where(length > 0, length, 1.0), (1.0, 0.0, 0.0)), line
