"""A geometry coloured by the values of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Field, Flag, Frame, Gather, Geometry, Identity, Model, Source, Term, mapper
from modules.data.accuracy import Place, Rigour
from modules.data.operators import Floats
from modules.data.sampling import at_places, within

OTHER = "the colour is that of another model now"
STRAIGHT = Source(
    "Colours straight between points", "mapping", "estimated",
    "mean of the points less the value in the middle of a cell or segment [middle-of-cell/1]",
)  # fmt: skip
PLACES: tuple[Place, Place] = ("cell", "segment")
RULE = "slope of the model times the error of the place, to first order; JCGM 100:2008, 5.1"


@mapper(
    "Colour by",
    aliases=("map onto", "probe onto surface", "paint", "texture by", "sample on geometry", "second variable"),
    output="coloured",
)
def colour_by(geometry: Geometry, model: Model, *, name: str = "") -> Geometry:
    """Points, lines and polygons with the values that a model has there, to colour them by.

    A renderer shows them by this name. Of a vector the length is taken.

    Parameters
    ----------
    geometry : contour lines, surfaces, traces, points
    model : on a regular or rectilinear grid, in the same frame
    name : of the values; automatic: that of the data, or "value"

    Raises
    ------
    ValueError : nothing lies in the model, the frames differ, or the grid is bent or unstructured

    Accuracy: the error of a colour is that of the model at the place, and what the error of the place makes of it through the
    slope of the model. Errors of places that are known as vectors go on exactly, with what they have in common with the
    model; of others only the distance is known, and they count with the steepest slope. Places outside have no value, and
    are flagged. Between points colours are drawn straight; what that leaves is estimated in the middle of each cell.
    Source: JCGM 100:2008, 5.1.2; Lopes 1999, 2.4 (a second variable on a surface).
    """
    d = model.grid.dimensions
    if any(one[:d] != other[:d] for one, other in zip(_frame(geometry.frame), _frame(model.grid.frame), strict=True)):
        raise ValueError("the geometry and the model lie in different frames (names or units of axes): transform one of them")
    if model.samples.components == 9:
        raise ValueError("a tensor has no colour: take one of its invariants")
    called = name or model.samples.name or "value"
    known = replace(geometry.accuracy, of=None)
    for term in known.select("value"):
        known = known.end(term, OTHER) if term.id in {t.id for t in known.terms} else known
    values, errors, inside = at_places(model, geometry.points)
    if values.ndim > 1:
        values, errors = _length(values, errors)
    colour = Accuracy(tuple(replace(t, quantity="value") for t in errors.terms))
    moved, flags = _moved(geometry, model, known, inside, {t.id for t in colour.terms})
    accuracy = Accuracy.join([(Accuracy(known.terms, known.missing, (), known.ended), None), (colour, None), (moved, None)])
    accuracy = accuracy.add(*_straight(geometry, model, values)).miss(*errors.missing)
    accuracy = accuracy.end_from(replace(model.accuracy, of=None), "it speaks of cells, not of places")
    accuracy = accuracy.flag(*known.flags, *errors.flags, *flags)
    field = Field(values, "point", model.unit)
    return replace(geometry, values={**geometry.values, called: field}, accuracy=accuracy)


def _frame(frame: Frame) -> tuple[tuple[str, ...], tuple[str, ...]]:
    return frame.axes, frame.units


def _straight(geometry: Geometry, model: Model, values: Floats) -> tuple[Term, ...]:
    """What drawing colours straight between points leaves: their mean less the value in the middle of each cell or segment."""
    cells = np.zeros(geometry.counts["cell"])
    if len(geometry.polygons):
        o, c = geometry.polygons.offsets, geometry.polygons.connectivity
        size = np.diff(o)
        middle = np.add.reduceat(geometry.points[c], o[:-1], axis=0) / size[:, None]
        cells[-len(geometry.polygons) :] = np.add.reduceat(values[c], o[:-1]) / size - _middle(model, middle)
    pairs = geometry.segments()
    lines = values[pairs].mean(axis=1) - _middle(model, geometry.points[pairs].mean(axis=1))
    return tuple(
        Term(STRAIGHT, "signed", "value", model.unit, np.nan_to_num(one), Identity(len(one)), place)
        for one, place in ((cells, PLACES[0]), (lines, PLACES[1]))
        if np.nan_to_num(one).any()
    )


def _middle(model: Model, points: Floats) -> Floats:
    inside = within(model, points)
    found = np.full(len(points), np.nan)
    if inside.any():
        value = model.at(points[inside])[0]
        found[inside] = value if value.ndim == 1 else np.linalg.norm(value, axis=1)
    return found


def _length(values: Floats, errors: Accuracy) -> tuple[Floats, Accuracy]:
    """The length of vectors, to first order; where it is 0 nothing is known of its error."""
    size = np.linalg.norm(values, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.nan_to_num(values / size[:, None], nan=0.0)
    n = len(values)
    pushed = errors.push(Gather(np.arange(3 * n).reshape(n, 3), along, 3 * n), components=1)
    still = np.flatnonzero(size == 0)
    flags = errors.flags
    if len(still):
        words = f"the length is 0 at {len(still)} of {n} places: its error is not known"
        flags = (*flags, Flag("not linear", words, "point", still))
    return size, pushed.flag(*flags)


def _moved(
    geometry: Geometry, model: Model, known: Accuracy, inside: NDArray[np.bool_], shared: set[str]
) -> tuple[Accuracy, list[Flag]]:
    """What errors of the places do to the values there."""
    terms = [t for t in known.select("position") if t.place in ("point", "cell", "segment")]
    if not terms:
        return Accuracy(), []
    slope = _slopes(model, geometry.points, inside)
    found: list[Term] = []
    common = []
    for term in terms:
        if term.place == "point" and term.components == 3:
            n = len(slope)
            operator = Gather(np.arange(3 * n).reshape(n, 3), slope, 3 * n)
            found.append(term.push(operator, quantity="value", unit=model.unit, components=1))
            continue
        steep = _at_items(geometry, term, np.linalg.norm(slope, axis=1))
        source = Source(f"{term.name}, by its place", "mapping", _word(term), f"{RULE} [place-through-slope/1]")
        size = np.where(np.isfinite(s := term.size()), s, 0.0) if term.count else np.zeros(0)
        kind = term.kind if term.kind in ("linear", "bound") else "bound" if term.source.rigour == "proven" else "signed"
        if term.kind == "members":
            kind = "linear"
        if term.kind == "metric" or not size.any():
            continue
        found.append(Term(source, kind, "value", model.unit, size * steep, Identity(len(size)), term.place))
        if term.id in shared:
            common.append(term.name)
    flags = []
    if common:
        words = f"{' and '.join(common)}: places and values share this source; it is counted as if they did not"
        flags.append(Flag("common source", words, "point", None))
    return Accuracy(tuple(found)), flags


def _word(term: Term) -> Rigour:
    return "estimated" if term.source.rigour == "proven" else term.source.rigour


def _slopes(model: Model, points: Floats, inside: NDArray[np.bool_]) -> Floats:
    """(n, 3) gradient of the value, or of the length of the vector; 0 outside."""
    slope = np.zeros((len(points), 3))
    if not inside.any():
        return slope
    where = points[inside]
    parts = model.law.slopes(model.grid, where)
    flat = model.samples.values.reshape(model.grid.count, -1).astype(float, copy=False)
    by_component = np.zeros((len(where), flat.shape[1], 3))
    for axis, part in enumerate(parts):
        for c in range(flat.shape[1]):
            by_component[:, c, axis] = part.apply(np.ascontiguousarray(flat[:, c]))
    if flat.shape[1] == 1:
        slope[inside] = by_component[:, 0]
    else:
        value = model.at(where)[0]
        size = np.linalg.norm(value, axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            slope[inside] = np.einsum("nc,nca->na", np.nan_to_num(value / size), by_component)
    return np.nan_to_num(slope)


def _at_items(geometry: Geometry, term: Term, steep: Floats) -> Floats:
    """The steepest slope among the points of each item."""
    if term.place == "point":
        return steep
    if term.place == "segment":
        return np.asarray(steep[geometry.segments()].max(axis=1))
    parts = [steep[p.connectivity] for p in (geometry.vertices, geometry.lines, geometry.polygons)]
    starts = [p.offsets[:-1] for p in (geometry.vertices, geometry.lines, geometry.polygons)]
    return np.concatenate([np.maximum.reduceat(v, s) if len(s) else np.zeros(0) for v, s in zip(parts, starts, strict=True)])
