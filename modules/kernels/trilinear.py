"""The trilinear cell F = a + ex + cy + bz + gxy + fxz + dyz + hxyz on the unit cube: derivatives and the points they tell.

Every function takes m cells as (m, 8) values at the corners 000, 001, 010, 011, 100, 101, 110, 111 of xyz.

Source: Lopes 1999, (4.11)-(4.37), with its misprints put right; (4.37) anew, from the form centred at (-d/h, -f/h, -g/h).
"""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

ON_SURFACE = 1e-9
"""Of the largest corner value: where |F| is larger at an inflection point, that is a spurious root on a constant face."""


def coefficients(f: Floats) -> Floats:
    """(m, 8) a, b, c, d, e, f, g, h."""
    f000, f001, f010, f011, f100, f101, f110, f111 = f.T
    a, b, c, e = f000, f001 - f000, f010 - f000, f100 - f000
    d, xz, xy = (f011 - f010) - b, (f101 - f100) - b, (f110 - f100) - c
    xyz = ((f111 - f110) - (f101 - f100)) - ((f011 - f010) - (f001 - f000))
    return np.stack([a, b, c, d, e, xz, xy, xyz], axis=1)


def value(f: Floats, at: Floats) -> Floats:
    """(m, ...) F at places (m, ..., 3)."""
    x, y, z = (at[..., n] for n in range(3))
    corner = f.reshape(len(f), *[1] * (at.ndim - 2), 8)
    total: Floats = np.zeros(np.broadcast_shapes(corner.shape[:-1], x.shape))
    for c in range(8):
        total = total + corner[..., c] * _weight(x, c >> 2) * _weight(y, (c >> 1) & 1) * _weight(z, c & 1)
    return total


def gradient(f: Floats, at: Floats) -> Floats:
    """(m, ..., 3) the derivatives of F along x, y, z at places (m, ..., 3)."""
    where = [at[..., n] for n in range(3)]
    corner = f.reshape(len(f), *[1] * (at.ndim - 2), 8)
    total = np.zeros(np.broadcast_shapes((*corner.shape[:-1], 3), at.shape))
    for c in range(8):
        bits = (c >> 2, (c >> 1) & 1, c & 1)
        for axis in range(3):
            others = [_weight(where[n], bits[n]) for n in range(3) if n != axis]
            total[..., axis] += (1.0 if bits[axis] else -1.0) * corner[..., c] * others[0] * others[1]
    return total


def _weight(t: Floats, high: int) -> Floats:
    return t if high else 1 - t


def discriminant(f: Floats) -> Floats:
    """(m,) the one discriminant of the three quadratics (Cayley's hyperdeterminant): below 0 there are no inflection points.

    Source: Lopes 1999, (4.29)-(4.34).
    """
    second, first, last = _quadratic(coefficients(f), 2)
    result: Floats = first**2 - 4 * second * last
    return result


def _quadratic(k: Floats, axis: int) -> tuple[Floats, Floats, Floats]:
    """The quadratic whose roots are the coordinates, along an axis, of its inflection points."""
    p0, p, m, q, n, r, h, a = _along(k, axis)
    return m * n - p0 * h, p * n + m * q - p0 * r - a * h, p * q - a * r


def _along(k: Floats, axis: int) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats]:
    """F = (a + k s) + (p + m s) P + (q + n s) Q + (r + h s) P Q along an axis; k, p, m, q, n, r, h, a."""
    a, b, c, d, e, xz, xy, xyz = k.T
    if axis == 2:
        return b, e, xz, c, d, xy, xyz, a
    if axis == 1:
        return c, e, xy, b, d, xz, xyz, a
    return e, c, xy, b, xz, d, xyz, a


def inflections(f: Floats) -> Floats:
    """(m, 3, 2, 3) the two inflection points of each axis, in ascending order along it; nan where there is none.

    They may lie outside the cell. F and its derivatives across the axis are 0 there.
    """
    k = coefficients(f)
    points = np.full((len(f), 3, 2, 3), np.nan)
    with np.errstate(all="ignore"):
        for axis in range(3):
            second, first, last = _quadratic(k, axis)
            size = np.maximum(np.maximum(np.abs(second), np.abs(first)), np.abs(last))
            root = np.sqrt(first**2 - 4 * second * last)
            q = -0.5 * (first + np.copysign(root, first))
            linear = np.abs(second) <= 1e-15 * size
            one, two = np.where(linear, -last / first, q / second), np.where(linear, np.nan, last / q)
            both = np.sort(np.stack([one, two], axis=1), axis=1)
            k0, p, m, n_q, n, r, h, a = (part[:, None] for part in _along(k, axis))
            here, along_p, along_q, mixed = a + k0 * both, p + m * both, n_q + n * both, r + h * both
            across = [c for c in range(3) if c != axis]
            points[:, axis, :, axis] = both
            # F_P = 0 gives Q, F_Q = 0 gives P; of two equivalent forms the one that divides by more
            points[:, axis, :, across[1]] = _larger(-here, along_q, -along_p, mixed)
            points[:, axis, :, across[0]] = _larger(-here, along_p, -along_q, mixed)
    return points


def _larger(one: Floats, below_one: Floats, two: Floats, below_two: Floats) -> Floats:
    return np.asarray(np.where(np.abs(below_two) > np.abs(below_one), two / below_two, one / below_one))


def inside(at: Floats) -> Bools:
    """(...) whether places (..., 3) lie strictly within the cell; False for nan."""
    return np.asarray(((at > 0) & (at < 1)).all(axis=-1))


def inner_inflections(f: Floats) -> Bools:
    """(m, 3, 2) which inflection points lie within the cell and on the surface."""
    points = inflections(f)
    size = np.abs(f).max(axis=1)[:, None, None]
    with np.errstate(invalid="ignore"):
        return np.asarray(inside(points) & (np.abs(value(f, points)) <= ON_SURFACE * size))


def hexagon(f: Floats) -> Floats:
    """(m, 6, 3) the six inflection points in cyclic order: neighbours differ in one coordinate, and F = 0 between them.

    Source: Lopes 1999, proposition 4.2.1.4, with its indices put right.
    """
    of_z = inflections(f)[:, 2]
    which = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 1, 0]])
    return np.stack([np.stack([of_z[:, which[n, axis], axis] for axis in range(3)], axis=1) for n in range(6)], axis=1)


def body_saddles(f: Floats) -> Floats:
    """(m, 2, 3) where all derivatives are 0; nan where there is no such point. They may lie outside the cell."""
    _, b, c, d, e, xz, xy, h = coefficients(f).T
    points = np.full((len(f), 2, 3), np.nan)
    with np.errstate(all="ignore"):
        along = [e - xz * xy / h, c - d * xy / h, b - d * xz / h]
        root = np.sqrt(-along[0] * along[1] * along[2] / h)
        for n, sign in enumerate((1, -1)):
            for axis, shift in enumerate((d, xz, xy)):
                points[:, n, axis] = -sign * root / along[axis] - shift / h
    flat = np.flatnonzero((h == 0) & (d * xz * xy != 0))
    for m in flat:
        matrix = np.array([[0, xy[m], xz[m]], [xy[m], 0, d[m]], [xz[m], d[m], 0]])
        points[m, 0] = np.linalg.solve(matrix, -np.array([e[m], c[m], b[m]]))
    points[~np.isfinite(points).all(axis=2)] = np.nan
    return points
