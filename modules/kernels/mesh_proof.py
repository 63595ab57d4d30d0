"""Whether triangles lie within a tolerance of the trilinear surface: the proof of `marching_distance`, cut where it pays.

Bernstein coefficients of a whole triangle exceed what they bound by a third; of its quarters by a twelfth. A triangle
that is not within the tolerance as a whole is tried in 4 and in 16 pieces, unless a few values show that it cannot be.

Beside a face the surface may bend so sharply that F falls along the normal in the cell behind it. Any direction along
which F rises proves as much as the normal: the second try takes one that does not leave the cell.

Source: as `marching_distance`.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from modules.kernels._jit import lean, lean_inlined
from modules.kernels.marching_cases import Floats, Integers, index
from modules.kernels.marching_distance import ROUNDING, bernstein, corners, largest_of, least_in_cell, piece, prove

SPLITS = 3
"""As a whole, in 4 and in 16 pieces."""

HOPELESS = 1.02
"""A triangle whose |F| / slope is this many tolerances somewhere is not tried in pieces."""

FAR = 1e300
"""Of a triangle that is given up: it may well be proven for a larger tolerance."""

TRIANGLES_A_SLAB = 1 << 12
ROOM = 155
"""Floats that `within` works in."""

Slabs = Callable[[Callable[[int], Any], Iterable[int]], list[Any]]


@lean_inlined
def value_in(f: Floats, u: float, v: float, w: float) -> float:
    """F in the unit cell."""
    low = (1 - v) * ((1 - w) * f[0] + w * f[1]) + v * ((1 - w) * f[2] + w * f[3])
    high = (1 - v) * ((1 - w) * f[4] + w * f[5]) + v * ((1 - w) * f[6] + w * f[7])
    value: float = (1 - u) * low + u * high
    return value


@lean_inlined
def slope_in(f: Floats, u: float, v: float, w: float, size: Floats, g: Floats) -> None:
    """The gradient at a place of the unit cell, a unit of length."""
    p, q, r = 1 - u, 1 - v, 1 - w
    g[0] = (q * (r * (f[4] - f[0]) + w * (f[5] - f[1])) + v * (r * (f[6] - f[2]) + w * (f[7] - f[3]))) / size[0]
    g[1] = (p * (r * (f[2] - f[0]) + w * (f[3] - f[1])) + u * (r * (f[6] - f[4]) + w * (f[7] - f[5]))) / size[1]
    g[2] = (p * (q * (f[1] - f[0]) + v * (f[3] - f[2])) + u * (q * (f[5] - f[4]) + v * (f[7] - f[6]))) / size[2]


@lean_inlined
def _fits(box: Floats, low: Floats, high: Floats, g: Floats, d: Floats, width: float, steep: float) -> bool:
    """Whether a box swept along g / steep stays in its cell; else g is no more along what leaves it. d gets the direction."""
    fits = True
    for a in range(3):
        d[a] = g[a] / steep
        if box[a] - width * abs(d[a]) < low[a] or box[3 + a] + width * abs(d[a]) > high[a]:
            fits = fits and d[a] == 0.0
            g[a] = 0.0
    return fits


@lean
def _prove_inside(f: Floats, level: float, low: Floats, high: Floats, p: Floats, size: float, room: Floats) -> float:
    """The proven distance of a triangle p (9,) along a direction that stays in its cell; infinite if there is none."""
    g, d, step, u, spare, box = room[0:3], room[3:6], room[6:9], room[9:18], room[18:49], room[49:55]
    for a in range(3):
        step[a] = high[a] - low[a]
        box[a], box[3 + a] = min(p[a], p[3 + a], p[6 + a]), max(p[a], p[3 + a], p[6 + a])
        for c in range(3):
            u[3 * c + a] = (p[3 * c + a] - low[a]) / step[a]
    largest: float = bernstein(f, level, u, spare) + ROUNDING * size
    slope_in(f, (u[0] + u[3] + u[6]) / 3, (u[1] + u[4] + u[7]) / 3, (u[2] + u[5] + u[8]) / 3, step, g)
    for a in range(3):
        g[a] *= box[a] > low[a] and box[3 + a] < high[a]
    factor = 1.25
    for _ in range(6):
        steep = math.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)
        if not steep > 0.0:
            return math.inf
        width = factor * largest / steep
        if not _fits(box, low, high, g, d, width, steep):
            continue
        for a in range(3):
            u[a] = max(0.0, (box[a] - width * abs(d[a]) - low[a]) / step[a])
            u[3 + a] = min(1.0, (box[3 + a] + width * abs(d[a]) - low[a]) / step[a])
        nx, ny, nz = d[0] / step[0], d[1] / step[1], d[2] / step[2]
        least: float = least_in_cell(f, u[0], u[3], u[1], u[4], u[2], u[5], nx, ny, nz, spare)
        least -= ROUNDING * size * (abs(nx) + abs(ny) + abs(nz))
        if not least > 0.0:
            return math.inf
        if largest <= width * least:
            reach: float = largest / least
            return reach
        factor *= 2.0
    return math.inf


@lean
def within(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, cell: int, p: Floats, tolerance: float, size: float,
    room: Floats,
) -> float:
    """The proven distance of a triangle p (9,) of a cell, cut until it is within the tolerance; infinite if there is none,
    `FAR` if it cannot be within it.

    What is larger than the tolerance may be larger than need be.
    """
    part, n, f, rest = room[0:9], room[9:12], room[12:20], room[20:94]
    i, row = cell % (x.size - 1), cell // (x.size - 1)
    j, k = row % (y.size - 1), row // (y.size - 1)
    ux, uy, uz = p[3] - p[0], p[4] - p[1], p[5] - p[2]
    vx, vy, vz = p[6] - p[0], p[7] - p[1], p[8] - p[2]
    n[0], n[1], n[2] = vy * uz - vz * uy, vz * ux - vx * uz, vx * uy - vy * ux
    length = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    if not length > 0.0:
        return math.inf
    n[0], n[1], n[2] = n[0] / length, n[1] / length, n[2] / length
    hx, hy, hz = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
    corners(values, x.size, y.size, i, j, k, f)
    u, v, w = (p[0] + p[3] + p[6]) / 3 - x[i], (p[1] + p[4] + p[7]) / 3 - y[j], (p[2] + p[5] + p[8]) / 3 - z[k]
    u, v, w = u / hx, v / hy, w / hz
    steep = least_in_cell(f, u, u, v, v, w, w, n[0] / hx, n[1] / hy, n[2] / hz, rest)
    if steep < 0.0:
        return math.inf
    if abs(value_in(f, u, v, w) - level) > HOPELESS * tolerance * steep:
        return FAR
    for m in range(3):
        q, r = 3 * m, 3 * ((m + 1) % 3)
        u, v, w = 0.5 * (p[q] + p[r]) - x[i], 0.5 * (p[q + 1] + p[r + 1]) - y[j], 0.5 * (p[q + 2] + p[r + 2]) - z[k]
        if abs(value_in(f, u / hx, v / hy, w / hz) - level) > 2 * HOPELESS * tolerance * steep:
            return FAR
    low, high, spare = room[ROOM - 61 : ROOM - 58], room[ROOM - 58 : ROOM - 55], room[ROOM - 55 : ROOM]
    low[0], low[1], low[2], high[0], high[1], high[2] = x[i], y[j], z[k], x[i + 1], y[j + 1], z[k + 1]
    best = math.inf
    for split in range(SPLITS):
        cuts, worst = 1 << split, 0.0
        for a in range(cuts):
            for b in range(2 * (cuts - a) - 1):
                if worst < best:
                    piece(p, part, cuts, a, b)
                    far = prove(values, level, x, y, z, i, j, k, part, n, size, rest)
                    if not far <= tolerance or far == math.inf:
                        far = min(far, _prove_inside(f, level, low, high, part, size, spare))
                    worst = max(worst, far)
        best = min(best, worst)
        if best <= tolerance and best < math.inf:
            break
    return best


@lean
def _measure(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats, triangle: Integers, cell: Integers,
    which: Integers, first: int, last: int, tolerance: float, size: float, reach: Floats, room: Floats,
) -> None:
    p, rest = room[0:9], room[9 : 9 + ROOM]
    for m in range(first, last):
        t = index(which[m])
        for c in range(3):
            for axis in range(3):
                p[3 * c + axis] = point[index(triangle[t, c]), axis]
        reach[m] = within(values, level, x, y, z, cell[t], p, tolerance, size, rest)


class Field:
    """Values on a rectilinear grid and a level, ready for the kernels.

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    level : in units of the values
    """

    def __init__(self, values: Floats, x: Floats, y: Floats, z: Floats, level: float) -> None:
        if np.shape(values) != (len(z), len(y), len(x)):
            raise ValueError(f"values of shape {np.shape(values)} do not fit {len(z)} x {len(y)} x {len(x)} coordinates")
        arrays = [np.ascontiguousarray(a, np.float64).reshape(-1).view() for a in (values, x, y, z)]
        for array in arrays:
            array.flags.writeable = False  # one signature for arrays that may and may not be written
        self.values, self.x, self.y, self.z = arrays
        self.level = float(level)
        self.size = largest_of(self.values) + abs(self.level)
        self.place = max(float(np.abs(axis).max()) for axis in arrays[1:])

    @property
    def given(self) -> tuple[Floats, float, Floats, Floats, Floats]:
        """The arguments with which kernels begin."""
        return self.values, self.level, self.x, self.y, self.z

    def surely(self, reach: Floats) -> Floats:
        """Distances with what rounding may add."""
        return reach * (1.0 + ROUNDING) + ROUNDING * self.place

    def asked(self, tolerance: float) -> float:
        """What a distance must not exceed so that it is within the tolerance with what rounding may add."""
        return (tolerance - ROUNDING * self.place) / (1.0 + 2 * ROUNDING)


def reaches(
    field: Field, points: Floats, triangles: Integers, cell: Integers, tolerance: float, *, which: Integers | None = None,
    slabs: Slabs | None = None,
) -> Floats:  # fmt: skip
    """The proven distance of triangles, cut as far as the tolerance needs; infinite where there is none.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,); the right-handed normals point to the low side
    tolerance : a triangle that is far beyond it is given up and gets `FAR`
    which : (k,) triangles that are wanted; all by default
    slabs : shares the work, as `Progress.map` does

    Returns
    -------
    (m,) or (k,), without what rounding of the places may add (`Field.surely`)
    """
    wanted = np.arange(len(triangles)) if which is None else np.ascontiguousarray(which, np.int64)
    reach = np.empty(len(wanted))
    at, ids, own = np.ascontiguousarray(points), np.ascontiguousarray(triangles), np.ascontiguousarray(cell)

    def measure(first: int) -> None:
        last = min(first + TRIANGLES_A_SLAB, len(wanted))
        _measure(*field.given, at, ids, own, wanted, first, last, float(tolerance), field.size, reach, np.empty(9 + ROOM))

    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    each(measure, range(0, len(wanted), TRIANGLES_A_SLAB))
    return reach


def warm() -> None:
    """Compile the kernels of this file."""
    axis = np.arange(2.0)
    field = Field(np.arange(8.0).reshape(2, 2, 2), axis, axis, axis, 0.5)
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    reaches(field, points, np.array([[0, 1, 2]]), np.array([0]), 0.1)
