"""A variogram fitted to scattered data: how much two values differ, by the distance of their points."""

from __future__ import annotations

import numpy as np

from modules.data.operators import Floats
from modules.modellers._scattered import Variogram

MOST_POINTS = 1500
"""Of which all pairs are looked at; of more points so many are drawn, always the same."""
BINS = 15
SHAPES = ("spherical", "exponential", "gaussian")


def fitted(at: Floats, values: Floats, noise: Floats, shape: str) -> Variogram:
    """The variogram that comes nearest to half the mean squared differences of pairs, up to half the largest distance.

    Its numbers are rounded to two digits: they are not known better, and the weights of kriging then stay the same under
    small changes of the data.

    Parameters
    ----------
    values : (n, components); components share one variogram
    noise : (n,) variance of the data's own random errors, which is taken off
    shape : one of SHAPES, or "automatic" for the one that fits best

    Raises
    ------
    ValueError : the values do not differ

    Source: Cressie 1985, weights by numbers of pairs; Matheron 1963.
    """
    distance, half, pairs = empirical(at, values, noise)
    if half.max() <= 0:
        raise ValueError("all values are the same, or differ by no more than their stated errors: there is nothing to estimate")
    tried = [_fit(distance, half, pairs, one) for one in (SHAPES if shape == "automatic" else (shape,))]
    return min(tried, key=lambda each: each[0])[1]


def empirical(at: Floats, values: Floats, noise: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean distance, half the mean squared difference less the noise, and number of pairs, of each class of distance."""
    if len(at) > MOST_POINTS:
        kept = np.sort(np.random.default_rng(0).choice(len(at), MOST_POINTS, replace=False))
        at, values, noise = at[kept], values[kept], noise[kept]
    one, other = np.triu_indices(len(at), 1)
    apart = np.linalg.norm(at[one] - at[other], axis=1)
    near = apart <= 0.5 * apart.max()
    one, other, apart = one[near], other[near], apart[near]
    half = np.mean((values[one] - values[other]) ** 2, axis=1) / 2 - (noise[one] + noise[other]) / 2
    edges = np.quantile(apart, np.linspace(0, 1, BINS + 1))
    group = np.clip(np.searchsorted(edges, apart, side="right") - 1, 0, BINS - 1)
    pairs = np.bincount(group, minlength=BINS).astype(float)
    held = pairs > 0
    mean = [np.bincount(group, weights=w, minlength=BINS)[held] / pairs[held] for w in (apart, half)]
    return mean[0], np.maximum(mean[1], 0.0), pairs[held]


def _fit(distance: Floats, half: Floats, pairs: Floats, shape: str) -> tuple[float, Variogram]:
    """How far a shape lies from the classes of distance, and its numbers."""
    from scipy.optimize import nnls

    weight = np.sqrt(pairs)
    best = (np.inf, Variogram(shape, 1.0, 1.0, 0.0))
    for reach in np.geomspace(distance[0] / 2, 4 * distance[-1], 80):
        reach = _two_digits(float(reach))
        rise = 1 - Variogram(shape, reach, 1.0, 0.0).shared(distance)
        (sill, nugget), off = nnls(np.column_stack([rise, np.ones(len(rise))]) * weight[:, None], half * weight)
        if off < best[0] * (1 - 1e-6) and sill > 0:
            best = (float(off), Variogram(shape, reach, _two_digits(float(sill)), _two_digits(float(nugget))))
    if not np.isfinite(best[0]):
        raise ValueError("neighbouring values have nothing in common here: no law between the points can be told from noise")
    return best


def _two_digits(number: float) -> float:
    return float(f"{number:.1e}")
