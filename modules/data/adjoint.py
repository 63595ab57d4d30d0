"""Operators turned round: how much each primitive counts in one weighted sum of all rows.

A mean or an integral touches every row. Asked for as a row of a chain it would need all rows of the chain at once; from the
other end it is one pass over each step.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_array, vstack

from modules.data.operators import (
    Chain,
    Floats,
    Gather,
    Identity,
    Interleave,
    Matrix,
    Operator,
    Spread,
    Stencil,
    Sum,
    along,
    blocks,
)


def weighed(operator: Operator, weights: Floats) -> Floats:
    """(n_in,) the weights of the primitives in the sum of `weights` (n_out,) times the rows."""
    match operator:
        case Identity():
            return np.asarray(weights, float)
        case Chain():
            return weighed(operator.first, weighed(operator.then, weights))
        case Sum():
            return np.asarray(sum(weighed(part, weights) for part in operator.parts))
        case Interleave():
            c = len(operator.parts)
            return np.asarray(sum(weighed(part, weights[k::c]) for k, part in enumerate(operator.parts)))
        case Spread():
            return np.array([weights.sum()])
        case Gather():
            result = np.zeros(operator.n_in)
            for k in range(operator.index.shape[1]):
                one = operator.weight if operator.weight.ndim == 0 else operator.weight[:, k]
                result += np.bincount(operator.index[:, k], one * weights, operator.n_in)
            return result
        case Stencil():
            step = along(operator.outcome, operator.axis, csr_array(operator.matrix().T))
            return step.apply(np.asarray(weights, float))
        case Matrix():
            return np.asarray(operator.entries.T @ weights)
    result = np.zeros(operator.shape[1])
    for block in blocks(operator.shape[0]):
        result += operator.rows(block).T @ weights[block]
    return result


def sums(operator: Operator, weights: Iterable[Floats]) -> Matrix:
    """The operator followed by m weighted sums of all its rows.

    Parameters
    ----------
    weights : m rows of (n_out,); zeros cost nothing
    """
    rows = [csr_array(weighed(operator, one)[None]) if one.any() else csr_array((1, operator.shape[1])) for one in weights]
    return Matrix(csr_array(vstack(rows)))
