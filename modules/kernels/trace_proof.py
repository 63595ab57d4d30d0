"""A proven tube about a trace: how far the exact path through the interpolated velocity can be from it.

Through the rows of a trace goes a curve of fifth degree, with the velocities and accelerations that its cell has there. Its
defect, its own velocity less that of the field, is a polynomial, bounded by its coefficients in Bernstein's form. The
distance r to the exact path then obeys r' <= mu r + |defect|, with mu the largest logarithmic norm, the largest eigenvalue
of the symmetric part of the derivative, in a box about curve and tube. The derivative is multi-affine in each cell and the
eigenvalue convex, so the corners of the box, cell by cell, bound it. Every sum is widened by what rounding may do.

Source: Dahlquist 1958 (logarithmic norm); Farouki and Rajan 1987 (Bernstein form).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import comb
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.trace_cell import BOX, NT, Flow
from modules.kernels.trace_fields import axes_of

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

EPS = float(np.finfo(float).eps)
DEGREE, WHOLE = 5, 15
"""Of the curve, and of a trilinear polynomial on it."""

ROUNDS = 8
"""Most often a box is widened until it holds the tube; then the proof ends."""

MOST = 50.0
"""A piece that may stretch a distance by more than e to this power ends it as well."""

SPAN = 3
"""A box that touches more cells along an axis ends the proof."""


class Pieces(NamedTuple):
    """Of s pieces of curves: (s,) duration; (s,) integral of the defect; (s, 3) ends of their boxes; (s,) how far they may
    leave their cells.
    """

    time: Floats
    defect: Floats
    low: Floats
    high: Floats
    beyond: Floats


def provable(flow: Flow) -> bool:
    """Whether a tube can be proven: a steady velocity, trilinear in boxes."""
    return flow.form == BOX and not flow.flat and int(flow.whole[NT]) == 1


def proven(
    flow: Flow, offsets: Integers, time: Floats, points: Floats, check: Callable[[float], None] = lambda fraction: None
) -> Floats:
    """(n,) radius about each row of traces in which the exact path from the same seed is then; inf where none is proven.

    Parameters
    ----------
    flow : for which `provable` holds
    offsets, time, points : of traces whose rows hold all ends of steps, so that no piece between two rows leaves a cell
    check : called with the fraction done between blocks of work
    """
    axes = axes_of(flow)
    values = flow.numbers[: 3 * axes[0].size * axes[1].size * axes[2].size]
    values = values.reshape(axes[2].size, axes[1].size, axes[0].size, 3)
    begins = np.setdiff1d(np.arange(len(time)), offsets[1:] - 1)
    pieces = _pieces(values, axes, time, points, begins)
    piece = np.full(len(time), -1)
    piece[begins] = np.arange(len(begins))
    radius, most = np.zeros(len(time)), int(np.diff(offsets).max(initial=0))
    for k in range(most - 1):
        check(k / most)
        rows = offsets[:-1][np.diff(offsets) > k + 1] + k
        known = np.isfinite(radius[rows])
        radius[rows[~known] + 1] = np.inf
        rows = rows[known]
        radius[rows + 1] = _over(values, axes, Pieces(*(part[piece[rows]] for part in pieces)), radius[rows])
    return radius


def _over(values: Floats, axes: list[Floats], piece: Pieces, before: Floats) -> Floats:
    """(q,) radius at the ends of pieces, by that at their begins."""
    widest = float(np.linalg.norm([np.ptp(a) for a in axes]))
    reach = 1.5 * (before + piece.defect) + 1e-300
    held, after = np.zeros(len(before), bool), np.full(len(before), np.inf)
    for _ in range(ROUNDS):
        left = np.flatnonzero(~held & (reach < widest))
        if not len(left):
            break
        norm, steep = _norms(values, axes, piece.low[left] - reach[left, None], piece.high[left] + reach[left, None])
        ends = norm * piece.time[left] > MOST
        reach[left[ends]] = np.inf
        left, norm, steep = left[~ends], norm[~ends], steep[~ends]
        grown = np.exp(norm * piece.time[left])
        added = piece.defect[left] + 4.0 * steep * piece.beyond[left] * piece.time[left]
        largest = np.maximum(grown, 1.0) * (before[left] + added)
        after[left] = (grown * before[left] + np.maximum(grown, 1.0) * added) * (1.0 + 16 * EPS)
        held[left] = largest <= reach[left]
        reach[left] = np.where(held[left], reach[left], 2.0 * largest)
    return np.where(held, after, np.inf)


def _pieces(values: Floats, axes: list[Floats], time: Floats, points: Floats, begins: Integers) -> Pieces:
    """The curves that begin at some rows and end at the next, and their defects."""
    p, q, h = points[begins], points[begins + 1], np.diff(time)[begins]
    cell = np.stack([_cell(a, 0.5 * (p + q)[:, m]) for m, a in enumerate(axes)], axis=1)
    low, edge = _box(axes, cell)
    terms = _monomials(values, cell)
    ends = []
    for at in (p, q):
        u = (at - low) / edge
        speed = _value(terms, u)
        ends += [at, speed, np.einsum("sma,sa->sm", _derivative(terms, edge, u), speed)]
    control = _control(ends, h[:, None])
    defect = _defect(terms, (control - low[:, None]) / edge[:, None], control, h)
    fast = np.abs(terms).sum(axis=(0, 2))
    far = np.abs(points).max(initial=0.0) + max(float(np.ptp(a)) for a in axes)
    rounding = 64 * EPS * (far + fast * (h + time[begins + 1]))
    outside = np.maximum(low[:, None] - control, control - (low + edge)[:, None]).max(axis=(1, 2))
    slack = np.where(outside < 0.1 * edge.min(axis=1), np.maximum(outside, 0.0), np.inf)
    whole = h * np.linalg.norm(defect, axis=2).mean(axis=1) + rounding
    return Pieces(h, np.where(np.isfinite(slack), whole, np.inf), control.min(axis=1), control.max(axis=1), slack)


def _control(ends: list[Floats], h: Floats) -> Floats:
    """(s, 6, 3) Bernstein coefficients of the curve by position, velocity and acceleration at both ends."""
    p, v, a, q, w, b = ends
    early = (p, p + h * v / 5, p + 2 * h * v / 5 + h * h * a / 20)
    return np.stack([*early, q - 2 * h * w / 5 + h * h * b / 20, q - h * w / 5, q], axis=1)


def _defect(terms: Floats, u: Floats, control: Floats, h: Floats) -> Floats:
    """(s, 16, 3) Bernstein coefficients of the velocity of the curve less that of the field on it."""
    short = np.where(h > 0, h, 1.0)
    total = _raise(DEGREE * np.diff(control, axis=1) / short[:, None, None], WHOLE)
    total[h <= 0] = 0.0
    x, y, z = (u[:, :, m : m + 1] for m in range(3))
    pair = _times(x, y)
    parts = (np.ones_like(x[:, :1]), x, y, pair, z, _times(x, z), _times(y, z), _times(pair, z))
    for term, part in zip(terms, parts, strict=True):
        total = total - np.where(h > 0, 1.0, 0.0)[:, None, None] * _raise(part, WHOLE) * term[:, None]
    return np.asarray(total)


def _times(a: Floats, b: Floats) -> Floats:
    """The product of two polynomials in Bernstein's form, (s, degree + 1, 1)."""
    m, n = a.shape[1] - 1, b.shape[1] - 1
    out = np.zeros((len(a), m + n + 1, 1))
    for i in range(m + 1):
        for j in range(n + 1):
            out[:, i + j] += comb(m, i) * comb(n, j) / comb(m + n, i + j) * a[:, i] * b[:, j]
    return out


