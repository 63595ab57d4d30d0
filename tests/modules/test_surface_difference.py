"""Distances between two surfaces, held against spheres whose distance is known."""

from typing import Any

import numpy as np
import pytest

from modules.accuracy_mappers.surface_difference import surface_difference
from modules.accuracy_mappers.worst import worst
from modules.api import Accuracy, Model, Progress, Samples, bound, regular
from modules.mappers.isosurface import isosurface


def ball() -> Any:
    a = np.linspace(-1, 1, 25)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    values = -np.sqrt(x**2 + y**2 + z**2)
    accuracy = Accuracy((bound("Half a unit", 0.001, values.size),))
    grid = regular(values.shape, (a[1] - a[0],) * 3, (-1.0,) * 3)
    return Model.between(Samples(grid=grid, values=values, accuracy=accuracy))


def sphere(model: Any, radius: float, method: Any = "accurate") -> Any:
    return isosurface(model, Progress(), level=-radius, method=method)


class TestDifference:
    def test_two_spheres(self) -> None:
        model = ball()
        found = surface_difference(sphere(model, 0.7), sphere(model, 0.5), Progress())
        columns = found.table.columns
        for name in ("mean", "rms", "largest"):
            assert np.allclose(np.asarray(columns[name], float), 0.2, atol=0.02)
        # the inner one looks out, to the outer one; the outer one does not look at the inner one
        assert np.asarray(columns["mean with sign"], float) == pytest.approx([0.2, -0.2], abs=0.02)
        assert np.asarray(found.surface.values["difference"].values) == pytest.approx(0.2, abs=0.02)

    def test_a_surface_and_itself(self) -> None:
        surface = sphere(ball(), 0.7)
        columns = surface_difference(surface, surface, Progress()).table.columns
        assert np.asarray(columns["largest"], float).max() < 1e-6

    def test_two_methods_differ_by_less_than_their_bounds(self) -> None:
        model = ball()
        one, two = sphere(model, 0.7), sphere(model, 0.7, "classic")
        columns = surface_difference(one, two, Progress()).table.columns
        bounds = sum(np.asarray(s.values["distance"].values).max() for s in (one, two))
        assert 0 < np.asarray(columns["largest"], float).max() <= bounds

    def test_terms_end_and_the_worst_places_are_found(self) -> None:
        model = ball()
        one, two = sphere(model, 0.7), sphere(model, 0.5)
        found = surface_difference(one, two, Progress())
        for each in found:
            assert one.accuracy.accounted() | two.accuracy.accounted() <= each.accuracy.accounted()
        assert np.asarray(worst(found.surface, Progress()).table.columns["size"], float)[0] == pytest.approx(
            np.abs(np.asarray(found.surface.values["difference"].values)).max()
        )

    def test_an_empty_surface_is_refused(self) -> None:
        model = ball()
        with pytest.raises(ValueError, match="second surface has no triangles"):
            surface_difference(sphere(model, 0.7), sphere(model, 99.0), Progress())
