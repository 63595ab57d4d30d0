"""The point G of a triangle: from its centroid along the gradient to the surface; and the thesis's recursion there.

A triangle becomes three at G, which lies on the surface. Edges are never cut, so what an edge is away stays: the recursion
stalls at the farthest edge, and its triangles become ever thinner.

Source: Lopes 1999, 4.4, second approach, figure 4.40.
"""

import math

import numpy as np

from modules.kernels._jit import lean
from modules.kernels.marching_cases import Floats, Integers, index
from modules.kernels.marching_distance import corners
from modules.kernels.mesh_proof import Field, Slabs, reaches, slope_in
from modules.kernels.mesh_split import Mesh, on_surface

TRIANGLES_A_SLAB = 1 << 13


@lean
def _centres(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats, triangle: Integers, cell: Integers,
    first: int, last: int, centre: Floats, away: Floats, room: Floats,
) -> None:
    """G of triangles first to last - 1, and how far it lies from the centroid; -1 where there is none."""
    f, low, size, s, d = room[0:8], room[8:11], room[11:14], room[14:17], room[17:20]
    for m in range(first, last):
        i, row = cell[m] % (x.size - 1), cell[m] // (x.size - 1)
        j, k = row % (y.size - 1), row // (y.size - 1)
        corners(values, x.size, y.size, i, j, k, f)
        low[0], low[1], low[2] = x[i], y[j], z[k]
        size[0], size[1], size[2] = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
        for a in range(3):
            s[a] = 0.0
            for c in range(3):
                s[a] += point[index(triangle[m, c]), a] / 3.0
        slope_in(f, (s[0] - low[0]) / size[0], (s[1] - low[1]) / size[1], (s[2] - low[2]) / size[2], size, d)
        steep, most = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2), math.sqrt(size[0] ** 2 + size[1] ** 2 + size[2] ** 2)
        for a in range(3):
            d[a] = d[a] / steep if steep > 0 else 0.0
            centre[m, a] = s[a]
        found = steep > 0 and on_surface(f, level, s, d, low, size, most)
        gap = 0.0
        for a in range(3):
            gap += (s[a] - centre[m, a]) ** 2
            centre[m, a] = s[a]
        away[m] = math.sqrt(gap) if found else -1.0


def centres(
    field: Field, points: Floats, triangles: Integers, cell: Integers, *, slabs: Slabs | None = None
) -> tuple[Floats, Floats]:
    """(m, 3) the point G of each triangle, and (m,) its distance from the centroid; -1 where the line meets no surface.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,)

    Accuracy: G lies on the surface to rounding; its distance says nothing of the rest of the triangle.
    """
    centre, away = np.empty((len(triangles), 3)), np.empty(len(triangles))
    at, ids, own = np.ascontiguousarray(points), np.ascontiguousarray(triangles), np.ascontiguousarray(cell)

    def some(first: int) -> None:
        last = min(first + TRIANGLES_A_SLAB, len(ids))
        _centres(*field.given, at, ids, own, first, last, centre, away, np.empty(20))

    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    each(some, range(0, len(ids), TRIANGLES_A_SLAB))
    return centre, away


def recursed(
    field: Field, points: Floats, triangles: Integers, cell: Integers, tolerance: float, rounds: int, most: int,
    *, slabs: Slabs | None = None,
) -> Mesh:  # fmt: skip
    """Each triangle that is too far becomes three at its G, again and again.

    Parameters
    ----------
    tolerance : distance, as `Field.asked` gives it
    rounds : at most
    most : triangles; more rounds are not begun beyond it
    """
    reach = reaches(field, points, triangles, cell, tolerance, slabs=slabs)
    for _ in range(rounds):
        far = np.flatnonzero(reach > tolerance)
        new, away = centres(field, points, triangles[far], cell[far], slabs=slabs)
        far, new = far[away > 0], new[away > 0]
        if not len(far) or len(triangles) + 2 * len(far) > most:
            break
        g, (a, b, c) = len(points) + np.arange(len(far)), triangles[far].T
        keep = np.ones(len(triangles), bool)
        keep[far] = False
        made = np.stack([np.column_stack(part) for part in ((a, b, g), (b, c, g), (c, a, g))], axis=1).reshape(-1, 3)
        points = np.concatenate([points, new])
        triangles, cell = np.concatenate([triangles[keep], made]), np.concatenate([cell[keep], np.repeat(cell[far], 3)])
        which = np.arange(int(keep.sum()), len(triangles))
        reach = np.concatenate([reach[keep], reaches(field, points, triangles, cell, tolerance, which=which, slabs=slabs)])
    far = np.flatnonzero(reach > tolerance)
    reach[far] = reaches(field, points, triangles, cell, np.inf, which=far, slabs=slabs)
    return Mesh(points, triangles, cell, field.surely(reach))


def warm() -> None:
    """Compile the kernels of this file."""
    axis = np.arange(2.0)
    field = Field(np.array([0.0, 1, 1, 2, 1, 2, 2, 4]).reshape(2, 2, 2), axis, axis, axis, 0.5)
    points = np.array([[0.0, 0, 0.5], [0.5, 0, 0], [0, 0.5, 0]])
    centres(field, points, np.array([[0, 2, 1]]), np.array([0]))