def _raise(a: Floats, degree: int) -> Floats:
    """The same polynomial in Bernstein's form of a higher degree."""
    n = a.shape[1] - 1
    by = degree - n
    matrix = np.array([
        [comb(n, i) * comb(by, k - i) / comb(degree, k) if 0 <= k - i <= by else 0.0 for i in range(n + 1)]
        for k in range(degree + 1)
    ])  # fmt: skip
    return np.asarray(np.einsum("ki,sim->skm", matrix, a))


def _cell(axis: Floats, x: Floats) -> Integers:
    return np.clip(np.searchsorted(axis, x, side="right") - 1, 0, len(axis) - 2).astype(np.int64)


def _box(axes: list[Floats], cell: Integers) -> tuple[Floats, Floats]:
    """(s, 3) low corners and edges of cells."""
    low = np.stack([a[cell[:, m]] for m, a in enumerate(axes)], axis=1)
    return low, np.stack([a[cell[:, m] + 1] for m, a in enumerate(axes)], axis=1) - low


def _monomials(values: Floats, cell: Integers) -> Floats:
    """(8, s, 3) coefficients of 1, u, v, uv, w, uw, vw, uvw in cells."""
    found = np.stack([
        values[cell[:, 2] + (k >> 2), cell[:, 1] + (k >> 1 & 1), cell[:, 0] + (k & 1)] for k in range(8)
    ])  # fmt: skip
    for bit in (1, 2, 4):
        for k in range(8):
            if k & bit:
                found[k] = found[k] - found[k - bit]
    return found


def _value(t: Floats, u: Floats) -> Floats:
    x, y, z = (u[..., m, None] for m in range(3))
    return np.asarray(t[0] + x * (t[1] + y * t[3]) + y * t[2] + z * (t[4] + x * (t[5] + y * t[7]) + y * t[6]))


def _derivative(t: Floats, edge: Floats, u: Floats) -> Floats:
    """(s, 3, 3) derivative of each component (first) along each axis."""
    x, y, z = (u[..., m, None] for m in range(3))
    along = (
        t[1] + y * t[3] + z * (t[5] + y * t[7]),
        t[2] + x * t[3] + z * (t[6] + x * t[7]),
        t[4] + x * t[5] + y * (t[6] + x * t[7]),
    )
    return np.stack([d / edge[..., m, None] for m, d in enumerate(along)], axis=-1)


def _norms(values: Floats, axes: list[Floats], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """(q,) largest logarithmic norm, and largest norm, of the derivative in boxes; inf where a box touches too many cells."""
    first = np.stack([_cell(a, low[:, m]) for m, a in enumerate(axes)], axis=1)
    last = np.stack([_cell(a, high[:, m]) for m, a in enumerate(axes)], axis=1)
    norm, steep = np.full(len(low), -np.inf), np.zeros(len(low))
    wide = (last - first >= SPAN).any(axis=1)
    for offset in product(range(SPAN), repeat=3):
        some = np.flatnonzero((first + offset <= last).all(axis=1) & ~wide)
        if not len(some):
            continue
        cell = first[some] + offset
        begin, edge = _box(axes, cell)
        terms = _monomials(values, cell)
        sides = [(np.clip(bound[some], begin, begin + edge) - begin) / edge for bound in (low, high)]
        for corner in product((0, 1), repeat=3):
            u = np.stack([sides[side][:, m] for m, side in enumerate(corner)], axis=1)
            slope = _derivative(terms, edge, u)
            size = np.linalg.norm(slope, axis=(1, 2))
            largest = np.linalg.eigvalsh(0.5 * (slope + slope.transpose(0, 2, 1)))[:, 2] + 256 * EPS * size
            norm[some], steep[some] = np.maximum(norm[some], largest), np.maximum(steep[some], size)
    norm[wide] = np.inf
    return norm, steep
