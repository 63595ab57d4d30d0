"""Fields by a formula: data that is known exactly, to try a network on."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from typing import Annotated

import numpy as np

from modules.api import (
    Accuracy,
    Flag,
    Frame,
    Range,
    Samples,
    Term,
    deviation,
    exactly,
    reader,
    regular,
)
from modules.data.formula import Formula, FormulaError
from modules.data.grid import Regular
from modules.data.operators import Floats
from modules.readers._files import memory

AXES = ("x", "y", "z")


@reader("Analytic field", output="samples", aliases=("formula", "function", "test field"))
def analytic(
    *,
    formula: str = "sin(3 * x) * cos(2 * y)",
    low: tuple[float, ...] = (-1.0, -1.0),
    high: tuple[float, ...] = (1.0, 1.0),
    samples: tuple[int, ...] = (65, 65),
    unit: str = "",
    lengths: str = "",
    name: str = "field",
    time: float | None = None,
    noise: Annotated[float, Range(0, 1)] = 0.0,
    seed: int = 1,
) -> Samples:
    """A field by a formula in x, y, z and t, on a regular grid.

    Parameters
    ----------
    formula : of x, y, z and t; two or three of them with ';' between make a vector field
    low : smallest x, y[, z] of the box, in `lengths`
    high : largest x, y[, z] of the box, in `lengths`
    samples : number of samples along x, y[, z]; how many numbers there are decides whether it is a line, a map or a volume
    unit : of the values
    lengths : unit of the coordinates
    name : of the field
    time : value of t; automatic takes 0 and says nothing of time
    noise : standard deviation of Gaussian noise added to each sample, in `unit`
    seed : of the noise

    Accuracy: the samples are exact up to the rounding of float64; added noise is a term with the standard deviation
    that it was made with.
    """
    grid = _grid(low, high, samples, lengths)
    parts = [Formula.parse(one) for one in formula.split(";")] if formula.strip() else [Formula.parse(formula)]
    if len(parts) > 3:
        raise FormulaError(f"there are {len(parts)} formulas; a vector field has two or three, with ';' between")
    values, flags = _values(parts, grid, 0.0 if time is None else time)
    content = sha256(repr((formula, low, high, samples, time, noise, seed)).encode()).hexdigest()[:32]
    rows = values.size
    rule = "computed from its formula, up to the rounding of float64 (formula/1)"
    terms = [replace(exactly("Formula", "data", rows, unit=unit, rule=rule), id=f"formula-{content}/formula")]
    if noise < 0 or not np.isfinite(noise):
        raise ValueError(f"noise = {noise} must be 0 or more: it is a standard deviation")
    if noise:
        generator = np.random.default_rng([seed & 0xFFFFFFFF, int(content[:15], 16)])
        values = values + noise * generator.standard_normal(values.shape)
        rule = f"Gaussian noise of standard deviation {noise:g} was added, seed {seed} (added noise/1)"
        terms.append(deviation("Added noise", noise, rows, unit=unit, rigour="exact", rule=rule, id=f"formula-{content}/noise"))
    accuracy = Accuracy(tuple(_vector(terms, 3 if len(parts) > 1 else 1)), flags=flags)
    return Samples(grid=grid, values=values, unit=unit, name=name, accuracy=accuracy, time=time)


def _grid(low: tuple[float, ...], high: tuple[float, ...], samples: tuple[int, ...], lengths: str) -> Regular:
    n = len(samples)
    if not 1 <= n <= 3 or min(samples) < 2:
        raise ValueError(f"samples {samples} should be one to three numbers, of 2 or more each")
    if len(low) < n or len(high) < n:
        raise ValueError(f"low {low} and high {high} should have {n} numbers, as samples has")
    spans = [b - a for a, b in zip(low, high, strict=False)][:n]
    if not all(np.isfinite(s) and s > 0 for s in spans):
        raise ValueError(f"each number of high {high} should be larger than that of low {low}")
    if np.prod(samples, dtype=float) * 8 > memory() / 2:
        raise ValueError(f"{' x '.join(map(str, samples))} samples take more than half of the memory: use fewer")
    spacing = [s / (k - 1) for s, k in zip(spans, samples, strict=True)]
    return regular(tuple(reversed(samples)), spacing, low[:n], Frame(units=(lengths,) * 3))


def _values(parts: list[Formula], grid: Regular, time: float) -> tuple[Floats, tuple[Flag, ...]]:
    """(grid.shape) or (grid.shape, 3) values, and a flag where a formula has no number."""
    mesh: list[Floats] = [np.zeros(()), np.zeros(()), np.zeros(())]
    for axis, coordinates in enumerate(grid.axes):
        mesh[axis] = coordinates.reshape([-1 if axis == k else 1 for k in reversed(range(len(grid.axes)))])
    given = {**dict(zip(AXES, mesh, strict=True)), "t": np.asarray(time)}
    fields = [np.broadcast_to(part.value(given), grid.shape) for part in parts]
    if len(fields) > 1:
        fields += [np.zeros(grid.shape)] * (3 - len(fields))
        values = np.stack(fields, axis=-1)
    else:
        values = fields[0].copy()
    wrong = ~np.isfinite(values) if len(parts) == 1 else ~np.isfinite(values).all(axis=-1)
    if not wrong.any():
        return values, ()
    where = np.flatnonzero(wrong)
    first = ", ".join(f"{a} = {v:g}" for a, v in zip(AXES, grid.points()[where[0]], strict=True))
    sentence = f"the formula has no finite number at {len(where)} of {grid.count} samples, first at {first}"
    if len(where) == grid.count:
        raise FormulaError(f"{sentence}: look for a division by 0, or a root or logarithm of a negative number")
    values[wrong] = np.nan
    return values, (Flag("no number", f"{sentence}; they are holes", "point", where),)


def _vector(terms: list[Term], components: int) -> list[Term]:
    return [replace(term, components=components) for term in terms]
