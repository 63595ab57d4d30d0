"""Traces in an unsteady flow: pathlines, streaklines and timelines, from a series of models."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Geometry,
    Identity,
    Literal,
    Missing,
    Model,
    Progress,
    Range,
    Term,
    mapper,
)
from modules.mappers._trace_accuracy import HALF_STEPS
from modules.mappers._trace_field import Medium, medium
from modules.mappers._trace_run import follow, time_unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST = 10_000
"""More releases or instants than this are refused: an interval in the wrong unit."""


@mapper(
    "Unsteady traces",
    version=2,
    aliases=("pathlines", "streaklines", "timelines", "time series", "advect"),
    output="traces",
)
def unsteady(
    series: list[Model],
    seeds: Geometry,
    progress: Progress,
    *,
    kind: Literal["pathlines", "streaklines", "timelines"] = "pathlines",
    release: float | None = None,
    until: float | None = None,
    interval: Annotated[float | None, Range(low=0)] = None,
    pair: Literal["Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)"] = "Dormand-Prince 5(4)",
    tolerance: Annotated[float, Range(1e-12, 1e-2, log=True)] = 1e-6,
    steps: Annotated[int, Range(1, 1_000_000, log=True)] = 20_000,
    restarts: bool = True,
) -> Geometry:
    """Where particles go in a flow that changes with time.

    A pathline is the path of one particle. A streakline joins, at one instant, the particles that have passed a seed. A
    timeline joins the particles of all seeds that were released at one instant, at later instants. In a steady flow path-
    and streaklines lie on the streamline.

    Parameters
    ----------
    series : models of velocity at two or more times, in any order, on one grid; linear in time between them
    seeds : where particles begin; a timeline joins them in their order
    kind : pathlines, streaklines or timelines
    release : time at which particles begin, of streaklines the first; automatic: the first time of the series
    until : time at which pathlines end, streaklines are seen, timelines are last seen; automatic: the last of the series
    interval : time between points of a pathline, releases of a streakline, timelines; automatic: a 20th of the whole
    pair : Runge-Kutta method
    tolerance : largest local error of a step, as a part of the extent of the domain
    steps : at most so many for each particle
    restarts : steps end on the faces of cells, where the linear model has a kink

    Values: `time` and `release` of each point; on lines `seed`, of timelines `instant`.

    Raises
    ------
    ValueError : fewer than two models, one without a time, equal times, several grids, or times outside the series

    Accuracy: the integration's error is estimated at each point, by two half steps. Errors of samples, of the models between
        samples and of the line between two times are not brought along: they are missing.
    Source: Lopes 1999, 2.5.2 (definitions), 5.1.3 (interpolation in time before that in space).
    """
    models = _in_order(series)
    begin, end, interval = _times(models, release, until, interval)
    field = medium(models, 1, seeds.points)
    rules: dict[str, Any] = {"tolerance": tolerance, "steps": steps, "faces": restarts, "assess": True}
    make = {"pathlines": _paths, "streaklines": _streaks, "timelines": _timelines}[kind]
    found = make(field, pair, rules, (begin, end, interval), progress)
    return _drawn(models[0], models, seeds, found, kind)


class _Lines:
    """Lines so far: points with time, release, error; lists of rows; and what each line stands for."""

    def __init__(self) -> None:
        self.points: list[Floats] = []
        self.times: list[Floats] = []
        self.releases: list[Floats] = []
        self.errors: list[Floats] = []
        self.lines: list[Ints] = []
        self.of: list[int] = []
        self.count = 0

    def add(self, points: Floats, times: Floats, releases: Floats, errors: Floats, of: int) -> None:
        """A line through points."""
        if len(points) < 2:
            return
        for mine, new in ((self.points, points), (self.times, times), (self.releases, releases), (self.errors, errors)):
            mine.append(new)
        self.lines.append(self.count + np.arange(len(points)))
        self.of.append(of)
        self.count += len(points)


def _in_order(series: list[Model]) -> list[Model]:
    if len(series) < 2:
        raise ValueError("a series needs models of two times at least: for one model use particle traces")
    if any(m.samples.time is None for m in series):
        raise ValueError("a model of the series has no time: state the time of its samples")
    models = sorted(series, key=lambda m: float(m.samples.time or 0.0))
    times = [m.samples.time for m in models]
    if len(set(times)) < len(times):
        raise ValueError("two models of the series have the same time")
    return models


def _times(
    models: list[Model], release: float | None, until: float | None, interval: float | None
) -> tuple[float, float, float]:
    """Begin, end and interval, within the series."""
    first, last = float(models[0].samples.time or 0.0), float(models[-1].samples.time or 0.0)
    begin, end = (first if release is None else release), (last if until is None else until)
    if not first <= begin < end <= last:
        raise ValueError(f"release {begin:g} and until {end:g} must lie in this order within the series, {first:g} to {last:g}")
    every = interval or (end - begin) / 20
    if (end - begin) / every > MOST:
        raise ValueError(f"an interval of {every:g} makes more than {MOST} instants: take a longer one")
    return begin, end, every


def _paths(field: Medium, pair: str, rules: dict[str, Any], times: tuple[float, float, float], progress: Progress) -> _Lines:
    begin, end, interval = times
    traces = follow(field, 1, pair, {**rules, "end": end - begin, "interval": interval}, progress, begin).traces
    lines = _Lines()
    for i in range(len(traces.offsets) - 1):
        some = slice(*traces.offsets[i : i + 2])
        time = begin + traces.time[some]
        lines.add(traces.points[some], time, np.full(len(time), begin), traces.error[some], i)
    return lines


def _instants(begin: float, end: float, interval: float) -> Floats:
    return np.asarray(begin + interval * np.arange(int((end - begin) / interval * (1 + 1e-12)) + 1), np.float64)


def _streaks(field: Medium, pair: str, rules: dict[str, Any], times: tuple[float, float, float], progress: Progress) -> _Lines:
    """The particles of each seed at the end, from the one released last; where some have left, the line is in pieces."""
    begin, end, interval = times
    releases = [t for t in _instants(begin, end, interval)[::-1] if end - t > 1e-12 * (end - begin)]
    p = len(field.seeds)
    at, errors = np.full((p, len(releases), 3), np.nan), np.zeros((p, len(releases), 3))
    there = np.zeros((p, len(releases)), bool)
    for k, since in enumerate(releases):
        span = end - since
        part = progress.part(k / len(releases), (k + 1) / len(releases))
        traces = follow(field, 1, pair, {**rules, "end": span, "interval": span}, part, since).traces
        last = traces.offsets[1:] - 1
        there[:, k] = (np.diff(traces.offsets) > 1) & (np.abs(traces.time[np.maximum(last, 0)] - span) <= 1e-9 * span)
        at[there[:, k], k], errors[there[:, k], k] = traces.points[last[there[:, k]]], traces.error[last[there[:, k]]]
    lines = _Lines()
    since = np.array(releases)
    for i in range(p):
        for piece in np.split(np.arange(len(releases)), np.flatnonzero(~there[i])):
            kept = piece[there[i, piece]]
            lines.add(at[i, kept], np.full(len(kept), end), since[kept], errors[i, kept], i)
    return lines


def _timelines(
    field: Medium, pair: str, rules: dict[str, Any], times: tuple[float, float, float], progress: Progress
) -> _Lines:
    """All particles at each instant, in the order of the seeds; where some have left, the line is in pieces."""
    begin, end, interval = times
    traces = follow(field, 1, pair, {**rules, "end": end - begin, "interval": interval}, progress, begin).traces
    lines, owner = _Lines(), np.repeat(np.arange(len(field.seeds)), np.diff(traces.offsets))
    for k, instant in enumerate(_instants(begin, end, interval)):
        rows = np.flatnonzero(np.abs(traces.time - (instant - begin)) <= 1e-9 * (end - begin))
        for piece in np.split(rows, np.flatnonzero(np.diff(owner[rows]) > 1) + 1):
            n = len(piece)
            lines.add(traces.points[piece], np.full(n, instant), np.full(n, begin), traces.error[piece], k)
    return lines


def _drawn(model: Model, series: list[Model], seeds: Geometry, found: _Lines, kind: str) -> Geometry:
    unit = model.grid.frame.length_unit(model.grid.dimensions)
    points = np.concatenate([np.zeros((0, 3)), *found.points])
    error = np.concatenate([np.zeros((0, 3)), *found.errors]).ravel()
    why = "errors of samples, models and seeds are not brought along traces in an unsteady flow"
    accuracy = Accuracy((Term(HALF_STEPS, "signed", "position", unit, error, Identity(len(error)), "point", 3),)).miss(
        Missing("Errors of data and model", why),
        Missing("Between two times", "the flow is taken as linear between the times of the series"),
    )
    for other in (*(m.accuracy for m in series), seeds.accuracy):
        accuracy = accuracy.end_from(other, why)
    clock = time_unit(model.unit, unit)
    times, releases = (np.concatenate([np.zeros(0), *values]) for values in (found.times, found.releases))
    return Geometry(
        points=points,
        lines=Cells.of([list(line) for line in found.lines]),
        values={
            "time": Field(times, "point", clock),
            "release": Field(releases, "point", clock),
            "instant" if kind == "timelines" else "seed": Field(np.array(found.of, np.int64), "cell"),
        },
        frame=model.grid.frame,
        name=kind,
        time=None if kind == "pathlines" else float(times.max(initial=0.0)),
        accuracy=accuracy,
    )
