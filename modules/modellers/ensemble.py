"""Several fields of one thing: their mean, their spread, and how sure either is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import Accuracy, Annotated, Flag, Identity, Literal, Missing, Range, Samples, Source, Term, modeller, uniform
from modules.data.operators import Floats
from modules.data.units import linear, same
from modules.modellers._linear import flat, incoming, lattice_of

NOTHING = "it is exactly 0 in the member"
REPEATED = "of repeated measurements the mean is as sure as the spread over the root of their number"
COMMON = Missing("Error common to all members", "members tell of random differences only")
JACKKNIFE = Source(
    "Few members", "model", "estimated", "jackknife over the members; Efron and Tibshirani 1993, 11.2 [member-jackknife/1]"
)

Show = Literal["mean", "median", "spread", "smallest", "largest", "share above"]


@modeller(
    "Ensemble", output="samples", aliases=("members", "mean of fields", "average fields", "spread", "probability")
)
def ensemble(
    fields: list[Samples],
    *,
    show: Show = "mean",
    level: Annotated[float | None, Range(of="fields.range")] = None,
    members_are: Literal["possible truths", "repeated measurements"] = "possible truths",
) -> Samples:
    """The mean of several fields, or of the members that one field carries, with what their spread says of the error.

    Parameters
    ----------
    fields : two or more members on one grid; or one field whose accuracy has members, as 'Read series' gives
    show : mean; median; spread, the standard deviation of the members; smallest and largest; or share above, the part of the
        members that lie above `level` at each sample
    level : of the share above, in the unit of the fields; automatic: the middle of the range of the mean
    members_are : possible truths, any of which may be the right one, so that the spread is the error of the mean; or repeated
        measurements of one thing, whose mean is surer by the root of their number

    Raises
    ------
    ValueError : fewer than two members, members on different grids or of different quantities

    Accuracy: the members themselves go on, so that what later steps do to each is known. What each field knows of its own
    errors goes on with its share in the mean, and in common where it is common. Spread, median, extremes and shares are not
    linear: how far they hang on single members is estimated by leaving each out, and errors of the single fields end there.
    Source: JCGM 100:2008, 4.2; Efron and Tibshirani 1993.
    """
    if not fields:
        raise ValueError("nothing is wired: wire two or more members, or one field that carries members")
    first = fields[0]
    values, known = _members(fields) if len(fields) > 1 else _carried(first)
    m = len(values)
    mean = values.mean(axis=0)
    if show == "mean":
        return _mean(first, values, mean, known, members_are)
    if level is None:
        told = mean[np.isfinite(mean)]
        level = float((told.min() + told.max()) / 2) if len(told) else 0.0
    whole = _shown(values, show, level)
    left = np.stack([_shown(np.delete(values, i, axis=0), show, level) for i in range(m)]) if m > 2 else np.zeros((0, 0))
    accuracy = Accuracy((), known.missing, (), known.ended).end_from(known, f"the {show} of members is not linear in it")
    if m > 2 and show not in ("smallest", "largest"):
        error = np.sqrt((m - 1) / m * ((left - left.mean(axis=0)) ** 2).sum(axis=0))
        c, unit = first.components, "" if show == "share above" else first.unit
        term = Term(JACKKNIFE, "linear", "value", unit, np.nan_to_num(error), Identity(len(error)), components=c)
        accuracy = accuracy.add(term)
    else:
        why = "of extremes no member tells" if show in ("smallest", "largest") else "two members do not tell"
        accuracy = accuracy.miss(Missing(JACKKNIFE.name, why))
    title = {"share above": f"share of members above {level:g}"}.get(show, f"{show} of members")
    return replace(
        first,
        values=whole.reshape(first.values.shape),
        unit="" if show == "share above" else first.unit,
        name=f"{title} of {first.name}" if first.name and show != "share above" else title,
        accuracy=accuracy.miss(COMMON),
    )


def _members(fields: list[Samples]) -> tuple[Floats, Accuracy]:
    """(m, n) values in the unit of the first, and what the fields know of their mean."""
    first = fields[0]
    made, parts = [], []
    for i, one in enumerate(fields):
        if one.values.shape != first.values.shape or not one.grid.same_place(first.grid):
            raise ValueError(f"member {i + 1} lies on another grid than the first: bring it there with 'resample'")
        scale, plus = (1.0, 0.0) if same(one.unit, first.unit) else linear(one.unit, first.unit)
        made.append(scale * flat(one) + plus)
        share = uniform(lattice_of(first), scale / len(fields))
        known = incoming(one)
        for term in known.terms:
            if term.source.rigour == "exact" and not term.value.any():
                known = known.end(term, NOTHING)
        parts.append((known.push(share, unit=first.unit, components=first.components), None))
    return np.stack(made), Accuracy.join(parts)


def _carried(field: Samples) -> tuple[Floats, Accuracy]:
    """The members that a field carries, about its values; and what else it knows."""
    known = incoming(field)
    terms = [t for t in known.terms if t.kind == "members"]
    if not terms:
        raise ValueError("one field is wired and carries no members: wire two or more, or read them with 'Read series'")
    counts = {len(t.value) for t in terms}
    if len(counts) > 1:
        raise ValueError(f"the field carries ensembles of {' and '.join(map(str, sorted(counts)))} members: which is meant?")
    values = np.stack([flat(field) + sum(t.operator.apply(t.value[i]) for t in terms) for i in range(counts.pop())])
    return values, known


def _mean(first: Samples, values: Floats, mean: Floats, known: Accuracy, members_are: str) -> Samples:
    """The mean, with the members about it as a term."""
    m = len(values)
    accuracy = known
    for term in known.terms:
        if term.kind == "members":
            accuracy = accuracy.end(term, f"its members are those of the ensemble; {REPEATED}")
    factor, said = 1.0, f"{m} members about their mean"
    if members_are == "repeated measurements":
        factor, said = 1 / np.sqrt(m), f"{m} members about their mean, over the root of {m}; JCGM 100:2008, 4.2.3"
    source = Source(f"Spread of {m} members", "data", "sampled", f"{said} [ensemble-members/1]")
    off = np.nan_to_num((values - mean) * factor)
    term = Term(source, "members", "value", first.unit, off, Identity(mean.size), components=first.components)
    accuracy = accuracy.add(term).miss(COMMON)
    if m < 10:
        words = f"{m} members: a spread of so few may be off by {1 / np.sqrt(2 * (m - 1)):.0%}"
        accuracy = accuracy.flag(Flag("few members", words, "point", None))
    return replace(
        first, values=mean.reshape(first.values.shape), accuracy=accuracy,
        name=f"mean of {first.name}" if first.name else "mean",
    )  # fmt: skip


def _shown(values: Floats, show: str, level: float) -> Floats:
    match show:
        case "median":
            return np.asarray(np.median(values, axis=0))
        case "spread":
            return np.asarray(values.std(axis=0, ddof=1)) if len(values) > 1 else np.zeros(values.shape[1])
        case "smallest":
            return np.asarray(values.min(axis=0))
        case "largest":
            return np.asarray(values.max(axis=0))
    share = (values > level).mean(axis=0)
    return np.where(np.isfinite(values).all(axis=0), share, np.nan)
