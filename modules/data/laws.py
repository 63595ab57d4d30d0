"""The law between samples: how a value between them follows, and by how much a smooth truth differs from it.

A law gives weights (value) and slopes (gradient) at points as operators on the samples, and its own error there. That
error lives only between samples: at a sample the model is the sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from modules import kernels
from modules.data.accuracy import Source
from modules.data.grid import Axial, Grid, Rectilinear, Regular
from modules.data.operators import MANY, Floats, Gather, Ints


class Law(Protocol):
    """What a Model needs to know of its law."""

    @property
    def name(self) -> str:
        """As a user writes it: nearest, linear."""

    @property
    def source(self) -> Source:
        """Who makes the law's own error."""

    def weights(self, grid: Grid, points: Floats) -> Gather:
        """Values at `points` (n, 3) as weighted samples."""

    def slopes(self, grid: Grid, points: Floats) -> tuple[Gather, ...]:
        """Derivatives along x, y[, z] at `points` as weighted samples."""

    def error(self, grid: Grid, values: Floats, points: Floats) -> Floats:
        """(n,) signed estimate of model - truth at `points`; NaN where the samples around do not tell."""

    def largest(self, grid: Grid, values: Floats) -> Floats:
        """(cells,) estimate of the largest error in each cell; NaN where the samples around do not tell."""


LINEAR = Source(
    "Interpolation between samples",
    "model",
    "estimated",
    "half the sum of u (1 - u) times the second difference along each axis; low below 8 samples a period "
    "[linear-second-difference/1]",
)
NEAREST = Source(
    "Nearest sample instead of the value between",
    "model",
    "estimated",
    "distance to the sample times the slope between samples [nearest-first-difference/1]",
)


@dataclass(frozen=True)
class Linear:
    """Linear in each axis: bilinear on a rectangle, trilinear in a box."""

    name: str = "linear"
    source: Source = LINEAR

    def weights(self, grid: Grid, points: Floats) -> Gather:
        """2^d weights a point."""
        cell, u = locate(grid, points)
        return corners(grid, cell, [(1 - t, t) for t in u.T])

    def slopes(self, grid: Grid, points: Floats) -> tuple[Gather, ...]:
        """Derivative of the multilinear polynomial of the cell."""
        cell, u = locate(grid, points)
        slopes = []
        for axis in range(u.shape[1]):
            h = cell_sizes(grid, axis)[cell[:, axis]] if u.shape[1] else np.ones(len(points))
            factors = [(-1 / h, 1 / h) if a == axis else (1 - u[:, a], u[:, a]) for a in range(u.shape[1])]
            slopes.append(corners(grid, cell, factors))
        return tuple(slopes)

    def error(self, grid: Grid, values: Floats, points: Floats) -> Floats:
        """1/2 sum_i u_i (1 - u_i) D2_i, D2 the second difference over the cell's width, interpolated."""
        cell, u = locate(grid, points)
        total = np.zeros(len(points))
        for axis, bend in enumerate(curvature(grid, values, points).T):
            h = cell_sizes(grid, axis)[cell[:, axis]]
            total += 0.5 * u[:, axis] * (1 - u[:, axis]) * h**2 * bend
        return total

    def largest(self, grid: Grid, values: Floats) -> Floats:
        """1/8 sum_i h_i^2 of the largest |second derivative| at the cell's corners."""
        total: Any = 0.0
        for axis in range(grid.dimensions):
            along = [1] * grid.dimensions
            along[grid.dimensions - 1 - axis] = -1
            h = cell_sizes(grid, axis).reshape(along)
            total = total + h**2 / 8 * corner_max(np.abs(second_derivative(grid, values, axis)))
        return np.asarray(total).ravel()


@dataclass(frozen=True)
class Nearest:
    """The value of the nearest sample; it jumps half way between two."""

    name: str = "nearest"
    source: Source = NEAREST

    def weights(self, grid: Grid, points: Floats) -> Gather:
        """One weight a point."""
        cell, u = locate(grid, points)
        return corners(grid, cell + (u > 0.5), [])

    def slopes(self, grid: Grid, points: Floats) -> tuple[Gather, ...]:
        """Zero: the law is flat between its jumps."""
        flat = self.weights(grid, points)
        return tuple(Gather(flat.index, np.asarray(0.0), flat.n_in) for _ in range(grid.dimensions))

    def error(self, grid: Grid, values: Floats, points: Floats) -> Floats:
        """Nearest - linear, the first difference times the distance."""
        flat = values.ravel()
        return np.asarray(self.weights(grid, points).apply(flat) - Linear().weights(grid, points).apply(flat))

    def largest(self, grid: Grid, values: Floats) -> Floats:
        """Half the sum over the axes of the largest first difference of the cell's edges."""
        total: Any = 0.0
        for d in range(values.ndim):
            step = np.abs(np.diff(values, axis=d))
            for other in range(values.ndim):
                if other != d:
                    n = step.shape[other]
                    step = np.maximum(step.take(range(1, n), other), step.take(range(n - 1), other))
            total = total + 0.5 * step
        return np.asarray(total).ravel()


