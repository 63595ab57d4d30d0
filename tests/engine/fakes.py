"""Modules without science, for tests of the engine. Loaded as a user's file, so that child processes find them by name."""

from __future__ import annotations

import threading
import time
import warnings
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np

from modules.data.accuracy import EXACT, Accuracy, deviation, unknown
from modules.data.wires import ColourMap, Geometry, Model, Samples, Table, Value
from modules.declare import mapper, modeller, reader
from modules.parameters import Range
from modules.progress import Progress

fired: list[str] = []
"""Names of what fired, in this process."""

gate = threading.Event()
gate.set()
"""`held` waits for it."""


def note(name: str) -> None:
    fired.append(name)


def plain(given: Value) -> float:
    assert isinstance(given.value, int | float)
    return float(given.value)


def value(number: float, accuracy: Accuracy) -> Value:
    return Value(value=float(number), accuracy=accuracy)


@reader("Zero")
def zero() -> Value:
    """Nought.

    Accuracy: exact.
    """
    note("zero")
    return value(0, EXACT)


@reader("Constant")
def constant(*, number: Annotated[float, Range(-100, 100)] = 1.0, sigma: float = 0.0) -> Value:
    """A number.

    Accuracy: a standard deviation, if one is given.
    """
    note(f"constant {number:g}")
    return value(number, EXACT.add(deviation("stated", sigma, 1)) if sigma else EXACT)


@modeller("Add")
def add(a: Value, b: Value, *, plus: float = 0.0) -> Value:
    """The sum of two.

    Accuracy: the errors of both add.
    """
    note("add")
    return value(plain(a) + plain(b) + plus, Accuracy.join([(a.accuracy, None), (b.accuracy, None)]))


@modeller("Total")
def total(values: list[Value], extra: Value | None = None) -> Value:
    """The sum of a list.

    Accuracy: the errors of all add.
    """
    note("total")
    everything = [*values, *([extra] if extra else [])]
    return value(sum(map(plain, everything)), Accuracy.join([(v.accuracy, None) for v in everything]))


@modeller("Ordered")
def ordered(values: list[Value]) -> Value:
    """The digits of a list, first to last.

    Accuracy: the errors of all add.
    """
    number = 0.0
    for v in values:
        number = 10 * number + plain(v)
    return value(number, Accuracy.join([(v.accuracy, None) for v in values]))


@modeller("Negate", was=("user.fakes.minus",))
def negate(a: Value) -> Value:
    """The opposite.

    Accuracy: the error changes its sign.
    """
    note("negate")
    return value(-plain(a), a.accuracy)


@modeller("Slow", version=2)
def slow(a: Value, progress: Progress, *, slabs: int = 10, pause: float = 0.01) -> Value:
    """The same, after some time.

    Accuracy: unchanged.
    """
    note("slow")
    progress.map(lambda _: time.sleep(pause), range(slabs))
    note("slow ended")
    return a


@modeller("Held")
def held(a: Value, *, tag: int = 0) -> Value:
    """The same, when the gate opens.

    Accuracy: unchanged.
    """
    note(f"held {tag}")
    gate.wait(20)
    return a


@modeller("Failing")
def failing(a: Value, *, how: Literal["value", "key", "memory", "exit", "cancel", "type"] = "value") -> Value:
    """Fails.

    Accuracy: none.
    """
    note("failing")
    if how == "memory":
        raise MemoryError
    if how == "exit":
        raise SystemExit(3)
    if how == "cancel":
        from modules.progress import Cancelled

        raise Cancelled
    if how == "key":
        return dict[str, Value]()["absent"]
    if how == "type":
        return "text"  # type: ignore[return-value]  # the fault is planted
    raise ValueError(f"{plain(a):g} is not what it should be: take another")


@modeller("Warning")
def warning(a: Value) -> Value:
    """Warns.

    Accuracy: unchanged.
    """
    warnings.warn("few samples", stacklevel=1)
    np.divide(np.ones(1), np.zeros(1))
    return a


@modeller("Forgets")
def forgets(a: Value, b: Value) -> Value:
    """Takes the first and says nothing of the second.

    Accuracy: breaks the law.
    """
    return a


