"""What a person knows of the errors of data whose file says nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from hashlib import sha256
from typing import Annotated, Literal

import numpy as np

from modules.api import (
    Gather,
    Identity,
    Operator,
    Range,
    Rectilinear,
    Regular,
    Samples,
    Source,
    Spread,
    Stencil,
    Term,
    modeller,
    scaling,
)
from modules.data.fold import Kind
from modules.data.operators import Floats, Ints

REACH = 3.0
"""Correlation lengths after which a weight is left out; it is exp(-9) there."""


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
    value, operator = _operator(samples, sizes, correlation, length, named=bool(source))
    size, assumed = _words(amount, kind, form, samples.unit), _assumed(samples, correlation, length)
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
    if not isinstance(samples.grid, Regular | Rectilinear):
        raise ValueError(f"a correlation length needs a regular or rectilinear grid, not a {samples.grid.kind} one")
    if not (math.isfinite(length) and length > 0):
        raise ValueError(f"length = {length} must be more than 0: choose 'independent' for none")
    samples.grid.frame.length_unit(samples.grid.dimensions)


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


def _operator(samples: Samples, sizes: Floats, correlation: str, length: float, named: bool) -> tuple[Floats, Operator]:
    """Primitive sizes, and how they reach the samples. A named source has primitives of size 1 everywhere."""
    c = samples.components
    rows = samples.grid.count * c
    one = np.asarray(1.0)
    if correlation == "independent":
        if not named:
            return sizes, Identity(rows)
        return one, _weighted(np.arange(rows), sizes, rows)
    if correlation == "common":
        if c == 1 and not named and not sizes.ndim:
            return sizes, Spread(rows)
        return one, _weighted(np.arange(rows) % c, sizes, c)
    chain = _correlated(samples, length)
    if not sizes.ndim and not named:
        return sizes, chain
    return one, (scaling(sizes) if sizes.ndim else _weighted(np.arange(rows), sizes, rows)).after(chain)


def _weighted(index: Ints, sizes: Floats, n_in: int) -> Gather:
    return Gather(index[:, None], sizes[:, None] if sizes.ndim else sizes, n_in)


def _correlated(samples: Samples, length: float) -> Operator:
    """Unit noise on a lattice of half the length, smoothed by a Gaussian along each axis to deviation 1 at each sample."""
    grid = samples.grid
    assert isinstance(grid, Regular | Rectilinear)
    weights = [_gaussian(axis, length) for axis in reversed(grid.axes)]
    extra = (samples.components,) if samples.components > 1 else ()
    lattice = [w[2] for w in weights] + list(extra)
    operator: Operator | None = None
    for axis, (columns, values, _) in enumerate(weights):
        step = Stencil(tuple(lattice), axis, columns, values)
        lattice[axis] = len(columns)
        operator = step if operator is None else step.after(operator)
    assert operator is not None
    return operator


def _gaussian(axis: Floats, length: float) -> tuple[Ints, Floats, int]:
    """Columns, weights and number of primitives along an axis: rows of norm 1, so that each sample has deviation 1.

    Primitives lie half a length apart; sums of such a Gaussian over them differ from its integral by 5e-9.
    """
    step = length / 2
    wide = math.ceil(REACH * length / step)
    position = (axis - axis[0]) / step
    nearest = np.rint(position).astype(np.int64)
    offsets = np.arange(-wide, wide + 1)
    columns = nearest[:, None] + offsets + wide
    weights = np.exp(-(((position[:, None] - nearest[:, None] - offsets) * step / length) ** 2))
    return columns, weights / np.sqrt((weights**2).sum(axis=1, keepdims=True)), int(columns.max()) + 1


def _words(amount: float, kind: str, form: str, unit: str) -> str:
    size = {
        "constant": f"{amount:g}{' ' + unit if unit else ''}",
        "percent": f"{amount:g} % of each value",
        "field": f"a field of sizes{f' times {amount:g}' if amount != 1 else ''}",
    }[form]
    return f"a {kind} of {size}"


def _assumed(samples: Samples, correlation: str, length: float) -> str:
    unit = samples.grid.frame.units[0]
    return {
        "independent": "assumed to be independent from sample to sample",
        "common": "assumed to be one error, common to all samples",
        "length": f"assumed to correlate as exp(-d²/2L²), L = {length:g}{' ' + unit if unit else ''}",
    }[correlation]


def _name(source: str, samples: Samples, term: Term, correlation: str, length: float) -> str:
    """One name for the same primitives: of one source and kind, and of one place unless the error is common."""
    parts = [source, term.kind, correlation, str(samples.components)]
    if correlation != "common":
        place = repr((samples.grid.shape, samples.grid.bounds, samples.grid.frame))
        parts.append(sha256(place.encode()).hexdigest()[:16])
    if correlation == "length":
        parts.append(f"{length:g}")
    return "stated/" + "/".join(parts)
