"""A small matrix along one axis of an array, applied in blocks that stay in the processor's cache."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.integer[Any]]

CHUNK = 1 << 15
"""Values that are combined at once."""

RAGGED = 12
"""From so many uneven pieces on the columns are looked up one by one."""


def combine(x: Floats, axis: int, columns: Ints, weights: Floats) -> Floats:
    """Each position of the result along `axis` is a weighted sum of k positions of `x`.

    Parameters
    ----------
    x : array of any shape
    axis : the axis that is combined
    columns, weights : (m_out, k)

    Returns
    -------
    array of the shape of `x`, m_out along the axis
    """
    m_out, m_in = len(columns), x.shape[axis]
    outer, inner = math.prod(x.shape[:axis]), math.prod(x.shape[axis + 1 :])
    lines = x.reshape(outer, m_in, inner)
    result = np.zeros((outer, m_out, inner))
    if result.size:
        tall = max(1, min(m_out, CHUNK // inner))
        wide = max(1, CHUNK // (tall * inner))
        pieces = [_pieces(column) for column in columns.T]
        for first in range(0, m_out, tall):
            rows = slice(first, min(m_out, first + tall))
            parts = [_inside(p, rows) for p in pieces]
            for start in range(0, outer, wide):
                block = slice(start, start + wide)
                _block(lines[block], result[block, rows], parts, columns[rows], weights[rows])
    return result.reshape(*x.shape[:axis], m_out, *x.shape[axis + 1 :])


def _block(x: Floats, out: Floats, parts: list[list[Any]], columns: Ints, weights: Floats) -> None:
    for k, pieces in enumerate(parts):
        weight = weights[:, k, None]
        if len(pieces) > RAGGED:
            out += x[:, columns[:, k]] * weight
        else:
            for rows, source in pieces:
                out[:, rows] += x[:, source] * weight[rows]


def _pieces(column: Ints) -> list[tuple[int, int, int, int]]:
    """(first row, end row, first column, step): stretches in which the columns go in even steps."""
    found, i, n = [], 0, len(column)
    steps = np.diff(column)
    changes = np.append(np.flatnonzero(np.diff(steps)) + 1, n - 1)
    for change in changes:
        if change < i:
            continue
        end = int(change) + 1
        found.append((i, end, int(column[i]), int(column[i + 1] - column[i]) if end - i > 1 else 1))
        i = end
    if i < n:
        found.append((i, n, int(column[i]), 1))
    return found


def _inside(pieces: list[tuple[int, int, int, int]], rows: slice) -> list[tuple[slice, slice]]:
    """The pieces that fall on some rows, as (rows from the first of them, columns)."""
    found = []
    for a, b, column, step in pieces:
        low, high = max(a, rows.start), min(b, rows.stop)
        if low >= high:
            continue
        first = column + (low - a) * step
        last = first + (high - low - 1) * step
        source = slice(first, first + 1) if step == 0 else slice(first, last + 1, step)
        if step < 0:
            source = slice(first, last - 1 if last > 0 else None, step)
        found.append((slice(low - rows.start, high - rows.start), source))
    return found
