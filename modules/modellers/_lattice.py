"""Samples taken or mixed along each axis, with a grid to match."""

from __future__ import annotations

from collections.abc import Sequence

from modules.api import Operator, Samples, Stencil
from modules.data.grid import Axial
from modules.data.operators import Floats, Ints
from modules.modellers._linear import carried


def taken(samples: Samples, grid: Axial, parts: Sequence[tuple[Ints, Floats]], lattice: tuple[int, ...]) -> Samples:
    """The samples after one small matrix (columns, weights) along each of x, y[, z]."""
    return carried(samples, mixing(parts, lattice), grid)


def mixing(parts: Sequence[tuple[Ints, Floats]], lattice: tuple[int, ...]) -> Operator:
    """The operator of one small matrix (columns, weights) along each of x, y[, z]; the lattice may have components last."""
    operator: Operator | None = None
    extra = len(lattice) - len(parts)
    for axis, (columns, weights) in enumerate(parts):
        step = Stencil(lattice, len(lattice) - 1 - extra - axis, columns, weights)
        lattice, operator = step.outcome, step if operator is None else step.after(operator)
    assert operator is not None
    return operator
