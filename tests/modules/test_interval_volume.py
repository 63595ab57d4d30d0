"""Interval volumes: closed, of the right topology and volume."""

from typing import Any

import numpy as np
import pytest

from modules.api import Model, Progress, Samples, bound
from modules.data.accuracy import Accuracy
from modules.mappers._isosurface_methods import open_edges
from modules.mappers.interval_volume import interval_volume
from tests.oracles import topology


def model_of(values: Any, spacing: Any = 1.0) -> Any:
    accuracy = Accuracy((bound("Half a unit", 0.01, np.size(values)),))
    return Model.between(Samples.from_array(values, spacing=spacing, accuracy=accuracy))


def volume(g: Any) -> float:
    p = g.points[g.triangles]
    return float(np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6)


def made(values: Any, low: Any = None, high: Any = None, **given: Any) -> Any:
    return interval_volume(model_of(values, **given), Progress(), low=low, high=high)


@pytest.mark.parametrize("seed", range(6))
def test_noise_gives_a_closed_oriented_mesh_of_the_right_volume(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = random.normal(size=random.integers(3, 6, 3))
    low, high = (-0.3, 0.4) if seed % 2 else (-0.05, 0.02)
    found = made(values, low, high)
    g = found.surface
    assert not len(open_edges(g.points, g.triangles))
    ends = topology.ends_of(g.triangles) @ np.array([len(g.points), 1])
    assert len(np.unique(ends)) == len(ends), "each edge once in each direction"
    assert len(np.unique(g.triangles)) == len(g.points)
    half = float(found.volume.accuracy.total(1.0, "volume")[0])
    assert abs(volume(g) - found.volume.value) < half + 0.03 * np.prod(np.array(values.shape) - 1)


def test_a_shell_about_a_ball() -> None:
    a = np.linspace(-1, 1, 14)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    found = made(0.8 - np.sqrt(x**2 + y**2 + z**2), 0.0, 0.3, spacing=2 / 13)
    g = found.surface
    assert topology.components(len(g.points), g.triangles) == 2
    assert topology.euler(len(g.points), g.triangles) == 4
    assert found.volume.value == pytest.approx(4 / 3 * np.pi * (0.8**3 - 0.5**3), rel=0.02)
    assert volume(g) == pytest.approx(found.volume.value, rel=0.01)
    assert not (g.values["side"].values == 2).any(), "the grid's border is not met"


def test_a_layer_is_exact() -> None:
    values = np.broadcast_to(np.arange(5.0), (4, 4, 5)).copy()
    found = made(values, 1.25, 3.5)
    assert volume(found.surface) == pytest.approx(2.25 * 9)
    assert found.volume.value == pytest.approx(2.25 * 9, abs=1e-4)
    assert topology.euler(len(found.surface.points), found.surface.triangles) == 2


def test_ties_and_the_whole_grid() -> None:
    values = np.random.default_rng(3).integers(-2, 3, (4, 4, 4)).astype(float)
    for low, high in ((-1.0, 1.0), (0.0, 0.5), (-9.0, 9.0)):
        g = made(values, low, high).surface
        assert not len(open_edges(g.points, g.triangles))
    assert volume(g) == pytest.approx(27)


def test_the_budget() -> None:
    model = model_of(np.random.default_rng(1).normal(size=(4, 4, 4)))
    found = interval_volume(model, Progress(), low=-0.2, high=0.3)
    for one in (found.surface, found.volume):
        assert model.accuracy.accounted() <= one.accuracy.accounted()
    assert all(t.count == len(found.surface.points) for t in found.surface.accuracy.select("position"))


def test_what_cannot_be_closed_is_refused() -> None:
    with pytest.raises(ValueError, match="less than"):
        made(np.zeros((3, 3, 3)), 1.0, 0.0)
    with pytest.raises(ValueError, match="not known"):
        made(np.full((3, 3, 3), np.nan), 0.0, 1.0)
