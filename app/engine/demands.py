"""Demands on the accuracy of an output, for `nonius run --require` and anyone who wants to be told.

    contour-1.lines.position.max < 0.01 cell            all terms together, standard deviations times k
    contour-1.lines[Quantisation].position.p95 <= 3 m   one term alone
    contour-1.lines.position.rigour >= estimated        the weakest word

    node.output[term].quantity.statistic  < or <=  number unit       statistics: max mean median p95 sum
    node.output.quantity.rigour  >=  exact|proven|estimated|sampled|unknown

The unit is the quantity's own if none is given; `cell` is the edge of the grid cells that a geometry was drawn from;
lengths may be given with another prefix. A demand about nothing, about NaN, or where a source is missing is not met.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np

from app.engine import check as legal
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError, UnknownName, hint, nearest
from app.engine.network import Network
from modules.data import units
from modules.data.accuracy import SIGNS, Accuracy, Place, Term
from modules.data.fold import Check
from modules.data.operators import Floats

STATISTICS = ("max", "mean", "median", "p95", "sum")
QUANTITIES = ("position", "value", "velocity", "area", "length", "gradient")
"""What errors are usually of: a demand on one of these that nobody speaks of is about nothing, not misspelt."""

LENGTHS = ("nm", "µm", "mm", "cm", "dm", "m", "km", "ft", "mi")
"""What is proposed for a misspelt length; any unit that is known can be written."""
CELL = "cell"
PLACES: tuple[Place, ...] = get_args(Place)

FORM = "write it as 'contour-1.lines.position.max < 0.01 cell'"
_DEMAND = re.compile(
    r"(?P<node>[^.\s\[\]<>=]+)\.(?P<output>[^.\s\[\]<>=]+)(?:\[(?P<term>[^\]]*)\])?"
    r"\.(?P<quantity>[^.\[\]<>=]+)\.(?P<statistic>[^.\s\[\]<>=]+)\s*(?P<sign><=|>=|<|>|==?)\s*(?P<rest>.+)"
)
_NUMBER = re.compile(r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>.*)")


class DemandRefused(NetworkError):
    """Words that are no demand."""


@dataclass(frozen=True)
class Verdict:
    """Whether a demand is met: the number found, its unit, and why not."""

    demand: str
    met: bool
    found: float | str
    unit: str = ""
    why: str = ""

    def record(self) -> dict[str, Any]:
        """As plain values."""
        found = self.found if isinstance(self.found, str) or math.isfinite(self.found) else str(self.found)
        return {"demand": self.demand, "met": self.met, "found": found, "unit": self.unit, "why": self.why}

    def __str__(self) -> str:
        found = self.found if isinstance(self.found, str) else f"{self.found:.4g}{' ' + self.unit if self.unit else ''}"
        if self.met:
            return f"met: {self.demand} (it is {found})"
        return f"not met: {self.demand}: {self.why}"


@dataclass(frozen=True)
class Demand:
    """One demand, as written and taken apart."""

    text: str
    node: str
    output: str
    term: str
    quantity: str
    statistic: str
    sign: str
    limit: float
    unit: str
    word: str = ""

    @classmethod
    def of(cls, text: str) -> Demand:
        """Read a demand.

        Raises
        ------
        DemandRefused : it is not of the form
        """
        text = " ".join(text.split())
        parts = _DEMAND.fullmatch(text)
        if parts is None:
            raise DemandRefused(f"{text!r} is no demand: {FORM}")
        statistic, sign, rest = parts["statistic"], parts["sign"], parts["rest"].strip()
        names = (parts["node"], parts["output"], (parts["term"] or "").strip(), parts["quantity"].strip(), statistic, sign)
        if statistic == "rigour":
            if sign != ">=":
                raise DemandRefused(f"{text!r}: a rigour is demanded with >=, 'at least {rest}'")
            if rest not in SIGNS:
                raise DemandRefused(f"{text!r}: there is no rigour {rest!r}{hint(rest, SIGNS)}")
            return cls(text, *names, math.nan, "", rest)
        if statistic not in STATISTICS:
            raise DemandRefused(f"{text!r}: there is no statistic {statistic!r}{hint(statistic, (*STATISTICS, 'rigour'))}")
        if sign not in ("<", "<="):
            raise DemandRefused(f"{text!r}: an error is demanded to be small: write < or <=, not {sign}")
        number = _NUMBER.fullmatch(rest)
        if number is None:
            raise DemandRefused(f"{text!r}: {rest!r} is no number with a unit: {FORM}")
        return cls(text, *names, float(number["number"]), number["unit"].strip())

    def against(self, network: Network, catalogue: Catalogue) -> None:
        """Whether there is such a node and output.

        Raises
        ------
        UnknownName : with the nearest name
        """
        record = legal.known(network[self.node].module, self.node, catalogue)
        legal.offered(self.node, record, self.output)

    def judge(self, value: Any, k: float, check: Check | None = None) -> Verdict:
        """Whether a wire value meets it; all its items are looked at.

        Raises
        ------
        UnknownName : no such term, or no such quantity
        DemandRefused : a unit that the quantity has not
        """
        accuracy = value if isinstance(value, Accuracy) else getattr(value, "accuracy", None)
        if accuracy is None:
            return self._not("nothing is said of accuracy there")
        terms = self._terms(accuracy)
        if missing := self._missing(accuracy):
            return self._not(missing)
        if self.word:
            return self._rigour(accuracy, terms)
        if not terms:
            return self._not(f"nothing is said of {self.quantity} there: a demand about nothing")
        factor, unit, why = self._factor(terms, value)
        if why:
            return self._not(why)
        found = -math.inf
        for place in PLACES:
            here = [t for t in terms if t.place == place]
            sizes = self._sizes(accuracy, here, place, k, check) if here else None
            if sizes is None:
                continue
            if not len(sizes):
                return self._not(f"{self.node}.{self.output} has no {place}s: a demand about nothing")
            if wrong := int(np.isnan(sizes).sum()):
                return self._not(f"the error of {wrong} of {len(sizes)} {place}s is not a number")
            found = max(found, statistics(sizes)[self.statistic] / factor)
        met = found < self.limit if self.sign == "<" else found <= self.limit
        why = "" if met else f"it is {found:.4g}{' ' + unit if unit else ''}"
        return Verdict(self.text, met, found, unit, why)

    def _not(self, why: str) -> Verdict:
        return Verdict(self.text, False, math.nan, self.unit, why)

    def _missing(self, accuracy: Accuracy) -> str:
        """Why a missing source makes the demand unanswerable; of one term, only that term's own absence does."""
        for missing in accuracy.missing:
            if not self.term or missing.name.casefold().startswith(self.term.casefold()):
                return f"a source is missing: {missing.name} ({missing.reason})"
        return ""

    def _terms(self, accuracy: Accuracy) -> tuple[Term, ...]:
        """The terms it speaks of."""
        there = {t.quantity for t in accuracy.terms}
        if self.quantity not in there and self.quantity not in QUANTITIES:
            close = hint(self.quantity, {*there, *QUANTITIES})
            raise UnknownName(f"{self.text!r}: nothing there is of {self.quantity!r}{close}")
        terms = accuracy.select(self.quantity)
        if not self.term:
            return terms
        names = {t.name for t in accuracy.terms}
        name = named(self.term, names)
        if not name:
            if any(m.name.casefold().startswith(self.term.casefold()) for m in accuracy.missing):
                return ()
            raise UnknownName(f"{self.text!r}: there is no term {self.term!r}{hint(self.term, names)}")
        return tuple(t for t in terms if t.name == name)

    def _rigour(self, accuracy: Accuracy, terms: tuple[Term, ...]) -> Verdict:
        words = list(SIGNS)
        known = [t.source.rigour for t in terms]
        if not known:
            return self._not(f"nothing is said of {self.quantity} there: a demand about nothing")
        found = "unknown" if accuracy.missing and not self.term else max(known, key=words.index)
        met = words.index(found) <= words.index(self.word)
        return Verdict(self.text, met, found, "", "" if met else f"it is {found}")

    def _sizes(self, accuracy: Accuracy, terms: list[Term], place: Place, k: float, check: Check | None) -> Floats:
        if self.term:
            return np.concatenate([t.size(None, check) * (k if t.kind in ("linear", "members") else 1.0) for t in terms])
        return accuracy.total(k, self.quantity, place, None, check)

    def _factor(self, terms: Iterable[Term], value: Any) -> tuple[float, str, str]:
        """(what one of the demand's unit is in the quantity's, the unit, why there is none)."""
        terms = list(terms)
        mine = terms[0].unit
        try:
            if set(units.together(t.unit for t in terms).values()) != {1.0} and self.term:
                return 1.0, "", f"the errors {self.term!r} come in several units: name one of them"
        except units.UnitError:
            several = sorted({t.unit or "plain numbers" for t in terms})
            return 1.0, "", f"errors of {self.quantity} come in {', '.join(several)}"
        if self.unit in ("", mine):
            return 1.0, mine, ""
        if self.unit == CELL:
            if self.quantity not in ("position", "length"):
                raise DemandRefused(f"{self.text!r}: a cell measures lengths; {self.quantity} is in {mine or 'plain numbers'}")
            cell = getattr(value, "cell", None)
            return (float(cell), CELL, "") if cell else (1.0, CELL, "what it is about does not know the size of its cells")
        if mine and units.known(self.unit) and units.known(mine) and units.parse(self.unit).powers == units.parse(mine).powers:
            return units.factor(self.unit, mine), self.unit, ""
        known = [*([mine] if mine else []), *(LENGTHS if units.is_length(mine) else ()), CELL]
        close = f"; did you mean {near!r}?" if (near := nearest(self.unit, known)) else ""
        has = mine or "plain numbers: write no unit"
        raise DemandRefused(f"{self.text!r}: {self.quantity} is in {has}, not {self.unit!r}{close}")


def statistics(sizes: Floats) -> dict[str, float]:
    """max, mean, median, p95 and sum of some sizes, as a budget's lines have them; NaN of none."""
    if not len(sizes):
        return dict.fromkeys(STATISTICS, math.nan)
    return {
        "max": float(sizes.max()),
        "mean": float(sizes.mean()),
        "median": float(np.median(sizes)),
        "p95": float(np.quantile(sizes, 0.95, method="lower")),
        "sum": float(sizes.sum()),
    }


def named(word: str, names: Iterable[str]) -> str:
    """The name meant by a word: the name itself, or the only one that begins with it; "" if there is none."""
    known = sorted(set(names))
    same = [n for n in known if n.casefold() == word.casefold()]
    begins = [n for n in known if word and n.casefold().startswith(word.casefold())]
    return same[0] if same else begins[0] if len(begins) == 1 else ""
