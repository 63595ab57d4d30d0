"""Noise of known size, to try what becomes of it."""

from __future__ import annotations

import math

import numpy as np

from modules.api import Annotated, Identity, Literal, Operator, Range, Samples, Source, Spread, Stencil, Term, modeller
from modules.data.operators import Floats
from modules.modellers._linear import incoming


@modeller("Add noise", output="samples", aliases=("noise", "perturb", "random", "jitter", "simulate errors"))
def add_noise(
    samples: Samples,
    *,
    amount: Annotated[float, Range(0)] = 0.01,
    kind: Literal["normal", "even"] = "normal",
    correlation: Literal["independent", "common"] = "independent",
    seed: int = 1,
) -> Samples:
    """The samples with random numbers added.

    Parameters
    ----------
    samples : of any grid
    amount : standard deviation of normal noise, or the most that even noise adds, in the unit of the values
    kind : normal; or even between -amount and amount
    correlation : independent from value to value; or common, one number for all samples of a component
    seed : the same seed gives the same noise

    Raises
    ------
    ValueError : an amount that is negative or no number

    Accuracy: errors of the samples go on as they are; adds the noise as a term of the size that it was made with: a
    standard deviation, or for even noise a bound.
    Source: the noise is made here.
    """
    if not (math.isfinite(amount) and amount >= 0):
        raise ValueError(f"amount = {amount} should be 0 or more")
    values = samples.values.astype(np.float64, copy=False)
    n, c = values.size, samples.components
    operator: Operator = Identity(n)
    if correlation == "common":
        operator = Spread(n) if c == 1 else _each(n, c)
    random = np.random.default_rng(seed & 0xFFFFFFFF)
    count = operator.shape[1]
    made = amount * (random.standard_normal(count) if kind == "normal" else random.uniform(-1, 1, count))
    unit = f" {samples.unit}" if samples.unit else ""
    words = f"standard deviation {amount:g}{unit}" if kind == "normal" else f"at most {amount:g}{unit}, evenly spread"
    rule = f"noise of {words} was added, {correlation}, seed {seed} (added noise/1)"
    said = Source("Added noise", "data", "exact" if kind == "normal" else "proven", rule)
    own = Term(
        said, "linear" if kind == "normal" else "bound", "value", samples.unit, np.asarray(amount), operator, components=c
    )  # fmt: skip
    noise: Floats = np.asarray(operator.apply(made)).reshape(values.shape)
    return Samples(
        grid=samples.grid,
        values=values + noise,
        unit=samples.unit,
        name=samples.name,
        accuracy=incoming(samples).add(own),
        time=samples.time,
    )


def _each(n: int, c: int) -> Operator:
    """One primitive a component reaches all samples."""
    return Stencil((1, c), 0, np.zeros((n // c, 1), np.int64), np.ones((n // c, 1)))
