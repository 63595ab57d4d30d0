"""A flat geometry laid over the surface of a field."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import Accuracy, Annotated, Geometry, Model, Range, mapper


@mapper("Drape", aliases=("lift", "project on surface", "on terrain"), output="draped")
def drape(geometry: Geometry, model: Model, *, scale: Annotated[float, Range(0, 10)] = 1.0) -> Geometry:
    """Points, lines and polygons of the plane lifted to z = scale * F.

    Parameters
    ----------
    geometry : what is lifted, in the plane of the model
    scale : height of one unit of the field, in units of the plane; that of the elevation surface beside it

    Raises
    ------
    ValueError : a point lies outside the model

    Accuracy: what is known of the geometry in its plane goes on; errors of the height end here, for the surface beside it
        shows them.
    Source: Lopes 1999, 2.4.2-2.4.4 (figure 2.7).
    """
    height, _ = model.at(geometry.points)
    if height.ndim != 1:
        raise ValueError("drape needs one value a sample: choose a component or the length")
    points = geometry.points.copy()
    points[:, 2] = scale * np.nan_to_num(height)
    return replace(geometry, points=points, accuracy=_ended(geometry.accuracy, model))


def _ended(accuracy: Accuracy, model: Model) -> Accuracy:
    why = "an error of the height is shown by the surface, not by what lies on it"
    return accuracy.end_from(model.accuracy, why).miss(*model.accuracy.missing)
