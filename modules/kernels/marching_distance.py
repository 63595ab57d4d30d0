"""How far triangles lie from the trilinear surface: a proven bound for each.

On a triangle F is a cubic whose ten Bernstein coefficients bound it: |F - L| <= B. In a box around the triangle, wide
enough for every path along the normal n, the slope n . grad F is at least g, the least of its values at the box's
corners in each cell that the box touches. If B / g is no more than the width, each point of the triangle has a point
of the surface within B / g. Beyond the border the interpolant of the last cells goes on.

Source: multi-affine polynomials reach their extremes at corners; Farin 1986 (Bernstein coefficients on triangles).
"""

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from modules.kernels._jit import lean, lean_inlined
from modules.kernels.marching_cases import Floats, Integers, index

SPLITS = 3
"""A triangle that cannot be proven as a whole is cut in 4 and 16."""

WIDENINGS = 4
MOST_CELLS = 64
ROUNDING = 2.0**-46
"""Of the numbers involved: what rounding may add."""

TRIANGLES_A_SLAB = 1 << 14

Slabs = Callable[[Callable[[int], Any], Iterable[int]], list[Any]]


@lean_inlined
def _cell_at(axis: Floats, t: float, near: int) -> int:
    """The cell of an axis that holds a place, sought from a cell near it; the first or last one for a place outside."""
    n, last = near, axis.size - 2
    while n > 0 and t < axis[index(n)]:
        n -= 1
    while n < last and t >= axis[index(n + 1)]:
        n += 1
    return n


@lean_inlined
def corners(values: Floats, nx: int, ny: int, i: int, j: int, k: int, f: Floats) -> None:
    """The values at the corners of a cell into f, in the order 000, 001, ..., 111 of x, y, z."""
    node = (k * ny + j) * nx + i
    for c in range(8):
        f[c] = values[index(node + ((c & 1) * ny + ((c >> 1) & 1)) * nx + (c >> 2))]


@lean_inlined
def least_in_cell(
    f: Floats, u0: float, u1: float, v0: float, v1: float, w0: float, w1: float, nx: float, ny: float, nz: float, d: Floats
) -> float:
    """The least n . grad F in a part of a cell, the normal given in steps of the cell."""
    for m in range(4):
        # along x at (v, w), along y at (u, w), along z at (u, v)
        u, v, w, last = u1 if m & 2 else u0, v1 if m & 2 else v0, w1 if m & 1 else w0, v1 if m & 1 else v0
        d[m] = (1 - v) * ((1 - w) * (f[4] - f[0]) + w * (f[5] - f[1])) + v * ((1 - w) * (f[6] - f[2]) + w * (f[7] - f[3]))
        d[4 + m] = (1 - u) * ((1 - w) * (f[2] - f[0]) + w * (f[3] - f[1])) + u * ((1 - w) * (f[6] - f[4]) + w * (f[7] - f[5]))
        v = last
        d[8 + m] = (1 - u) * ((1 - v) * (f[1] - f[0]) + v * (f[3] - f[2])) + u * ((1 - v) * (f[5] - f[4]) + v * (f[7] - f[6]))
    least = math.inf
    for c in range(8):
        a, b, e = c >> 2, (c >> 1) & 1, c & 1
        along = nx * d[2 * b + e] + ny * d[4 + 2 * a + e] + nz * d[8 + 2 * a + b]
        if not along >= least:
            least = along
    return least


@lean
def _least_slope(
    values: Floats, x: Floats, y: Floats, z: Floats, i: int, j: int, k: int, box: Floats, n: Floats, size: float, room: Floats
) -> float:
    """The least n . grad F in a box, less what rounding may add; not positive, or not a number, where there is none."""
    f, d = room[0:8], room[8:20]
    i0, i1 = _cell_at(x, box[0], i), _cell_at(x, box[3], i)
    j0, j1 = _cell_at(y, box[1], j), _cell_at(y, box[4], j)
    k0, k1 = _cell_at(z, box[2], k), _cell_at(z, box[5], k)
    least = math.inf
    if (i1 - i0 + 1) * (j1 - j0 + 1) * (k1 - k0 + 1) > MOST_CELLS:
        return -math.inf
    for r in range(k0, k1 + 1):
        for q in range(j0, j1 + 1):
            for p in range(i0, i1 + 1):
                hx, hy, hz = x[p + 1] - x[p], y[q + 1] - y[q], z[r + 1] - z[r]
                u0, u1 = (box[0] - x[p]) / hx if p == i0 else 0.0, (box[3] - x[p]) / hx if p == i1 else 1.0
                v0, v1 = (box[1] - y[q]) / hy if q == j0 else 0.0, (box[4] - y[q]) / hy if q == j1 else 1.0
                w0, w1 = (box[2] - z[r]) / hz if r == k0 else 0.0, (box[5] - z[r]) / hz if r == k1 else 1.0
                corners(values, x.size, y.size, p, q, r, f)
                a, b, c = n[0] / hx, n[1] / hy, n[2] / hz
                along = least_in_cell(f, u0, u1, v0, v1, w0, w1, a, b, c, d)
                along -= ROUNDING * size * (abs(a) + abs(b) + abs(c))
                if not along >= least:
                    least = along
                    if not along > 0.0:
                        return -math.inf
    return least


