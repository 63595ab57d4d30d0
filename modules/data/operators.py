"""Linear operators that bring an error from where it arose to where it is wanted, kept and never multiplied out.

An operator has n_out rows and n_in columns. It gives the rows that someone asks for as a sparse matrix, and can be
applied to a whole array; nothing of the size n_out x n_in is ever made.

    Gather     k weighted entries a row: probe, crop, displacement, a linearised point-wise function
    Stencil    a small matrix along one axis of a lattice: smoothing, difference, resampling
    Chain      one after the other
    Sum        the same source by several ways
    Interleave components of a vector side by side: the rows of several operators take turns
    Identity   every row is its own primitive
    Spread     every row is the one primitive: a common error (a bias)
    Matrix     an explicit sparse matrix, where a module has one
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from modules import kernels
from modules.data.combine import combine

MANY = 8_192
"""From so many rows on the compiled way is worth its loading."""

Floats = NDArray[np.float64]
Ints = NDArray[np.integer[Any]]

BLOCK = 1 << 15
"""Rows that are folded at once."""


@dataclass(frozen=True, eq=False)
class Operator:
    """A linear map of n_in values to n_out values."""

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        raise TypeError(f"{type(self).__name__} states no shape")

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array (len(i), n_in)."""
        raise TypeError(f"{type(self).__name__} gives no rows")

    def apply(self, x: Floats) -> Floats:
        """The map applied to the n_in values `x`, all rows."""
        parts = [self.rows(block) @ x for block in blocks(self.shape[0])]
        return np.concatenate(parts) if parts else np.zeros(0)

    def after(self, first: Operator) -> Operator:
        """This operator applied to what `first` gives."""
        if first.shape[0] != self.shape[1]:
            raise ValueError(f"an operator of {self.shape[1]} inputs cannot follow one of {first.shape[0]} outputs")
        if isinstance(first, Identity):
            return self
        if isinstance(self, Identity):
            return first
        return Chain(first, self)


@dataclass(frozen=True, eq=False)
class Gather(Operator):
    """Each row is a weighted sum of k entries.

    Parameters
    ----------
    index : (n_out, k) int, entries of the input
    weight : (n_out, k) float, or 0-d when it is the same for all
    n_in : number of inputs
    """

    index: Ints
    weight: Floats
    n_in: int

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        return len(self.index), self.n_in

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        weight = self.weight if self.weight.ndim == 0 else self.weight[i]
        index = self.index[i]
        return fixed(index, np.broadcast_to(weight, index.shape), self.n_in)

    def apply(self, x: Floats) -> Floats:
        """The weighted sums of `x`; an entry of weight 0 is not touched, so it may be NaN."""
        if self.weight.ndim == 2 and len(self.index) >= MANY:
            return kernels.interpolation.gather(self.index, self.weight, x)
        result = np.zeros(len(self.index))
        for k in range(self.index.shape[1]):
            weight = self.weight if self.weight.ndim == 0 else self.weight[:, k]
            result += np.where(weight == 0, 0.0, weight * x[self.index[:, k]])
        return result


@dataclass(frozen=True, eq=False)
class Stencil(Operator):
    """A small matrix along one axis of a lattice, the same for every line of that axis.

    Parameters
    ----------
    lattice : shape of the input lattice, C order
    axis : the axis that is combined
    columns : (m_out, k) int, positions on the input axis that output position p combines
    weights : (m_out, k) float
    """

    lattice: tuple[int, ...]
    axis: int
    columns: Ints
    weights: Floats

    @property
    def outcome(self) -> tuple[int, ...]:
        """Shape of the output lattice."""
        return (*self.lattice[: self.axis], len(self.columns), *self.lattice[self.axis + 1 :])

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        return math.prod(self.outcome), math.prod(self.lattice)

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        inner = math.prod(self.lattice[self.axis + 1 :])
        m_out, m_in = len(self.columns), self.lattice[self.axis]
        lines, offset = np.divmod(np.asarray(i, np.int64), inner)
        outer, position = np.divmod(lines, m_out)
        base = outer * (m_in * inner) + offset
        return fixed(base[:, None] + self.columns[position] * inner, self.weights[position], self.shape[1])

    def apply(self, x: Floats) -> Floats:
        """The combination of `x` along the axis."""
        return combine(np.asarray(x, float).reshape(self.lattice), self.axis, self.columns, self.weights).ravel()

    def matrix(self) -> Any:
        """The small matrix (m_out, m_in), as csr_array."""
        return fixed(self.columns, self.weights, self.lattice[self.axis])


@dataclass(frozen=True, eq=False)
class Spread(Operator):
    """One primitive reaches every row with weight 1: a common error."""

    n_out: int

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, 1)."""
        return self.n_out, 1

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        return fixed(np.zeros((len(i), 1), np.int32), np.ones((len(i), 1)), 1)

    def apply(self, x: Floats) -> Floats:
        """The primitive, n_out times."""
        return np.full(self.n_out, float(np.ravel(x)[0]))


@dataclass(frozen=True, eq=False)
class Matrix(Operator):
    """An explicit sparse matrix."""

    entries: Any

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        n_out, n_in = self.entries.shape
        return int(n_out), int(n_in)

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        return csr_array(self.entries[i])

    def apply(self, x: Floats) -> Floats:
        """The product with `x`."""
        return np.asarray(self.entries @ x)


@dataclass(frozen=True, eq=False)
class Chain(Operator):
    """`then` applied to what `first` gives."""

    first: Operator
    then: Operator

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        return self.then.shape[0], self.first.shape[1]

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array; only touched columns are asked for, and packed before the product."""
        outer = self.then.rows(i)
        touched, packed = np.unique(outer.indices, return_inverse=True)
        inner = self.first.rows(touched)
        columns, small = np.unique(inner.indices, return_inverse=True)
        outer = csr_array((outer.data, packed.astype(np.int32), outer.indptr), shape=(len(i), len(touched)))
        inner = csr_array((inner.data, small.astype(np.int32), inner.indptr), shape=(len(touched), len(columns)))
        product = outer @ inner
        return csr_array((product.data, columns[product.indices], product.indptr), shape=(len(i), self.shape[1]))

    def apply(self, x: Floats) -> Floats:
        """Both steps on the whole."""
        return self.then.apply(self.first.apply(x))


