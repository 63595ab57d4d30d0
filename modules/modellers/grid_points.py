"""Scattered points brought to a regular grid: nearest, linear in triangles, thin plate splines, or kriging."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from modules.api import Annotated, Flag, Literal, Progress, Range, Regular, Samples, Source, Term, modeller, regular
from modules.data import correlation
from modules.data.operators import Floats
from modules.modellers._scattered import (
    Points,
    Variogram,
    Weighted,
    in_hull,
    kriging,
    linear,
    nearest,
    operator_of,
    points_of,
    spline,
)
from modules.modellers._variogram import fitted

Method = Literal["linear", "nearest", "spline", "kriging"]
Shape = Literal["automatic", "spherical", "exponential", "gaussian"]

FOLDS = 10
FEWEST, MOST = {2: 48, 3: 24}, {2: 200, 3: 64}
"""Of samples along the longest axis, by the number of axes, where they are as many as twice the points along it."""


@modeller(
    "Grid points",
    output="samples",
    aliases=("scattered data", "kriging", "thin plate spline", "rbf", "radial basis", "delaunay", "gridding"),
)
def grid_points(
    points: Samples,
    progress: Progress,
    *,
    method: Method = "kriging",
    samples: Annotated[tuple[int, ...] | None, Range(2, 1024)] = None,
    variogram: Shape = "automatic",
    neighbours: Annotated[int, Range(4, 64, strict=True)] = 24,
    extrapolate: bool = False,
) -> Samples:
    """Values on a regular grid around scattered points, with how wrong they may be between them.

    Parameters
    ----------
    points : data with positions, in the plane or in space; what has no value is left out, samples at one place are averaged
    method : kriging, whose error is estimated place by place; a thin plate spline through all points; linear in the triangles
        of Delaunay; or nearest
    samples : numbers along x, y[, z]; one number serves the longest axis; automatic
        takes twice as many along each axis as there are points
    variogram : of kriging; how fast points cease to have anything in common
    neighbours : of each sample, that kriging and splines use
    extrapolate : give values outside of the points' convex hull, too; linear never does

    Raises
    ------
    ValueError : too few points, all on one line, values that are all the same (kriging), a grid beyond memory

    Accuracy: errors of the data go through the weights; kriging weighs by the random errors that the data state. Between
    points kriging adds the deviation of the field about its estimate, which a variogram fitted to the same data predicts;
    the other methods add the root mean square of what points left out in tens would have been off by. Both are taken to
    be alike within the distance of the points.
    Source: Cressie 1993, 3.2 (ordinary kriging); Duchon 1977 (thin plate splines); Stone 1974 (cross-validation).
    """
    found = points_of(points)
    grid = _grid(points, found, samples)
    places = grid.points()[:, : found.at.shape[1]]
    law = fitted(found.at, found.values, found.noise, variogram) if method == "kriging" else None
    progress(0.1)
    weighted = weights(found, places, method, neighbours, law)
    if not extrapolate and method != "linear":
        inside = in_hull(found.at, places)
        weighted = Weighted(weighted.index, np.where(inside[:, None], weighted.weight, 0.0), inside, weighted.variance)
    progress(0.6)
    operator = operator_of(weighted, found)
    c = points.components
    values = operator.apply(np.nan_to_num(points.values.ravel().astype(float)))
    values[np.repeat(~weighted.inside, c)] = np.nan
    extra = points.values.shape[len(points.grid.shape) :]
    accuracy = points.accuracy.push(operator).add(_own(grid, weighted, found, law, method, neighbours, points.unit))
    if found.twice:
        accuracy = accuracy.flag(Flag("averaged", f"{found.twice} samples lay where others did, and were averaged with them"))
    progress(1.0)
    return replace(points, grid=grid, values=values.reshape(*grid.shape, *extra), accuracy=accuracy)


def weights(
    found: Points, places: Floats, method: str, neighbours: int, law: Variogram | None, leave: bool = False
) -> Weighted:
    """Weights of the points at some places; `leave` leaves out the point that lies there (not of linear and nearest)."""
    if method == "nearest":
        return nearest(found.at, places)
    if method == "linear":
        return linear(found.at, places)
    if law is None:
        return spline(found.at, places, neighbours, leave)
    return kriging(found.at, places, neighbours, law, found.noise, leave)


def left_out(found: Points, method: str, neighbours: int, law: Variogram | None) -> tuple[Floats, Floats]:
    """Values less what the other points say of them, (n, components); and its variance that is known beforehand, (n,).

    That is the noise of the data, and what kriging predicts of the field. Each point is left out by itself, or every tenth
    at a time for nearest and linear. NaN where the others say nothing.
    """
    n = len(found.at)
    guess, known = np.full(found.values.shape, np.nan), found.noise.copy()
    if method in ("spline", "kriging"):
        weighted = weights(found, found.at, method, neighbours, law, leave=True)
        guess = np.einsum("mk,mkc->mc", weighted.weight, found.values[weighted.index])
        known += np.sum(weighted.weight**2 * found.noise[weighted.index], axis=1)
        return found.values - guess, known + (weighted.variance if law else 0.0)
    order = np.random.default_rng(0).permutation(n)
    for fold in range(min(FOLDS, n)):
        out = np.zeros(n, bool)
        out[order[fold::FOLDS]] = True
        if np.linalg.matrix_rank(found.at[~out] - found.at[~out][0]) < found.at.shape[1]:
            continue
        weighted = weights(replace(found, at=found.at[~out]), found.at[out], method, neighbours, law)
        said = np.einsum("mk,mkc->mc", weighted.weight, found.values[~out][weighted.index])
        guess[out] = np.where(weighted.inside[:, None], said, np.nan)
        known[out] += np.sum(weighted.weight**2 * found.noise[~out][weighted.index], axis=1)
    return found.values - guess, known


def _own(
    grid: Regular, weighted: Weighted, found: Points, law: Variogram | None, method: str, neighbours: int, unit: str
) -> Term:
    """The error of the method between the points."""
    c = found.values.shape[1]
    residual, known = left_out(found, method, neighbours, law)
    if law is not None:
        about = np.sqrt(np.nanmean(residual**2 / known[:, None]))
        sizes = np.repeat(np.sqrt(weighted.variance), c)
        rule = (
            f"ordinary kriging of {neighbours} neighbours, {law.shape} variogram: range {law.reach:g}, sill {law.sill:g}, "
            f"nugget {law.nugget:g}; points left out were off by {about:.2f} of what it predicts (kriging-variance/1)"
        )
        name = "Kriging"
    else:
        sizes = np.full(len(weighted.inside) * c, _beyond_noise(residual, known))
        rule = f"root mean square by which left-out points are off, less their noise; {method} (cross-validation/1)"
        name = "Gridding"
    sizes = np.where(np.repeat(weighted.inside, c), sizes, 0.0)
    alike = "length" if len(set(grid.frame.units[: found.at.shape[1]])) == 1 else "independent"
    length = spacing_of(found.at)
    value, operator = correlation.carried(grid, c, sizes, alike, length)
    rule += "; " + correlation.words(grid, alike, length)
    return Term(Source(name, "model", "estimated", rule), "linear", "value", unit, value, operator, components=c)


def _beyond_noise(residual: Floats, known: Floats) -> float:
    """Root mean square of what was left out, less what noise alone makes; never less than the chance in that difference."""
    there = np.isfinite(residual)
    if not there.any():
        return math.inf
    total = float(np.mean(residual[there] ** 2))
    noise = float(np.mean(np.broadcast_to(known[:, None], residual.shape)[there]))
    return math.sqrt(max(total - noise, total * math.sqrt(2 / there.sum())))


def spacing_of(at: Floats) -> float:
    """Median distance of a point to its nearest."""
    from scipy.spatial import cKDTree

    return float(np.median(cKDTree(at).query(at, k=2)[0][:, 1]))


def _grid(points: Samples, found: Points, samples: tuple[int, ...] | None) -> Regular:
    low, high = found.at.min(axis=0), found.at.max(axis=0)
    d = len(low)
    wide = high - low
    if samples is not None and len(samples) not in (1, d):
        raise ValueError(f"samples should be one number, or {d}, as the points have {d} coordinates")
    if samples is not None and min(samples) < 2:
        raise ValueError(f"samples {samples} should be 2 or more along each axis")
    if samples is not None and len(samples) == d:
        counts = samples
    else:
        even = float(np.prod(wide / wide.max())) ** (1 / d)
        automatic = int(np.clip(round(2 * len(found.at) ** (1 / d) / even), FEWEST[d], MOST[d]))
        longest = samples[0] if samples is not None else automatic
        counts = tuple(max(2, round((longest - 1) * float(w / wide.max())) + 1) for w in wide)
    if math.prod(counts) > 50_000_000:
        raise ValueError(f"{' x '.join(map(str, counts))} samples are too many here: ask for fewer")
    spacing = [float(w) / (k - 1) for w, k in zip(wide, counts, strict=True)]
    return regular(tuple(reversed(counts)), spacing, [float(v) for v in low], points.grid.frame)
