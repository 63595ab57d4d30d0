"""Smoothing that keeps straight lines: [1 2 1], or a Gaussian."""

from __future__ import annotations

import math
from typing import Any

from modules.api import Annotated, Literal, Progress, Range, Samples, modeller
from modules.data.operators import Floats
from modules.modellers._linear import axial, chosen
from modules.modellers._smoothing import smoothed
from modules.modellers._weights import binomial, gaussian


@modeller("Smooth", output="samples", aliases=("blur", "gaussian", "binomial", "low pass", "noise reduction"))
def smooth(
    samples: Samples,
    progress: Progress,
    *,
    kernel: Literal["binomial", "gaussian"] = "binomial",
    passes: Annotated[int, Range(0, 20)] = 1,
    width: Annotated[float | None, Range(0)] = None,
    axis: Literal["all", "x", "y", "z"] = "all",
) -> Samples:
    """Each sample becomes a weighted mean of itself and its neighbours along each axis.

    A plane stays a plane, on unevenly spaced axes and at borders too. A hole makes its neighbours holes.

    Parameters
    ----------
    samples : of a regular or rectilinear grid; vectors and tensors by component
    kernel : binomial, the weights 1 2 1; or gaussian, a line fitted with Gaussian weights out to four deviations
    passes : how often
    width : standard deviation of the Gaussian in the unit of the coordinates; automatic takes one mean step of each axis
    axis : along which it works

    Raises
    ------
    ValueError : a bent or unstructured grid, an axis that the data does not have, a width that is not positive

    Accuracy: errors of the samples go through the same weights, so what neighbours have in common afterwards is known;
    adds what smoothing takes from the truth, estimated with its sign from the field itself, and says where noise hides it.
    Source: binomial filter; Fan and Gijbels 1996, 2.3 (local linear fit); bias by twicing, Tukey 1977.
    """
    if passes < 0:
        raise ValueError(f"passes = {passes} should be 0 or more")
    if width is not None and not (width > 0 and math.isfinite(width)):
        raise ValueError(f"width = {width} should be more than 0, or automatic")
    grid = axial(samples, "smoothing")

    def matrix(x: Floats) -> Any:
        if kernel == "binomial" or len(x) < 2:
            return binomial(x)
        return gaussian(x, (x[-1] - x[0]) / (len(x) - 1) if width is None else width)

    return smoothed(samples, grid, chosen(grid, axis), matrix, "Smoothing", progress, passes)
