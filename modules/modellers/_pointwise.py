"""A function of each sample's own numbers, linearised: its derivatives bring the errors on, and a flag says where not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from modules.api import Flag, Gather, Samples
from modules.data.operators import Floats, Ints
from modules.modellers._linear import GLANCE, incoming

Pointwise = Callable[[Floats], tuple[Floats, Floats]]
"""(n, c) numbers of n samples -> (n,) values and (n, c) derivatives."""

BLOCK = 1 << 16
BENT = 0.3
"""A rule of first order is given up where it differs by so much of what it says, for two deviations."""


def pointwise(samples: Samples, function: Pointwise, *, unit: str | None = None, name: str | None = None) -> Samples:
    """The function of each sample, with the errors of the samples through its derivatives.

    Parameters
    ----------
    unit, name : of the result; those of the samples by default
    """
    c, n = samples.components, samples.grid.count
    numbers = samples.values.astype(np.float64, copy=False).reshape(n, c)
    values, slopes = np.empty(n), np.empty((n, c))
    wrong = np.zeros(n, bool)
    reach = reach_of(samples)
    for first in range(0, n, BLOCK):
        part = slice(first, first + BLOCK)
        values[part], slopes[part] = function(numbers[part])
        if reach.any():
            wrong[part] = bent(function, numbers[part], values[part], slopes[part], reach)
    known = np.asarray(np.isfinite(slopes).all(axis=1))
    lost = ~known & np.isfinite(numbers).all(axis=1)
    index: Ints = np.arange(n * c, dtype=np.int64).reshape(n, c)
    if n * c < 2**31:
        index = index.astype(np.int32)
    operator = Gather(index, np.where(known[:, None], slopes, 0.0), n * c)
    accuracy = incoming(samples).push(operator, unit=unit, components=1)
    found = np.flatnonzero(lost | wrong)
    if len(found):
        words = f"the errors change the outcome otherwise than by its slope at {len(found)} of {n} samples"
        accuracy = accuracy.flag(Flag("not linear", words, "point", found))
    return replace(
        samples,
        values=values.reshape(samples.grid.shape),
        unit=samples.unit if unit is None else unit,
        name=samples.name if name is None else name,
        accuracy=accuracy,
    )


def reach_of(samples: Samples, *, bounded: bool = True) -> Floats:
    """(c,) how far errors may move each number: bounds (or without), and two deviations; the largest of some samples."""
    count, c = samples.grid.count, samples.components
    looked = np.unique(np.random.default_rng(0).integers(0, count, GLANCE)) if count > GLANCE else np.arange(count)
    bounds, variance = np.zeros(c), np.zeros(c)
    for term in incoming(samples).select("value", "point"):
        size = np.abs(term.error(looked)).reshape(-1, c).max(axis=0, initial=0.0)
        if term.kind in ("linear", "members"):
            variance += size**2
        elif bounded:
            bounds += size
    return np.asarray(bounds + 2 * np.sqrt(variance))


def bent(function: Pointwise, numbers: Floats, values: Floats, slopes: Floats, reach: Floats) -> Any:
    """Where the function over the reach of the errors is not the line that its slope says."""
    away = np.sign(np.nan_to_num(slopes)) * reach
    away = np.where(away == 0, reach, away)
    said = (np.abs(np.nan_to_num(slopes)) * reach).sum(axis=1)
    with np.errstate(invalid="ignore"):
        up, down = function(numbers + away)[0] - values, values - function(numbers - away)[0]
        off = np.maximum(np.abs(up - said), np.abs(down - said))
        noise = 64 * np.finfo(float).eps * np.abs(values)
        return np.asarray((off > BENT * said + noise) | (np.isnan(off) & np.isfinite(values)))
