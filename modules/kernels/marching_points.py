"""The points of an accurate cell: crossings, shoulder points of arcs on faces and slices, inflection points.

Places are in the unit cell. Every function takes the cell's values less the level, F000, F001, F010, ... F111.

Source: Lopes 1999, sections 3.3.1, 4.2.2.1 and equations (4.17)-(4.28).
"""

import math
from importlib import import_module

import numpy as np

from modules.kernels._jit import lean_inlined, lean_part
from modules.kernels.marching_cases import ACROSS, EDGE_ENDS, FACE_CORNERS, Cell, Floats

APART = 2.0**-24
"""Of an edge or an arc: as near to its end a point may come, so that no two points of a mesh coincide."""

OFF_FACES = 2.0**-28
"""Of the cell: as near to a face an inner point may come, so that no triangle lies in a face."""

ON_SURFACE = 1e-9
"""Of the largest corner value: a larger |F| at an inflection point says that it is a spurious root on a constant face."""

DOUBLE = 1e-13
"""Of the numbers involved: a discriminant as small may be 0 but for rounding."""

HEXAGON = np.array([[2, 0, 0, 0], [1, 1, 0, 0], [0, 1, 0, 1], [2, 1, 1, 1], [1, 0, 1, 1], [0, 0, 1, 0]])
"""The six inflection points in cyclic order: their axis, and which of the two x, y, z of the axis-2 points they have."""


@lean_inlined
def put(to: Floats, place: Floats) -> None:
    """Copy a place."""
    to[0], to[1], to[2] = place[0], place[1], place[2]


@lean_part
def crossing(low: float, high: float) -> float:
    """Where F is 0 between the ends of an edge, kept apart from both."""
    return min(max(low / (low - high), APART), 1.0 - APART)


@lean_part
def place_crossing(f: Floats, edge: int, at: Floats) -> None:
    """The place of the crossing on an edge."""
    axis, a, b = edge // 4, EDGE_ENDS[edge, 0], EDGE_ENDS[edge, 1]
    at[0], at[1], at[2] = float((a >> 2) & 1), float((a >> 1) & 1), float(a & 1)
    at[axis] = crossing(f[a], f[b])


@lean_part
def shoulder(g: tuple[float, float, float, float], p: tuple[float, float], q: tuple[float, float]) -> tuple[float, float]:
    """The point of the arc from p to q where its tangent is parallel to the chord; g = F00, F10, F11, F01.

    Accuracy: on the arc to rounding, but `APART` from its ends.
    Source: thesis (3.6), (3.7), without a division by the coefficient of uv.
    """
    a, b, c = g[1] - g[0], g[3] - g[0], (g[2] - g[3]) - (g[1] - g[0])
    across_p, across_q = math.sqrt(abs(b + c * p[0])), math.sqrt(abs(b + c * q[0]))
    along_p, along_q = math.sqrt(abs(a + c * p[1])), math.sqrt(abs(a + c * q[1]))
    u, v = across_p + across_q, along_p + along_q
    u = 0.5 if u == 0.0 else min(max(across_p / u, APART), 1.0 - APART)
    v = 0.5 if v == 0.0 else min(max(along_p / v, APART), 1.0 - APART)
    return p[0] + u * (q[0] - p[0]), p[1] + v * (q[1] - p[1])


@lean_part
def _on_face(f: Floats, edge: int, p: int, q: int) -> tuple[float, float]:
    """Two coordinates of the crossing on an edge."""
    axis, a, b = edge // 4, EDGE_ENDS[edge, 0], EDGE_ENDS[edge, 1]
    t = crossing(f[a], f[b])
    return t if axis == p else float((a >> (2 - p)) & 1), t if axis == q else float((a >> (2 - q)) & 1)


@lean_part
def place_shoulder(f: Floats, face: int, first: int, second: int, at: Floats) -> None:
    """The place of the shoulder point of the arc between two edges of a face; their order does not matter."""
    axis = face // 2
    p, q = ACROSS[axis, 0], ACROSS[axis, 1]
    g = (f[FACE_CORNERS[face, 0]], f[FACE_CORNERS[face, 1]], f[FACE_CORNERS[face, 2]], f[FACE_CORNERS[face, 3]])
    at[axis] = float(face % 2)
    at[p], at[q] = shoulder(g, _on_face(f, min(first, second), p, q), _on_face(f, max(first, second), p, q))


@lean_part
def coefficients(f: Floats, size: float) -> tuple[float, float, float, float, float, float, float, float]:
    """a, b, c, d, e, f, g, h of F / size = a + ex + cy + bz + gxy + fxz + dyz + hxyz.

    Source: thesis (4.17), with the signs of h put right.
    """
    a, b, c, e = f[0] / size, f[1] / size, f[2] / size, f[4] / size
    bc, be, ce, bce = f[3] / size, f[5] / size, f[6] / size, f[7] / size
    d = (bc - c) - (b - a)
    return a, b - a, c - a, d, e - a, (be - e) - (b - a), (ce - e) - (c - a), ((bce - ce) - (be - e)) - d


