"""Slope and aspect of a surface z = F(x, y)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import eye_array

from modules.api import Annotated, Interleave, Literal, Missing, Operator, Range, Samples, Source, Sum, along, modeller, uniform
from modules.data.grid import Axial
from modules.data.operators import Floats
from modules.modellers._derivative import RULE
from modules.modellers._linear import axial, carried, dimension, estimated, lattice_of
from modules.modellers._pointwise import pointwise
from modules.modellers._weights import binomial, slope_bias
from modules.modellers._weights import slope as derivative

HORN = f"{RULE}; and what 1 2 1 across takes from the slopes as they are [horn-across/1]"
WHAT = "Differences instead of derivatives"


@modeller(
    "Slope and aspect",
    version=2,
    output="samples",
    aliases=("steepness", "hillside", "exposition", "terrain", "gradient angle"),
)
def slope(
    samples: Samples,
    *,
    measure: Literal["slope", "grade", "aspect"] = "slope",
    method: Literal["differences", "horn"] = "differences",
    scale: Annotated[float, Range(0)] = 1.0,
) -> Samples:
    """How steep a surface is, or which way it falls.

    Parameters
    ----------
    samples : heights on a map of a regular or rectilinear grid
    measure : slope, in degrees from level; grade, rise over run; aspect, the bearing of the fall in degrees, clockwise from y
    method : differences of the two neighbours; or horn, which smooths them across by 1 2 1
    scale : one unit of height in units of the coordinates: 0.001 for heights in m over a map in km

    Raises
    ------
    ValueError : not a map of single numbers; a bent or unstructured grid; a scale that is not positive

    Accuracy: errors of the heights go through the differences and the derivative of the angle; what neighbours have in
    common is known, an error common to all has no part in a slope. Where errors are as large as the slope, most of all of
    the aspect of level ground, it is flagged as not linear. Adds what the differences leave out, estimated with its sign.
    Source: Horn 1981; JCGM 100:2008, 5.1.
    """
    grid = axial(samples, "a slope")
    if samples.components != 1 or len(grid.axes) != 2 or min(grid.shape) < 2:
        raise ValueError("a slope is that of heights on a map: two axes of two samples or more, one number each")
    if not (scale > 0 and np.isfinite(scale)):
        raise ValueError(f"scale = {scale} should be more than 0")
    grid.frame.length_unit(2)
    slopes = carried(samples, _both(samples, grid, derivative, method == "horn", scale), extra=(3,))
    if min(grid.shape) < 4:
        missing = Missing(WHAT, "what they leave out of a slope is not estimated for so few samples")
        slopes = replace(slopes, accuracy=slopes.accuracy.miss(missing))
    else:
        bias = _bias(samples, grid, method == "horn", scale)
        slopes = estimated(slopes, samples, bias, Source(WHAT, "model", "estimated", HORN if method == "horn" else RULE))

    def function(numbers: Floats) -> tuple[Floats, Floats]:
        return angles(numbers, measure)

    name = f"{measure} of {samples.name}" if samples.name else measure
    return pointwise(slopes, function, unit="" if measure == "grade" else "degree", name=name)


def _both(samples: Samples, grid: Axial, matrix: Callable[[Floats], Any], smoothed: bool, scale: float) -> Operator:
    """Something of each axis, and 0 along z; smoothed across or not."""
    lattice, parts = lattice_of(samples), list[Operator]()
    for axis in (0, 1):
        step: Operator = along(lattice, dimension(grid, axis), scale * matrix(grid.axes[axis]))
        if smoothed:
            other = 1 - axis
            step = along(lattice, dimension(grid, other), binomial(grid.axes[other])).after(step)
        parts.append(step)
    return Interleave((parts[0], parts[1], uniform(lattice, 0.0)))


def _bias(samples: Samples, grid: Axial, smoothed: bool, scale: float) -> Operator:
    """What differences leave out along each axis, and what smoothing across takes away."""
    lattice, parts = lattice_of(samples), list[Operator]()
    for axis in (0, 1):
        x, across = grid.axes[axis], grid.axes[1 - axis]
        third = slope_bias(x)
        assert third is not None, "four samples or more have a third derivative"
        step: Operator = along(lattice, dimension(grid, axis), scale * third)
        if smoothed:
            mixed = binomial(across)
            taken = mixed - eye_array(len(across), format="csr")
            lost = along(lattice, dimension(grid, 1 - axis), taken).after(
                along(lattice, dimension(grid, axis), scale * derivative(x))
            )
            step = Sum((along(lattice, dimension(grid, 1 - axis), mixed).after(step), lost))
        parts.append(step)
    return Interleave((parts[0], parts[1], uniform(lattice, 0.0)))


def angles(numbers: Floats, measure: str) -> tuple[Floats, Floats]:
    """(n, 3) gradients -> (n,) slope, grade or aspect, and (n, 3) derivatives; NaN where level ground has none."""
    p, q = numbers[:, 0], numbers[:, 1]
    steep = np.hypot(p, q)
    slopes = np.zeros(numbers.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        if measure == "aspect":
            value = np.degrees(np.arctan2(-p, -q)) % 360
            slopes[:, 0], slopes[:, 1] = np.degrees(q / steep**2), np.degrees(-p / steep**2)
            return np.where(steep > 0, value, np.nan), slopes
        slopes[:, 0], slopes[:, 1] = p / steep, q / steep
        if measure == "grade":
            return steep, slopes
        return np.degrees(np.arctan(steep)), np.degrees(slopes / (1 + steep**2)[:, None])
