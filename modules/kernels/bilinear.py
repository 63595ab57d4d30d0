"""The bilinear cell: F(u, v) = a u + b v + c u v + d on the unit square, from its corner values f00, f10, f01, f11.

The first digit of a corner is u (along x), the second v (along y). Every function takes scalars or arrays that
broadcast; the kernels marked `jit` or `inlined` take scalars and are called by other kernels.

Source: thesis section 3.2, equations (3.2)-(3.5).
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import inlined, jit

Floats = npt.NDArray[np.float64]

CLEAR = 1e-3
"""A determinant larger than this part of its two products is right to 5e-13 as it stands."""


def coefficients(
    f00: npt.ArrayLike, f10: npt.ArrayLike, f01: npt.ArrayLike, f11: npt.ArrayLike
) -> tuple[Floats, Floats, Floats, Floats]:
    """The coefficients a, b, c, d of F.

    Source: thesis (3.2).
    """
    g00, g10, g01, g11 = (np.asarray(f, np.float64) for f in (f00, f10, f01, f11))
    return g10 - g00, g01 - g00, (g11 - g10) - (g01 - g00), g00


def value(
    f00: npt.ArrayLike,
    f10: npt.ArrayLike,
    f01: npt.ArrayLike,
    f11: npt.ArrayLike,
    u: npt.ArrayLike,
    v: npt.ArrayLike,
) -> Floats:
    """F at the place (u, v) of the cell, as a weighted mean of the corners (exact at the corners).

    Source: thesis (3.2).
    """
    f = [np.asarray(corner, np.float64) for corner in (f00, f10, f01, f11)]
    p, q = np.asarray(u, np.float64), np.asarray(v, np.float64)
    mean: Floats = ((1 - p) * f[0] + p * f[1]) * (1 - q) + ((1 - p) * f[2] + p * f[3]) * q
    return mean


def gradient(
    f00: npt.ArrayLike,
    f10: npt.ArrayLike,
    f01: npt.ArrayLike,
    f11: npt.ArrayLike,
    u: npt.ArrayLike,
    v: npt.ArrayLike,
) -> tuple[Floats, Floats]:
    """F_u = a + c v and F_v = b + c u, per cell width and cell height.

    Source: thesis (3.3).
    """
    a, b, c, _ = coefficients(f00, f10, f01, f11)
    return a + c * np.asarray(v, np.float64), b + c * np.asarray(u, np.float64)


def saddle(f00: npt.ArrayLike, f10: npt.ArrayLike, f01: npt.ArrayLike, f11: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
    """The saddle's place (u, v) and value; not a number where F is linear (c = 0).

    Source: thesis (3.4).
    """
    a, b, c, d = coefficients(f00, f10, f01, f11)
    c = np.where(c == 0, np.nan, c)
    return -b / c, -a / c, d - a * b / c


@inlined
def twist(f00: float, f10: float, f01: float, f11: float) -> float:
    """The coefficient c = f00 + f11 - f10 - f01; 0 exactly where F is linear.

    Accuracy: rounding of c itself, however small it is beside the corner values.
    """
    upper, upper_rest = _difference(f11, f10)
    lower, lower_rest = _difference(f01, f00)
    c, rest = _difference(upper, lower)
    return c + (rest + (upper_rest - lower_rest))


@jit
def determinant(f00: float, f10: float, f01: float, f11: float, level: float) -> float:
    """(f00 - L)(f11 - L) - (f10 - L)(f01 - L) = c (F(S) - L), with the right sign.

    The sign tells, without a division, which side of the level the saddle S lies on; minus this number is
    ab - cd, the product F_u F_v that is the same all along the contour.

    Accuracy: 5e-13 relative to exact arithmetic on the given floats, hence the sign, and whether it is 0, are exact
    (unless a product underflows).
    Source: Nielson and Hamann 1991 (asymptotic decider); thesis (3.4), (3.5); expansions: Shewchuk 1997.
    """
    g00, g10, g01, g11 = f00 - level, f10 - level, f01 - level, f11 - level
    first, second = g00 * g11, g10 * g01
    det = first - second
    if abs(det) > CLEAR * (abs(first) + abs(second)):
        return det
    if (g00 == 0.0 or g11 == 0.0) and (g10 == 0.0 or g01 == 0.0):
        return 0.0
    size = max(max(abs(f00), abs(f10)), max(abs(f01), abs(f11)), abs(level))
    s = math.ldexp(1.0, -max(math.frexp(size)[1], -1000))  # a power of two, lest a product overflows
    return _exact_determinant(f00 * s, f10 * s, f01 * s, f11 * s, level * s) / s / s


@jit
def _exact_determinant(f00: float, f10: float, f01: float, f11: float, level: float) -> float:
    terms = np.zeros(16)  # a sum kept as floats that do not overlap, the smallest first
    used = 0
    for sign, f, g in ((1.0, f00, f11), (-1.0, f10, f01)):
        for p in _difference(f, level):
            for q in _difference(g, level):
                for term in _product(sign * p, q):
                    rest = term
                    for i in range(used):
                        rest, terms[i] = _sum(rest, terms[i])
                    terms[used] = rest
                    used += 1
    total = 0.0
    for i in range(used):
        total += terms[i]
    return total


@inlined
def _sum(a: float, b: float) -> tuple[float, float]:
    """The sum, rounded, and the rounding error."""
    total = a + b
    b_part = total - a
    return total, (a - (total - b_part)) + (b - b_part)


@inlined
def _difference(a: float, b: float) -> tuple[float, float]:
    """The difference, rounded, and the rounding error."""
    return _sum(a, -b)


@jit
def _product(a: float, b: float) -> tuple[float, float]:
    """The product, rounded, and the rounding error."""
    product = a * b
    a_cut, b_cut = a * 134217729.0, b * 134217729.0  # 2^27 + 1
    a_high, b_high = a_cut - (a_cut - a), b_cut - (b_cut - b)
    a_low, b_low = a - a_high, b - b_high
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return product, error
