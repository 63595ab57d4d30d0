"""Axes of a scene in space: numbers along three edges of its box, and the triad that says how it is turned."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from app.draw import numbers, page, placing
from app.draw.extent import Box
from app.draw.ink import Ink
from app.draw.page import Rect
from modules.data.grid import Frame

Floats = NDArray[np.float64]
Project = Callable[[Floats], Floats]


def edges(box: Box, project: Project, eye: Floats) -> list[tuple[Floats, Floats] | None]:
    """For x, y and z the edge of the box that numbers stand along: on its outline, lowest for x and y, leftmost for z."""
    low, high = np.array(box.low), np.array(box.high)
    front = [[eye[a] < low[a], eye[a] > high[a]] for a in range(3)]
    chosen: list[tuple[Floats, Floats] | None] = []
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        best: tuple[float, Floats, Floats] | None = None
        for sides in product((0, 1), repeat=2):
            if front[others[0]][sides[0]] == front[others[1]][sides[1]]:
                continue
            start, end = low.copy(), high.copy()
            for other, side in zip(others, sides, strict=True):
                start[other] = end[other] = (low, high)[side][other]
            middle = project(np.stack([start, end])).mean(axis=0)
            rank = float(middle[0] if axis == 2 else -middle[1])
            if best is None or rank < best[0]:
                best = (rank, start, end)
        chosen.append(best[1:] if best else None)
    return chosen


def axes(pen: Ink, plot: Rect, box: Box, frame: Frame, factor: float, project: Project, eye: Floats) -> None:
    """Numbers and names along three edges; heights are told as they are, though drawn `factor` times as high.

    Parameters
    ----------
    box : of the scene, with heights as they are drawn
    project : places as they are drawn -> pixels
    """
    centre = project(np.array([box.centre]))[0]
    taken: list[placing.Placed] = []
    for axis, edge in enumerate(edges(box, project, eye)):
        if edge is None or box.sides[axis] == 0:
            continue
        by = factor if axis == 2 else 1.0
        _one(pen, plot, frame, axis, edge, by, centre, project, taken)


def _one(
    pen: Ink, plot: Rect, frame: Frame, axis: int, edge: tuple[Floats, Floats], by: float, centre: Floats,
    project: Project, taken: list[placing.Placed],
) -> None:  # fmt: skip
    start, end = edge
    a, b = project(np.stack([start, end]))
    outward = _outward(a, b, centre)
    told = page.axis(frame.axes[axis], frame.units[axis], start[axis] / by, end[axis] / by, math.dist(a, b), pen.px(62))
    places = np.repeat(start[None], len(told.at), axis=0)
    places[:, axis] = np.array(told.at) * by
    for (x, y), words in zip(project(places), told.words, strict=True):
        tip = np.array([x, y]) + outward * pen.px(5)
        _put(pen, plot, tip, outward, words, 10.5, taken, mark=(float(x), float(y)))
    if axis == 2:  # over its upper end: the edge may be short
        _put(pen, plot, b, np.array([0.0, -1.0]), told.name, 11.0, taken)
        return
    widest = max((pen.extent(w, 10.5)[0] for w in told.words), default=0.0)
    far = (a + b) / 2 + outward * (pen.px(5 + 14) + abs(outward[0]) * widest + abs(outward[1]) * pen.px(10))
    _put(pen, plot, far, outward, told.name, 11.0, taken)


def _outward(a: Floats, b: Floats, centre: Floats) -> Floats:
    """Square to an edge on the page, away from the middle of the box."""
    along = b - a
    normal = np.array([-along[1], along[0]]) / (float(np.hypot(*along)) or 1.0)
    away: Floats = normal if (normal @ ((a + b) / 2 - centre)) > 0 else -normal
    return away


def _put(
    pen: Ink, plot: Rect, at: Floats, outward: Floats, words: str, size: float, taken: list[placing.Placed],
    mark: tuple[float, float] | None = None,
) -> None:  # fmt: skip
    """Words beyond a place, if they stand on the plot and over no other words."""
    width, height = pen.extent(words, size)
    middle = at + outward * (abs(outward[0]) * width / 2 + abs(outward[1]) * height / 2 + pen.px(3))
    label = placing.Placed(words, float(middle[0]), float(middle[1]), 0.0, width, height)
    if mark:
        pen.line([mark, (float(at[0]), float(at[1]))], role="edge")
    inside = plot.x <= middle[0] - width / 2 and middle[0] + width / 2 <= plot.right
    if not inside or any(placing.overlap(label.corners(), t.corners(), pen.px(3)) for t in taken):
        return
    taken.append(label)
    pen.text(label.x, label.y + height * 0.36, words, size=size, role="text 2", across="center")


def triad(pen: Ink, plot: Rect, frame: Frame, right: Floats, up: Floats, taken: str) -> None:
    """Three short arms that say how the scene is turned, in a lower corner that the legend leaves free.

    Parameters
    ----------
    right, up : (3,) the directions of the page in the world
    """
    arm = pen.px(26)
    x = plot.x + pen.px(34) if taken != "bottom left" else plot.right - pen.px(50)
    y = plot.bottom - pen.px(30)
    for axis in range(3):
        dx, dy = arm * float(right[axis]), -arm * float(up[axis])
        pen.line([(x, y), (x + dx, y + dy)], role="text 2", width=1.3)
        if math.hypot(dx, dy) > pen.px(6):
            scale = 1 + pen.px(8) / math.hypot(dx, dy)
            name = frame.axes[axis]
            pen.text(x + dx * scale, y + dy * scale + pen.px(3.5), name, size=10.5, role="text 2", across="center")


def height_words(factor: float) -> str:
    """What stands in the legend when heights are drawn otherwise than they are."""
    return f"heights ×{numbers.significant(factor, 3)}"
