"""Sizes of errors after stencils only: the weights are products along the axes, and so are their squares and sizes.

One size for all primitives becomes a product of one number per axis; sizes of their own pass through the same stencils
with squared (or absolute) weights, for the price of the values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array

from modules.data.operators import Floats, Identity, Ints, Operator, Stencil, Sum, along, steps

ROUNDING = 1e-15
"""What is left of squares that cancel, relative to them, is nothing."""
WHOLE = 8
"""Rows that are wanted times this: from so many on the whole lattice is computed."""


def separable(operator: Operator) -> tuple[tuple[int, ...], list[Any | None]] | None:
    """The input lattice, and one small matrix per axis (None: nothing is done), if the operator is stencils in a row."""
    found = [step for step in steps(operator) if not isinstance(step, Identity)]
    stencils = [step for step in found if isinstance(step, Stencil)]
    if not found or len(stencils) < len(found):
        return None
    matrices: list[Any | None] = [None] * len(stencils[0].lattice)
    for before, step in zip([None, *stencils], stencils, strict=False):
        if before is not None and before.outcome != step.lattice:
            return None
        earlier = matrices[step.axis]
        matrices[step.axis] = step.matrix() if earlier is None else step.matrix() @ earlier
    return stencils[0].lattice, matrices


def folded(kind: str, value: Floats, operator: Operator, rows: Ints | None) -> Floats | None:
    """Sizes in the wanted rows, or None where this way does not lead to them."""
    wanted = operator.shape[0] if rows is None else len(rows)
    if kind not in ("linear", "bound") or (value.ndim and wanted * WHOLE < operator.shape[0]):
        return None
    if isinstance(operator, Sum):
        return _of_ways(value, operator, rows) if kind == "linear" else None
    parts = separable(operator)
    if parts is None:
        return None
    lattice, matrices = parts
    power = 2 if kind == "linear" else 1
    sizes = [None if m is None else abs(_joined(m)).power(power) for m in matrices]
    total = _passed(lattice, sizes, value**power, rows)
    return np.sqrt(total) if kind == "linear" else total


def _passed(lattice: Sequence[int], sizes: Sequence[Any | None], value: Floats, rows: Ints | None) -> Floats:
    """Sizes of the primitives after one small matrix an axis, in the wanted rows."""
    if value.ndim == 0:
        return _product(lattice, sizes, rows) * abs(float(value))
    passed = value.reshape(lattice)
    for axis, matrix in enumerate(sizes):
        if matrix is not None:
            step = along(passed.shape, axis, matrix)
            passed = step.apply(passed).reshape(step.outcome)
    return passed.ravel() if rows is None else passed.ravel()[rows]


def _of_ways(value: Floats, operator: Sum, rows: Ints | None) -> Floats | None:
    """One source by several ways, each of stencils: the square of a sum is a sum of products, each a product along the axes."""
    ways = [separable(part) for part in operator.parts]
    known = [way for way in ways if way is not None]
    here = [isinstance(part, Identity) for part in operator.parts]
    if not known or any(way is None and not same for way, same in zip(ways, here, strict=True)):
        return None
    lattice = known[0][0]
    if any(way[0] != lattice for way in known) or operator.shape[1] != math.prod(lattice):
        return None
    whole = [[_matrix(m, n) for m, n in zip(way[1] if way else [None] * len(lattice), lattice, strict=True)] for way in ways]
    if len({tuple(m.shape for m in one) for one in whole}) > 1:
        return None
    total, largest = np.zeros(1), np.zeros(1)
    for i, one in enumerate(whole):
        for j, other in enumerate(whole[: i + 1]):
            both = [a.multiply(b).tocsr() for a, b in zip(one, other, strict=True)]
            part = _passed(lattice, both, value**2, rows) * (1 if i == j else 2)
            total, largest = total + part, largest + np.abs(part)
    return np.sqrt(np.where(total > ROUNDING * largest, total, 0.0))


def _matrix(matrix: Any | None, n: int) -> Any:
    return csr_array(eye_array(n)) if matrix is None else csr_array(_joined(matrix))


def _joined(matrix: Any) -> Any:
    """With entries of one place added up; a copy, for a stencil's matrix shares the stencil's numbers."""
    joined = matrix.copy()
    joined.sum_duplicates()
    return joined


def _product(lattice: Sequence[int], sizes: Sequence[Any | None], rows: Ints | None) -> Floats:
    sums = [np.ones(n) if m is None else np.asarray(m.sum(axis=1)).ravel() for n, m in zip(lattice, sizes, strict=True)]
    if rows is None:
        total = np.ones(())
        for one in sums:
            total = np.multiply.outer(total, one)
        return total.ravel()
    places = np.unravel_index(rows, [len(one) for one in sums])
    return np.asarray(np.prod([one[place] for one, place in zip(sums, places, strict=True)], axis=0))
