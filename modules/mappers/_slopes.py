"""Slopes of a bilinear model at the points of its contours: how far an error of the values moves a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.data.accuracy import Accuracy, Flag
from modules.data.grid import Rectilinear, Regular
from modules.data.laws import second_derivative
from modules.data.wires import Model

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VALID = 0.4
"""Largest kappa = error |F_nn| / slope^2 for which 95 % bands of a first-order position cover 94 to 98 %."""


def smallest(model: Model, points: Floats, segments: Ints, cell: Ints, length: Floats) -> Floats:
    """The smaller slope of the two cells that meet at each point of the lines.

    Parameters
    ----------
    points : (n, 3); segments : (s, 2) int; cell : (s,) int, cell of each segment
    length : (2,) coordinates per unit of length along x and y

    Returns
    -------
    (n,) float, unit of the field / unit of length
    """
    slope = np.full(len(points), np.inf)
    for end in (0, 1):
        at = segments[:, end]
        across, along = _gradient(model, points[at], cell)
        np.minimum.at(slope, at, np.hypot(across * length[0], along * length[1]))
    return slope


def _gradient(model: Model, points: Floats, cell: Ints) -> tuple[Floats, Floats]:
    grid = model.grid
    assert isinstance(grid, Regular | Rectilinear)
    x, y = grid.axes
    values = np.asarray(model.samples.values, float)
    row, column = np.divmod(cell, len(x) - 1)
    hx, hy = np.diff(x)[column], np.diff(y)[row]
    u, v = (points[:, 0] - x[column]) / hx, (points[:, 1] - y[row]) / hy
    f00, f10 = values[row, column], values[row, column + 1]
    f01, f11 = values[row + 1, column], values[row + 1, column + 1]
    return ((1 - v) * (f10 - f00) + v * (f11 - f01)) / hx, ((1 - u) * (f01 - f00) + u * (f11 - f10)) / hy


def saddles(model: Model, cell: Ints) -> Floats:
    """(m, 3) positions of the saddle points of cells, kept within each cell."""
    grid = model.grid
    assert isinstance(grid, Regular | Rectilinear)
    x, y = grid.axes
    values = np.asarray(model.samples.values, float)
    row, column = np.divmod(cell, len(x) - 1)
    u, v, _ = kernels.bilinear.saddle(
        values[row, column], values[row, column + 1], values[row + 1, column], values[row + 1, column + 1]
    )
    px = x[column] + np.clip(u, 0, 1) * np.diff(x)[column]
    py = y[row] + np.clip(v, 0, 1) * np.diff(y)[row]
    return np.column_stack([px, py, np.zeros(len(px))])


def too_curved(model: Model, points: Floats, at_points: Accuracy, slope: Floats, length: Floats) -> list[Flag]:
    """A flag on the points where error / slope is no longer the displacement: kappa above 0.4."""
    if not len(points):
        return []
    error = at_points.total(1.0, "value")
    values = np.asarray(model.samples.values, float)
    weights = model.law.weights(model.grid, points)
    bending = np.max(
        [
            np.abs(np.nan_to_num(weights.apply(second_derivative(model.grid, values, axis).ravel()))) * length[axis] ** 2
            for axis in (0, 1)
        ],
        axis=0,
    )
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        kappa = np.where(error > 0, error * bending / slope**2, 0.0)
    bad = np.flatnonzero(~(kappa <= VALID))
    if not len(bad):
        return []
    words = f"the slope is too small for the error at {len(bad)} of {len(points)} points: a line may lie farther, or not exist"
    return [Flag("kappa", words, "point", bad, np.nan_to_num(kappa[bad], nan=np.inf))]
