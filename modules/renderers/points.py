"""Points as dots: seeds, sites, and the dust that shows an error."""

from __future__ import annotations

from modules.api import Annotated, Choice, ColourMap, Geometry, Layer, Literal, PointLook, Range, renderer
from modules.renderers import _colours, _titles


@renderer("Points", aliases=("dots", "dust", "scatter", "seeds"), output="layer")
def points(
    geometry: Geometry,
    colours: ColourMap | None = None,
    *,
    size: Annotated[float, Range(0.5, 12)] = 2.0,
    colour: str = "",
    colour_by: Annotated[str, Choice(of="geometry.names")] = "",
    map: Literal["values", "errors", "greys"] = "values",
    scale: Literal["linear", "logarithmic"] = "linear",
    low: float | None = None,
    high: float | None = None,
    opacity: Annotated[float, Range(0, 1)] = 1.0,
    title: str = "",
) -> Layer:
    """The vertices of a geometry as dots; all its points if it names none.

    Parameters
    ----------
    colours : colour map to use instead of `map`
    size : in pixels at 100 %
    colour : a role or "#rrggbb"; automatic: "dust", the colour of errors, if the points show one, else "line"
    colour_by : values that give the colour
    map : values (cividis), errors (clay to ember) or greys (dark is little)
    scale : of the colours
    low, high : ends of the colours; automatic: those of the values
    opacity : 1 covers what lies below, 0 shows nothing of the layer
    title : for the legend; automatic: nothing for points that show an error, since the error's own words stand there

    Raises
    ------
    ValueError : no such values

    Accuracy: passed on as it is; errors that the geometry shows are named in the legend.
    """
    chosen = colours or _colours.colour_map(map, scale=scale)
    look = PointLook(
        colour=colour or ("dust" if geometry.shows else "line"),
        colouring=_colours.by_field(geometry, colour_by, chosen, low, high),
        size=size,
        opacity=opacity,
    )
    words = title or _titles.of_points(geometry)
    return Layer(shape=geometry, look=look, title=words, shows=geometry.shows, accuracy=geometry.accuracy)
