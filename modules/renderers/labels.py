"""Levels written along contour lines, or words in a corner."""

from __future__ import annotations

import numpy as np

from modules.api import Annotated, Choice, Geometry, LabelLook, Layer, Range, Text, renderer
from modules.data.operators import Floats
from modules.renderers import _titles

TRIES = 9
"""Places looked at on each stretch of a line."""

SPAN = 0.2
"""Part of the distance of labels over which a line is looked at for how straight it runs."""

MOST_BENT = 1.6
"""A line this many times longer than its chord carries no label there."""


@renderer("Labels", aliases=("annotation", "level labels", "contour labels", "text"), output="layer")
def labels(
    geometry: Geometry,
    *,
    by: Annotated[str, Choice(of="geometry.names")] = "level",
    size: Annotated[float, Range(7, 24)] = 10.5,
    colour: str = "text",
    apart: Annotated[float, Range(0.05, 2)] = 0.35,
    every: Annotated[int, Range(1, 10)] = 1,
    unit: bool = False,
) -> Layer:
    """The level of each contour line, written along it where it runs straightest.

    Parameters
    ----------
    by : values of the lines or points that are written
    size : of the text, in pixels at 100 %
    colour : a role or "#rrggbb"
    apart : least distance between labels of one line, as a share of the picture's width
    every : only every so-many-th level
    unit : whether each label has its unit

    Raises
    ------
    ValueError : no such values

    Accuracy: passed on as it is. Labels cover a piece of a line and say nothing of where it lies; what has no room, or
        would lie over another label, is left out.
    """
    text = text_along(geometry, by, apart, every, unit)
    look = LabelLook(size=size, colour=colour)
    return Layer(shape=text, look=look, title="", shows=(), accuracy=geometry.accuracy)


def text_along(geometry: Geometry, by: str, apart: float, every: int, unit: bool) -> Text:
    """Places for labels on the lines of a geometry, the straightest first."""
    if by not in geometry.values:
        there = ", ".join(geometry.values) or "none"
        raise ValueError(f"the geometry has no values {by!r} to write; it has {there}")
    field = geometry.values[by]
    values = _of_lines(geometry, np.asarray(field.values, float), field.place)
    wanted = {v: i % every == 0 for i, v in enumerate(np.unique(values))}
    bounds = geometry.bounds
    width = max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]) if bounds else 0.0
    found: list[tuple[float, str, Floats, Floats, float]] = []
    for line, value in zip(geometry.polylines(), values, strict=True):
        if wanted[value]:
            words = _titles.with_unit(_titles.number(value), field.unit if unit else "")
            found += [(bend, words, at, along, room) for bend, at, along, room in places(line, apart * width)]
    found.sort(key=lambda f: f[0])
    return Text(
        words=tuple(f[1] for f in found),
        at=tuple(_triple(f[2]) for f in found),
        along=tuple(_triple(f[3]) for f in found),
        room=tuple(f[4] for f in found),
    )


def _of_lines(geometry: Geometry, values: Floats, place: str) -> Floats:
    """(lines,) one value a line, from values on cells, points or segments."""
    if place == "cell":
        start = len(geometry.vertices)
        return values[start : start + len(geometry.lines)]
    if place == "point":
        return values[geometry.lines.connectivity[geometry.lines.offsets[:-1]]]
    first: Floats = values[geometry.lines.offsets[:-1] - np.arange(len(geometry.lines))]
    return first


def places(line: Floats, apart: float) -> list[tuple[float, Floats, Floats, float]]:
    """Places on one line for its label: (bend, middle, direction, room), two at most for each stretch of length `apart`.

    The bend is how much longer the line is than the chord under the label; the room is that chord's length.
    """
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(lengths)])
    total = float(run[-1])
    if len(line) < 3 or total <= 0:
        return []
    stretches = max(1, int(total / apart)) if apart > 0 else 1
    marks = np.linspace(0, total, stretches + 1)
    tries = marks[:-1, None] + (marks[1:] - marks[:-1])[:, None] * np.linspace(0, 1, TRIES + 2)[1:-1]
    half = np.minimum(SPAN * apart / 2, np.minimum(tries, total - tries))
    before, middle, after = (
        np.stack([np.interp(tries + side * half, run, line[:, axis]) for axis in range(3)], axis=-1) for side in (-1, 0, 1)
    )
    chord = after - before
    length = np.linalg.norm(chord, axis=-1)
    bend = np.where(length > 0, 2 * half / np.where(length > 0, length, 1.0), np.inf)
    best = np.argsort(bend, axis=1, kind="stable")[:, :2]
    return [
        (float(bend[i, j]), middle[i, j], chord[i, j], float(length[i, j]))
        for i in range(stretches)
        for j in best[i]
        if bend[i, j] < MOST_BENT
    ]


def _triple(v: Floats) -> tuple[float, float, float]:
    return (float(v[0]), float(v[1]), float(v[2]))