def axial(grid: Grid) -> Axial:
    """The grid, if its cells are boxes along the axes.

    Raises
    ------
    ValueError : curvilinear and unstructured grids need point location, which this law does not do
    """
    if isinstance(grid, Regular | Rectilinear):
        return grid
    raise ValueError(f"a {grid.kind} grid cannot be sampled at points yet: resample it to a regular grid first")


def cell_sizes(grid: Grid, axis: int) -> Floats:
    """(n - 1,) lengths of the cells along x (0), y (1) or z (2)."""
    return np.diff(axial(grid).axes[axis])


def locate(grid: Grid, points: Floats) -> tuple[Ints, Floats]:
    """The cell of each point and the position in it.

    Returns
    -------
    (n, d) int cell along x, y[, z]; (n, d) float in [0, 1]

    Raises
    ------
    ValueError : a point lies outside the grid, or an axis has a single sample
    """
    box = axial(grid)
    points = np.asarray(points, float)
    cell, u = np.empty((len(points), grid.dimensions), np.int64), np.empty((len(points), grid.dimensions))
    many = len(points) >= MANY
    for axis, coordinates in enumerate(box.axes):
        if len(coordinates) < 2:
            raise ValueError(f"axis {grid.frame.axes[axis]} has a single sample: there is nothing between samples")
        x = points[:, axis]
        slack = 1e-9 * (coordinates[-1] - coordinates[0])
        outside = ~((x >= coordinates[0] - slack) & (x <= coordinates[-1] + slack))
        if outside.any():
            first = points[outside][0]
            raise ValueError(
                f"{outside.sum()} of {len(points)} points lie outside the grid, the first at "
                f"{', '.join(f'{v:g}' for v in first)}; "
                f"{grid.frame.axes[axis]} goes from {coordinates[0]:g} to {coordinates[-1]:g}"
            )
        if many:
            continue
        i = np.clip(np.searchsorted(coordinates, x, side="right") - 1, 0, len(coordinates) - 2)
        cell[:, axis] = i
        u[:, axis] = np.clip((x - coordinates[i]) / (coordinates[i + 1] - coordinates[i]), 0.0, 1.0)
    return kernels.interpolation.locate(points, box.axes) if many else (cell, u)


def corners(grid: Grid, cell: Ints, factors: list[tuple[Floats, Floats]]) -> Gather:
    """The corners of cells with products of factors per axis (in x, y, z); only the first corner without factors."""
    strides = np.cumprod([1, *reversed(grid.shape)])[: grid.dimensions]
    if factors and len(cell) >= MANY:
        return Gather(*kernels.interpolation.corners(cell, strides, factors), grid.count)
    index = (cell @ strides)[:, None]
    weight: Any = np.asarray(1.0)
    for axis, (low, high) in enumerate(factors):
        index = np.concatenate([index, index + strides[axis]], axis=1)
        weight = np.ones((len(cell), 1)) if weight.ndim == 0 else weight
        weight = np.concatenate([weight * low[:, None], weight * high[:, None]], axis=1)
    return Gather(index, weight, grid.count)


def curvature(grid: Grid, values: Floats, points: Floats) -> Floats:
    """(n, d) second derivatives of the samples along x, y[, z], by `second_derivative`, interpolated at points."""
    cell, u = locate(grid, points)
    if len(points) >= MANY:
        return kernels.interpolation.curvature(cell, u, values, axial(grid).axes)
    weights = corners(grid, cell, [(1 - t, t) for t in u.T])
    every = [weights.apply(second_derivative(grid, values, axis).ravel()) for axis in range(grid.dimensions)]
    return np.stack(every, axis=1) if every else np.zeros((len(points), 0))


def second_derivative(grid: Grid, values: Floats, axis: int) -> Floats:
    """Second derivative along x (0), y (1) or z (2) by the three-point difference of the axis's own spacing.

    Ends, and samples beside a hole, take the value of the neighbour inside; NaN where there is none.
    """
    coordinates = axial(grid).axes[axis]
    a = np.moveaxis(np.asarray(values, float), values.ndim - 1 - axis, 0)
    result = np.full(a.shape, np.nan)
    if len(coordinates) > 2:
        h = np.diff(coordinates).reshape(-1, *[1] * (a.ndim - 1))
        slope = np.diff(a, axis=0) / h
        result[1:-1] = 2 * np.diff(slope, axis=0) / (h[1:] + h[:-1])
    for shift in (1, -1):  # border, and the edge of a hole
        beside = np.roll(result, shift, axis=0)
        beside[0 if shift > 0 else -1] = np.nan
        result = np.where(np.isnan(result), beside, result)
    return np.moveaxis(result, 0, values.ndim - 1 - axis)


def corner_max(values: Floats, skip: int | None = None) -> Floats:
    """Largest of the 2^d corners of each cell; NaN if any corner is NaN. Axis `skip` is along cells already."""
    for d in range(values.ndim):
        if d == skip:
            continue
        n = values.shape[d]
        values = np.maximum(values.take(range(n - 1), d), values.take(range(1, n), d))
    return values
