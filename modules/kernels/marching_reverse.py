"""How far the trilinear surface is from the triangles: a proven bound for each cell, the other way round than
`marching_distance`.

A cell is cut in boxes until the bound of each is small. In a box where F rises or falls along one axis on all four edges,
the surface is a graph over the other two. The graph is linear-fractional in each of them: so it lies between its values at
the four corners, and no farther from their convex hull than range x ((sqrt r - 1) / (sqrt r + 1)) along each, r the ratio
of the rises at both ends. The distance to a triangle is convex, so that the four corners tell of the hull.

Where a box lies over the edge between two triangles, both count, if they make a convex quadrangle when unfolded. Of points
Q of theirs the mean, in the unfolded plane, is a point of the quadrangle; folding it back moves the rest of the mean by no
more than half of |n1 - n2| times the largest distance of a Q from the edge, for the side with less weight is moved.

Source: multi-affine polynomials; the bounds of the linear-fractional graph and of the fold are our own.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from modules.kernels._jit import lean, lean_inlined, lean_part
from modules.kernels.marching_cases import Floats, Integers, frozen, int64

DEPTH = 8
"""A cell is cut in at most 2^DEPTH pieces along an axis."""

CLOSE = 1.25
"""Times the distance of the cell's triangles from the surface: a bound below it is not made better."""

FINE = 2.0**-7
"""Of the cell: nor is one below this."""

ROUNDING = 2.0**-44
CELLS_A_SLAB = 1 << 10
ROOM = 8 * (7 * DEPTH + 8)
MOST_PAIRS = 64
PAIR = 9
"""Of two triangles with a common edge: their numbers, |n1 - n2| / 2, the ends of the edge."""

Slabs = Callable[[Callable[[int], Any], Iterable[int]], list[Any]]


@lean_inlined
def _square(p: Floats, i: int, t: Floats, j: int) -> float:
    """The square of the distance from the place at p[i] to the triangle at t[j].

    Source: Ericson 2005, Real-Time Collision Detection, 5.1.5.
    """
    ax, ay, az = t[j], t[j + 1], t[j + 2]
    ux, uy, uz = t[j + 3] - ax, t[j + 4] - ay, t[j + 5] - az
    vx, vy, vz = t[j + 6] - ax, t[j + 7] - ay, t[j + 8] - az
    px, py, pz = p[i] - ax, p[i + 1] - ay, p[i + 2] - az
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    s, r = d1 * vv - d2 * uv, d2 * uu - d1 * uv
    whole = uu * vv - uv * uv
    if s > 0.0 and r > 0.0 and s + r < whole:
        s, r = s / whole, r / whole
    else:  # the nearest of three sides
        best, s, r = math.inf, 0.0, 0.0
        for side in range(3):
            if side == 0:
                q = min(max(d1 / uu, 0.0), 1.0) if uu > 0.0 else 0.0
                a, b = q, 0.0
            elif side == 1:
                q = min(max(d2 / vv, 0.0), 1.0) if vv > 0.0 else 0.0
                a, b = 0.0, q
            else:
                long = uu - 2.0 * uv + vv
                q = min(max((d2 - d1 + uu - uv) / long, 0.0), 1.0) if long > 0.0 else 0.0
                a, b = 1.0 - q, q
            gx, gy, gz = px - a * ux - b * vx, py - a * uy - b * vy, pz - a * uz - b * vz
            away = gx * gx + gy * gy + gz * gz
            if away < best:
                best, s, r = away, a, b
    gx, gy, gz = px - s * ux - r * vx, py - s * uy - r * vy, pz - s * uz - r * vz
    square: float = gx * gx + gy * gy + gz * gz
    return square


@lean_part
def _nearest(p: Floats, count: int, corner: Floats, first: int, last: int) -> float:
    """The least over triangles of the largest distance of some places from one of them."""
    best = math.inf
    for m in range(first, last):
        worst = 0.0
        for i in range(count):
            worst = max(worst, _square(p, 3 * i, corner, 9 * m))
            if worst >= best:
                break
        best = min(best, worst)
    return math.sqrt(best)


