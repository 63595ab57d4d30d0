"""Chapter 5 of the thesis: what it defines, and what it saw, number by number."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from modules.api import Model, Progress
from modules.kernels import trace as kernel
from modules.kernels.runge_kutta import PAIRS
from modules.mappers.seeds import seeds
from modules.mappers.trace import trace
from modules.modellers.interpolate import interpolate
from modules.readers.analytic import analytic

CLOSED_BOX = (
    "0.5*sin(3.14159265*x/2)*cos(3.14159265*y); -0.25*cos(3.14159265*x/2)*sin(3.14159265*y); "
    "0.05*sin(3.14159265*z)*cos(3.14159265*x/2)"
)


def gap(low: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Model:
    """A circulation in a box of the thesis's 18 x 10 x 10 nodes, the walls of which nothing crosses."""
    shift = [f"({name} - {value})" for name, value in zip("xyz", low, strict=True)]
    formula = CLOSED_BOX
    for name, moved in zip("xyz", shift, strict=True):
        formula = formula.replace(f"*{name}", f"*{moved}")
    high = tuple(a + b for a, b in zip(low, (2.0, 1.0, 1.0), strict=True))
    return interpolate(analytic(formula=formula, low=low, high=high, samples=(18, 10, 10)))


def one(model: Model, **rules: Any) -> Any:
    corner = model.grid.bounds[::2]
    first = tuple(a + b for a, b in zip(corner, (0.5, 0.3, 0.4), strict=True))
    start = seeds(model, arrangement="point", first=first)
    return trace(model, start, Progress(), carry=False, end_time=6.0, interval=0.25, **rules)


def sizes(traces: Any, name: str = "Integration") -> Any:
    (found,) = [t for t in traces.accuracy.terms if t.name == name]
    return found.size()


def test_table_5_1_second_order_is_heun_and_midpoint() -> None:
    """As printed, V(p + p*), the formula is no method; with (V(p) + V(p*)) / 2 it is Heun's."""
    heun, midpoint = PAIRS["Heun"], PAIRS["midpoint"]
    assert heun.result[:2].tolist() == [0.5, 0.5] and heun.stages[1, 0] == 1.0
    assert midpoint.result[:2].tolist() == [0.0, 1.0] and midpoint.stages[1, 0] == 0.5
    assert PAIRS["RK4"].result[:4] == pytest.approx(np.array([1, 2, 2, 1]) / 6)
    assert [PAIRS[p].order + 1 for p in ("Euler", "Heun", "RK4")] == [2, 3, 5]


def test_5_4_the_threshold_is_none_where_a_boundary_is_at_0() -> None:
    """Then the weight is the coordinate alone, and the accuracy depends on where the origin is; ours does not."""
    there = (100.0, 100.0, 100.0)
    away: dict[str, float] = {}
    for control in ("nag", "extent"):
        rules: dict[str, Any] = {"control": control, "tolerance": 1e-3, "restarts": False}
        here, moved = (one(gap(low), **rules).traces.points for low in ((0.0,) * 3, there))
        away[control] = float(np.abs(here + there - moved)[:10].max())
    assert away["extent"] < 1e-6
    assert away["nag"] > 1e3 * away["extent"]


def test_5_6_the_range_of_the_tolerance() -> None:
    flow = kernel.flow_of(np.zeros((2, 2, 2, 3)), *[np.arange(2.0)] * 3)
    for tolerance in (1e-15, 0.011):
        with pytest.raises(ValueError, match="tolerance"):
            kernel.rules_of(flow, control="nag", tolerance=tolerance)


def test_5_8_the_residual_is_a_velocity_and_vanishes_at_the_ends_of_steps() -> None:
    traces = one(gap(), tolerance=1e-3).traces
    (term,) = traces.accuracy.select("velocity")
    assert term.components == 3 and term.size().max() > 0
    every_step = one(gap(), tolerance=1e-3)[0]
    assert every_step.accuracy.select("velocity")[0].size()[0] == 0


def test_5_9_equal_times_and_the_last_position_always() -> None:
    model = interpolate(analytic(formula="1;0.2;0", low=(0, 0, 0), high=(2, 1, 1), samples=(18, 10, 10)))
    start = seeds(model, arrangement="point", first=(0.1, 0.1, 0.5))
    traces, ends = trace(model, start, Progress(), interval=0.5)
    assert traces.values["time"].values == pytest.approx([0, 0.5, 1.0, 1.5, 1.9])
    assert traces.points[-1] == pytest.approx([2.0, 0.48, 0.5])
    assert ends.columns["reason"].tolist() == ["left the domain"]


def test_figure_5_6_the_first_re_integration_tells_most() -> None:
    """RK 2(3) at 0.008 with four re-integrations, each with a tenth of the tolerance, without restarts as it was."""
    runs = [
        one(gap(), pair="Bogacki-Shampine 3(2)", control="nag", tolerance=0.008 / 10**k, restarts=False).traces.points
        for k in range(5)
    ]
    apart = [float(np.linalg.norm(a - b, axis=1).max()) for a, b in pairwise(runs)]
    assert apart[0] > 3 * max(apart[1:])


def test_figure_5_10_why_the_estimate_ended_and_that_restarts_cure_it() -> None:
    """The half steps of RKSUITE are refused over faces at a tolerance that they credit between faces."""
    model = gap()
    start = seeds(model, arrangement="plane", count=4)
    rules: dict[str, Any] = {"end_time": 8.0, "interval": 0.25, "carry": False, "tolerance": 1e-6}
    without = trace(model, start, Progress(), restarts=False, **rules).traces
    cured = trace(model, start, Progress(), **rules).traces
    lost = [sum(f.count for f in t.accuracy.flags) / len(t.points) for t in (without, cured)]
    assert lost[0] > 0.3 and lost[1] < 0.02


def test_5_2_4_re_integration_agrees_with_half_steps_where_it_halves_too() -> None:
    model = gap()
    half, again = (one(model, tolerance=1e-3, estimate=e).traces for e in ("half steps", "re-integration"))
    late = sizes(half) > 1e-9
    assert np.median(sizes(again)[late] / sizes(half)[late]) == pytest.approx(1.0, abs=0.15)
