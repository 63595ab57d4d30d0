"""Formulas over the numbers of several samples: values, errors to first order, and what lies beyond it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Flag, Gather, Identity, Missing, Operator, Samples, Source, Term, uniform
from modules.data.derivative import derivatives
from modules.data.expression import Floats, Node, evaluate, order
from modules.data.intervals import Interval, enclosed, steady
from modules.data.operators import Ints
from modules.modellers._linear import flat, incoming, lattice_of
from modules.modellers._pointwise import BLOCK, bent, reach_of

STRAIGHT = ("+", "-", "*", "/", "neg", "**")
"""Operations that are linear where their derivatives are constant."""
UNUSED = "the formula does not use it"
BEYOND = Source(
    "Beyond first order",
    "model",
    "proven",
    "mean value theorem: derivatives over the interval of all bounds, less those at its middle; Moore 1966 "
    "[mean-value-interval/1]",
)


@dataclass(frozen=True)
class Column:
    """A name of a formula: one component of one of the inputs."""

    name: str
    input: int
    component: int


@dataclass(frozen=True, eq=False)
class Formulas:
    """What is computed of which numbers.

    Parameters
    ----------
    inputs : samples on one grid
    roots : m expressions
    columns : names that stand for data, all that the expressions use
    exact : names that have no error, coordinates for example
    """

    inputs: Sequence[Samples]
    roots: Sequence[Node]
    columns: Sequence[Column]
    exact: Mapping[str, Floats]
    slopes: Sequence[Sequence[Node]] = field(init=False)

    def __post_init__(self) -> None:
        slopes = [[derivatives(root, column.name) for column in self.columns] for root in self.roots]
        object.__setattr__(self, "slopes", slopes)

    @property
    def linear(self) -> bool:
        """Whether the outcome is a straight line of the data: no derivative depends on it, and there is no step."""
        names = {"$" + column.name for column in self.columns}
        if any(n.what in names for row in self.slopes for slope in row for n in order(slope)):
            return False
        depends: set[int] = set()
        for node in order(*self.roots):
            if node.what in names or any(id(one) in depends for one in node.inputs):
                depends.add(id(node))
                if node.what not in (*names, *STRAIGHT):
                    return False
        return True

    @property
    def numbers(self) -> Floats:
        """(n, columns) the data."""
        if not self.columns:
            return np.zeros((self.inputs[0].grid.count, 0))
        return np.column_stack([self._column(c, flat(self.inputs[c.input])) for c in self.columns])

    def _column(self, column: Column, values: Floats) -> Floats:
        c = self.inputs[column.input].components
        return values.reshape(-1, c)[:, column.component]

    def names(self, numbers: Floats, part: slice = slice(None)) -> dict[str, Floats]:
        """Name -> values, of the data as given and of what is exact."""
        data = {column.name: numbers[:, i] for i, column in enumerate(self.columns)}
        return data | {name: values[part] for name, values in self.exact.items()}

    def values(self, numbers: Floats, part: slice = slice(None)) -> Floats:
        """(n, m) values for (n, columns) numbers."""
        found = evaluate(self.roots, self.names(numbers, part))
        return np.stack([np.broadcast_to(one, (len(numbers),)) for one in found], axis=-1)

    def jacobian(self, numbers: Floats) -> Floats:
        """(n, m, columns) derivatives."""
        found = evaluate([slope for row in self.slopes for slope in row], self.names(numbers))
        stacked = [np.broadcast_to(one, (len(numbers),)) for one in found]
        if not stacked:
            return np.zeros((len(numbers), len(self.roots), 0))
        return np.stack(stacked, axis=-1).reshape(len(numbers), len(self.roots), len(self.columns))


def calculated(formulas: Formulas, unit: str) -> tuple[Floats, Accuracy]:
    """(n, m) values, NaN where there is none, and their accuracy with m components a sample."""
    numbers = formulas.numbers
    values, jacobian = formulas.values(numbers), formulas.jacobian(numbers)
    usable = np.isfinite(values).all(axis=1)
    values = np.where(np.isfinite(values), values, np.nan)
    sloped = np.isfinite(jacobian).all(axis=(1, 2))
    jacobian[~sloped] = 0.0
    m = len(formulas.roots)
    parts = [
        (incoming(samples).push(_operator(formulas, i, jacobian), unit=unit, components=m), None)
        for i, samples in enumerate(formulas.inputs)
        if any(column.input == i for column in formulas.columns)
    ]
    accuracy = Accuracy.join(parts)
    for samples in formulas.inputs:
        accuracy = accuracy.end_from(samples.accuracy, UNUSED)
    whole = np.isfinite(numbers).all(axis=1)
    accuracy = _told(accuracy, np.flatnonzero(whole & ~usable), len(numbers))
    if formulas.linear:
        return values, accuracy
    accuracy = _members(accuracy, formulas, numbers, values)
    accuracy = _beyond(accuracy, formulas, numbers, values, jacobian, unit)
    wrong = usable & (~sloped | _bent(formulas, numbers, values, jacobian))
    if wrong.any():
        words = f"the errors change the outcome otherwise than by its slope at {int(wrong.sum())} of {len(wrong)} samples"
        accuracy = accuracy.flag(Flag("not linear", words, "point", np.flatnonzero(wrong)))
    return values, accuracy


def _told(accuracy: Accuracy, items: Ints, count: int) -> Accuracy:
    if not len(items):
        return accuracy
    words = f"the formula has no number at {len(items)} of {count} samples: a division by 0, or a root or logarithm below 0"
    return accuracy.flag(Flag("no value", words, "point", items))


def _operator(formulas: Formulas, which: int, jacobian: Floats) -> Operator:
    """How the numbers of one input move the outcome."""
    samples, m = formulas.inputs[which], len(formulas.roots)
    mine = [i for i, column in enumerate(formulas.columns) if column.input == which]
    c, n = samples.components, samples.grid.count
    if c == m == 1 and formulas.slopes[0][mine[0]].what == "number":
        factor = formulas.slopes[0][mine[0]].number
        return Identity(n) if factor == 1 else uniform(lattice_of(samples), factor)
    components = np.array([formulas.columns[i].component for i in mine])
    index = np.repeat(np.arange(n)[:, None] * c + components, m, axis=0)
    if n * c < 2**31:
        index = index.astype(np.int32)
    return Gather(index, np.ascontiguousarray(jacobian[:, :, mine].reshape(n * m, len(mine))), n * c)


def _members(accuracy: Accuracy, formulas: Formulas, numbers: Floats, values: Floats) -> Accuracy:
    """Each member through the formula itself, not through its slope."""
    into = [{t.id: t for t in incoming(s).terms if t.kind == "members"} for s in formulas.inputs]
    terms = []
    for term in accuracy.terms:
        if term.kind != "members":
            terms.append(term)
            continue
        made = []
        for k in range(len(term.value)):
            moved = numbers.copy()
            for i, column in enumerate(formulas.columns):
                if (before := into[column.input].get(term.id)) is not None:
                    moved[:, i] += formulas._column(column, before.operator.apply(before.value[k]))
            made.append(np.nan_to_num(formulas.values(moved) - values, posinf=0.0, neginf=0.0).ravel())
        value = np.stack(made)
        terms.append(replace(term, value=value, operator=Identity(value.shape[1])))
    return replace(accuracy, terms=tuple(terms))


def _bent(formulas: Formulas, numbers: Floats, values: Floats, jacobian: Floats) -> NDArray[np.bool_]:
    """Where two deviations reach so far that the slope is not what they do; bounds are enclosed elsewhere."""
    reaches = [reach_of(samples, bounded=False) for samples in formulas.inputs]
    reach = np.array([reaches[column.input][column.component] for column in formulas.columns])
    found = np.zeros(len(numbers), bool)
    if not reach.any():
        return found
    for first in range(0, len(numbers), BLOCK):
        part = slice(first, first + BLOCK)
        for k in range(len(formulas.roots)):

            def one(moved: Floats, k: int = k, part: slice = part) -> tuple[Floats, Floats]:
                return formulas.values(moved, part)[:, k], moved

            found[part] |= bent(one, numbers[part], values[part, k], jacobian[part, k], reach)
    return found


def _beyond(
    accuracy: Accuracy, formulas: Formulas, numbers: Floats, values: Floats, jacobian: Floats, unit: str
) -> Accuracy:
    """With what bounds may do beyond first order, proven."""
    bounds = np.zeros(numbers.shape)
    for i, samples in enumerate(formulas.inputs):
        for term in incoming(samples).terms:
            if term.kind == "bound":
                size = term.error().ravel()
                for place, column in enumerate(formulas.columns):
                    if column.input == i:
                        bounds[:, place] += formulas._column(column, size)
    if not bounds.any():
        return accuracy
    rest = np.zeros(values.shape)
    for first in range(0, len(numbers), BLOCK):
        part = slice(first, first + BLOCK)
        rest[part] = _rest(formulas, numbers[part], bounds[part], values[part], jacobian[part], part)
    open_ = ~np.isfinite(rest)
    lost = np.flatnonzero((open_ & np.isfinite(values)).any(axis=1))
    if len(lost):
        words = f"no bound is known at {len(lost)} of {len(rest)} samples: the bounds of the data reach a pole, or no value"
        accuracy = accuracy.flag(Flag("unproven", words, "point", lost)).miss(
            Missing(BEYOND.name, "at some samples the bounds of the data reach a pole, or where the formula has no value")
        )
    rest[open_] = 0.0
    if not rest.any():
        return accuracy
    c = len(formulas.roots)
    return accuracy.add(Term(BEYOND, "bound", "value", unit, rest.ravel(), Identity(rest.size), components=c))


def _rest(
    formulas: Formulas, numbers: Floats, bounds: Floats, values: Floats, jacobian: Floats, part: slice
) -> Floats:
    """(n, m) the most by which an outcome within the bounds differs from its first order; infinite where none is known."""
    ends: dict[str, Interval] = {name: (one, one) for name, one in formulas.names(numbers, part).items()}
    for i, column in enumerate(formulas.columns):
        ends[column.name] = numbers[:, i] - bounds[:, i], numbers[:, i] + bounds[:, i]
    rest = np.empty(values.shape)
    with np.errstate(invalid="ignore"):
        for k, root in enumerate(formulas.roots):
            low, high = enclosed([root], ends)[0]
            first = (np.abs(jacobian[:, k]) * bounds).sum(axis=1)
            straight = np.maximum(np.abs(high - values[:, k]), np.abs(low - values[:, k])) + first
            bent_by = np.zeros(len(numbers))
            for i, (below, above) in enumerate(enclosed(formulas.slopes[k], ends)):
                off = np.maximum(np.abs(above - jacobian[:, k, i]), np.abs(below - jacobian[:, k, i]))
                bent_by += np.where(bounds[:, i] == 0, 0.0, off * bounds[:, i])
            usable = steady(root, ends) & np.isfinite(low) & np.isfinite(high)
            rest[:, k] = np.fmin(straight, np.where(usable, bent_by, np.inf))
    return rest