@lean_part
def _fold(t: Floats, one: int, two: int, a: int, b: int, pair: Floats, at: int) -> bool:
    """The pair of triangles with the common corners a and b of the first; whether they are a convex quadrangle unfolded."""
    start, stop = 9 * one + 3 * a, 9 * one + 3 * b
    ex, ey, ez = t[stop] - t[start], t[stop + 1] - t[start + 1], t[stop + 2] - t[start + 2]
    long = ex * ex + ey * ey + ez * ez
    pair[at], pair[at + 1], bend = float(one), float(two), 0.0
    place, height = pair[at + 3 : at + 5], pair[at + 5 : at + 7]
    for side in range(2):
        j, far = 9 * (two if side else one), -1.0
        for c in range(3):
            px, py, pz = t[j + 3 * c] - t[start], t[j + 3 * c + 1] - t[start + 1], t[j + 3 * c + 2] - t[start + 2]
            along = (px * ex + py * ey + pz * ez) / long if long > 0.0 else 0.0
            off = math.sqrt((px - along * ex) ** 2 + (py - along * ey) ** 2 + (pz - along * ez) ** 2)
            if off > far:
                far, place[side], height[side] = off, along, off
    total = height[0] + height[1]
    if not (height[0] > 0.0 and height[1] > 0.0):
        return False
    crossing = place[0] + (place[1] - place[0]) * height[0] / total
    for axis in range(3):
        p, q = (axis + 1) % 3, (axis + 2) % 3
        rise = 0.0
        for side in range(2):
            j = 9 * (two if side else one)
            turn = (t[j + 3 + p] - t[j + p]) * (t[j + 6 + q] - t[j + q]) - (t[j + 3 + q] - t[j + q]) * (t[j + 6 + p] - t[j + p])
            rise += (1.0 - 2.0 * side) * turn / (height[side] * math.sqrt(long))
        bend += rise * rise
    pair[at + 2] = 0.5 * math.sqrt(bend)
    for axis in range(3):
        pair[at + 3 + axis], pair[at + 6 + axis] = t[start + axis], t[stop + axis]
    return bool(0.0 <= crossing <= 1.0)


@lean_part
def _over_edges(p: Floats, count: int, corner: Floats, pair: Floats, pairs: int, best: float) -> float:
    """As `_nearest`, for two triangles with a common edge at a time; no more than `best`."""
    for n in range(pairs):
        b, far, out = PAIR * n, 0.0, 0.0
        one, two, half = int64(pair[b]), int64(pair[b + 1]), pair[b + 2]
        ex, ey, ez = pair[b + 6] - pair[b + 3], pair[b + 7] - pair[b + 4], pair[b + 8] - pair[b + 5]
        long = ex * ex + ey * ey + ez * ez
        for i in range(count):
            far = max(far, min(_square(p, 3 * i, corner, 9 * one), _square(p, 3 * i, corner, 9 * two)))
            if far >= best * best:
                break
            px, py, pz = p[3 * i] - pair[b + 3], p[3 * i + 1] - pair[b + 4], p[3 * i + 2] - pair[b + 5]
            along = (px * ex + py * ey + pz * ez) / long
            out = max(out, (px - along * ex) ** 2 + (py - along * ey) ** 2 + (pz - along * ez) ** 2)
        if far < best * best:
            off = math.sqrt(far)
            best = min(best, off + half * (math.sqrt(out) + off))
    return best


@lean_inlined
def _bend(before: float, after: float) -> float:
    """By how much of its range a linear-fractional function differs from a straight one, from its two denominators."""
    root = math.sqrt(after / before)
    return abs(root - 1.0) / (root + 1.0)


@lean_part
def _graph(g: Floats, box: Floats, b: int, low: Floats, size: Floats, p: Floats, spare: float) -> tuple[int, float]:
    """The axis along which the surface in a box is a graph, -1 if there is none; its four corners as places p; its range."""
    axis, steepest = -1, 0.0
    for a in range(3):
        step, least, rising = 4 >> a, math.inf, 0
        for c in range(8):
            if not c & step:
                rise = g[c + step] - g[c]
                rising += 1 if rise > 0.0 else -1
                least = min(least, abs(rise))
        if (rising == 4 or rising == -4) and least > max(steepest, spare):
            axis, steepest = a, least
    if axis < 0:
        return axis, math.inf
    one, two, step = (axis + 1) % 3, (axis + 2) % 3, 4 >> axis
    lowest, highest = math.inf, -math.inf
    for n in range(4):
        c = (n & 1) * (4 >> one) + (n >> 1) * (4 >> two)
        t = g[c] / (g[c] - g[c + step])
        lowest, highest = min(lowest, t), max(highest, t)
        p[3 * n + axis] = low[axis] + size[axis] * (box[b + axis] + t * box[b + 3 + axis])
        p[3 * n + one] = low[one] + size[one] * (box[b + one] + (n & 1) * box[b + 3 + one])
        p[3 * n + two] = low[two] + size[two] * (box[b + two] + (n >> 1) * box[b + 3 + two])
    return axis, highest - lowest


