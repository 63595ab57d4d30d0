"""What is known about the accuracy of the data on a wire.

An `Accuracy` is a budget: terms (who made an error, of which kind, how large), what is missing (known to exist, not
given), flags (where a rule does not hold) and what has ended (and why). A term keeps the operator that brings its
primitive errors here, so the same source met twice is known as one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np

from modules.data.fold import Check
from modules.data.operators import Floats, Identity, Ints, Operator, Sum, scaling, uniform
from modules.data.terms import (
    SIGNS,
    Carrier,
    Ended,
    Flag,
    Line,
    Missing,
    Place,
    Rigour,
    Source,
    Stage,
    Term,
    bound,
    deviation,
    exactly,
    line,
)
from modules.data.units import UnitError, together

__all__ = [
    "EXACT", "SIGNS", "Accuracy", "Carrier", "Ended", "Flag", "Line", "Missing", "Place", "Rigour", "Source", "Stage",
    "Term", "accuracies", "bound", "deviation", "exactly", "line", "replace_accuracies", "unknown",
]  # fmt: skip

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Accuracy:
    """The budget of a wire.

    Parameters
    ----------
    terms : contributions, each of its own source
    missing : sources known to exist and not given; any makes the whole "not known"
    flags : where a rule does not hold
    ended : id -> what stopped here or upstream, and why
    of : the carrier, set by the wire value that carries it
    """

    terms: tuple[Term, ...] = ()
    missing: tuple[Missing, ...] = ()
    flags: tuple[Flag, ...] = ()
    ended: Mapping[str, Ended] = field(default_factory=dict)
    of: Carrier | None = None

    def __post_init__(self) -> None:
        seen: set[tuple[str, str, str]] = set()
        for term in self.terms:
            what = (term.id, term.quantity, term.place)
            if what in seen:
                raise ValueError(f"the source {term.name!r} occurs twice for {term.quantity}: merge with Accuracy.join")
            seen.add(what)

    def add(self, *terms: Term) -> Accuracy:
        """With further terms."""
        return replace(self, terms=(*self.terms, *terms))

    def miss(self, *missing: Missing) -> Accuracy:
        """With further sources that nobody gave; each is listed once."""
        return replace(self, missing=_unique((*self.missing, *missing)))

    def flag(self, *flags: Flag) -> Accuracy:
        """With further flags."""
        return replace(self, flags=(*self.flags, *flags))

    def push(
        self,
        operator: Operator,
        *,
        quantity: str | None = None,
        unit: str | None = None,
        place: Place | None = None,
        components: int | None = None,
    ) -> Accuracy:
        """All terms after one more linear step. Flags of the items before do not go on; `missing` and `ended` do."""
        terms = tuple(
            t.push(operator, quantity=quantity, unit=unit, place=place, components=components) for t in self.terms
        )
        return Accuracy(terms, self.missing, (), self.ended)

    def end(self, which: Term | str | None, why: str) -> Accuracy:
        """Without the term (its id, or all for None): its story stops here, for this reason."""
        wanted = which.id if isinstance(which, Term) else which
        stopped = {t.id: Ended(t.name, why) for t in self.terms if wanted is None or t.id == wanted}
        if wanted is not None and not stopped:
            raise ValueError(f"there is no term {wanted!r} to end; terms are {', '.join(t.name for t in self.terms)}")
        return replace(self, terms=tuple(t for t in self.terms if t.id not in stopped), ended={**self.ended, **stopped})

    def end_from(self, other: Accuracy, why: str) -> Accuracy:
        """Account for all that another accuracy holds and this output does not use."""
        mine = {t.id for t in self.terms}
        stopped = {t.id: Ended(t.name, why) for t in other.terms if t.id not in mine}
        return replace(self, ended={**other.ended, **self.ended, **stopped}, missing=self.missing)

    def accounted(self) -> frozenset[str]:
        """Ids of the terms and of what has ended."""
        return frozenset(t.id for t in self.terms) | frozenset(self.ended)

    def signed(self, names: Mapping[str, str], carrier: str) -> Accuracy:
        """With other ids for the terms named, and a name for a carrier that has none; itself if nothing changes."""
        of = self.of if self.of is None or self.of.key else Carrier(self.of.kind, self.of.counts, carrier)
        renamed = bool(names) and not names.keys().isdisjoint([*self.ended, *(t.id for t in self.terms)])
        if of is self.of and not renamed:
            return self
        terms = tuple(t.called(names[t.id]) if t.id in names else t for t in self.terms) if renamed else self.terms
        ended = {names.get(i, i): why for i, why in self.ended.items()} if renamed else self.ended
        return Accuracy(terms, self.missing, self.flags, ended, of)

    def carried(self, kind: str, counts: Mapping[str, int]) -> Accuracy:
        """Bound to its carrier; ValueError if a term speaks of another number of items."""
        for term in self.terms:
            if term.place != "own" and term.count != counts.get(term.place, -1):
                raise ValueError(
                    f"term {term.name!r} speaks of {term.count} {term.place}s; this {kind} has "
                    f"{counts.get(term.place, 'no such')}"
                )
        if self.of is not None and self.of.kind == kind and self.of.counts == counts:
            return self
        return Accuracy(self.terms, self.missing, self.flags, self.ended, Carrier(kind, dict(counts)))

    def select(self, quantity: str | None = None, place: Place | None = None) -> tuple[Term, ...]:
        """The terms of a quantity and place."""
        return tuple(
            t for t in self.terms if quantity in (None, t.quantity) and place in (None, t.place)
        )

    def rigour(self, quantity: str | None = None) -> Rigour:
        """The weakest word; "unknown" if anything is missing, "exact" if there is no error at all."""
        return "unknown" if self.missing else self.word(quantity)

    def word(self, quantity: str | None = None) -> Rigour:
        """The weakest word among the terms that are known."""
        words = list(SIGNS)
        return max((t.source.rigour for t in self.select(quantity)), key=words.index, default="exact")

    def total(
        self,
        k: float,
        quantity: str,
        place: Place = "point",
        items: Ints | None = None,
        check: Check | None = None,
    ) -> Floats:
        """The combined size per item: bounds and |signed| add, standard deviations add in squares, times k.

        Parameters
        ----------
        k : coverage factor of the standard deviations
        quantity, place : only like quantities at one place add
        items : wanted items; all by default

        Returns
        -------
        (n,) float, in the unit of the first term of the quantity

        Raises
        ------
        ValueError : terms of the quantity have units that measure different things

        Source: JCGM 101; uncertainties of independent sources add in squares, proven bounds linearly.
        """
        terms = self.select(quantity, place)
        try:
            into = together(t.unit for t in terms)
        except UnitError:
            units = ", ".join(sorted({t.unit or "plain numbers" for t in terms}))
            raise ValueError(f"errors of {quantity} come in {units}: convert first") from None
        count = terms[0].count if terms else (self.of.counts.get(place, 0) if self.of else 0)
        n = count if items is None else len(items)
        straight, squares = np.zeros(n), np.zeros(n)
        for i, term in enumerate(terms):
            size = term.size(items, _share(check, i, len(terms))) * into[term.unit]
            if term.kind in ("linear", "members"):
                squares += size**2
            else:
                straight += size
        return straight + k * np.sqrt(squares)

    def budget(self, items: int | None = None, check: Check | None = None) -> tuple[Line, ...]:
        """Each term evaluated, the largest first within its quantity.

        Parameters
        ----------
        items : look at that many random items (fixed seed) instead of all: a glance, which says so in `looked`
        """
        lines = [line(t, items, _share(check, i, len(self.terms))) for i, t in enumerate(self.terms)]
        order = ("position", "value", "velocity", "area", "length")
        rank = {q: i for i, q in enumerate(order)}
        return tuple(sorted(lines, key=lambda one: (rank.get(one.quantity, 9), one.quantity, -one.max, one.name)))

    @staticmethod
    def join(parts: Iterable[tuple[Accuracy, Operator | None]]) -> Accuracy:
        """The one way to merge: the same id on the same quantity becomes one term whose operators add.

        A term ended on one branch and alive on another is alive, and the ending is kept.

        Parameters
        ----------
        parts : (accuracy, operator that brings it here; None for as it is)
        """
        found: dict[tuple[str, str, str], list[Term]] = {}
        ended: dict[str, Ended] = {}
        missing: list[Missing] = []
        flags: list[Flag] = []
        for accuracy, operator in parts:
            ended |= accuracy.ended
            missing += accuracy.missing
            flags += accuracy.flags if operator is None else ()
            for term in accuracy.terms:
                pushed = term if operator is None else term.push(operator)
                found.setdefault((term.id, pushed.quantity, pushed.place), []).append(pushed)
        terms = tuple(_merged(ways) for ways in found.values())
        return Accuracy(terms, _unique(missing), tuple(dict.fromkeys(flags)), ended)


EXACT = Accuracy()
"""The claim that there is no error at all."""


def unknown(why: str) -> Accuracy:
    """The accuracy of who does not know: nothing is claimed, and it says so."""
    return Accuracy(missing=(Missing("accuracy", why),))


def accuracies(value: Any) -> Iterator[Accuracy]:
    """Every accuracy inside a wire value, a list of them, or a table of outputs, in the order in which they stand."""
    waiting = [value]
    while waiting:
        one = waiting.pop()
        kind = type(one)
        if kind is Accuracy:
            yield one
        elif kind in _LEAVES:
            continue
        elif isinstance(one, Mapping):
            waiting.extend(reversed(list(one.values())))
        elif isinstance(one, list | tuple):
            waiting.extend(reversed(one))
        else:
            waiting.extend(getattr(one, name) for name in _names(kind))


_LEAVES = frozenset({np.ndarray, str, bytes, int, float, bool, complex, type(None)})


_NAMES: dict[type, tuple[str, ...]] = {}


def _names(kind: type) -> tuple[str, ...]:
    """Fields of a dataclass, the last first; none for other types."""
    if kind not in _NAMES:
        _NAMES[kind] = tuple(f.name for f in reversed(fields(kind)) if f.init) if is_dataclass(kind) else ()
    return _NAMES[kind]


def replace_accuracies(value: T, function: Callable[[Accuracy], Accuracy]) -> T:
    """The wire value with each accuracy inside it passed through `function`; where nothing changes, the very object."""
    kind = type(value)
    if kind in _LEAVES:
        return value
    if isinstance(value, Accuracy):
        return cast(T, function(value))
    if isinstance(value, list | tuple):
        inner = [replace_accuracies(v, function) for v in value]
        if all(a is b for a, b in zip(inner, value, strict=True)):
            return value
        return cast(T, kind(*inner) if hasattr(value, "_fields") else cast(Callable[[Any], Any], kind)(inner))
    changed = {}
    for name in _names(kind):
        before = getattr(value, name)
        if type(before) not in _LEAVES and (after := replace_accuracies(before, function)) is not before:
            changed[name] = after
    return replace(cast(Any, value), **changed) if changed else value


def _merged(ways: list[Term]) -> Term:
    if len(ways) == 1:
        return ways[0]
    first = ways[0]
    try:
        into = together(w.unit for w in ways)
    except UnitError:
        raise ValueError(f"the source {first.name!r} arrives in units that measure different things: end it on one") from None
    if any(w.kind != first.kind for w in ways):
        raise ValueError(f"the source {first.name!r} arrives in different kinds: convert before joining")
    ways = [w if into[w.unit] == 1 else w.push(uniform((w.operator.shape[0],), into[w.unit]), unit=first.unit) for w in ways]
    if all(w.value is first.value or np.array_equal(w.value, first.value) for w in ways[1:]):
        return replace(first, operator=Sum(tuple(w.operator for w in ways)))
    return _summed(ways)


def _summed(ways: list[Term]) -> Term:
    """One source that arrives with other numbers on another way, as after a step that is not linear: effects add."""
    first = ways[0]
    if first.kind == "members":
        value = np.stack([sum(w.operator.apply(w.value[k]) for w in ways) for k in range(len(first.value))])
        return replace(first, value=value, operator=Identity(value.shape[1]))
    if first.kind in ("signed", "metric"):
        value = np.asarray(sum(w.operator.apply(np.broadcast_to(w.value, (w.operator.shape[1],))) for w in ways))
        return replace(first, value=value, operator=Identity(len(value)))
    if len({w.operator.shape[1] for w in ways}) > 1:
        raise ValueError(f"the source {first.name!r} arrives with other primitives on another way: end it on one of them")
    scaled = (w.operator.after(scaling(np.broadcast_to(w.value, (w.operator.shape[1],)))) for w in ways)
    return replace(first, value=np.asarray(1.0), operator=Sum(tuple(scaled)))


def _unique(missing: Iterable[Missing]) -> tuple[Missing, ...]:
    return tuple(dict.fromkeys(missing))


def _share(check: Check | None, i: int, n: int) -> Check | None:
    return None if check is None else lambda f: check((i + f) / n)
