"""Small matrices along an axis: smoothing that keeps straight lines, derivatives, and how far these are wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from modules.data.cubic import parabola_slopes, slope_error
from modules.data.operators import Floats, Ints, fixed


def line_fit(x: Floats, low: Ints, high: Ints, kernel: Callable[[Floats, Floats], Floats]) -> Any:
    """Each sample replaced by a line fitted to the samples around it: a smoothing that keeps straight lines.

    Parameters
    ----------
    x : (m,) coordinates
    low, high : (m,) first and last sample of each window
    kernel : (distance from the sample, length that a neighbour stands for) -> weight of the neighbour in the fit

    Returns
    -------
    (m, m) sparse

    Source: local linear regression, Fan and Gijbels 1996, 2.3.
    """
    wide = int((high - low).max()) + 1
    columns = np.minimum(low[:, None] + np.arange(wide), high[:, None])
    held = low[:, None] + np.arange(wide) <= high[:, None]
    stands = np.gradient(x) if len(x) > 1 else np.ones(1)
    away = x[columns] - x[:, None]
    weight = np.where(held, kernel(away, stands[columns]), 0.0)
    s0, s1, s2 = (np.sum(weight * away**p, axis=1)[:, None] for p in range(3))
    spread = s0 * s2 - s1**2
    alone = spread <= 1e-12 * s0 * s2
    fit = weight * (s2 - s1 * away) / np.where(alone, 1.0, spread)
    fit = np.where(alone, columns == np.arange(len(x))[:, None], fit)
    matrix = fixed(columns, np.where(held, fit, 0.0), len(x))
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix


def binomial(x: Floats) -> Any:
    """[1 2 1]/4, on an uneven axis with the weights that keep straight lines; the ends stay."""
    n = len(x)
    matrix = np.zeros((n, 3))
    matrix[:, 1] = 1.0
    if n > 2:
        h = np.diff(x)
        both = h[1:] + h[:-1]
        matrix[1:-1] = np.column_stack([h[1:] / both, np.ones(n - 2), h[:-1] / both]) / 2
    columns = np.clip(np.arange(n)[:, None] + np.array([-1, 0, 1]), 0, n - 1)
    smooth = fixed(columns, matrix, n)
    smooth.sum_duplicates()
    smooth.eliminate_zeros()
    return smooth


def gaussian(x: Floats, deviation: float) -> Any:
    """A line fitted with Gaussian weights, out to four deviations."""
    reach = 4 * deviation
    low, high = np.searchsorted(x, x - reach * (1 + 1e-12)), np.searchsorted(x, x + reach * (1 + 1e-12), "right") - 1
    return line_fit(x, low, high, lambda away, stands: stands * np.exp(-0.5 * (away / deviation) ** 2))


def running(x: Floats, size: int) -> Any:
    """A line fitted to `size` (odd) samples with equal weights; on an even axis, inside, their mean."""
    half, place = size // 2, np.arange(len(x))
    low, high = np.maximum(place - half, 0), np.minimum(place + half, len(x) - 1)
    return line_fit(x, low, high, lambda away, _: np.ones_like(away))


def slope(x: Floats) -> Any:
    """(m, m): the slope at each sample of the parabola through it and its neighbours; one-sided at the ends."""
    columns, weights = parabola_slopes(x)
    return csr_array(fixed(columns, weights, len(x)))


def slope_bias(x: Floats) -> Any | None:
    """(m, m): the error of `slope` by the third derivative; None for fewer than four samples."""
    third = third_derivative(x)
    return None if third is None else csr_array(diags_array(slope_error(x)) @ third)


def third_derivative(x: Floats) -> Any | None:
    """(m, m): mean of the two divided differences of four samples around each; None for fewer than four samples."""
    n = len(x)
    if n < 4:
        return None
    columns = np.arange(n - 3)[:, None] + np.arange(4)
    away = x[columns][:, :, None] - x[columns][:, None, :]
    weights = 6 / np.where(np.eye(4, dtype=bool), 1.0, away).prod(axis=2)
    pick = np.clip(np.arange(n)[:, None] + np.array([-2, -1]), 0, n - 4)
    return csr_array(fixed(pick, np.full(pick.shape, 0.5), n - 3) @ fixed(columns, weights, n))


def second_derivative(x: Floats) -> Any | None:
    """(m, m): by three samples, the ends as their neighbours; None for fewer than three samples."""
    n = len(x)
    if n < 3:
        return None
    columns = np.clip(np.arange(n), 1, n - 2)[:, None] + np.array([-1, 0, 1])
    h = np.diff(x)[columns[:, :2]]
    weights = 2 * np.column_stack([1 / h[:, 0], -1 / h[:, 0] - 1 / h[:, 1], 1 / h[:, 1]]) / h.sum(axis=1)[:, None]
    return csr_array(fixed(columns, weights, n))
