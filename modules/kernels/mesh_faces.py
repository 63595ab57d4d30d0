"""The area between the sides of triangles that lie in faces of cells and the arcs of the surface there.

Source: Lopes 1999, 3.4, in closed form (`arcs.area`).
"""

import numpy as np

from modules.kernels import arcs
from modules.kernels.marching_cases import Floats, Integers
from modules.kernels.mesh_proof import Field
from modules.kernels.mesh_split import edges_of


def areas(field: Field, points: Floats, triangles: Integers, cell: Integers) -> Floats:
    """(m, 3) the area beside each side of each triangle; nan for sides within a cell.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,)
    """
    edges = edges_of(field, points, triangles, cell)
    size = np.full(len(edges.ends), np.nan)
    for axis in range(3):
        which = np.flatnonzero(edges.axis == axis)
        size[which] = _beside(field, points[edges.ends[which]], edges.cell[which], axis)
    return np.asarray(size[edges.of])


def _beside(field: Field, ends: Floats, cell: Integers, axis: int) -> Floats:
    """Areas of sides (k, 2, 3) in faces across an axis."""
    along = [field.x, field.y, field.z]
    nx, ny = len(field.x), len(field.y)
    row, i = np.divmod(cell, nx - 1)
    k, j = np.divmod(row, ny - 1)
    place = np.stack([i, j, k])
    place[axis] += ends[:, 0, axis] > 0.5 * (along[axis][place[axis]] + along[axis][place[axis] + 1])
    b, c = (a for a in range(3) if a != axis)
    step = np.array([1, nx, nx * ny])
    node = step @ place
    f00, f10, f01, f11 = (field.values[node + db * step[b] + dc * step[c]] for dc in (0, 1) for db in (0, 1))
    low = along[b][place[b]]
    share = (ends[:, :, b] - low[:, None]) / (along[b][place[b] + 1] - low)[:, None]
    slope = (1 - share) * (f01 - f00)[:, None] + share * (f11 - f10)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = np.log(slope[:, 1] / slope[:, 0])
    bend = np.where(np.isfinite(bend), bend, 0.0)
    d = ends[:, 1] - ends[:, 0]
    return np.asarray(arcs.area(d[:, b], d[:, c], bend))


def of_triangles(sides: Floats, cell: Integers, whole: bool) -> Floats:
    """(m,) one number a triangle: of its own sides in faces, or the mean of its cell where it has none; or of the whole cell.

    Parameters
    ----------
    sides : (m, 3) of `areas`
    whole : the sum over all faces of the cell
    """
    own = np.nansum(sides, axis=1)
    has = ~np.isnan(sides).all(axis=1)
    _, ids = np.unique(cell, return_inverse=True)
    total, count = np.bincount(ids, own), np.bincount(ids, has)
    if whole:
        return np.asarray(total[ids])
    return np.where(has, own, (total / np.maximum(count, 1))[ids])
