"""Adams and BDF on particles: against a rotation, over the faces of cells, and how they start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Geometry, Model, Progress
from modules.mappers.trace_multistep import trace_multistep
from modules.modellers.interpolate import interpolate
from modules.progress import Cancelled, Stop
from modules.readers.analytic import analytic


def model(formula: str, samples: tuple[int, ...] = (5, 5, 5)) -> Model:
    box: dict[str, Any] = {"low": (-1,) * len(samples), "high": (1,) * len(samples), "samples": samples}
    return interpolate(analytic(formula=formula, unit="m/s", lengths="m", noise=0.01, **box))


def start(*points: tuple[float, float, float]) -> Geometry:
    return Geometry(points=np.array(points), accuracy=EXACT)


@pytest.mark.parametrize(("method", "bar"), [("Adams", 30), ("BDF", 300)])
def test_a_rotation_is_followed_to_the_tolerance_and_its_error_told(method: Any, bar: float) -> None:
    spin = interpolate(analytic(formula="-y; x; 0.1 + 0*z", low=(-1, -1, -1), high=(1, 1, 1), samples=(5, 5, 5)))
    traces, ends = trace_multistep(spin, start((0.6, 0.1, -0.5)), Progress(), method=method, tolerance=1e-7, end_time=2.0)
    t = traces.values["time"].values
    assert t == pytest.approx(np.linspace(0, 2, 21))
    true = np.column_stack([0.6 * np.cos(t) - 0.1 * np.sin(t), 0.6 * np.sin(t) + 0.1 * np.cos(t), -0.5 + 0.1 * t])
    off = traces.points - true
    assert 0 < np.abs(off).max() < bar * 1e-7
    (told,) = traces.accuracy.select("position")
    assert told.error() == pytest.approx(off, abs=2e-8)
    assert ends.columns["largest"][0] == pytest.approx(np.linalg.norm(off, axis=1).max(), abs=2e-8)
    assert 0 < ends.columns["start-up error"][0] < ends.columns["largest"][0]
    assert {m.name for m in traces.accuracy.missing} >= {"Velocity residual"}


def test_it_ends_on_the_border_backwards_too_and_outside_it_does_not_begin() -> None:
    wind = model("1 + 0*x; 0.25 + 0*y; 0*z")
    seeds = start((-0.55, 0.1, 0.2), (3.0, 0.0, 0.0))
    _, ends = trace_multistep(wind, seeds, Progress(), end_time=5.0)
    assert ends.columns["reason"].tolist() == ["left the domain", "began outside"]
    assert ends.columns["x"][0] == pytest.approx(1.0, abs=0.05) and ends.columns["time"][0] == pytest.approx(1.55, abs=0.05)
    traces, ends = trace_multistep(wind, seeds, Progress(), end_time=5.0, direction="backward")
    assert ends.columns["x"][0] == pytest.approx(-1.0, abs=0.05) and traces.values["time"].values.min() < -0.4


def test_a_map_stays_flat_and_what_does_not_fit_is_refused() -> None:
    flat = model("-y; x", (9, 9))
    traces, _ = trace_multistep(flat, start((0.5, 0, 0)), Progress(), end_time=1.0)
    assert (traces.points[:, 2] == 0).all() and model("-y; x", (9, 9)).accuracy.terms
    assert flat.accuracy.terms[0].id in traces.accuracy.accounted()
    bent = interpolate(analytic(formula="-y; x; 0*z", low=(0, 0, 0), high=(1, 1, 1), samples=(4, 4, 4), grid="curvilinear"))
    with pytest.raises(ValueError, match="curvilinear"):
        trace_multistep(bent, start((0.5, 0.5, 0.5)), Progress())
    stop = Stop()
    stop.set()
    with pytest.raises(Cancelled):
        trace_multistep(flat, start((0.5, 0, 0)), Progress(stop=stop))
