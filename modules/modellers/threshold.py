"""Only what lies between two values, of the data itself or of other data on the same grid; the rest becomes holes."""

from __future__ import annotations

import numpy as np

from modules.api import Accuracy, Annotated, Flag, Literal, Range, Samples, modeller
from modules.data.operators import Floats
from modules.modellers._linear import incoming

SURE = 2.0
"""Standard deviations within which a value may fall on the other side."""


@modeller("Threshold", output="samples", aliases=("mask", "cut off", "filter by value", "range", "where", "blank"))
def threshold(
    samples: Samples,
    by: Samples | None = None,
    *,
    low: Annotated[float | None, Range(of="samples.range")] = None,
    high: Annotated[float | None, Range(of="samples.range")] = None,
    keep: Literal["inside", "outside"] = "inside",
) -> Samples:
    """The samples whose value lies in a range; the others become holes.

    Parameters
    ----------
    samples : of any grid
    by : single numbers on the same grid that decide instead of the samples themselves: a mask
    low : smallest value that is inside; automatic has no lower end. A mask with neither end keeps what is not 0
    high : largest value that is inside; automatic has no upper end
    keep : what is inside the range, or what is outside

    Raises
    ------
    ValueError : vectors without a mask, a mask elsewhere, a low above the high

    Accuracy: what is kept keeps its errors. Where errors of what decides are as large as its distance from an end (bounds
    and two deviations), the decision is flagged as at risk; a mask's errors end here, in that flag.
    Source: a choice of rows.
    """
    decides = samples if by is None else by
    if decides.components != 1:
        raise ValueError("vectors have no order: wire single numbers (invariants gives the length) as what decides")
    if by is not None and not by.grid.same_place(samples.grid):
        raise ValueError(f"the mask lies on {by.grid.shape} samples, the data on {samples.grid.shape} elsewhere: resample it")
    if low is not None and high is not None and low > high:
        raise ValueError(f"low = {low:g} is above high = {high:g}")
    value = decides.values.astype(np.float64, copy=False)
    if by is not None and low is None and high is None:
        inside = np.isfinite(value) & (value != 0)
    else:
        with np.errstate(invalid="ignore"):
            inside = (value >= (-np.inf if low is None else low)) & (value <= (np.inf if high is None else high))
    kept = inside if keep == "inside" else np.isfinite(value) & ~inside
    extra = samples.values.ndim - kept.ndim
    values = np.where(kept.reshape(*kept.shape, *[1] * extra), samples.values.astype(np.float64, copy=False), np.nan)
    accuracy = _risked(incoming(samples), decides, value, low, high)
    if by is not None:
        accuracy = accuracy.end_from(by.accuracy, "it decides what is kept; where that is at risk is flagged")
        accuracy = accuracy.miss(*by.accuracy.missing)
    return Samples(
        grid=samples.grid, values=values, unit=samples.unit, name=samples.name, accuracy=accuracy, time=samples.time
    )


def _risked(accuracy: Accuracy, decides: Samples, value: Floats, low: float | None, high: float | None) -> Accuracy:
    """With a flag where what decides may lie on the other side of an end."""
    ends = [e for e in (low, high) if e is not None]
    if not ends or not decides.accuracy.terms:
        return accuracy
    flat = value.ravel()
    away = np.min([np.abs(flat - e) for e in ends], axis=0)
    near = np.flatnonzero(np.isfinite(away))
    size = incoming(decides).total(SURE, "value", "point", near)
    risked = near[size >= away[near]]
    if not len(risked):
        return accuracy
    words = f"errors may carry {len(risked)} of {len(flat)} samples over an end of the range"
    return accuracy.flag(Flag("decision at risk", words, "point", risked))
