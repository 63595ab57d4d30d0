"""Samples become a model: a law between them, with an estimate of its own error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from modules.api import Curvilinear, Flag, Literal, Model, Rectilinear, Regular, Samples, along, modeller
from modules.data.grid import lattice_of
from modules.data.operators import Floats, fixed
from modules.modellers._linear import dimension, noise_in
from modules.modellers._linear import lattice_of as components
from modules.modellers._weights import second_derivative, slope_bias

SURE = 1.5
"""Of what bounds and two deviations may do to one difference: the largest of a cell's differences is rarely more."""


@modeller("Interpolate", version=2, aliases=("model", "bilinear", "trilinear", "nearest", "cubic"), output="model")
def interpolate(samples: Samples, *, law: Literal["linear", "nearest", "cubic"] = "linear") -> Model:
    """A value anywhere between the samples, by a law.

    Linear is bilinear on a rectangle and trilinear in a box: the law whose contours the thesis draws exactly.

    Parameters
    ----------
    law : linear; nearest (the value of the closest sample, with a jump half way); or cubic (smooth across the cells)

    Accuracy: errors of the samples go through the law's weights; the law adds its own error, estimated from second
        differences, which is zero at the samples. Where these are within the noise it is flagged as not resolvable.
    Source: Lopes 1999, 2.3.1 (accuracy model); error of piecewise linear interpolation, h^2 f''/8.
    """
    model = Model.between(samples, law)
    flag = _not_resolvable(model)
    if flag is None:
        return model
    return Model(samples=samples, law=model.law, accuracy=model.accuracy.flag(flag))


def _not_resolvable(model: Model) -> Flag | None:
    """Cells whose second differences are within what noise alone would give."""
    own, samples = model.own, model.samples
    if own is None:
        return None
    grid = lattice_of(samples.grid) if isinstance(samples.grid, Curvilinear) else samples.grid
    if not isinstance(grid, Regular | Rectilinear):
        return None
    limit = 0.0
    for axis, x in enumerate(grid.axes):
        told = TELLS[model.law.name](x)
        if told is not None:
            limit += SURE * noise_in(samples, along(components(samples), dimension(grid, axis), told), samples.components)
    below = np.flatnonzero(own.size() <= limit) if limit > 0 else np.zeros(0, np.int64)
    if not len(below):
        return None
    words = f"the interpolation error cannot be told from the noise in {len(below)} of {own.count} cells"
    return Flag("not resolvable", words, "cell", below)


def _bend(x: Floats) -> Any | None:
    """What linear interpolation between samples may be wrong by: an eighth of the second difference over the wider cell."""
    second = second_derivative(x)
    return None if second is None else csr_array(diags_array(_wider(x) ** 2 / 8) @ second)


def _step(x: Floats) -> Any | None:
    """Half the difference of two samples."""
    n = len(x)
    return None if n < 2 else csr_array(fixed(np.arange(n - 1)[:, None] + np.arange(2), np.tile([-0.5, 0.5], (n - 1, 1)), n))


def _slopes(x: Floats) -> Any | None:
    """What the cubic may be wrong by: 4/27 of the cell times the error of the slope at each end."""
    bias = slope_bias(x)
    return None if bias is None else csr_array(diags_array(8 / 27 * _wider(x)) @ bias)


def _wider(x: Floats) -> Floats:
    h = np.diff(x)
    return np.asarray(np.maximum(np.append(h, h[-1]), np.append(h[0], h)))


TELLS: Mapping[str, Callable[[Floats], Any | None]] = {"linear": _bend, "nearest": _step, "cubic": _slopes}
"""Law -> a small matrix along an axis that gives the size of its error there; None for too few samples."""
