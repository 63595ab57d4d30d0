"""How errors of samples hang together: independent, one for all, or alike within a length."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from modules.data.grid import Grid, Rectilinear, Regular
from modules.data.operators import Floats, Gather, Identity, Ints, Operator, Spread, Stencil, scaling

Correlation = Literal["independent", "common", "length"]

REACH = 3.0
"""Correlation lengths after which a weight is left out; it is exp(-9) there."""


def check(grid: Grid, correlation: str, length: float) -> None:
    """Whether a grid can have errors that are alike within a length.

    Raises
    ------
    ValueError : a bent grid, axes of several units, or no length
    """
    if correlation != "length":
        return
    if not isinstance(grid, Regular | Rectilinear):
        raise ValueError(f"a correlation length needs a regular or rectilinear grid, not a {grid.kind} one")
    if not (math.isfinite(length) and length > 0):
        raise ValueError(f"length = {length} must be more than 0: choose 'independent' for none")
    grid.frame.length_unit(grid.dimensions)


def carried(
    grid: Grid, components: int, sizes: Floats, correlation: str, length: float, *, named: bool = False
) -> tuple[Floats, Operator]:
    """Primitive sizes, and how they reach the samples.

    Parameters
    ----------
    sizes : 0-d, or one size per value, components fastest
    named : primitives have size 1 everywhere, so that errors of one source are the same wherever they occur
    """
    rows = grid.count * components
    one = np.asarray(1.0)
    if correlation == "independent":
        if not named:
            return sizes, Identity(rows)
        return one, _weighted(np.arange(rows), sizes, rows)
    if correlation == "common":
        if components == 1 and not named and not sizes.ndim:
            return sizes, Spread(rows)
        return one, _weighted(np.arange(rows) % components, sizes, components)
    chain = _correlated(grid, components, length)
    if not sizes.ndim and not named:
        return sizes, chain
    return one, (scaling(sizes) if sizes.ndim else _weighted(np.arange(rows), sizes, rows)).after(chain)


def words(grid: Grid, correlation: str, length: float) -> str:
    """What is assumed, to be printed."""
    unit = grid.frame.units[0]
    return {
        "independent": "assumed to be independent from sample to sample",
        "common": "assumed to be one error, common to all samples",
        "length": f"assumed to correlate as exp(-d²/2L²), L = {length:g}{' ' + unit if unit else ''}",
    }[correlation]


def _weighted(index: Ints, sizes: Floats, n_in: int) -> Gather:
    return Gather(index[:, None], sizes[:, None] if sizes.ndim else sizes, n_in)


def _correlated(grid: Grid, components: int, length: float) -> Operator:
    """Unit noise on a lattice of half the length, smoothed by a Gaussian along each axis to deviation 1 at each sample."""
    assert isinstance(grid, Regular | Rectilinear)
    weights = [_gaussian(axis, length) for axis in reversed(grid.axes)]
    extra = (components,) if components > 1 else ()
    lattice = [w[2] for w in weights] + list(extra)
    operator: Operator | None = None
    for axis, (columns, values, _) in enumerate(weights):
        step = Stencil(tuple(lattice), axis, columns, values)
        lattice[axis] = len(columns)
        operator = step if operator is None else step.after(operator)
    assert operator is not None
    return operator


def _gaussian(axis: Floats, length: float) -> tuple[Ints, Floats, int]:
    """Columns, weights and number of primitives along an axis: rows of norm 1, so that each sample has deviation 1.

    Primitives lie half a length apart; sums of such a Gaussian over them differ from its integral by 5e-9.
    """
    step = length / 2
    wide = math.ceil(REACH * length / step)
    position = (axis - axis[0]) / step
    nearest = np.rint(position).astype(np.int64)
    offsets = np.arange(-wide, wide + 1)
    columns = nearest[:, None] + offsets + wide
    weights = np.exp(-(((position[:, None] - nearest[:, None] - offsets) * step / length) ** 2))
    return columns, weights / np.sqrt((weights**2).sum(axis=1, keepdims=True)), int(columns.max()) + 1
