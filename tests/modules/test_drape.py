"""Draping: heights from the model, accuracy of the plane kept, that of the height ended."""

from __future__ import annotations

import numpy as np
import pytest

from modules.api import EXACT, Missing, Progress, Samples, bound
from modules.mappers.contour import contour
from modules.mappers.drape import drape
from modules.modellers.interpolate import interpolate

VALUES = np.random.default_rng(0).normal(size=(6, 7))


def test_contour_lines_lie_at_their_level_on_the_surface() -> None:
    accuracy = EXACT.add(bound("b", 0.1, 42)).miss(Missing("survey"))
    model = interpolate(Samples.from_array(VALUES, spacing=(2, 3), accuracy=accuracy))
    flat = contour(model, Progress(), levels=(0.2,))
    lifted = drape(flat, model, scale=3.0)
    assert np.allclose(lifted.points[:, 2], 0.6)
    assert np.array_equal(lifted.points[:, :2], flat.points[:, :2])
    assert lifted.counts == flat.counts
    assert [t.id for t in lifted.accuracy.terms] == [t.id for t in flat.accuracy.terms]
    other = interpolate(Samples.from_array(VALUES, spacing=(2, 3), accuracy=EXACT.add(bound("c", 1.0, 42))))
    assert {t.id for t in other.accuracy.terms} <= drape(flat, other).accuracy.accounted()
    assert drape(flat, other).accuracy.missing == (Missing("survey"),)


def test_points_outside_are_told() -> None:
    model = interpolate(Samples.from_array(VALUES[:3, :3], accuracy=EXACT))
    wide = contour(interpolate(Samples.from_array(VALUES, accuracy=EXACT)), Progress(), levels=(0.2,))
    with pytest.raises(ValueError, match="outside the grid"):
        drape(wide, model)
