"""Contour lines of a linear field on triangles, and of the four triangles about the middle of each rectangle.

A line crosses a triangle straight, so it is exact for the linear field. The rules are those of `kernels.contour`: a node
on the level counts as above, the high side lies to the left, crossings are known by their edge.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from modules.kernels import contour
from modules.kernels.contour import ContourLines
from modules.kernels.crossings import CROSSING, SADDLE

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def lines(
    nodes: Floats, triangles: Integers, values: Floats, level: float, *, check: Callable[[float], None] = lambda fraction: None
) -> ContourLines:
    """The contour lines F = level of a field that is linear in each triangle.

    Parameters
    ----------
    nodes : (n, 2)
        x, y.
    triangles : (m, 3) int
        In either sense of rotation.
    values : (n,)
        At the nodes. Not finite: a hole.
    level
        In units of the values.

    Returns
    -------
    ContourLines
        Bends are 0; `cell` names the triangle of each segment.

    Raises
    ------
    ValueError
        If an edge belongs to more than two triangles, or the triangles overlap, so that lines cannot be joined.

    Accuracy: exact for the linear field, to rounding.
    Source: thesis 3.1.2, figure 3.1 (a).
    """
    turned = _one_way(nodes, np.asarray(triangles, np.int64))
    above = values[turned] >= level
    active = np.isfinite(values[turned]).all(axis=1) & (above.any(axis=1) != above.all(axis=1))
    which = np.flatnonzero(active)
    corners, high = turned[which], above[which]
    check(0.3)
    alone = np.where(high.sum(axis=1) == 1, high.argmax(axis=1), (~high).argmax(axis=1))  # the corner cut off
    row = np.arange(len(which))
    a, b, c = (corners[row, (alone + k) % 3] for k in range(3))
    entry, leave = _edge(a, b, len(nodes)), _edge(c, a, len(nodes))
    low = high.sum(axis=1) == 2
    start, end = np.where(low, leave, entry), np.where(low, entry, leave)
    return _linked(nodes, values, level, start, end, which, check)


def four_triangles(
    values: Floats,
    x: Floats,
    y: Floats,
    level: float,
    *,
    check: Callable[[float], None] = lambda fraction: None,
) -> ContourLines:
    """The contour lines by four triangles a cell, the middle of which has the mean of its corners (Dayhoff; Heap).

    Its lines join otherwise than the bilinear field's wherever the middle and the saddle are on different sides.

    Parameters
    ----------
    values : (ny, nx); x, y : (nx,), (ny,); level
        As in `contour.lines`.

    Returns
    -------
    ContourLines
        Bends are 0, and are not those of the bilinear contour; `cell` names the grid cell of each segment.

    Accuracy: of the four linear pieces, to rounding; nothing is claimed of the bilinear contour.
    Source: thesis 3.2.1.
    """
    nx = len(x)
    above = values >= level
    count = above[:-1, :-1].astype(np.int8) + above[:-1, 1:] + above[1:, :-1] + above[1:, 1:]
    finite = np.isfinite(values)
    solid = finite[:-1, :-1] & finite[:-1, 1:] & finite[1:, :-1] & finite[1:, 1:]
    row, column = np.nonzero((count > 0) & (count < 4) & solid)
    ring = [row * nx + column, row * nx + column + 1, (row + 1) * nx + column + 1, (row + 1) * nx + column]
    used, packed = np.unique(np.concatenate(ring) if len(row) else np.zeros(0, np.int64), return_inverse=True)
    corners = packed.reshape(4, -1)
    middle = len(used) + np.arange(len(row))
    flat = values.ravel()[used]
    mean = flat[corners].mean(axis=0) if len(row) else np.zeros(0)
    nodes = np.concatenate(
        [
            np.column_stack([x[used % nx], y[used // nx]]),
            np.column_stack([(x[column] + x[column + 1]) / 2, (y[row] + y[row + 1]) / 2]),
        ]
    )
    fan = np.stack([np.column_stack([corners[k], corners[(k + 1) % 4], middle]) for k in range(4)], axis=1).reshape(-1, 3)
    drawn = lines(nodes, fan, np.concatenate([flat, mean]), level, check=check)
    return drawn._replace(cell=(row * (nx - 1) + column)[drawn.cell // 4])


def _one_way(nodes: Floats, triangles: Integers) -> Integers:
    """The triangles, each turning to the left."""
    p, q, r = (nodes[triangles[:, k]] for k in range(3))
    turn = (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])
    return np.where((turn < 0)[:, None], triangles[:, ::-1], triangles)


def _edge(a: Integers, b: Integers, n: int) -> Integers:
    """One number an edge, whichever way it is named."""
    return np.asarray(np.minimum(a, b) * n + np.maximum(a, b))


def _linked(
    nodes: Floats,
    values: Floats,
    level: float,
    start: Integers,
    end: Integers,
    triangle: Integers,
    check: Callable[[float], None],
) -> ContourLines:
    """Segments from edge to edge, joined at the edges they share."""
    edges, ids = np.unique(np.concatenate([start, end]), return_inverse=True)
    first, last = ids[: len(start)], ids[len(start) :]
    if len(start) and max(np.bincount(first).max(), np.bincount(last).max()) > 1:
        raise ValueError("an edge belongs to more than two triangles, or triangles overlap: lines cannot be joined there")
    low, high = edges // len(nodes), edges % len(nodes)
    share = np.clip((level - values[low]) / (values[high] - values[low]), 0.0, 1.0)
    at = nodes[low] + share[:, None] * (nodes[high] - nodes[low])
    crossings = np.zeros(len(edges), CROSSING)
    crossings["x"], crossings["y"] = at[:, 0], at[:, 1]
    crossings["next"] = -1
    crossings["next"][first] = last
    crossings["cell"][first] = triangle
    crossings["entered"][last] = 1
    check(0.6)
    return contour.walked(crossings, np.zeros(0, SADDLE), 0, False, check)
