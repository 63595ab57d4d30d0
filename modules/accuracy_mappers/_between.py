"""Arcs of contour lines within grid cells, matched by their ends, and the polygons between them.

Arcs are short and many: points are pairs of plain numbers, which is many times as fast here as small arrays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from modules.api import Geometry

Point = tuple[float, float]
Ring = list[Point]
Groups = dict[tuple[float, int], list[Ring]]
"""(level, grid cell) -> the arcs there, each as its points."""

CLOSE = 1e-9
"""Ends that are nearer than this part of their cell are one."""


def arcs_of(lines: Geometry) -> Groups:
    """The lines cut into the arcs of the grid cells that they pass.

    Raises
    ------
    ValueError : the lines do not know their levels and cells
    """
    if "grid cell" not in lines.values or "level" not in lines.values:
        raise ValueError("a difference needs contour lines that know their levels and cells: wire the lines of 'contour'")
    cell = np.asarray(lines.values["grid cell"].values, np.int64)
    level = np.asarray(lines.values["level"].values, float)[len(lines.vertices) :]
    line = np.repeat(np.arange(len(lines.lines)), np.maximum(lines.lines.sizes() - 1, 0))
    cuts = np.flatnonzero((np.diff(cell) != 0) | (np.diff(line) != 0)) + 1
    ends = np.concatenate([[0], cuts, [len(cell)]]) if len(cell) else np.zeros(1, np.int64)
    first = ends[:-1]
    way: Ring = [(x, y) for x, y in lines.points[lines.lines.connectivity, :2].tolist()]
    groups: Groups = {}
    keys = zip(level[line[first]].tolist(), cell[first].tolist(), strict=True)
    runs = zip(line[first].tolist(), (first + line[first]).tolist(), np.diff(ends).tolist(), strict=True)
    opened: dict[int, tuple[tuple[float, int], Ring]] = {}
    for key, (number, start, steps) in zip(keys, runs, strict=True):
        arc = way[start : start + steps + 1]
        begun = opened.setdefault(number, (key, arc))
        if begun[1] is not arc and begun[0] == key and begun[1][0] == arc[-1]:
            begun[1][:0] = arc[:-1]  # a closed line that starts within a cell
        else:
            groups.setdefault(key, []).append(arc)
    return groups


def matched(one: Sequence[Ring], two: Sequence[Ring]) -> tuple[list[Ring], list[Ring]] | None:
    """Closed loops between the arcs of one cell: of arcs with the same two ends, and of arcs joined in another way.

    None if the ends are not the same places.
    """
    left, right = list(one), list(two)
    slack = CLOSE * max((_size(arc) for arc in (*left, *right)), default=0.0)
    same: list[Ring] = []
    for arc in list(left):
        for other in right:
            turned = _aligned(arc, other, slack)
            if turned is not None:
                same += _split(arc, turned)
                left = [a for a in left if a is not arc]
                right = [a for a in right if a is not other]
                break
    if not left and not right:
        return same, []
    _add_points(left, right)
    _add_points(right, left)
    loop = _round(left, right, slack)
    return None if loop is None else (same, [loop])


def _size(arc: Ring) -> float:
    (x, y), (u, v) = arc[0], arc[-1]
    return max(abs(u - x), abs(v - y))


def _near(p: Point, q: Point, slack: float) -> bool:
    return p == q or (abs(p[0] - q[0]) <= slack and abs(p[1] - q[1]) <= slack)


def _aligned(arc: Ring, other: Ring, slack: float) -> Ring | None:
    """The other arc in the direction of the first, if both have the same ends."""
    if _near(arc[0], other[0], slack) and _near(arc[-1], other[-1], slack):
        return other
    if _near(arc[0], other[-1], slack) and _near(arc[-1], other[0], slack):
        return other[::-1]
    return None


def _split(arc: Ring, other: Ring) -> list[Ring]:
    """Loops of an arc forth and the other back, cut where both have the same point on their way."""
    if len(arc) == 2 or len(other) == 2:
        return [arc + other[-2:0:-1]] if len(arc) + len(other) > 4 else []
    where = {p: i for i, p in enumerate(other)}
    loops, start, back = [], 0, 0
    for i, p in enumerate(arc):
        j = where.get(p, -1) if i < len(arc) - 1 else len(other) - 1
        if i and j > back:
            loops.append(arc[start : i + 1] + other[back + 1 : j][::-1])
            start, back = i, j
    return [loop for loop in loops if len(loop) > 2]


def _add_points(fewer: list[Ring], more: list[Ring]) -> None:
    """A corner on the level where two arcs of the one meet is an arc of no length of the other, which nobody drew."""
    ends = [p for arc in more for p in (arc[0], arc[-1])]
    for p in dict.fromkeys(ends):
        if len(fewer) < len(more) and ends.count(p) == 2:
            fewer.append([p, p])


def _round(left: list[Ring], right: list[Ring], slack: float) -> Ring | None:
    """One loop along arcs of the one and the other in turn, or None if they do not close."""
    if not left or len(left) != len(right):
        return None
    loop, turn, open_ = [left[0]], 1, [left[1:], list(right)]
    while any(open_):
        end = loop[-1][-1]
        ways = ((k, way) for k, arc in enumerate(open_[turn]) for way in (arc, arc[::-1]))
        following = next(((k, way) for k, way in ways if _near(way[0], end, slack)), None)
        if following is None:
            return None
        open_[turn].pop(following[0])
        loop.append(following[1])
        turn = 1 - turn
    if not _near(loop[0][0], loop[-1][-1], slack):
        return None
    ring = [p for arc in loop for p in arc[:-1]]
    return [p for i, p in enumerate(ring) if p != ring[i - 1]]


def shoelace(ring: Ring) -> float:
    """Area of a ring, positive against the clock; measured from its first point, so that no digits are lost."""
    x0, y0 = ring[0]
    total = 0.0
    for (px, py), (qx, qy) in pairwise(ring[1:]):
        total += (px - x0) * (qy - y0) - (py - y0) * (qx - x0)
    return 0.5 * total


def _turn(p: Point, q: Point, r: Point) -> float:
    """Twice the area of a triangle, positive against the clock."""
    return (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0])


def _is_convex(ring: Ring) -> bool:
    """Whether a ring turns one way, and once round."""
    if len(ring) == 3:
        return True
    turns = [_turn(ring[i - 2], ring[i - 1], p) for i, p in enumerate(ring)]
    if min(turns) < 0 < max(turns):
        return False
    if len(ring) == 4:
        return True
    right = [q[0] > p[0] for p, q in zip(ring, [*ring[1:], ring[0]], strict=True) if q[0] != p[0]]
    return sum(a != b for a, b in zip(right, [*right[1:], right[0]], strict=True)) <= 2 if right else True


def simple(loop: Ring) -> Iterator[Ring]:
    """A loop cut where it crosses itself, into rings that do not."""
    n = len(loop)
    if n < 3:
        return
    if not _is_convex(loop):
        for i in range(n - 2):
            for j in range(i + 2, n if i else n - 1):
                x = _crossing(loop[i], loop[i + 1], loop[j], loop[(j + 1) % n])
                if x is not None:
                    yield from simple([*loop[: i + 1], x, *loop[j + 1 :]])
                    yield from simple([x, *loop[i + 1 : j + 1]])
                    return
    yield loop


def _crossing(a: Point, b: Point, c: Point, d: Point) -> Point | None:
    """Where the inner parts of two segments cross, None if they do not."""
    ux, uy, vx, vy, wx, wy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1], c[0] - a[0], c[1] - a[1]
    below = ux * vy - uy * vx
    if below == 0:
        return None
    s, t = (wx * vy - wy * vx) / below, (wx * uy - wy * ux) / below
    return (a[0] + s * ux, a[1] + s * uy) if 0 < s < 1 and 0 < t < 1 else None


def convex_parts(ring: Ring) -> list[Ring]:
    """The ring itself if it is convex, else triangles that fill it (ears cut off one by one)."""
    if _is_convex(ring):
        return [ring]
    rest = list(ring) if shoelace(ring) > 0 else ring[::-1]
    parts: list[Ring] = []
    while len(rest) > 3:
        turns = [_turn(rest[i - 1], p, rest[(i + 1) % len(rest)]) for i, p in enumerate(rest)]
        order = np.argsort(-np.array(turns), kind="stable").tolist()
        ear = next((i for i in order if turns[i] >= 0 and _is_ear(rest, i)), None)
        if ear is None:
            break
        parts.append([rest[ear - 1], rest[ear], rest[(ear + 1) % len(rest)]])
        del rest[ear]
    return [*parts, rest]


def _is_ear(ring: Ring, i: int) -> bool:
    """Whether no other corner lies within the triangle at a corner, or on the cut."""
    n = len(ring)
    a, b, c = ring[i - 1], ring[i], ring[(i + 1) % n]
    others = (p for k, p in enumerate(ring) if k not in ((i - 1) % n, i, (i + 1) % n))
    return not any(_turn(a, b, p) > 0 and _turn(b, c, p) > 0 and _turn(c, a, p) >= 0 for p in others)
