"""The cubic law: a Hermite cubic in each axis, with slopes from the parabola through three samples.

On evenly spaced samples it is the Catmull-Rom spline. It is C1, local (four samples an axis) and exact for parabolas.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Source
from modules.data.grid import Grid
from modules.data.laws import axial, cell_sizes, corner_max, corners, locate, second_derivative
from modules.data.operators import Floats, Gather, Ints

CUBIC = Source(
    "Interpolation between samples",
    "model",
    "estimated",
    "error of the slopes, a sixth of h^2 times the third derivative, through the Hermite cubic; low below 8 samples a period "
    "[cubic-third-difference/1]",
)


@dataclass(frozen=True)
class Cubic:
    """Bicubic or tricubic Hermite interpolation: four samples along each axis, three beside an end."""

    name: str = "cubic"
    source: Source = CUBIC

    def weights(self, grid: Grid, points: Floats) -> Gather:
        """4^d weights a point."""
        cell, u = locate(grid, points)
        return _product(grid, [_along(grid, axis, cell[:, axis], u[:, axis])[:2] for axis in range(grid.dimensions)])

    def slopes(self, grid: Grid, points: Floats) -> tuple[Gather, ...]:
        """Derivative of the Hermite polynomial of the cell."""
        cell, u = locate(grid, points)
        along = [_along(grid, axis, cell[:, axis], u[:, axis]) for axis in range(grid.dimensions)]
        return tuple(
            _product(grid, [(index, slope if a == axis else weight) for a, (index, weight, slope) in enumerate(along)])
            for axis in range(grid.dimensions)
        )

    def error(self, grid: Grid, values: Floats, points: Floats) -> Floats:
        """Errors of the slopes at both ends of the cell, carried through the Hermite cubic, and that of the cubic itself."""
        cell, u = locate(grid, points)
        total = np.zeros(len(points))
        for axis in range(grid.dimensions):
            t, h = u[:, axis], cell_sizes(grid, axis)[cell[:, axis]]
            third = _third_derivative(grid, values, axis).ravel()
            low, high = (_at_end(grid, cell, u, axis, end).apply(third) for end in (0, 1))
            scale = slope_error(axial(grid).axes[axis])
            first, last = scale[cell[:, axis]] * low, scale[cell[:, axis] + 1] * high
            total += h * (t * (1 - t) ** 2 * first - t**2 * (1 - t) * last)
            total -= h**3 / 24 * t**2 * (1 - t) ** 2 * (high - low)
        return total

    def largest(self, grid: Grid, values: Floats) -> Floats:
        """4/27 h of the errors of the slopes at both ends, and 1/384 of h^4 times the fourth derivative."""
        total = np.zeros(tuple(n - 1 for n in grid.shape))
        for axis in range(grid.dimensions):
            d = grid.dimensions - 1 - axis
            along = [1] * grid.dimensions
            along[d] = -1
            h = cell_sizes(grid, axis).reshape(along)
            third = _third_derivative(grid, values, axis)
            ends = np.abs(third * slope_error(axial(grid).axes[axis]).reshape(along))
            n = ends.shape[d]
            slopes = corner_max(ends.take(range(n - 1), d) + ends.take(range(1, n), d), skip=d)
            total = total + 4 / 27 * h * slopes + h**3 / 384 * corner_max(np.abs(np.diff(third, axis=d)), skip=d)
        return np.asarray(total).ravel()


def _at_end(grid: Grid, cell: Ints, u: Floats, axis: int, end: int) -> Gather:
    """Weights of the samples at the low (0) or high (1) end of the cell along an axis, linear along the others."""
    chosen = (np.full(len(u), 1.0 - end), np.full(len(u), float(end)))
    return corners(grid, cell, [chosen if a == axis else (1 - t, t) for a, t in enumerate(u.T)])


def _third_derivative(grid: Grid, values: Floats, axis: int) -> Floats:
    """Third derivative along x (0), y (1) or z (2), by the difference of the second over two cells."""
    second = second_derivative(grid, values, axis)
    x, d = axial(grid).axes[axis], values.ndim - 1 - axis
    if len(x) < 4:
        return np.full(second.shape, np.nan)
    return np.asarray(np.gradient(second, x, axis=d))


def slope_error(x: Floats) -> Floats:
    """Error of the slope of the parabola at each sample of an axis, for a third derivative of one."""
    if len(x) == 2:
        return np.zeros(2)
    columns = np.clip(np.arange(len(x)), 1, len(x) - 2)[:, None] + np.array([-1, 0, 1])
    away = x[:, None] - x[columns]
    return np.asarray(-np.where(away == 0, 1.0, away).prod(axis=1) / 6)


def _along(grid: Grid, axis: int, cell: Ints, u: Floats) -> tuple[Ints, Floats, Floats]:
    """The samples on an axis that a point depends on, (n, k), with their weights for the value and for the derivative."""
    x = axial(grid).axes[axis]
    wide = min(4, len(x))
    base = np.clip(cell - 1, 0, len(x) - wide)
    h = x[cell + 1] - x[cell]
    columns, slopes = parabola_slopes(x)
    value, derivative = np.zeros((len(u), wide)), np.zeros((len(u), wide))
    basis = (2 * u**3 - 3 * u**2 + 1, h * (u**3 - 2 * u**2 + u), 3 * u**2 - 2 * u**3, h * (u**3 - u**2))
    change = ((6 * u**2 - 6 * u) / h, 3 * u**2 - 4 * u + 1, (6 * u - 6 * u**2) / h, 3 * u**2 - 2 * u)
    row = np.arange(len(u))
    for out, (p0, m0, p1, m1) in ((value, basis), (derivative, change)):
        for node, p, m in ((cell, p0, m0), (cell + 1, p1, m1)):
            out[row, node - base] += p
            for j in range(columns.shape[1]):
                out[row, columns[node, j] - base] += m * slopes[node, j]
    return base[:, None] + np.arange(wide), value, derivative


def parabola_slopes(x: Floats) -> tuple[Ints, Floats]:
    """For each sample of an axis, the three samples of its parabola and their weights in its slope there."""
    if len(x) == 2:
        return np.array([[0, 1], [0, 1]]), np.array([[-1.0, 1], [-1, 1]]) / (x[1] - x[0])
    middle = np.clip(np.arange(len(x)), 1, len(x) - 2)
    columns = middle[:, None] + np.array([-1, 0, 1])
    a, b, c = (x[columns[:, j]] for j in range(3))
    first, second = (2 * x - b - c) / ((a - b) * (a - c)), (2 * x - a - c) / ((b - a) * (b - c))
    return columns, np.column_stack([first, second, -first - second])


def _product(grid: Grid, along: list[tuple[Ints, Floats]]) -> Gather:
    """Products of the weights of each axis (in x, y, z)."""
    n, stride = len(along[0][0]), 1
    index, weight = np.zeros((n, 1), np.int64), np.ones((n, 1))
    for (columns, weights), size in zip(along, reversed(grid.shape), strict=True):
        index = (index[:, None, :] + stride * columns[:, :, None]).reshape(n, -1)
        weight = (weight[:, None, :] * weights[:, :, None]).reshape(n, -1)
        stride *= size
    return Gather(index, weight, grid.count)


def not_a_knot(axes: Sequence[Floats], values: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
    """A second cubic, in which each sample has a say everywhere: the tensor spline whose end pieces are one; C2, fourth order.

    Along an axis of three samples it is their parabola, of two their line.

    Parameters
    ----------
    axes : coordinates of the samples along x, y, z
    values : (nz, ny, nx, ...)

    Returns
    -------
    coefficients of B-splines, in the shape of the values; (d, cells) for each cell along each axis the first of its four; and
    (d, cells, 16) the weight of each in powers of the place in the cell

    Raises
    ------
    ValueError : a sample that is no number, for it would be none everywhere
    """
    if not np.isfinite(values).all():
        raise ValueError("a spline goes through all samples, and some are no numbers: fill them, or take the linear law")
    from scipy.interpolate import BSpline, make_interp_spline

    longest, d = max(len(x) for x in axes) - 1, len(axes)
    base, basis = np.zeros((d, longest), np.int64), np.zeros((d, longest, 4, 4))
    found = np.asarray(values, float)
    for axis, x in enumerate(axes):
        degree, n = min(3, len(x) - 1), len(x)
        spline = make_interp_spline(x, found, k=degree, axis=d - 1 - axis)
        found = np.moveaxis(np.asarray(spline.c), 0, d - 1 - axis)
        each = BSpline(spline.t, np.eye(n), degree)
        first = np.clip(np.searchsorted(spline.t, x[:-1], side="right") - 1, degree, n - 1) - degree
        base[axis, : n - 1] = np.minimum(first, max(n - 4, 0))
        for power in range(degree + 1):
            weight = each(x[:-1], nu=power) * (np.diff(x) ** power / math.factorial(power))[:, None]
            columns = np.minimum(base[axis, : n - 1, None] + np.arange(min(4, n)), n - 1)
            basis[axis, : n - 1, : min(4, n), power] = np.take_along_axis(weight, columns, axis=1)
    return np.ascontiguousarray(found), base, basis.reshape(d, longest, 16)
