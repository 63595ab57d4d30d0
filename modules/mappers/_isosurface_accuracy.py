"""What is known of where an isosurface lies: errors of the values, distance of the triangles, and the flags."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.data.accuracy import Accuracy, Flag, Source, Term
from modules.data.laws import curvature
from modules.data.operators import Identity, scaling
from modules.data.wires import Model
from modules.mappers._contour_accuracy import FLATTEST, VALID

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ONE_WAY = (
    "Bernstein coefficients over the least slope in the swept box, else the way to an edge that the surface crosses; largest "
    "of the triangles at a point [triangle-reach/2]"
)
BOTH_WAYS = ONE_WAY + "; and from the surface to the triangles, by boxes in which it is a graph [surface-reach/1]"
SLACK = 2.0**-44
"""Of the numbers involved: what rounding may add."""

EXACT_TOPOLOGY = "asymptotic decider and inflection points; Lopes 1999, 4.2 [accurate-cells/1]"


def position(
    model: Model, axes: tuple[Floats, ...], level: float, points: Floats, triangles: Ints, cell: Ints, method: str, unit: str,
    most: float = np.inf, slabs: Any = None, both: bool = False,
) -> tuple[Accuracy, Floats]:
    """Errors of the values as displacements of the points, and the proven distance of the triangles.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,)
    unit : of lengths
    most : a distance that the method never exceeds
    slabs : shares the proof, as `Progress.map` does
    both : whether the distance counts the other way round too, from the surface to the triangles of a cell

    Returns
    -------
    Accuracy; (m,) proven distance

    Accuracy: displacement = error / |grad F|, to first order; flagged where that fails.
    """
    values = np.asarray(model.samples.values, float)
    reach, slope = kernels.marching_distance.distances(values, *axes, level, points, triangles, cell, slabs=slabs)
    finely = np.isfinite(reach)
    reach[~finely] = coarse(values, axes, level, points, triangles[~finely], cell[~finely])
    reach = np.minimum(reach, most)
    accuracy = displaced(model, points, model.at(points)[1], slope, unit)
    if both:
        back = kernels.marching_reverse.distances(values, *axes, level, points, triangles, cell, reach, slabs=slabs)
        reach = np.maximum(reach, back)
    farthest = np.zeros(len(points))
    np.maximum.at(farthest, triangles.ravel(), np.repeat(reach, 3))
    source = Source("Triangles instead of the curved surface", "mapping", "proven", BOTH_WAYS if both else ONE_WAY)
    terms = [Term(source, "bound", "position", unit, farthest, Identity(len(points)))]
    if method == "accurate":
        terms.append(exact_topology(len(points), unit, EXACT_TOPOLOGY))
    return accuracy.add(*terms).flag(*_coarsely(finely)), reach


def coarse(values: Floats, axes: tuple[Floats, ...], level: float, points: Floats, triangles: Ints, cell: Ints) -> Floats:
    """A distance that no point of a triangle exceeds, proven without the slope: (m,).

    The surface crosses each edge of the cell of which one end is below the level and the other is not: no point of a triangle
    is farther from there than its farthest corner.
    """
    corner = points[triangles]
    row, i = np.divmod(cell, len(axes[0]) - 1)
    k, j = np.divmod(row, len(axes[1]) - 1)
    low, high = (np.stack([axis[n + side] for axis, n in zip(axes, (i, j, k), strict=True)], axis=1) for side in (0, 1))
    best = np.linalg.norm(high - low, axis=1)
    for along, a, b in itertools.product(range(3), (0, 1), (0, 1)):
        start = np.insert([a, b], along, 0)
        stop = np.insert([a, b], along, 1)
        f0, f1 = (values[k + at[2], j + at[1], i + at[0]] for at in (start, stop))
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (level - f0) / (f1 - f0)
        place = np.where(start, high, low)
        place[:, along] += share * (high - low)[:, along]
        away = np.linalg.norm(corner - place[:, None], axis=2).max(axis=1)
        best = np.where((f0 >= level) != (f1 >= level), np.fmin(best, away), best)
    return np.asarray(best * (1 + SLACK) + SLACK * max(float(np.abs(axis).max()) for axis in axes))


def displaced(model: Model, points: Floats, known: Accuracy, slope: Floats, unit: str) -> Accuracy:
    """Errors of the values at points as displacements along the normal, with a flag where that is too rough.

    Parameters
    ----------
    points : (n, 3) in the model's frame
    known : of the values there
    slope : (n,) |grad F|, in the unit of lengths `unit`
    """
    accuracy = known.push(scaling(1 / np.maximum(slope, FLATTEST)), quantity="position", unit=unit)
    return accuracy.flag(*_too_curved(model, points, known, slope))


def exact_topology(n: int, unit: str, rule: str) -> Term:
    """A term that says that the topology is the model's."""
    source = Source("Topology of the surface", "mapping", "exact", rule)
    return Term(source, "bound", "position", unit, np.asarray(0.0), Identity(n))


def _coarsely(finely: NDArray[np.bool_]) -> list[Flag]:
    rough = np.flatnonzero(~finely)
    if not len(rough):
        return []
    words = f"only a coarse distance is proven for {len(rough)} of {len(finely)} triangles: the slope may vanish beside them"
    return [Flag("coarse", words, "cell", rough)]


def _too_curved(model: Model, points: Floats, known: Accuracy, slope: Floats) -> list[Flag]:
    """The points where error / slope is no longer the displacement: kappa above 0.4."""
    if not len(points) or not known.select("value", "point"):
        return []
    error = known.total(1.0, "value")
    bend = np.abs(np.nan_to_num(curvature(model.grid, np.asarray(model.samples.values, float), points))).max(axis=1)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        kappa = np.where(error > 0, error * bend / slope**2, 0.0)
    bad = np.flatnonzero(~(kappa <= VALID))
    if not len(bad):
        return []
    words = f"the slope is too small for the error at {len(bad)} of {len(kappa)} points: it may lie elsewhere, or not exist"
    return [Flag("kappa", words, "point", bad, np.nan_to_num(kappa[bad], nan=np.inf))]
