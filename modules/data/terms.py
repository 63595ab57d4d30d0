"""One line of a budget: a source, its errors where they arose, and the operator that brings them here."""

from __future__ import annotations

import math
import secrets
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from modules.data.fold import Check, Kind, fold
from modules.data.operators import Floats, Identity, Ints, Operator

Stage = Literal["data", "model", "mapping", "render"]
Rigour = Literal["exact", "proven", "estimated", "sampled", "unknown"]
Place = Literal["point", "cell", "segment", "own"]

SIGNS: Mapping[str, str] = MappingProxyType(
    {"exact": "=", "proven": "≤", "estimated": "~", "sampled": "n=", "unknown": "?"}
)
"""The five words and their signs, from the strongest claim to none."""

UNBOUNDED = 1e100
"""A larger size is none that a first-order rule can tell: it is infinite."""


@dataclass(frozen=True)
class Source:
    """Who made an error.

    Parameters
    ----------
    name : what the user reads, "Quantisation, half a metre"
    stage : data, model, mapping or render
    rigour : exact, proven, estimated, sampled
    rule : one sentence with its reference and, in brackets, the rule's id and number
    """

    name: str
    stage: Stage
    rigour: Rigour
    rule: str = ""

    @property
    def sign(self) -> str:
        """The sign of its rigour."""
        return SIGNS[self.rigour]

    @property
    def rule_name(self) -> str:
        """The id of its rule without the number of its version: what a renamed source still is."""
        return self.rule.rpartition("[")[2].partition("/")[0]


@dataclass(frozen=True, eq=False)
class Term:
    """One source's contribution on this wire.

    Parameters
    ----------
    source : who made it
    kind : linear (standard deviations of independent primitives), bound (|e| <= b), signed (an estimate of the error
        itself), members (k realisations), metric (a measure of its own, such as an area)
    quantity, unit : what the error is of: value, position, area, velocity; and in which unit
    value : (n_in,) primitive values; 0-d when all are the same; (k, n_in) for members
    operator : n_in primitives -> items x components, components fastest
    place : point, cell, segment (two consecutive points of a polyline) or own points
    components : 1 for a scalar, 3 for a vector
    id : identity of the source's errors; two terms of one id are the same errors
    points : (n, 3) positions, for place "own"
    """

    source: Source
    kind: Kind
    quantity: str
    unit: str
    value: Floats
    operator: Operator
    place: Place = "point"
    components: int = 1
    id: str = field(default_factory=lambda: f"script:{secrets.token_hex(8)}")
    points: Floats | None = None

    def __post_init__(self) -> None:
        value = np.asarray(self.value, dtype=float)
        object.__setattr__(self, "value", value)
        if np.isnan(value).any():
            raise ValueError(f"term {self.source.name!r} has NaN values: state what is not known as missing")
        if self.kind in ("linear", "bound") and (value < 0).any():
            raise ValueError(f"term {self.source.name!r}: a {self.kind} size is never negative")
        if self.kind == "members" and value.ndim != 2:
            raise ValueError(f"term {self.source.name!r}: members are (k, n) values")
        n_in = self.operator.shape[1]
        if value.ndim and value.shape[-1] != n_in:
            raise ValueError(f"term {self.source.name!r} has {value.shape[-1]} primitives; its operator takes {n_in}")
        if self.operator.shape[0] % self.components:
            raise ValueError(f"term {self.source.name!r}: {self.operator.shape[0]} rows are no multiple of {self.components}")

    @property
    def name(self) -> str:
        """The source's name."""
        return self.source.name

    @property
    def count(self) -> int:
        """Number of items it speaks of."""
        return self.operator.shape[0] // self.components

    def called(self, id: str) -> Term:
        """The same errors under another id; there is nothing to check anew."""
        other = copy(self)
        object.__setattr__(other, "id", id)
        return other

    def error(self, items: Ints | None = None, check: Check | None = None) -> Floats:
        """Its size: a standard deviation, bound, signed value, spread or measure.

        Parameters
        ----------
        items : wanted items; all by default

        Returns
        -------
        (n,) float, or (n, components)
        """
        rows = items
        if self.components > 1 and items is not None:
            rows = (np.asarray(items)[:, None] * self.components + np.arange(self.components)).ravel()
        size = fold(self.kind, self.value, self.operator, rows, check)
        size[np.abs(size) > UNBOUNDED] = math.inf
        return size.reshape(-1, self.components) if self.components > 1 else size

    def size(self, items: Ints | None = None, check: Check | None = None) -> Floats:
        """`error` without its sign; the length of a vector."""
        error = self.error(items, check)
        return np.abs(error) if error.ndim == 1 else np.asarray(np.sqrt((error**2).sum(axis=1)))

    def push(
        self,
        operator: Operator,
        *,
        quantity: str | None = None,
        unit: str | None = None,
        place: Place | None = None,
        components: int | None = None,
    ) -> Term:
        """The same errors after one more linear step; costs nothing until someone looks."""
        return replace(
            self,
            operator=operator.after(self.operator),
            quantity=self.quantity if quantity is None else quantity,
            unit=self.unit if unit is None else unit,
            place=self.place if place is None else place,
            components=self.components if components is None else components,
        )


