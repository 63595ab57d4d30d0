"""Contour lines of a two-dimensional model, with the exact area between each line and the true contour."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    Literal,
    Model,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    mapper,
    scaling,
)
from modules.data.geometry import points_of
from modules.mappers import _slopes as slopes

Floats = NDArray[np.float64]

CHORDS = {
    "shoulder": Source(
        "Two chords a cell", "mapping", "proven", "farthest point of each arc from its chord; Lopes 1999, 3.3 [arc-sagitta/1]"
    ),
    "basic": Source(
        "One chord a cell", "mapping", "proven", "farthest point of each arc from its chord; Lopes 1999, 3.2 [arc-sagitta/1]"
    ),
}
AREA = Source(
    "Area between line and contour", "mapping", "exact", "|K| (sinh w - w) of each arc; Lopes 1999, 3.5.1 [arc-area/1]"
)
JOINING = Source(
    "Joining of the lines", "mapping", "exact", "asymptotic decider without division; Lopes 1999, 3.2.1 [decider/1]"
)
FLATTEST = 1e-150
"""A smaller slope counts as this one: the position is then not known to first order, and the number says so."""


@mapper("Contour", aliases=("isoline", "isobar", "isotherm", "level", "contouring"), output="lines")
def contour(
    model: Model,
    progress: Progress,
    *,
    levels: Annotated[tuple[float, ...] | None, Range(of="model.range")] = None,
    interval: Annotated[float | None, Range(low=0)] = None,
    method: Literal["shoulder", "basic"] = "shoulder",
) -> Geometry:
    """Lines on which a two-dimensional field has a level, with the topology of its bilinear model.

    Parameters
    ----------
    levels : values to draw, in the unit of the field; automatic: by the interval
    interval : distance of the levels, which are its multiples; automatic: a round number that gives about ten
    method : shoulder (an extra point where each arc bends most), or basic (one chord a cell)

    Raises
    ------
    ValueError : the model is not two-dimensional, not linear or not scalar, or there are too many levels

    Accuracy: errors of the model move a line by error / slope, to first order (flagged where that fails); the area
        between line and exact contour is known exactly, its largest distance is proven. The joining of lines is exact.
    Source: Lopes 1999, chapter 3; area in closed form, |K| (sinh w - w), instead of (3.29).
    """
    grid = _plane(model)
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    chosen = _levels(values, levels, interval)
    x, y = grid.axes
    drawn = progress.map(
        lambda level: kernels.contour.lines(values, x, y, level, method == "shoulder", check=lambda _: progress.check()),
        chosen,
    )
    points, lines, which = _joined(drawn)
    bend, cell = (np.concatenate([getattr(d, name) for d in drawn] or [np.zeros(0)]) for name in ("bend", "cell"))
    line_level = np.asarray(chosen, float)[which]
    segments = np.repeat(line_level, np.maximum(lines.sizes() - 1, 0))
    bare = Geometry(points=points, lines=lines, accuracy=Accuracy())
    accuracy = _accuracy(model, bare, bend, cell.astype(np.int64), method)
    accuracy = accuracy.flag(*_at_risk(model, drawn, chosen, segments, cell.astype(np.int64)))
    return Geometry(
        points=points,
        lines=lines,
        values={
            "level": Field(line_level, "cell", model.unit),
            "bend": Field(bend, "segment"),
            "grid cell": Field(cell.astype(np.int64), "segment"),
        },
        cell=float(np.sqrt(np.median(np.diff(x)) * np.median(np.diff(y)))),
        frame=grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def _plane(model: Model) -> Regular | Rectilinear:
    grid = model.grid
    if model.law.name != "linear":
        raise ValueError(f"contour draws the linear model; this one is {model.law.name}: choose law 'linear' in interpolate")
    if grid.dimensions != 2 or not isinstance(grid, Regular | Rectilinear):
        raise ValueError(
            f"contour needs a two-dimensional regular or rectilinear grid, got {grid.dimensions}-dimensional {grid.kind}: "
            "take a slice first"
        )
    if model.samples.components != 1:
        raise ValueError(f"contour needs one value a sample, got {model.samples.components}: choose a component or the length")
    return grid


def _levels(values: Floats, levels: Sequence[float] | None, interval: float | None) -> list[float]:
    """The levels to draw: those given, or multiples of an interval within the range."""
    if levels is not None:
        return sorted(set(levels))
    finite = values[np.isfinite(values)]
    if not finite.size:
        return []
    low, high = float(finite.min()), float(finite.max())
    if interval is not None and interval <= 0:
        raise ValueError(f"interval must be positive, not {interval:g}")
    step = interval if interval is not None else round_step((high - low) / 10)
    if not step or high == low:
        return []
    if (high - low) / step > 10_000:
        raise ValueError(f"an interval of {step:g} gives {(high - low) / step:.0f} levels: choose a larger one")
    first = math.floor(low / step) + 1
    return [k * step for k in range(first, math.ceil(high / step)) if low < k * step < high]


def round_step(width: float) -> float:
    """The round number, 1, 2 or 5 times a power of ten, that is nearest above a width; 0 for none."""
    if not width > 0 or not math.isfinite(width):
        return 0.0
    power = 10.0 ** math.floor(math.log10(width))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= width * (1 - 1e-9))


def _joined(drawn: Sequence[kernels.contour.ContourLines]) -> tuple[Floats, Cells, NDArray[np.int64]]:
    """The lines of all levels as one geometry: points, lines, and the level of each line.

    A closed line names its first point again instead of repeating it.
    """
    points, connectivity, sizes, which = [np.zeros((0, 2))], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], []
    known = 0
    for i, d in enumerate(drawn):
        first, last = d.offsets[:-1], d.offsets[1:] - 1
        closed = (d.points[first] == d.points[last]).all(axis=1) & (last > first)
        keep = np.ones(len(d.points), bool)
        keep[last[closed]] = False
        ids = known + np.cumsum(keep) - 1
        ids[last[closed]] = ids[first[closed]]
        points.append(d.points[keep])
        connectivity.append(ids)
        sizes.append(np.diff(d.offsets))
        which.append(np.full(len(first), i, np.int64))
        known += int(keep.sum())
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64)
    level = np.concatenate([*which, np.zeros(0, np.int64)])
    return points_of(np.concatenate(points)), Cells(offsets, np.concatenate(connectivity)), level


def _accuracy(model: Model, bare: Geometry, bend: Floats, cell: NDArray[np.int64], method: str) -> Accuracy:
    """Errors of the model as positions of the points; area and distance of each segment from the exact contour."""
    n, segments = len(bare.points), bare.segments()
    length, unit = _measure(model)
    slope = slopes.smallest(model, bare.points, segments, cell, length)
    _, at_points = model.at(bare.points)
    accuracy = at_points.push(scaling(1 / np.maximum(slope, FLATTEST)), quantity="position", unit=unit)
    step = (bare.points[segments[:, 1]] - bare.points[segments[:, 0]])[:, :2] / length
    area = kernels.arcs.area(step[:, 0], step[:, 1], bend)
    reach = kernels.arcs.sagitta(step[:, 0], step[:, 1], bend)
    farthest = np.zeros(n)
    np.maximum.at(farthest, segments.ravel(), np.repeat(reach, 2))
    square = f"{unit}²" if unit else ""
    terms = (
        Term(CHORDS[method], "bound", "position", unit, farthest, Identity(n)),
        Term(AREA, "metric", "area", square, area, Identity(len(segments)), "segment"),
        Term(JOINING, "bound", "position", unit, np.asarray(0.0), Identity(n)),
    )
    return accuracy.add(*terms).flag(*slopes.too_curved(model, bare.points, at_points, slope, length))


def _measure(model: Model) -> tuple[Floats, str]:
    """What one unit of length is along x and y: 1 in a common unit, or a cell where the axes' units differ."""
    grid = model.grid
    try:
        return np.ones(2), grid.frame.length_unit(2)
    except ValueError:
        assert isinstance(grid, Regular | Rectilinear)
        return np.array([np.median(np.diff(a)) for a in grid.axes]), "cell"


def _at_risk(
    model: Model,
    drawn: Sequence[kernels.contour.ContourLines],
    levels: Sequence[float],
    segment_level: Floats,
    segment_cell: NDArray[np.int64],
) -> list[Flag]:
    """Segments of cells whose saddle is closer to the level than the errors of the values reach."""
    if not any(len(d.saddle_cell) for d in drawn):
        return []
    _, there = model.at(slopes.saddles(model, np.concatenate([d.saddle_cell for d in drawn])))
    reach = np.split(there.total(2.0, "value"), np.cumsum([len(d.saddle_cell) for d in drawn])[:-1])
    hit, count = [], 0
    for d, level, error in zip(drawn, levels, reach, strict=True):
        risky = d.saddle_cell[d.saddle_margin <= error]
        count += len(risky)
        if len(risky):
            hit.append(np.flatnonzero((segment_level == level) & np.isin(segment_cell, risky)))
    if not count:
        return []
    words = f"the saddle of {count} cells is closer to the level than the known errors: lines may join the other way"
    return [Flag("topology at risk", words, "segment", np.concatenate(hit))]
