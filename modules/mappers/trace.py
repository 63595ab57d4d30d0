"""Particle traces through a steady flow, and how far each of their points may be from where the particle is."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Annotated,
    Geometry,
    Literal,
    Model,
    NamedTuple,
    Progress,
    Range,
    Table,
    mapper,
)
from modules.mappers import _trace_accuracy as known
from modules.mappers._trace_answers import answers_along, carries
from modules.mappers._trace_field import Medium, medium
from modules.mappers._trace_lines import drawn, ends, span
from modules.mappers._trace_proof import tube
from modules.mappers._trace_run import Run, against, answers, follow, judged

Floats = NDArray[np.float64]

SOURCES = {"half steps": known.HALF_STEPS, "re-integration": known.AGAIN, "none": None}


class Traced(NamedTuple):
    """Traces as lines with times, and how each of them ends."""

    traces: Geometry
    ends: Table


@mapper(
    "Particle traces",
    version=2,
    aliases=("streamlines", "advect", "integrate", "flow lines", "Runge-Kutta", "GenPathAccuracy"),
)
def trace(
    model: Model,
    seeds: Geometry,
    progress: Progress,
    better: Model | None = None,
    *,
    pair: Literal[
        "Dormand-Prince 5(4)", "Bogacki-Shampine 3(2)", "Euler", "Heun", "midpoint", "RK4"
    ] = "Dormand-Prince 5(4)",
    control: Literal["extent", "nag", "fixed", "cell", "curvature"] = "extent",
    tolerance: Annotated[float, Range(1e-12, 1e-2, log=True)] = 1e-6,
    step: Annotated[float, Range(1e-3, 1, log=True)] = 0.2,
    direction: Literal["forward", "backward", "both"] = "forward",
    end_time: Annotated[float | None, Range(low=0)] = None,
    interval: Annotated[float | None, Range(low=0)] = None,
    longest: Annotated[float | None, Range(low=0)] = None,
    steps: Annotated[int, Range(1, 1_000_000, log=True)] = 20_000,
    restarts: bool = True,
    estimate: Literal["half steps", "re-integration", "none"] = "half steps",
    report: Literal["primary", "subsidiary"] = "primary",
    safety: Annotated[float, Range(1, 10)] = 1.0,
    space: Literal["physical", "computational"] = "physical",
    carry: bool = True,
    proof: bool = False,
    law: Literal["of the model", "not-a-knot spline"] = "of the model",
) -> Traced:
    """The paths of particles that follow a steady velocity, from each seed until the end time, the border or rest.

    Parameters
    ----------
    model : velocity, of two or three components: linear, nearest or cubic on a regular or rectilinear grid, linear on a
        bent lattice or in cells of an unstructured grid, which are cut in tetrahedra
    seeds : where particles begin
    better : another model of the velocity, for the velocity residual in place of the one that is followed
    pair : Runge-Kutta method; the first two estimate their local errors, the others need another control of the steps
    control : extent (local error over the size of the domain), nag (over the coordinate itself, thesis 5.3 to 5.7: near a
        border at coordinate 0 it depends on where the origin is), fixed steps, by cell size over speed, or by curvature
    tolerance : largest local error of a step, as a part of what `control` says; of extent with restarts that of the steps
        through as many cells as lie across the domain, each with its share
    step : fixed: the time step; cell: part of a cell; curvature: angle in radians that a step may turn
    direction : forward, backward or both from each seed
    end_time : time to follow each particle; automatic: that of two diagonals of the domain at the mean speed
    interval : time between the points of a trace; automatic: one at each step
    longest : length at which a trace ends, measured along its steps; automatic: any
    steps : at most so many in each direction
    restarts : steps end on the faces of cells, where the linear model has a kink; without, the order of the method is lost.
        A cubic model needs none; bent lattices and tetrahedra always have them
    estimate : of the integration's error: two half steps beside each step (three thirds of 3(2)), a second integration with
        a tenth of the tolerance (and twice the steps in each cell, with restarts), or none
    report : with half steps, the primary trace, whose error is stated; or the subsidiary one of the half steps, as NAG and
        figure 5.10 do: it is the better one, and what is stated is still the error of the primary one
    safety : a declared factor on the estimate of the integration's error
    space : of a bent lattice: physical, exact for the interpolated velocity; or computational, where velocities are brought
        to the lattice at the samples and interpolated there, as thesis 5.1.1 tells, which is another flow between them
    carry : errors of samples, model and seeds are brought along the traces
    proof : also a proven bound of the integration's error, through a steady linear model in boxes with restarts
    law : between the samples: of the model; or a spline through all of them, C2 and of fourth order. By how much two laws
        differ along a trace, 'Compare traces' tells as an error of the model

    Raises
    ------
    ValueError : the model is not a velocity on such a grid, a setting does not fit the method, or re-integration without
        an interval, whose times both integrations share

    Values: `time`, `speed`, `velocity`, `local error` of the step, and with `carry` `stretching`, the largest factor by which
    a small displacement of the seed has grown; on lines `seed`.

    Accuracy: the integration's error is estimated along each trace; errors of samples, of the model and of the seeds are
        carried by the derivative of the flow, exact to first order, through linear and cubic models in boxes and linear ones
        on bent lattices; elsewhere they are missing. The velocity residual is exact and is no position. The proven tube
        bounds each coordinate, rounding included; where it ends, as wide as some cells, it is infinite.
    Source: Lopes 1999, chapter 5, with steps restarted at the faces of cells; Alekseev-Groebner integral for the errors of
        data and model.
    """
    _check(report, estimate, safety, interval)
    signs = {"forward": (1,), "backward": (-1,), "both": (-1, 1)}[direction]
    media = [medium([model], sign, seeds.points, space, spline=law != "of the model") for sign in signs]
    rules: dict[str, Any] = {
        "control": control, "tolerance": tolerance, "size": step, "end": span(media[0], end_time),
        "interval": interval or 0.0, "length": math.inf if longest is None else longest, "steps": steps, "faces": restarts,
        "subsidiary": report == "subsidiary",
    }  # fmt: skip
    other_way = law == "of the model" and carries(model, media[0])
    asked = _Asked(estimate, proof, carry, other_way)
    runs = []
    for i, (sign, field) in enumerate(zip(signs, media, strict=True)):
        part = progress.part(i / len(signs), (i + 1) / len(signs))
        run = _run(model, field, sign, pair, rules, asked, part)
        runs.append(run if better is None else replace(run, traces=judged(run.traces, better, sign)))
    why_not = _why_not(carry, media[0].carries or other_way)
    how = known.Told(SOURCES[estimate], report, safety, why_not, better=better is not None, proof=proof)
    traces, told = drawn(model, seeds, runs, how), ends(model, seeds, runs)
    if better is not None:
        why = "its velocity alone is looked at, for the velocity residual"
        traces = replace(traces, accuracy=traces.accuracy.end_from(better.accuracy, why))
        told = replace(told, accuracy=told.accuracy.end_from(better.accuracy, why))
    return Traced(traces, told)


class _Asked(NamedTuple):
    """What is to be known of the traces, and whether errors of samples go along by the weights of the law."""

    estimate: str
    proof: bool
    carry: bool
    by_weights: bool


def _check(report: str, estimate: str, safety: float, interval: float | None) -> None:
    if estimate == "re-integration" and not interval:
        raise ValueError("re-integration compares positions at equal times: give an interval")
    if report == "subsidiary" and estimate != "half steps":
        raise ValueError("the subsidiary trace is that of the half steps: estimate by these, or report the primary one")
    if not safety >= 1:
        raise ValueError(f"a safety factor is at least 1, not {safety:g}")


def _why_not(carry: bool, known_way: bool) -> str:
    """Why errors of samples and model would not be carried; the number of answers, if nothing else."""
    if not carry:
        return "not brought along the traces: 'carry' is off"
    if not known_way:
        return "brought along traces only through linear and cubic models, on bent lattices through linear ones"
    return ""


def _run(
    model: Model, field: Medium, sign: int, pair: str, rules: dict[str, Any], asked: _Asked, progress: Progress
) -> Run:
    """Follow all particles in one direction, with all that is asked."""
    run = _estimated(field, sign, pair, rules, asked.estimate, progress.part(0.0, 0.4))
    if asked.proof:
        run = replace(run, tube=tube(run, pair, rules, progress.part(0.4, 0.6)))
    if asked.carry and field.carries:
        return replace(run, found=answers(model, run, progress.part(0.6, 1.0)))
    if asked.carry and asked.by_weights:
        return replace(run, found=answers_along(model, run, pair, rules, progress.part(0.6, 1.0)))
    return run


def _estimated(field: Medium, sign: int, pair: str, rules: dict[str, Any], estimate: str, progress: Progress) -> Run:
    """Follow all particles in one direction, with the estimated error of each position."""
    run = follow(field, sign, pair, {**rules, "assess": estimate == "half steps"}, progress)
    if estimate != "re-integration":
        return run
    controlled = rules["control"] in ("extent", "nag")
    finer = {"tolerance": rules["tolerance"] / 10} if controlled else {"size": rules["size"] / 2}
    again = follow(field, sign, pair, {**rules, **finer, "halve": rules["faces"]}, progress)
    return replace(run, error=against(run.traces, again.traces))
