"""Names written beside points, or the name of a shape above it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import Annotated, Choice, Geometry, LabelLook, Layer, Range, Text, renderer

AROUND = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1], [0, 1.2], [1.2, 0], [-1.2, 0], [0, -1.2]]) / 1.2
"""Where a name may stand beside its point, in order of choice."""


@renderer("Names", aliases=("point labels", "annotation", "text", "letters"), output="layer")
def names(
    geometry: Geometry,
    *,
    by: Annotated[str, Choice(of="geometry.names")] = "name",
    size: Annotated[float, Range(7, 24)] = 12.0,
    colour: str = "text",
    apart: Annotated[float, Range(0, 0.2)] = 0.03,
    title: str = "",
) -> Layer:
    """A name beside each point; or the name of the shape above its middle.

    Parameters
    ----------
    by : values of the points that are written; "" writes the name of the shape
    size : of the text, in pixels at 100 %
    colour : a role or "#rrggbb"
    apart : distance of a name from its point, as a share of the shape's width (of a cell, if that is more)
    title : for the legend; nothing by default

    Raises
    ------
    ValueError : the points have no such values

    Accuracy: passed on as it is. A name stands beside its point and says nothing of where that may lie; what has no room is
        left out.
    """
    text = beside(geometry, by, apart) if by else above(geometry, apart)
    return Layer(shape=text, look=LabelLook(size=size, colour=colour), title=title, shows=(), accuracy=geometry.accuracy)


def beside(geometry: Geometry, by: str, apart: float) -> Text:
    """Names of points, each with several places; the first that has room is taken, the others lie too near to it.

    Values "aside" of the points, if there are any, say on which side there is room.
    """
    if by not in geometry.values or geometry.values[by].place != "point":
        there = ", ".join(geometry.values) or "none"
        raise ValueError(f"the points have no values {by!r} to write; there are {there}")
    words = [_word(v) for v in geometry.values[by].values]
    aside = geometry.values.get("aside")
    step = apart * _width(geometry)
    tries: list[tuple[str, NDArray[np.float64]]] = []
    for i, word in enumerate(words):
        order = np.arange(len(AROUND))
        if aside is not None:
            order = np.argsort(-(AROUND @ np.asarray(aside.values[i], float)[:2]), kind="stable")
        tries += [(word, geometry.points[i] + step * np.append(AROUND[k], 0.0)) for k in order]
    return Text(words=tuple(w for w, _ in tries), at=tuple((float(x), float(y), float(z)) for _, (x, y, z) in tries))


def above(geometry: Geometry, apart: float) -> Text:
    """The name of a shape, above the middle of its box."""
    bounds = geometry.bounds
    if bounds is None or not geometry.name:
        return Text(words=())
    top = bounds[3] + 2 * apart * _width(geometry)
    return Text(words=(geometry.name,), at=(((bounds[0] + bounds[1]) / 2, top, bounds[5]),))


def _word(value: object) -> str:
    if isinstance(value, str | np.str_):
        return str(value)
    return f"{float(value):.6g}".replace("-", "−")  # type: ignore[arg-type]  # values are words or numbers


def _width(geometry: Geometry) -> float:
    """Of the shape, or of one cell where its points lie closer together than that."""
    bounds = geometry.bounds
    return max(bounds[1] - bounds[0], bounds[3] - bounds[2], geometry.cell or 0.0) if bounds else 0.0
