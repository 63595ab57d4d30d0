"""Nested shapes, drawn one over the other and translucent: dense where an error is likely, fading outwards."""

from __future__ import annotations

import math

import numpy as np

from modules.data.operators import Floats


def nested(k: float, steps: int) -> Floats:
    """The k of each shape, the widest first: equal steps of the density exp(-k^2 / 2)."""
    edge = math.exp(-(k**2) / 2)
    return np.asarray(np.sqrt(-2 * np.log(edge + (1 - edge) * np.arange(steps) / steps)))
