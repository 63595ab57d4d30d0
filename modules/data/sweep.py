"""Lines swept to surfaces: directions, frames that twist as little as can be, rings and strips; arrays in, arrays out.

A bundle of lines is `points` (n, 3), line after line, and `offsets` (lines + 1,): line i is points[offsets[i]:offsets[i + 1]].
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from modules.data.operators import Floats, Ints

TURNED = 1e-6
"""A vector across whose part across the next chunk is shorter than this is chosen anew."""


def directions(points: Floats, offsets: Ints) -> Floats:
    """(n, 3) unit direction of the chunk that begins at each point; the last point has that of the chunk before.

    Chunks without a length have the direction before them, or, at the start of a line, after them; (1, 0, 0) if a line has
    no length at all.
    """
    along = np.zeros_like(points)
    along[:-1] = np.diff(points, axis=0)
    for a, b in pairwise(offsets):
        if b > a:
            along[b - 1] = along[b - 2] if b - a > 1 else 0.0
            _filled(along[a:b])
    length = np.linalg.norm(along, axis=1, keepdims=True)
    return np.where(length > 0, along / np.where(length > 0, length, 1.0), (1.0, 0.0, 0.0))


def _filled(along: Floats) -> None:
    """Rows of zeros get the row before them, or the first one that is none; in place."""
    some = (along != 0).any(axis=1)
    if some.any() and not some.all():
        last = np.maximum.accumulate(np.where(some, np.arange(len(along)), -1))
        along[:] = along[np.where(last < 0, np.argmax(some), last)]


def across(u: Floats, offsets: Ints) -> Floats:
    """(n, 3) a unit vector across each direction, carried along its line with as little twist as can be.

    All lines are walked at once, one point at a time.
    """
    found = np.zeros_like(u)
    sizes = np.diff(offsets)
    starts = np.asarray(offsets[:-1])[sizes > 0]
    sizes = sizes[sizes > 0]
    found[starts] = _any_across(u[starts])
    for step in range(1, int(sizes.max(initial=0))):
        at = starts[sizes > step] + step
        part = found[at - 1] - _along(found[at - 1], u[at])
        length = np.linalg.norm(part, axis=1)
        turned = length < TURNED
        part[turned] = _any_across(u[at[turned]])
        length[turned] = 1.0
        found[at] = part / length[:, None]
    return found


def _along(v: Floats, u: Floats) -> Floats:
    return np.asarray((v * u).sum(axis=1, keepdims=True) * u)


def _any_across(u: Floats) -> Floats:
    """A unit vector across each, from the axis that it is least along."""
    axis = np.eye(3)[np.argmin(np.abs(u), axis=1)]
    part = axis - _along(axis, u)
    return np.asarray(part / np.linalg.norm(part, axis=1, keepdims=True))


def chunks(offsets: Ints) -> Ints:
    """(c,) the point at which each chunk of the lines begins."""
    begins = np.ones(int(offsets[-1]), bool)
    ends = np.asarray(offsets[1:])[np.diff(offsets) > 0]
    begins[ends - 1] = False
    return np.flatnonzero(begins)


def quads(offsets: Ints, sides: int, *, closed: bool = True) -> Ints:
    """(c * m, 4) faces between the rings of consecutive points, chunk after chunk.

    Parameters
    ----------
    sides : points of each ring; point i of the lines has the points i * sides to (i + 1) * sides - 1
    closed : whether the last point of a ring joins the first: m is sides, else sides - 1
    """
    first = chunks(offsets)[:, None] * sides
    j = np.arange(sides if closed else sides - 1)
    k = (j + 1) % sides
    return np.stack([first + j, first + k, first + sides + k, first + sides + j], axis=-1).reshape(-1, 4)


def rings(centre: Floats, first: Floats, second: Floats, sides: int) -> Floats:
    """(n * sides, 3) points of ellipses around centres, with half axes `first` and `second` (n, 3)."""
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = centre[:, None] + np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    return np.asarray(ring.reshape(-1, 3))
