"""The triangles of an isosurface with their cells and levels, and the model they were drawn of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from modules.api import Geometry, Model, Rectilinear, Regular

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NEEDED = ("level", "grid cell", "distance")


class Triangles(NamedTuple):
    """What accuracy mappers of isosurfaces start from.

    Attributes
    ----------
    values, axes : of the model
    triangles, cell, level : (m, 3), (m,), (m,)
    reach : (m,) proven distance; nan where there is none
    unit : of lengths
    """

    values: Floats
    axes: tuple[Floats, Floats, Floats]
    triangles: Ints
    cell: Ints
    level: Floats
    reach: Floats
    unit: str


def of(surface: Geometry, model: Model, what: str) -> Triangles:
    """The triangles of a surface.

    Raises
    ------
    ValueError : no triangles that know their cell, level and distance, or not of this model
    """
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or model.law.name != "linear":
        raise ValueError(f"{what} need a linear model on a regular or rectilinear grid of 3 dimensions")
    only = surface.counts["cell"] == len(surface.polygons) and (surface.polygons.sizes() == 3).all()
    if not set(NEEDED) <= set(surface.values) or not only:
        raise ValueError(f"{what} need triangles that know their level, cell and distance: wire the surface of 'isosurface'")
    level, cell, reach = (np.asarray(surface.values[name].values) for name in NEEDED)
    if len(cell) and not 0 <= cell.min() <= cell.max() < grid.cells:
        raise ValueError(f"the surface passes cell {cell.max()} of {grid.cells}: wire the model it was drawn of")
    x, y, z = grid.axes
    values = np.asarray(model.samples.values, float)
    unit = surface.values["distance"].unit
    return Triangles(
        values, (x, y, z), surface.triangles, cell.astype(np.int64), level.astype(float), reach.astype(float), unit
    )
