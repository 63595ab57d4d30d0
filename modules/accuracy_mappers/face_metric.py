"""The area metric of contours in the faces of cells, brought to the triangles of an isosurface (thesis 4.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.accuracy_mappers import _triangles
from modules.api import Field, Geometry, Identity, Literal, Model, Progress, Shown, Source, Term, accuracy_mapper

Floats = NDArray[np.float64]

NAME = "Area beside the surface in faces"
RULE = "|K (sinh w - w)| in the faces of cells; Lopes 1999, 4.4 with 3.4 in closed form [face-area/1]"


@accuracy_mapper("Face metric", aliases=("area metric in 3-D", "texture", "thesis 4.4", "isosurface error"), output="surface")
def face_metric(
    surface: Geometry, model: Model, progress: Progress, *, of: Literal["sides", "cell"] = "sides"
) -> Geometry:
    """The same surface with a number a triangle: the area that its sides leave beside the exact arcs in the faces of cells.

    Choose 'face metric' in the surface renderer to see it as colour. It ranks triangles only roughly, for it sees nothing of
    what lies within a cell: the proven distance is the number to trust.

    Parameters
    ----------
    surface : of 'isosurface' or 'refine_surface', in triangles
    model : of which it was drawn
    of : sides (of the triangle's own sides in faces; a triangle that has none gets the mean of its cell's triangles that
        do), or cell (of all faces of its cell)

    Raises
    ------
    ValueError : no triangles that know their cell, level and distance, or not of this model

    Accuracy: the area in each face is exact, in closed form; that it stands for the triangle is the thesis's proposal, and
        no bound. What is known of the surface goes on.
    Source: Lopes 1999, 4.4, first approach; which faces a triangle answers for is ours.
    """
    mesh = _triangles.of(surface, model, "face metrics")
    metric = np.zeros(len(mesh.cell))
    for n, level in enumerate(np.unique(mesh.level)):
        progress(n / len(np.unique(mesh.level)))
        here = np.flatnonzero(mesh.level == level)
        field = kernels.mesh_proof.Field(mesh.values, *mesh.axes, float(level))
        sides = kernels.mesh_faces.areas(field, surface.points, mesh.triangles[here], mesh.cell[here])
        metric[here] = kernels.mesh_faces.of_triangles(sides, mesh.cell[here], whole=of == "cell")
    unit = f"{mesh.unit}²" if mesh.unit else ""
    source = Source(NAME, "mapping", "exact", RULE)
    term = Term(source, "metric", "area", unit, metric, Identity(len(metric)), "cell")
    return replace(
        surface,
        values={**surface.values, "face metric": Field(metric, "cell", unit)},
        shows=(*surface.shows, Shown(NAME, "area", "in the faces of its cell" if of == "cell" else "beside its own sides")),
        accuracy=surface.accuracy.add(term).end_from(model.accuracy, "the surface knows what the errors of the model do to it"),
    )
