"""Further points of an isosurface put where a straight polygon has them, to see what each kind is worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CROSSING, ON_FACE, INSIDE = 2, 1, 0
"""Kinds of points, by how many of their coordinates are the grid's."""


def kinds(points: Floats, axes: tuple[Floats, ...]) -> Ints:
    """(n,) kind of each point: `CROSSING` of an edge of the grid (or more), `ON_FACE` of a cell, `INSIDE` a cell."""
    on = np.stack([np.isin(points[:, a], axes[a]) for a in range(3)], axis=1)
    return np.asarray(np.minimum(on.sum(axis=1), CROSSING), np.int64)


def straightened(points: Floats, triangles: Ints, axes: tuple[Floats, ...], on_faces: bool, inside: bool) -> Floats:
    """The points, with those of a kind moved to the middle of what they are joined to.

    Parameters
    ----------
    on_faces : points on faces go to the middle of the chord between their two crossings
    inside : points inside cells go to the mean of the points around them on the cell's faces
    """
    kind, moved = kinds(points, axes), points.copy()
    ends = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = np.unique(np.concatenate([ends, ends[:, ::-1]]) @ np.array([len(points), 1]))
    here, there = np.divmod(ends, max(len(points), 1))
    if on_faces:
        _to_mean(moved, here, there, (kind[here] == ON_FACE) & (kind[there] == CROSSING))
    if inside:
        _to_mean(moved, here, there, (kind[here] == INSIDE) & (kind[there] != INSIDE))
    return moved


def _to_mean(points: Floats, here: Ints, there: Ints, wanted: NDArray[np.bool_]) -> None:
    one, other = here[wanted], there[wanted]
    count = np.bincount(one, minlength=len(points))
    moved = count > 0
    total = np.stack([np.bincount(one, points[other, a], minlength=len(points)) for a in range(3)], axis=1)
    points[moved] = total[moved] / count[moved, None]
