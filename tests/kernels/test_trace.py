"""The kernel of particle traces: against closed forms and an independent reference, cell by cell, and at every border."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from modules.kernels import trace, trace_flow
from modules.kernels.runge_kutta import PAIRS
from modules.kernels.trace import REASONS
from modules.kernels.trace_fields import axes_of

Floats = NDArray[np.float64]
FIXED = ("Euler", "Heun", "midpoint", "RK4")


def grid(n: int, low: float = -1.0, high: float = 1.0) -> tuple[Floats, Floats, Floats, Floats]:
    axis = np.linspace(low, high, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    return axis, x, y, z


def abc(n: int = 13) -> Any:
    axis, x, y, z = grid(n, 0.0, 2 * np.pi)
    a, b, c = np.sqrt(3.0), np.sqrt(2.0), 1.0
    v = np.stack([a * np.sin(z) + c * np.cos(y), b * np.sin(x) + a * np.cos(z), c * np.sin(y) + b * np.cos(x)], axis=-1)
    return trace.flow_of(v, axis, axis, axis)


def taylor_green(n: int = 13) -> Any:
    axis, x, y, z = grid(n, 0.0, np.pi)
    v = np.stack([np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z), 0.0 * z], axis=-1)
    return trace.flow_of(v, axis, axis, axis)


def rotation(n: int = 9) -> Any:
    axis, x, y, z = grid(n)
    return trace.flow_of(np.stack([-y, x, 0 * z], axis=-1), axis, axis, axis)


def march(flow: Any, seeds: Any, pair: str = "Dormand-Prince 5(4)", **rules: Any) -> trace.Traces:
    return trace.march(flow, np.asarray(seeds, float), trace.rules_of(flow, pair=pair, **rules), pair)


def trilinear(flow: Any, cell: NDArray[np.int64], p: Floats) -> Floats:
    """The polynomial of a cell, on its own."""
    total, axes = np.zeros(3), axes_of(flow)
    values = flow.numbers[: 3 * axes[0].size * axes[1].size * axes[2].size].reshape(axes[2].size, axes[1].size, -1, 3)
    u = [(p[a] - axes[a][cell[a]]) / (axes[a][cell[a] + 1] - axes[a][cell[a]]) for a in range(3)]
    for k in range(8):
        bits = (k & 1, k >> 1 & 1, k >> 2)
        weight = np.prod([u[a] if bits[a] else 1 - u[a] for a in range(3)])
        total += weight * values[cell[2] + bits[2], cell[1] + bits[1], cell[0] + bits[0]]
    return total


def reference(flow: Any, seed: Floats, times: Floats) -> Floats:
    """DOP853 to 1e-13, begun anew at each face; positions at the times."""
    p, t, axes = np.array(seed, float), 0.0, axes_of(flow)
    cell = np.array([min(max(np.searchsorted(x, p[a], side="right") - 1, 0), len(x) - 2) for a, x in enumerate(axes)])
    found = np.full((len(times), 3), np.nan)
    for _ in range(500):
        if t >= times[-1]:
            break
        events: list[Any] = []
        for a in range(3):
            for side in range(2):
                def event(_: float, q: Floats, a: int = a, side: int = side, cell: NDArray[np.int64] = cell) -> float:
                    return float(q[a] - axes[a][cell[a] + side])

                event.terminal = True  # type: ignore[attr-defined]  # scipy's way
                event.direction = 1.0 if side else -1.0  # type: ignore[attr-defined]
                events.append(event)
        own = cell.copy()
        s = solve_ivp(
            lambda _, q, own=own: trilinear(flow, own, q), (t, times[-1]), p, method="DOP853", rtol=1e-13, atol=1e-13,
            events=events, dense_output=True,
        )  # fmt: skip
        here = (times >= t) & (times <= s.t[-1])
        if here.any():
            found[here] = s.sol(times[here]).T
        t, p = s.t[-1], s.y[:, -1]
        hit = [k for k, e in enumerate(s.t_events) if len(e)]
        if s.status == 0 or not hit:
            break
        a, side = divmod(hit[0], 2)
        p[a] = axes[a][cell[a] + side]
        cell[a] += 1 if side else -1
        if not 0 <= cell[a] <= len(axes[a]) - 2:
            break
    return found


@pytest.mark.parametrize("field", [abc, taylor_green])
def test_it_agrees_with_an_independent_reference_begun_anew_at_faces(field: Any) -> None:
    flow = field()
    seeds = np.random.default_rng(3).uniform(0.8, 2.3, (3, 3))
    found = march(flow, seeds, end=1.5, interval=0.25, tolerance=1e-12)
    for i in range(3):
        a, b = found.offsets[i : i + 2]
        true = reference(flow, seeds[i], found.time[a:b])
        inside = np.isfinite(true).all(axis=1)
        assert inside.sum() >= 3
        assert np.abs(found.points[a:b] - true)[inside].max() < 2e-9


def pooled(flow: Any, seeds: Floats, end: float, interval: float, **rules: Any) -> tuple[Floats, Floats]:
    """True and estimated size of the error at all samples but the last of each trace."""
    fine = march(flow, seeds, end=end, interval=interval, tolerance=1e-13)
    found = march(flow, seeds, end=end, interval=interval, assess=True, **rules)
    true, estimate = [], []
    for i in range(len(seeds)):
        a, b, c, d = *found.offsets[i : i + 2], *fine.offsets[i : i + 2]
        n = min(b - a, d - c) - 1
        true.append(np.linalg.norm(found.points[a + 1 : a + n] - fine.points[c + 1 : c + n], axis=1))
        estimate.append(np.linalg.norm(found.error[a + 1 : a + n], axis=1))
    return np.concatenate(true), np.concatenate(estimate)


@pytest.mark.parametrize("field", [abc, taylor_green])
@pytest.mark.parametrize("pair", ["Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)"])
def test_the_estimate_of_two_half_steps_is_the_error(field: Any, pair: str) -> None:
    flow = field()
    seeds = np.random.default_rng(0).uniform(0.7, 2.4, (60, 3))
    true, estimate = pooled(flow, seeds, 3.0, 0.1, tolerance=1e-4, pair=pair)
    effectivity = estimate[true > 1e-12] / true[true > 1e-12]
    low, middle, high = np.quantile(effectivity, (0.05, 0.5, 0.95))
    assert 0.9 < middle < 1.1
    assert low > 0.5 and high < 2.0


def test_without_restarts_the_order_is_lost_and_rksuite_does_not_trust_the_estimate() -> None:
    flow = abc()
    seeds = np.random.default_rng(0).uniform(1.0, 5.0, (40, 3))
    with_faces, _ = pooled(flow, seeds, 2.0, 0.1, tolerance=1e-6)
    without, _ = pooled(flow, seeds, 2.0, 0.1, tolerance=1e-6, faces=False)
    assert np.median(without) > 30 * np.median(with_faces)
    trusted = march(flow, seeds, end=2.0, tolerance=1e-6, assess=True).trusted
    doubted = march(flow, seeds, end=2.0, tolerance=1e-6, assess=True, faces=False).trusted
    assert np.isinf(trusted).mean() > 0.95 and np.isinf(doubted).mean() < 0.3


@pytest.mark.parametrize("pair", PAIRS)
def test_the_observed_order_is_the_stated_one(pair: str) -> None:
    flow = rotation(2)  # one cell, so nothing but the method makes errors
    sizes = 0.2 / 2.0 ** np.arange(3)
    errors = []
    for size in sizes:
        found = march(flow, [[0.6, 0.0, 0.0]], pair, control="fixed", size=size, end=1.0)
        errors.append(np.hypot(*(found.points[-1, :2] - 0.6 * np.array([np.cos(1), np.sin(1)]))))
    observed = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert observed[-1] == pytest.approx(PAIRS[pair].order, abs=0.25)


def test_the_tableaus_are_consistent() -> None:
    for pair in PAIRS.values():
        assert pair.result.sum() == pytest.approx(1.0, abs=1e-14)
        assert pair.error.sum() == pytest.approx(0.0, abs=1e-14)
        assert pair.dense.sum(axis=1) == pytest.approx(pair.result, abs=1e-13)
        assert np.array_equal(pair.stages[-1], pair.result)


def test_rotation_comes_round_to_the_tolerance() -> None:
    for tolerance in (1e-5, 1e-8, 1e-11):
        found = march(rotation(), [[0.7, 0.1, 0.3]], end=2 * np.pi, tolerance=tolerance, assess=True)
        assert np.linalg.norm(found.points[-1] - [0.7, 0.1, 0.3]) < 100 * tolerance
        assert REASONS[found.reason[0]] == "end time"


def test_the_exit_is_recorded_on_the_border() -> None:
    axis, x, y, z = grid(6)
    flow = trace.flow_of(np.stack([1 + 0 * x, 0.25 + 0 * y, 0 * z], axis=-1), axis, axis, axis)
    for faces in (True, False):
        found = march(flow, [[-0.55, 0.1, 0.2]], interval=0.4, faces=faces)
        assert REASONS[found.reason[0]] == "left the domain"
        assert found.points[-1] == pytest.approx([1.0, 0.1 + 0.25 * 1.55, 0.2], abs=1e-12)
        assert found.time == pytest.approx([0, 0.4, 0.8, 1.2, 1.55])


@pytest.mark.parametrize("faces", [True, False])
def test_a_wall_at_rest_is_no_exit_and_nothing_stalls(faces: bool) -> None:
    axis, x, y, z = grid(9)
    rate = (1 - x**2) * (1 - y**2)
    flow = trace.flow_of(np.stack([rate, 0.5 * rate, 0 * z], axis=-1), axis, axis, axis)
    seeds = np.random.default_rng(1).uniform(-0.8, 0.8, (20, 3))
    found = march(flow, seeds, end=200.0, interval=10.0, faces=faces, steps=50_000)
    assert {REASONS[r] for r in found.reason} <= {"end time", "at rest"}
    assert (np.abs(found.points) <= 1.0).all()
    assert found.evaluations.max() < 100_000


def test_a_hole_ends_a_trace_where_it_begins() -> None:
    axis, x, y, z = grid(9)
    v = np.stack([1 + 0 * x, 0 * y, 0 * z], axis=-1)
    v[4, 4, 6] = np.nan  # the node at x = 0.5 makes a hole of the cells from x = 0.25 on
    flow = trace.flow_of(v, axis, axis, axis)
    found = march(flow, [[-0.9, 0.1, 0.1], [0.4, 0.1, 0.1], [2.0, 0.0, 0.0], [-0.9, 0.6, 0.1]])
    assert [REASONS[r] for r in found.reason] == ["hole", "hole", "began outside", "left the domain"]
    assert found.points[found.offsets[1] - 1] == pytest.approx([0.25, 0.1, 0.1])
    assert np.diff(found.offsets)[1:3].tolist() == [0, 0]
    plain = march(flow, [[-0.9, 0.1, 0.1]], faces=False)
    assert REASONS[plain.reason[0]] == "hole" and plain.points[-1, 0] == pytest.approx(0.25, abs=1e-6)


def test_length_steps_rest_and_backwards() -> None:
    found = march(rotation(), [[0.5, 0.0, 0.0]], length=1.0)
    assert REASONS[found.reason[0]] == "largest length" and found.length[0] == pytest.approx(1.0)
    found = march(rotation(), [[0.5, 0.0, 0.0]], steps=3)
    assert REASONS[found.reason[0]] == "most steps" and len(found.time) == 4
    found = march(rotation(), [[0.0, 0.0, 0.0]])
    assert REASONS[found.reason[0]] == "at rest" and len(found.time) == 1
    axis, x, y, z = grid(9)
    back = trace.flow_of(np.stack([-y, x, 0 * z], axis=-1), axis, axis, axis, backwards=True)
    found = march(back, [[0.5, 0.0, 0.0]], end=np.pi / 2, tolerance=1e-9)
    assert found.points[-1] == pytest.approx([0.0, -0.5, 0.0], abs=1e-6)


def test_no_row_lies_beyond_the_end_time() -> None:
    seeds = np.random.default_rng(2).uniform(2.0, 4.0, (40, 3))
    found = march(abc(33), seeds, interval=0.5, end=0.5)
    assert found.time.reshape(40, 2)[:, 1] == pytest.approx(0.5, abs=1e-12)


def test_a_map_and_uneven_axes() -> None:
    x, y = np.array([-1.0, -0.6, 0.1, 0.3, 1.0]), np.array([-1.0, 0.0, 0.7, 1.0])
    yy, xx = np.meshgrid(y, x, indexing="ij")
    flow = trace.flow_of(np.stack([-yy, xx, 9.0 + 0 * xx], axis=-1), x, y)
    found = march(flow, [[0.7, 0.0, 0.0]], end=2 * np.pi, tolerance=1e-9)
    assert found.points[-1] == pytest.approx([0.7, 0.0, 0.0], abs=1e-6)
    assert (found.points[:, 2] == 0).all()


@pytest.mark.parametrize("control", ["fixed", "cell", "curvature"])
@pytest.mark.parametrize("pair", FIXED)
def test_every_method_takes_every_control_it_can(control: Any, pair: str) -> None:
    found = march(rotation(), [[0.7, 0.0, 0.1]], pair, control=control, size=0.02, end=1.0, assess=True)
    assert REASONS[found.reason[0]] == "end time"
    true = np.hypot(*(found.points[-1, :2] - 0.7 * np.array([np.cos(1), np.sin(1)])))
    assert np.linalg.norm(found.error[-1]) == pytest.approx(true, rel=0.3, abs=1e-12)


def test_what_does_not_fit_is_refused() -> None:
    flow = rotation()
    for rules, word in (
        ({"pair": "RK5"}, "no method"), ({"pair": "Heun"}, "no error estimate"), ({"tolerance": 0.5}, "tolerance"),
        ({"control": "nag", "tolerance": 0.05}, "tolerance"), ({"control": "fixed"}, "size"), ({"steps": 0}, "step"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=word):
            trace.rules_of(flow, **rules)
    axis = np.arange(3.0)
    with pytest.raises(ValueError, match="fit"):
        trace.flow_of(np.zeros((3, 3, 2, 3)), axis, axis, axis)
    with pytest.raises(ValueError, match="ascend"):
        trace.flow_of(np.zeros((3, 3, 3, 3)), axis[::-1], axis, axis)


def test_answers_to_one_sample_are_its_differences() -> None:
    flow, seed = abc(), np.array([[2.0, 1.5, 3.0]])
    rules = trace.rules_of(flow, end=1.0, interval=0.5, tolerance=1e-12)
    base = trace.march(flow, seed, rules)
    found = trace_flow.answers(flow, seed, [base.time])
    node, c, step = int(found.sample[found.start[-2] :][5]), 1, 1e-5
    moved = []
    for sign in (1, -1):
        numbers = flow.numbers.copy()
        numbers[3 * node + c] += sign * step
        moved.append(trace.march(flow._replace(numbers=numbers), seed, rules).points)
    measured = (moved[0] - moved[1])[-1] / (2 * step)
    assert found.answer[found.start[-2] + 5, :, c] == pytest.approx(measured, rel=2e-3, abs=1e-6)
    near = trace.march(flow, seed + np.array([1e-6, 0, 0]), rules).points
    assert found.growth[-1, :, 0] == pytest.approx((near - base.points)[-1] / 1e-6, rel=1e-2, abs=1e-3)
