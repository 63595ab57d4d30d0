"""The dust cloud: random points between each drawn line and the exact contour, as many as the area between them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Geometry,
    Range,
    Shown,
    Term,
    accuracy_mapper,
    select,
)
from modules.data.geometry import points_of

MOST = 5_000_000
"""More points are refused: they would fill the picture and the memory."""


@accuracy_mapper("Dust cloud", aliases=("random points", "area metric", "contour error"), output="dust")
def dust(
    lines: Geometry,
    accuracy: Accuracy | None = None,
    *,
    points: Annotated[int, Range(100, 100_000, log=True)] = 4_000,
    point_area: Annotated[float | None, Range(low=0)] = None,
    exaggeration: Annotated[float, Range(1, 100, log=True)] = 1.0,
    seed: int = 1,
) -> Geometry:
    """Random points spread evenly between contour lines and the exact contour: the cloud is large where the error is.

    The number of points of a segment is in proportion to the area it leaves, so the density within the area is even.
    The lines themselves are not changed.

    Parameters
    ----------
    lines : contour lines
    accuracy : of the same lines; their own by default
    points : wanted number of points in all
    point_area : area that one point stands for, to compare pictures on one scale; automatic: from the number of points
    exaggeration : distance of the points from their chord, times this; printed in the picture
    seed : of the chance; another seed is another cloud of the same error

    Raises
    ------
    ValueError : the lines are not contour lines, or the area of one point gives too many

    Accuracy: shows the area between line and contour. That term goes on, a row a point; all other terms of the lines end
        here, for the dust shows nothing of them.
    Source: Lopes 1999, 3.5.2 and figure 3.12, with the number of points instead of their density in proportion.
    """
    shown = lines.accept(accuracy)
    term = _area(lines, shown)
    area = term.size()
    per_point = _point_area(float(area.sum()), points, point_area)
    random = np.random.default_rng(seed)
    counts = _counts(area, per_point, random)
    if counts.sum() > MOST:
        raise ValueError(f"one point a {per_point:g} {term.unit} gives {counts.sum()} points: choose a larger point_area")
    cloud = _cloud(lines, counts, exaggeration, random)
    where = np.repeat(np.arange(len(counts)), counts)
    only = Accuracy((term.push(select(where, term.count), place="point"),), shown.missing, (), shown.ended)
    why = "the dust shows the area between line and contour only"
    return Geometry(
        points=cloud,
        vertices=Cells.of(np.arange(len(cloud))[:, None]),
        origin=where.astype(np.int64),
        shows=(Shown(term.name, "area", f"1 point = {_number(per_point)} {term.unit}".strip(), exaggeration),),
        cell=lines.cell,
        frame=lines.frame,
        name=lines.name,
        time=lines.time,
        accuracy=only.end_from(shown, why).end_from(lines.accuracy, why),
    )


def _area(lines: Geometry, shown: Accuracy) -> Term:
    found = [t for t in shown.select("area", "segment") if t.kind == "metric"]
    if not found or "bend" not in lines.values:
        raise ValueError("dust needs contour lines that know their area from the exact contour: wire the lines of 'contour'")
    if np.isnan(np.asarray(lines.values["bend"].values, float)).any():
        raise ValueError(
            "dust fills the space between a line and its hyperbola: wire a contour by shoulder, basic or exact of a regular or "
            "rectilinear grid"
        )
    return found[0]


def _point_area(total: float, points: int, given: float | None) -> float:
    """The area of a point: the one given, or the round number that gives about the wanted number of points."""
    if given is not None:
        if given <= 0:
            raise ValueError(f"point_area must be positive, not {given:g}")
        return given
    if points < 1:
        raise ValueError(f"points must be at least 1, not {points}")
    if total <= 0:
        return 1.0
    exact = total / points
    power = 10.0 ** math.floor(math.log10(exact))
    return min((m * power for m in (1.0, 2.0, 5.0, 10.0)), key=lambda a: abs(math.log(a / exact)))


def _counts(area: NDArray[np.float64], per_point: float, random: np.random.Generator) -> NDArray[np.int64]:
    """Points of each segment: its area over that of a point, the fraction decided by chance."""
    wanted = area / per_point
    whole = np.floor(wanted)
    return (whole + (random.random(len(area)) < wanted - whole)).astype(np.int64)


def _cloud(lines: Geometry, counts: NDArray[np.int64], factor: float, random: np.random.Generator) -> NDArray[np.float64]:
    segments = lines.segments()
    start, end = lines.points[segments[:, 0], :2], lines.points[segments[:, 1], :2]
    cloud = kernels.arcs.uniform(start, end, np.asarray(lines.values["bend"].values, float), counts, random)
    if factor != 1.0:
        where = np.repeat(np.arange(len(counts)), counts)
        chord = end[where] - start[where]
        share = ((cloud - start[where]) * chord).sum(axis=1) / (chord**2).sum(axis=1)
        foot = start[where] + share[:, None] * chord
        cloud = foot + factor * (cloud - foot)
    return points_of(cloud)


def _number(value: float) -> str:
    if 1e3 <= value < 1e9:
        return f"{value:,.0f}".replace(",", "\u2009")
    return f"{value:.3g}" if 1e-4 <= value < 1e3 else f"{value:.0e}"
