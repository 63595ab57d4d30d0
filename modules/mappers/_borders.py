"""The borders of filled bands: how steep the field is there, how far the chords are from it, how areas depend on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules import kernels
from modules.data.accuracy import Accuracy, Flag
from modules.data.laws import Linear, second_derivative
from modules.mappers._plane import Rectangle

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VALID = 0.4
"""Largest kappa = error |F_nn| / slope^2 for which 95 % bands of a first-order position cover 94 to 98 %."""
FLATTEST = 1e-150
"""A smaller slope counts as this one: the position is then not known to first order, and the number says so."""
LONGEST = 12.0
"""Through a saddle the area changes as e ln e, without a derivative; then arcs count as bent by this much."""
GAUSS = (0.5 - 15**0.5 / 10, 0.5, 0.5 + 15**0.5 / 10), (5 / 18, 8 / 18, 5 / 18)
"""Places on an arc, and their shares of it."""


def gradient(plane: Rectangle, points: Floats, cell: Ints) -> tuple[Floats, Floats]:
    """F_x and F_y of a cell's own bilinear field at points (n, 2) of it."""
    row, column, u, v = plane.within(points, cell)
    f00, f10, f01, f11 = plane.corners(row, column)
    along_x = ((1 - v) * (f10 - f00) + v * (f11 - f01)) / np.diff(plane.axes[0])[column]
    along_y = ((1 - u) * (f01 - f00) + u * (f11 - f10)) / np.diff(plane.axes[1])[row]
    return along_x, along_y


class Border(NamedTuple):
    """What is known at the points of the bands; both are 0 where a point is on no border.

    Attributes
    ----------
    slope : (p,) the smaller slope of the cells that meet there, per unit of length; infinite off the borders
    reach : (p,) the largest distance between the chords that end there and their arcs
    """

    slope: Floats
    reach: Floats


def border(plane: Rectangle, drawn: kernels.bands.Bands, partly: Ints) -> Border:
    """Slope and reach at the points of bands.

    Parameters
    ----------
    partly : polygons whose cell does not lie in their band as a whole
    """
    sides, cell = _sides(drawn, partly)
    length = plane.measure
    level = drawn.on[sides]
    slope, reach = np.full(len(drawn.points), np.inf), np.zeros(len(drawn.points))
    slopes = []
    for end in (0, 1):
        along_x, along_y = gradient(plane, drawn.points[sides[:, end]], cell)
        slopes.append((along_x, along_y))
        at = level[:, end] >= 0
        np.minimum.at(slope, sides[at, end], np.hypot(along_x * length[0], along_y * length[1])[at])
    arc = (level[:, 0] == level[:, 1]) & (level[:, 0] >= 0)
    step = (drawn.points[sides[:, 1]] - drawn.points[sides[:, 0]]) / length
    (_, start), (_, end_y) = slopes
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = end_y / start
        bend = np.where(ratio > 0, np.log(np.where(ratio > 0, ratio, 1.0)), kernels.arcs.TURN)
    far = np.where(arc, kernels.arcs.sagitta(step[:, 0], step[:, 1], np.nan_to_num(bend)), 0.0)
    np.maximum.at(reach, sides.ravel(), np.repeat(far, 2))
    return Border(slope, reach)


def _sides(drawn: kernels.bands.Bands, partly: Ints) -> tuple[Ints, Ints]:
    """(s, 2) sides of some polygons, and the cell of each."""
    following = np.arange(1, len(drawn.connectivity) + 1)
    following[drawn.offsets[1:] - 1] = drawn.offsets[:-1]
    owner = np.repeat(np.arange(len(drawn.band)), np.diff(drawn.offsets))
    keep = np.isin(owner, partly)
    sides = np.column_stack([drawn.connectivity, drawn.connectivity[following]])
    return sides[keep], drawn.cell[owner[keep]]


class Areas(NamedTuple):
    """How the areas of bands depend on the values along their borders: dA = weights @ dF(points).

    Attributes
    ----------
    points : (q, 3) on the contours of the levels
    weights : (bands, q) sparse
    """

    points: Floats
    weights: csr_array


