"""The point G of each triangle of an isosurface, with lines to its corners (thesis, figure 4.40)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.accuracy_mappers import _triangles
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    Model,
    Progress,
    Range,
    Shown,
    Source,
    Term,
    accuracy_mapper,
)

Floats = NDArray[np.float64]

NAME = "Triangle, by its proven distance"
RULE = "the distance that was proven for each triangle; its point G alone would say less than the truth [triangle-reach/1]"
WHY = "the lines show how far each triangle may be from the surface, and nothing else"


@accuracy_mapper("G lines", aliases=("point G", "centroid", "thesis 4.40", "triangle error", "needle"), output="lines")
def centre_lines(
    surface: Geometry,
    model: Model,
    progress: Progress,
    *,
    above: Annotated[float, Range(0, 0.5, unit="cell")] = 0.0,
) -> Geometry:
    """Three lines a triangle, from its corners to the point G of the surface that lies off its centroid along the gradient.

    A flat star is a triangle that lies close there. G underestimates, so the number that goes with the lines is the
    proven distance of the triangle.

    Parameters
    ----------
    surface : of 'isosurface' or 'refine_surface', in triangles
    model : of which it was drawn
    above : only triangles whose proven distance is larger, as a part of a cell

    Raises
    ------
    ValueError : no triangles that know their cell, level and distance, or not of this model

    Accuracy: G lies on the surface of the model, to rounding; the lines carry the proven distance of their triangle.
        Triangles for which nothing is proven, and those whose line meets no surface within the cell, have no lines and
        are told. All terms of the surface end here.
    Source: Lopes 1999, 4.4, second approach and figure 4.40; with the proven distance in place of that of G.
    """
    mesh = _triangles.of(surface, model, "G lines")
    centre, away = np.empty((len(mesh.cell), 3)), np.full(len(mesh.cell), -1.0)
    for level in np.unique(mesh.level):
        here = np.flatnonzero(mesh.level == level)
        field = kernels.mesh_proof.Field(mesh.values, *mesh.axes, float(level))
        centre[here], away[here] = kernels.mesh_centre.centres(
            field, surface.points, mesh.triangles[here], mesh.cell[here], slabs=progress.map
        )
    proven, found = np.isfinite(mesh.reach), away >= 0
    edge = surface.cell or 1.0
    kept = np.flatnonzero(proven & found & (mesh.reach > above * edge))
    points = np.concatenate([surface.points[mesh.triangles[kept]].reshape(-1, 3), centre[kept]])
    n = 3 * len(kept)
    lines = np.column_stack([np.arange(n), n + np.repeat(np.arange(len(kept)), 3)])
    source = Source(NAME, "mapping", "proven", RULE)
    reach = np.repeat(mesh.reach[kept], 3)
    own = Accuracy((Term(source, "bound", "position", mesh.unit, reach, Identity(n), "cell"),), surface.accuracy.missing)
    return Geometry(
        points=points,
        lines=Cells.of(lines),
        values={
            "distance": Field(reach, "cell", mesh.unit),
            "distance of G": Field(np.repeat(away[kept], 3), "cell", mesh.unit),
        },
        origin=np.repeat(kept, 3),
        shows=(Shown(NAME, "position", "three lines to the point G"),),
        cell=surface.cell,
        frame=surface.frame,
        name=surface.name,
        time=surface.time,
        accuracy=own.flag(*_flags(proven, found)).end_from(surface.accuracy, WHY).end_from(model.accuracy, WHY),
    )


def _flags(proven: NDArray[np.bool_], found: NDArray[np.bool_]) -> list[Flag]:
    flags = []
    if not proven.all():
        words = f"{int((~proven).sum())} of {len(proven)} triangles have no lines: nothing is proven of them"
        flags.append(Flag("unproven", words, "cell"))
    lost = int((proven & ~found).sum())
    if lost:
        words = f"{lost} of {len(found)} triangles have no point G: the line from their centroid meets no surface in the cell"
        flags.append(Flag("no point G", words, "cell"))
    return flags
