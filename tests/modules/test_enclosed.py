"""Enclosed volume and area: bounds against fine subdivision, errors against draws."""

from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Model, Progress, Samples, bound, deviation
from modules.data.accuracy import Accuracy
from modules.kernels import cubes, solid
from modules.modellers.enclosed import enclosed


def of(values: Any, level: Any = 0.0, spacing: Any = 1.0, accuracy: Any = EXACT, **given: Any) -> Any:
    model = Model.between(Samples.from_array(values, spacing=spacing, accuracy=accuracy))
    return enclosed(model, Progress(), level=level, **given)


def ball(n: int) -> Any:
    a = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    return 0.6 - (x**2 + y**2 + z**2)


def size(value: Any, quantity: str) -> float:
    return float(value.accuracy.total(1.0, quantity)[0])


def mapping(value: Any) -> Any:
    return next(t for t in value.accuracy.terms if t.source.stage == "mapping")


@pytest.mark.parametrize("cuts", [1, 4, 8])
def test_the_bounds_hold_the_volume_of_a_fine_subdivision(cuts: int) -> None:
    values = np.random.default_rng(0).normal(size=(5, 6, 7))
    x, y, z = (np.arange(float(n)) for n in (7, 6, 5))
    fine, _ = cubes.refined(values, (x, y, z), 24)
    middle = np.lib.stride_tricks.sliding_window_view(fine, (2, 2, 2)).mean(axis=(3, 4, 5))
    for level in (-0.5, 0.0, 0.5):
        part = solid.volume(values, x, y, z, level, cuts)
        assert part.low <= (middle >= level).mean() * part.whole <= part.high


def test_bounds_come_together_with_the_square_of_the_cuts() -> None:
    values, axis = ball(9), np.linspace(-1, 1, 9)
    gap = [np.subtract(*solid.volume(values**3, axis, axis, axis, 0.001, cuts)[1::-1]) for cuts in (4, 8)]
    assert gap[1] < 0.35 * gap[0]


def test_a_plane_is_exact() -> None:
    x = np.arange(5.0)
    values = np.broadcast_to(x - 1.25, (5, 5, 5)).copy()
    found = of(values)
    assert found.volume.value == pytest.approx(2.75 * 16, abs=1e-4)
    assert found.area.value == pytest.approx(16)
    assert mapping(found.area).size()[0] < 1e-9


def test_a_ball() -> None:
    found = of(ball(33), spacing=2 / 32)
    assert found.volume.value == pytest.approx(4 / 3 * np.pi * 0.6**1.5, rel=0.01)
    assert found.area.value == pytest.approx(4 * np.pi * 0.6, rel=0.01)


def test_the_area_is_nearer_than_the_triangles_and_its_error_holds() -> None:
    values = np.exp(2 * ball(7))
    found = of(values, 1.0, 2 / 6)
    fine, _ = cubes.refined(values, (np.linspace(-1, 1, 7),) * 3, 10)
    truth = of(fine, 1.0, 2 / 60).area.value
    assert abs(found.area.value - truth) <= mapping(found.area).size()[0]
    assert abs(found.area.value / truth - 1) < 0.003


def test_errors_of_samples_change_the_volume_as_draws_do() -> None:
    values, noise, random, x = ball(12), 0.02, np.random.default_rng(3), np.linspace(-1, 1, 12)
    accuracy = Accuracy((deviation("Noise", noise, values.size),))
    found = of(values, 0.0, 2 / 11, accuracy)
    term = next(t for t in found.volume.accuracy.terms if t.name == "Noise")
    drawn = []
    for _ in range(200):
        part = solid.volume(values + noise * random.normal(size=values.shape), x, x, x, 0.0, 3)
        drawn.append((part.low + part.high) / 2)
    assert term.size()[0] == pytest.approx(np.std(drawn), rel=0.2)


def test_a_common_error_is_area_times_shift() -> None:
    values = ball(17)
    accuracy = Accuracy((bound("Half a unit", 0.01, values.size),))
    found = of(values, 0.0, 2 / 16, accuracy)
    term = next(t for t in found.volume.accuracy.terms if t.name == "Half a unit")
    assert term.unit == ""
    assert term.size()[0] == pytest.approx(0.01 * 4 * np.pi * 0.6 / (2 * np.sqrt(0.6)), rel=0.03)


def test_holes_do_not_count_and_are_told() -> None:
    values = ball(9)
    values[4, 4, 4] = np.nan
    found = of(values)
    assert any(m.name == "Holes" for m in found.volume.accuracy.missing)
    assert found.volume.value < of(ball(9)).volume.value


def test_what_cannot_be_measured_is_refused() -> None:
    with pytest.raises(ValueError, match="3 dimensions"):
        of(np.zeros((3, 3)))
    with pytest.raises(ValueError, match="number"):
        of(ball(5), np.nan)


def test_a_level_beside_the_field() -> None:
    assert of(ball(5), 9.0).volume.value == pytest.approx(0, abs=1e-6)
    assert of(ball(5), -9.0).volume.value == pytest.approx(64)
    assert of(ball(5), 9.0).area.value == 0