@modeller("Independent", independent={"value": ("b",)})
def independent(a: Value, b: Value) -> Value:
    """Takes the first, and says so.

    Accuracy: of the first.
    """
    return a


@modeller("Selects")
def selects(a: Value, b: Value) -> Value:
    """Takes the first, and ends the second.

    Accuracy: of the first.
    """
    return value(plain(a), a.accuracy.end_from(b.accuracy, "not selected"))


@modeller("Noise")
def noise(a: Value, *, sigma: float = 1.0) -> Value:
    """Two new sources of one name.

    Accuracy: adds two standard deviations.
    """
    note("noise")
    return value(plain(a), a.accuracy.add(deviation("noise", sigma, 1), deviation("noise", sigma, 1)))


class Both(NamedTuple):
    half: Value
    table: Table


@modeller("Both")
def both(a: Value) -> Both:
    """Half of it, and a table.

    Accuracy: unchanged.
    """
    note("both")
    table = Table(columns={"x": np.array([a.value])}, accuracy=a.accuracy)
    return Both(value(plain(a) / 2, a.accuracy), table)


@modeller("Uncertainty")
def uncertainty(accuracy: Accuracy) -> Value:
    """The number of sources.

    Accuracy: unchanged.
    """
    return value(len(accuracy.terms), accuracy)


@reader("Ramp")
def ramp(*, count: int = 8, seed: int = 0) -> Samples:
    """Samples along a line.

    Accuracy: not known.
    """
    note("ramp")
    return Samples.from_array(np.arange(2.0 * count).reshape(2, count) + seed, accuracy=unknown("made up"))


@modeller("Model")
def between(samples: Samples) -> Model:
    """The law between.

    Accuracy: the samples', and the law's own.
    """
    note("between")
    return Model.between(samples)


@modeller("Sum of samples")
def summed(samples: Samples) -> Value:
    """Their sum.

    Accuracy: ended here.
    """
    note("summed")
    return value(samples.values.sum(), EXACT.end_from(samples.accuracy, "counted elsewhere"))


@modeller("Model's mean")
def mean(model: Model) -> Value:
    """The mean of the model's samples.

    Accuracy: ended here.
    """
    return value(model.samples.values.mean(), EXACT.end_from(model.accuracy, "counted elsewhere"))


@modeller("Writes into its input")
def vandal(samples: Samples) -> Samples:
    """Changes what it was given.

    Accuracy: unchanged.
    """
    samples.values[0, 0] = 99.0
    return samples


@mapper("Dots")
def dots(model: Model, colours: Value | None = None) -> Geometry:
    """A point.

    Accuracy: ended here.
    """
    accuracy = EXACT.end_from(model.accuracy, "a point")
    if colours:
        accuracy = accuracy.end_from(colours.accuracy, "a point")
    return Geometry(points=np.zeros((1, 3)), accuracy=accuracy)


@reader("Number in a file", companions=lambda path: [path.with_suffix(".hdr")])
def number_file(*, path: Path = Path(), factor: float = 1.0) -> Value:
    """The number that a file holds.

    Accuracy: exact.
    """
    note("number_file")
    gate.wait(20)
    return value(float(path.read_text()) * factor, EXACT)


@reader("Files in a folder")
def number_files(*, folder: Path | None = None) -> Value:
    """How many files a folder or pattern has.

    Accuracy: exact.
    """
    note("number_files")
    return value(0 if folder is None else 1, EXACT)


@reader("Colours")
def colours() -> ColourMap:
    """Two colours.

    Accuracy: carries none.
    """
    return ColourMap("two", np.zeros((2, 3)))


@reader("Wide")
def wide(*, level: Annotated[float, Range(0.0, float("inf"))] = 1.0, levels: tuple[float, ...] | None = None,
         mode: Literal["fast", "exact"] = "fast", on: bool = True, title: str = "") -> Value:  # fmt: skip
    """Takes all kinds of settings.

    Accuracy: exact.
    """
    note("wide")
    return value(level, EXACT)