@lean_inlined
def bernstein(f: Floats, level: float, u: Floats, g: Floats) -> float:
    """B, from the Bernstein coefficients of F - L on a triangle with corners u (3, 3) in the unit cell."""
    for r in range(3):
        p = u[3 * r]
        for c in range(4):
            g[c] = (1 - p) * f[c] + p * f[c + 4] - level
        for s in range(3):
            q = u[3 * s + 1]
            low, high = (1 - q) * g[0] + q * g[2], (1 - q) * g[1] + q * g[3]
            for t in range(3):
                w = u[3 * t + 2]
                g[4 + 9 * r + 3 * s + t] = (1 - w) * low + w * high
    largest = 0.0
    for a in range(3):
        for b in range(a, 3):
            for c in range(b, 3):
                total = g[4 + 9 * a + 3 * b + c] + g[4 + 9 * b + 3 * c + a] + g[4 + 9 * c + 3 * a + b]
                total += g[4 + 9 * a + 3 * c + b] + g[4 + 9 * b + 3 * a + c] + g[4 + 9 * c + 3 * b + a]
                largest = max(largest, abs(total) / 6.0)
    return largest


@lean
def prove(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, i: int, j: int, k: int, p: Floats, n: Floats, size: float,
    room: Floats,
) -> float:
    """The proven distance of a triangle (3, 3) with unit normal n to the high side; infinite if there is none."""
    f, u, g, box, spare = room[0:8], room[8:17], room[17:48], room[48:54], room[54:74]
    hx, hy, hz = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
    corners(values, x.size, y.size, i, j, k, f)
    for c in range(3):
        u[3 * c], u[3 * c + 1] = (p[3 * c] - x[i]) / hx, (p[3 * c + 1] - y[j]) / hy
        u[3 * c + 2] = (p[3 * c + 2] - z[k]) / hz
    largest = bernstein(f, level, u, g) + ROUNDING * size
    a, b, c = (u[0] + u[3] + u[6]) / 3.0, (u[1] + u[4] + u[7]) / 3.0, (u[2] + u[5] + u[8]) / 3.0
    steep = least_in_cell(f, a, a, b, b, c, c, n[0] / hx, n[1] / hy, n[2] / hz, spare)
    if not steep > 0.0:
        return math.inf
    width = 1.25 * largest / steep
    for _ in range(WIDENINGS):
        for axis in range(3):
            step = width * abs(n[axis])
            box[axis] = min(p[axis], p[3 + axis], p[6 + axis]) - step
            box[3 + axis] = max(p[axis], p[3 + axis], p[6 + axis]) + step
        least = _least_slope(values, x, y, z, i, j, k, box, n, size, spare)
        if not least > 0.0:
            return math.inf
        if largest <= width * least:
            return largest / least
        width *= 2.0
    return math.inf


@lean
def _measure(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats, triangle: Integers, origin: Integers,
    first: int, last: int, size: float, reach: Floats, room: Floats,
) -> None:
    """The proven distance of triangles first to last - 1."""
    p, part, n, rest = room[0:9], room[9:18], room[18:21], room[21:95]
    for m in range(first, last):
        i, row = origin[m] % (x.size - 1), origin[m] // (x.size - 1)
        j, k = row % (y.size - 1), row // (y.size - 1)
        for c in range(3):
            for axis in range(3):
                p[3 * c + axis] = point[index(triangle[m, c]), axis]
        ux, uy, uz = p[3] - p[0], p[4] - p[1], p[5] - p[2]
        vx, vy, vz = p[6] - p[0], p[7] - p[1], p[8] - p[2]
        n[0], n[1], n[2] = vy * uz - vz * uy, vz * ux - vx * uz, vx * uy - vy * ux
        length = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
        reach[m] = math.inf
        if not length > 0.0:
            continue
        n[0], n[1], n[2] = n[0] / length, n[1] / length, n[2] / length
        for split in range(SPLITS):
            cuts, worst = 1 << split, 0.0
            for a in range(cuts):
                for b in range(2 * (cuts - a) - 1):
                    if worst < math.inf:
                        piece(p, part, cuts, a, b)
                        worst = max(worst, prove(values, level, x, y, z, i, j, k, part, n, size, rest))
            if worst < math.inf:
                reach[m] = worst
                break


