"""What a person knows of the errors of data whose file says nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from hashlib import sha256
from typing import Annotated, Literal

import numpy as np

from modules.api import Range, Samples, Source, Term, modeller
from modules.data import correlation as correlated
from modules.data.fold import Kind
from modules.data.operators import Floats


@modeller("State accuracy", output="samples", aliases=("error", "uncertainty", "survey error", "noise level"))
def state_accuracy(
    samples: Samples,
    field: Samples | None = None,
    *,
    amount: Annotated[float, Range(0)] = 1.0,
    kind: Literal["standard deviation", "bound"] = "standard deviation",
    form: Literal["constant", "percent", "field"] = "constant",
    correlation: Literal["independent", "common", "length"] = "independent",
    length: Annotated[float, Range(0)] = 1.0,
    error: str = "Measurement error",
    who: str = "the user",
    source: str = "",
    answers: str = "Measurement error",
) -> Samples:
    """Adds what someone says of the errors of the samples.

    Parameters
    ----------
    field : sizes of the errors, on the same grid, in the unit of the samples; for form "field"
    amount : size in the unit of the samples; per cent of each value for form "percent"; a factor for form "field"
    kind : standard deviation, or bound: an error that is never exceeded
    form : constant for all samples, per cent of the value, or a field of sizes
    correlation : independent from sample to sample; common, one error for all; or alike within a length
    length : distance at which two samples correlate by exp(-1/2), in the unit of the coordinates
    error : what the error is called
    who : who says so
    source : errors of one source name are the same errors wherever they occur; empty: these errors occur only here
    answers : the missing source that this answers and takes off the list; empty for none

    Accuracy: adds one term, estimated, whose rule names who says so and what is assumed of the correlation; the terms
    of the samples go on; those of the field end, for an error of an error is not carried.

    Source: JCGM 100:2008, 4.3 (type B evaluation); correlation exp(-d^2 / 2 length^2) made by a Gaussian of unit noise.
    """
    _check(samples, field, amount, form, correlation, kind, length)
    sizes = _sizes(samples, field, amount, form)
    grid = samples.grid
    value, operator = correlated.carried(grid, samples.components, sizes, correlation, length, named=bool(source))
    size, assumed = _words(amount, kind, form, samples.unit), correlated.words(grid, correlation, length)
    said = Source(error, "data", "estimated", f"{who} states {size}; {assumed} (stated accuracy/1)")
    how: Kind = "bound" if kind == "bound" else "linear"
    term = Term(said, how, "value", samples.unit, value, operator, components=samples.components)
    if source:
        term = replace(term, id=_name(source, samples, term, correlation, length))
    if term.id in {t.id for t in samples.accuracy.terms}:
        raise ValueError(f"the errors of {source!r} are stated for these samples already: take another source name")
    missing = tuple(m for m in samples.accuracy.missing if m.name != answers or not answers)
    accuracy = replace(samples.accuracy, missing=missing).add(term)
    if field is not None:
        accuracy = accuracy.end_from(field.accuracy, "it is an error of a stated error, which is not carried")
    return replace(samples, accuracy=accuracy)


def _check(
    samples: Samples, field: Samples | None, amount: float, form: str, correlation: str, kind: str, length: float
) -> None:
    if not (math.isfinite(amount) and amount >= 0):
        raise ValueError(f"amount = {amount} is no size of an error: it must be 0 or more")
    if form == "field" and field is None:
        raise ValueError("form is 'field' and no field is wired: wire one, or choose constant or percent")
    if form != "field" and field is not None:
        raise ValueError(f"a field is wired and form is {form!r}: choose form 'field', or pull the wire")
    if field is not None and not field.grid.same_place(samples.grid):
        raise ValueError(
            f"the field lies on {field.grid.shape} samples elsewhere than the data ({samples.grid.shape}): resample it first"
        )
    if field is not None and field.unit and samples.unit and field.unit != samples.unit:
        raise ValueError(f"the field is in {field.unit}, the samples in {samples.unit}: convert it first")
    if correlation != "length":
        return
    if kind == "bound":
        raise ValueError("a bound has no correlation length: choose independent or common, or a standard deviation")
    correlated.check(samples.grid, correlation, length)


def _sizes(samples: Samples, field: Samples | None, amount: float, form: str) -> Floats:
    """0-d, or one size per value, components fastest; 0 at holes."""
    if form == "constant":
        return np.asarray(amount)
    if form == "percent":
        flat = np.abs(samples.values.astype(float)).ravel() * (amount / 100)
        return np.asarray(np.nan_to_num(flat, nan=0.0))
    assert field is not None
    stated = field.values.astype(float)
    if field.components == 1 and samples.components > 1:
        extra = [1] * (samples.values.ndim - stated.ndim)
        stated = np.broadcast_to(stated.reshape(*stated.shape, *extra), samples.values.shape)
    if stated.shape != samples.values.shape:
        raise ValueError(f"the field has {field.components} numbers a sample, the data {samples.components}: take as many")
    holes = np.isnan(samples.values)
    wrong = ~holes & ~(np.isfinite(stated) & (stated >= 0))
    if wrong.any():
        first = stated.ravel()[np.flatnonzero(wrong)[0]]
        raise ValueError(f"the field of errors is negative or not known at {int(wrong.sum())} samples, first {first:g}")
    return np.asarray(np.where(holes, 0.0, stated).ravel() * amount)


def _words(amount: float, kind: str, form: str, unit: str) -> str:
    size = {
        "constant": f"{amount:g}{' ' + unit if unit else ''}",
        "percent": f"{amount:g} % of each value",
        "field": f"a field of sizes{f' times {amount:g}' if amount != 1 else ''}",
    }[form]
    return f"a {kind} of {size}"


def _name(source: str, samples: Samples, term: Term, correlation: str, length: float) -> str:
    """One name for the same primitives: of one source and kind, and of one place unless the error is common."""
    parts = [source, term.kind, correlation, str(samples.components)]
    if correlation != "common":
        place = repr((samples.grid.shape, samples.grid.bounds, samples.grid.frame))
        parts.append(sha256(place.encode()).hexdigest()[:16])
    if correlation == "length":
        parts.append(f"{length:g}")
    return "stated/" + "/".join(parts)
