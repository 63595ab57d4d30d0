"""Numbers of a whole field: their errors from those of the samples, by weights that say how each sample counts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modules.api import Accuracy, Identity, Samples, Term
from modules.data.adjoint import sums
from modules.data.operators import Floats
from modules.modellers._linear import flat, incoming

Statistic = Callable[[Floats], Floats]
"""(n,) values -> (m,) numbers."""

SPREADS = ("linear", "members")


def deviation_of(samples: Samples) -> Floats:
    """(n,) standard deviation of each sample, of all that spreads."""
    squares = np.zeros(samples.grid.count)
    for term in incoming(samples).select("value", "point"):
        if term.kind in SPREADS:
            squares += term.size() ** 2
    return np.asarray(np.sqrt(squares))


def bounds_of(samples: Samples) -> Floats:
    """(n,) how far the proven or stated bounds of each sample reach together."""
    total = np.zeros(samples.grid.count)
    for term in incoming(samples).select("value", "point"):
        if term.kind == "bound":
            total += term.size()
    return total


def summed(samples: Samples, weights: Floats, quantity: str, unit: str, statistic: Statistic | None = None) -> Accuracy:
    """Errors of m numbers of a field.

    Parameters
    ----------
    weights : (m, n) derivative of each number by each sample, 0 at holes
    statistic : what is computed, if it is not linear: members go through it, not through its derivative
    """
    values = flat(samples)
    terms = []
    accuracy = incoming(samples)
    for term in accuracy.terms:
        if term.kind == "members" and statistic is not None:
            now = statistic(values)
            moved = np.stack([statistic(values + term.operator.apply(one)) - now for one in term.value])
            terms.append(replace(term, value=np.nan_to_num(moved), operator=Identity(len(now)), quantity=quantity, unit=unit))
        else:
            terms.append(replace(term, operator=sums(term.operator, weights), quantity=quantity, unit=unit))
    return Accuracy(tuple(terms), accuracy.missing, (), accuracy.ended)


def total(accuracy: Accuracy, k: float, quantity: str, rows: int) -> Floats:
    """(m,) the combined size of each number's errors; 0 where there are none."""
    return accuracy.total(k, quantity) if accuracy.select(quantity) else np.zeros(rows)


def only(accuracy: Accuracy, kinds: tuple[str, ...]) -> tuple[Term, ...]:
    """The terms of some kinds."""
    return tuple(t for t in accuracy.terms if t.kind in kinds)
