"""Path-, streak- and timelines, against closed forms and each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Geometry, Model, Progress
from modules.mappers.trace import trace
from modules.mappers.unsteady import unsteady
from modules.modellers.interpolate import interpolate
from modules.readers.analytic import analytic


def series(formula: str, times: Any) -> list[Model]:
    box: dict[str, Any] = {"low": (-4, -4, -4), "high": (4, 4, 4), "samples": (9, 9, 9)}
    return [interpolate(analytic(formula=formula, time=float(t), **box)) for t in times]


def at(*points: tuple[float, float, float]) -> Geometry:
    return Geometry(points=np.array(points, float), accuracy=EXACT)


def test_a_pathline_in_a_flow_that_turns() -> None:
    """dx/dt = t, dy/dt = 1: linear in time, so a parabola, exactly."""
    flow = series("t + 0*x; 1 + 0*y; 0*z", [2, 0, 1])
    lines = unsteady(flow, at((-1, -1, 0)), Progress(), interval=0.25)
    t = lines.values["time"].values
    assert t == pytest.approx(np.arange(0, 2.1, 0.25))
    assert lines.points == pytest.approx(np.column_stack([-1 + t**2 / 2, -1 + t, 0 * t]), abs=1e-10)


def test_a_streakline_joins_what_passed_the_seed() -> None:
    flow = series("t + 0*x; 1 + 0*y; 0*z", [0, 1, 2])
    lines = unsteady(flow, at((-1, -1, 0)), Progress(), kind="streaklines", interval=0.25)
    r = lines.values["release"].values
    assert r == pytest.approx(np.arange(1.75, -0.1, -0.25))
    assert lines.points == pytest.approx(np.column_stack([-1 + (4 - r**2) / 2, 1 - r, 0 * r]), abs=1e-10)
    assert (lines.values["time"].values == 2).all()


def test_a_timeline_joins_what_was_released_at_once() -> None:
    flow = series("t*y; 0*y; 0*z", [0, 1, 2])
    seeds = at(*[(0, y, 0) for y in (-1, -0.5, 0.5, 1)])
    lines = unsteady(flow, seeds, Progress(), kind="timelines", interval=1.0)
    assert [len(p) for p in lines.polylines()] == [4, 4, 4]
    for k, line in enumerate(lines.polylines()):
        assert line == pytest.approx(seeds.points + np.outer(seeds.points[:, 1] * k**2 / 2, [1, 0, 0]), abs=1e-10)


def test_in_a_steady_flow_all_lie_on_the_streamline() -> None:
    """Thesis 2.5.2. The three agree within what they state, and lie on the trace of the one model."""
    flow, seed = series("-y + 0*t; x; 0.1 + 0*z", [0, 1.5, 3]), at((1, 0, 0))
    rules: dict[str, Any] = {"interval": 0.25, "tolerance": 1e-9, "carry": False}
    paths = unsteady(flow, seed, Progress(), **rules)
    streaks = unsteady(flow, seed, Progress(), kind="streaklines", **rules)
    line = trace(flow[0], seed, Progress(), end_time=3.0, **rules).traces
    assert paths.points == pytest.approx(line.points, abs=1e-7)
    assert streaks.points == pytest.approx(line.points[1:], abs=1e-7)


def test_the_stated_error_is_the_error() -> None:
    flow, seed = series("-y*(1 + t); x*(1 + t); 0*z", [0, 1, 2]), at((1, 0, 0), (0, 2, 1))
    fine, coarse = (unsteady(flow, seed, Progress(), interval=0.5, tolerance=t, carry=False) for t in (1e-12, 1e-5))
    angle = fine.values["time"].values + fine.values["time"].values ** 2 / 2
    assert np.hypot(*fine.points[:5, :2].T) == pytest.approx(1.0, abs=1e-9)
    assert fine.points[:5, 0] == pytest.approx(np.cos(angle[:5]), abs=1e-9)
    (stated,) = [t for t in coarse.accuracy.select("position") if t.name == "Integration"]
    off = coarse.points - fine.points
    late = np.linalg.norm(off, axis=1) > 1e-9
    assert np.median(stated.size()[late] / np.linalg.norm(off, axis=1)[late]) == pytest.approx(1.0, abs=0.15)
    plain = unsteady(flow, seed, Progress(), interval=0.5, carry=False)
    assert {m.name for m in plain.accuracy.missing} >= {"Errors of data and model", "Between two times"}
    two = unsteady(flow[:2], seed, Progress(), interval=0.5, carry=True)
    assert {m.name for m in two.accuracy.missing} >= {"Between two times"}


@pytest.mark.parametrize("kind", ["pathlines", "timelines", "streaklines"])
def test_the_error_of_the_line_between_two_times_is_told_with_its_sign(kind: Any) -> None:
    formula, seed = "t*t + 0*x; 1 + 0*y; 0*z", at((-1, -1, 0), (-1, 0, 0))
    lines = unsteady(series(formula, [0, 1, 2]), seed, Progress(), kind=kind, interval=0.5, carry=True)
    (told,) = [t for t in lines.accuracy.select("position") if t.name == "Between two times"]
    t, r = lines.values["time"].values, lines.values["release"].values
    off = lines.points[:, 0] - (-1 + (t**3 - r**3) / 3)
    assert np.abs(off).max() > 0.1
    assert told.error()[:, 0] == pytest.approx(off, abs=1e-9)


@pytest.mark.parametrize("kind", ["pathlines", "timelines", "streaklines"])
def test_noise_of_each_time_is_carried(kind: Any) -> None:
    sigma, seed, random = 0.02, at((1, 0.2, 0.1), (0, 1.3, 0.2)), np.random.default_rng(0)
    box: dict[str, Any] = {"low": (-4, -4, -4), "high": (4, 4, 4), "samples": (6, 6, 6)}
    box["formula"] = "-y*(1 + t); x; 0.1*t + 0*z"
    noisy = [interpolate(analytic(time=float(t), noise=sigma, seed=t, **box)) for t in (0, 1, 2)]
    rules: dict[str, Any] = {"kind": kind, "interval": 1.0}
    lines = unsteady(noisy, seed, Progress(), carry=True, **rules)
    terms = [t for t in lines.accuracy.select("position") if t.name == "Added noise"]
    assert len(terms) == 3
    stated = np.sqrt(sum(t.error() ** 2 for t in terms))
    clean, runs = [analytic(time=float(t), **box) for t in (0, 1, 2)], []
    for _ in range(40):
        drawn = [
            Model.between(replace(s, values=s.values + sigma * random.standard_normal(s.values.shape), accuracy=EXACT))
            for s in clean
        ]
        runs.append(unsteady(drawn, seed, Progress(), **rules).points)
    spread = np.std(runs, axis=0, ddof=1)
    late = spread > 1e-6
    assert late.sum() >= 6
    assert np.median(stated[late] / spread[late]) == pytest.approx(1.0, abs=0.2)


def test_lines_break_where_particles_have_left() -> None:
    flow = series("y; 0*y; 0*z", [0, 1, 2])
    seeds = at((3, 1, 0), (3, 0.1, 0), (3, 0.2, 0), (3, 3, 0), (3, 0.0, 0), (3, 0.1, 1))
    lines = unsteady(flow, seeds, Progress(), kind="timelines", interval=1.0)
    assert [len(p) for p in lines.polylines()] == [6, 3, 2, 2, 2]


def test_what_does_not_fit_is_refused() -> None:
    flow, seed = series("1 + 0*x; 0*y; 0*z", [0, 1]), at((0, 0, 0))
    timeless = interpolate(analytic(formula="1 + 0*x; 0*y; 0*z", low=(-4, -4, -4), high=(4, 4, 4), samples=(9, 9, 9)))
    for models, words, rules in (
        (flow[:1], "two times at least", {}), ([*flow, timeless], "no time", {}), ([flow[0], flow[0]], "same time", {}),
        (flow, "within the series", {"until": 5.0}), (flow, "instants", {"interval": 1e-9}),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=words):
            unsteady(models, seed, Progress(), **rules)  # type: ignore[arg-type]  # rules of all kinds
    other = interpolate(analytic(formula="1 + 0*x; 0*y; 0*z", low=(-1, -1, -1), high=(1, 1, 1), samples=(5, 5, 5), time=2.0))
    with pytest.raises(ValueError, match="one grid"):
        unsteady([*flow, other], seed, Progress())
