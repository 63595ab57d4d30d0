"""What an output of one run is off from another run: values at points, points of level sets, particles at equal times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.verify.runs import Bench, Run
from app.verify.shapes import Level, levels_of, measure_of
from modules.data.accuracy import Accuracy, Term
from modules.data.grid import Rectilinear, Regular
from modules.data.laws import Law
from modules.data.wires import LAWS, Geometry, Model, Samples

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

LOOKED = 1_200
"""Items of an output that are looked at."""


@dataclass(frozen=True, eq=False)
class View:
    """An output of a run, ready to be held against other runs.

    Parameters
    ----------
    quantity : whose terms speak of the errors
    accuracy : at all items
    items, components : those looked at; rows are components of items
    excused : (rows,) where a flag takes the rules away
    off : (run, as the truth) -> (rows,) errors against that run; NaN where there is nothing to compare
    scale : of what is told, below which differences are rounding
    """

    quantity: str
    accuracy: Accuracy
    items: Ints
    components: int
    excused: Mask
    off: Callable[[Run, bool], Floats]
    scale: float

    @property
    def terms(self) -> tuple[Term, ...]:
        """Of the quantity, at the items."""
        return self.accuracy.select(self.quantity, "point")

    def size(self, term: Term) -> Floats:
        """(rows,) the term's numbers, with sign where it has one."""
        return np.asarray(term.error(self.items), float).ravel()

    def realised(self, term: Term, made: Floats) -> Floats:
        """(rows,) what some primitive errors amount to by the term's operator."""
        primitives = np.broadcast_to(made, (term.operator.shape[1],))
        rows = (self.items[:, None] * term.components + np.arange(term.components)).ravel()
        return np.asarray(term.operator.rows(rows) @ primitives)


def view(bench: Bench, run: Run, node: str, output: str) -> View | str:
    """The view of an output, or why there is none."""
    value = run.outputs[node][output]
    if isinstance(value, Samples):
        return _values(run, node, output, value)
    if isinstance(value, Model):
        return _between(run, node, output, value)
    if isinstance(value, Geometry):
        if not value.accuracy.select("position", "point"):
            return "it states no error of its points"
        if levels_of(value) is not None:
            return _level_set(bench, run, node, value)
        if "time" in value.values and "velocity" in value.values and "seed" in value.values and len(value.lines):
            return _traces(node, output, value)
    return "only samples, models, level sets and traces have a truth to be held against"


def _some(n: int) -> Ints:
    if n <= LOOKED:
        return np.arange(n)
    return np.sort(np.random.default_rng(5).choice(n, LOOKED, replace=False))


def _excused(accuracy: Accuracy, items: Ints, components: int) -> Mask:
    gone = np.zeros(int(items.max(initial=-1)) + 1, bool)
    for flag in accuracy.flags:
        if flag.name != "not resolvable" and flag.items is not None and flag.place == "point":
            gone[flag.items[flag.items < len(gone)]] = True
    return np.repeat(gone[items], components)


def _law(law: Law, truth: bool) -> Law:
    return LAWS["linear"] if truth and law.name == "nearest" else law


def _at(samples: Samples, law: Law, points: Floats) -> Floats:
    """(n, c) values of samples between their places; NaN outside."""
    flat = samples.values.reshape(samples.grid.count, -1).astype(float)
    low, high = np.array(samples.grid.bounds).reshape(3, 2).T
    inside = ((points >= low - 1e-9 * (high - low)) & (points <= high + 1e-9 * (high - low))).all(axis=1)
    weights = law.weights(samples.grid, points[inside])
    found = np.full((len(points), flat.shape[1]), np.nan)
    found[inside] = np.stack([weights.apply(column) for column in flat.T], axis=-1)
    return found


def _span(samples: Samples) -> float:
    finite = samples.values[np.isfinite(samples.values)]
    return float(np.abs(finite).max()) if finite.size else 0.0


def _values(run: Run, node: str, output: str, samples: Samples) -> View:
    items, c = _some(samples.grid.count), samples.components
    points = samples.grid.points()[items]
    mine = samples.values.reshape(samples.grid.count, c)[items].astype(float)

    def off(other: Run, truth: bool) -> Floats:
        there = other.outputs[node][output]
        if there.grid.shape == samples.grid.shape and there.grid.same_place(samples.grid):
            theirs = there.values.reshape(samples.grid.count, c)[items].astype(float)
        else:
            theirs = _at(there, LAWS["linear"], points)
        return np.asarray((mine - theirs).ravel())

    return View("value", samples.accuracy, items, c, _excused(samples.accuracy, items, c), off, _span(samples))


