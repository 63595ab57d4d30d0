"""How far triangles lie from the trilinear surface: a proven bound for each.

On a triangle F is a cubic whose ten Bernstein coefficients bound it: |F - L| <= B. In a box around the triangle, wide
enough for every path along the normal n, the slope n . grad F is at least g, the least of its values at the box's
corners in each cell that the box touches. If B / g is no more than the width, each point of the triangle has a point
of the surface within B / g. Beyond the border the interpolant of the last cells goes on.

Source: multi-affine polynomials reach their extremes at corners; Farin 1986 (Bernstein coefficients on triangles).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit
from modules.kernels.marching_cases import Floats, Integers


class Lattice(NamedTuple):
    """The samples: (nz, ny, nx) values and the coordinates along each axis."""

    values: Floats
    x: Floats
    y: Floats
    z: Floats


SPLITS = 3
"""A triangle that cannot be proven as a whole is cut in 4 and 16."""

WIDENINGS = 4
ROUNDING = 2.0**-46
"""Of the numbers involved: what rounding may add."""


@jit
def _corner_value(lattice: Lattice, i: int, j: int, k: int, x: float, y: float, z: float) -> float:
    """F at a place, by the polynomial of a cell."""
    f = lattice.values
    u = (x - lattice.x[i]) / (lattice.x[i + 1] - lattice.x[i])
    v = (y - lattice.y[j]) / (lattice.y[j + 1] - lattice.y[j])
    w = (z - lattice.z[k]) / (lattice.z[k + 1] - lattice.z[k])
    low = (1 - v) * ((1 - u) * f[k, j, i] + u * f[k, j, i + 1]) + v * ((1 - u) * f[k, j + 1, i] + u * f[k, j + 1, i + 1])
    k += 1
    high = (1 - v) * ((1 - u) * f[k, j, i] + u * f[k, j, i + 1]) + v * ((1 - u) * f[k, j + 1, i] + u * f[k, j + 1, i + 1])
    result: float = (1 - w) * low + w * high
    return result


@jit
def _slope(lattice: Lattice, i: int, j: int, k: int, x: float, y: float, z: float, g: Floats) -> None:
    """The gradient of F at a place, by the polynomial of a cell."""
    f = lattice.values
    hx, hy, hz = lattice.x[i + 1] - lattice.x[i], lattice.y[j + 1] - lattice.y[j], lattice.z[k + 1] - lattice.z[k]
    u, v, w = (x - lattice.x[i]) / hx, (y - lattice.y[j]) / hy, (z - lattice.z[k]) / hz
    g[:] = 0.0
    for c in range(8):
        a, b, d = c >> 2, (c >> 1) & 1, c & 1
        value = f[k + d, j + b, i + a]
        p, q, r = (u if a else 1 - u), (v if b else 1 - v), (w if d else 1 - w)
        g[0] += (value if a else -value) * q * r / hx
        g[1] += (value if b else -value) * p * r / hy
        g[2] += (value if d else -value) * p * q / hz


@jit
def _cell_at(axis: Floats, t: float) -> int:
    last: int = axis.size - 2
    return min(max(int(np.searchsorted(axis, t, side="right")) - 1, 0), last)


@jit
def _least_slope(lattice: Lattice, low: Floats, high: Floats, n: Floats, g: Floats) -> float:
    """The least n . grad F in a box; not a number where a sample of its cells is none."""
    least = math.inf
    x, y, z = lattice.x, lattice.y, lattice.z
    i0, i1 = _cell_at(x, low[0]), _cell_at(x, high[0])
    j0, j1 = _cell_at(y, low[1]), _cell_at(y, high[1])
    k0, k1 = _cell_at(z, low[2]), _cell_at(z, high[2])
    if (i1 - i0 + 1) * (j1 - j0 + 1) * (k1 - k0 + 1) > 64:
        return -math.inf
    for k in range(k0, k1 + 1):
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                for c in range(8):
                    px = (high[0] if i == i1 else x[i + 1]) if c & 1 else (low[0] if i == i0 else x[i])
                    py = (high[1] if j == j1 else y[j + 1]) if c & 2 else (low[1] if j == j0 else y[j])
                    pz = (high[2] if k == k1 else z[k + 1]) if c & 4 else (low[2] if k == k0 else z[k])
                    _slope(lattice, i, j, k, px, py, pz, g)
                    along = n[0] * g[0] + n[1] * g[1] + n[2] * g[2]
                    if not along >= least:
                        least = along
                        if not along > 0.0:
                            return -math.inf
    return least


@jit
def _largest(lattice: Lattice, level: float, cell: tuple[int, int, int], p: Floats) -> float:
    """B, from the Bernstein coefficients of F - L on a triangle (3, 3) in a cell."""
    largest, (i, j, k) = 0.0, cell
    for a in range(3):
        for b in range(a, 3):
            for c in range(b, 3):
                total = 0.0
                for turn in range(6):
                    r, s, t = (a, b, c) if turn % 3 == 0 else (b, c, a) if turn % 3 == 1 else (c, a, b)
                    if turn > 2:
                        s, t = t, s
                    total += _corner_value(lattice, i, j, k, p[r, 0], p[s, 1], p[t, 2]) - level
                largest = max(largest, abs(total) / 6.0)
    return largest


@jit
def _prove(lattice: Lattice, level: float, cell: tuple[int, int, int], p: Floats, n: Floats, size: float) -> float:
    """The proven distance of a triangle (3, 3) with unit normal n to the high side; infinite if there is none."""
    low, high, g = np.empty(3), np.empty(3), np.empty(3)
    largest = _largest(lattice, level, cell, p) + ROUNDING * size
    _slope(lattice, cell[0], cell[1], cell[2], p[:, 0].mean(), p[:, 1].mean(), p[:, 2].mean(), g)
    steep = n[0] * g[0] + n[1] * g[1] + n[2] * g[2]
    if not steep > 0.0:
        return math.inf
    width = 1.25 * largest / steep
    for _ in range(WIDENINGS):
        for axis in range(3):
            low[axis] = min(p[0, axis], p[1, axis], p[2, axis]) - width * abs(n[axis])
            high[axis] = max(p[0, axis], p[1, axis], p[2, axis]) + width * abs(n[axis])
        least = _least_slope(lattice, low, high, n, g)
        if not least > 0.0:
            return math.inf
        if largest <= width * least:
            return largest / least
        width *= 2.0
    return math.inf


@jit
def _measure(
    lattice: Lattice, level: float, point: Floats, triangle: Integers, origin: Integers, size: float,
    reach: Floats, slope: Floats,
) -> None:
    """The proven distance of each triangle, and the least slope of the cells about each point."""
    nx, ny = lattice.x.size - 1, lattice.y.size - 1
    p, part, n, g = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    for m in range(len(triangle)):
        i, row = origin[m] % nx, origin[m] // nx
        cell = (i, row % ny, row // ny)
        for c in range(3):
            p[c] = point[triangle[m, c]]
            _slope(lattice, cell[0], cell[1], cell[2], p[c, 0], p[c, 1], p[c, 2], g)
            steep = math.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)
            slope[triangle[m, c]] = min(slope[triangle[m, c]], steep)
        u, v = p[1] - p[0], p[2] - p[0]
        n[0], n[1], n[2] = v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]
        length = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
        reach[m] = math.inf
        if not length > 0.0:
            continue
        n /= length
        for level_of_split in range(SPLITS):
            cuts, worst = 1 << level_of_split, 0.0
            for a in range(cuts):
                for b in range(2 * (cuts - a) - 1):
                    if worst < math.inf:
                        _piece(p, part, cuts, a, b)
                        worst = max(worst, _prove(lattice, level, cell, part, n, size))
            if worst < math.inf:
                reach[m] = worst
                break


@jit
def _piece(p: Floats, part: Floats, cuts: int, a: int, b: int) -> None:
    """The b-th piece of the a-th strip of a triangle cut in cuts^2."""
    s, up = b // 2, b % 2
    for axis in range(3):
        u, v = (p[1, axis] - p[0, axis]) / cuts, (p[2, axis] - p[0, axis]) / cuts
        part[0, axis] = p[0, axis] + (s + up) * u + a * v
        part[1, axis] = p[0, axis] + (s + 1) * u + (a + up) * v
        part[2, axis] = p[0, axis] + s * u + (a + 1) * v


def distances(
    values: Floats, x: Floats, y: Floats, z: Floats, level: float, points: Floats, triangles: Integers, cell: Integers
) -> tuple[Floats, Floats]:
    """The proven distance of each triangle from the trilinear surface, and the least slope about each point.

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    points, triangles, cell : (n, 3), (m, 3), (m,)
        A surface, as of `marching.surface`: each triangle lies in its cell, its normal points to the low side.

    Returns
    -------
    (m,), (n,)
        Infinite where nothing could be proven; |grad F|, the smallest of the cells of the triangles at a point.

    Accuracy: proven, rounding included.
    """
    lattice = Lattice(*(np.ascontiguousarray(array, np.float64).view() for array in (values, x, y, z)))
    for array in lattice:
        array.flags.writeable = False
    finite = np.abs(lattice.values[np.isfinite(lattice.values)])
    size = float(finite.max(initial=0.0)) + abs(level)
    reach, slope = np.empty(len(triangles)), np.full(len(points), math.inf)
    ids, origin = (np.ascontiguousarray(array, np.int64) for array in (triangles, cell))
    _measure(lattice, float(level), np.ascontiguousarray(points, np.float64), ids, origin, size, reach, slope)
    place = max(float(np.abs(axis).max()) for axis in lattice[1:])
    proven: npt.NDArray[np.float64] = reach * (1.0 + ROUNDING) + ROUNDING * place
    return proven, slope


def warm() -> None:
    """Compile the kernels of this file."""
    values = np.arange(8.0).reshape(2, 2, 2)
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    axis = np.arange(2.0)
    distances(values, axis, axis, axis, 0.5, points, np.array([[0, 1, 2]]), np.array([0]))
