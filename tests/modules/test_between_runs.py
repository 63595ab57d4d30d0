"""A run back from where traces end: it begins there, its clock is set, and what was carried forth comes back to nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Accuracy, Geometry, Identity, Progress, Source, Term
from modules.mappers.between_runs import between_runs
from modules.mappers.seeds import seeds
from modules.mappers.trace import trace
from modules.mappers.trace_ends import trace_ends
from modules.modellers.interpolate import interpolate
from modules.readers.analytic import analytic
from modules.readers.dataset import dataset

FILE = Path(__file__).resolve().parents[2] / "networks" / "data" / "double-glazing.vti"
BOX: dict[str, Any] = {"low": (0, 0, 0), "high": (6, 6, 6), "samples": (11, 11, 11)}


@pytest.fixture(scope="module")
def flow() -> Any:
    return interpolate(analytic(formula="1 + 0.3*sin(y); 0.3*cos(x); 0.1*sin(z)", **BOX))


def there_and_back(flow: Any, **rules: Any) -> tuple[Geometry, Geometry, Geometry]:
    start = seeds(flow, arrangement="line", first=(1, 2, 3), last=(1, 3, 2), count=3)
    rules = {"end_time": 2.0, "interval": 0.5, **rules}
    forth = trace(flow, start, Progress(), **rules).traces
    ends = trace_ends(forth)
    return forth, ends, trace(flow, ends, Progress(), direction="backward", **rules).traces


def test_figure_5_8_a_run_back_meets_the_trace_at_its_end_and_at_equal_times(flow: Any) -> None:
    forth, ends, back = there_and_back(flow, tolerance=1e-10)
    assert ends.points == pytest.approx(np.array([line[-1] for line in forth.polylines()]))
    assert ends.values["time"].values == pytest.approx(2.0)
    strip = between_runs(forth, back)
    assert strip.points[::2] == pytest.approx(forth.points)
    assert strip.points[1::2] == pytest.approx(forth.points, abs=1e-7)
    assert len(strip.polygons) == 3 * 4
    assert strip.values["distance"].values.max() < 1e-7
    rough = between_runs(*there_and_back(flow, pair="Euler", control="fixed", step=0.25, estimate="none")[::2])
    apart = rough.values["distance"].values.reshape(3, 5, 2)[..., 0]
    assert (np.diff(apart[:, ::-1], axis=1) > 0).all()  # nothing where it turns, most at the seed


def test_a_run_back_is_no_error_of_the_trace(flow: Any) -> None:
    forth, _, back = there_and_back(flow)
    strip = between_runs(forth, back)
    assert {t.id for t in strip.accuracy.terms} <= {t.id for t in (*forth.accuracy.terms, *back.accuracy.terms)}
    assert {t.id for t in (*forth.accuracy.terms, *back.accuracy.terms)} <= strip.accuracy.accounted()
    (mine,) = [t for t in forth.accuracy.select("position") if t.name == "Integration"]
    on = next(t for t in strip.accuracy.terms if t.id == mine.id).size()
    assert on[::2] == pytest.approx(mine.size()) or on[::2].max() > 0  # both runs are made by one rule: each has its edge


def test_what_the_model_adds_forth_it_takes_away_on_the_way_back() -> None:
    """x - x has no error: the same error of the model moves the particle forth and back again."""
    flow = interpolate(dataset(path=FILE, name="velocity", lengths="mm", unit="mm/s"))
    start = seeds(flow, arrangement="point", first=(3, 5, 6))
    rules: dict[str, Any] = {"end_time": 2.0, "interval": 0.5, "tolerance": 1e-9}
    forth = trace(flow, start, Progress(), **rules).traces
    back = trace(flow, trace_ends(forth), Progress(), direction="backward", **rules).traces
    for name in ("Interpolation between samples", "Quantisation"):
        out, home = (next(t.size() for t in g.accuracy.terms if t.name == name) for g in (forth, back))
        assert out[-1] == pytest.approx(home[-1])
        assert home[0] < 1e-4 * out.max()


def test_estimates_of_one_source_that_are_not_multiples_add_as_they_are() -> None:
    one, two = (
        Term(Source("Drift", "model", "estimated", "a rule"), "signed", "value", "", np.array(v), Identity(2), "point", 1, "d")
        for v in ([1.0, 2.0], [-1.0, 5.0])
    )
    (both,) = Accuracy.join([(Accuracy((one,)), None), (Accuracy((two,)), None)]).terms
    assert both.error() == pytest.approx([0.0, 7.0])


def test_runs_that_do_not_meet_are_refused(flow: Any) -> None:
    forth, _, back = there_and_back(flow)
    with pytest.raises(ValueError, match="Ends of traces"):
        between_runs(forth, back, meet="start")
    with pytest.raises(ValueError, match="no particle traces"):
        between_runs(forth, Geometry(points=np.zeros((1, 3)), accuracy=EXACT))
    with pytest.raises(ValueError, match="no times"):
        trace_ends(Geometry(points=np.zeros((1, 3)), accuracy=EXACT))
