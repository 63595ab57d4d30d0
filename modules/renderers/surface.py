"""Polygons as a lit surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Annotated, Choice, ColourMap, Geometry, Layer, Literal, Range, SurfaceLook, renderer
from modules.renderers import _colours, _titles


@renderer("Surface", aliases=("polygons", "mesh", "terrain", "shaded"), output="layer")
def surface(
    geometry: Geometry,
    colours: ColourMap | None = None,
    *,
    colour: str = "clay",
    colour_by: Annotated[str, Choice(of="geometry.names")] = "",
    map: Literal["values", "errors", "greys"] = "values",
    scale: Literal["linear", "logarithmic"] = "linear",
    low: float | None = None,
    high: float | None = None,
    relief: bool = False,
    light: Annotated[float, Range(0.1, 20, log=True)] = 1.0,
    smooth: bool = True,
    edges: bool = False,
    opacity: Annotated[float, Range(0, 1)] = 1.0,
    title: str = "",
) -> Layer:
    """The polygons of a geometry, lit; neutral as clay unless values give the colour. What is flat has the colours of the bar.

    Parameters
    ----------
    colours : colour map to use instead of `map`
    colour : a role or "#rrggbb"; used where no values give the colour
    colour_by : values that give the colour
    map : values (cividis), errors (clay to ember) or greys (dark is little)
    scale : of the colours
    low, high : ends of the colours; automatic: those of the values, and on bands those of the bands, whose borders then lie
        between two colours
    relief : light from the north-west at 45 degrees, as on a map, however the surface is turned
    light : slopes are taken so many times as steep for the light of the relief; the shape stays as it is
    smooth : light runs on over the edges of polygons
    edges : whether the edges of the polygons are drawn
    opacity : 1 covers what lies below, 0 shows nothing of the layer
    title : for the legend; automatic: what the surface is, such as "Surface at level 0.5"

    Raises
    ------
    ValueError : the geometry has no polygons and no primitives, or no such values

    Accuracy: passed on as it is; errors that the geometry shows are named in the legend. Smooth light hides the edges
        between polygons, not their distance from the true surface.
    """
    if not len(geometry.polygons) and not geometry.primitives and len(geometry.points):
        raise ValueError("the geometry has no polygons: use 'lines' or 'points'")
    if light <= 0:
        raise ValueError(f"slopes {light:g} times as steep have no light: give a number above zero")
    chosen = colours or _colours.colour_map(map, scale=scale)
    borders = _borders(geometry)
    if len(borders) and colour_by == "level" and low is None and high is None:
        low, high = float(borders[0]), float(borders[-1])
        if np.allclose(np.diff(borders), borders[1] - borders[0], rtol=1e-6) and chosen.scale == "linear" and len(borders) > 2:
            chosen = replace(chosen, steps=len(borders) - 1)
    colouring = _colours.by_field(geometry, colour_by, chosen, low, high)
    flat = colouring is not None and not relief and _is_flat(geometry)
    look = SurfaceLook(
        colour=colour,
        colouring=colouring,
        opacity=opacity,
        edges=edges,
        smooth=geometry.values[colour_by].place == "point" if flat else smooth,
        relief=relief or flat,  # the light of a relief leaves level ground as it is: colours are those of the bar
        light=1.0 if flat else light,
    )
    words = title or _title(geometry, borders, relief, light)
    return Layer(shape=geometry, look=look, title=words, shows=geometry.shows, accuracy=geometry.accuracy)


def _borders(geometry: Geometry) -> NDArray[np.float64]:
    """The levels between which a geometry's bands lie, if these follow one on the other; else none."""
    if not {"band", "low", "high"} <= set(geometry.values):
        return np.zeros(0)
    low, high = (np.unique(np.asarray(geometry.values[name].values, float)) for name in ("low", "high"))
    if not len(low) or not np.isfinite([low[0], high[-1]]).all() or not np.array_equal(low[1:], high[:-1]):
        return np.zeros(0)
    return np.append(low, high[-1])


def _is_flat(geometry: Geometry) -> bool:
    bounds = geometry.bounds
    return bounds is not None and bounds[4] == bounds[5] and not geometry.primitives


def _title(geometry: Geometry, borders: NDArray[np.float64], relief: bool, light: float) -> str:
    if geometry.shows:
        return ""  # the error's own words stand there
    if not len(borders):
        return _titles.of_surface(geometry, relief, light)
    widths = np.diff(borders)
    if len(widths) > 1 and np.allclose(widths, widths[0], rtol=1e-6):
        return f"Bands of {_titles.with_unit(_titles.number(round(float(widths[0]), 12)), geometry.values['low'].unit)}"
    return f"Bands between {len(borders)} levels"
