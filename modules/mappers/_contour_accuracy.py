"""What is known of where contour lines lie: terms from the errors of the values, from the drawing, and the flags."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from modules.data.accuracy import Accuracy, Flag, Source, Term
from modules.data.operators import Identity, scaling
from modules.mappers._plane import Drawn, Plane, Rectangle, Triangles

if TYPE_CHECKING:
    from modules.kernels.contour import ContourLines

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VALID = 0.4
"""Largest kappa = error |F_nn| / slope^2 for which 95 % bands of a first-order position cover 94 to 98 %."""

FLATTEST = 1e-150
"""A smaller slope counts as this one: the position is then not known to first order, and the number says so."""

SURE = 0.05
"""Saddles that may decide otherwise with a larger probability are flagged."""

CHORDS = {
    "shoulder": ("Two chords a cell", "farthest point of each arc from its chord; Lopes 1999, 3.3"),
    "basic": ("One chord a cell", "farthest point of each arc from its chord; Lopes 1999, 3.2"),
    "triangles": ("Lines through triangles", "straight, as the linear field is; Lopes 1999, 3.1.2"),
    "exact": ("Chords to a tolerance", "farthest point of each piece from its chord; pieces by log4(area / tolerance)"),
}
SIDE = 24
"""Points along each side of a cell by which four triangles are measured."""

IN_CELL = "on the image of each arc at 17 points"


def position(plane: Plane, drawn: Drawn, method: str) -> Accuracy:
    """Errors of the values as displacements of the points, and what the drawing itself leaves.

    Parameters
    ----------
    plane, drawn : where the lines are, and the lines
    method : of the drawing

    Accuracy: displacement = error / slope, to first order; flagged where that fails.
    """
    slope = plane.slope(drawn)
    values = plane.at(drawn)
    accuracy = values.push(scaling(1 / np.maximum(slope, FLATTEST)), quantity="position", unit=plane.unit)
    if method == "four_triangles":
        terms = _sampled(plane, drawn, slope) if isinstance(plane, Rectangle) else ()
    else:
        terms = _drawing(plane, drawn, method)
    return accuracy.add(*terms).flag(*_too_curved(plane, drawn, values, slope))


def _drawing(plane: Plane, drawn: Drawn, method: str) -> tuple[Term, ...]:
    n, segments = len(drawn.points), len(drawn.segments)
    area, reach, longer = plane.left(drawn)
    farthest = np.zeros(n)
    np.maximum.at(farthest, drawn.segments.ravel(), np.repeat(reach, 2))
    name, rule = CHORDS["triangles" if isinstance(plane, Triangles) else method]
    bent = "" if plane.exact else f", {IN_CELL}"
    chord = Source(name, "mapping", "proven" if plane.exact else "estimated", f"{rule}{bent} [arc-sagitta/1]")
    beside = Source(
        "Area between line and contour", "mapping", "exact" if plane.exact else "estimated",
        f"|K| (sinh w - w) of each arc; Lopes 1999, 3.5.1{bent} [arc-area/1]",
    )  # fmt: skip
    length = Source(
        "Contour longer than its line", "mapping", "exact" if plane.exact else "estimated",
        f"length of each arc by quadrature; Lopes 1999, 3.5.1{bent} [arc-length/1]",
    )  # fmt: skip
    joined = "asymptotic decider without division; Lopes 1999, 3.2.1 [decider/1]"
    joining = Source("Joining of the lines", "mapping", "exact", joined)
    square = f"{plane.unit}²" if plane.unit else ""
    return (
        Term(chord, "bound", "position", plane.unit, farthest, Identity(n)),
        Term(beside, "metric", "area", square, area, Identity(segments), "segment"),
        Term(length, "metric", "length", plane.unit, longer, Identity(segments), "segment"),
        Term(joining, "bound", "position", plane.unit, np.asarray(0.0), Identity(n)),
    )


def _sampled(plane: Rectangle, drawn: Drawn, slope: Floats) -> tuple[Term, ...]:
    """Four triangles: the bilinear field at the points, and the part of each cell where the two take other sides."""
    row, column, u, v = plane.within(drawn.points, drawn.cell[drawn.of_point] if len(drawn.cell) else drawn.cell)
    f00, f10, f01, f11 = plane.corners(row, column)
    here = (1 - u) * (1 - v) * f00 + u * (1 - v) * f10 + (1 - u) * v * f01 + u * v * f11
    away = "bilinear value less the level, over the slope [four-triangles/1]"
    off = Source("Four triangles a cell", "mapping", "estimated", away)
    beside = Source("Area between line and contour", "mapping", "sampled", f"{SIDE**2} points a cell [side-by-points/1]")
    square = f"{plane.unit}²" if plane.unit else ""
    error, n = (here - drawn.level) / np.maximum(slope, FLATTEST), len(here)
    area = _side_by_points(plane, drawn)
    return (
        Term(off, "signed", "position", plane.unit, error, Identity(n)),
        Term(beside, "metric", "area", square, area, Identity(len(area)), "segment"),
    )


def _side_by_points(plane: Rectangle, drawn: Drawn) -> Floats:
    """(s,) area of each cell where four triangles and the bilinear field are on other sides, shared by its segments."""
    pair, which, shared = np.unique(
        np.column_stack([drawn.cell, drawn.segment_level]), axis=0, return_inverse=True, return_counts=True
    )
    row, column = np.divmod(pair[:, 0].astype(np.int64), len(plane.axes[0]) - 1)
    corner = [f - pair[:, 1] for f in plane.corners(row, column)]
    t = (np.arange(SIDE) + 0.5) / SIDE
    differ = np.zeros(len(pair))
    for u in t:
        for v in t:
            differ += (_bilinear(corner, u, v) >= 0) != (_four(corner, u, v) >= 0)
    size = np.diff(plane.axes[0])[column] * np.diff(plane.axes[1])[row] / np.prod(plane.measure)
    return np.asarray((differ / SIDE**2 * size / shared)[which.ravel()])


def _bilinear(f: Sequence[Floats], u: float, v: float) -> Floats:
    return (1 - v) * ((1 - u) * f[0] + u * f[1]) + v * ((1 - u) * f[2] + u * f[3])


def _four(f: Sequence[Floats], u: float, v: float) -> Floats:
    """The field of four triangles about the mean."""
    p, q = u - 0.5, v - 0.5
    t = 2 * max(abs(p), abs(q))
    if abs(q) >= abs(p):
        low, high, along = (f[0], f[1], p) if q < 0 else (f[2], f[3], p)
    else:
        low, high, along = (f[0], f[2], q) if p < 0 else (f[1], f[3], q)
    return (1 - t) * (f[0] + f[1] + f[2] + f[3]) / 4 + t * (low + high) / 2 + along * (high - low)


def _too_curved(plane: Plane, drawn: Drawn, values: Accuracy, slope: Floats) -> list[Flag]:
    """The points where error / slope is no longer the displacement: kappa above 0.4."""
    if not len(drawn.points):
        return []
    error = values.total(1.0, "value")
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        kappa = np.where(error > 0, error * plane.bending(drawn) / slope**2, 0.0)
    bad = np.flatnonzero(~(kappa <= VALID))
    if not len(bad):
        return []
    words = f"the slope is too small for the error at {len(bad)} of {len(kappa)} points: a line may lie farther, or not exist"
    return [Flag("kappa", words, "point", bad, np.nan_to_num(kappa[bad], nan=np.inf))]


def joins_at_risk(plane: Plane, lines: Sequence[ContourLines], levels: Sequence[float], drawn: Drawn) -> list[Flag]:
    """Segments of cells whose saddle may decide otherwise, by the errors that are known.

    A cell is flagged when proven and estimated errors of the value reach from the saddle to the level, or when the
    random ones flip the sign of N = f00 f11 - f10 f01 with a probability above 5 %: Phi(-|N| / sigma_N), to first order.
    """
    if isinstance(plane, Triangles) or not any(len(d.saddle_cell) for d in lines):
        return []
    cells, count = np.concatenate([d.saddle_cell for d in lines]), [len(d.saddle_cell) for d in lines]
    known = plane.known(plane.saddles(cells))
    reach = known.total(0.0, "value")  # bounds and estimates; the random part has its own rule
    risk = np.where(np.concatenate([d.saddle_margin for d in lines]) <= reach, 1.0, 0.0)
    chance = np.concatenate([_flips(plane, d.saddle_cell, level) for d, level in zip(lines, levels, strict=True)])
    at_risk = (risk > 0) | (chance > SURE)
    if not at_risk.any():
        return []
    level_of = np.repeat(np.asarray(levels, float), count)
    hit, likely = [], []
    for level in np.unique(level_of[at_risk]):
        mine = at_risk & (level_of == level)
        segments = np.flatnonzero((drawn.segment_level == level) & np.isin(drawn.cell, cells[mine]))
        table = dict(zip(cells[mine].tolist(), chance[mine].tolist(), strict=True))
        hit.append(segments)
        likely += [table[c] for c in drawn.cell[segments].tolist()]
    words = f"the saddle of {int(at_risk.sum())} cells is closer to the level than the known errors: lines may join otherwise"
    most = float(chance[at_risk].max())
    words += f", by noise alone with a probability up to {most:.0%}" if most > SURE else ""
    return [Flag("topology at risk", words, "segment", np.concatenate(hit), np.asarray(likely))]


def _flips(plane: Rectangle, cells: Ints, level: float) -> Floats:
    """Probability that the samples' random errors change the sign that joins the corners of each cell."""
    number, derivative = plane.decider(cells, level)
    samples = plane.model.samples.accuracy
    random = Accuracy(tuple(t for t in samples.select("value", "point") if t.kind in ("linear", "members")))
    if not random.terms or not len(cells):
        return np.zeros(len(cells))
    sigma = random.push(derivative).total(1.0, "value")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(sigma > 0, ndtr(-np.abs(number) / np.where(sigma > 0, sigma, 1.0)), 0.0)


