"""Sizes of errors after stencils only: the weights are products along the axes, and so are their squares and sizes.

One size for all primitives becomes a product of one number per axis; sizes of their own pass through the same stencils
with squared (or absolute) weights, for the price of the values.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from modules.data.operators import Floats, Identity, Ints, Operator, Stencil, along, steps

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
    parts = separable(operator)
    if parts is None:
        return None
    lattice, matrices = parts
    power = 2 if kind == "linear" else 1
    sizes = [None if m is None else abs(_joined(m)).power(power) for m in matrices]
    if value.ndim == 0:
        total = _product(lattice, sizes, rows) * abs(float(value)) ** power
    else:
        passed = value.reshape(lattice) ** power
        for axis, matrix in enumerate(sizes):
            if matrix is not None:
                step = along(passed.shape, axis, matrix)
                passed = step.apply(passed).reshape(step.outcome)
        total = passed.ravel() if rows is None else passed.ravel()[rows]
    return np.sqrt(total) if kind == "linear" else total


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
