"""Contour lines of a two-dimensional model, with the exact area between each line and the true contour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Annotated, Cells, Field, Geometry, Literal, Model, Progress, Range, mapper
from modules.mappers._contour_accuracy import joins_at_risk, position, too_thin
from modules.mappers._plane import Drawn, plane_of

if TYPE_CHECKING:
    from modules.kernels.contour import ContourLines

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_LEVELS = 10_000

EXACT_TO = 1e-5
"""Of a cell: what the method 'exact' leaves beside an arc."""


@mapper("Contour", version=2, aliases=("isoline", "isobar", "isotherm", "level", "contouring"), output="lines")
def contour(
    model: Model,
    progress: Progress,
    *,
    levels: Annotated[tuple[float, ...] | None, Range(of="model.range")] = None,
    interval: Annotated[float | None, Range(low=0)] = None,
    count: Annotated[int | None, Range(1, 100)] = None,
    method: Literal["shoulder", "basic", "four_triangles", "exact"] = "shoulder",
    tolerance: Annotated[float | None, Range(1e-8, 0.1, log=True, unit="cell")] = None,
) -> Geometry:
    """Lines on which a two-dimensional field has a level, with the topology of its bilinear model.

    A cubic model is sampled finely first; a bent cell is contoured in its own coordinates and mapped; in triangles the
    lines are exact.

    Parameters
    ----------
    levels : values to draw, in the unit of the field; automatic: by the interval or the count
    interval : distance of the levels, which are its multiples; automatic: a round number that gives about ten
    count : so many levels, evenly spaced between the ends of the field; automatic: by the interval
    method : shoulder (a point where each arc bends most), basic (one chord a cell), exact (to the tolerance), or
        four_triangles (about the mean of each cell, for comparison: its lines may join wrongly)
    tolerance : area that may be left beside each arc, as a part of its cell; automatic: what the method leaves

    Raises
    ------
    ValueError : the model is not two-dimensional, or not of one value a sample, or there are too many levels

    Accuracy: errors of the model move a line by error / slope, to first order (flagged where that fails); the area
        between line and exact contour is known exactly, its largest distance is proven. The joining of lines is exact.
        On a bent lattice areas and distances are estimated on the image; those of four triangles are sampled.
    Source: Lopes 1999, chapter 3; area in closed form, |K| (sinh w - w), instead of (3.29).
    """
    plane = plane_of(model)
    chosen = _levels(plane.values, levels, interval, count)
    left = _tolerance(method, tolerance)
    lines = progress.map(lambda level: plane.draw(level, method, left, lambda _: progress.check()), chosen)
    drawn = _joined(lines, chosen)
    points = plane.place(drawn)
    accuracy = position(plane, drawn, method)
    accuracy = accuracy.flag(
        *joins_at_risk(plane, lines, chosen, drawn), *too_thin(accuracy, drawn, points, plane.at(drawn), chosen)
    )
    bend = np.full(len(drawn.bend), np.nan) if method == "four_triangles" or not plane.exact else drawn.bend
    return Geometry(
        points=points,
        lines=drawn.lines,
        values={
            "level": Field(drawn.line_level, "cell", model.unit),
            "bend": Field(bend, "segment"),
            "grid cell": Field(drawn.cell, "segment"),
        },
        cell=plane.cell,
        frame=model.grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def _tolerance(method: str, tolerance: float | None) -> float | None:
    if tolerance is not None and not tolerance > 0:
        raise ValueError(f"tolerance must be positive, not {tolerance:g}")
    return EXACT_TO if method == "exact" and tolerance is None else tolerance


def _levels(
    values: Floats, levels: Sequence[float] | None, interval: float | None, count: int | None = None
) -> list[float]:
    """The levels to draw: those given, multiples of an interval, or a count of them, within the range."""
    if levels is not None:
        return sorted(set(levels))
    finite = values[np.isfinite(values)]
    if not finite.size:
        return []
    low, high = float(finite.min()), float(finite.max())
    if interval is not None and interval <= 0:
        raise ValueError(f"interval must be positive, not {interval:g}")
    if interval is None and count is not None:
        if not 1 <= count <= MOST_LEVELS:
            raise ValueError(f"count must be from 1 to {MOST_LEVELS}, not {count}")
        return [low + (high - low) * k / (count + 1) for k in range(1, count + 1)] if high > low else []
    step = interval if interval is not None else round_step((high - low) / 10)
    if not step or high == low:
        return []
    if (high - low) / step > MOST_LEVELS:
        raise ValueError(f"an interval of {step:g} gives {(high - low) / step:.0f} levels: choose a larger one")
    first = math.floor(low / step) + 1
    return [k * step for k in range(first, math.ceil(high / step)) if low < k * step < high]


def round_step(width: float) -> float:
    """The round number, 1, 2 or 5 times a power of ten, that is nearest above a width; 0 for none."""
    if not width > 0 or not math.isfinite(width):
        return 0.0
    power = 10.0 ** math.floor(math.log10(width))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= width * (1 - 1e-9))


def _joined(lines: Sequence[ContourLines], levels: Sequence[float]) -> Drawn:
    """The lines of all levels as one; a closed line names its first point again instead of repeating it."""
    points, ids, sizes, which = [np.zeros((0, 2))], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    known = 0
    for i, d in enumerate(lines):
        first, last = d.offsets[:-1], d.offsets[1:] - 1
        closed = (d.points[first] == d.points[last]).all(axis=1) & (last > first)
        keep = np.ones(len(d.points), bool)
        keep[last[closed]] = False
        mine = known + np.cumsum(keep) - 1
        mine[last[closed]] = mine[first[closed]]
        points.append(d.points[keep])
        ids.append(mine)
        sizes.append(np.diff(d.offsets))
        which.append(np.full(len(first), i, np.int64))
        known += int(keep.sum())
    cells = Cells(np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64), np.concatenate(ids))
    at = np.concatenate(points)
    bare = Geometry(points=np.column_stack([at, np.zeros(len(at))]), lines=cells, accuracy=Accuracy())
    cell, bend = (np.concatenate([np.zeros(0), *(getattr(d, name) for d in lines)]) for name in ("cell", "bend"))
    level = np.asarray(levels, float)[np.concatenate(which)]
    return Drawn(at, cells, bare.segments(), cell.astype(np.int64), bend, level)
