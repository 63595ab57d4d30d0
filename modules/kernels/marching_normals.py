"""Normals at the points of an isosurface, for light: of slopes at the nodes, or of the cells' own polynomials.

They look to the low side, as the triangles do.

Source: Lopes 1999, section 4.1.2 (normals interpolated from the gradients at the nodes).
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_inlined
from modules.kernels.interpolation import locate
from modules.kernels.marching_cases import Floats, Integers, frozen

Singles = npt.NDArray[np.float32]


@lean_inlined
def _slope(values: Floats, place: Floats, i: int, node: int, step: int) -> float:
    """The difference of the neighbours of a node along an axis; one-sided at its ends and beside a hole, 0 where alone."""
    low, high = i, i
    if i > 0 and math.isfinite(values[node - step]):
        low = i - 1
    if i < place.size - 1 and math.isfinite(values[node + step]):
        high = i + 1
    if low == high:
        return 0.0
    rise: float = (values[node + (high - i) * step] - values[node - (i - low) * step]) / (place[high] - place[low])
    return rise


@jit
def _at_nodes(values: Floats, x: Floats, y: Floats, z: Floats, cell: Integers, u: Floats, normal: Singles) -> None:
    nx, ny = x.size, y.size
    for n in range(len(cell)):
        gx = gy = gz = 0.0
        for c in range(8):
            a, b, e = c & 1, (c >> 1) & 1, c >> 2
            weight = (u[n, 0] if a else 1.0 - u[n, 0]) * (u[n, 1] if b else 1.0 - u[n, 1]) * (u[n, 2] if e else 1.0 - u[n, 2])
            if weight > 0.0:
                i, j, k = cell[n, 0] + a, cell[n, 1] + b, cell[n, 2] + e
                node = (k * ny + j) * nx + i
                gx += weight * _slope(values, x, i, node, 1)
                gy += weight * _slope(values, y, j, node, nx)
                gz += weight * _slope(values, z, k, node, nx * ny)
        length = math.sqrt(gx * gx + gy * gy + gz * gz)
        if length > 0.0:
            normal[n, 0], normal[n, 1], normal[n, 2] = -gx / length, -gy / length, -gz / length


@jit
def _in_cells(
    values: Floats, x: Floats, y: Floats, z: Floats, points: Floats, triangles: Integers, origin: Integers, normal: Singles
) -> None:
    nx, ny, f = x.size, y.size, np.empty(8)
    for m in range(len(triangles)):
        i, row = origin[m] % (nx - 1), origin[m] // (nx - 1)
        j, k = row % (ny - 1), row // (ny - 1)
        for c in range(8):
            f[c] = values[((k + (c & 1)) * ny + j + ((c >> 1) & 1)) * nx + i + (c >> 2)]
        hx, hy, hz = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
        for c in range(3):
            n = triangles[m, c]
            u, v, w = (points[n, 0] - x[i]) / hx, (points[n, 1] - y[j]) / hy, (points[n, 2] - z[k]) / hz
            p, q, r = 1 - u, 1 - v, 1 - w
            gx = (q * (r * (f[4] - f[0]) + w * (f[5] - f[1])) + v * (r * (f[6] - f[2]) + w * (f[7] - f[3]))) / hx
            gy = (p * (r * (f[2] - f[0]) + w * (f[3] - f[1])) + u * (r * (f[6] - f[4]) + w * (f[7] - f[5]))) / hy
            gz = (p * (q * (f[1] - f[0]) + v * (f[3] - f[2])) + u * (q * (f[5] - f[4]) + v * (f[7] - f[6]))) / hz
            length = math.sqrt(gx * gx + gy * gy + gz * gz)
            if length > 0.0:
                normal[n, 0] -= gx / length
                normal[n, 1] -= gy / length
                normal[n, 2] -= gz / length


def from_nodes(values: Floats, x: Floats, y: Floats, z: Floats, points: Floats) -> Singles:
    """Directions down the slopes at the nodes, by central differences, interpolated: (n, 3) of length 1; 0 where level.

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    points : (n, 3), in cells without a hole
    """
    cell, u = locate(points, (x, y, z))
    normal = np.zeros((len(points), 3), np.float32)
    field, fx, fy, fz = frozen(values, x, y, z)
    _at_nodes(field, fx, fy, fz, cell, u, normal)
    return normal


def from_cells(
    values: Floats, x: Floats, y: Floats, z: Floats, points: Floats, triangles: Integers, cell: Integers
) -> Singles:  # fmt: skip
    """Directions down the slopes of the polynomials of the triangles' cells, the mean at each point: (n, 3); 0 where level.

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    points, triangles, cell : (n, 3), (m, 3), (m,)
    """
    normal = np.zeros((len(points), 3), np.float32)
    at, ids, origin = np.ascontiguousarray(points), np.ascontiguousarray(triangles), np.ascontiguousarray(cell)
    field, fx, fy, fz = frozen(values, x, y, z)
    _in_cells(field, fx, fy, fz, at, ids, origin, normal)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(normal / np.where(length > 0, length, 1), np.float32)


def warm() -> None:
    """Compile the kernels of this file."""
    values, axis = np.arange(8.0).reshape(2, 2, 2), np.arange(2.0)
    points, triangles = np.array([[0.0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]]), np.array([[0, 1, 2]])
    from_nodes(values, axis, axis, axis, points)
    from_cells(values, axis, axis, axis, points, triangles, np.zeros(1, np.int64))
