"""Traces in an unsteady flow: pathlines, streaklines and timelines, from a series of models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Gather,
    Geometry,
    Identity,
    Literal,
    Matrix,
    Missing,
    Model,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    mapper,
)
from modules.mappers._trace_accuracy import HALF_STEPS
from modules.mappers._trace_answers import summed, unsteady_pieces
from modules.mappers._trace_field import medium
from modules.mappers._trace_proof import with_steps
from modules.mappers._trace_run import follow, time_unit

if TYPE_CHECKING:
    from modules.kernels.trace import Traces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Found = tuple[csr_array, Floats, Floats]
"""Answers to the samples of all models; displacements by the errors of laws and times; growth."""

BETWEEN = Source(
    "Between two times", "model", "estimated",
    "half of u (1 - u) times the square of the step times the second difference in time, carried [linear-in-time/1]",
)  # fmt: skip

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
    carry: bool = False,
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
    carry : errors of samples, models and seeds, and of the line between two times, are brought along, which takes far longer
        than the traces: for some tens of particles

    Values: `time` and `release` of each point; on lines `seed`, of timelines `instant`.

    Raises
    ------
    ValueError : fewer than two models, one without a time, equal times, several grids, or times outside the series

    Accuracy: the integration's error is estimated at each point, by parts of the steps. Errors of samples, of the models
        between samples and of the line between two times (by second differences of three) are carried to first order
        through linear models in boxes; elsewhere they are missing.
    Source: Lopes 1999, 2.5.2 (definitions), 5.1.3 (interpolation in time before that in space).
    """
    models = _in_order(series)
    begin, end, interval = _times(models, release, until, interval)
    rules: dict[str, Any] = {"tolerance": tolerance, "steps": steps, "faces": restarts, "assess": True}
    make = {"pathlines": _paths, "streaklines": _streaks, "timelines": _timelines}[kind]
    flow = _Flow(models, seeds.points, pair, rules, carry)
    return _drawn(models, seeds, make(flow, (begin, end, interval), progress), kind, carry)


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
        self.rows: list[Ints] = []
        self.seeds: list[Ints] = []
        self.found: list[Found | None] = []
        self.answered = 0

    def bring(self, found: Found | None, rows: int) -> int:
        """Keep how the rows of a run answer to errors; returns the number of its first."""
        self.found.append(found)
        self.answered += rows
        return self.answered - rows

    def add(
        self, points: Floats, times: Floats, releases: Floats, errors: Floats, of: int, rows: Ints, seeds: Ints | int
    ) -> None:
        """A line through points, which are rows of the runs, of particles from some seeds."""
        if len(points) < 2:
            return
        self.rows.append(rows)
        self.seeds.append(np.broadcast_to(np.asarray(seeds, np.int64), (len(points),)))
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


class _Flow:
    """The flow and how particles are followed in it, with how they answer to errors if that is brought along."""

    def __init__(self, models: list[Model], seeds: Floats, pair: str, rules: dict[str, Any], carry: bool) -> None:
        self.field, self._models, self._pair, self._rules = medium(models, 1, seeds), models, pair, rules
        self._carry = carry and isinstance(models[0].grid, Regular | Rectilinear) and models[0].law.name == "linear"

    def follow(self, end: float, interval: float, release: float, lines: _Lines, progress: Progress) -> tuple[Traces, int]:
        """Traces from a time of release, and the number of the first of their rows among those of all runs."""
        rules = {**self._rules, "end": end, "interval": interval}
        run = follow(self.field, 1, self._pair, rules, progress.part(0.0, 0.5 if self._carry else 1.0), release)
        found = None
        if self._carry:
            rows = with_steps(run, self._pair, rules, progress.part(0.5, 0.6), release)
            pieces = unsteady_pieces(self._models, rows, release)
            count = len(self._models) * self._models[0].grid.count
            found = summed(rows, pieces, count, 1, progress.part(0.6, 1.0))
        return run.traces, lines.bring(found, len(run.traces.time))


def _paths(flow: _Flow, times: tuple[float, float, float], progress: Progress) -> _Lines:
    begin, end, interval = times
    lines = _Lines()
    traces, first = flow.follow(end - begin, interval, begin, lines, progress)
    for i in range(len(traces.offsets) - 1):
        some = slice(*traces.offsets[i : i + 2])
        time = begin + traces.time[some]
        rows = first + np.arange(*traces.offsets[i : i + 2])
        lines.add(traces.points[some], time, np.full(len(time), begin), traces.error[some], i, rows, i)
    return lines


def _instants(begin: float, end: float, interval: float) -> Floats:
    return np.asarray(begin + interval * np.arange(int((end - begin) / interval * (1 + 1e-12)) + 1), np.float64)