@dataclass(frozen=True)
class Missing:
    """A source that is known to exist and whose size nobody gave."""

    name: str
    reason: str = "not given"


@dataclass(frozen=True)
class Ended:
    """A term that stops here, and why."""

    name: str
    why: str


@dataclass(frozen=True, eq=False)
class Flag:
    """Where a rule does not hold, or a decision is at risk.

    Parameters
    ----------
    name : kappa, topology at risk, not resolvable, unproven ...
    words : one sentence
    place : what the items are
    items : (m,) int indices of the carrier's items; None for the whole
    values : (m,) float, if each has a number
    """

    name: str
    words: str
    place: Place = "point"
    items: Ints | None = None
    values: Floats | None = None

    @property
    def count(self) -> int:
        """Number of places; 1 for the whole."""
        return 1 if self.items is None else len(self.items)


@dataclass(frozen=True)
class Carrier:
    """What an accuracy belongs to: the type, and how many points, cells and segments it has."""

    kind: str
    counts: Mapping[str, int]
    key: str = ""


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a budget, evaluated: numbers over all items or over those that were looked at."""

    name: str
    stage: str
    rigour: Rigour
    quantity: str
    unit: str
    place: Place
    kind: Kind
    rule: str
    id: str
    count: int
    looked: int
    max: float
    mean: float
    median: float
    p95: float
    sum: float

    @property
    def sign(self) -> str:
        """The sign of its rigour."""
        return SIGNS[self.rigour]


def exactly(name: str, stage: Stage, n: int, *, quantity: str = "value", unit: str = "", rule: str = "") -> Term:
    """A term that says an error is zero, with its reason."""
    return Term(Source(name, stage, "exact", rule), "bound", quantity, unit, np.asarray(0.0), Identity(n))


def deviation(
    name: str,
    sigma: ArrayLike,
    n: int,
    *,
    stage: Stage = "data",
    quantity: str = "value",
    unit: str = "",
    rigour: Rigour = "estimated",
    rule: str = "",
    id: str | None = None,
) -> Term:
    """Independent errors of n items with standard deviation `sigma` (one number, or (n,))."""
    source = Source(name, stage, rigour, rule)
    return _term(source, "linear", quantity, unit, sigma, n, id)


def bound(
    name: str,
    limit: ArrayLike,
    n: int,
    *,
    stage: Stage = "data",
    quantity: str = "value",
    unit: str = "",
    rigour: Rigour = "proven",
    rule: str = "",
    id: str | None = None,
) -> Term:
    """Errors of n items that never exceed `limit` (one number, or (n,))."""
    source = Source(name, stage, rigour, rule)
    return _term(source, "bound", quantity, unit, limit, n, id)


def _term(source: Source, kind: Kind, quantity: str, unit: str, value: ArrayLike, n: int, id: str | None) -> Term:
    term = Term(source, kind, quantity, unit, np.asarray(value, float), Identity(n))
    return term if id is None else term.called(id)


def line(term: Term, items: int | None = None, check: Check | None = None) -> Line:
    """A term evaluated: its largest, mean, median and 95 % size; over `items` random ones if given."""
    wanted = None
    if items is not None and items < term.count:
        wanted = np.sort(np.random.default_rng(0).choice(term.count, items, replace=False))
    size = term.size(wanted, check)
    numbers = dict.fromkeys(("max", "mean", "median", "p95", "sum"), 0.0)
    if len(size):
        finite = size[np.isfinite(size)]
        numbers = {
            "max": float(size.max()),
            "mean": float(size.mean()),
            "median": float(np.median(size)),
            "p95": float(np.quantile(size, 0.95, method="lower")) if len(finite) else math.inf,
            "sum": float(size.sum()) * (term.count / len(size)),
        }
    return Line(
        name=term.name, stage=term.source.stage, rigour=term.source.rigour, quantity=term.quantity, unit=term.unit,
        place=term.place, kind=term.kind, rule=term.source.rule, id=term.id, count=term.count, looked=len(size), **numbers,
    )  # fmt: skip
