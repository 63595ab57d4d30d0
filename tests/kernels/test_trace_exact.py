"""Traces with restarts against the exact path through the piecewise trilinear velocity, and the oracle against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from modules.kernels import trace, trace_proof
from modules.kernels.runge_kutta import PAIRS
from tests.benchmarks.trace_accuracy import Case, fields, judged
from tests.oracles.traces import Exact, exact


@pytest.fixture(scope="module")
def cases() -> dict[str, tuple[Case, Exact]]:
    return {n: (c, exact(c.values, c.axes, c.seeds, c.times)) for n, c in fields(5).items()}


def test_the_oracle_turns_with_a_rotation_to_the_last_digits() -> None:
    axis, times = np.linspace(-1, 1, 6), np.linspace(0, 6.3, 8)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    seeds = np.array([[0.5, 0.1, -0.7], [0.1, 0.7, 0.0], [0.2, 0.0, 0.0]])
    found = exact(np.stack([-y, x, 0.1 + 0 * z], axis=-1), [axis] * 3, seeds, times)
    c, s = np.cos(times), np.sin(times)
    p, q = seeds[:, :1], seeds[:, 1:2]
    true = np.stack([c * p - s * q, s * p + c * q, seeds[:, 2:] + 0.1 * times], axis=-1)
    assert np.abs(found.points - true).max() < 1e-14 and np.isinf(found.left).all()


def test_the_oracle_leaves_when_and_where_it_must_and_sees_an_excursion_over_a_face() -> None:
    axis = np.arange(5.0)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    bend = np.stack([1 + 0 * x, 0.1 * (2 - x) + 0 * y, 0 * z], axis=-1)  # y = 2.9 + 0.2 t - 0.05 t^2 goes over 3 at t = 0.59
    bend[:, 4, :, 1] += 1.0  # what is beyond the face differs: who does not see the excursion ends below
    found = exact(bend, [axis] * 3, [[0.0, 2.9, 1.5]], [1.0, 2.0, 5.0])
    assert found.points[0, 0, 1] > 3.05 and found.left[0] < 5.0
    assert found.exits[0].max() == 4.0


@pytest.mark.parametrize(("name", "bar"), [("ABC 33^3", 1e-7), ("Taylor-Green 33^3", 1e-7), ("double glazing 10x10x18", 3e-5)])
@pytest.mark.parametrize("pair", ["Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)"])
def test_the_true_error_at_1e_6_and_its_estimate(cases: Any, name: str, bar: float, pair: str) -> None:
    case, true = cases[name]
    found = judged(case, true, pair, tolerance=1e-6)
    assert found.worst.max() <= (bar if pair.startswith("D") else 10 * bar)
    assert found.lost == 0 and found.exits[:2] == (0, 0) and found.exits[2] < 1e-5
    ratio = (found.estimate / np.maximum(found.true, 1e-300))[found.true > 1e-12]
    assert found.assessed == 1.0
    assert 0.9 <= np.median(ratio) <= 1.1 and ((ratio > 0.5) & (ratio < 2)).mean() >= 0.9
    assert (2 * found.estimate >= found.true - 1e-14).mean() >= 0.95


@pytest.mark.parametrize("pair", ["Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)", "Euler", "Heun", "midpoint", "RK4"])
def test_the_order_is_kept_over_the_faces(cases: Any, pair: str) -> None:
    """Steps of a part of a cell, which end on faces as well: what is left behind falls with the stated order."""
    case, true = cases["Taylor-Green 33^3"]
    sizes, off = (1.0, 0.5, 0.25), []
    for size in sizes:
        off.append(np.median(judged(case, true, pair, control="cell", size=size).worst))
    order = np.log2(off[0] / off[-1]) / 2
    assert order == pytest.approx(PAIRS[pair].order, abs=0.5)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-7])
@pytest.mark.parametrize("name", ["ABC 33^3", "Taylor-Green 33^3", "double glazing 10x10x18"])
def test_the_proven_tube_is_never_left_and_not_much_too_wide(cases: Any, name: str, tolerance: float) -> None:
    case, _ = cases[name]
    flow = trace.flow_of(case.values, *case.axes)
    rules = trace.rules_of(flow, end=float(case.times[-1]) / 2, tolerance=tolerance)
    run = trace.march(flow, case.seeds[:2], rules)
    radius = trace_proof.proven(flow, run.offsets, run.time, run.points)
    assert np.isfinite(radius).mean() > 0.8
    for i in range(2):
        rows = slice(*run.offsets[i : i + 2])
        true = exact(case.values, case.axes, case.seeds[i : i + 1], run.time[rows]).points[0]
        off, tube = np.linalg.norm(run.points[rows] - true, axis=1), radius[rows]
        assert not (off > tube).any()
        if not name.startswith("double"):
            assert np.nanmedian(tube[1:] / np.maximum(off[1:], 1e-13)) < 100  # beyond the exit there is no path


def test_a_tube_as_wide_as_cells_ends_and_rounding_is_in_it() -> None:
    axis = np.linspace(0.0, 1.0, 5)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    flow = trace.flow_of(np.stack([1 + 0 * x, 0 * y, 0 * z], axis=-1), axis, axis, axis)
    run = trace.march(flow, np.array([[0.1, 0.3, 0.3]]), trace.rules_of(flow, end=0.8))
    radius = trace_proof.proven(flow, run.offsets, run.time, run.points)
    off = np.abs(run.points[:, 0].astype(np.longdouble) - 0.1 - run.time.astype(np.longdouble))
    assert (off <= radius).all() and 0 < radius[-1] < 1e-12
    jumpy = trace.flow_of(1e3 * np.random.default_rng(0).standard_normal((5, 5, 5, 3)), axis, axis, axis)
    run = trace.march(jumpy, np.array([[0.5, 0.5, 0.5]]), trace.rules_of(jumpy, control="cell", size=1.0, end=1.0))
    assert np.isinf(trace_proof.proven(jumpy, run.offsets, run.time, run.points)).any()
