"""Fields of known truth with known errors, and the faults of a modeller that is fed with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Model, Operator, Progress, Samples, Source, Spread, Term, bound, deviation
from modules.data.operators import stencil
from modules.modellers.interpolate import interpolate
from modules.records import Module

Floats = NDArray[np.float64]

SIGMA = 1e-6
"""Of the errors, so small that first order is all there is."""
DRAWS = 400
DEVIATION = 5 / np.sqrt(2 * DRAWS)
"""By how much a deviation counted over so many draws may be off, five times its own deviation."""

NUMBERS = np.array([[0.9, 0.5, -0.6], [-0.5, 0.8, 0.4], [0.3, -0.4, 0.7]])
"""Wave numbers along x, y, z of the plane waves: nine samples a period, or more."""


@dataclass(frozen=True)
class Field:
    """Samples of a sum of plane waves a component, and the sum itself."""

    name: str
    samples: Samples
    phases: Floats

    def value(self, points: Floats, *axes: int) -> Floats:
        """(n, components): the field at points, or its derivative after some axes."""
        numbers = NUMBERS * (np.arange(3) < len(self.samples.grid.shape))
        angle = points @ numbers.T
        factor = np.prod([numbers[:, a] for a in axes], axis=0) if axes else np.ones(3)
        waves = np.sin(angle[:, None, :] + self.phases + 0.5 * np.pi * len(axes)) * factor
        return np.asarray(waves.sum(axis=2) + (0.0 if axes else 3.0))


def _field(name: str, shape: tuple[int, ...], uneven: bool, extra: tuple[int, ...], seed: int) -> Field:
    random = np.random.default_rng(seed)
    spacing = (0.5, 0.4, 0.6)[: len(shape)]
    axes = [h * np.arange(n) for h, n in zip(spacing, reversed(shape), strict=True)]
    c = int(np.prod(extra, dtype=int))
    where: dict[str, Any] = {"spacing": spacing}
    if uneven:
        where = {"axes": [a + 0.15 * h * np.sin(1.7 * np.arange(len(a))) for a, h in zip(axes, spacing, strict=True)]}
    plain = Samples.from_array(np.zeros(shape), accuracy=Accuracy(), unit="m", name="waves", **where)
    empty = Field(name, plain, random.uniform(0, 2 * np.pi, (c, 3)))
    values = empty.value(plain.grid.points()).reshape(*shape, *extra)
    return replace(empty, samples=replace(plain, values=values))


@cache
def fields(seed: int = 0) -> tuple[Field, ...]:
    """One of each kind that a wire carries."""
    return (
        _field("line", (40,), False, (), seed + 1),
        _field("map", (12, 13), False, (), seed + 2),
        _field("uneven map", (13, 12), True, (), seed + 3),
        _field("volume", (7, 8, 9), False, (), seed + 4),
        _field("uneven volume", (8, 7, 9), True, (), seed + 5),
        _field("vectors on a map", (9, 10), False, (3,), seed + 6),
        _field("vectors in a volume", (7, 8, 9), True, (3,), seed + 7),
        _field("tensors in a volume", (6, 7, 8), False, (3, 3), seed + 8),
    )


def errors(samples: Samples, prefix: str = "") -> Accuracy:
    """Independent, common and correlated deviations, and a rounding that is bounded."""
    n, c = samples.values.size, samples.components
    lattice = samples.grid.shape if c == 1 else (*samples.grid.shape, c)
    smooth: Operator = stencil(lattice, 0, (-1, 0, 1), (0.3, 0.5, 0.2))
    for axis in range(1, len(samples.grid.shape)):
        smooth = stencil(lattice, axis, (-2, 0, 1), (0.4, 0.5, 0.1)).after(smooth)
    said = Source("correlated", "data", "estimated", "made up [test/1]")
    terms = (
        deviation("independent", SIGMA * np.linspace(0.5, 1.5, n), n, unit="m"),
        Term(replace(said, name="common"), "linear", "value", "m", np.asarray(SIGMA), Spread(n)),
        Term(said, "linear", "value", "m", np.asarray(SIGMA), smooth),
        bound("rounding", SIGMA, n, unit="m"),
    )
    return Accuracy(tuple(replace(t, id=f"{prefix}{t.name}", components=c) for t in terms))


# --- running a modeller ------------------------------------------------------------------------------------------


Run = Callable[[Mapping[str, Floats]], Any]
"""Values of each port -> what the modeller gives."""


def runner(function: Callable[..., Any], record: Module, field: Field, settings: Mapping[str, Any]) -> tuple[Run, Accuracy]:
    """The modeller as a function of the values at its ports, and the errors at all of them together."""
    ports = [p for p in record.ports if not p.optional]
    given: dict[str, Samples] = {}
    for i, port in enumerate(ports):
        other = replace(field, phases=field.phases + 0.7 * i)
        values = other.value(field.samples.grid.points()).reshape(field.samples.values.shape)
        made = replace(field.samples, values=values)
        given[port.name] = replace(made, accuracy=errors(made, f"{port.name} "))
    more = {record.progress: Progress()} if record.progress else {}

    def wired(samples: Samples, kind: type, many: bool) -> Any:
        one = interpolate(samples) if kind is Model else samples
        return [one, one] if many else one

    def run(values: Mapping[str, Floats]) -> Any:
        inputs = {
            p.name: wired(replace(given[p.name], values=given[p.name].values + values.get(p.name, 0.0)), p.type, p.many)
            for p in ports
        }
        return function(**inputs, **more, **settings)

    terms = tuple(t for samples in given.values() for t in samples.accuracy.terms)
    return run, Accuracy(terms)


@dataclass(frozen=True)
class Seen:
    """Values of an outcome, its accuracy at them, and which values a flag takes the rule away from."""

    values: Floats
    accuracy: Accuracy
    excused: NDArray[np.bool_]
    points: Floats


def seen(outcome: Any) -> Seen:
    """A model is looked at between its samples, samples at themselves; of several outputs the first."""
    outcome = outcome[0] if isinstance(outcome, tuple) else outcome
    if isinstance(outcome, Model):
        low, high = np.array(outcome.grid.bounds).reshape(3, 2).T
        points = np.random.default_rng(9).uniform(low, high, (200, 3))
        values, accuracy = outcome.at(points)
    else:
        points, values, accuracy = outcome.grid.points(), outcome.values, outcome.accuracy
    c = int(values.size // len(points))
    excused = np.zeros((len(points), c), bool)
    for flag in accuracy.flags:
        if flag.name != "not resolvable" and flag.items is not None:
            excused[flag.items] = True
    return Seen(values.astype(float).ravel(), accuracy, excused.ravel(), points)


def draw(term: Term, random: np.random.Generator) -> Floats:
    """One realisation of the primitives: normal of a deviation, even within a bound."""
    n = term.operator.shape[1]
    made = random.standard_normal(n) if term.kind == "linear" else random.uniform(-1, 1, n)
    return np.asarray(term.value * made)


# --- faults ------------------------------------------------------------------------------------------------------


def faults(function: Callable[..., Any], record: Module, field: Field, settings: Mapping[str, Any]) -> list[str]:
    """What a modeller states of errors that is not so."""
    run, before = runner(function, record, field, settings)
    plain = seen(run({}))
    alive = {t.id: t for t in plain.accuracy.terms}
    found = [
        f"the error {t.name!r} vanishes without a reason"
        for t in before.terms
        if t.id not in alive and t.id not in plain.accuracy.ended
    ]
    pairs = [(t, alive[t.id]) for t in before.terms if t.id in alive]
    known = {t.id for t in before.terms}
    own = [t for t in alive.values() if t.id not in known]
    found += _unlike_realised(run, plain, pairs, own, field)
    for _, after in pairs:
        found += _unlike_counted(after)
    return found


def _unlike_realised(run: Run, plain: Seen, pairs: list[tuple[Term, Term]], own: list[Term], field: Field) -> list[str]:
    """The very errors that were put in come out as the operators say."""
    random = np.random.default_rng(11)
    slack = sum((2 * t.error().ravel() for t in own if t.kind == "bound"), np.zeros(1))
    found = []
    for before, after in pairs:
        made = draw(before, random)
        port = before.id.rpartition(" ")[0]
        into = np.asarray(before.operator.apply(made)).reshape(field.samples.values.shape)
        out = seen(run({port: into})).values - plain.values
        said = np.asarray(after.operator.apply(np.broadcast_to(made, (after.operator.shape[1],))))
        looked = np.isfinite(out) & ~plain.excused
        scale = float(np.sqrt(np.mean(said[looked] ** 2))) if looked.any() else 0.0
        wrong = np.abs(out - said) > slack + 3e-3 * scale + 1e-13 * np.nanmax(np.abs(plain.values), initial=1.0)
        if (wrong & looked).any():
            worst = float(np.abs(out - said)[looked].max()) / max(scale, 1e-300)
            found.append(f"{before.name} errors come out otherwise: {int((wrong & looked).sum())} rows, by up to {worst:.2g}")
        if after.kind == "bound" and (np.abs(said) > after.error().ravel() * (1 + 1e-9) + 1e-18).any():
            found.append(f"the bound of {before.name} is exceeded")
    return found


def _unlike_counted(term: Term) -> list[str]:
    """The deviation that it states is that of many realisations."""
    if term.kind != "linear":
        return []
    size = term.error().ravel()
    n_out, n_in = term.operator.shape
    rows = np.unique(np.random.default_rng(2).integers(0, n_out, 300))
    made = np.random.default_rng(12).standard_normal((n_in, DRAWS)) * np.broadcast_to(term.value, (n_in,))[:, None]
    counted = np.sqrt(np.mean((term.operator.rows(rows) @ made) ** 2, axis=1))
    size = size[rows]
    off = np.abs(counted - size) > DEVIATION * size + 1e-6 * SIGMA
    return [f"{term.name}: the deviation of {int(off.sum())} rows is not that of {DRAWS} draws"] if off.any() else []


Truth = Callable[[Field, Seen, Mapping[str, Any]], Floats]
"""(field, outcome, settings) -> (rows, components) what a modeller would give of the field itself."""


def untrue(
    function: Callable[..., Any], record: Module, field: Field, settings: Mapping[str, Any], truth: Truth | None
) -> list[str]:
    """What a modeller states of errors of its own that is not so, of data without any."""
    more = {record.progress: Progress()} if record.progress else {}
    ports = [p for p in record.ports if not p.optional]
    data = {Model: interpolate(field.samples), Samples: field.samples}
    inputs = {p.name: [data[p.type]] * 2 if p.many else data[p.type] for p in ports}
    outcome = seen(function(**inputs, **more, **settings))
    own = [t for t in outcome.accuracy.terms if t.kind in ("signed", "bound")]
    if not own:
        return []
    if truth is None:
        return [f"it adds {own[0].name!r}, and nobody says what the truth would be"]
    error = outcome.values - truth(field, outcome, settings).ravel()
    signed = sum((t.error().ravel() for t in own if t.kind == "signed"), np.zeros(len(error)))
    bounds = sum((t.error().ravel() for t in own if t.kind == "bound"), np.zeros(len(error)))
    looked = np.isfinite(error) & ~outcome.excused
    rest, found = np.abs(error - signed)[looked], []
    if any(t.kind == "bound" for t in own) and (rest > bounds[looked] * (1 + 1e-9) + 1e-12).any():
        found.append(f"the bound of its own is exceeded, by up to {float((rest - bounds[looked]).max()):.2g}")
    if any(t.kind == "signed" for t in own):
        left = float(np.sqrt(np.mean(rest**2)) / max(np.sqrt(np.mean(error[looked] ** 2)), 1e-300))
        most = LEFT_BY_CUBIC if settings.get("law") == "cubic" else LEFT
        if left > most and np.abs(error[looked]).max() > 1e-12:
            found.append(f"its signed estimate leaves {left:.2f} of its error")
    return found


LEFT = 0.5
"""The most that a signed estimate may leave of an error, in root mean square, on fields whose borders count for much."""
LEFT_BY_CUBIC = 0.85
"""Of the cubic law, whose own error is far smaller."""


def twin(record: Module, function: Callable[..., Any]) -> Module:
    """The record of a modeller with another function behind it."""
    return replace(record, function=function)