@lean_part
def value(f: Floats, at: Floats) -> float:
    """F at a place, as a weighted mean of the corners."""
    x, y, z = at[0], at[1], at[2]
    low = ((1 - z) * f[0] + z * f[1]) * (1 - y) + ((1 - z) * f[2] + z * f[3]) * y
    high = ((1 - z) * f[4] + z * f[5]) * (1 - y) + ((1 - z) * f[6] + z * f[7]) * y
    result: float = low * (1 - x) + high * x
    return result


@lean_part
def is_inside(at: Floats) -> bool:
    """Whether a place lies strictly inside the unit cell."""
    result: bool = 0.0 < at[0] < 1.0 and 0.0 < at[1] < 1.0 and 0.0 < at[2] < 1.0
    return result


@lean_part
def keep_inside(at: Floats) -> None:
    """Move a place that is nearly on a face of the cell a little away from it."""
    for axis in range(3):
        at[axis] = min(max(at[axis], OFF_FACES), 1.0 - OFF_FACES)


@lean_part
def roots(a: float, b: float, c: float) -> tuple[int, float, float]:
    """The real roots of at^2 + bt + c in ascending order, and their number; none where both coincide."""
    size = max(abs(a), abs(b), abs(c))
    if abs(a) <= 1e-15 * size:
        if abs(b) <= 1e-15 * size:
            return 0, math.nan, math.nan
        return 1, -c / b, math.nan
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        return 0, math.nan, math.nan
    q = -0.5 * (b + math.copysign(math.sqrt(discriminant), b))
    first, second = q / a, (c / q if q != 0.0 else 0.0)
    return 2, min(first, second), max(first, second)


@lean_part
def _ratio(above: float, below: float, other_above: float, other_below: float) -> float:
    """-above / below, or the equivalent -other_above / other_below if that divides by more."""
    if abs(other_below) > abs(below):
        above, below = other_above, other_below
    return -above / below if below != 0.0 else math.inf


@lean_part
def _along(
    axis: int, b: float, c: float, d: float, e: float, xz: float, xy: float
) -> tuple[float, float, float, float, float, float]:
    """k, p, m, q, n, r: along the axis F = (a + k s) + (p + m s) P + (q + n s) Q + (r + xyz s) P Q."""
    if axis == 2:
        return b, e, xz, c, d, xy
    if axis == 1:
        return c, e, xy, b, d, xz
    return e, c, xy, b, xz, d


@lean_part
def has_double_inflection(f: Floats) -> bool:
    """Whether two inflection points fall together, to rounding, as they do where a tunnel opens."""
    size = 0.0
    for corner in range(8):
        size = max(size, abs(f[corner]))
    a, b, c, d, e, xz, xy, xyz = coefficients(f, size)
    for axis in range(3):
        k, p, m, q, n, r = _along(axis, b, c, d, e, xz, xy)
        square, half, rest = m * n - k * xyz, p * n + m * q - k * r - a * xyz, p * q - a * r
        whole = half * half + abs(4.0 * square * rest)
        if abs(square) > DOUBLE and abs(half * half - 4.0 * square * rest) <= DOUBLE * whole:
            return True
    return False


@lean_part
def inflections(f: Floats, bend: Floats) -> int:
    """The inflection points inside the cell, two places an axis, nan where there is none; their number.

    Source: thesis (4.23)-(4.28).
    """
    size = 0.0
    for corner in range(8):
        size = max(size, abs(f[corner]))
    a, b, c, d, e, xz, xy, xyz = coefficients(f, size)
    found = 0
    for axis in range(3):
        k, p, m, q, n, r = _along(axis, b, c, d, e, xz, xy)
        number, low, high = roots(m * n - k * xyz, p * n + m * q - k * r - a * xyz, p * q - a * r)
        for i in range(2):
            at = bend[2 * axis + i]
            s = low if i == 0 else high
            at[axis] = s
            at[ACROSS[axis, 0]] = _ratio(a + k * s, p + m * s, q + n * s, r + xyz * s)
            at[ACROSS[axis, 1]] = _ratio(a + k * s, q + n * s, p + m * s, r + xyz * s)
            if i < number and is_inside(at) and abs(value(f, at)) <= ON_SURFACE * size:
                found += 1
            else:
                at[0] = at[1] = at[2] = math.nan
    return found


@lean_part
def hexagon(cell: Cell) -> bool:
    """The six inflection points in cyclic order, if all lie inside; neighbours differ in one coordinate.

    Its sides lie on six straight lines of the surface, one pair along each axis.
    Source: thesis, proposition 4.2.1.4, with its indices put right.
    """
    if math.isnan(cell.bend[4, 0]) or math.isnan(cell.bend[5, 0]):
        return False
    for i in range(6):
        for axis in range(3):
            cell.hexagon[i, axis] = cell.bend[4 + HEXAGON[i, 1 + axis], axis]
    return True


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
