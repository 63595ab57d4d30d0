"""Values rounded to steps, as an instrument or a file would."""

from __future__ import annotations

import math

import numpy as np

from modules.api import Annotated, Identity, Range, Samples, Source, Term, modeller
from modules.modellers._linear import incoming


@modeller("Quantise", output="samples", aliases=("quantize", "round", "bits", "steps", "digitise", "posterise"))
def quantise(
    samples: Samples,
    *,
    step: Annotated[float | None, Range(0)] = None,
    bits: Annotated[int, Range(1, 32)] = 8,
) -> Samples:
    """Each value becomes the nearest of evenly spaced steps.

    Parameters
    ----------
    samples : of any grid
    step : distance of two steps, in the unit of the values, one of them at 0; automatic takes what `bits` give
    bits : without a step: 2 to the power of bits steps from the smallest to the largest value

    Raises
    ------
    ValueError : a step that is not positive, more than 32 bits

    Accuracy: errors of the samples go on as they are; adds a bound of half a step, proven.
    Source: rounding to the nearest.
    """
    if step is not None and not (step > 0 and math.isfinite(step)):
        raise ValueError(f"step = {step} should be more than 0, or automatic")
    if not 1 <= bits <= 32:
        raise ValueError(f"bits = {bits} should be 1 to 32")
    values = samples.values.astype(np.float64, copy=False)
    held = values[np.isfinite(values)]
    low, width = 0.0, step
    if width is None:
        low = float(held.min()) if held.size else 0.0
        width = (float(held.max()) - low) / (2**bits - 1) if held.size else 0.0
    rounded = low + np.rint((values - low) / width) * width if width > 0 else values.copy()
    largest = float(np.abs(held).max()) if held.size else 0.0
    half = 0.5 * width + 4 * np.finfo(float).eps * largest
    n, c, unit = values.size, samples.components, samples.unit
    rule = f"half of a step of {width:g}{' ' + unit if unit else ''} (rounding/1)"
    said = Source("Rounding to steps", "model", "proven", rule)
    own = Term(said, "bound", "value", unit, np.asarray(half), Identity(n), components=c)
    return Samples(
        grid=samples.grid, values=rounded, unit=unit, name=samples.name, accuracy=incoming(samples).add(own), time=samples.time
    )
