"""Kernels of the accuracy algebra: what gathers do to the sizes of errors, without ever building a sparse matrix.

A gather is n rows of k weights: row i is sum over j of weight[i, j] times the primitive value at index[i, j]. The same
index may occur more than once in a row; its weights add up first, as they stand for one and the same error.
"""

import math
from typing import Any, Literal, TypeVar

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Kind = Literal["linear", "bound", "signed"]
Array = TypeVar("Array", bound=npt.NDArray[Any])

_KINDS = {"linear": 0, "bound": 1, "signed": 2}


def gather_fold(index: npt.NDArray[np.integer], weight: Floats, value: npt.ArrayLike, kind: Kind) -> Floats:
    """The size of each row's error.

    Parameters
    ----------
    index, weight : (n, k)
        Rows of the gather.
    value : (n_in,) or ()
        Of the primitives: standard deviations, bounds or signed errors; a single number is the same for all.
    kind
        `linear`: sqrt(sum (w v)^2); `bound`: sum |w| |v|; `signed`: sum w v; w is what the weights of an index add to.

    Returns
    -------
    (n,)

    Raises
    ------
    ValueError
        If the shapes do not fit or the kind is not known.
    IndexError
        If an index is outside the values (of a single number every index from 0 on is inside).

    Accuracy: rounding of the sums, in the order of the row.
    """
    if kind not in _KINDS:
        raise ValueError(f"no kind of error is called {kind!r}: {', '.join(_KINDS)}")
    values = np.asarray(value, np.float64)
    if values.ndim > 1:
        raise ValueError(f"values of one error each, or one for all, are needed, not an array of shape {values.shape}")
    rows, weights = _gather_at_the_door(index, weight, values.size if values.ndim else None)
    out = np.empty(len(rows))
    _fold(rows, weights, _frozen(values.reshape(-1)), int(values.ndim > 0), _KINDS[kind], out)
    return out


def stencil_gather_variance(
    index: npt.NDArray[np.integer],
    weight: Floats,
    lattice: tuple[int, int, int],
    cov_z: Floats,
    cov_y: Floats,
    cov_x: Floats,
) -> Floats:
    """The variance of each row of a gather over a lattice whose values a product of stencils has correlated.

    Parameters
    ----------
    index, weight : (n, k)
        Flat indices into the lattice, row-major in z, y, x.
    lattice
        Numbers of nodes along z, y, x; 1 where there is no such axis.
    cov_z, cov_y, cov_x : (nodes of the axis, 2 R + 1)
        Banded covariance of the stencils along each axis, for primitives of variance 1:
        cov[p, d + R] = (S S^T)[p, p + d]; what lies outside the lattice is not read. R may differ from axis to axis.

    Returns
    -------
    (n,)
        Never below 0.

    Raises
    ------
    ValueError
        If shapes do not fit.
    IndexError
        If an index is outside the lattice.

    Accuracy: exact in the algebra, borders included: sum_ab w_a w_b prod_axis (S S^T)[p_a, p_b]; rounding else.
    """
    rows, weights = _gather_at_the_door(index, weight, math.prod(lattice))
    bands = []
    for name, size, band in zip("zyx", lattice, (cov_z, cov_y, cov_x), strict=True):
        if band.ndim != 2 or band.shape[0] != size or band.shape[1] % 2 == 0:
            raise ValueError(f"a band of shape {band.shape} does not fit the {size} nodes along {name}")
        bands.append(_frozen(np.ascontiguousarray(band, np.float64)))
    out = np.empty(len(rows))
    _variance(rows, weights, lattice[1], lattice[2], bands[0], bands[1], bands[2], out)
    return out


def _gather_at_the_door(index: npt.NDArray[np.integer], weight: Floats, n_in: int | None) -> tuple[Integers, Floats]:
    rows, weights = np.ascontiguousarray(index, np.int64), np.ascontiguousarray(weight, np.float64)
    if rows.ndim != 2 or rows.shape != weights.shape:
        raise ValueError(f"indices of shape {rows.shape} and weights of shape {weights.shape} are not one gather")
    if rows.size and (rows.min() < 0 or (n_in is not None and rows.max() >= n_in)):
        raise IndexError(f"a gather from {n_in} values reaches outside: {rows.min()} to {rows.max()}")
    return _frozen(rows), _frozen(weights)


def _frozen(array: Array) -> Array:
    """The array, seen read-only: one signature for arrays that may and may not be written."""
    view = array.view()
    view.flags.writeable = False
    return view


@jit
def _fold(index: Integers, weight: Floats, value: Floats, stride: int, kind: int, out: Floats) -> None:
    n, k = index.shape
    joined = np.empty(k)
    for i in range(n):
        doubled = False
        if kind != 2:
            for a in range(1, k):
                for b in range(a):
                    doubled |= index[i, a] == index[i, b]
        weights = weight[i]
        if doubled:
            _join(index[i], weight[i], joined)
            weights = joined
        total = 0.0
        for a in range(k):
            part = weights[a] * value[index[i, a] * stride]
            if kind == 0:
                total += part * part
            elif kind == 1:
                total += abs(part)
            else:
                total += part
        out[i] = math.sqrt(total) if kind == 0 else total


@jit
def _join(index: Integers, weight: Floats, joined: Floats) -> None:
    """The weights of each index added up at its first place; 0 at the others."""
    for a in range(index.size):
        joined[a] = 0.0
        for b in range(index.size):
            if index[b] == index[a]:
                if b < a:
                    joined[a] = 0.0
                    break
                joined[a] += weight[b]


@jit
def _variance(
    index: Integers, weight: Floats, ny: int, nx: int, cov_z: Floats, cov_y: Floats, cov_x: Floats, out: Floats
) -> None:
    n, k = index.shape
    place = np.empty((3, k), np.int64)
    for i in range(n):
        for a in range(k):
            flat = index[i, a]
            place[0, a], place[1, a], place[2, a] = flat // (nx * ny), flat // nx % ny, flat % nx
        total = 0.0
        for a in range(k):
            z, y, x = place[0, a], place[1, a], place[2, a]
            row = 0.5 * weight[i, a] * _band(cov_z, z, z) * _band(cov_y, y, y) * _band(cov_x, x, x)
            for b in range(a):
                c = _band(cov_x, x, place[2, b])
                if c != 0.0:
                    row += weight[i, b] * c * _band(cov_y, y, place[1, b]) * _band(cov_z, z, place[0, b])
            total += 2.0 * weight[i, a] * row
        out[i] = max(total, 0.0)


@jit
def _band(band: Floats, p: int, q: int) -> float:
    """The covariance of the nodes p and q of an axis; 0 outside the band."""
    reach = band.shape[1] // 2
    return band[p, q - p + reach] if abs(q - p) <= reach else 0.0


def warm() -> None:
    """Compile the kernels of this file."""
    index, weight, band = np.zeros((1, 1), np.int64), np.ones((1, 1)), np.ones((1, 1))
    gather_fold(index, weight, 1.0, "linear")
    stencil_gather_variance(index, weight, (1, 1, 1), band, band, band)
