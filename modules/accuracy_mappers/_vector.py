"""The error of a position as a vector at each point of a trace: which term, where it is drawn, and how large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modules.accuracy_mappers._nested import nested
from modules.api import Accuracy, Geometry, Shown, Term, select
from modules.data import sweep
from modules.data.operators import Floats, blocks

Ints = NDArray[np.int64]

UNCREDITED = "no assessment"
"""Flag of the points from which on the estimate of the integration's error is not credible."""
ASSESSED = "two half steps"
"""The rule of the sources of which that flag speaks, however they are called."""
LEFT_OUT = "not drawn where the estimate is not credible"


@dataclass(frozen=True, eq=False)
class Along:
    """The places of traces where an error is drawn, in runs of consecutive points.

    Parameters
    ----------
    where : (m,) points of the traces
    offsets : (runs + 1,) run i has the places offsets[i]:offsets[i + 1]
    line : (m,) the line of each place
    left_out : how many places of the traces are not among them, for no finite and credible error is known there
    """

    where: Ints
    offsets: Ints
    line: Ints
    left_out: int

    def every(self, stride: int) -> Ints:
        """(k,) every so-many-th place of each run, from its first."""
        if stride < 1:
            raise ValueError(f"every must be at least 1, not {stride}")
        within = np.arange(len(self.where)) - np.repeat(self.offsets[:-1], np.diff(self.offsets))
        return np.flatnonzero(within % stride == 0)


def vectors(known: Accuracy) -> list[Term]:
    """The terms that are vectors at points: of positions, and of velocities."""
    return [t for t in known.select(place="point") if t.components == 3 and t.quantity in ("position", "velocity")]


def chosen(traces: Geometry, known: Accuracy, source: str | None) -> Term:
    """The vector term by the name of its source; or the largest of those of the position.

    Raises
    ------
    ValueError : there is none, or none of that name
    """
    terms = vectors(known)
    positions = [t for t in terms if t.quantity == "position"]
    if not (terms if source else positions) or not len(traces.lines):
        raise ValueError("the lines know no error of their positions as a vector: wire the traces of 'trace'")
    if not source:
        return max(positions, key=lambda t: float(np.nan_to_num(t.size(), posinf=0.0).max(initial=0.0)))
    found = [t for t in terms if t.name == source]
    if not found:
        raise ValueError(f"there is no source {source!r}; vector terms are {', '.join(repr(t.name) for t in terms)}")
    return found[0]


def checked(exaggeration: float, k: float = 2.0) -> None:
    """Refuse factors that give no picture."""
    if not exaggeration > 0:
        raise ValueError(f"errors {exaggeration:g} times as large are no picture: give a number above zero")
    if not k > 0:
        raise ValueError(f"k = {k:g} standard deviations are no width: give a number above zero")


def spread(term: Term) -> bool:
    """Whether its sizes are standard deviations."""
    return term.kind in ("linear", "members")


def sizes(term: Term, exaggeration: float, k: float) -> Floats:
    """(n, 3) the error at each point as it is drawn: k standard deviations of a spread, else as it is."""
    return np.asarray(term.error() * exaggeration * (k if spread(term) else 1.0))


def shares(term: Term, k: float, steps: int) -> Floats:
    """Sizes of nested shapes as parts of the whole, the widest first: even steps of the density of a spread, else even.

    Raises
    ------
    ValueError : less than one step
    """
    if steps < 1:
        raise ValueError(f"a soft edge has one step or more, not {steps}")
    return nested(k, steps) / k if spread(term) else np.arange(steps, 0, -1) / steps


def credible(known: Accuracy, term: Term, size: Floats) -> NDArray[np.bool_]:
    """(n,) whether the size (n,) of a term is finite, and its estimate credible."""
    good = np.isfinite(size)
    for flag in known.flags:
        if flag.name == UNCREDITED and flag.items is not None and term.source.rule_name == ASSESSED:
            good[flag.items] = False
    return good


