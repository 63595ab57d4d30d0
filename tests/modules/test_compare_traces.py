"""The synchroniser: thesis (5.9) to (5.12), and the difference of any two traces as a term."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Geometry, Progress
from modules.mappers.compare_traces import compare_traces, synchronised
from modules.mappers.trace import trace
from modules.modellers.interpolate import interpolate
from modules.readers.analytic import analytic

BOX: dict[str, Any] = {"low": (0, 0, 0), "high": (6, 6, 6), "samples": (11, 11, 11)}
WAVE = "1 + 0.3*sin(y); 0.3*cos(x); 0.1*sin(z)"


def model(law: Any = "linear") -> Any:
    return interpolate(analytic(formula=WAVE, **BOX), law=law)


SEEDS = Geometry(points=np.array([[1.0, 2.0, 3.0], [2.0, 3.0, 2.0]]), accuracy=EXACT)


def traced(law: Any = "linear", **rules: Any) -> Any:
    return trace(model(law), SEEDS, Progress(), end_time=2.0, carry=False, **rules).traces


def error(geometry: Geometry, name: str) -> Any:
    (found,) = [t for t in geometry.accuracy.terms if t.name == name]
    return found.error()


def test_5_9_only_what_falls_on_the_times_of_the_first_is_used() -> None:
    """Q at each step of its own; P at its sampling times and its exit."""
    first, second = traced(interval=0.3, tolerance=1e-9), traced(tolerance=1e-9)
    away = synchronised(first, second)
    assert away.shape == first.points.shape
    assert np.abs(away).max() < 1e-4  # the cubic between the steps of the second
    assert np.abs(synchronised(first, first)).max() == 0.0


def test_the_difference_is_the_error_of_the_first_where_the_second_is_exact() -> None:
    exact = traced(interval=0.5, tolerance=1e-12)
    rough = traced(interval=0.5, pair="RK4", control="fixed", step=0.25)
    told = error(compare_traces(rough, exact), "Difference of integration")
    assert told == pytest.approx(rough.points - exact.points, abs=1e-14)
    half = error(rough, "Integration")
    late = np.linalg.norm(told, axis=1) > 1e-9
    assert np.median(np.linalg.norm(half, axis=1)[late] / np.linalg.norm(told, axis=1)[late]) == pytest.approx(1.0, abs=0.2)


def test_two_models_differ_as_the_first_says_it_is_off() -> None:
    linear, cubic = (traced(law, interval=1.0, tolerance=1e-9) for law in ("linear", "cubic"))
    found = compare_traces(linear, cubic, meaning="model")
    told = error(found, "Difference of models")
    assert found.accuracy.select("position")[-1].source.stage == "model"
    carried = error(trace(model(), SEEDS, Progress(), end_time=2.0, interval=1.0).traces, "Interpolation between samples")
    off = np.linalg.norm(told, axis=1) > 1e-6
    assert np.median(np.linalg.norm(told - carried, axis=1)[off] / np.linalg.norm(told, axis=1)[off]) < 0.5


def test_all_terms_go_on_and_what_has_no_second_is_flagged() -> None:
    first = traced(interval=0.5)
    alone = trace(model(), Geometry(points=SEEDS.points[:1], accuracy=EXACT), Progress(), end_time=2.0, interval=0.5).traces
    found = compare_traces(first, alone, name="Other pair")
    assert {t.id for t in first.accuracy.terms} <= {t.id for t in found.accuracy.terms}
    assert {t.id for t in alone.accuracy.terms} <= found.accuracy.accounted()
    (flag,) = [f for f in found.accuracy.flags if f.name == "not compared"]
    assert flag.count == len(first.points) // 2


def test_what_are_no_traces_is_refused() -> None:
    with pytest.raises(ValueError, match="no particle traces"):
        compare_traces(traced(), SEEDS)
    missed = Geometry(points=np.array([[9.0, 9.0, 9.0], [1.0, 1.0, 1.0]]), accuracy=EXACT)
    other = trace(model(), missed, Progress(), end_time=1.0, carry=False).traces
    with pytest.raises(ValueError, match="same seeds"):
        only = Geometry(points=SEEDS.points[:1], accuracy=EXACT)
        compare_traces(trace(model(), only, Progress(), end_time=1.0).traces, other)
