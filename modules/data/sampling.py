"""A model at any places, also outside of it, where it has no value."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Accuracy, Flag
from modules.data.laws import axial
from modules.data.operators import Floats, Gather
from modules.data.wires import Model

SLACK = 1e-9
"""Of the extent of an axis: rounding by which a place may lie outside."""


def within(model: Model, points: Floats) -> NDArray[np.bool_]:
    """(n,) whether a place lies in the box of the model; a map has every height.

    Raises
    ------
    ValueError : the grid is bent or unstructured
    """
    inside = np.isfinite(points).all(axis=1)
    for axis, x in enumerate(axial(model.grid).axes):
        slack = SLACK * float(x[-1] - x[0])
        inside &= (points[:, axis] >= x[0] - slack) & (points[:, axis] <= x[-1] + slack)
    return np.asarray(inside)


def at_places(model: Model, points: Floats) -> tuple[Floats, Accuracy, NDArray[np.bool_]]:
    """Values at places, NaN outside of the model, with their accuracy; and which lie inside.

    Parameters
    ----------
    points : (n, 3) in the frame of the model

    Returns
    -------
    (n,) or (n, 3 ...) values; Accuracy of n rows, which says nothing outside; (n,) inside

    Raises
    ------
    ValueError : no place lies inside, or the grid is bent or unstructured
    """
    inside = within(model, points)
    if len(points) and not inside.any():
        low, high = np.reshape(model.grid.bounds, (3, 2)).T
        raise ValueError(
            f"none of the {len(points)} places lies in the model, which goes from {_words(low)} to {_words(high)}; "
            f"the first is {_words(points[0])}"
        )
    if inside.all():
        return *model.at(points), inside
    found, known = model.at(points[inside])
    values = np.full((len(points), *found.shape[1:]), np.nan)
    values[inside] = found
    return values, outside_is_nothing(known, inside, model.samples.components), inside


def outside_is_nothing(known: Accuracy, inside: NDArray[np.bool_], components: int) -> Accuracy:
    """The accuracy of some places as that of all; the others have a flag instead."""
    place = np.maximum(np.cumsum(inside) - 1, 0)
    index = (place[:, None] * components + np.arange(components)).ravel()[:, None]
    weight = np.repeat(inside.astype(float), components)[:, None]
    accuracy = known.push(Gather(index, weight, int(inside.sum()) * components))
    items = np.flatnonzero(inside)
    flags = [
        Flag(f.name, f.words, f.place, items if f.items is None else items[f.items], f.values)
        for f in known.flags
        if f.place == "point"
    ]
    words = f"{int((~inside).sum())} of {len(inside)} places lie outside the model, where it has no value"
    return accuracy.flag(*flags, Flag("outside", words, "point", np.flatnonzero(~inside)))


def _words(place: Floats) -> str:
    return "(" + ", ".join(f"{v:g}" for v in place) + ")"
