"""Axes of charts: a logarithmic one is drawn at the exponents of ten of its numbers, and labelled with the numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from app.draw import numbers
from modules.data.scene import ChartLook, Layer

Logs = tuple[bool, bool]
"""Whether the axis across and the one upwards are logarithmic."""
PLAIN: Logs = (False, False)
NARROW = 1.3
"""Below so many decades the places between powers of ten have numbers too."""


def logs_of(layers: Iterable[Layer]) -> Logs:
    """The axes that the charts of a view share; plain ones where there is no chart."""
    for layer in layers:
        if isinstance(layer.look, ChartLook):
            return logs(layer.look)
    return PLAIN


def logs(look: ChartLook) -> Logs:
    """The axes of one chart."""
    return look.x_scale == "logarithmic", look.y_scale == "logarithmic"


def drawn(values: ArrayLike, log: bool) -> NDArray[np.float64]:
    """Numbers as they lie along an axis; NaN where a logarithmic one does not reach."""
    array = np.asarray(values, float)
    if not log:
        return array
    found: NDArray[np.float64] = np.log10(array, out=np.full(array.shape, np.nan), where=array > 0)
    return found


def ticks(low: float, high: float, wanted: int) -> tuple[list[float], list[str]]:
    """Places of a logarithmic axis from 10**low to 10**high, and their words; the fine ticks between decades have none."""
    powers = range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)
    span = high - low
    if len(powers) < 2 and span < 0.3:
        values = [v for v in numbers.ticks(10.0**low, 10.0**high, wanted) if v > 0]
        return [math.log10(v) for v in values], numbers.labels(values)
    stride = max(1, math.ceil(span / max(1, wanted)))
    told = {1, 2, 5} if span < NARROW else {1}
    at, words = [], []
    for power in range(math.floor(low), math.floor(high) + 1):
        for m in range(1, 10) if stride == 1 else (1,):
            place = power + math.log10(m)
            if low - 1e-9 <= place <= high + 1e-9:
                at.append(place)
                words.append(_word(m, power, powers) if m in told and power % stride == 0 else "")
    return at, words


def _word(m: int, power: int, powers: range) -> str:
    """One, two or five times a power of ten; the powers alike all along the axis."""
    if m == 1 and powers and (powers[0] < -3 or powers[-1] > 4):
        return numbers.power(power)
    return numbers.significant(m * 10.0**power, 1 if power < 0 else 2)
