"""What is known of where an isosurface lies: errors of the values, distance of the triangles, and the flags."""

from __future__ import annotations

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

EXACT_TOPOLOGY = "asymptotic decider and inflection points; Lopes 1999, 4.2 [accurate-cells/1]"


def position(
    model: Model, axes: tuple[Floats, ...], level: float, points: Floats, triangles: Ints, cell: Ints, method: str, unit: str,
    most: float = np.inf, slabs: Any = None,
) -> tuple[Accuracy, Floats]:
    """Errors of the values as displacements of the points, and the proven distance of the triangles.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,)
    unit : of lengths
    most : a distance that the method never exceeds
    slabs : shares the proof, as `Progress.map` does

    Returns
    -------
    Accuracy; (m,) proven distance, nan where there is none

    Accuracy: displacement = error / |grad F|, to first order; flagged where that fails.
    """
    values = np.asarray(model.samples.values, float)
    reach, slope = kernels.marching_distance.distances(values, *axes, level, points, triangles, cell, slabs=slabs)
    reach = np.minimum(reach, most)
    accuracy = displaced(model, points, model.at(points)[1], slope, unit)
    proven = np.isfinite(reach)
    farthest = np.zeros(len(points))
    np.maximum.at(farthest, triangles.ravel(), np.repeat(np.where(proven, reach, 0.0), 3))
    source = Source(
        "Triangles instead of the curved surface", "mapping", "proven",
        "Bernstein coefficients over the least slope in the swept box; largest of the triangles at a point [triangle-reach/1]",
    )  # fmt: skip
    terms = [Term(source, "bound", "position", unit, farthest, Identity(len(points)))]
    if method == "accurate":
        terms.append(exact_topology(len(points), unit, EXACT_TOPOLOGY))
    return accuracy.add(*terms).flag(*_unproven(proven)), np.where(proven, reach, np.nan)


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


def _unproven(proven: NDArray[np.bool_]) -> list[Flag]:
    bad = np.flatnonzero(~proven)
    if not len(bad):
        return []
    words = f"no distance could be proven for {len(bad)} of {len(proven)} triangles: the slope may vanish beside them"
    return [Flag("unproven", words, "cell", bad)]


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
