"""The region between two levels as a closed mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Geometry,
    Identity,
    Missing,
    Model,
    NamedTuple,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    Value,
    mapper,
)
from modules.mappers._caps import caps
from modules.mappers._isosurface_together import known_together
from modules.mappers.isosurface import isosurface

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BOXES = Source(
    "Volume between bounds", "mapping", "proven", "boxes of the cells and planes moved by the rest of the field [solid-boxes/1]"
)


class IntervalVolume(NamedTuple):
    """The closed surface of the region, and its volume."""

    surface: Geometry
    volume: Value


@mapper("Interval volume", version=2, aliases=("between two levels", "shell", "thick surface", "solid"))
def interval_volume(
    model: Model,
    progress: Progress,
    *,
    low: Annotated[float | None, Range(of="model.range")] = None,
    high: Annotated[float | None, Range(of="model.range")] = None,
    cuts: Annotated[int, Range(1, 16)] = 4,
) -> IntervalVolume:
    """The region low <= F < high as a closed mesh that looks outwards: two accurate isosurfaces and the border of the grid.

    Values "side" of the triangles: 0 where the field is low, 1 where it is high, 2 on the border of the grid.

    Parameters
    ----------
    low, high : in the unit of the field; automatic: a third and two thirds of its range
    cuts : boxes along each axis of a cell, for the bounds of the volume

    Raises
    ------
    ValueError : low is not below high, there are holes, or the model is not a linear one of single values on a regular or
        rectilinear grid of three dimensions

    Accuracy: each surface has the trilinear topology and its own proven distance; the volume is proven to lie within its
        bound. Errors of the model move both surfaces; what they change of the volume is told by 'enclosed volume'.
    Source: Lopes 1999, 4.5 (future work); Fujishiro, Maeda, Sato and Takeshima 1996.
    """
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or model.law.name != "linear":
        raise ValueError("an interval volume needs a linear model on a regular or rectilinear grid of 3 dimensions")
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    if not np.isfinite(values).all():
        raise ValueError("the region between two levels cannot be closed beside samples that are not known: fill or crop them")
    least, most = float(values.min()), float(values.max())
    low = least + (most - least) / 3 if low is None else low
    high = most - (most - least) / 3 if high is None else high
    if not low < high:
        raise ValueError(f"low = {low:g} must be less than high = {high:g}")
    sheets = [isosurface(model, progress.part(0.4 * n, 0.4 * (n + 1)), level=level) for n, level in enumerate((low, high))]
    mesh = [(s.points, s.triangles) for s in sheets]
    points, triangles = caps(values, grid.axes, (low, high), mesh, progress.part(0.8, 1.0))
    below, above = (len(s.points) for s in sheets)
    everything = np.concatenate([sheets[0].triangles, sheets[1].triangles[:, ::-1] + below, triangles])
    side = np.repeat([0, 1, 2], [len(sheets[0].triangles), len(sheets[1].triangles), len(triangles)])
    n = below + above + len(points)
    surface = Geometry(
        points=np.concatenate([sheets[0].points, sheets[1].points, points]),
        polygons=Cells.of(everything),
        values={
            "side": Field(side, "cell"),
            "distance": Field(
                np.concatenate([*(s.values["distance"].values for s in sheets), np.zeros(len(triangles))]),
                "cell",
                sheets[0].values["distance"].unit,
            ),
        },
        cell=sheets[0].cell,
        frame=grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=known_together(sheets, n),
    )
    return IntervalVolume(surface, _volume(model, values, grid.axes, low, high, cuts))


def _volume(model: Model, values: Floats, axes: tuple[Floats, ...], low: float, high: float, cuts: int) -> Value:
    x, y, z = axes
    one, two = (kernels.solid.volume(values, x, y, z, level, cuts) for level in (low, high))
    least, most = max(one.low - two.high, 0.0), one.high - two.low
    why = "what errors of values change of the volume is told by 'enclosed volume'"
    unit = model.grid.frame.length_unit(3)
    cubic = f"{unit}³" if unit else ""
    accuracy = Accuracy().end_from(model.accuracy, why).miss(Missing("Errors of the model", why), *model.accuracy.missing)
    half = np.asarray([(most - least) / 2])
    accuracy = accuracy.add(Term(BOXES, "bound", "volume", cubic, half, Identity(1)))
    return Value(value=(least + most) / 2, unit=cubic, name="volume", accuracy=accuracy)
