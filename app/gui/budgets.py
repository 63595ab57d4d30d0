"""What is known of the accuracy of an output, evaluated: plain data for the budget view."""

from __future__ import annotations

import math
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
    note : "on 95 %" where some items have no bound
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
    note: str = ""


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
    reach: float = math.inf

    def size(self, line: Line) -> float:
        """The size of a term as it counts in the total: the largest, or that on 95 % where the largest has no bound."""
        return size(line, self.k, self.reach)

    @property
    def exact(self) -> bool:
        """Whether there is no error at all."""
        return not self.lines and not self.missing


def budget_of(accuracy: Accuracy, k: float, reach: float = math.inf) -> Budget:
    """Evaluate a budget over some items; call it in no window's thread.

    Parameters
    ----------
    reach : the size of the shape: an error of position beyond it says only that there is no bound
    """
    lines = tuple(glance(accuracy))
    quantities = dict.fromkeys(line.quantity for line in lines)
    totals = tuple(_total(accuracy, q, k, reach, [one for one in lines if one.quantity == q]) for q in quantities)
    ended = tuple((e.name, e.why) for e in accuracy.ended.values())
    missing = tuple({m.name: m for m in accuracy.missing}.values())
    return Budget(lines, totals, missing, tuple(accuracy.flags), k, ended, reach)


def size(line: Line, k: float, reach: float = math.inf) -> float:
    """The size of a term, a standard deviation k times; of a measure the sum."""
    if line.kind == "metric":
        return line.sum
    largest = line.p95 if line.quantity == "position" and not line.max <= reach else line.max
    return largest * (k if line.kind in SPREAD else 1.0)


def _total(accuracy: Accuracy, quantity: str, k: float, reach: float, lines: list[Line]) -> Total:
    terms = accuracy.select(quantity)
    first = terms[0]
    alike = tuple(t for t in terms if t.place == first.place and t.count == first.count)
    items = _some(first)
    looked = first.count if items is None else len(items)
    bounds = sum(size(one, k, reach) for one in lines if one.kind not in SPREAD)
    note = ""
    if all(t.kind == "metric" for t in terms):
        value, looked, note = bounds, first.count, "in all"
    else:
        each = np.asarray(Accuracy(alike).total(k, quantity, first.place, items), float)
        value = float(each.max(initial=0.0))
        if quantity == "position" and not value <= reach:
            beyond = int((~(each <= reach)).sum())
            value = float(np.quantile(each, 0.95, method="higher"))
            note = f"on 95 %; no bound at {numbers.count(beyond)} of {numbers.count(looked)} {first.place}s"
    spread = float(np.sqrt(sum(size(one, k, reach) ** 2 for one in lines if one.kind in SPREAD)))
    rigour = accuracy.word(quantity)
    number = numbers.quantity(value, first.unit, up=rigour == "proven")
    made = (quantity, first.unit, SIGNS[rigour], rigour, number, value, bounds, spread, looked, first.count)
    return Total(*made, place=first.place, note=note)


def _some(term: Term) -> np.ndarray[tuple[int], np.dtype[np.int64]] | None:
    if term.count <= GLANCE:
        return None
    return np.sort(np.random.default_rng(0).choice(term.count, GLANCE, replace=False)).astype(np.int64)
