"""The size of an error where it is wanted: a term's operator and its primitive values, folded row by row.

Three fast paths, tested against the rows: stencils alone (products along the axes), one standard deviation through a
gather over stencils (the covariance along each axis is a small banded matrix, exact at the borders too), and a gather.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from modules import kernels
from modules.data.operators import (
    MANY,
    Chain,
    Floats,
    Gather,
    Identity,
    Interleave,
    Ints,
    Operator,
    Stencil,
    Sum,
    blocks,
    fixed,
    steps,
)
from modules.data.separable import folded

Kind = Literal["linear", "bound", "signed", "members", "metric"]
Check = Callable[[float], object]

SIGNED = ("signed", "metric")
"""Kinds whose sizes keep their sign."""

WIDEST = 64
"""Most entries a row that are composed before the general way takes over."""


def fold(kind: Kind, value: Floats, operator: Operator, rows: Ints | None = None, check: Check | None = None) -> Floats:
    """What the primitives amount to in the rows of an operator.

    Parameters
    ----------
    kind : linear -> standard deviation, bound -> bound, signed and metric -> the value, members -> spread (ddof 1)
    value : (n_in,) primitive values, 0-d when all are the same, (k, n_in) for members
    operator : n_in primitives -> n_out rows
    rows : wanted rows; all by default
    check : polled with a fraction; may raise

    Returns
    -------
    (len(rows),) float
    """
    if isinstance(operator, Interleave):
        return _taking_turns(kind, value, operator, rows, check)
    quick = folded(kind, value, operator, rows)
    if quick is None:
        quick = _repeated(kind, value, operator, rows, check)
    if quick is not None:
        return quick
    wanted = np.arange(operator.shape[0]) if rows is None else np.asarray(rows)
    result = np.empty(len(wanted))
    for block in blocks(len(wanted)):
        if check:
            check(block[0] / len(wanted))
        result[block] = _block(kind, value, operator, wanted[block])
    return result


def _taking_turns(kind: Kind, value: Floats, operator: Interleave, rows: Ints | None, check: Check | None) -> Floats:
    """Parts that take turns are folded each on its own, so that those of stencils keep to the fast path."""
    c = len(operator.parts)
    result = np.empty(operator.shape[0] if rows is None else len(rows))
    for k, part in enumerate(operator.parts):
        share = None if check is None else _share(check, k, c)
        if rows is None:
            result[k::c] = fold(kind, value, part, None, share)
        else:
            mine = np.asarray(rows) % c == k
            result[mine] = fold(kind, value, part, np.asarray(rows)[mine] // c, share)
    return result


def _repeated(kind: Kind, value: Floats, operator: Operator, rows: Ints | None, check: Check | None) -> Floats | None:
    """Rows that are single entries of what comes before, many of them the same, as the points of a glyph: each folded once."""
    if not isinstance(operator, Chain) or not isinstance(operator.then, Gather) or operator.then.index.shape[1] != 1:
        return None
    last, wanted = operator.then, slice(None) if rows is None else np.asarray(rows)
    entries = last.index[wanted, 0]
    used, which = np.unique(entries, return_inverse=True)
    if 2 * len(used) > len(entries):
        return None
    weight = last.weight if last.weight.ndim == 0 else last.weight[wanted, 0]
    return np.asarray(fold(kind, value, operator.first, used, check)[which] * (weight if kind in SIGNED else np.abs(weight)))


def _share(check: Check, k: int, n: int) -> Check:
    return lambda fraction: check((k + fraction) / n)


def _block(kind: Kind, value: Floats, operator: Operator, rows: Ints) -> Floats:
    composed = _composed(operator, rows)
    if composed is not None:
        index, weight, rest = composed
        if not rest:
            return _entries(kind, value, index, weight)
        if kind == "linear" and value.ndim == 0 and (lattice := _lattice(rest)):
            return abs(float(value)) * np.sqrt(_stationary(index, weight, rest, lattice))
    return _general(kind, value, operator.rows(rows))


def _composed(operator: Operator, rows: Ints) -> tuple[Ints, Floats, list[Operator]] | None:
    """The leading gathers of a chain as entries of `rows`, and the operators that remain before them."""
    rest = steps(operator)
    index, weight = rows[:, None], np.ones((len(rows), 1))
    while rest and isinstance(rest[-1], Gather | Identity):
        last = rest.pop()
        if isinstance(last, Gather):
            inner = last.index[index]
            if inner.shape[1] * inner.shape[2] > WIDEST:
                return None
            inner_weight = last.weight if last.weight.ndim == 0 else last.weight[index]
            weight = (weight[:, :, None] * np.broadcast_to(inner_weight, inner.shape)).reshape(len(rows), -1)
            index = inner.reshape(len(rows), -1)
    return None if any(isinstance(step, Sum) for step in rest) else (index, weight, rest)


def _entries(kind: Kind, value: Floats, index: Ints, weight: Floats) -> Floats:
    """Rows that are k weighted primitives; entries that fall on one primitive add up before they are squared."""
    if kind in SIGNED:
        return np.asarray((weight * (value if value.ndim == 0 else value[index])).sum(axis=1))
    if index.shape[1] == 1 and kind != "members":
        return np.abs(weight[:, 0] * (value if value.ndim == 0 else value[index[:, 0]]))
    if (kind == "linear" or kind == "bound") and len(index) >= MANY:
        return np.asarray(kernels.operators.gather_fold(index, weight, value, kind))
    n_in = int(index.max()) + 1 if index.size else 0
    return _general(kind, value, fixed(index, weight, n_in))


def _general(kind: Kind, value: Floats, matrix: Any) -> Floats:
    matrix.sum_duplicates()
    if kind == "members":
        members = np.stack([matrix @ member[: matrix.shape[1]] for member in value])
        return np.asarray(members.std(axis=0, ddof=1))
    entries = matrix.data * (value if value.ndim == 0 else value[matrix.indices])
    if kind == "linear":
        entries = entries**2
    elif kind == "bound":
        entries = np.abs(entries)
    filled = np.diff(matrix.indptr) > 0
    sums = np.add.reduceat(np.append(entries, 0.0), matrix.indptr[:-1]) * filled
    return np.asarray(np.sqrt(sums) if kind == "linear" else sums)


def _lattice(rest: Sequence[Operator]) -> tuple[int, ...]:
    """The output lattice if the operators are stencils of one lattice; () otherwise."""
    lattice: tuple[int, ...] = ()
    for step in rest:
        if not isinstance(step, Stencil) or (lattice and step.lattice != lattice) or len(step.lattice) > 3:
            return ()
        lattice = step.outcome
    return lattice


def _stationary(index: Ints, weight: Floats, rest: Sequence[Operator], lattice: tuple[int, ...]) -> Floats:
    """Variance of weighted sums over stencilled unit noise: products of the covariance along each axis."""
    stencils = [step for step in rest if isinstance(step, Stencil)]
    bands = [_band([s for s in stencils if s.axis == axis], size) for axis, size in enumerate(lattice)]
    while len(bands) < 3:
        bands.insert(0, np.ones((1, 1)))
    nz, ny, nx = (1,) * (3 - len(lattice)) + lattice
    variance = kernels.operators.stencil_gather_variance(index, weight, (nz, ny, nx), *bands)
    return np.asarray(np.maximum(variance, 0.0))


_BANDS: dict[tuple[int, ...], tuple[Sequence[Stencil], Floats]] = {}


def _band(along: Sequence[Stencil], size: int) -> Floats:
    """(size, 2R+1): covariance of the axis at distances -R..R, for independent unit noise."""
    if not along:
        return np.ones((size, 1))
    key = tuple(id(s) for s in along)
    known = _BANDS.get(key)
    if known is not None and all(a is b for a, b in zip(known[0], along, strict=True)):
        return known[1]
    matrix = along[0].matrix()
    for step in along[1:]:
        matrix = step.matrix() @ matrix
    covariance = (matrix @ matrix.T).tocoo()
    reach = int(np.abs(covariance.col - covariance.row).max()) if covariance.nnz else 0
    band = np.zeros((size, 2 * reach + 1))
    np.add.at(band, (covariance.row, covariance.col - covariance.row + reach), covariance.data)
    if len(_BANDS) > 64:
        _BANDS.clear()
    _BANDS[key] = (tuple(along), band)
    return band


