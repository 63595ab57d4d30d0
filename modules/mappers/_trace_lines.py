"""Runs of particles as lines with what is known of them, and the table of how they end."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Accuracy, Cells, Field, Geometry, Model, Table
from modules.mappers import _trace_accuracy as known
from modules.mappers._trace_field import Medium
from modules.mappers._trace_run import Run, order, time_unit

Floats = NDArray[np.float64]

CROSSINGS = 2.0
"""Automatic end time: that of so many diagonals of the domain at the mean speed."""


def span(field: Medium, end_time: float | None) -> float:
    """The time to follow particles: as given, or automatic."""
    if end_time is not None:
        return end_time
    box, speed, _known, _boxes = kernels.trace_fields.measures(field.flow)
    return float(CROSSINGS * np.linalg.norm(box[3] - box[2]) / speed) if speed > 0 else 1.0


def drawn(model: Model, seeds: Geometry, runs: list[Run], how: known.Told) -> Geometry:
    """Lines, values and accuracy of all runs.

    Parameters
    ----------
    model, seeds : that were followed
    runs : one a direction
    how : what is told of all this
    """
    rows, offsets, seed = order(runs)
    sign = np.repeat([r.sign for r in runs], [len(r.traces.time) for r in runs])[rows]
    column = {
        name: np.concatenate([getattr(r.traces, name) for r in runs])[rows]
        for name in ("time", "points", "velocity", "residual", "local")
    }
    unit = model.grid.frame.length_unit(model.grid.dimensions)
    time, velocity = column["time"] * sign, column["velocity"] * sign[:, None]
    answers = [r.found for r in runs if r.found is not None]
    found = answers if len(answers) == len(runs) else None
    accuracy = Accuracy.join([
        (known.integration(how, np.concatenate([r.estimate for r in runs])[rows], unit), None),
        (known.tubes(how, [r.tube for r in runs], rows, unit), None),
        (known.residual(how, column["residual"] * sign[:, None], model.unit), None),
        (known.inherited(model, seeds, seed, found, rows, unit, how), None),
    ]).flag(*known.trusted(runs, time, seed, how))  # fmt: skip
    sizes = np.diff(offsets)
    long = np.flatnonzero(sizes > 1)
    lines = Cells(np.concatenate([[0], np.cumsum(sizes[long])]).astype(np.int64), np.flatnonzero(np.repeat(sizes > 1, sizes)))
    stretching = {}
    if found is not None:
        growth = np.concatenate([a.growth for a in found])[rows]
        stretching["stretching"] = Field(np.linalg.norm(growth, 2, axis=(1, 2)) if len(growth) else np.zeros(0), "point")
    return Geometry(
        points=column["points"],
        lines=lines,
        values={
            "time": Field(time, "point", time_unit(model.unit, unit)),
            "speed": Field(np.linalg.norm(velocity, axis=1), "point", model.unit),
            "velocity": Field(velocity, "point", model.unit),
            "local error": Field(np.linalg.norm(column["local"], axis=1), "point", unit),
            "seed": Field(long, "cell"),
            **stretching,
        },
        origin=long.astype(np.int64),
        cell=runs[0].medium.cell,
        frame=model.grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def ends(model: Model, seeds: Geometry, runs: list[Run]) -> Table:
    """How each trace ends: why, when and where, and what it took."""
    names: tuple[str, ...] = kernels.trace.REASONS
    columns: dict[str, list[NDArray[Any]]] = {}
    for run in runs:
        t = run.traces
        last = np.maximum(t.offsets[1:] - 1, 0)
        some = np.diff(t.offsets) > 0
        place = np.where(some[:, None], t.points[last] if len(t.points) else 0.0, seeds.points)
        time = np.where(some, t.time[last] if len(t.time) else 0.0, 0.0) * run.sign
        values = {
            "seed": np.arange(len(some)), "reason": np.array([names[k] for k in t.reason], dtype=np.str_), "time": time,
            "x": place[:, 0], "y": place[:, 1], "z": place[:, 2], "length": t.length, "steps": t.steps,
            "refused": t.refused, "evaluations": t.evaluations,
        }  # fmt: skip
        for name, value in values.items():
            columns.setdefault(name, []).append(value)
    unit = model.grid.frame.length_unit(model.grid.dimensions)
    return Table(
        columns={name: np.concatenate(parts) for name, parts in columns.items()},
        units={**dict.fromkeys(("x", "y", "z", "length"), unit), "time": time_unit(model.unit, unit)},
        name="ends",
        accuracy=known.elsewhere(model, seeds),
    )
