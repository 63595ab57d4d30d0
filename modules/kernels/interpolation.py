"""Multilinear interpolation at many points: cells, corners and weights, weighted sums, second differences.

To the bit what `modules.data.laws` and `modules.data.operators` compute with numpy, in one pass without arrays between.
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_inlined

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Whole = npt.NDArray[np.integer]


@jit
def _locate(points: Floats, place: Floats, start: Integers, cell: Integers, u: Floats) -> None:
    for axis in range(start.size - 1):
        first, last = start[axis], start[axis + 1] - 2
        even = (last + 1 - first) / (place[last + 1] - place[first])
        for n in range(len(points)):
            x = points[n, axis]
            i = min(max(first + int((x - place[first]) * even), first), last)
            while i > first and x < place[i]:
                i -= 1
            while i < last and x >= place[i + 1]:
                i += 1
            cell[n, axis] = i - first
            u[n, axis] = min(max((x - place[i]) / (place[i + 1] - place[i]), 0.0), 1.0)


@jit
def _corners(cell: Integers, stride: Integers, low: Floats, high: Floats, index: Integers, weight: Floats) -> None:
    dimensions = stride.size
    for n in range(len(cell)):
        node = 0
        for axis in range(dimensions):
            node += cell[n, axis] * stride[axis]
        index[n, 0], weight[n, 0] = node, low[0, n]
        index[n, 1], weight[n, 1] = node + stride[0], high[0, n]
        if dimensions > 1:
            p, q, step = low[1, n], high[1, n], stride[1]
            for c in range(2):
                index[n, 2 + c], weight[n, 2 + c] = index[n, c] + step, weight[n, c] * q
                weight[n, c] *= p
        if dimensions > 2:
            p, q, step = low[2, n], high[2, n], stride[2]
            for c in range(4):
                index[n, 4 + c], weight[n, 4 + c] = index[n, c] + step, weight[n, c] * q
                weight[n, c] *= p


@jit
def _gather(index: Integers, weight: Floats, values: Floats, result: Floats) -> None:
    for n in range(len(index)):
        total = 0.0
        for c in range(index.shape[1]):
            if weight[n, c] != 0.0:
                total += weight[n, c] * values[index[n, c]]
        result[n] = total


@lean_inlined
def _second(values: Floats, place: Floats, first: int, last: int, i: int, node: int, step: int) -> float:
    """The three-point second difference at node i of an axis; not a number at its ends or beside a hole."""
    if i <= first or i >= last:
        return math.nan
    before, after = place[i] - place[i - 1], place[i + 1] - place[i]
    rise, fall = (values[node] - values[node - step]) / before, (values[node + step] - values[node]) / after
    bend: float = 2.0 * (fall - rise) / (after + before)
    return bend


@jit
def _curvature(
    cell: Integers, u: Floats, values: Floats, place: Floats, start: Integers, stride: Integers, result: Floats
) -> None:
    dimensions = stride.size
    for n in range(len(cell)):
        for axis in range(dimensions):
            result[n, axis] = 0.0
        for c in range(1 << dimensions):
            weight, node = 1.0, 0
            for axis in range(dimensions):
                high = (c >> axis) & 1
                weight *= u[n, axis] if high else 1.0 - u[n, axis]
                node += (cell[n, axis] + high) * stride[axis]
            if weight == 0.0:
                continue
            for axis in range(dimensions):
                first, last, step = start[axis], start[axis + 1] - 1, stride[axis]
                i = first + cell[n, axis] + ((c >> axis) & 1)
                bend = _second(values, place, first, last, i, node, step)
                if bend != bend and i > first:
                    bend = _second(values, place, first, last, i - 1, node - step, step)
                if bend != bend and i < last:
                    bend = _second(values, place, first, last, i + 1, node + step, step)
                result[n, axis] += weight * bend


def locate(points: Floats, axes: tuple[Floats, ...]) -> tuple[Integers, Floats]:
    """The cell of each point along each axis and the position in it; the border's for a point outside.

    Parameters
    ----------
    points : (n, d) or more columns
    axes : coordinates along x, y[, z], at least two each, ascending

    Returns
    -------
    (n, d) int64; (n, d) in [0, 1]
    """
    cell, u = np.empty((len(points), len(axes)), np.int64), np.empty((len(points), len(axes)))
    _locate(np.ascontiguousarray(points, np.float64), *_joined(axes), cell, u)
    return cell, u


def corners(cell: Whole, stride: Whole, factors: list[tuple[Floats, Floats]]) -> tuple[Integers, Floats]:
    """Corners of cells and the products of the factors of their axes.

    Parameters
    ----------
    cell : (n, d)
    stride : (d,) of the flat index along x, y[, z]
    factors : d pairs of (n,), for the low and the high corner along an axis

    Returns
    -------
    (n, 2^d) int64 places; (n, 2^d) weights
    """
    low, high = (np.array([pair[side] for pair in factors], np.float64) for side in (0, 1))
    shape = len(cell), 1 << len(factors)
    index, weight = np.empty(shape, np.int64), np.empty(shape)
    _corners(np.ascontiguousarray(cell, np.int64), np.ascontiguousarray(stride, np.int64), low, high, index, weight)
    return index, weight


def gather(index: Whole, weight: Floats, values: Floats) -> Floats:
    """Weighted sums (n,) of values at places (n, k); what has weight 0 is not looked at.

    Raises
    ------
    IndexError
        If a place is not among the values.
    """
    if len(index) and not (index.min() >= 0 and index.max() < len(values)):
        raise IndexError(f"places {index.min()} to {index.max()} are not all among {len(values)} values")
    result = np.empty(len(index))
    _gather(np.ascontiguousarray(index, np.int64), np.ascontiguousarray(weight, np.float64), _flat(values), result)
    return result


def curvature(cell: Whole, u: Floats, values: Floats, axes: tuple[Floats, ...]) -> Floats:
    """Second differences along each axis, interpolated: (n, d); where there is none, of the neighbour along the axis.

    Parameters
    ----------
    cell, u : (n, d), as of `locate`
    values : (nodes,)
    axes : coordinates along x, y[, z]

    Returns
    -------
    (n, d); not a number where no neighbour has one
    """
    place, start = _joined(axes)
    stride = np.cumprod([1, *np.diff(start)[:-1]]).astype(np.int64)
    result = np.empty(cell.shape)
    _curvature(np.ascontiguousarray(cell, np.int64), np.ascontiguousarray(u), _flat(values), place, start, stride, result)
    return result


def _flat(values: Floats) -> Floats:
    flat = np.ascontiguousarray(values, np.float64).reshape(-1).view()
    flat.flags.writeable = False  # one signature for arrays that may and may not be written
    return flat


def _joined(axes: tuple[Floats, ...]) -> tuple[Floats, Integers]:
    """All coordinates, one axis after the other, and where each starts."""
    return np.concatenate(axes).astype(np.float64), np.cumsum([0, *map(len, axes)]).astype(np.int64)


def warm() -> None:
    """Compile the kernels of this file."""
    axes = (np.arange(2.0), np.arange(2.0))
    cell, u = locate(np.zeros((1, 2)), axes)
    index, weight = corners(cell, np.array([1, 2]), [(1 - t, t) for t in u.T])
    gather(index, weight, np.zeros(4))
    curvature(cell, u, np.zeros(4), axes)
