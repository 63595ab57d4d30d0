"""Arcs of hyperbolas whose asymptotes are parallel to the axes: the contours of bilinear interpolants.

An arc runs from P to Q = P + (dx, dy) with the *bend* w = ln(F_y(Q) / F_y(P)) = ln(F_x(P) / F_x(Q)). Measured from the
saddle it is X = X_P e^(w t), Y = Y_P e^(-w t), 0 <= t <= 1, hence

    x = x_P + dx (e^(w t) - 1) / (e^w - 1),    y = y_P + dy (1 - e^(-w t)) / (1 - e^(-w)).

With w = 0 it is the chord; with w -> +inf it goes along y and then along x. A bend of +-`TURN` stands for that right
angle (the saddle on the level). The point t = 1/2 is the shoulder point, where the tangent is parallel to the chord;
each half is an arc of bend w/2. All functions broadcast, take any finite bend and never overflow. Areas are in the
product of the units of dx and dy; where the two are mixed (`sagitta`, `length`) they must have the same unit.

Source: thesis section 3.3.1, proposition 3.3.1.2 (F_x F_y is constant along the contour).
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

TURN = 1000.0
"""The bend that stands for a right angle: e^-TURN is nothing beside 1, and TURN itself is far from overflow."""

STRAIGHT = 2.0**-50
"""A smaller bend is none: the shoulder point is the middle of the chord, to rounding."""

_SINH = tuple(1.0 / math.factorial(2 * k + 3) for k in range(9))
_COSH = tuple(2.0 / math.factorial(2 * k + 2) for k in range(9))
_LONG, _SHORT = np.polynomial.legendre.leggauss(32), np.polynomial.legendre.leggauss(10)
_PANEL = 2.5  # of bend: 32 nodes give the length of such a piece to rounding (the speed is analytic up to i pi / 4)
_SLIGHT = 0.5  # of bend: 10 nodes do
_FAR = 10.0  # of bend from where |dx/dt| = |dy/dt|: there the longer is the length, to rounding


@jit
def shoulder_share(bend: float) -> float:
    """1 / (1 + e^(|w|/2)): the part of the chord that the shoulder point takes along the axis it covers last.

    The shoulder point is (x_P + s dx, y_Q - s dy) if w > 0, (x_Q - s dx, y_P + s dy) if w < 0.
    """
    q = math.exp(-0.5 * abs(bend))
    return q / (1.0 + q)


def point(start: npt.ArrayLike, end: npt.ArrayLike, bend: npt.ArrayLike, t: npt.ArrayLike) -> Floats:
    """The point at parameter t of each arc.

    Parameters
    ----------
    start, end : (..., 2)
        x, y of P and Q.
    bend, t : (...)
        t from 0 at P to 1 at Q; equal steps of t are equal steps of ln F_y, not of length.

    Returns
    -------
    (..., 2)

    Accuracy: rounding.
    """
    p, q = np.asarray(start, np.float64), np.asarray(end, np.float64)
    w, s = np.asarray(bend, np.float64), np.asarray(t, np.float64)
    early = _early(np.abs(w), s)
    late = early * np.exp(-np.abs(w) * (1.0 - s))
    share = np.stack(np.broadcast_arrays(np.where(w > 0, late, early), np.where(w > 0, early, late)), axis=-1)
    at: Floats = np.where(share <= 0.5, p + share * (q - p), q - (1.0 - share) * (q - p))
    return at


def _early(a: Floats, t: Floats) -> Floats:
    """(1 - e^(-a t)) / (1 - e^-a) for a >= 0: the part of the chord covered along the axis that comes first."""
    safe = np.where(a > 0, a, 1.0)
    share: Floats = np.where(a > 0, np.expm1(-safe * t) / np.expm1(-safe), t)
    return share


def area(dx: npt.ArrayLike, dy: npt.ArrayLike, bend: npt.ArrayLike) -> Floats:
    """The area between arc and chord, |dx dy| (sinh w - w) / (4 sinh^2(w/2)).

    It is at least four times what its two halves leave; |dx dy| / 2 at a right angle.

    Accuracy: 1e-14 relative for given arguments.
    Source: thesis (3.28), (3.29), integrated without a division by c.
    """
    product = np.abs(np.asarray(dx, np.float64) * np.asarray(dy, np.float64))
    between: Floats = product * _bulge(np.abs(np.asarray(bend, np.float64)))
    return between


def _bulge(a: Floats) -> Floats:
    """(sinh a - a) / (4 sinh^2(a/2)) for a >= 0, from 0 to 1/2: series below 1, in powers of e^-a above."""
    small, large = np.minimum(a, 1.0), np.maximum(a, 1.0)
    square = small * small
    series = small * _horner(_SINH, square) / _horner(_COSH, square)
    q = np.exp(-large)
    closed = (0.5 * (1.0 - q * q) - large * q) / (1.0 - q) ** 2
    bulge: Floats = np.where(a < 1.0, series, closed)
    return bulge


def _horner(coefficients: tuple[float, ...], x: Floats) -> Floats:
    total = np.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def sagitta(dx: npt.ArrayLike, dy: npt.ArrayLike, bend: npt.ArrayLike) -> Floats:
    """The largest distance between arc and chord, |dx dy| tanh(|w|/4) / |PQ|, reached at the shoulder point.

    It is twice the area of the triangle of P, Q and the shoulder point over |PQ|.

    Accuracy: rounding.
    """
    x, y = np.asarray(dx, np.float64), np.asarray(dy, np.float64)
    chord = np.hypot(x, y)
    height: Floats = np.abs(x) * (np.abs(y) / np.where(chord > 0, chord, 1.0))
    return height * np.tanh(np.abs(np.asarray(bend, np.float64)) / 4.0)


def length(dx: npt.ArrayLike, dy: npt.ArrayLike, bend: npt.ArrayLike) -> Floats:
    """The length of the arc.

    With tau = w t it is the integral of sqrt(A^2 e^(2 tau) + B^2 e^(-2 tau)), by Gauss-Legendre quadrature on pieces of
    2.5 around the place where both terms are equal; away from there it is the change of one coordinate.

    Accuracy: 1e-13 relative.
    """
    x, y, w = np.broadcast_arrays(*(np.asarray(each, np.float64) for each in (dx, dy, bend)))
    x, y = np.abs(x), np.abs(y)
    x, y, a = np.where(w > 0, x, y), np.where(w > 0, y, x), np.abs(w)  # now x is covered last
    total = np.asarray(np.hypot(x, y))
    curved = (a >= STRAIGHT) & (x > 0) & (y > 0)
    if curved.any():
        total[curved] = _curved_length(x[curved], y[curved], a[curved])
    return total


def _curved_length(x: Floats, y: Floats, a: Floats) -> Floats:
    # speeds per unit of tau: x e^-(a - tau) a_rate along x, y e^-tau a_rate along y, with a_rate = 1 / (1 - e^-a)
    rate = -1.0 / np.expm1(-a)
    balance = 0.5 * (a + np.log(y) - np.log(x))
    low, high = np.clip(balance - _FAR, 0.0, a), np.clip(balance + _FAR, 0.0, a)
    total: Floats = y * rate * -np.expm1(-low) + x * rate * -np.expm1(high - a)
    slight = high - low <= _SLIGHT
    panels = np.where(slight, 1, np.ceil((high - low) / _PANEL)).astype(np.int64)
    step = (high - low) / np.maximum(panels, 1)
    for panel in range(int(panels.max())):
        for which, rule in ((slight, _SHORT), (~slight, _LONG)):
            on = np.flatnonzero(which & (panels > panel))
            mean = _mean_speed(x[on], y[on], a[on], low[on] + panel * step[on], step[on], rule)
            total[on] += rate[on] * step[on] * mean
    return total


def _mean_speed(x: Floats, y: Floats, a: Floats, start: Floats, step: Floats, rule: tuple[Floats, Floats]) -> Floats:
    """The mean of sqrt((x e^(tau - a))^2 + (y e^-tau)^2) over tau from start to start + step."""
    nodes, weights = rule
    scale = np.maximum(x, y)
    decay = np.exp(-(start[:, None] + step[:, None] * (0.5 + 0.5 * nodes)))
    along_x = (x / scale * np.exp(-a))[:, None] / decay
    along_y = (y / scale)[:, None] * decay
    mean: Floats = scale * 0.5 * (np.sqrt(along_x * along_x + along_y * along_y) @ weights)
    return mean


def halvings(area: npt.ArrayLike, tolerance: npt.ArrayLike) -> Integers:
    """How often arcs must be halved at their shoulder points for their area to be within the tolerance.

    n = ceil(log4(A / tolerance)), at least 0: each halving leaves at most a quarter.

    Raises
    ------
    ValueError
        If a tolerance is not positive.

    Accuracy: enough, proven; one less may do for strongly bent arcs.
    """
    limit = np.asarray(tolerance, np.float64)
    if not (limit > 0).all():
        raise ValueError("the tolerance of an area must be positive")
    ratio = np.maximum(np.asarray(area, np.float64) / limit, 1.0)
    return np.asarray(np.ceil(np.log2(ratio) / 2.0)).astype(np.int64)


def uniform(start: Floats, end: Floats, bend: Floats, counts: npt.NDArray[np.integer], random: np.random.Generator) -> Floats:
    """Random points between arc and chord, evenly distributed over the area of each.

    Parameters
    ----------
    start, end : (n, 2)
        x, y of P and Q.
    bend : (n,)
        Of each arc.
    counts : (n,) int
        Points wanted for each arc; `np.repeat(np.arange(n), counts)` is the arc of each point.
    random
        Where the chance comes from; two numbers a point.

    Returns
    -------
    (counts.sum(), 2)
        In the order of the arcs. A straight arc gets points on itself.

    Accuracy: exact density: the area swept from P up to t is to the whole as sinh(w t) - w t to sinh w - w.
    """
    arc = np.repeat(np.arange(len(bend)), counts)
    chance = np.clip(random.random((arc.size, 2)), 2.0**-53, 1.0 - 2.0**-53)
    p, w = start[arc], np.abs(bend[arc])
    t = _swept(w, chance[:, 0])
    points: Floats = p + np.sqrt(chance[:, 1, None]) * (point(p, end[arc], bend[arc], t) - p)
    return points


def _swept(a: Floats, part: Floats) -> Floats:
    """The t with (sinh(a t) - a t) / (sinh a - a) = part, by Newton's method on the logarithm, which is concave."""
    full = np.maximum(a, 1e-6)  # below, it is t^3 to 1e-13
    goal = np.log(part) + _log_segment(full)
    z = np.cbrt(part) * full  # never beyond the root, nor are Newton's steps from there
    for _ in range(60):
        step = 2.0 * _bulge(z) * (goal - _log_segment(z))
        z = np.minimum(z + step, full)
        if (np.abs(step) <= 1e-13 * z).all():
            break
    return z / full


def _log_segment(z: Floats) -> Floats:
    """ln(sinh z - z), z > 0."""
    small, large = np.minimum(z, 1.0), np.maximum(z, 1.0)
    q = np.exp(-large)
    log: Floats = np.where(
        z < 1.0,
        3.0 * np.log(small) + np.log(_horner(_SINH, small * small)),
        large + np.log(0.5 * (1.0 - q * q) - large * q),
    )
    return log
