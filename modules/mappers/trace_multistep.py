"""Traces by multi-step methods, Adams and BDF, for comparison with Runge-Kutta: what they cost, and how they start."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Annotated,
    Geometry,
    Literal,
    Model,
    NamedTuple,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Table,
    mapper,
)
from modules.mappers import _trace_accuracy as known
from modules.mappers._trace_field import Medium, medium
from modules.mappers._trace_lines import drawn, ends, span
from modules.mappers._trace_run import Run, against, follow

Floats = NDArray[np.float64]

PAST = {"Adams": 12, "BDF": 5}
"""The highest order, which is how many past steps it needs: until there are so many, a method is still starting."""

BETTER, FINEST = 1e-3, 1e-12
"""The tolerance of the Runge-Kutta march that judges, as a part of what is judged, and the smallest."""

JUDGE = "Dormand-Prince 5(4)"


class Stepped(NamedTuple):
    """Traces as lines with times, and how each of them ends."""

    traces: Geometry
    ends: Table


@mapper("Multi-step traces", aliases=("Adams", "BDF", "Gear", "VODE", "stiff", "integrate"))
def trace_multistep(
    model: Model,
    seeds: Geometry,
    progress: Progress,
    *,
    method: Literal["Adams", "BDF"] = "Adams",
    tolerance: Annotated[float, Range(1e-10, 1e-2, log=True)] = 1e-6,
    direction: Literal["forward", "backward"] = "forward",
    end_time: Annotated[float | None, Range(low=0)] = None,
    instants: Annotated[int, Range(2, 10_000, log=True)] = 20,
    steps: Annotated[int, Range(1, 1_000_000, log=True)] = 20_000,
) -> Stepped:
    """Particles followed by methods that use their past steps, as VODE has them, to be compared with 'Particle traces'.

    A multi-step method has no past when it starts: it begins at order one with tiny steps, and does so anew in effect wherever
    the velocity has a kink, which in a linear model is at each face of a cell. One particle after the other, in the
    interpreter: a comparison, not a way to follow many.

    Parameters
    ----------
    model : velocity on a regular or rectilinear grid
    seeds : where particles begin
    method : Adams, of orders up to 12; or BDF, of orders up to 5, for stiff flows
    tolerance : largest local error of a step, as a part of the extent of the domain
    direction : forward or backward
    end_time : time to follow each particle; automatic: that of two diagonals of the domain at the mean speed
    instants : equal times at which positions are kept
    steps : at most so many

    Raises
    ------
    ValueError : the model is not a velocity on such a grid

    Values: `time`, `speed`, `velocity`. In the table of ends also `largest`, the largest distance of a trace from the march
    that judges it, and `start-up error`, that distance when as many steps are taken as the highest order needs.

    Accuracy: the distance from a Runge-Kutta march with restarts at a thousandth of the tolerance, estimated. There is no
        velocity residual, for the method has no dense output. Errors of samples and model are missing.
    Source: Lopes 1999, 5.1.2 (multi-step methods need a start); Brown, Byrne and Hindmarsh 1989 (VODE, by scipy).
    """
    if not isinstance(model.grid, Regular | Rectilinear):
        raise ValueError(f"multi-step methods follow particles on regular and rectilinear grids; this one is {model.grid.kind}")
    sign = 1 if direction == "forward" else -1
    field = medium([model], sign, seeds.points)
    end = span(field, end_time)
    times, fine = np.linspace(0.0, end, instants + 1), max(BETTER * tolerance, FINEST)
    judge = follow(field, sign, JUDGE, {"tolerance": fine, "end": end, "interval": end / instants}, progress.part(0.0, 0.1))
    velocity, reach = _velocity(model, sign), max(float(np.ptp(a)) for a in model.grid.axes)
    solver = _Solver(velocity, model.grid, method, tolerance * reach)
    found, late = [], []
    for i, seed in enumerate(field.seeds):
        progress(0.1 + 0.9 * i / len(field.seeds))
        found.append(_one(solver, seed, times, PAST[method], steps, progress))
        late.append(_start_up(field, i, found[-1], fine))
    run = Run(sign, field, _joined(found, velocity))
    away = against(run.traces, judge.traces)
    rule = f"distance from {JUDGE} with restarts at {fine:.0e}; {method} by VODE; Lopes 1999, 5.1.2 [multi-step/1]"
    source = Source("Integration", "mapping", "estimated", rule)
    how = known.Told(source, why_not="brought along by 'Particle traces' only", dense=False)
    traces = drawn(model, seeds, [replace(run, error=away)], how)
    return Stepped(traces, _with_errors(ends(model, seeds, [run]), run, away, late))


def _with_errors(told: Table, run: Run, away: Floats, late: list[float]) -> Table:
    """The table of ends with how far each trace is off, at most and after its start."""
    apart = np.linalg.norm(away, axis=1)
    largest = [float(apart[a:b].max(initial=0.0)) for a, b in pairwise(run.traces.offsets)]
    unit = told.units["length"]
    return replace(
        told,
        columns={**told.columns, "largest": np.array(largest), "start-up error": np.array(late)},
        units={**told.units, "largest": unit, "start-up error": unit},
    )


class _Found(NamedTuple):
    """One trace: times and positions; the time and place when it has started; why it ends; steps and evaluations."""

    time: Floats
    points: Floats
    started: tuple[float, Floats]
    reason: int
    steps: int
    evaluations: int


def _velocity(model: Model, sign: int) -> Callable[[Floats], Floats]:
    """The velocity at one position, beyond the border that of the nearest point of the domain."""
    grid = model.grid
    flat = sign * np.asarray(model.samples.values, float).reshape(grid.count, -1)
    flat[:, grid.dimensions :] = 0.0
    ends = np.asarray(grid.bounds).reshape(-1, 2)[: grid.dimensions]

    def at(p: Floats) -> Floats:
        inside = np.array(p, float)
        inside[: grid.dimensions] = np.clip(inside[: grid.dimensions], ends[:, 0], ends[:, 1])
        weights = model.law.weights(grid, inside[None])
        return np.asarray(np.broadcast_to(weights.weight, weights.index.shape)[0] @ flat[weights.index[0]], float)

    return at


class _Solver:
    """VODE on one particle, which tells positions within its last step by its own polynomial."""

    def __init__(self, velocity: Callable[[Floats], Floats], grid: Regular | Rectilinear, method: str, allowed: float) -> None:
        self._velocity, self._method, self._allowed = velocity, method, allowed
        self._low, self._high = (np.array([a[e] for a in grid.axes]) for e in (0, -1))
        self.evaluations = 0

    def _counted(self, _: float, p: Floats) -> Floats:
        self.evaluations += 1
        return self._velocity(p)

    def begin(self, seed: Floats, end: float) -> None:
        """Stand at a seed, to go on until a time or a little beyond."""
        from scipy.integrate import ode

        solver = ode(self._counted)
        solver.set_integrator("vode", method=self._method.lower(), rtol=0.0, atol=self._allowed, nsteps=100_000)
        self._solver, self._end, self.evaluations = solver.set_initial_value(seed, 0.0), end, 0

    def step(self) -> float:
        """The time after one more step."""
        self._solver.integrate(self._end, step=True)
        return float(self._solver.t)

    def at(self, time: float) -> Floats:
        """The position at a time in the last step."""
        return np.array(self._solver.integrate(time), float)

    def inside(self, p: Floats) -> bool:
        """Whether a position lies in the domain."""
        d = len(self._low)
        return bool(((p[:d] >= self._low) & (p[:d] <= self._high)).all())

    def last_inside(self, before: float, after: float) -> float:
        """When a step leaves the domain that ends outside."""
        for _ in range(50):
            middle = 0.5 * (before + after)
            before, after = (middle, after) if self.inside(self.at(middle)) else (before, middle)
        return before


def _one(solver: _Solver, seed: Floats, times: Floats, past: int, most: int, progress: Progress) -> _Found:
    """Follow one particle, and keep its positions at some times, the first of them 0."""
    reasons = kernels.trace.REASONS
    if not np.isfinite(seed).all() or not solver.inside(seed):
        return _Found(np.zeros(0), np.zeros((0, 3)), (0.0, seed), reasons.index("began outside"), 0, 0)
    kept, points, started, taken, now, why = [0.0], [seed], (0.0, seed), 0, 0.0, "end time"
    solver.begin(seed, times[-1])
    while now < times[-1]:
        progress.check()
        if taken == most:
            why = "most steps"
            break
        before, now, taken = now, solver.step(), taken + 1
        if not now > before:
            why = "steps too small"
            break
        stop = now
        if not solver.inside(solver.at(now)):
            stop, why = solver.last_inside(before, now), "left the domain"
        due = times[(times > before) & (times <= stop)].tolist()
        if why == "left the domain" and stop < times[-1]:
            due.append(stop)
        kept += due
        points += [solver.at(t) for t in due]
        if why == "left the domain":
            why = why if stop < times[-1] else "end time"
            break
        if taken == past:
            started = now, solver.at(now)
    return _Found(np.array(kept), np.array(points), started, reasons.index(why), taken, solver.evaluations)


def _start_up(field: Medium, which: int, found: _Found, tolerance: float) -> float:
    """How far a particle is from where it should be when the method has started; NaN where it ended before."""
    time, there = found.started
    if not time > 0:
        return math.nan
    one = replace(field, seeds=field.seeds[which : which + 1])
    judge = kernels.trace.march(one.flow, one.seeds, kernels.trace.rules_of(one.flow, tolerance=tolerance, end=time))
    return float(np.linalg.norm(there - judge.points[-1]))


def _joined(found: list[_Found], velocity: Callable[[Floats], Floats]) -> Any:
    """All traces as those of the kernel; what a multi-step method does not tell is NaN."""
    points = np.concatenate([np.zeros((0, 3)), *(f.points for f in found)])
    unknown = np.full(points.shape, np.nan)
    counts = {name: np.array([getattr(f, name) for f in found], np.int64) for name in ("reason", "steps", "evaluations")}
    chords = [np.linalg.norm(np.diff(f.points, axis=0), axis=1).sum() for f in found]
    return kernels.trace.Traces(
        offsets=np.cumsum([0, *(len(f.time) for f in found)]).astype(np.int64),
        time=np.concatenate([np.zeros(0), *(f.time for f in found)]),
        points=points,
        velocity=np.array([velocity(p) for p in points]).reshape(-1, 3),
        residual=unknown, error=unknown, local=unknown, refused=np.zeros(len(found), np.int64),
        length=np.array(chords, float), trusted=np.full(len(found), np.inf), **counts,
    )  # fmt: skip
