"""Which labels find room, and where: upright along their lines, never over one another."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modules.data.scene import Text

Floats = NDArray[np.float64]
Measure = Callable[[str], tuple[float, float]]
Project = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Placed:
    """A label in pixels, y downwards: its middle, and its angle in degrees against the clock."""

    words: str
    x: float
    y: float
    angle: float
    width: float
    height: float

    def corners(self) -> Floats:
        """(4, 2) corners of the turned rectangle."""
        turn = math.radians(self.angle)
        u = np.array([math.cos(turn), -math.sin(turn)]) * self.width / 2
        v = np.array([math.sin(turn), math.cos(turn)]) * self.height / 2
        return np.array([self.x, self.y]) + np.stack([u + v, u - v, -u - v, -u + v])


def upright(angle: float) -> float:
    """The same direction in (-90, 90], so that no label stands on its head."""
    turned = (angle + 90.0) % 180.0 - 90.0
    return 90.0 if turned == -90.0 else turned


def place(
    text: Text,
    project: Project,
    measure: Measure,
    frame: tuple[float, float, float, float],
    *,
    pad: float,
    apart: float = 0.0,
    taken: list[Placed] | None = None,
) -> list[Placed]:
    """Labels that have room, in the order of the text.

    Parameters
    ----------
    project : (n, 3) places -> (n, 2) pixels; NaN where a place is not seen
    measure : words -> width and height in pixels
    frame : left, top, right, bottom of the plot in pixels
    pad : pixels kept free around each label
    apart : least distance in pixels between two labels of the same words
    taken : places where others stand already
    """
    if not text.at:
        return []
    at = np.asarray(text.at, float)
    middle = project(at)
    ends = project(at + np.asarray(text.along, float) / 2) if text.along else middle
    starts = project(at - np.asarray(text.along, float) / 2) if text.along else middle
    found: list[Placed] = []
    others = list(taken or ())
    sizes = {words: measure(words) for words in set(text.words)}
    for i, words in enumerate(text.words):
        width, height = sizes[words]
        run = ends[i] - starts[i]
        if not (np.isfinite(middle[i]).all() and np.isfinite(run).all()):
            continue
        if text.room and text.room[i] and math.hypot(*run) < width + 2 * pad:
            continue
        angle = upright(-math.degrees(math.atan2(run[1], run[0]))) if text.along else 0.0
        label = Placed(words, float(middle[i][0]), float(middle[i][1]), angle, width, height)
        if _inside(label, frame, pad) and not any(_clash(label, o, pad, apart) for o in (*others, *found)):
            found.append(label)
    return found


def _inside(label: Placed, frame: tuple[float, float, float, float], pad: float) -> bool:
    corners = label.corners()
    low, high = corners.min(axis=0) - pad, corners.max(axis=0) + pad
    return bool(low[0] >= frame[0] and low[1] >= frame[1] and high[0] <= frame[2] and high[1] <= frame[3])


def _clash(one: Placed, other: Placed, pad: float, apart: float) -> bool:
    distance = math.hypot(one.x - other.x, one.y - other.y)
    if one.words == other.words and distance < apart:
        return True
    if distance > (math.hypot(one.width, one.height) + math.hypot(other.width, other.height)) / 2 + pad:
        return False
    return overlap(one.corners(), other.corners(), pad)


def overlap(one: Floats, other: Floats, pad: float = 0.0) -> bool:
    """Whether two rectangles meet, or come closer than `pad`: no side of either parts them."""
    for box in (one, other):
        for a, b in ((0, 1), (1, 2)):
            side = box[b] - box[a]
            length = float(np.hypot(*side))
            if length == 0:
                continue
            first, second = one @ side / length, other @ side / length
            if first.max() + pad <= second.min() or second.max() + pad <= first.min():
                return False
    return True
