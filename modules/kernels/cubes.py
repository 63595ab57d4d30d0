"""Surfaces by cubes: cuberille (faces of voxels), discretized marching cubes, dividing cubes, and brute subdivision.

For comparison with `marching`. A node on the level counts as above it; normals point to the low side.

Source: Herman and Liu 1979 (cuberille); Montani, Scateni and Scopigno 1994 (discretized); Cline, Lorensen, Ludke, Crawford
and Teeter 1988 (dividing cubes); Lopes 1999, 2.4.5 and 4.1.
"""

import numpy as np
import numpy.typing as npt

from modules.kernels.straight import Mesh, active, surface

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def cuberille(values: Floats, x: Floats, y: Floats, z: Floats, level: float) -> Mesh:
    """The faces between samples above and below, each sample being a box to half way to its neighbours.

    Faces are cut where cells meet, so that each triangle lies in one cell. Samples that are not finite have no faces.

    Accuracy: each point is within half a diagonal of a cell of the surface, which passes between the two samples.
    """
    axes = (x, y, z)
    ticks = [np.sort(np.concatenate([a, 0.5 * (a[1:] + a[:-1])])) for a in axes]
    nx, ny = len(ticks[0]), len(ticks[1])
    step = np.array([1, nx, nx * ny])
    keys, origin = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    index = np.indices(values.shape)[::-1]  # x, y, z
    for axis in range(3):
        d = 2 - axis
        low, high = (np.take(values, np.arange(n, values.shape[d] - 1 + n), d) for n in (0, 1))
        differ = ((low >= level) != (high >= level)) & np.isfinite(low) & np.isfinite(high)
        where = np.array([np.take(i, np.arange(values.shape[d] - 1), d)[differ] for i in index]).T
        falls = (low >= level)[differ]
        p, q = ((axis + 1) % 3, (axis + 2) % 3)
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):  # the quarter of the face towards these cells
            cell = where.copy()
            cell[:, p], cell[:, q] = where[:, p] - 1 + u, where[:, q] - 1 + v
            inside = (cell >= 0).all(axis=1) & (cell < np.array(values.shape[::-1]) - 1).all(axis=1)
            here, corner = cell[inside], 2 * where[inside]
            corner[:, axis] += 1
            corner[:, p] += u - 1
            corner[:, q] += v - 1
            first = corner @ step
            quad = np.stack([first, first + step[p], first + step[p] + step[q], first + step[q]], axis=1)
            quad = np.where(falls[inside][:, None], quad, quad[:, ::-1])
            keys.append(quad[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3))
            number = (here[:, 2] * (values.shape[1] - 1) + here[:, 1]) * (values.shape[2] - 1) + here[:, 0]
            origin.append(np.repeat(number, 2))
    known, triangles = np.unique(np.concatenate(keys), return_inverse=True)
    row, i = np.divmod(known, nx)
    k, j = np.divmod(row, ny)
    points = np.column_stack([ticks[0][i], ticks[1][j], ticks[2][k]])
    return Mesh(points, triangles.reshape(-1, 3), np.concatenate(origin))


def discretized(values: Floats, x: Floats, y: Floats, z: Floats, level: float) -> Mesh:
    """Marching cubes whose crossings lie in the middle of edges: only thirteen directions of triangles.

    Accuracy: crossings are within half an edge of the true ones.
    """
    sides = np.where(np.isfinite(values), np.where(values >= level, 1.0, -1.0), np.nan)
    return surface(sides, x, y, z, 0.0, "four_triangles")


def refined(values: Floats, axes: tuple[Floats, Floats, Floats], cuts: int) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """Values and axes of the trilinear interpolant with each cell cut in cuts^3."""
    fine = []
    for axis, x in enumerate(axes):
        d = 2 - axis
        position = np.arange((len(x) - 1) * cuts + 1)
        i = np.minimum(position // cuts, len(x) - 2)
        t = (position - i * cuts) / cuts
        along = [1, 1, 1]
        along[d] = -1
        w = t.reshape(along)
        low, high = np.take(values, i, d), np.take(values, i + 1, d)
        values = np.where(w == 0, low, np.where(w == 1, high, (1 - w) * low + w * high))  # a hole stays where it is
        fine.append((1 - t) * x[i] + t * x[i + 1])
    return values, (fine[0], fine[1], fine[2])


def coarse_cell(cell: Integers, shape: tuple[int, ...], cuts: int) -> Integers:
    """The cell of a grid of a shape [z, y, x] to which each cell of its refinement belongs."""
    _, ny, nx = (n - 1 for n in shape)
    row, i = np.divmod(cell, nx * cuts)
    k, j = np.divmod(row, ny * cuts)
    result: Integers = (k // cuts * ny + j // cuts) * nx + i // cuts
    return result


def subdivided(values: Floats, x: Floats, y: Floats, z: Floats, level: float, cuts: int) -> Mesh:
    """Marching cubes with the asymptotic decider on a grid of cuts^3 boxes a cell: brute force."""
    fine, axes = refined(values, (x, y, z), cuts)
    mesh = surface(fine, *axes, level, "decider")
    return Mesh(mesh.points, mesh.triangles, coarse_cell(mesh.cell, values.shape, cuts))


def dividing(values: Floats, x: Floats, y: Floats, z: Floats, level: float, cuts: int) -> tuple[Floats, Integers]:
    """Dividing cubes: a point in the middle of each of the cuts^3 boxes a cell that the surface passes.

    Returns
    -------
    (n, 3), (n,)
        Points, and the grid cell of each.

    Accuracy: the surface passes each box, so a point is within half a diagonal of its box.
    """
    fine, axes = refined(values, (x, y, z), cuts)
    found = active(fine, level)
    ny, nx = fine.shape[1] - 1, fine.shape[2] - 1
    row, i = np.divmod(found.cell, nx)
    k, j = np.divmod(row, ny)
    middle = [0.5 * (a[1:] + a[:-1]) for a in axes]
    points = np.column_stack([middle[0][i], middle[1][j], middle[2][k]])
    return points, coarse_cell(found.cell, values.shape, cuts)
