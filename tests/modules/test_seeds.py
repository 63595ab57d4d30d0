"""The mapper `seeds`: arrangements in the domain, corners, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from modules.api import EXACT, Model, Samples
from modules.declare import record_of
from modules.mappers.seeds import seeds
from modules.modellers.interpolate import interpolate


def box(shape: tuple[int, ...] = (5, 5, 5)) -> Model:
    return interpolate(Samples.from_array(np.zeros((*shape, 3)), vector=True, accuracy=EXACT))


def test_arrangements() -> None:
    assert seeds(box(), arrangement="point").points == pytest.approx(np.array([[2.0, 2.0, 2.0]]))
    line = seeds(box(), arrangement="line", first=(0, 0, 0), last=(4, 4, 4), count=5)
    assert line.points == pytest.approx(np.repeat(np.arange(5.0)[:, None], 3, axis=1))
    plane = seeds(box(), arrangement="plane", count=4).points
    assert len(plane) == 16 and (plane[:, 0] == 2).all()
    assert len(seeds(box(), arrangement="grid", count=3).points) == 27
    flat = seeds(box((5, 5)), arrangement="grid", count=3).points
    assert len(flat) == 9 and (flat[:, 2] == 0).all()


def test_a_ring_is_a_closed_rake_and_a_sphere_is_even() -> None:
    ring = seeds(box(), arrangement="ring", first=(2, 1, 1), last=(2, 3, 3), count=8).points
    assert (ring[:, 0] == 2).all() and np.linalg.norm(ring - 2, axis=1) == pytest.approx(1.0)
    steps = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    assert steps == pytest.approx(steps[0])
    ball = seeds(box(), arrangement="sphere", first=(1, 1, 1), last=(3, 3, 3), count=400).points - 2
    assert np.linalg.norm(ball, axis=1) == pytest.approx(1.0)
    assert np.abs(ball.mean(axis=0)).max() < 0.01 and np.cov(ball.T) == pytest.approx(np.eye(3) / 3, abs=0.01)
    flat = seeds(box((5, 5)), arrangement="ring", count=6).points
    assert len(flat) == 6 and (flat[:, 2] == 0).all()


def test_a_view_can_set_the_corners() -> None:
    record = record_of(seeds)
    for name in ("first", "last"):
        parameter = record.parameter(name)
        assert parameter is not None and parameter.position is not None and parameter.position.of == "model"


def test_random_ones_are_the_same_for_a_seed_and_within_the_box() -> None:
    one, same, other = (seeds(box(), arrangement="random", count=50, seed=s).points for s in (3, 3, 4))
    assert np.array_equal(one, same) and not np.array_equal(one, other)
    assert (one >= 0.4).all() and (one <= 3.6).all()


def test_they_are_exact() -> None:
    assert seeds(box()).accuracy.rigour() == "exact"


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="agree in one"):
        seeds(box(), arrangement="plane", first=(0, 0, 0), last=(1, 1, 1))
    with pytest.raises(ValueError, match="3 coordinates"):
        seeds(box(), first=(0, 0))
    with pytest.raises(ValueError, match="too many"):
        seeds(box(), arrangement="grid", count=1000)
    with pytest.raises(ValueError, match="at least 1"):
        seeds(box(), count=0)
