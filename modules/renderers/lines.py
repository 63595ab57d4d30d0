"""Lines as lines."""

from __future__ import annotations

import numpy as np

from modules.api import (
    Annotated,
    Choice,
    ColourMap,
    Geometry,
    Layer,
    LineLook,
    Literal,
    Range,
    renderer,
)
from modules.renderers import _colours, _titles


@renderer("Lines", aliases=("polylines", "contour lines", "streamlines"), output="layer")
def lines(
    geometry: Geometry,
    colours: ColourMap | None = None,
    *,
    width: Annotated[float, Range(0.25, 6)] = 1.2,
    colour: str = "line",
    colour_by: Annotated[str, Choice(of="geometry.names")] = "",
    map: Literal["values", "errors", "greys"] = "values",
    scale: Literal["linear", "logarithmic"] = "linear",
    low: float | None = None,
    high: float | None = None,
    major: Annotated[int, Range(0, 10)] = 0,
    dashed: bool = False,
    opacity: Annotated[float, Range(0, 1)] = 1.0,
    title: str = "",
) -> Layer:
    """The lines of a geometry, drawn as they are.

    Parameters
    ----------
    colours : colour map to use instead of `map`
    width : in pixels at 100 %
    colour : a role ("line", "text 2", "dust" ...) or "#rrggbb"; used where no values give the colour
    colour_by : values that give the colour
    map : values (cividis), errors (clay to ember) or greys (dark is little)
    scale : of the colours
    low, high : ends of the colours; automatic: those of the values
    major : every so-many-th level is drawn thicker; 0 for none
    dashed : broken lines, for what is construction and not data
    opacity : 1 covers what lies below, 0 shows nothing of the layer
    title : for the legend; automatic: what the lines are, such as "Contour lines every 100 m"

    Raises
    ------
    ValueError : the geometry has no lines, or no such values

    Accuracy: passed on as it is; errors that the geometry shows are named in the legend.
    """
    if not len(geometry.lines) and len(geometry.points):
        raise ValueError("the geometry has no lines: use 'points' or 'surface'")
    chosen = colours or _colours.colour_map(map, scale=scale)
    look = LineLook(
        colour=colour,
        colouring=_colours.by_field(geometry, colour_by, chosen, low, high),
        width=width,
        opacity=opacity,
        dashed=dashed,
        major=major if "level" in geometry.values and np.unique(geometry.values["level"].values).size > 1 else 0,
    )
    words = title or _titles.of_lines(geometry)
    return Layer(shape=geometry, look=look, title=words, shows=geometry.shows, accuracy=geometry.accuracy)
