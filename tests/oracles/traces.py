"""Particles through a piecewise trilinear velocity, to the last digits: Taylor series in extended precision, cell by cell.

Within a cell the velocity is a polynomial, so the solution is a power series whose coefficients follow from one another. A
step takes `ORDER` of them, as far as they tell the position to `SMALL` of a cell, or to the face where the series first
goes out; excursions between two places where it is looked at are found by their lowest point. Nothing of the project's
kernels is used. Where the machine's long double is a double the digits are those of a double.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Long = NDArray[np.longdouble]
Ints = NDArray[np.int64]

ORDER = 26
SMALL = 1e-20
LOOKS = 64
MOST = 20_000


class Exact(NamedTuple):
    """Of p particles: (p, n, 3) positions at the times, NaN from the exit on; (p,) time of exit, inf for none; (p, 3) where."""

    points: NDArray[np.float64]
    left: NDArray[np.float64]
    exits: NDArray[np.float64]


def exact(values: Any, axes: Any, seeds: Any, times: Any) -> Exact:
    """Follow particles from seeds (p, 3) to ascending times (n,).

    Parameters
    ----------
    values : (nz, ny, nx, 3) velocity
    axes : ascending coordinates of the samples along x, y, z
    """
    field, axes = np.asarray(values, np.longdouble), [np.asarray(a, np.longdouble) for a in axes]
    wanted = np.asarray(times, np.longdouble)
    at = np.asarray(seeds, np.longdouble).copy()
    cell = np.stack([np.clip(np.searchsorted(a, at[:, m], "right") - 1, 0, len(a) - 2) for m, a in enumerate(axes)], axis=1)
    low, edge = _box(axes, cell)
    u, now = (at - low) / edge, np.zeros(len(at), np.longdouble)
    found = Exact(np.full((len(at), len(wanted), 3), np.nan), np.full(len(at), np.inf), np.full((len(at), 3), np.nan))
    found.points[:, wanted <= 0] = np.asarray(at, float)[:, None]
    going = np.ones(len(at), bool)
    for _ in range(MOST):
        some = np.flatnonzero(going & (now < wanted[-1]))
        if not len(some):
            return found
        series = _series(_monomials(field, axes, cell[some]), u[some])
        span = np.minimum(_reach(series), wanted[-1] - now[some])
        face, taken = _exits(series, span)
        low, edge = _box(axes, cell[some])
        for row, i in enumerate(some):
            inside = np.flatnonzero((wanted > now[i]) & (wanted <= now[i] + taken[row]))
            if len(inside):
                then = _polynomial(series[:, row, :, None], (wanted[inside] - now[i])[None])
                found.points[i, inside] = np.asarray(low[row] + then.T * edge[row], float)
        now[some] += taken
        u[some] = np.clip(_polynomial(series, taken[:, None]), 0, 1)
        for row in np.flatnonzero(face >= 0).tolist():
            who, axis, side = int(some[row]), int(face[row]) >> 1, int(face[row]) & 1
            cell[who, axis] += 1 if side else -1
            u[who, axis] = 0 if side else 1
            if not 0 <= cell[who, axis] <= len(axes[axis]) - 2:
                cell[who, axis] -= 1 if side else -1
                u[who, axis] = 1 if side else 0
                going[who], found.left[who] = False, float(now[who])
                found.exits[who] = np.asarray(low[row] + u[who] * edge[row], float)
    raise RuntimeError(f"a particle has not come to its end in {MOST} steps")


def _box(axes: list[Long], cell: Ints) -> tuple[Long, Long]:
    """(p, 3) low corners and edges of cells."""
    low = np.stack([a[cell[:, m]] for m, a in enumerate(axes)], axis=1)
    return low, np.stack([a[cell[:, m] + 1] for m, a in enumerate(axes)], axis=1) - low


def _monomials(field: Long, axes: list[Long], cell: Ints) -> Long:
    """(8, p, 3) coefficients of 1, u, v, uv, w, uw, vw, uvw in cells a second."""
    corner = np.stack([
        field[cell[:, 2] + (k >> 2), cell[:, 1] + (k >> 1 & 1), cell[:, 0] + (k & 1)] for k in range(8)
    ])  # fmt: skip
    for bit in (1, 2, 4):
        for k in range(8):
            if k & bit:
                corner[k] = corner[k] - corner[k - bit]
    return np.asarray(corner / _box(axes, cell)[1])


def _series(a: Long, u: Long) -> Long:
    """(ORDER + 1, p, 3) coefficients of the coordinates in powers of time."""
    one = np.zeros((ORDER + 1, len(u), 3), np.longdouble)
    pairs = np.zeros((ORDER + 1, len(u), 4), np.longdouble)  # uv, uw, vw, uvw
    one[0] = u
    for n in range(ORDER):
        x, y, z = (one[: n + 1, :, m] for m in range(3))
        pairs[n, :, 0] = (x * y[::-1]).sum(axis=0)
        pairs[n, :, 1] = (x * z[::-1]).sum(axis=0)
        pairs[n, :, 2] = (y * z[::-1]).sum(axis=0)
        pairs[n, :, 3] = (pairs[: n + 1, :, 0] * z[::-1]).sum(axis=0)
        rate = a[1] * x[n, :, None] + a[2] * y[n, :, None] + a[4] * z[n, :, None]
        for k, p in ((3, 0), (5, 1), (6, 2), (7, 3)):
            rate = rate + a[k] * pairs[n, :, p, None]
        one[n + 1] = (rate + (a[0] if n == 0 else 0)) / (n + 1)
    return one


def _reach(series: Long) -> Long:
    """(p,) the time for which the series tells the position to `SMALL`, by its last two coefficients."""
    reach = np.full(series.shape[1], np.inf, np.longdouble)
    for n in (ORDER, ORDER - 1):
        size = np.abs(series[n]).max(axis=1)
        reach = np.minimum(reach, np.where(size > 0, (SMALL / np.where(size > 0, size, 1)) ** (np.longdouble(1) / n), np.inf))
    return np.asarray(reach)


def _polynomial(series: Long, time: Long) -> Long:
    total = np.zeros(np.broadcast_shapes(series.shape[1:], time.shape), np.longdouble)
    for c in series[::-1]:
        total = total * time + c
    return total


def _exits(series: Long, span: Long) -> tuple[Ints, Long]:
    """(p,) the face, twice the axis and one more at the high end, through which each goes out first in a time, and when; -1."""
    look = np.linspace(0, 1, LOOKS + 1).astype(np.longdouble)
    times = span[:, None] * look
    face, taken = np.full(len(span), -1), span.copy()
    for axis in range(3):
        along = _polynomial(series[:, :, axis, None], times)
        for side in range(2):
            depth = 1 - along if side else along
            c = -series[:, :, axis] if side else series[:, :, axis].copy()
            if side:
                c[0] = 1 + c[0]
            middle = depth[:, 1:-1]
            dips = (middle <= depth[:, :-2]) & (middle <= depth[:, 2:]) & (middle < 0.05)
            for row in np.flatnonzero((depth[:, 1:] < 0).any(axis=1) | dips.any(axis=1)):
                when = _first(c[:, row], times[row], depth[row], dips[row])
                if when < taken[row] or (when == taken[row] and face[row] < 0 and depth[row, -1] < 0):
                    face[row], taken[row] = 2 * axis + side, when
    return face, taken


def _first(c: Long, times: Long, depth: Long, dips: Any) -> Any:
    """When a depth first falls below 0; inf if it does not."""
    for k in range(1, len(times)):
        before, after = times[k - 1], times[k]
        lowest = after if depth[k] < 0 else None
        if lowest is None and k < len(times) - 1 and dips[k - 1]:
            bottom = _lowest(c, times[k - 1], times[k + 1])
            lowest = bottom if _polynomial(c, bottom) < 0 else None
        if lowest is not None:
            return _root(c, before, lowest)
    return np.inf


def _lowest(c: Long, a: Any, b: Any) -> Any:
    rate = c[1:] * np.arange(1, len(c))
    for _ in range(70):
        middle = (a + b) / 2
        a, b = (middle, b) if _polynomial(rate, middle) < 0 else (a, middle)
    return (a + b) / 2


def _root(c: Long, a: Any, b: Any) -> Any:
    for _ in range(70):
        middle = (a + b) / 2
        a, b = (a, middle) if _polynomial(c, middle) < 0 else (middle, b)
    return (a + b) / 2
