"""The band around contour lines in which they may lie, by the errors of the data: soft where these are random."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from modules.accuracy_mappers import _nested
from modules.accuracy_mappers import _within as within
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Geometry,
    Model,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Shown,
    Term,
    accuracy_mapper,
    scaling,
    select,
)
from modules.data.geometry import points_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CHORD = 1e-3
"""Of a cell: area that the sides of the band leave beside its arcs."""
FLATTEST = 1e-150
"""A smaller slope counts as this one."""
MOST = 4_000_000
"""More polygons are refused: they would fill the memory and no picture shows them."""


@accuracy_mapper("Error band", aliases=("data error", "confidence band", "fuzzy contour", "where it may lie"), output="band")
def band(
    lines: Geometry,
    model: Model,
    progress: Progress,
    accuracy: Accuracy | None = None,
    *,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
    steps: Annotated[int, Range(1, 20)] = 6,
    modelled: bool = False,
) -> Geometry:
    """Nested regions around contour lines in which these may lie, by the known errors of the data.

    Where the field is within its bounds and k standard deviations of the level, the line may pass. Drawn one over the
    other and translucent, the regions are dense where the line is likely and fade out; the lines are not changed.

    Parameters
    ----------
    lines : contour lines
    model : that they were drawn of
    accuracy : of the same model; its own by default
    k : standard deviations that the widest region reaches beyond the bounds
    steps : number of nested regions; each inner one begins where the density of the errors has risen by the same amount
    modelled : whether errors of the model (interpolation and what went before) widen the band, not those of the data alone

    Raises
    ------
    ValueError : the lines are no contour lines, the model is none of theirs, or no error of the data is known

    Accuracy: shows the terms of the data (and of the model) as positions; they go on, a row a polygon, and all other
        terms end here. Bounds add to k standard deviations; of independent errors the band is up to 17 % too wide between
        samples, never too narrow. Cells where error times curvature exceeds 0.4 slope squared
        are flagged, and have 0 as "valid": there a line may lie beyond the band, or not exist.
    Source: after Lopes 1999, 3.5.2; positions to first order by |F - level| <= error, without a division by the slope.
    """
    levels = _levels(lines, model)
    own = Model(samples=model.samples, law=model.law, accuracy=accuracy) if accuracy is not None else model
    chosen = tuple(t for t in own.accuracy.terms if t.source.stage == "data" or (modelled and t.source.stage == "model"))
    if not chosen:
        raise ValueError("no error of the data is known, so there is no band: state one with 'state accuracy'")
    if not (k > 0 and steps >= 1):
        raise ValueError(f"a band reaches k > 0 standard deviations in one step or more, not k = {k:g} in {steps}")
    part = within.restricted(own, chosen)
    found, drawn = _drawn(part, levels, _nested.nested(k, steps), progress)
    shapes, patch, level, reach = drawn
    segment = _nearest(lines, shapes, level)
    kappa = found.kappa[patch]
    return Geometry(
        points=shapes.points,
        polygons=shapes.polygons,
        values={
            "k": Field(reach, "cell"),
            "density": Field(np.exp(-(reach**2) / 2), "cell"),
            "level": Field(level, "cell", model.unit),
            "valid": Field((kappa <= within.VALID).astype(float), "cell"),
        },
        origin=segment,
        shows=tuple(Shown(t.name, "position", _note(t, k)) for t in chosen),
        cell=lines.cell,
        frame=lines.frame,
        name=lines.name,
        time=lines.time,
        accuracy=_accuracy(part, own, lines, model, segment).flag(*_flags(kappa, found.cell[patch], reach)),
    )


def _levels(lines: Geometry, model: Model) -> Floats:
    grid = model.grid
    if "level" not in lines.values or lines.values["level"].place != "cell":
        raise ValueError("a band lies around lines that know their level: wire the lines of 'contour'")
    if grid.dimensions != 2 or not isinstance(grid, Regular | Rectilinear) or model.law.name != "linear":
        raise ValueError(
            "a band needs a linear model on a regular or rectilinear grid of the plane; this one is "
            f"{model.law.name}, on a {grid.dimensions}-dimensional {grid.kind} grid"
        )
    if model.samples.components != 1:
        raise ValueError(f"a band needs one value a sample, got {model.samples.components}: choose a component")
    if lines.frame != grid.frame:
        raise ValueError("lines and model lie in different frames: wire the model that the lines were drawn of")
    return np.unique(np.asarray(lines.values["level"].values, float))


def _drawn(
    model: Model, levels: Floats, nested: Floats, progress: Progress
) -> tuple[within.Patches, tuple[Geometry, Ints, Floats, Floats]]:
    """The regions of all levels, the widest first: shapes, and patch, level and k of each polygon."""
    x, y = model.grid.axes  # type: ignore[attr-defined]  # a rectangle, as _levels has seen
    tolerance = CHORD * float(np.median(np.diff(x)) * np.median(np.diff(y)))
    reached = within.candidates(model, levels, float(nested[0]))
    every = np.unique(np.concatenate([*reached, np.zeros(0, np.int64)]))
    found = within.patches(model, every, progress.part(0.0, 0.6))
    jobs = [(float(r), i) for r in nested for i in range(len(levels))]

    def work(job: tuple[float, int]) -> tuple[Floats, list[Ints], Ints]:
        return within.regions(found, np.searchsorted(every, reached[job[1]]), float(levels[job[1]]), job[0], tolerance)

    done = progress.part(0.6, 1.0).map(work, jobs)
    counts = [len(d[2]) for d in done]
    if sum(counts) > MOST:
        raise ValueError(f"the band has {sum(counts)} polygons: fewer 'steps', fewer levels, or a part of the data")
    starts = np.cumsum([0, *(len(d[0]) for d in done)])
    ends = np.cumsum([0, *(len(d[1][1]) for d in done)])
    offsets = np.concatenate([[0], *(d[1][0][1:] + e for d, e in zip(done, ends, strict=False))]).astype(np.int64)
    connectivity = np.concatenate([np.zeros(0, np.int64), *(d[1][1] + s for d, s in zip(done, starts, strict=False))])
    points = points_of(np.concatenate([np.zeros((0, 2)), *(d[0] for d in done)]))
    patch = np.concatenate([np.zeros(0, np.int64), *(d[2] for d in done)])
    level = np.repeat([levels[i] for _, i in jobs], counts)
    reach = np.repeat([r for r, _ in jobs], counts)
    return found, (Geometry(points=points, polygons=Cells(offsets, connectivity), accuracy=Accuracy()), patch, level, reach)


def _nearest(lines: Geometry, shapes: Geometry, level: Floats) -> Ints:
    """The segment of its own level that each polygon is nearest to."""
    segments = lines.segments()
    middle = lines.points[segments].mean(axis=1)[:, :2]
    of_segment = np.repeat(np.asarray(lines.values["level"].values, float)[len(lines.vertices) :], lines.lines.sizes() - 1)
    corner = shapes.points[shapes.polygons.connectivity, :2]
    centre = np.zeros((len(level), 2))
    if len(level):
        centre = np.add.reduceat(corner, shapes.polygons.offsets[:-1]) / shapes.polygons.sizes()[:, None]
    nearest = np.zeros(len(level), np.int64)
    for one in np.unique(level):
        among, mine = np.flatnonzero(of_segment == one), level == one
        nearest[mine] = among[cKDTree(middle[among]).query(centre[mine])[1]]
    return nearest


def _accuracy(part: Model, own: Model, lines: Geometry, model: Model, segment: Ints) -> Accuracy:
    """The terms that are shown, as positions of the line that each polygon stands for; all others have ended."""
    used, row = np.unique(segment, return_inverse=True)
    at = lines.points[lines.segments()[used, 0]] * [1.0, 1.0, 0.0]
    _, known = part.at(at)
    unit = _unit(model)
    shown = known.push(scaling(1 / np.maximum(within.slope_at(part, at), FLATTEST)), quantity="position", unit=unit)
    shown = shown.push(select(row.astype(np.int64), len(used)), place="cell")
    why = "the band shows where a line may lie by errors of the data, not this"
    full = Accuracy(shown.terms).miss(*own.accuracy.missing, *lines.accuracy.missing)
    return full.end_from(own.accuracy, why).end_from(model.accuracy, why).end_from(lines.accuracy, why)


def _unit(model: Model) -> str:
    try:
        return model.grid.frame.length_unit(2)
    except ValueError as error:
        raise ValueError(f"a band has a width only where lengths have one unit: {error}") from None


def _note(term: Term, k: float) -> str:
    if term.kind in ("linear", "members"):
        return f"band to k = {k:g}, dense where likely"
    return "added to the band on both sides"


def _flags(kappa: Floats, cell: Ints, reach: Floats) -> list[Flag]:
    """The polygons of the widest region, in which all others lie, where a first-order rule does not hold."""
    bad = np.flatnonzero(~(kappa <= within.VALID) & (reach == reach.max(initial=0.0)))
    if not len(bad):
        return []
    words = f"the slope is too small for the error in {len(np.unique(cell[bad]))} grid cells: a line may lie beyond the band"
    return [Flag("kappa", words, "cell", bad, kappa[bad])]
