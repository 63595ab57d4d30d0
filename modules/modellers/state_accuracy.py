"""What a person knows of the errors of data whose file says nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from hashlib import sha256
from typing import Annotated, Literal

import numpy as np

from modules.api import Identity, Range, Samples, Source, Term, modeller
from modules.data import correlation as correlated
from modules.data.fold import Kind
from modules.data.formula import Formula
from modules.data.operators import Floats
from modules.data.units import UnitError, factor


@modeller("State accuracy", output="samples", aliases=("error", "uncertainty", "survey error", "noise level"))
def state_accuracy(
    samples: Samples,
    field: Samples | None = None,
    members: list[Samples] | None = None,
    *,
    amount: Annotated[float, Range(0)] = 1.0,
    kind: Literal["standard deviation", "bound"] = "standard deviation",
    form: Literal["constant", "percent", "field", "formula", "members"] = "constant",
    formula: str = "0.01 * abs(v)",
    correlation: Literal["independent", "common", "length"] = "independent",
    length: Annotated[float, Range(0)] = 1.0,
    error: str = "Measurement error",
    basis: Literal["not said", "measured", "judged"] = "not said",
    who: str = "the user",
    source: str = "",
    answers: str = "Measurement error",
) -> Samples:
    """Adds what someone says of the errors of the samples.

    Parameters
    ----------
    field : sizes of the errors, on the same grid, in a unit of the same kind; for form "field"
    members : other realisations of the samples, on the same grid; for form "members"
    amount : size in the unit of the samples; per cent of each value for form "percent"; a factor for the other forms
    kind : standard deviation, or bound: an error that is never exceeded
    form : constant for all samples, per cent of the value, a field of sizes, a formula, or members
    formula : size at x, y, z where the value is v (its size, for a vector); for form "formula"
    correlation : independent from sample to sample; common, one error for all; or alike within a length
    length : distance at which two samples correlate by exp(-1/2), in the unit of the coordinates
    error : what the error is called
    basis : whether it was measured, or is an expert's judgement; a judgement is named as one wherever it goes
    who : who says so
    source : errors of one source name are the same errors wherever they occur; empty: these errors occur only here
    answers : the missing source that this answers and takes off the list; empty for none

    Accuracy: adds one term, estimated, whose rule names who says so and what is assumed of the correlation; the terms
    of the samples go on; those of the field end, for an error of an error is not carried.

    Source: JCGM 100:2008, 4.3 (type B evaluation); correlation exp(-d^2 / 2 length^2) made by a Gaussian of unit noise.
    """
    _check(samples, field, members, amount, form, correlation, kind, length)
    judged = f"{error}, as judged by {who}" if basis == "judged" else error
    if form == "members":
        term = _of_members(samples, members or [], amount, judged, who)
    else:
        sizes = _sizes(samples, field, amount, form, formula)
        grid = samples.grid
        value, operator = correlated.carried(grid, samples.components, sizes, correlation, length, named=bool(source))
        size, assumed = _words(amount, kind, form, samples.unit, formula), correlated.words(grid, correlation, length)
        said = Source(judged, "data", "estimated", f"{who} {VERBS[basis]} {size}; {assumed} (stated accuracy/1)")
        how: Kind = "bound" if kind == "bound" else "linear"
        term = Term(said, how, "value", samples.unit, value, operator, components=samples.components)
    if source:
        term = replace(term, id=_name(source, samples, term, correlation, length))
    if term.id in {t.id for t in samples.accuracy.terms}:
        raise ValueError(f"the errors of {source!r} are stated for these samples already: take another source name")
    missing = tuple(m for m in samples.accuracy.missing if m.name != answers or not answers)
    accuracy = replace(samples.accuracy, missing=missing).add(term)
    for other in (*([field] if field is not None else []), *(members or [])):
        accuracy = accuracy.end_from(other.accuracy, "it is an error of a stated error, which is not carried")
    return replace(samples, accuracy=accuracy)


VERBS = {"not said": "states", "measured": "measured", "judged": "judges, and did not measure,"}
"""Basis -> what was done."""


def _check(
    samples: Samples, field: Samples | None, members: list[Samples] | None, amount: float, form: str, correlation: str,
    kind: str, length: float,
) -> None:  # fmt: skip
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
    if (form == "members") != bool(members):
        count = len(members or [])
        raise ValueError(f"form is {form!r} with {count} members wired: wire members for form 'members', and only then")
    if correlation != "length":
        return
    if kind == "bound":
        raise ValueError("a bound has no correlation length: choose independent or common, or a standard deviation")
    correlated.check(samples.grid, correlation, length)


def _sizes(samples: Samples, field: Samples | None, amount: float, form: str, formula: str) -> Floats:
    """0-d, or one size per value, components fastest; 0 at holes."""
    if form == "constant":
        return np.asarray(amount)
    if form == "percent":
        flat = np.abs(samples.values.astype(float)).ravel() * (amount / 100)
        return np.asarray(np.nan_to_num(flat, nan=0.0))
    if form == "formula":
        return _by_formula(samples, formula) * amount
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
    return np.asarray(np.where(holes, 0.0, stated).ravel() * (amount * _into(field, samples)))


def _into(other: Samples, samples: Samples) -> float:
    """What brings differences of another quantity to the unit of the samples; 1 where one of them has none."""
    if not other.unit or not samples.unit:
        return 1.0
    try:
        return factor(other.unit, samples.unit)
    except UnitError as error:
        raise ValueError(f"stated errors are in {other.unit}, the samples in {samples.unit}: {error}") from None


def _by_formula(samples: Samples, text: str) -> Floats:
    points, c = samples.grid.points(), samples.components
    flat = samples.values.reshape(samples.grid.count, c).astype(float)
    size = flat[:, 0] if c == 1 else np.sqrt((flat**2).sum(axis=1))
    holes = np.isnan(size)
    names = dict(zip(("x", "y", "z", "v"), (*points.T, np.where(holes, 0.0, size)), strict=True))
    sizes = np.broadcast_to(Formula.parse(text, tuple(names)).value(names), size.shape)
    wrong = ~holes & ~(np.isfinite(sizes) & (sizes >= 0))
    if wrong.any():
        first = sizes[np.flatnonzero(wrong)[0]]
        where = f"gives no size at {int(wrong.sum())} samples, first {first:g}"
        raise ValueError(f"the formula {text!r} {where}: it must be 0 or more")
    return np.repeat(np.where(holes, 0.0, sizes), c)


def _of_members(samples: Samples, members: list[Samples], amount: float, error: str, who: str) -> Term:
    """The spread of realisations about their mean."""
    if len(members) < 2:
        raise ValueError("one member has no spread: wire two or more")
    for one in members:
        if not one.grid.same_place(samples.grid) or one.values.shape != samples.values.shape:
            raise ValueError(f"member {one.name!r} lies elsewhere than the samples: resample it first")
    found = np.stack([one.values.astype(float).ravel() * _into(one, samples) for one in members])
    holes = np.isnan(samples.values).ravel()
    if np.isnan(found[:, ~holes]).any():
        raise ValueError("a member has holes where the samples have none: fill them, or mask the samples")
    errors = np.where(holes, 0.0, (found - found.mean(axis=0)) * amount)
    times = f" times {amount:g}" if amount != 1 else ""
    rule = f"{who} gives {len(members)} realisations; their spread about their mean{times}"
    said = Source(error, "data", "sampled", f"{rule} (stated members/1)")
    return Term(said, "members", "value", samples.unit, errors, Identity(errors.shape[1]), components=samples.components)


def _words(amount: float, kind: str, form: str, unit: str, formula: str) -> str:
    size = {
        "constant": f"{amount:g}{' ' + unit if unit else ''}",
        "percent": f"{amount:g} % of each value",
        "field": f"a field of sizes{f' times {amount:g}' if amount != 1 else ''}",
        "formula": f"{formula}{f' times {amount:g}' if amount != 1 else ''}{' ' + unit if unit else ''}",
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