@lean_inlined
def piece(p: Floats, part: Floats, cuts: int, a: int, b: int) -> None:
    """The b-th piece of the a-th strip of a triangle cut in cuts^2."""
    s, up = b // 2, b % 2
    for axis in range(3):
        u, v = (p[3 + axis] - p[axis]) / cuts, (p[6 + axis] - p[axis]) / cuts
        part[axis] = p[axis] + (s + up) * u + a * v
        part[3 + axis] = p[axis] + (s + 1) * u + (a + up) * v
        part[6 + axis] = p[axis] + s * u + (a + 1) * v


@lean
def _slopes(
    values: Floats, x: Floats, y: Floats, z: Floats, point: Floats, triangle: Integers, origin: Integers, slope: Floats,
    room: Floats,
) -> None:
    """The least |grad F| at each point, of the cells of its triangles."""
    f, before = room[0:8], -1
    i, j, k = 0, 0, 0
    for m in range(len(triangle)):
        if origin[m] != before:
            before = origin[m]
            i, row = before % (x.size - 1), before // (x.size - 1)
            j, k = row % (y.size - 1), row // (y.size - 1)
            corners(values, x.size, y.size, i, j, k, f)
        hx, hy, hz = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
        for c in range(3):
            n = index(triangle[m, c])
            u, v, w = (point[n, 0] - x[i]) / hx, (point[n, 1] - y[j]) / hy, (point[n, 2] - z[k]) / hz
            p, q, r = 1 - u, 1 - v, 1 - w
            gx = (q * (r * (f[4] - f[0]) + w * (f[5] - f[1])) + v * (r * (f[6] - f[2]) + w * (f[7] - f[3]))) / hx
            gy = (p * (r * (f[2] - f[0]) + w * (f[3] - f[1])) + u * (r * (f[6] - f[4]) + w * (f[7] - f[5]))) / hy
            gz = (p * (q * (f[1] - f[0]) + v * (f[3] - f[2])) + u * (q * (f[5] - f[4]) + v * (f[7] - f[6]))) / hz
            slope[n] = min(slope[n], math.sqrt(gx * gx + gy * gy + gz * gz))


def distances(
    values: Floats, x: Floats, y: Floats, z: Floats, level: float, points: Floats, triangles: Integers, cell: Integers,
    *, slabs: Slabs | None = None,
) -> tuple[Floats, Floats]:  # fmt: skip
    """The proven distance of each triangle from the trilinear surface, and the least slope about each point.

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    points, triangles, cell : (n, 3), (m, 3), (m,)
        A surface, as of `marching.surface`: each triangle lies in its cell, its normal points to the low side.
    slabs
        Applies a function to each of some numbers and gives the list of results, perhaps in several threads; what it
        raises ends the work.

    Returns
    -------
    (m,), (n,)
        Infinite where nothing could be proven; |grad F|, the smallest of the cells of the triangles at a point.

    Accuracy: proven, rounding included.
    """
    shape = np.shape(values)
    values, x, y, z = (np.ascontiguousarray(array, np.float64).reshape(-1) for array in (values, x, y, z))
    if shape != (z.size, y.size, x.size):
        raise ValueError(f"values of shape {shape} do not fit {z.size} x {y.size} x {x.size} coordinates")
    size = largest_of(values) + abs(level)
    reach, slope = np.empty(len(triangles)), np.full(len(points), math.inf)
    ids, origin = (np.ascontiguousarray(array, np.int64) for array in (triangles, cell))
    at = np.ascontiguousarray(points, np.float64)
    read_only = [array.view() for array in (values, x, y, z)]
    for array in read_only:
        array.flags.writeable = False  # one signature for arrays that may and may not be written
    values, x, y, z = read_only

    def measure(first: int) -> None:
        last = min(first + TRIANGLES_A_SLAB, len(ids))
        _measure(values, float(level), x, y, z, at, ids, origin, first, last, size, reach, np.empty(95))

    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    each(measure, range(0, len(ids), TRIANGLES_A_SLAB))
    _slopes(values, x, y, z, at, ids, origin, slope, np.empty(8))
    place = max(float(np.abs(axis).max()) for axis in (x, y, z))
    return reach * (1.0 + ROUNDING) + ROUNDING * place, slope


def largest_of(values: Floats) -> float:
    """The largest finite |value|."""
    with np.errstate(invalid="ignore"):
        low, high = float(np.min(values)), float(np.max(values))
    if math.isfinite(low) and math.isfinite(high):
        return max(-low, high)
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def warm() -> None:
    """Compile the kernels of this file."""
    values = np.arange(8.0).reshape(2, 2, 2)
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    axis = np.arange(2.0)
    distances(values, axis, axis, axis, 0.5, points, np.array([[0, 1, 2]]), np.array([0]))
