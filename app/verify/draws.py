"""Where errors of data enter a network, and realisations of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.verify.runs import Bench, Outputs, Run, perturbed, with_values
from modules.data.accuracy import Term
from modules.data.wires import Model, Samples

Floats = NDArray[np.float64]

DRAWN = ("linear", "bound", "members")
"""Kinds of which there are realisations."""


@dataclass(frozen=True, eq=False)
class Birth:
    """A term at the output where it is first stated of values that it did not make.

    Parameters
    ----------
    node, output : where it enters
    term : as it is there
    """

    node: str
    output: str
    term: Term


def births(bench: Bench, run: Run) -> list[Birth]:
    """Every drawable term of samples, where it enters: at a source, or at a step that states it and changes no value."""
    found = []
    for node in bench.wanted:
        outputs = run.outputs.get(node)
        if outputs is None:
            continue
        above = list(_above(bench, run, node))
        known = {t.id for value in above for t in value.accuracy.terms}
        for name, value in outputs.items():
            if not isinstance(value, Samples) or not (_same(value, above) or node in bench.sources):
                continue
            found += [
                Birth(node, name, t)
                for t in value.accuracy.select("value", "point")
                if t.kind in DRAWN and t.id not in known and np.any(t.value) and np.isfinite(t.value).all()
            ]
    return found


def _above(bench: Bench, run: Run, node: str) -> Iterator[Any]:
    for origins in bench.network.incoming.get(node, {}).values():
        for source, output in origins:
            value = run.outputs.get(source, {}).get(output.partition(":")[0])
            if isinstance(value, Samples | Model):
                yield value


def _same(value: Samples, above: list[Any]) -> bool:
    """Whether a step hands on the very values that it got."""
    given = [v.samples if isinstance(v, Model) else v for v in above]
    return any(v.values.shape == value.values.shape and np.array_equal(v.values, value.values, equal_nan=True) for v in given)


def draw(term: Term, random: np.random.Generator, corner: bool = False) -> Floats:
    """One realisation of a term's primitives: normal of a deviation, even within a bound or at its ends, a mix of members."""
    n = term.operator.shape[1]
    if term.kind == "members":
        apart = term.value - term.value.mean(axis=0)
        return np.asarray(random.standard_normal(len(apart)) @ apart / np.sqrt(max(1, len(apart) - 1)))
    if term.kind == "linear":
        return np.asarray(term.value * random.standard_normal(n))
    return np.asarray(term.value * (random.choice([-1.0, 1.0], n) if corner else random.uniform(-1, 1, n)))


def laid(run: Run, made: Mapping[str, Floats], all_of: list[Birth]) -> dict[str, Outputs]:
    """What to lay so that some terms have come true: the outputs at which they enter, with the errors added.

    Parameters
    ----------
    made : id -> primitives
    all_of : every birth; one that lies below another takes the errors that reach it too
    """
    outputs: dict[str, Outputs] = {}
    for birth in all_of:
        if birth.term.id not in made and birth.node not in outputs:
            continue
        here = run.outputs[birth.node] if birth.node not in outputs else outputs[birth.node]
        if birth.node in outputs and here[birth.output] is not run.outputs[birth.node][birth.output]:
            continue
        samples = run.outputs[birth.node][birth.output]
        total = np.zeros(samples.values.size)
        for term in samples.accuracy.select("value", "point"):
            if term.id in made:
                primitives = np.broadcast_to(made[term.id], (term.operator.shape[1],))
                total = total + np.asarray(term.operator.apply(primitives)).ravel()
        outputs[birth.node] = with_values(here, birth.output, perturbed(samples, total))
    return outputs
