"""Grid cells under contour lines: their corners, and the area that the lines leave in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Cells, Curvilinear, Geometry, Grid, Rectilinear, Regular, Term, Unstructured

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def area_of(lines: Geometry, shown: Accuracy, what: str) -> Term:
    """The term of the area between lines and exact contour, a row a segment.

    Raises
    ------
    ValueError : the lines are not contour lines that know their grid cells
    """
    found = [t for t in shown.select("area", "segment") if t.kind == "metric"]
    if not found or "grid cell" not in lines.values:
        raise ValueError(f"{what} needs contour lines that know their area and their cells: wire the lines of 'contour'")
    return found[0]


def corners(grid: Grid, cell: Ints) -> tuple[Floats, Cells]:
    """The corners of some cells of a flat grid: points, each once, and a polygon a cell.

    Parameters
    ----------
    cell : (m,) flat index of the cells, row-major over (ny - 1, nx - 1); number of the cell of an unstructured grid

    Raises
    ------
    ValueError : a cell that the grid does not have, or a grid that is not flat
    """
    if grid.dimensions != 2:
        raise ValueError(f"cells of the plane are needed; this grid has {grid.dimensions} dimensions: take a slice")
    if len(cell) and not 0 <= cell.min() <= cell.max() < grid.cells:
        raise ValueError(f"the lines pass cell {cell.max()} of a grid of {grid.cells} cells: wire the model they were drawn of")
    if isinstance(grid, Unstructured):
        lists = [grid.connectivity[grid.offsets[c] : grid.offsets[c + 1]] for c in cell]
        node = np.concatenate([*lists, np.zeros(0, np.int64)])
        sizes = np.array([len(one) for one in lists], np.int64)
    else:
        assert isinstance(grid, Regular | Rectilinear | Curvilinear)
        width = grid.shape[1]
        row, column = np.divmod(np.asarray(cell, np.int64), width - 1)
        first = row * width + column
        node = np.column_stack([first, first + 1, first + width + 1, first + width]).ravel()
        sizes = np.full(len(cell), 4, np.int64)
    used, place = np.unique(node, return_inverse=True)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    return grid.points()[used], Cells(offsets, place.astype(np.int64))