@lean_part
def _far(g: Floats, axis: int) -> float:
    """The part of its range that the graph may be from the hull of its four corners."""
    step, one, two = 4 >> axis, 4 >> ((axis + 1) % 3), 4 >> ((axis + 2) % 3)
    d0, d1 = abs(g[step] - g[0]), abs(g[one + step] - g[one])
    d2, d3 = abs(g[two + step] - g[two]), abs(g[one + two + step] - g[one + two])
    return max(_bend(d0, d1), _bend(d2, d3)) + max(_bend(d0, d2), _bend(d1, d3))


@lean_part
def _values(f: Floats, box: Floats, b: int, g: Floats) -> bool:
    """F at the corners of a box; whether 0 may lie between them."""
    low, high = math.inf, -math.inf
    for c in range(8):
        u, v = box[b] + (c >> 2) * box[b + 3], box[b + 1] + ((c >> 1) & 1) * box[b + 4]
        w = box[b + 2] + (c & 1) * box[b + 5]
        near = (1 - v) * ((1 - w) * f[0] + w * f[1]) + v * ((1 - w) * f[2] + w * f[3])
        far = (1 - v) * ((1 - w) * f[4] + w * f[5]) + v * ((1 - w) * f[6] + w * f[7])
        g[c] = (1 - u) * near + u * far
        low, high = min(low, g[c]), max(high, g[c])
    return bool(low <= f[8] and high >= -f[8])


@lean_part
def _split(box: Floats, b: int, axis: int) -> int:
    """Put the parts of a box, across all axes but one, where it was and after it; how many places they take."""
    u, v, w, depth = box[b], box[b + 1], box[b + 2], box[b + 6]
    su, sv, sw = box[b + 3], box[b + 4], box[b + 5]
    taken = int64(0)
    for part in range(8):
        a, e, i = part >> 2, (part >> 1) & 1, part & 1
        if (axis == 0 and a) or (axis == 1 and e) or (axis == 2 and i):
            continue
        hu, hv, hw = su if axis == 0 else 0.5 * su, sv if axis == 1 else 0.5 * sv, sw if axis == 2 else 0.5 * sw
        n = b + 7 * taken
        box[n], box[n + 1], box[n + 2] = u + a * hu, v + e * hv, w + i * hw
        box[n + 3], box[n + 4], box[n + 5], box[n + 6] = hu, hv, hw, depth + 1.0
        taken += 1
    number: int = taken
    return number


@lean_part
def _cell(
    f: Floats, low: Floats, size: Floats, corner: Floats, last: int, pair: Floats, pairs: int, aim: float, room: Floats
) -> float:
    """The largest distance of the surface in a cell from its triangles; f[8] is what rounding may add to F."""
    g, p, box = room[0:8], room[8:32], room[32:]
    for n in range(3):
        box[n], box[3 + n] = 0.0, 1.0
    box[6], worst, top = 0.0, 0.0, int64(7)
    while top:
        b = top - 7
        top = b
        if not _values(f, box, b, g):
            continue
        axis, spread = _graph(g, box, b, low, size, p, 4.0 * f[8])
        if axis >= 0:
            extra = spread * box[b + 3 + axis] * size[axis] * _far(g, axis)
            bound = math.inf
            if extra <= aim or box[b + 6] >= DEPTH:
                bound = _nearest(p, 4, corner, int64(0), last)
                if bound + extra > max(aim, worst):
                    bound = _over_edges(p, 4, corner, pair, pairs, bound)
                bound += extra
        else:
            bound = math.inf
            if box[b + 6] >= DEPTH:
                for c in range(8):
                    for a in range(3):
                        p[3 * c + a] = low[a] + size[a] * (box[b + a] + ((c >> (2 - a)) & 1) * box[b + 3 + a])
                bound = _nearest(p, 8, corner, int64(0), last)
        if bound <= max(aim, worst) or box[b + 6] >= DEPTH:
            worst = max(worst, bound)
        else:
            top = b + 7 * _split(box, b, axis)
    return worst


@lean_inlined
def _common(triangle: Integers, one: int, two: int) -> tuple[int, int]:
    """Two corners of a triangle that another one has too; the second is -1 if there are no two."""
    a, b = -1, -1
    for c in range(3):
        v = triangle[one, c]
        if v == triangle[two, 0] or v == triangle[two, 1] or v == triangle[two, 2]:
            a, b = (c, b) if a < 0 else (a, c)
    return a, b