def _streaks(flow: _Flow, times: tuple[float, float, float], progress: Progress) -> _Lines:
    """The particles of each seed at the end, from the one released last; where some have left, the line is in pieces."""
    begin, end, interval = times
    releases = [t for t in _instants(begin, end, interval)[::-1] if end - t > 1e-12 * (end - begin)]
    lines, p = _Lines(), len(flow.field.seeds)
    rows = np.zeros((p, len(releases)), np.int64)
    at, errors = np.full((p, len(releases), 3), np.nan), np.zeros((p, len(releases), 3))
    there = np.zeros((p, len(releases)), bool)
    for k, since in enumerate(releases):
        span = end - since
        part = progress.part(k / len(releases), (k + 1) / len(releases))
        traces, first = flow.follow(span, span, since, lines, part)
        last = traces.offsets[1:] - 1
        there[:, k] = (np.diff(traces.offsets) > 1) & (np.abs(traces.time[np.maximum(last, 0)] - span) <= 1e-9 * span)
        rows[:, k] = first + np.maximum(last, 0)
        at[there[:, k], k], errors[there[:, k], k] = traces.points[last[there[:, k]]], traces.error[last[there[:, k]]]
    since = np.array(releases)
    for i in range(p):
        for piece in np.split(np.arange(len(releases)), np.flatnonzero(~there[i])):
            kept = piece[there[i, piece]]
            lines.add(at[i, kept], np.full(len(kept), end), since[kept], errors[i, kept], i, rows[i, kept], i)
    return lines


def _timelines(flow: _Flow, times: tuple[float, float, float], progress: Progress) -> _Lines:
    """All particles at each instant, in the order of the seeds; where some have left, the line is in pieces."""
    begin, end, interval = times
    lines = _Lines()
    traces, first = flow.follow(end - begin, interval, begin, lines, progress)
    owner = np.repeat(np.arange(len(flow.field.seeds)), np.diff(traces.offsets))
    for k, instant in enumerate(_instants(begin, end, interval)):
        rows = np.flatnonzero(np.abs(traces.time - (instant - begin)) <= 1e-9 * (end - begin))
        for piece in np.split(rows, np.flatnonzero(np.diff(owner[rows]) > 1) + 1):
            when, since = np.full(len(piece), instant), np.full(len(piece), begin)
            lines.add(traces.points[piece], when, since, traces.error[piece], k, first + piece, owner[piece])
    return lines


def _accuracy(models: list[Model], seeds: Geometry, lines: _Lines, carry: bool) -> Accuracy:
    """What is known of the points of all lines."""
    unit = models[0].grid.frame.length_unit(models[0].grid.dimensions)
    error = np.concatenate([np.zeros((0, 3)), *lines.errors])
    told = Accuracy((_signed(HALF_STEPS, error, unit),))
    found = [f for f in lines.found if f is not None]
    why = "errors of this kind are not brought along traces in an unsteady flow"
    if len(found) < len(lines.found):
        asked = "in boxes, through linear models, and while there are not too many answers" if carry else "where 'carry' is on"
        told = told.miss(Missing("Errors of data and model", f"brought along traces in an unsteady flow only {asked}"))
    else:
        told = Accuracy.join([(told, None), *_carried(models, seeds, lines, found, unit)])
    if len(models) < 3 or len(found) < len(lines.found):
        told = told.miss(Missing("Between two times", "the flow is taken as linear between the times of the series"))
    for other in (*(m.accuracy for m in models), seeds.accuracy):
        told = told.end_from(other, why)
    return told


def _carried(
    models: list[Model], seeds: Geometry, lines: _Lines, found: list[Found], unit: str
) -> list[tuple[Accuracy, None]]:
    """Terms of samples, laws, times and seeds, each as an accuracy of its own."""
    rows = np.concatenate([np.zeros(0, np.int64), *lines.rows])
    three = (rows[:, None] * 3 + np.arange(3)).ravel()
    matrix = csr_array(vstack([f[0] for f in found], format="csr"))[three].tocsc()
    parts: list[Term] = []
    missing: list[Missing] = [*seeds.accuracy.missing]
    for m, model in enumerate(models):
        count, own = 3 * model.grid.count, model.own
        push = Matrix(csr_array(matrix[:, m * count : (m + 1) * count]))
        missing += model.accuracy.missing
        for term in model.accuracy.select("value", "point"):
            if term is not own:
                parts.append(term.push(push, quantity="position", unit=unit, place="point", components=3))
    drift = np.concatenate([f[1] for f in found])[rows]
    if models[0].own is not None:
        parts.append(_signed(models[0].own.source, drift[:, 0], unit))
    if len(models) > 2:
        parts.append(_signed(BETWEEN, drift[:, 1], unit))
    growth = np.concatenate([f[2] for f in found])[rows]
    seed = np.concatenate([np.zeros(0, np.int64), *lines.seeds])
    index = np.repeat(3 * seed[:, None] + np.arange(3), 3, axis=0).reshape(-1, 3)
    carry = Gather(index, growth.reshape(-1, 3), 3 * len(seeds.points))
    parts += [t.push(carry) for t in seeds.accuracy.select("position", "point") if t.components == 3]
    return [(Accuracy(missing=tuple(dict.fromkeys(missing))), None), *((Accuracy((t,)), None) for t in parts)]


def _signed(source: Source, error: Floats, unit: str) -> Term:
    flat = np.ascontiguousarray(error).ravel()
    return Term(source, "signed", "position", unit, flat, Identity(len(flat)), "point", 3)


def _drawn(models: list[Model], seeds: Geometry, found: _Lines, kind: str, carry: bool) -> Geometry:
    model, accuracy = models[0], _accuracy(models, seeds, found, carry)
    unit = model.grid.frame.length_unit(model.grid.dimensions)
    points = np.concatenate([np.zeros((0, 3)), *found.points])
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
