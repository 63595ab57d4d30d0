"""How far two surfaces lie from each other: signed distances on the first, and mean, rms and Hausdorff distance both ways."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Field,
    Geometry,
    Identity,
    NamedTuple,
    Progress,
    Range,
    Shown,
    Source,
    Table,
    Term,
    accuracy_mapper,
)

Floats = NDArray[np.float64]

RULE = "distance of each point of the first surface to the nearest triangle of the second [surface-difference/1]"
WHY = "what lies between two drawings says how they differ, not how far either may be trusted"
POINTS_A_SLAB = 1 << 14


class Difference(NamedTuple):
    """The first surface with its distances from the second, and the numbers of both ways."""

    surface: Geometry
    table: Table


@accuracy_mapper("Difference of surfaces", aliases=("Hausdorff", "compare isosurfaces", "mesh distance", "method difference"))
def surface_difference(
    first: Geometry,
    second: Geometry,
    progress: Progress,
    *,
    points: Annotated[int, Range(1_000, 1_000_000, log=True)] = 20_000,
    seed: int = 1,
    called: str = "Difference of two surfaces",
) -> Difference:
    """How far two surfaces lie apart: by two methods, with and without refinement, before and after a filter.

    Each point of the first surface gets its distance from the second, above zero on the side to which the second looks. The
    table has mean, root mean square and largest distance from the first to the second and back, of points spread evenly; the
    larger of the two largest is the Hausdorff distance, from below.

    Parameters
    ----------
    first, second : surfaces in the same space
    points : spread on each surface for the table, beside its own points for the largest distance
    seed : of the chance
    called : what legends call it; two differences in one picture need two names

    Raises
    ------
    ValueError : a surface without triangles, or axes of different units

    Accuracy: the distance at each point is exact, to rounding; the largest of the table is that of the points looked at, and
        so never more than the true one. Where the nearest place lies on an open border the sign says nothing. All terms of
        both surfaces end here.
    Source: Cignoni, Rocchini and Scopigno 1998 (Metro: distances both ways by samples); distances by VTK.
    """
    if points < 1:
        raise ValueError(f"points must be at least 1, not {points}")
    for geometry, name in ((first, "first"), (second, "second")):
        if not len(geometry.triangles):
            raise ValueError(f"the {name} surface has no triangles: there is nothing to compare")
    unit = first.frame.length_unit(3) or ""
    random = np.random.default_rng(seed)
    own = _away(first.points, second, progress.part(0.0, 0.4))
    there = _away(_spread(first, points, random), second, progress.part(0.4, 0.7))
    back = _away(np.concatenate([_spread(second, points, random), second.points]), first, progress.part(0.7, 1.0))
    rows = ((there, np.abs(own).max()), (back[:points], np.abs(back).max()))
    term = Term(Source(called, "mapping", "exact", RULE), "signed", "length", unit, own, Identity(len(own)))
    ended = Accuracy((term,)).end_from(first.accuracy, WHY).end_from(second.accuracy, WHY)
    ended = ended.miss(*first.accuracy.missing, *second.accuracy.missing)
    shown = replace(
        first,
        values={**first.values, "difference": Field(own, "point", unit)},
        shows=(Shown(called, "length", "from the first to the second"),),
        accuracy=ended,
    )
    table = {
        "from": np.array(["first to second", "second to first"]),
        "mean": np.array([np.abs(d).mean() for d, _ in rows]),
        "rms": np.array([np.sqrt((d**2).mean()) for d, _ in rows]),
        "largest": np.array([max(np.abs(d).max(), most) for d, most in rows]),
        "mean with sign": np.array([d.mean() for d, _ in rows]),
    }
    units = dict.fromkeys(list(table)[1:], unit) if unit else {}
    bare = Accuracy().end_from(first.accuracy, WHY).end_from(second.accuracy, WHY)
    bare = bare.miss(*first.accuracy.missing, *second.accuracy.missing)
    return Difference(shown, Table(columns=table, units=units, name=called, accuracy=bare))


def _spread(surface: Geometry, count: int, random: np.random.Generator) -> Floats:
    """Points spread evenly over the triangles."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = area.sum()
    which = random.choice(len(area), count, p=area / total if total > 0 else None)
    u, v = random.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return np.asarray(a[which] + u * (b - a)[which] + v * (c - a)[which])


def _away(points: Floats, surface: Geometry, progress: Progress) -> Floats:
    """Signed distances of points from a surface, above zero where it looks."""
    import pyvista
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

    triangles = surface.triangles
    mesh: Any = pyvista.PolyData(surface.points, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(mesh)
    found = np.empty(len(points))
    for start in range(0, len(points), POINTS_A_SLAB):
        progress(start / len(points))
        part = numpy_to_vtk(np.ascontiguousarray(points[start : start + POINTS_A_SLAB]), deep=1)
        out = numpy_to_vtk(np.zeros(len(points[start : start + POINTS_A_SLAB])), deep=1)
        distance.FunctionValue(part, out)
        found[start : start + POINTS_A_SLAB] = vtk_to_numpy(out)
    return found
