"""Interpolation at many points gives to the bit what numpy gives at few."""

from typing import Any

import numpy as np
import pytest

from modules.data.grid import Rectilinear
from modules.data.laws import Linear, curvature, locate
from modules.data.operators import MANY

LINEAR = Linear()


def grid(dimensions: int) -> Any:
    random = np.random.default_rng(3)
    axes = [np.cumsum(random.uniform(0.2, 2, n)) for n in (5, 2, 6)[:dimensions]]
    values = random.normal(size=[len(a) for a in reversed(axes)])
    values.flat[values.size // 2] = np.nan
    points = np.zeros((MANY, 3))
    for n, axis in enumerate(axes):
        points[:, n] = random.uniform(axis[0], axis[-1], MANY)
        points[::3, n] = random.choice(axis, len(points[::3]))
    return Rectilinear(tuple(axes)), values, points


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_many_points_are_as_few(dimensions: int) -> None:
    box, values, points = grid(dimensions)
    parts = np.array_split(points, 4)
    for at in (
        lambda p: locate(box, p)[0],
        lambda p: locate(box, p)[1],
        lambda p: LINEAR.weights(box, p).index,
        lambda p: LINEAR.weights(box, p).weight,
        lambda p: LINEAR.weights(box, p).apply(values.ravel()),
        lambda p: LINEAR.slopes(box, p)[-1].apply(values.ravel()),
        lambda p: curvature(box, values, p),
        lambda p: LINEAR.error(box, values, p),
    ):
        np.testing.assert_array_equal(at(points), np.concatenate([at(part) for part in parts]))


def test_a_point_outside_is_refused() -> None:
    box, _, points = grid(3)
    points[5, 1] = -1.0
    with pytest.raises(ValueError, match="1 of 8192 points lie outside the grid"):
        locate(box, points)
