"""Two traces of the same particles compared at equal times: the thesis's synchroniser, for any second trace."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import Field, Flag, Geometry, Identity, Literal, Source, Term, mapper
from modules.mappers._trace_run import at_times

Floats = NDArray[np.float64]

RULE = "position at equal times less that of a second trace; Lopes 1999, (5.9) to (5.12) [synchroniser/1]"


@mapper("Compare traces", aliases=("synchroniser", "re-integration", "difference of models", "second trace"), output="traces")
def compare_traces(
    traces: Geometry,
    second: Geometry,
    *,
    meaning: Literal["integration", "model"] = "integration",
    name: str = "",
) -> Geometry:
    """The first traces, with how far they are from second ones of the same seeds as an error.

    The second traces may come from another method, tolerance, step rule, law of interpolation or data.

    Parameters
    ----------
    traces : whose points and times are kept
    second : traces of the same seeds; between their points a cubic through positions and velocities is taken
    meaning : what the second one differs in: its integration, or the model of the flow
    name : of the error; automatic: Difference of integration, or of models

    Raises
    ------
    ValueError : a geometry without times, velocities and seeds, as traces have them, or no seed in common

    Accuracy: a further signed term, estimated: by how much the second trace is off is not known. The terms of the first go on.
    Source: Lopes 1999, 5.2.4, re-integration and synchroniser (5.9) to (5.12); 5.4 asks for two modelling interpolators.
    """
    away = synchronised(traces, second)
    alone = np.isnan(away).any(axis=1)
    if alone.all():
        raise ValueError("no trace of the second geometry begins at a seed of the first: wire the same seeds to both")
    called = name or ("Difference of integration" if meaning == "integration" else "Difference of models")
    source = Source(called, "mapping" if meaning == "integration" else "model", "estimated", RULE)
    unit = traces.frame.length_unit(3 if np.ptp(traces.points[:, 2]) > 0 else 2)
    flat = np.nan_to_num(away, nan=0.0).ravel()
    accuracy = traces.accuracy.add(Term(source, "signed", "position", unit, flat, Identity(len(flat)), "point", 3))
    why = "only where the second traces are is used"
    accuracy = accuracy.end_from(second.accuracy, why)
    if alone.any():
        words = f"{int(alone.sum())} of {len(away)} points have no second trace to be compared with"
        accuracy = accuracy.flag(Flag("not compared", words, "point", np.flatnonzero(alone)))
    return replace(traces, accuracy=accuracy)


def synchronised(traces: Geometry, second: Geometry) -> Floats:
    """(n, 3) position of each point of traces less that of the second trace of its seed at its time; NaN without one.

    The samples of thesis (5.9) to (5.12): P keeps all its times, the exit among them; of the second trace only what falls on
    these is used.

    Raises
    ------
    ValueError : a geometry that has not the values of traces
    """
    for one in (traces, second):
        missing = {"time", "velocity", "seed"} - set(one.values)
        if missing:
            raise ValueError(f"these are no particle traces: {', '.join(sorted(missing))} of their points is not there")
    others = dict(zip(_values(second, "seed"), _rows(second), strict=True))
    away = np.full((len(traces.points), 3), np.nan)
    for seed, rows in zip(_values(traces, "seed"), _rows(traces), strict=True):
        there = others.get(seed)
        if there is not None:
            found = at_times(
                _values(traces, "time")[rows], _values(second, "time")[there], second.points[there],
                _values(second, "velocity")[there],
            )  # fmt: skip
            away[rows] = traces.points[rows] - found
    return away


def _values(geometry: Geometry, name: str) -> NDArray[Any]:
    field: Field = geometry.values[name]
    return np.asarray(field.values)


def _rows(geometry: Geometry) -> list[NDArray[np.int64]]:
    o, c = geometry.lines.offsets, geometry.lines.connectivity
    return [c[a:b] for a, b in pairwise(o)]
