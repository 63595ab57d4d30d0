"""Arcs of contour lines within grid cells, matched by their ends, and the polygons between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modules.api import Geometry

Floats = NDArray[np.float64]
Groups = dict[tuple[float, int], list[Floats]]
"""(level, grid cell) -> the arcs there, each as its (k, 2) points."""

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
    groups: Groups = {}
    first = 0
    for i, (a, b) in enumerate(pairwise(lines.lines.offsets)):
        points = lines.points[lines.lines.connectivity[a:b], :2]
        own = cell[first : first + b - a - 1]
        first += max(0, b - a - 1)
        cuts = [0, *(np.flatnonzero(np.diff(own)) + 1).tolist(), len(own)]
        for start, stop in pairwise(cuts):
            if stop > start:
                groups.setdefault((float(level[i]), int(own[start])), []).append(points[start : stop + 1])
    return groups


def matched(one: Sequence[Floats], two: Sequence[Floats]) -> tuple[list[Floats], list[Floats]] | None:
    """Closed loops between the arcs of one cell: of arcs with the same two ends, and of arcs joined in another way.

    None if the ends are not the same places.
    """
    left, right = list(one), list(two)
    size = max((float(np.ptp(a, axis=0).max()) for a in (*left, *right)), default=0.0)
    same: list[Floats] = []
    for arc in list(left):
        for other in right:
            turned = _aligned(arc, other, CLOSE * size)
            if turned is not None:
                same += _split(arc, turned)
                left = [a for a in left if a is not arc]
                right = [a for a in right if a is not other]
                break
    if not left and not right:
        return same, []
    loop = _round(left, right, CLOSE * size)
    return None if loop is None else (same, [loop])


def _aligned(arc: Floats, other: Floats, slack: float) -> Floats | None:
    """The other arc in the direction of the first, if both have the same ends."""
    for turned in (other, other[::-1]):
        if np.abs(arc[[0, -1]] - turned[[0, -1]]).max() <= slack:
            return turned
    return None


def _split(arc: Floats, other: Floats) -> list[Floats]:
    """Loops of an arc forth and the other back, cut where both have the same point on their way."""
    where = {tuple(p): i for i, p in enumerate(other.tolist())}
    loops, start, back = [], 0, 0
    for i, p in enumerate(arc.tolist()):
        j = where.get(tuple(p), -1) if i < len(arc) - 1 else len(other) - 1
        if i and j > back:
            loops.append(np.concatenate([arc[start : i + 1], other[back + 1 : j][::-1]]))
            start, back = i, j
    return [loop for loop in loops if len(loop) > 2]


def _round(left: list[Floats], right: list[Floats], slack: float) -> Floats | None:
    """One loop along arcs of the one and the other in turn, or None if they do not close."""
    if not left or len(left) != len(right):
        return None
    loop, turn, open_ = [left[0]], 1, [left[1:], list(right)]
    while any(open_):
        end = loop[-1][-1]
        following = next(
            ((k, d) for k, arc in enumerate(open_[turn]) for d in (arc, arc[::-1]) if np.abs(d[0] - end).max() <= slack), None
        )
        if following is None:
            return None
        open_[turn].pop(following[0])
        loop.append(following[1])
        turn = 1 - turn
    if np.abs(loop[0][0] - loop[-1][-1]).max() > slack:
        return None
    return np.concatenate([arc[:-1] for arc in loop])


def shoelace(ring: Floats) -> float:
    """Area of a ring, positive against the clock; measured from its first point, so that no digits are lost."""
    x, y = (ring - ring[0]).T
    return float(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _turns(ring: Floats) -> Floats:
    """Twice the area of the triangle at each corner, positive where the ring turns left."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return np.asarray(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])


def _is_convex(ring: Floats) -> bool:
    """Whether a ring turns one way, and once round."""
    turns = _turns(ring)
    if (turns > 0).any() and (turns < 0).any():
        return False
    step = np.diff(ring[:, 0], append=ring[0, 0])
    way = np.sign(step[step != 0])
    return int((way != np.roll(way, 1)).sum()) <= 2


def simple(loop: Floats) -> Iterator[Floats]:
    """A loop cut where it crosses itself, into rings that do not."""
    n = len(loop)
    if n < 3:
        return
    if not _is_convex(loop):
        after = np.roll(loop, -1, axis=0)
        for i in range(n - 2):
            for j in range(i + 2, n if i else n - 1):
                x = _crossing(loop[i], after[i], loop[j], after[j])
                if x is not None:
                    yield from simple(np.concatenate([loop[: i + 1], [x], loop[j + 1 :]]))
                    yield from simple(np.concatenate([[x], loop[i + 1 : j + 1]]))
                    return
    yield loop


def _crossing(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats | None:
    """Where the inner parts of two segments cross, None if they do not."""
    (ux, uy), (vx, vy), (wx, wy) = (b - a).tolist(), (d - c).tolist(), (c - a).tolist()
    below = ux * vy - uy * vx
    if below == 0:
        return None
    s, t = (wx * vy - wy * vx) / below, (wx * uy - wy * ux) / below
    return np.asarray(a + s * (b - a)) if 0 < s < 1 and 0 < t < 1 else None


def convex_parts(ring: Floats) -> list[Floats]:
    """The ring itself if it is convex, else triangles that fill it (ears cut off one by one)."""
    if _is_convex(ring):
        return [ring]
    rest = ring if shoelace(ring) > 0 else ring[::-1]
    parts: list[Floats] = []
    while len(rest) > 3:
        turns = _turns(rest)
        ear = next((i for i in np.argsort(-turns, kind="stable") if turns[i] >= 0 and _is_ear(rest, int(i))), None)
        if ear is None:
            break
        n = len(rest)
        parts.append(rest[[(ear - 1) % n, ear, (ear + 1) % n]])
        rest = np.delete(rest, ear, axis=0)
    return [*parts, rest]


def _is_ear(ring: Floats, i: int) -> bool:
    """Whether no other corner lies within the triangle at a corner, or on the cut."""
    n = len(ring)
    a, b, c = ring[i - 1], ring[i], ring[(i + 1) % n]
    others = np.delete(ring, [(i - 1) % n, i, (i + 1) % n], axis=0)
    inside = np.ones(len(others), bool)
    for p, q in ((a, b), (b, c), (c, a)):
        side = q - p
        left = side[0] * (others[:, 1] - p[1]) - side[1] * (others[:, 0] - p[0])
        inside &= (left >= 0) if p is c else (left > 0)
    return not inside.any()