def too_thin(
    accuracy: Accuracy, drawn: Drawn, points: Floats, values: Accuracy, levels: Sequence[float], k: float = 2.0
) -> list[Flag]:
    """Lines that are thinner than their error: closed ones smaller than it, and neighbours closer than twice it.

    Neighbouring lines lie gap / slope apart and each may move by error / slope: they may swap where 2 error > gap.
    """
    if not len(drawn.points):
        return []
    error = values.total(k, "value")
    gap = float(np.min(np.diff(levels))) if len(levels) > 1 else np.inf
    close = np.flatnonzero(2 * error > gap)
    small = _small_loops(drawn, points, accuracy.total(k, "position"))
    flags = []
    if len(close):
        words = f"twice the error of the values exceeds the step of the levels at {len(close)} of {len(error)} points"
        flags.append(Flag("lines closer than their errors", words, "point", close))
    if len(small):
        words = f"{len(small)} closed lines are smaller than their error: what they enclose may not exist"
        flags.append(Flag("thinner than the error", words, "cell", small))
    return flags


def _small_loops(drawn: Drawn, points: Floats, error: Floats) -> Ints:
    """Closed lines whose extent is below twice the median error of their points."""
    lines = drawn.lines
    small = []
    for i, (a, b) in enumerate(zip(lines.offsets[:-1], lines.offsets[1:], strict=True)):
        ids = lines.connectivity[a:b]
        if b - a > 2 and ids[0] == ids[-1]:
            extent = float(np.linalg.norm(np.ptp(points[ids], axis=0)))
            if extent < 2 * float(np.median(error[ids])):
                small.append(i)
    return np.asarray(small, np.int64)
