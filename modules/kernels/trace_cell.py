"""The cell in which a particle is: its trilinear velocity, where it ends, and the way into the next one.

A weight near a face is measured from that face, so on a wall whose samples are at rest the velocity is exactly zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class Flow(NamedTuple):
    """Samples of a velocity field: values (nz, ny, nx, 3); coordinates (nx,), (ny,), (nz,)."""

    values: Floats
    x: Floats
    y: Floats
    z: Floats


class Here(NamedTuple):
    """The cell where a particle is: cell (3,) along x, y, z; corner (8, 3), x fastest; ends low, high (3,)."""

    cell: Integers
    corner: Floats
    low: Floats
    high: Floats


@jit
def nowhere() -> Here:
    """Room for a cell, to be filled by `find`."""
    return Here(np.zeros(3, np.int64), np.zeros((8, 3)), np.zeros(3), np.zeros(3))


@jit
def load(flow: Flow, here: Here) -> bool:
    """Fetch corners and ends of the cell `here.cell`; returns whether all corners are numbers."""
    i, j, k = here.cell
    here.low[0], here.high[0] = flow.x[i], flow.x[i + 1]
    here.low[1], here.high[1] = flow.y[j], flow.y[j + 1]
    here.low[2], here.high[2] = flow.z[k], flow.z[k + 1]
    total = 0.0
    for corner in range(8):
        for c in range(3):
            value = flow.values[k + (corner >> 2), j + (corner >> 1 & 1), i + (corner & 1), c]
            here.corner[corner, c] = value
            total += value
    return bool(total - total == 0.0)


@jit
def cell_of(axis: Floats, x: float) -> int:
    """The cell of a coordinate, the outermost one beyond the ends; on a face the cell above it."""
    low, high = 0, axis.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= axis[middle]:
            low = middle
        else:
            high = middle
    return low


@jit
def find(flow: Flow, here: Here, p: Floats) -> bool:
    """Go to the cell of a position, at the border the nearest; returns whether all its corners are numbers."""
    here.cell[0] = cell_of(flow.x, p[0])
    here.cell[1] = cell_of(flow.y, p[1])
    here.cell[2] = cell_of(flow.z, p[2])
    return load(flow, here)


@jit
def holds(here: Here, p: Floats) -> bool:
    """Whether a position lies in the cell, its faces included."""
    return bool(
        here.low[0] <= p[0] <= here.high[0] and here.low[1] <= p[1] <= here.high[1] and here.low[2] <= p[2] <= here.high[2]
    )


@jit
def velocity(here: Here, p: Floats, out: Floats) -> None:
    """The trilinear velocity of the cell at a position, continued beyond its faces."""
    hx, hy, hz = here.high[0] - here.low[0], here.high[1] - here.low[1], here.high[2] - here.low[2]
    u0, u1 = (here.high[0] - p[0]) / hx, (p[0] - here.low[0]) / hx
    v0, v1 = (here.high[1] - p[1]) / hy, (p[1] - here.low[1]) / hy
    w0, w1 = (here.high[2] - p[2]) / hz, (p[2] - here.low[2]) / hz
    f = here.corner
    a, b, c, d = v0 * w0, v1 * w0, v0 * w1, v1 * w1
    for m in range(3):
        out[m] = u0 * (a * f[0, m] + b * f[2, m] + c * f[4, m] + d * f[6, m]) + u1 * (
            a * f[1, m] + b * f[3, m] + c * f[5, m] + d * f[7, m]
        )


@jit
def jacobian(here: Here, p: Floats, out: Floats) -> None:
    """(3, 3) derivative of the velocity's component (row) along each axis (column)."""
    hx, hy, hz = here.high[0] - here.low[0], here.high[1] - here.low[1], here.high[2] - here.low[2]
    u0, u1 = (here.high[0] - p[0]) / hx, (p[0] - here.low[0]) / hx
    v0, v1 = (here.high[1] - p[1]) / hy, (p[1] - here.low[1]) / hy
    w0, w1 = (here.high[2] - p[2]) / hz, (p[2] - here.low[2]) / hz
    f = here.corner
    for m in range(3):
        out[m, 0] = (
            v0 * w0 * (f[1, m] - f[0, m]) + v1 * w0 * (f[3, m] - f[2, m])
            + v0 * w1 * (f[5, m] - f[4, m]) + v1 * w1 * (f[7, m] - f[6, m])
        ) / hx  # fmt: skip
        out[m, 1] = (
            u0 * w0 * (f[2, m] - f[0, m]) + u1 * w0 * (f[3, m] - f[1, m])
            + u0 * w1 * (f[6, m] - f[4, m]) + u1 * w1 * (f[7, m] - f[5, m])
        ) / hy  # fmt: skip
        out[m, 2] = (
            u0 * v0 * (f[4, m] - f[0, m]) + u1 * v0 * (f[5, m] - f[1, m])
            + u0 * v1 * (f[6, m] - f[2, m]) + u1 * v1 * (f[7, m] - f[3, m])
        ) / hz  # fmt: skip


@jit
def crossing_time(here: Here, p: Floats, v: Floats, a: Floats, where: Integers) -> float:
    """When p + v t + a t^2 / 2 first leaves the cell, by the axis and side in `where`; inf if never."""
    first = np.inf
    for m in range(3):
        for side in range(2):
            # distance inside the face, its rate and its acceleration
            if side == 0:
                g, r, s = p[m] - here.low[m], v[m], 0.5 * a[m]
            else:
                g, r, s = here.high[m] - p[m], -v[m], -0.5 * a[m]
            g = max(g, 0.0)
            t = np.inf
            root = r * r - 4.0 * s * g
            if root >= 0.0:
                root = np.sqrt(root)
                if r < 0.0:
                    t = 2.0 * g / (root - r)  # the nearer root, without cancellation
                elif s < 0.0:
                    t = (r + root) / (-2.0 * s)
            if t < first:
                first = t
                where[0], where[1] = m, side
    return first


@jit
def onwards(flow: Flow, here: Here, axis: int, side: int) -> int:
    """Into the neighbour beyond a face: 0 done, 1 there is none (the border of the domain), 2 it is a hole."""
    n = flow.x.size if axis == 0 else (flow.y.size if axis == 1 else flow.z.size)
    there = here.cell[axis] + (1 if side else -1)
    if there < 0 or there > n - 2:
        return 1
    here.cell[axis] = there
    return 0 if load(flow, here) else 2
