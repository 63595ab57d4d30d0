"""The grid cells that contour lines pass, each with the area that the lines leave in it (thesis 3.5.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules.accuracy_mappers import _cells
from modules.api import Accuracy, Cells, Field, Geometry, Matrix, Model, Shown, Term, accuracy_mapper

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@accuracy_mapper("Error background", aliases=("area metric", "cell error", "contour error", "grey background"), output="cells")
def background(lines: Geometry, model: Model, accuracy: Accuracy | None = None) -> Geometry:
    """The cells that contour lines pass, as polygons whose value "area" is what the lines leave in each.

    To be drawn below the lines by the renderer 'surface', coloured by "area" and half transparent. The lines themselves
    are not changed.

    Parameters
    ----------
    lines : contour lines
    model : the model that they were drawn of, for its grid
    accuracy : of the same lines; their own by default

    Raises
    ------
    ValueError : the lines are not contour lines, or not of this model

    Accuracy: shows the area between line and contour. That term goes on, the segments of a cell added up; all other terms
        of lines and model end here, for the background shows nothing of them.
    Source: Lopes 1999, 3.5.2 (a solid but transparent background, the metric of each cell).
    """
    shown = lines.accept(accuracy)
    term = _cells.area_of(lines, shown, "an error background")
    which, cell = np.unique(np.asarray(lines.values["grid cell"].values, np.int64), return_inverse=True)
    points, polygons = _cells.corners(model.grid, which)
    _same_place(lines, cell, points, polygons)
    per_cell = _sums(term, cell, len(which))
    why = "the background shows the area between line and contour only"
    only = Accuracy((per_cell,), shown.missing, (), shown.ended)
    ended = only.end_from(shown, why).end_from(lines.accuracy, why).end_from(model.accuracy, why)
    return Geometry(
        points=points,
        polygons=polygons,
        values={"area": Field(per_cell.size(), "cell", term.unit)},
        origin=which,
        shows=(Shown(term.name, "area", "per cell"),),
        cell=lines.cell,
        frame=model.grid.frame,
        name=lines.name,
        time=lines.time,
        accuracy=ended.miss(*model.accuracy.missing),
    )


def _sums(term: Term, cell: Ints, n: int) -> Term:
    """The term with a row a cell: the sum over its segments."""
    entries = csr_array((np.ones(len(cell)), (cell, np.arange(len(cell)))), shape=(n, term.count))
    return term.push(Matrix(entries), place="cell")


def _same_place(lines: Geometry, cell: Ints, corners: Floats, polygons: Cells) -> None:
    """Each segment must lie in its cell: the model of another place has cells of these numbers too."""
    if not len(cell):
        return
    at, starts = corners[polygons.connectivity, :2], polygons.offsets[:-1]
    low, high = np.minimum.reduceat(at, starts)[cell], np.maximum.reduceat(at, starts)[cell]
    middle, slack = lines.points[lines.segments(), :2].mean(axis=1), 1e-6 * (high - low)
    if not ((middle >= low - slack) & (middle <= high + slack)).all():
        raise ValueError("the lines do not lie in the cells of the model: wire the model that they were drawn of")
