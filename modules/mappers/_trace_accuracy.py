"""What is known of where a traced particle is: terms from the integration, the data, the model and the seeds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from modules.api import EXACT, Accuracy, Flag, Gather, Geometry, Identity, Matrix, Missing, Model, Source, Term
from modules.mappers._trace_run import MOST_ANSWERS, RKSUITE, Answers, Run

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HALF_STEPS = Source(
    "Integration", "mapping", "estimated",
    "each step again in n = 2 parts, in 3 by a method of order 3, times n^p / (n^p - 1); Lopes 1999, 5.2.4 [two half steps/2]",
)  # fmt: skip
AGAIN = Source(
    "Integration", "mapping", "estimated",
    "a second integration with a tenth of the tolerance; Lopes 1999, 5.2.4 [re-integration/1]",
)  # fmt: skip
RESIDUAL = Source(
    "Velocity residual", "mapping", "exact", "dp/dt of the dense output less V(p); Lopes 1999, (5.8) [residual/1]"
)  # fmt: skip

BETTER = Source(
    "Velocity residual, of another model", "mapping", "estimated",
    "dp/dt of the dense output less the velocity of a second model; Lopes 1999, (5.8) and 5.4 [residual of another model/1]",
)  # fmt: skip
TUBE = Source(
    "Proven tube of the integration", "mapping", "proven",
    "defect of a curve through the steps, and the largest logarithmic norm by the corners of cells [logarithmic-norm/1]",
)  # fmt: skip


@dataclass(frozen=True)
class Told:
    """What a trace says of its error.

    Parameters
    ----------
    source : who estimates the integration's error; None if nobody was asked to
    report : primary or subsidiary
    safety : declared factor on the estimate
    why_not : why errors of samples and model are not carried, if they are not
    dense : whether there is a dense output, which tells a velocity residual
    better : whether that is against another model
    proof : whether a proven tube was asked for
    """

    source: Source | None
    report: str = "primary"
    safety: float = 1.0
    why_not: str = ""
    dense: bool = True
    better: bool = False
    proof: bool = False


def integration(how: Told, error: Floats, unit: str) -> Accuracy:
    """The estimate of the global error along the traces as a term; what is missing if none was asked for."""
    source = how.source
    if source is None:
        return Accuracy(missing=(Missing("Integration", "no estimate was asked for"),))
    if how.report == "subsidiary":
        source = replace(source, name="Integration, of the primary trace", rule=f"the subsidiary trace is drawn; {source.rule}")
    if how.safety != 1.0:
        source = replace(source, rule=f"{how.safety:g} times as safety: {source.rule}")
    return Accuracy((_vector(source, how.safety * error, "position", unit),))


def residual(how: Told, error: Floats, unit: str) -> Accuracy:
    """The velocity that the dense output infers less that of the model, as a term."""
    if not how.dense:
        return Accuracy(missing=(Missing("Velocity residual", "a multi-step method has no dense output to infer a velocity"),))
    return Accuracy((_vector(BETTER if how.better else RESIDUAL, error, "velocity", unit),))


def tubes(how: Told, radius: list[Floats | None], rows: Ints, unit: str) -> Accuracy:
    """Proven tubes of all runs as a bound of each coordinate, if they were asked for; or that there are none."""
    if not how.proof:
        return EXACT
    found = [r for r in radius if r is not None]
    if len(found) < len(radius):
        why = "proven of primary traces whose steps end on faces, in a steady linear model on a regular or rectilinear grid"
        return Accuracy(missing=(Missing(TUBE.name, why),))
    flat = np.repeat(np.concatenate(found)[rows], 3)
    return Accuracy((Term(TUBE, "bound", "position", unit, flat, Identity(len(flat)), "point", 3),))


def _vector(source: Source, error: Floats, quantity: str, unit: str) -> Term:
    flat = np.ascontiguousarray(error).ravel()
    return Term(source, "signed", quantity, unit, flat, Identity(len(flat)), "point", 3)


def inherited(
    model: Model, seeds: Geometry, seed: Ints, found: list[Answers] | None, rows: Ints, unit: str, how: Told
) -> Accuracy:
    """Errors of the samples, of the law and of the seeds, brought along the traces.

    Parameters
    ----------
    model, seeds : whose errors they are
    seed : (n,) the seed of each point
    found : the answers of all runs; None if there are none
    rows : (n,) row of each point in these
    unit : of lengths
    how : why not, if not
    """
    if found is None:
        why = how.why_not or f"more than {MOST_ANSWERS} answers of positions to samples: fewer particles or samples carry them"
        return Accuracy(missing=(Missing("Errors of data and model", why),)).end_from(model.accuracy, why).end_from(
            seeds.accuracy, why
        )
    parts: list[Term] = []
    three = (rows[:, None] * 3 + np.arange(3)).ravel()
    matrix = Matrix(csr_array(vstack([a.samples for a in found], format="csr"))[three])
    own = model.own
    for term in model.accuracy.select("value", "point"):
        if term is not own:
            parts.append(term.push(matrix, quantity="position", unit=unit, place="point", components=3))
    drifts = [a.drift for a in found if a.drift is not None]
    if own is not None and len(drifts) == len(found):
        drift = np.concatenate(drifts)[rows].ravel()
        parts.append(Term(own.source, "signed", "position", unit, drift, Identity(len(drift)), "point", 3, own.id))
    growth = np.concatenate([a.growth for a in found])[rows]
    index = np.repeat(3 * seed[:, None] + np.arange(3), 3, axis=0).reshape(-1, 3)
    carry = Gather(index, growth.reshape(-1, 3), 3 * len(seeds.points))
    moved = [t.push(carry) for t in seeds.accuracy.select("position", "point") if t.components == 3]
    ways = [(Accuracy((t,)), None) for t in (*parts, *moved)]
    missing = Accuracy(missing=(*model.accuracy.missing, *seeds.accuracy.missing))
    carried = Accuracy.join([(missing, None), *ways])
    why = "errors of this kind are not brought along a trace"
    return carried.end_from(model.accuracy, why).end_from(seeds.accuracy, why)


def trusted(runs: list[Run], time: Floats, seed: Ints, how: Told) -> list[Flag]:
    """Points from where on RKSUITE's test finds the assessment not credible."""
    if how.source != HALF_STEPS:
        return []
    late = np.zeros(len(time), bool)
    for run in runs:
        late |= time * run.sign > run.traces.trusted[seed]
    bad = np.flatnonzero(late)
    if not len(bad):
        return []
    traces = len(np.unique(seed[bad]))
    words = (
        f"the estimate is not credible at {len(bad)} of {len(time)} points of {traces} traces, by RKSUITE's rule: the half "
        "steps are not much better than the steps; steps that end on the faces of cells, or a smaller tolerance, help"
    )
    return [Flag(RKSUITE, words, "point", bad)]


def elsewhere(model: Model, seeds: Geometry) -> Accuracy:
    """The accuracy of the table of ends: it is that of the last points."""
    why = "where a trace ends is as accurate as its last point: look at the traces"
    told = Accuracy(missing=(Missing("Accuracy of the ends", why),))
    return replace(told.end_from(model.accuracy, why).end_from(seeds.accuracy, why), missing=told.missing)
