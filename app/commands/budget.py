"""A budget at a glance, in words and signs, as the command line prints it beside each node."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from app.draw import numbers
from modules.data.accuracy import SIGNS, Accuracy, Line, line
from modules.data.wires import ColourMap, Layer, Scene

GLANCE = 2000
"""Items that are looked at; certificates and demands look at all."""

SHOWN = 3
"""Terms of a quantity that are named; `--verbose` names all."""


def speaks(value: Any) -> bool:
    """Whether an output says something new of accuracy: a layer repeats its shape, a scene its layers."""
    return not isinstance(value, Layer | Scene | ColourMap) and isinstance(getattr(value, "accuracy", None), Accuracy)


def glance(accuracy: Accuracy) -> list[Line]:
    """The budget over some items; a measure (an area) over all, for its sum."""
    measures = [line(t) for t in accuracy.terms if t.kind == "metric"]
    rest = Accuracy(tuple(t for t in accuracy.terms if t.kind != "metric"))
    return [*rest.budget(GLANCE), *measures]


def said(value: Any, lines: Iterable[Line], k: float, most: int | None = SHOWN) -> Iterator[str]:
    """The budget of an output, one line a quantity; what is missing on a line of its own.

    Parameters
    ----------
    lines : of its budget, the largest of a quantity first
    most : terms of a quantity that are named; all for None
    """
    by: dict[str, list[Line]] = {}
    for one in lines:
        by.setdefault(one.quantity, []).append(one)
    for quantity, terms in by.items():
        named = [words(term, value, k) for term in terms[:most]]
        rest = f"; and {len(terms) - len(named)} more" if len(terms) > len(named) else ""
        looked = [t for t in terms if t.looked < t.count]
        note = f"  (n={looked[0].looked} of {looked[0].count} {looked[0].place}s)" if looked else ""
        yield f"{quantity} {'; '.join(named)}{rest}{note}"
    missing = value.accuracy.missing
    if missing:
        yield f"{SIGNS['unknown']} {'; '.join(dict.fromkeys(m.name for m in missing))}"
    if not by and not missing:
        yield f"{SIGNS['exact']} exact"


def words(one: Line, value: Any, k: float) -> str:
    """A term's largest size with its sign; bounds are rounded up, standard deviations times k.

    Of a measure (an area) the sum; where the largest error of position exceeds the shape itself, that on 95 %.
    """
    spread = one.kind in ("linear", "members")
    derived = getattr(value, "origin", None) is not None  # a sum over its items would count some twice
    size, note = one.max, ""
    if one.kind == "metric" and one.count > 1 and not derived:
        size, note = one.sum, " in all"
    elif one.quantity == "position" and one.max > reach(value):
        size, note = one.p95, " on 95 %"
    number = numbers.significant(size * (k if spread else 1.0), up=one.rigour == "proven")
    return f"{one.sign} {'±' if spread else ''}{numbers.with_unit(number, one.unit)}{note} {one.name}"


def reach(value: Any) -> float:
    """The size of a shape: an error of position beyond it says only that there is no bound."""
    bounds = getattr(value, "bounds", None)
    return (math.dist(bounds[::2], bounds[1::2]) or math.inf) if bounds is not None else math.inf
