"""Filled bands of a two-dimensional model: colour bands of a map, and the exact area of each (thesis 2.4.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Gather,
    Geometry,
    Identity,
    Matrix,
    Model,
    NamedTuple,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Table,
    Term,
    exactly,
    mapper,
)
from modules.data.geometry import points_of
from modules.mappers import _borders as borders
from modules.mappers._plane import Rectangle
from modules.mappers.contour import round_step

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CHORDS = Source("Chords of the borders", "mapping", "proven", "farthest point of each arc from its chord [arc-sagitta/1]")
AREA = Source(
    "Area between border and polygon", "mapping", "exact", "|K| (sinh w - w) of each arc; Lopes 1999, 3.5.1 [arc-area/1]"
)
CLOSED = "integral under the hyperbolas of each cell, in closed form [band-area/1]"
MOST = 1_000
"""More bands are refused: nobody tells so many colours apart."""


class Filled(NamedTuple):
    """The polygons of the bands, and a row for each band."""

    bands: Geometry
    areas: Table


@mapper("Colour bands", aliases=("filled contours", "hypsometric tints", "choropleth", "contourf", "level bands"))
def bands(
    model: Model,
    progress: Progress,
    *,
    levels: Annotated[tuple[float, ...] | None, Range(of="model.range")] = None,
    interval: Annotated[float | None, Range(low=0)] = None,
    count: Annotated[int | None, Range(1, 30)] = None,
    tolerance: Annotated[float, Range(1e-6, 0.5, log=True)] = 1e-3,
    merge: bool = False,
) -> Filled:
    """The regions in which a two-dimensional field lies between two levels, as polygons, and their exact areas.

    Parameters
    ----------
    levels : borders of the bands, in the unit of the field; nothing is filled below the first and above the last
    interval : width of the bands, whose borders are its multiples; automatic: a round number that gives about ten
    count : number of bands of equal width from the lowest to the highest value, instead of an interval
    tolerance : largest area that is left between an arc of a border and its chords, as a share of a grid cell
    merge : cells of a row that lie in one band as a whole become one rectangle: fewer polygons, for flat maps only

    Raises
    ------
    ValueError : the model is not two-dimensional, not linear or not scalar, or there is no band or too many

    Accuracy: errors of the model move a border by error / slope, to first order (flagged where that fails); the area
        between polygon and exact border is known exactly, the distance of its chords is proven. Areas in the table are
        exact for the bilinear model; errors of the model change them by the integral of error / slope along the borders.
    Source: Lopes 1999, 2.4.2 and chapter 3; areas in closed form.
    """
    grid = _plane(model)
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    marks = _marks(values, levels, interval, count)
    plane = Rectangle(model)
    x, y = grid.axes
    cell = plane.cell**2
    part = progress.part(0.0, 0.7)
    drawn = kernels.bands.fill(values, x, y, marks, tolerance * cell, merged=merge, check=part)
    progress.check()
    shapes = Geometry(
        points=points_of(drawn.points),
        polygons=Cells(drawn.offsets, drawn.connectivity),
        values={
            "level": Field((marks[:-1] / 2 + marks[1:] / 2)[drawn.band], "cell", model.unit),
            "low": Field(marks[drawn.band], "cell", model.unit),
            "high": Field(marks[drawn.band + 1], "cell", model.unit),
            "band": Field(drawn.band, "cell"),
        },
        origin=drawn.cell,
        cell=plane.cell,
        frame=grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=_of_shapes(plane, drawn, marks),
    )
    progress(0.8)
    return Filled(shapes, _table(plane, drawn, marks, shapes, progress))


def _plane(model: Model) -> Regular | Rectilinear:
    grid = model.grid
    if model.law.name != "linear":
        raise ValueError(f"bands are of the linear model; this one is {model.law.name}: choose law 'linear' in interpolate")
    if grid.dimensions != 2 or not isinstance(grid, Regular | Rectilinear):
        raise ValueError(
            f"bands need a two-dimensional regular or rectilinear grid, got {grid.dimensions}-dimensional {grid.kind}: "
            "take a slice first"
        )
    if model.samples.components != 1:
        raise ValueError(f"bands need one value a sample, got {model.samples.components}: choose a component or the length")
    return grid


def _marks(values: Floats, levels: Sequence[float] | None, interval: float | None, count: int | None) -> Floats:
    """The borders of the bands, ascending; the highest value lies below the last unless levels are given."""
    if levels is not None:
        marks = np.unique(np.asarray(levels, float))
        if len(marks) < 2:
            raise ValueError("a band lies between two levels: give two or more")
        return marks
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    if count is not None:
        if not 1 <= count <= MOST:
            raise ValueError(f"there can be 1 to {MOST} bands, not {count}")
        ends = np.linspace(low, high, count + 1)
        ends[-1] = np.nextafter(high, np.inf)
        return np.unique(ends)
    if interval is not None and interval <= 0:
        raise ValueError(f"interval must be positive, not {interval:g}")
    step = interval if interval is not None else round_step((high - low) / 10) or 1.0
    if (high - low) / step > MOST:
        raise ValueError(f"an interval of {step:g} gives {(high - low) / step:.0f} bands: choose a larger one")
    first, last = math.floor(low / step), math.floor(high / step) + 1
    return np.array([k * step for k in range(first, last + 1)])


def _of_shapes(plane: Rectangle, drawn: kernels.bands.Bands, marks: Floats) -> Accuracy:
    """Errors of the model as positions of the borders; distance and area between polygons and exact borders."""
    unit = plane.unit
    edge = borders.border(plane, drawn, np.flatnonzero(~_whole(plane, drawn, marks)))
    n = len(drawn.points)
    at = np.flatnonzero(np.isfinite(edge.slope))
    _, at_border = plane.model.at(points_of(drawn.points[at]))
    rows, weight = np.zeros((n, 1 if len(at) else 0), np.int64), np.zeros((n, 1 if len(at) else 0))
    if len(at):
        rows[at, 0] = np.arange(len(at))
        weight[at, 0] = 1 / np.maximum(edge.slope[at], borders.FLATTEST)
    accuracy = at_border.push(Gather(rows, weight, len(at)), quantity="position", unit=unit)
    left = drawn.left / float(np.prod(plane.measure))
    found = borders.too_curved(plane, points_of(drawn.points[at]), at_border, edge.slope[at])
    flags = [Flag(f.name, f.words, "point", at[f.items], f.values) for f in found if f.items is not None]
    return accuracy.add(
        Term(CHORDS, "bound", "position", unit, edge.reach, Identity(n)),
        Term(AREA, "metric", "area", f"{unit}²" if unit else "", left, Identity(len(left)), "cell"),
    ).flag(*flags)


def _whole(plane: Rectangle, drawn: kernels.bands.Bands, marks: Floats) -> NDArray[np.bool_]:
    """Which polygons are whole cells."""
    corners = np.stack(plane.corners(*np.divmod(drawn.cell, len(plane.axes[0]) - 1)))
    return np.asarray(((corners >= marks[drawn.band]) & (corners < marks[drawn.band + 1])).all(axis=0))


def _table(
    plane: Rectangle, drawn: kernels.bands.Bands, marks: Floats, shapes: Geometry, progress: Progress
) -> Table:
    """A row for each band: its ends, its exact area and its share of the whole."""
    model, n = plane.model, len(marks) - 1
    scale = float(np.prod(plane.measure))
    area = np.bincount(drawn.band, drawn.area, n) / scale
    finite = np.isfinite(plane.values)
    solid = finite[:-1, :-1] & finite[1:, :-1] & finite[:-1, 1:] & finite[1:, 1:]
    total = float(np.outer(np.diff(plane.axes[1]), np.diff(plane.axes[0]))[solid].sum()) / scale
    square = f"{plane.unit}²" if plane.unit else ""
    found = borders.areas(plane, marks, lambda _: progress.check())
    _, at = model.at(found.points)
    accuracy = at.push(Matrix(csr_array(found.weights / scale)), quantity="area", unit=square)
    accuracy = accuracy.add(exactly("Area by closed form", "mapping", n, quantity="area", unit=square, rule=CLOSED))
    return Table(
        columns={
            "band": np.arange(n), "low": marks[:-1], "high": marks[1:], "area": area,
            "share": area / total if total else np.zeros(n),
        },
        units={"low": model.unit, "high": model.unit, "area": square},
        name=model.samples.name,
        accuracy=accuracy.flag(*_of_rows(shapes, drawn, n)),
    )  # fmt: skip


def _of_rows(shapes: Geometry, drawn: kernels.bands.Bands, n: int) -> list[Flag]:
    """The rows whose borders the flags of the points lie on."""
    flags = []
    for flag in shapes.accuracy.flags:
        if flag.items is None:
            continue
        level = np.unique(drawn.on[flag.items])
        rows = np.unique(np.concatenate([level - 1, level]))
        rows = rows[(rows >= 0) & (rows < n)]
        words = "the slope along their borders is too small for the error: these areas may change by more"
        flags.append(Flag(flag.name, words, "point", rows))
    return flags
