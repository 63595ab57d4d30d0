"""What is known of the accuracy of an output, evaluated: plain data for the budget view."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.commands.budget import GLANCE, glance
from app.draw import numbers
from modules.data.accuracy import SIGNS, Accuracy, Flag, Line, Missing, Term

SPREAD = ("linear", "members")
"""Kinds that are standard deviations: they count k times."""


@dataclass(frozen=True)
class Total:
    """All terms of a quantity together.

    Parameters
    ----------
    sign, rigour : of the weakest of them
    number : with its unit
    value : the largest over the items
    bounds, spread : what adds, and k times what adds in squares
    looked, count : items that were looked at, and all
    """

    quantity: str
    unit: str
    sign: str
    rigour: str
    number: str
    value: float
    bounds: float
    spread: float
    looked: int
    count: int
    place: str


@dataclass(frozen=True)
class Budget:
    """The budget of an output.

    Parameters
    ----------
    lines : the terms, the largest of each quantity first
    totals : one a quantity
    missing, flags : as the accuracy has them
    ended : what ended here, and why
    """

    lines: tuple[Line, ...]
    totals: tuple[Total, ...]
    missing: tuple[Missing, ...]
    flags: tuple[Flag, ...]
    k: float
    ended: tuple[tuple[str, str], ...] = field(default=())

    @property
    def exact(self) -> bool:
        """Whether there is no error at all."""
        return not self.lines and not self.missing


def budget_of(accuracy: Accuracy, k: float) -> Budget:
    """Evaluate a budget over some items; call it in no window's thread."""
    lines = tuple(glance(accuracy))
    quantities = dict.fromkeys(line.quantity for line in lines)
    totals = tuple(_total(accuracy, q, k, [one for one in lines if one.quantity == q]) for q in quantities)
    ended = tuple((e.name, e.why) for e in accuracy.ended.values())
    missing = tuple({m.name: m for m in accuracy.missing}.values())
    return Budget(lines, totals, missing, tuple(accuracy.flags), k, ended)


def size(line: Line, k: float) -> float:
    """The largest size of a term, a standard deviation k times; of a measure the sum."""
    if line.kind == "metric":
        return line.sum
    return line.max * (k if line.kind in SPREAD else 1.0)


def _total(accuracy: Accuracy, quantity: str, k: float, lines: list[Line]) -> Total:
    terms = accuracy.select(quantity)
    first = terms[0]
    alike = [t for t in terms if t.place == first.place and t.count == first.count]
    items = _some(first)
    looked = first.count if items is None else len(items)
    if all(t.kind == "metric" for t in terms):
        value = sum(one.sum for one in lines)
        bounds, looked = value, first.count
    else:
        part = Accuracy(tuple(alike))
        value = float(np.max(part.total(k, quantity, first.place, items), initial=0.0))
        bounds = sum(size(one, k) for one in lines if one.kind not in SPREAD)
    spread = float(np.sqrt(sum(size(one, k) ** 2 for one in lines if one.kind in SPREAD)))
    rigour = accuracy.word(quantity)
    number = numbers.quantity(value, first.unit, up=rigour == "proven")
    return Total(quantity, first.unit, SIGNS[rigour], rigour, number, value, bounds, spread, looked, first.count, first.place)


def _some(term: Term) -> np.ndarray[tuple[int], np.dtype[np.int64]] | None:
    if term.count <= GLANCE:
        return None
    return np.sort(np.random.default_rng(0).choice(term.count, GLANCE, replace=False)).astype(np.int64)