def _between(run: Run, node: str, output: str, model: Model) -> View | str:
    if not isinstance(model.grid, Regular | Rectilinear) or min(model.grid.shape) < 2:
        return f"a model on a {model.grid.kind} grid is not sampled at points"
    low, high = np.array(model.grid.bounds).reshape(3, 2).T
    points = np.random.default_rng(9).uniform(low, high, (400, 3))
    values, accuracy = model.at(points)
    mine, items, c = values.reshape(len(points), -1), np.arange(len(points)), model.samples.components

    def off(other: Run, truth: bool) -> Floats:
        there = other.outputs[node][output]
        return np.asarray((mine - _at(there.samples, _law(there.law, truth), points)).ravel())

    return View("value", accuracy, items, c, _excused(accuracy, items, c), off, _span(model.samples))


def _level_set(bench: Bench, run: Run, node: str, shape: Geometry) -> View | str:
    model = bench.model_of(node, run)
    if model is None or not isinstance(model.grid, Regular | Rectilinear) or model.samples.components != 1:
        return "its field cannot be sampled at points"
    level, measure = levels_of(shape), measure_of(model)
    assert level is not None
    items = _some(len(shape.points))
    points = shape.points[items] * (np.arange(3) < model.grid.dimensions)

    def off(other: Run, truth: bool) -> Floats:
        there = bench.model_of(node, other)
        return Level.of(there, truth, measure).distance(points, level[items])

    bounds = np.array(shape.bounds).reshape(3, 2)
    reach = float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
    excused = _excused(shape.accuracy, items, 1) | ~np.isfinite(level[items])
    return View("position", shape.accuracy, items, 1, excused, off, reach)


def _traces(node: str, output: str, shape: Geometry) -> View:
    items = _some(len(shape.points))
    seeds, times = _clock(shape)

    def off(other: Run, truth: bool) -> Floats:
        there = other.outputs[node][output]
        return np.asarray((shape.points[items] - _followed(there, seeds[items], times[items])).ravel())

    bounds = np.array(shape.bounds).reshape(3, 2)
    reach = float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
    return View("position", shape.accuracy, items, 3, _excused(shape.accuracy, items, 3), off, reach)


def _clock(shape: Geometry) -> tuple[Ints, Floats]:
    """(points,) seed and time of each."""
    seed = np.full(len(shape.points), -1, np.int64)
    of_line = np.asarray(shape.values["seed"].values)[len(shape.vertices) : len(shape.vertices) + len(shape.lines)]
    seed[shape.lines.connectivity] = np.repeat(of_line, shape.lines.sizes())
    return seed, np.asarray(shape.values["time"].values, float)


def _followed(shape: Geometry, seeds: Ints, times: Floats) -> Floats:
    """Where the particles of some seeds are at some times, by cubic pieces through positions and velocities; else NaN."""
    found = np.full((len(seeds), 3), np.nan)
    seed, clock = _clock(shape)
    velocity = np.asarray(shape.values["velocity"].values, float)
    for one in np.unique(seeds):
        rows = np.flatnonzero(seed == one)
        rows = rows[np.argsort(clock[rows], kind="stable")]
        rows = rows[np.append(True, np.diff(clock[rows]) > 0)] if len(rows) else rows
        mine = np.flatnonzero(seeds == one)
        if len(rows) < 2:
            continue
        t, x, v = clock[rows], shape.points[rows], velocity[rows]
        inside = mine[(times[mine] >= t[0]) & (times[mine] <= t[-1])]
        i = np.clip(np.searchsorted(t, times[inside], side="right") - 1, 0, len(t) - 2)
        h = (t[i + 1] - t[i])[:, None]
        u = (times[inside] - t[i])[:, None] / h
        found[inside] = (
            (1 + 2 * u) * (1 - u) ** 2 * x[i] + u**2 * (3 - 2 * u) * x[i + 1]
            + u * (1 - u) ** 2 * h * v[i] - u**2 * (1 - u) * h * v[i + 1]
        )  # fmt: skip
    return found


def named(terms: tuple[Term, ...], id: str) -> Term | None:
    """The term of that identity."""
    return next((t for t in terms if t.id == id), None)


