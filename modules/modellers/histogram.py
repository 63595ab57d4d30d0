"""How many samples of a field lie in each class of values, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from modules.api import Accuracy, Annotated, Identity, Literal, Range, Samples, Source, Table, Term, modeller
from modules.data.adjoint import sums
from modules.data.operators import Floats
from modules.data.units import product
from modules.modellers._linear import flat, incoming
from modules.modellers._statistic import Statistic, bounds_of, deviation_of, total

ACROSS = Source(
    "Bounds across classes", "model", "proven",
    "samples whose bounds reach over an end of the class, or into it [class-bounds/1]",
)  # fmt: skip
ENDED = "samples that it may carry to another class are counted by 'Bounds across classes'"
MOST = 100_000


@modeller(
    "Histogram", output="table", aliases=("distribution", "frequency", "bins", "classes", "cumulative", "hypsometry")
)
def histogram(
    samples: Samples,
    *,
    classes: Annotated[int, Range(2, 200)] = 30,
    low: Annotated[float | None, Range(of="samples.range")] = None,
    high: Annotated[float | None, Range(of="samples.range")] = None,
    measure: Literal["count", "share", "density"] = "count",
    cumulative: bool = False,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
) -> Table:
    """Samples counted by value in classes of equal width, with the error of each count: a table for 'chart'.

    The table has the middle, the ends, and the count of each class, its total error, and the count less and more that error.
    A sample on the border of two classes counts in the upper one, in the last class also at its upper end. Holes do not count.

    Parameters
    ----------
    samples : single numbers
    classes : how many
    low, high : ends of the first and last class; automatic: the smallest and the largest sample
    measure : count of samples; share of all samples; or density, share over the width of a class
    cumulative : all samples from the lowest on, up to the upper end of each class
    k : standard deviations that spreads count with in the columns of the total

    Raises
    ------
    ValueError : vectors, no number at all, or ends the wrong way round

    Accuracy: deviations move samples over the ends of classes: as many as lie there, by kernels of half a deviation, which is
    exact for independent errors of an even density; errors in common move all alike. Bounds become a proven bound of the count
    and end in it; signed estimates and members are counted again. The field's counts are those of its samples, not of a volume.
    Source: binomial variance of a count near the end of a class, and kernel density, Silverman 1986, 2.4.
    """
    if samples.components != 1:
        raise ValueError("a histogram is of single numbers: take a component, or a length, with 'calculator'")
    if not 1 <= classes <= MOST:
        raise ValueError(f"classes = {classes} should be from 1 to {MOST}")
    values = flat(samples)
    told = values[np.isfinite(values)]
    if not len(told):
        raise ValueError("the field has no number at all: every sample is a hole")
    first = float(told.min()) if low is None else low
    last = float(told.max()) if high is None else high
    if not (np.isfinite([first, last]).all() and first <= last):
        raise ValueError(f"low = {first:g} is above high = {last:g}")
    if first == last:
        first, last = first - 0.5 * (abs(first) or 1.0) * 1e-3, last + 0.5 * (abs(last) or 1.0) * 1e-3
    edges = np.linspace(first, last, classes + 1)
    scale = {"count": 1.0, "share": 1 / len(told), "density": classes / (last - first) / len(told)}[measure]
    unit = {"count": "", "share": "", "density": product("", samples.unit, -1)}[measure]

    def counted(field: Floats) -> Floats:
        found = np.histogram(field[np.isfinite(field)], edges)[0].astype(float)
        if cumulative:
            found = np.cumsum(found) + float((field < edges[0]).sum())
        return np.asarray(found * scale)

    counts = counted(values)
    accuracy = _errors(samples, values, edges, counts, counted, cumulative, scale, unit, measure)
    error = total(accuracy, k, measure, classes)
    columns = {
        samples.name or "value": (edges[:-1] + edges[1:]) / 2 if not cumulative else edges[1:],
        measure: counts,
        "low": edges[:-1],
        "high": edges[1:],
        "total error": error,
        f"{measure} less error": np.maximum(counts - error, 0.0),
        f"{measure} and error": counts + error,
    }
    units = {name: samples.unit for name in (samples.name or "value", "low", "high") if samples.unit}
    units |= {name: unit for name in (measure, "total error", f"{measure} less error", f"{measure} and error") if unit}
    title = f"histogram of {samples.name}" if samples.name else "histogram"
    return Table(columns=columns, units=units, name=title, accuracy=accuracy)


def _errors(
    samples: Samples, values: Floats, edges: Floats, counts: Floats, counted: Statistic, cumulative: bool, scale: float,
    unit: str, quantity: str,
) -> Accuracy:
    noise = deviation_of(samples)
    before, terms = incoming(samples), []
    for term in before.terms:
        if term.kind == "linear":
            weights = _weights(values, noise, edges, cumulative, scale)
            terms.append(replace(term, operator=sums(term.operator, weights), quantity=quantity, unit=unit))
        elif term.kind != "bound":
            effects = np.broadcast_to(term.value, (term.value.shape[0] if term.value.ndim == 2 else 1, term.operator.shape[1]))
            moved = [counted(values + term.operator.apply(e)) - counts for e in effects]
            if term.kind == "signed":
                moved = [counts - counted(values - term.operator.apply(effects[0]))]
            value = np.stack(moved) if term.kind == "members" else moved[0]
            terms.append(replace(term, value=value, operator=Identity(len(counts)), quantity=quantity, unit=unit))
    accuracy = before
    for term in before.terms:
        if term.kind == "bound":
            accuracy = accuracy.end(term, ENDED)
    accuracy = Accuracy(tuple(terms), before.missing, (), accuracy.ended)
    bounds = bounds_of(samples)
    if not bounds.any():
        return accuracy
    across = _across(values, bounds, edges, cumulative) * scale
    return accuracy.add(Term(ACROSS, "bound", quantity, unit, across, Identity(len(counts))))


def _weights(values: Floats, noise: Floats, edges: Floats, cumulative: bool, scale: float) -> Iterator[Floats]:
    """For each class (n,) by how much it gains when a sample rises: what crosses its lower end less what crosses its upper."""
    told = np.flatnonzero(np.isfinite(values) & (noise > 0))
    order = told[np.argsort(values[told], kind="stable")]
    ranked, reach = values[order], 3 * float(noise[told].max(initial=0.0))

    def crossing(edge: float) -> Floats:
        found = np.zeros(len(values))
        near = order[np.searchsorted(ranked, edge - reach) : np.searchsorted(ranked, edge + reach)]
        wide = noise[near] / 2
        found[near] = scale * np.exp(-0.5 * ((values[near] - edge) / wide) ** 2) / (np.sqrt(2 * np.pi) * wide)
        return found

    below = crossing(edges[0])
    for edge in edges[1:]:
        above = crossing(edge)
        yield -above if cumulative else below - above
        below = above


def _across(values: Floats, bounds: Floats, edges: Floats, cumulative: bool) -> Floats:
    """How many samples may enter or leave each class within their bounds, the larger of both."""
    told = np.isfinite(values)
    low, high, here = (values - bounds)[told], (values + bounds)[told], values[told]
    result = np.empty(len(edges) - 1)
    for j, (a, b) in enumerate(pairwise(edges)):
        a = -np.inf if cumulative else a
        top = j == len(result) - 1
        inside = (here >= a) & ((here <= b) if top else (here < b))
        may = (high >= a) & ((low <= b) if top else (low < b))
        surely = (low >= a) & ((high <= b) if top else (high < b))
        result[j] = max(int((may & ~inside).sum()), int((inside & ~surely).sum()))
    return result