@lean
def _measure(
    values: Floats, level: float, x: Floats, y: Floats, z: Floats, point: Floats, triangle: Integers, origin: Integers,
    start: Integers, first: int, last: int, reach: Floats, spare: float, bound: Floats, room: Floats, corner: Floats,
    pair: Floats,
) -> None:
    """The bounds of cells first to last - 1, whose triangles begin where `start` tells."""
    f, low, size, rest = room[0:9], room[9:12], room[12:15], room[16:]
    for n in range(first, last):
        m0, m1 = start[n], start[n + 1]
        i, row = origin[m0] % (x.size - 1), origin[m0] // (x.size - 1)
        j, k = row % (y.size - 1), row // (y.size - 1)
        for c in range(8):
            f[c] = values[((k + (c & 1)) * y.size + j + ((c >> 1) & 1)) * x.size + i + (c >> 2)] - level
        f[8] = spare
        low[0], low[1], low[2] = x[i], y[j], z[k]
        size[0], size[1], size[2] = x[i + 1] - x[i], y[j + 1] - y[j], z[k + 1] - z[k]
        aim = FINE / CLOSE * min(size[0], size[1], size[2])
        for m in range(m0, m1):
            if reach[m] < math.inf:
                aim = max(aim, reach[m])
            for c in range(3):
                for axis in range(3):
                    corner[9 * (m - m0) + 3 * c + axis] = point[triangle[m, c], axis]
        pairs = int64(0)
        for one in range(m0, m1):
            for two in range(one + 1, m1):
                a, b = _common(triangle, one, two)
                if b >= 0 and pairs < MOST_PAIRS:
                    pairs += int64(_fold(corner, one - m0, two - m0, a, b, pair, PAIR * pairs))
        bound[n] = _cell(f, low, size, corner, m1 - m0, pair, pairs, CLOSE * aim, rest)


def distances(
    values: Floats, x: Floats, y: Floats, z: Floats, level: float, points: Floats, triangles: Integers, cell: Integers,
    reach: Floats, *, slabs: Slabs | None = None,
) -> Floats:  # fmt: skip
    """How far the surface in the cell of each triangle may be from the triangles of that cell: (m,).

    Parameters
    ----------
    values, x, y, z : (nz, ny, nx), (nx,), (ny,), (nz,)
    points, triangles, cell : (n, 3), (m, 3), (m,)
        Of `marching.surface`: the triangles of a cell lie together.
    reach : (m,) the distance of each triangle from the surface, as of `marching_distance`; it tells how close to look
    slabs
        Applies a function to each of some numbers and gives the list of results, perhaps in several threads.

    Accuracy: proven, rounding included; cells that the surface passes without a triangle are not looked at.
    """
    if not len(triangles):
        return np.zeros(0)
    start = np.append(np.flatnonzero(np.diff(cell, prepend=-1)), len(cell)).astype(np.int64)
    finite = np.abs(values[np.isfinite(values)])
    spare = ROUNDING * (float(finite.max(initial=0.0)) + abs(level))
    field, x, y, z = frozen(values, x, y, z)
    at, near = np.ascontiguousarray(points, np.float64), np.ascontiguousarray(reach, np.float64)
    ids, origin = (np.ascontiguousarray(array, np.int64) for array in (triangles, cell))
    bound, most = np.empty(len(start) - 1), int(np.diff(start).max())

    def measure(first: int) -> None:
        last = min(first + CELLS_A_SLAB, len(bound))
        room, corner, pair = np.empty(16 + 32 + ROOM), np.empty(9 * most), np.empty(PAIR * (MOST_PAIRS + 1))
        _measure(field, float(level), x, y, z, at, ids, origin, start, first, last, near, spare, bound, room, corner, pair)

    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    each(measure, range(0, len(bound), CELLS_A_SLAB))
    place = max(float(np.abs(axis).max()) for axis in (x, y, z))
    return np.repeat(bound * (1.0 + ROUNDING) + ROUNDING * place, np.diff(start))


def warm() -> None:
    """Compile the kernels of this file."""
    values, axis = np.arange(8.0).reshape(2, 2, 2), np.arange(2.0)
    points, triangles = np.array([[0.0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]]), np.array([[0, 1, 2]])
    distances(values, axis, axis, axis, 0.5, points, triangles, np.zeros(1, np.int64), np.ones(1))
