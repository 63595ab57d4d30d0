"""Colour maps by name, and how a module comes to one."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modules.data.colours import CIVIDIS, TABLES, rgb
from modules.data.geometry import Field, Geometry
from modules.data.scene import Colouring, ColourMap

Scale = Literal["linear", "logarithmic"]
MapName = Literal["values", "errors", "greys"]

__all__ = ["CIVIDIS", "TABLES", "MapName", "Scale", "by_field", "colour_map", "ends", "field_of", "rgb", "sizes_of"]


def colour_map(name: str = "values", *, scale: Scale = "linear", steps: int = 0) -> ColourMap:
    """The colour map of a name: "values" is cividis, "errors" runs from clay to ember, "greys" from dark to light.

    Parameters
    ----------
    steps : number of discrete colours; 0 for a continuous map

    Raises
    ------
    ValueError : no such map, or fewer than two steps
    """
    if name not in TABLES:
        raise ValueError(f"there is no colour map {name!r}: maps are {', '.join(TABLES)}")
    if steps < 0 or steps == 1:
        raise ValueError("a discrete colour map has at least 2 steps; 0 is a continuous one")
    return ColourMap(name, rgb(TABLES[name]), scale, steps)


def ends(values: NDArray[np.float64], map: ColourMap, low: float | None, high: float | None) -> tuple[float, float]:
    """The ends of a colour bar: as given, else those of the finite data; errors are told from zero.

    Raises
    ------
    ValueError : a logarithmic map meets values of zero or less, or the ends are the wrong way round
    """
    finite = values[np.isfinite(values)]
    first = float(finite.min()) if low is None and finite.size else (0.0 if low is None else low)
    if map.name == "errors" and map.scale == "linear" and low is None and first > 0:
        first = 0.0
    last = float(finite.max()) if high is None and finite.size else (1.0 if high is None else high)
    if map.scale == "logarithmic" and first <= 0:
        what = f"the lowest value is {first:.3g}" if low is None else f"the lower end is {first:.3g}"
        raise ValueError(f"a logarithmic colour map takes values above zero; {what}: give a lower end above zero")
    if first > last:
        raise ValueError(f"the lower end {first:g} of the colours lies above the upper end {last:g}")
    return (first, last) if first < last else (first, first + (abs(first) or 1.0) * 1e-6)


def by_field(
    geometry: Geometry, by: str, map: ColourMap, low: float | None = None, high: float | None = None
) -> Colouring | None:
    """Colouring by a field of a geometry; None when `by` is empty.

    Raises
    ------
    ValueError : no such field, or one that has no colours on this map
    """
    if not by:
        return None
    field = field_of(geometry, by)
    sizes = sizes_of(field)
    return Colouring(by=by, map=map, range=ends(sizes, map, low, high), title=by, unit=field.unit)


def field_of(geometry: Geometry, by: str) -> Field:
    """The field of a name, or a sentence that lists what there is."""
    if by not in geometry.values:
        there = f"it has {', '.join(geometry.values)}" if geometry.values else "it has no values"
        raise ValueError(f"the geometry has no values {by!r}: {there}")
    return geometry.values[by]


def sizes_of(field: Field) -> NDArray[np.float64]:
    """(n,) the values, or the lengths of vectors."""
    values = np.asarray(field.values, float)
    return np.linalg.norm(values, axis=1) if values.ndim > 1 else values
