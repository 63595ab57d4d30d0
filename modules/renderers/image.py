"""Samples of the plane as an image: by a colour map, as shaded relief, or both."""

from __future__ import annotations

import numpy as np

from modules.api import (
    Annotated,
    Colouring,
    ColourMap,
    ImageLook,
    Layer,
    Literal,
    Range,
    Rectilinear,
    Regular,
    Samples,
    renderer,
)
from modules.renderers import _colours, _titles

STEEPEST = 0.85
"""Automatic light makes 95 % of the slopes at most this steep."""


@renderer("Image", aliases=("heat map", "pseudocolour", "hillshade", "shaded relief"), output="layer")
def image(
    samples: Samples,
    colours: ColourMap | None = None,
    *,
    show: Literal["values", "relief", "both"] = "values",
    map: Literal["values", "errors", "greys"] = "values",
    scale: Literal["linear", "logarithmic"] = "linear",
    steps: Annotated[int, Range(0, 20)] = 0,
    low: float | None = None,
    high: float | None = None,
    light: Annotated[float | None, Range(0.1, 20, log=True)] = None,
    interpolate: bool = True,
    opacity: Annotated[float, Range(0, 1)] = 1.0,
    title: str = "",
) -> Layer:
    """Samples of the plane as an image, by a colour map, as relief lit from the north-west, or both.

    Parameters
    ----------
    colours : colour map to use instead of `map`
    show : values (colours), relief (grey shading of the slopes), or both
    map : values (cividis), errors (clay to ember) or greys (dark is little)
    scale : of the colours
    steps : number of discrete colours; 0 for a continuous map
    low, high : ends of the colours; automatic: those of the values
    light : slopes are taken so many times as steep for the light; automatic: so that most are below 40 degrees. The
        factor stands in the legend
    interpolate : between samples; off shows each sample as a box of its own
    opacity : 1 covers what lies below, 0 shows nothing of the layer
    title : for the legend; automatic: name of the values, and the light

    Raises
    ------
    ValueError : the samples are not scalar, or not on a regular or rectilinear grid of the plane

    Accuracy: passed on as it is. Shading is of the samples' differences, times the factor of the light.
    """
    _check(samples)
    chosen = colours or _colours.colour_map(map, scale=scale, steps=steps)
    values = np.asarray(samples.values, float)
    colouring = None
    if show != "relief":
        span = _colours.ends(values, chosen, low, high)
        colouring = Colouring(by=samples.name, map=chosen, range=span, title=samples.name or "value", unit=samples.unit)
    factor = 1.0
    if show != "values":
        factor = automatic_light(samples) if light is None else light
        if factor <= 0:
            raise ValueError(f"slopes {factor:g} times as steep have no light: give a number above zero")
    look = ImageLook(
        colouring=colouring, relief=show != "values", exaggeration=factor, opacity=opacity, interpolate=interpolate
    )
    words = title or _titles.of_image(samples, look)
    return Layer(shape=samples, look=look, title=words, accuracy=samples.accuracy)


def _check(samples: Samples) -> None:
    grid = samples.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 2:
        got = f"{grid.dimensions}-dimensional {grid.kind}"
        raise ValueError(f"an image needs samples on a grid of the plane, got a {got} one: take a slice")
    if samples.components != 1:
        raise ValueError(f"an image needs one value a sample, got {samples.components}: choose a component or the length")
    if min(grid.shape) < 2:
        raise ValueError(f"an image needs at least 2 samples along each axis, got {grid.shape}")


def automatic_light(samples: Samples) -> float:
    """A round factor that makes 95 % of the slopes at most 40 degrees steep."""
    assert isinstance(samples.grid, Regular | Rectilinear)
    x, y = samples.grid.axes
    across, up = np.gradient(np.asarray(samples.values, float), y, x)[::-1]
    slope = np.hypot(across, up)
    slope = slope[np.isfinite(slope)]
    steep = float(np.quantile(slope, 0.95)) if slope.size else 0.0
    return _titles.rounded(STEEPEST / steep) if steep > 0 else 1.0
