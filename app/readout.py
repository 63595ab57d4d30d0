"""What is known at one place of a picture: position, values, and each source of error in words and signs.

The terms of the shape are brought to the place by the weights of its points, so errors that points share are counted as
the algebra of accuracy counts them, and not point by point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import numbers
from app.draw.caption import HOW
from app.legend import IN_WORDS
from app.pick import Hit
from modules.data.accuracy import SIGNS, Accuracy, Flag, Missing, Rigour, Term
from modules.data.geometry import Geometry
from modules.data.grid import Frame
from modules.data.operators import Gather
from modules.data.scene import Layer
from modules.data.wires import Samples, Table

Floats = NDArray[np.float64]
Check = Callable[[float], object]

SPREAD = ("linear", "members")
BETWEEN = Missing("Interpolation between samples", "the picture draws straight on from sample to sample; no law is stated")


@dataclass(frozen=True, kw_only=True)
class Line:
    """One source of error at the place.

    Parameters
    ----------
    sign, rigour : how it is known
    number : with its unit; "±" before k standard deviations, a sign before an estimate of the error itself
    words, quantity, stage, rule : who made it, of what, where, and by which rule
    value : the number itself, standard deviations times k; infinite where there is no bound, NaN where nobody knows
    """

    sign: str
    rigour: Rigour
    number: str
    words: str
    quantity: str = ""
    unit: str = ""
    stage: str = ""
    rule: str = ""
    kind: str = ""
    value: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Total:
    """All that is known of one quantity together."""

    quantity: str
    unit: str
    sign: str
    rigour: Rigour
    number: str
    value: float


@dataclass(frozen=True, kw_only=True)
class Readout:
    """What stands in the box beside a picked place.

    Parameters
    ----------
    title : what was met
    place : where, and in which cell
    values : (name, number with unit)
    totals : one a quantity
    summary : these in words
    lines : the sources, those not known last
    flags : that touch the place
    """

    title: str
    place: str
    values: tuple[tuple[str, str], ...]
    totals: tuple[Total, ...]
    summary: str
    lines: tuple[Line, ...]
    flags: tuple[str, ...]
    k: float
    hit: Hit

    def plain(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)

    def text(self) -> str:
        """As it is copied."""
        out = [self.title, self.place, *(f"{name}: {number}" for name, number in self.values), "", self.summary]
        for one in self.lines:
            origin = ", ".join(part for part in (one.quantity, one.stage) if part)
            out.append("\t".join(part for part in (one.sign, one.number, one.words, origin) if part))
        out += [f"flag\t{words}" for words in self.flags]
        if any(one.kind in SPREAD for one in self.lines):
            out.append(f"± is k = {self.k:g} standard deviations")
        return "\n".join(out)


def read_out(layer: Layer, hit: Hit, *, k: float = 2.0, check: Check | None = None) -> Readout:
    """What is known at a place of a layer.

    Parameters
    ----------
    hit : where, as `app.pick.pick` gives it, or made by hand from a cell and weights
    k : coverage factor of standard deviations
    check : called with the fraction done; what it raises ends the work

    Raises
    ------
    ValueError : the place does not belong to the layer's shape

    Accuracy: terms on points go through the weights of the place, so |weights| x bounds add, standard deviations add in
        squares and an error that points share stays one. A measure of an item, such as an area, is that of the item.
    """
    here = _Here(layer, hit)
    terms = here.terms()
    lines = []
    for i, term in enumerate(terms):
        if check is not None:
            check(i / len(terms))
        lines.append(_line(term, k))
    known = Accuracy(terms)
    totals = tuple(_total(known, q, k) for q in dict.fromkeys(t.quantity for t in terms if t.kind != "metric"))
    missing = tuple(dict.fromkeys((*layer.accuracy.missing, *here.missing())))
    lines.sort(key=lambda one: ((one.quantity != "position"), one.quantity, -one.value))
    lines += [_unknown(m) for m in missing]
    return Readout(
        title=here.title(), place=here.place(), values=here.values(totals), totals=totals,
        summary=_summary(here.what(), totals, lines), lines=tuple(lines), flags=here.flags(), k=k, hit=hit,
    )  # fmt: skip


class _Here:
    """One place of one shape."""

    def __init__(self, layer: Layer, hit: Hit) -> None:
        self.layer, self.hit, self.shape = layer, hit, layer.shape
        counts = layer.accuracy.of.counts if layer.accuracy.of else getattr(self.shape, "counts", {})
        if counts and max(hit.points, default=0) >= counts.get("point", 0):
            raise ValueError(f"point {max(hit.points)} is none of the layer's {counts.get('point', 0)}: pick again")
        self.items = {"point": hit.points, "cell": (hit.cell,), "segment": (hit.segment,) if hit.segment >= 0 else ()}

    # --- accuracy

    def terms(self) -> tuple[Term, ...]:
        """The terms of the shape as one row each: of this place."""
        return tuple(found for t in self.layer.accuracy.terms if (found := self._here(t)) is not None)

    def _here(self, term: Term) -> Term | None:
        items = [i for i in self.items.get(term.place, ()) if i < term.count]
        if not items:
            return None
        weights = np.ones(1)
        if term.place == "point":
            weights = np.asarray(self.hit.weights, float)
            if term.kind == "metric":
                items, weights = [items[int(np.argmax(weights))]], np.ones(1)
        keep = weights != 0
        index, c = np.asarray(items, np.int64)[keep], term.components
        rows = index[None, :] * c + np.arange(c)[:, None]
        operator = Gather(rows, np.broadcast_to(weights[keep], rows.shape).copy(), term.operator.shape[0])
        return term.push(operator, place="point")

    def missing(self) -> tuple[Missing, ...]:
        """What nobody gave for just this place."""
        between = self.hit.kind == "sample" and max(self.hit.weights) < 1 - 1e-9
        return (BETWEEN,) if between else ()

    def flags(self) -> tuple[str, ...]:
        """In words, of the whole and of this place."""
        return tuple(dict.fromkeys(words for f in self.layer.accuracy.flags if (words := self._flag(f))))

    def _flag(self, flag: Flag) -> str:
        name = IN_WORDS.get(flag.name, flag.name)
        if flag.items is None:
            return flag.words
        mine = self.items.get(flag.place, ())
        if flag.place == "point":
            mine = tuple(p for p, w in zip(self.hit.points, self.hit.weights, strict=True) if w)
        where = np.flatnonzero(np.isin(flag.items, mine)) if mine else np.zeros(0, int)
        if not len(where):
            return ""
        number = "" if flag.values is None else f" ({numbers.significant(float(np.asarray(flag.values)[where[0]]))})"
        return f"{name[:1].upper()}{name[1:]}{number}: {flag.words}"

    # --- words

    def frame(self) -> Frame:
        """Names and units of the axes."""
        if isinstance(self.shape, Samples):
            return self.shape.grid.frame
        return self.shape.frame if isinstance(self.shape, Geometry) else Frame()

    def what(self) -> str:
        """The thing that was met, as the subject of a sentence."""
        kinds = {"vertex": "point", "line": "line", "polygon": "surface", "sample": "value", "row": "point"}
        return kinds[self.hit.kind]

    def title(self) -> str:
        """What was met."""
        shape, hit = self.shape, self.hit
        if isinstance(shape, Samples):
            return (shape.name[:1].upper() + shape.name[1:]) or "A value between samples"
        if isinstance(shape, Table):
            return f"Row {numbers.count(hit.cell)} of the table"
        level = self._field("level")
        if shape.shows:
            factor = max(one.factor for one in shape.shows)
            return f"{shape.shows[0].name}, drawn" + (f" ×{numbers.grouped(f'{factor:.4g}')}" if factor != 1 else " to scale")
        if hit.kind == "line" and level is not None:
            return f"On the {numbers.with_unit(numbers.significant(float(level), 6), shape.values['level'].unit)} line"
        whole = {"vertex": "A point", "line": "On a line", "polygon": "On the surface"}[hit.kind]
        of = self.layer.title or shape.name
        if hit.kind == "polygon" and "surface" in of.lower():
            return of
        return f"{whole} of {of[:1].lower()}{of[1:]}" if of else whole

    def place(self) -> str:
        """Position and cell."""
        frame, at, hit = self.frame(), self.hit.at, self.hit
        bounds = getattr(getattr(self.shape, "grid", self.shape), "bounds", None)
        span = max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]) if bounds else 0.0
        deep = bounds is None or bounds[4] != bounds[5] or bounds[4] != 0
        if isinstance(self.shape, Table):
            return f"Row {numbers.count(hit.cell)}"
        parts = [
            f"{name} {numbers.with_unit(_to(value, span * 1e-4), unit)}"
            for name, unit, value in list(zip(frame.axes, frame.units, at, strict=True))[: 3 if deep else 2]
        ]
        parts.append(f"segment {numbers.count(hit.segment)}" if hit.segment >= 0 else f"cell {numbers.count(hit.cell)}")
        origin = getattr(self.shape, "origin", None)
        if origin is not None:
            parts.append(f"drawn for item {numbers.count(int(origin[hit.cell]))} of what it shows")
        return ", ".join(parts)

    def values(self, totals: Sequence[Total]) -> tuple[tuple[str, str], ...]:
        """Names and numbers; what has an error is told to two digits of it."""
        error = next((t.value for t in totals if t.quantity == "value"), math.nan)
        if isinstance(self.shape, Samples):
            flat = self.shape.values.reshape(self.shape.grid.count, -1)
            value = np.asarray(self.hit.weights) @ flat[list(self.hit.points)].astype(float)
            return ((self.shape.name or "value", _number(value, self.shape.unit, error)),)
        if isinstance(self.shape, Table):
            units = self.shape.units
            errors = {t.quantity: t.value for t in totals}
            return tuple(
                (name, _cell(column[self.hit.cell], units.get(name, ""), errors.get(name, math.nan)))
                for name, column in self.shape.columns.items()
            )
        found = [(name, self._field(name), self.shape.values[name].unit) for name in self.shape.values]
        mine = (self.shape.name, "value")
        return tuple((n, _number(v, unit, error if n in mine else math.nan)) for n, v, unit in found if v is not None)

    def _field(self, name: str) -> Any:
        """A field of a geometry at the place; None where it says nothing of it."""
        field = self.shape.values.get(name)
        items = self.items.get(field.place, ()) if field is not None else ()
        if field is None or not items or not np.issubdtype(np.asarray(field.values).dtype, np.number):
            return None
        values = np.asarray(field.values, float)[list(items)]
        if field.place != "point":
            return values[0]
        weights = np.asarray(self.hit.weights)
        return weights[weights != 0] @ values[weights != 0]


def _line(term: Term, k: float) -> Line:
    """A term of one row in words."""
    rigour, up = term.source.rigour, term.source.rigour == "proven"
    size = float(term.size()[0]) * (k if term.kind in SPREAD else 1.0)
    number = numbers.quantity(size, term.unit, up=up)
    if term.kind in SPREAD:
        number = f"±{number}"
    elif term.kind == "signed" and term.components == 1 and size:
        number = f"{'+' if float(term.error()[0]) > 0 else '−'}{number}"
    if not math.isfinite(size):
        number = "no bound"
    return Line(
        sign=term.source.sign, rigour=rigour, number=number, words=term.name, quantity=term.quantity, unit=term.unit,
        stage=term.source.stage, rule=term.source.rule, kind=term.kind, value=size,
    )  # fmt: skip


def _unknown(missing: Missing) -> Line:
    words = f"{missing.name} {missing.reason}" if missing.reason == "not given" else f"{missing.name}: {missing.reason}"
    return Line(sign=SIGNS["unknown"], rigour="unknown", number="", words=words)


def _total(known: Accuracy, quantity: str, k: float) -> Total:
    alike = Accuracy(tuple(t for t in known.select(quantity) if t.kind != "metric"))
    first = alike.terms[0]
    value = float(alike.total(k, quantity, "point")[0])
    word = alike.word(quantity)
    number = numbers.quantity(value, first.unit, up=word == "proven") if math.isfinite(value) else "no bound"
    return Total(quantity=quantity, unit=first.unit, sign=SIGNS[word], rigour=word, number=number, value=value)


def _summary(what: str, totals: Sequence[Total], lines: Sequence[Line]) -> str:
    """One sentence a quantity with the total, and whether it may be more."""
    said = [_sentence(what, t) for t in totals if t.rigour != "exact"]
    unknown = sum(one.rigour == "unknown" for one in lines)
    if not said and not unknown:
        said = ["Exact: nothing here is in doubt." if totals else "Nothing is stated of its accuracy."]
    if unknown:
        source = "One source is" if unknown == 1 else f"{numbers.count(unknown)} sources are"
        said.append(f"{source} not known, so it may be more." if said else f"{source} not known.")
    return " ".join(said)


def _sentence(what: str, total: Total) -> str:
    if not math.isfinite(total.value):
        return f"The {total.quantity} has no bound here."
    how = HOW[total.rigour]
    known = ", proven" if total.rigour == "proven" else " by what is known"
    if total.quantity == "position":
        return f"The {what} may lie {how} {total.number} from here{known}."
    subject = "value" if total.quantity == "value" else total.quantity
    return f"The {subject} is right to {how} {total.number}{known}."


def _to(value: float, step: float) -> str:
    """A number to the digits that a step leaves it."""
    if not step > 0 or not math.isfinite(value):
        return numbers.significant(value, 5)
    places = max(0, -math.floor(math.log10(step)))
    text = f"{value:.{places}f}"
    return numbers.grouped("0" if float(text) == 0 else text) if places <= 6 else numbers.significant(value, 5)


def _number(value: Any, unit: str, error: float) -> str:
    """A value, or a vector, to two digits of its error."""
    one = np.atleast_1d(np.asarray(value, float))
    step = 10.0 ** (math.floor(math.log10(error)) - 1) if error > 0 and math.isfinite(error) else math.nan
    if step > abs(float(np.abs(one).max())) and math.isfinite(step):
        step = math.nan
    words = [_to(float(v), step) for v in one]
    return numbers.with_unit(words[0] if len(words) == 1 else f"({', '.join(words)})", unit)


def _cell(value: Any, unit: str, error: float) -> str:
    return _number(value, unit, error) if np.issubdtype(np.asarray(value).dtype, np.number) else str(value)