@dataclass(frozen=True, eq=False)
class Sum(Operator):
    """The same source by several ways."""

    parts: tuple[Operator, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        return self.parts[0].shape

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        return reduce(lambda a, b: a + b, (part.rows(i) for part in self.parts))

    def apply(self, x: Floats) -> Floats:
        """The sum of the ways."""
        total = np.array(self.parts[0].apply(x))
        for part in self.parts[1:]:
            total += part.apply(x)
        return total


@dataclass(frozen=True, eq=False)
class Interleave(Operator):
    """The rows of c operators of one shape take turns: row c i + k is row i of part k, component k of item i."""

    parts: tuple[Operator, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """(n_out, n_in)."""
        rows, n_in = self.parts[0].shape
        return rows * len(self.parts), n_in

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        item, turn = np.divmod(np.asarray(i, np.int64), len(self.parts))
        order = np.argsort(turn, kind="stable")
        stacked = vstack([part.rows(item[order[turn[order] == k]]) for k, part in enumerate(self.parts)], format="csr")
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        return csr_array(stacked[place])

    def apply(self, x: Floats) -> Floats:
        """The parts side by side."""
        result = np.empty((self.parts[0].shape[0], len(self.parts)))
        for k, part in enumerate(self.parts):
            result[:, k] = part.apply(x)
        return result.ravel()

    def after(self, first: Operator) -> Operator:
        """Each part applied to what `first` gives."""
        return Interleave(tuple(part.after(first) for part in self.parts))


@dataclass(frozen=True, eq=False)
class Identity(Operator):
    """Every row is its own primitive; it costs no memory."""

    n: int

    @property
    def shape(self) -> tuple[int, int]:
        """(n, n)."""
        return self.n, self.n

    def rows(self, i: Ints) -> Any:
        """The rows `i` as a csr_array."""
        return fixed(np.asarray(i)[:, None], np.ones((len(i), 1)), self.n)

    def apply(self, x: Floats) -> Floats:
        """`x` itself."""
        return np.broadcast_to(np.asarray(x, float), (self.n,))


def scaling(weight: Floats) -> Gather:
    """Each of n rows is its own input times `weight` (n,)."""
    return Gather(np.arange(len(weight))[:, None], np.asarray(weight, float)[:, None], len(weight))


def select(index: Ints, n_in: int) -> Gather:
    """The rows `index` (n_out,) of n_in inputs: a crop, a subset."""
    return Gather(np.asarray(index)[:, None], np.asarray(1.0), n_in)


def stencil(lattice: Sequence[int], axis: int, offsets: Sequence[int], weights: Sequence[float]) -> Stencil:
    """The same weights at each position along an axis; ends repeat the border sample."""
    size = lattice[axis]
    columns = np.clip(np.arange(size)[:, None] + np.asarray(offsets), 0, size - 1)
    return Stencil(tuple(lattice), axis, columns, np.broadcast_to(np.asarray(weights, float), columns.shape).copy())


def along(lattice: Sequence[int], axis: int, matrix: Any) -> Stencil:
    """A sparse matrix (m_out, m_in) along an axis of a lattice; entries that a row lacks repeat its first column."""
    rows = csr_array(matrix)
    filled = np.diff(rows.indptr)
    wide = int(filled.max(initial=0))
    place = rows.indptr[:-1, None] + np.arange(wide)
    held = np.arange(wide) < filled[:, None]
    safe = np.where(held, place, rows.indptr[:-1, None]).clip(0, max(rows.nnz - 1, 0))
    columns = rows.indices[safe] if rows.nnz else np.zeros(safe.shape, np.int64)
    weights = np.where(held, rows.data[safe], 0.0) if rows.nnz else np.zeros(safe.shape)
    return Stencil(tuple(lattice), axis, columns.astype(np.int64), weights)


def uniform(lattice: Sequence[int], factor: float) -> Stencil:
    """Every value of a lattice times one factor; it costs one axis of memory."""
    last = lattice[-1]
    return Stencil(tuple(lattice), len(lattice) - 1, np.arange(last)[:, None], np.full((last, 1), float(factor)))


def fixed(columns: Ints, weights: Floats, n_in: int) -> Any:
    """A csr_array with k entries a row; doubled columns add up."""
    n, k = columns.shape
    kind = np.int32 if max(n_in, n * k) < 2**31 else np.int64
    indptr = np.arange(0, n * k + 1, k, dtype=kind) if k else np.zeros(n + 1, kind)
    data = np.ascontiguousarray(weights, dtype=float).ravel()
    return csr_array((data, columns.astype(kind, copy=False).ravel(), indptr), shape=(n, n_in))


def blocks(n: int, size: int = BLOCK) -> Iterator[Ints]:
    """0..n-1 in blocks of rows."""
    for start in range(0, n, size):
        yield np.arange(start, min(n, start + size))


def steps(operator: Operator) -> list[Operator]:
    """The operators of a chain, the first applied first."""
    if isinstance(operator, Chain):
        return [*steps(operator.first), *steps(operator.then)]
    return [operator]
