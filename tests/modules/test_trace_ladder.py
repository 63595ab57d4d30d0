"""The ladder of tolerances: each rung against the finest, and what it costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from modules.api import Geometry, Model, Progress
from modules.mappers.seeds import seeds
from modules.mappers.trace import trace
from modules.mappers.trace_ladder import trace_ladder
from modules.modellers.interpolate import interpolate
from modules.progress import Cancelled, Stop
from modules.readers.analytic import analytic

ABC = "1.7320508*sin(z)+cos(y);1.4142136*sin(x)+1.7320508*cos(z);sin(y)+1.4142136*cos(x)"


def abc() -> tuple[Model, Geometry]:
    box: dict[str, Any] = {"low": (0, 0, 0), "high": (2 * np.pi,) * 3, "samples": (11, 11, 11)}
    model = interpolate(analytic(formula=ABC, unit="m/s", lengths="m", noise=0.01, **box))
    return model, seeds(model, arrangement="random", count=20, first=(2, 2, 2), last=(4, 4, 4))


@pytest.mark.parametrize("restarts", [True, False])
def test_each_rung_costs_more_and_is_off_by_less(restarts: bool) -> None:
    model, start = abc()
    tolerance = 1e-5 if restarts else 1e-3
    traces, curve = trace_ladder(model, start, Progress(), tolerance=tolerance, rungs=4, end_time=1.0, restarts=restarts)
    assert curve.columns["tolerance"] == pytest.approx(tolerance / np.array([1, 10, 100]))
    assert (np.diff(curve.columns["evaluations"]) > 0).all()
    assert (np.diff(curve.columns["largest"]) < 0).all() and (curve.columns["median"] <= curve.columns["largest"]).all()
    assert curve.units["largest"] == "m"
    exact = trace(
        model, start, Progress(), tolerance=1e-12, end_time=1.0, interval=0.05, carry=False, estimate="none"
    ).traces
    (told,) = traces.accuracy.select("position")
    true = traces.points - exact.points
    late = np.linalg.norm(true, axis=1) > 0.1 * np.linalg.norm(true, axis=1).max()
    assert np.median(told.size()[late] / np.linalg.norm(true, axis=1)[late]) == pytest.approx(1.0, abs=0.1)
    assert curve.columns["largest"][0] == pytest.approx(told.size().max())
    assert model.accuracy.terms[0].id in traces.accuracy.accounted() & curve.accuracy.accounted()


def test_with_restarts_a_rung_held_up_by_faces_still_says_something() -> None:
    """All rungs take the same steps there but for the finest, which halves them."""
    model, start = abc()
    curve = trace_ladder(model, start, Progress(), tolerance=1e-2, rungs=3, end_time=0.5).curve
    assert (curve.columns["median"] > 0).all()


def test_what_no_machine_can_tell_is_refused_and_work_can_be_cancelled() -> None:
    model, start = abc()
    with pytest.raises(ValueError, match="fewer rungs"):
        trace_ladder(model, start, Progress(), tolerance=1e-10, rungs=8)
    stop = Stop()
    stop.set()
    with pytest.raises(Cancelled):
        trace_ladder(model, start, Progress(stop=stop))