def areas(plane: Rectangle, levels: Floats, check: Callable[[float], None]) -> Areas:
    """Where and how an error of the values changes the area of the bands between levels, to first order.

    dA is the integral of dF / |grad F| along the low border less that along the high one. On an arc of bend w about a
    saddle, ds / |grad F| = |w / c| dt, even in t, so Gauss's three places in t serve.
    """
    x, y = plane.axes
    points, weights, rows = [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0, np.int64)]
    for i, level in enumerate(levels):
        if not np.isfinite(level):
            continue
        lines = kernels.contour.lines(plane.values, x, y, float(level), check=check)
        start, end = _pieces(lines)
        time = _time(plane, lines.points[start], lines.points[end], lines.cell)
        for t, share in zip(*GAUSS, strict=True):
            points.append(kernels.arcs.point(lines.points[start], lines.points[end], lines.bend, t))
            weights.append(share * time)
            rows.append(np.full(len(time), i, np.int64))
    at, weight, row = np.concatenate(points), np.concatenate(weights), np.concatenate(rows)
    column = np.arange(len(at))
    n = len(levels) - 1
    low, high = row < n, row > 0
    where = (np.concatenate([row[low], row[high] - 1]), np.concatenate([column[low], column[high]]))
    matrix = csr_array((np.concatenate([weight[low], -weight[high]]), where), shape=(n, len(at)))
    return Areas(np.column_stack([at, np.zeros(len(at))]), matrix)


def _pieces(lines: kernels.contour.ContourLines) -> tuple[Ints, Ints]:
    """The points where each segment starts and ends."""
    keep = np.ones(max(0, len(lines.points) - 1), bool)
    keep[lines.offsets[1:-1] - 1] = False
    start = np.flatnonzero(keep)
    return start, start + 1


def _time(plane: Rectangle, p: Floats, q: Floats, cell: Ints) -> Floats:
    """The integral of ds / |grad F| along each arc: dx over the logarithmic mean of F_y at its ends, or dy over that of F_x."""
    start, end = gradient(plane, p, cell), gradient(plane, q, cell)
    step = np.abs(q - p)
    means = [_mean(np.abs(start[axis]), np.abs(end[axis])) for axis in (1, 0)]
    steep = (means[0] * (step[:, 0] > 0) >= means[1] * (step[:, 1] > 0)) & (step[:, 0] > 0)
    along, mean = np.where(steep, step[:, 0], step[:, 1]), np.where(steep, *means)
    return np.asarray(np.divide(along, mean, out=np.zeros(len(mean)), where=mean > 0))


def _mean(a: Floats, b: Floats) -> Floats:
    """The logarithmic mean (b - a) / ln(b / a); where one is nearly 0, as if the arc had the bend `LONGEST`."""
    most = np.maximum(a, b)
    ratio = np.maximum(np.minimum(a, b) / np.where(most > 0, most, 1.0), np.exp(-LONGEST))
    fall = 1 - ratio
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(most * np.where(fall > 1e-6, fall / -np.log1p(-fall), 1 - fall / 2))


def too_curved(plane: Rectangle, points: Floats, known: Accuracy, slope: Floats) -> list[Flag]:
    """A flag on the points of the borders where error / slope is no longer the displacement: kappa above 0.4.

    Parameters
    ----------
    points : (n, 3); known : of the values there; slope : (n,)
    """
    if not len(points):
        return []
    weights, grid = Linear().weights(plane.model.grid, points), plane.model.grid
    bent = [
        np.abs(np.nan_to_num(weights.apply(second_derivative(grid, plane.values, axis).ravel()))) * plane.measure[axis] ** 2
        for axis in (0, 1)
    ]
    error = known.total(1.0, "value")
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        kappa = np.where(error > 0, error * np.maximum(*bent) / slope**2, 0.0)
    bad = np.flatnonzero(~(kappa <= VALID))
    if not len(bad):
        return []
    words = f"the slope is too small for the error at {len(bad)} of {len(points)} points: a border may be elsewhere"
    return [Flag("kappa", words, "point", bad, np.nan_to_num(kappa[bad], nan=np.inf))]