def along(traces: Geometry, known: Accuracy, terms: Sequence[Term], least: int = 1) -> Along:
    """Where the errors are finite and their estimates credible.

    Parameters
    ----------
    least : runs of fewer points are left out
    """
    lines = traces.lines
    good = np.logical_and.reduce([credible(known, term, term.size()) for term in terms])
    runs: list[Ints] = []
    owners: list[int] = []
    for i, (a, b) in enumerate(pairwise(lines.offsets)):
        places = np.arange(a, b)
        kept = good[lines.connectivity[a:b]]
        parts = np.split(places, np.flatnonzero(np.diff(kept)) + 1) if len(places) else []
        found = [p for p in parts if kept[p[0] - a] and len(p) >= least]
        runs += found
        owners += [i] * len(found)
    where = lines.connectivity[np.concatenate([np.zeros(0, np.int64), *runs])]
    lengths = np.array([len(r) for r in runs], np.int64)
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    return Along(where, offsets, np.repeat(np.array(owners, np.int64), lengths), len(lines.connectivity) - len(where))


def directions(traces: Geometry, places: Along) -> Floats:
    """(m, 3) unit direction of the trace at each place."""
    return sweep.directions(traces.points[places.where], places.offsets)


def at_points(terms: Sequence[Term], where: Ints, known: Accuracy, traces: Geometry, what: str) -> Accuracy:
    """The terms on the points of a glyph, each standing for point `where` of the traces, and the end of all others."""
    rows = (where[:, None] * 3 + np.arange(3)).ravel()
    pushed = tuple(t.push(select(rows, 3 * t.count), place="point") for t in terms)
    which = "one source only" if len(terms) == 1 else "these sources only"
    why = f"the {what} shows {which}: {', '.join(t.name for t in terms)}"
    only = Accuracy(pushed, known.missing, (), known.ended)
    return only.end_from(known, why).end_from(traces.accuracy, why)


def words(
    term: Term, factor: float, k: float | None, note: str, places: Along | None = None, warning: str = ""
) -> tuple[Shown, ...]:
    """For the legend: what is shown and in which sense, and the exaggeration.

    A velocity is drawn as the way that it makes in `factor` units of time, which is no exaggeration and stands in the note.

    Parameters
    ----------
    k : standard deviations that a spread is drawn to; None where it is not drawn by its size
    note : in which sense a position is drawn
    warning : how it may mislead
    """
    parts = [note if term.quantity == "position" else ""]
    if spread(term) and k is not None:
        parts.append(f"to k = {k:g}")
    if term.quantity == "velocity":
        _, _, unit = term.unit.partition("/")
        parts.append(f"drawn as the way made in {factor:g} {unit or 'units of time'}")
    parts += [warning, LEFT_OUT if places is not None and places.left_out else ""]
    scale = 1.0 if term.quantity == "velocity" else factor
    return (Shown(term.name, term.quantity, "; ".join(p for p in parts if p), scale),)


def covariance(terms: Sequence[Term], items: Ints) -> Floats:
    """(m, 3, 3) covariance of the errors at some points, of independent sources together.

    Parameters
    ----------
    terms : spreads, vectors at the same points
    items : the points
    """
    total = np.zeros((len(items), 3, 3))
    for term in terms:
        for some in blocks(len(items), 4096):
            rows = (items[some, None] * 3 + np.arange(3)).ravel()
            total[some] += _members(term, rows) if term.kind == "members" else _linear(term, rows)
    return total


def _linear(term: Term, rows: Ints) -> Floats:
    matrix = term.operator.rows(rows).tocsr()
    matrix.sum_duplicates()
    matrix.data = matrix.data * (term.value if term.value.ndim == 0 else term.value[matrix.indices])
    parts = [matrix[c::3] for c in range(3)]
    found = np.empty((len(rows) // 3, 3, 3))
    for a in range(3):
        for b in range(a, 3):
            found[:, a, b] = found[:, b, a] = np.asarray(parts[a].multiply(parts[b]).sum(axis=1)).ravel()
    return found


def _members(term: Term, rows: Ints) -> Floats:
    matrix = term.operator.rows(rows)
    draws = np.stack([matrix @ member for member in term.value]).reshape(len(term.value), -1, 3)
    away = draws - draws.mean(axis=0)
    return np.asarray(np.einsum("kni,knj->nij", away, away) / (len(draws) - 1))


def sections(traces: Geometry, terms: Sequence[Term], places: Along) -> tuple[Floats, Floats, Floats]:
    """The covariance of spreads in the plane across the trace at each place.

    Returns
    -------
    two unit vectors (m, 3) that span the plane, carried along without twist; (m, 2, 2) covariance in them
    """
    u = directions(traces, places)
    first = sweep.across(u, places.offsets)
    plane = np.stack([first, np.cross(u, first)], axis=1)
    return first, plane[:, 1], np.asarray(plane @ covariance(terms, places.where) @ plane.transpose(0, 2, 1))
