"""Contour lines refined to a tolerance: how many points an arc needs follows from the closed form of its area."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from modules.kernels import arcs
from modules.kernels.contour import ContourLines

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

MOST_HALVINGS = 12
"""4096 pieces an arc: beyond that rounding is larger than what is left."""


def refined(lines: ContourLines, tolerance: float | Floats) -> ContourLines:
    """The lines with each arc cut into 2^n pieces of equal bend, n = ceil(log4(area / tolerance)).

    Parameters
    ----------
    lines
        As `contour.lines` gives them.
    tolerance : () or (segments,)
        Largest area that may be left beside each arc; in the product of the units of x and y.

    Returns
    -------
    ContourLines
        The same lines; a straight arc gets no point, an arc that turns at a right angle gets just its corner.

    Raises
    ------
    ValueError
        If a tolerance is not positive.

    Accuracy: new points lie on the exact contour to rounding; an arc leaves at most its tolerance, proven.
    Source: thesis 3.5.1; each halving at the shoulder point leaves at most a quarter of the area.
    """
    start, end = _ends(lines)
    step = end - start
    area = arcs.area(step[:, 0], step[:, 1], lines.bend)
    halvings = np.minimum(arcs.halvings(area, tolerance), MOST_HALVINGS)
    halvings[np.abs(lines.bend) >= arcs.TURN / 2] = np.minimum(halvings[np.abs(lines.bend) >= arcs.TURN / 2], 1)
    halvings[lines.bend == 0] = 0
    pieces = 1 << halvings
    if not halvings.any():
        return lines
    which = np.repeat(np.arange(len(pieces)), pieces)
    first = np.cumsum(pieces) - pieces
    t = (np.arange(len(which)) - first[which] + 1) / pieces[which]
    inner = t < 1.0
    after = end[which].copy()
    after[inner] = arcs.point(start[which[inner]], end[which[inner]], lines.bend[which[inner]], t[inner])
    per_line = np.add.reduceat(pieces, lines.offsets[:-1] - np.arange(len(lines.offsets) - 1)) if len(pieces) else pieces
    offsets = np.concatenate([[0], np.cumsum(per_line + 1)])
    points = np.empty((int(offsets[-1]), 2))
    points[offsets[:-1]] = lines.points[lines.offsets[:-1]]
    rest = np.ones(len(points), bool)
    rest[offsets[:-1]] = False
    points[rest] = after
    bend = lines.bend[which] / pieces[which]
    return lines._replace(points=points, offsets=offsets, bend=bend, cell=lines.cell[which])


def _ends(lines: ContourLines) -> tuple[Floats, Floats]:
    """The points at which each segment starts and ends."""
    keep = np.ones(max(0, len(lines.points) - 1), bool)
    keep[lines.offsets[1:-1] - 1] = False
    return lines.points[:-1][keep], lines.points[1:][keep]
