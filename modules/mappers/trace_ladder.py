"""Traces at one tolerance after the other: what each rung is off by, and what it costs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Geometry,
    Literal,
    Missing,
    Model,
    NamedTuple,
    Progress,
    Range,
    Source,
    Table,
    exactly,
    mapper,
)
from modules.mappers import _trace_accuracy as known
from modules.mappers._trace_field import medium
from modules.mappers._trace_lines import drawn, span
from modules.mappers._trace_run import Run, against, follow

Floats = NDArray[np.float64]

FINEST = 10 * float(np.finfo(float).eps)
"""No local error can be kept below this part of the domain."""

DOWN = 10.0
"""The tolerance of a rung over that of the next."""


class Climbed(NamedTuple):
    """The traces of the first rung, and the curve of error against cost."""

    traces: Geometry
    curve: Table


@mapper("Ladder of tolerances", aliases=("re-integration", "convergence", "error against cost", "work precision"))
def trace_ladder(
    model: Model,
    seeds: Geometry,
    progress: Progress,
    *,
    pair: Literal["Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)"] = "Dormand-Prince 5(4)",
    control: Literal["extent", "nag"] = "extent",
    tolerance: Annotated[float, Range(1e-12, 1e-2, log=True)] = 1e-3,
    rungs: Annotated[int, Range(2, 8)] = 4,
    direction: Literal["forward", "backward"] = "forward",
    end_time: Annotated[float | None, Range(low=0)] = None,
    instants: Annotated[int, Range(2, 10_000, log=True)] = 20,
    restarts: bool = True,
) -> Climbed:
    """The same particles followed at a tolerance, a tenth, a hundredth of it and so on: thesis's re-integration in full.

    Each rung is compared with the finest at equal times. With restarts the finest takes every crossing of a cell in two steps
    at least, for rungs whose steps are all held up by faces take the same steps, and say nothing of each other.

    Parameters
    ----------
    model : velocity, as 'Particle traces' takes it
    seeds : where particles begin
    pair : Runge-Kutta method
    control : what the tolerance is a part of: the extent of the domain, or the coordinate as in thesis (5.3) to (5.7)
    tolerance : of the first rung
    rungs : how many, the finest among them
    direction : forward or backward
    end_time : time to follow each particle; automatic: that of two diagonals of the domain at the mean speed
    instants : equal times at which the rungs are compared
    restarts : steps end on the faces of cells

    Raises
    ------
    ValueError : the model is not a velocity on such a grid, or a rung is finer than the machine can tell

    Values of the curve, a row a rung but for the finest: `evaluations` of the velocity a particle, `tolerance`, `median` and
    `largest` distance from the finest, `steps` and `refused` a particle. Those of the traces: `time`, `speed`, `velocity`.

    Accuracy: the distance of the first rung from the finest, as an estimate of its error; that of the finest is not in it. The
        curve states sizes of errors and has none of its own.
    Source: Lopes 1999, 5.2.4 and figure 5.6.
    """
    finest = tolerance / DOWN ** (rungs - 1)
    if finest < FINEST:
        raise ValueError(f"the last rung would have tolerance {finest:.0e}, finer than the machine can tell: fewer rungs")
    sign = 1 if direction == "forward" else -1
    field = medium([model], sign, seeds.points)
    end = span(field, end_time)
    rules: dict[str, Any] = {"control": control, "end": end, "interval": end / instants, "faces": restarts}
    runs = [
        follow(
            field, sign, pair, {**rules, "tolerance": tolerance / DOWN**k, "halve": restarts and k == rungs - 1},
            progress.part(k / rungs, (k + 1) / rungs),
        )
        for k in range(rungs)
    ]  # fmt: skip
    away = [against(run.traces, runs[-1].traces) for run in runs[:-1]]
    halved = ", and with twice the steps in a cell" if restarts else ""
    rule = f"the same particles at {finest:g}, {rungs - 1} rungs finer{halved}; Lopes 1999, 5.2.4 [ladder/1]"
    how = known.Told(Source("Integration", "mapping", "estimated", rule), why_not="brought along by 'Particle traces'")
    return Climbed(
        drawn(model, seeds, [replace(runs[0], error=away[0])], how), _curve(model, seeds, runs, away, tolerance),
    )  # fmt: skip


def _curve(model: Model, seeds: Geometry, runs: list[Run], away: list[Floats], tolerance: float) -> Table:
    """A row for each rung but the finest, which has nothing to be compared with."""
    apart = [np.linalg.norm(a, axis=1) for a in away]
    worst = [[d[a:b].max() for a, b in pairwise(r.traces.offsets) if b > a] for d, r in zip(apart, runs, strict=False)]
    columns = {
        "evaluations": [r.traces.evaluations.mean() for r in runs[:-1]],
        "largest": [max(w, default=np.nan) for w in worst],
        "median": [np.median(w) if w else np.nan for w in worst],
        "tolerance": [tolerance / DOWN**k for k in range(len(away))],
        "steps": [r.traces.steps.mean() for r in runs[:-1]],
        "refused": [r.traces.refused.mean() for r in runs[:-1]],
    }
    unit = model.grid.frame.length_unit(model.grid.dimensions)
    why = "the curve states sizes of errors of integration; what else traces are off by is on their wire"
    counted = exactly("Count", "mapping", len(away), quantity="evaluations", rule="evaluations are counted [count/1]")
    told = Accuracy((counted,), (Missing("Accuracy of the curve", "that of the finest rung, whose own error is not in it"),))
    return Table(
        columns={name: np.array(values, float) for name, values in columns.items()},
        units={"largest": unit, "median": unit},
        name="ladder",
        accuracy=replace(told.end_from(model.accuracy, why).end_from(seeds.accuracy, why), missing=told.missing),
    )
