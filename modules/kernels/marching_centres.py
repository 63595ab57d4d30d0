"""Bi-shoulder points of many cells at once, in lanes that run on whole vector registers.

A point is sought by going from a slice through the cell to the slice across it and back. On each, the arc's shoulder
point has a closed form without a branch; the secant method closes the gap. Lanes that are done make room for others.

With v the corner that an arc cuts off, b and g the slopes along the two sides from it and d the twist, the shoulder
point lies (-v g, -v b) / t from it, t = b g + sqrt(b g (b g - d v)), the root with the sign of b g. An arc between
opposite sides with slopes g and h has it g / t of the way, t = g + sqrt(g h), the root with the sign of g.

Source: Lopes 1999, section 4.2.2.2 and, for the closed forms, equations (3.6) and (3.7) with the ends put in.
"""

import math
from importlib import import_module

from modules.kernels._jit import lean_part, vectorized
from modules.kernels.marching_cases import Floats

LANES = 64
CLOSE = 1e-6
"""Of the cell: when the two slices agree so far, the search ends."""

ROUNDS = 3
MOST_SWEEPS = 12
NEAR = 2.0**-20
"""Of the cell: a point as near to a face is found in the careful way."""

TINY = 1e-280
"""A smaller square may have lost digits, or is 0 where the arc is two lines: then the careful way is taken."""

AT, BEFORE, GAP, ALONG, ACROSS_IT, TURNS, BACK = 8, 9, 10, 11, 12, 13, 14
ROWS = 15
"""Rows of the lanes: eight corner values; place along the first axis, now and before; the gap there; the
other two; rounds of the search; where the other slice leads."""


@vectorized
def shoulder_of(v00: float, v10: float, v01: float, v11: float) -> tuple[float, float]:
    """The shoulder point of the one arc of a square with these corner values; nan if there is not just one.

    Source: thesis (3.6), (3.7).
    """
    s00, s10, s01, s11 = v00 >= 0.0, v10 >= 0.0, v01 >= 0.0, v11 >= 0.0
    low, high, left, right = s00 != s10, s01 != s11, s00 != s01, s10 != s11  # the sides that are cut
    corner, swap = low != high, low & high
    flip_p, flip_q = corner & right, corner & high
    x0, x1 = v10 if flip_p else v00, v00 if flip_p else v10
    y0, y1 = v11 if flip_p else v01, v01 if flip_p else v11
    v, c = y0 if flip_q else x0, x1 if flip_q else y1
    a, b = y1 if flip_q else x1, x0 if flip_q else y0
    p, q = from_corner(v, b if swap else a, a if swap else b, c, corner)
    p, q = q if swap else p, p if swap else q
    p, q = 1.0 - p if flip_p else p, 1.0 - q if flip_q else q
    return p if corner | (swap != (left & right)) else math.nan, q


@vectorized
def from_corner(v: float, va: float, vb: float, vc: float, corner: bool) -> tuple[float, float]:
    """The shoulder point from the corner v that an arc cuts off or, if not `corner`, of an arc across the side to va."""
    b, g, h = va - v, vb - v, vc - va
    bg, twist = b * g, h - g
    first = bg if corner else g
    square = first * (bg - twist * v if corner else h)
    root = math.sqrt(square if square > TINY else math.nan)
    total = first + root if first > 0.0 else first - root
    part = 1.0 / total
    opposite = -(v * total + bg) / (g * (total + twist))
    return (-v if corner else 1.0) * g * part, -v * b * part if corner else opposite


@lean_part
def sweep(lane: Floats) -> None:
    """One round of the search in all lanes: two slices, and the next place; short loops, so that lanes overlap."""
    for n in range(LANES):
        t = lane[AT * LANES + n]
        s = 1.0 - t
        f000, f001, f010, f011 = lane[n], lane[LANES + n], lane[2 * LANES + n], lane[3 * LANES + n]
        f100, f101, f110, f111 = lane[4 * LANES + n], lane[5 * LANES + n], lane[6 * LANES + n], lane[7 * LANES + n]
        p, q = shoulder_of(s * f000 + t * f100, s * f010 + t * f110, s * f001 + t * f101, s * f011 + t * f111)
        lane[ALONG * LANES + n], lane[ACROSS_IT * LANES + n] = p, q
    for n in range(LANES):
        p = lane[ALONG * LANES + n]
        r = 1.0 - p
        f000, f001, f010, f011 = lane[n], lane[LANES + n], lane[2 * LANES + n], lane[3 * LANES + n]
        f100, f101, f110, f111 = lane[4 * LANES + n], lane[5 * LANES + n], lane[6 * LANES + n], lane[7 * LANES + n]
        back, _ = shoulder_of(r * f000 + p * f010, r * f100 + p * f110, r * f001 + p * f011, r * f101 + p * f111)
        lane[BACK * LANES + n] = back
    for n in range(LANES):
        t = lane[AT * LANES + n]
        gap, gap_before = lane[BACK * LANES + n] - t, lane[GAP * LANES + n]
        lane[AT * LANES + n] = _following(t, gap, lane[BEFORE * LANES + n], gap_before)
        lane[BEFORE * LANES + n], lane[GAP * LANES + n] = t, gap


@vectorized
def _following(t: float, gap: float, t_before: float, gap_before: float) -> float:
    """The next place: by the secant where the gap shrinks, the other slice's place at first, else half the way."""
    secant = t - gap * (t - t_before) / (gap - gap_before)
    half = t + (0.5 * gap if gap_before == gap_before else gap)
    return secant if (abs(gap) < 0.9 * abs(gap_before)) & (secant > 0.0) & (secant < 1.0) else half


@lean_part
def begin(lane: Floats) -> None:
    """The first place in lanes that are new: the mean of the polygon's crossings; their sum so far is in the lane."""
    for n in range(LANES):
        total = lane[AT * LANES + n]
        for edge in range(4):
            low, high = lane[edge * LANES + n], lane[(4 + edge) * LANES + n]
            total += crossing_of(low, high)
        if lane[TURNS * LANES + n] == 0.0:
            lane[AT * LANES + n] = total * lane[GAP * LANES + n]
            lane[GAP * LANES + n] = math.nan


@vectorized
def crossing_of(low: float, high: float) -> float:
    """Where F is 0 between two corners; 0 where it is not."""
    t = low / (low - high)
    return t if (low >= 0.0) != (high >= 0.0) else 0.0


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
