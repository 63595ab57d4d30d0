"""Lattices of IRIS Explorer (.lat) in its plain format: numbers as text, in one order.

After the first line come nDim, dims, nDataVar, primType, coordType, nSteps, nCoordVar (of a curvilinear lattice alone), the
coordinates and then the data of each step; the variables of a node stand together, the first dimension varies fastest.
Coordinates are a lower and an upper end for each axis (uniform), the values along each axis (perimeter), or those of each
node (curvilinear). Source: NAG, IRIS Explorer reference, ReadLat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from modules.api import Accuracy, Curvilinear, Flag, Identity, Missing, Samples, Source, Term, Unstructured, regular
from modules.data.grid import Grid, Rectilinear
from modules.data.operators import Floats
from modules.readers._files import ReadError, digest, fits, nearest
from modules.readers._text import half_digit, is_number

SUFFIXES = (".lat",)
KINDS = ("uniform", "perimeter", "curvilinear")
TYPES = ("uint8", "int16", "int32", "float32", "float64")
HEADER = "cxLattice plain"


@dataclass(frozen=True)
class Lattice:
    """What stands before the coordinates.

    Parameters
    ----------
    dims : samples along the first axis, which varies fastest, the second, ...
    variables : of each node
    type, kind : of the numbers and of the coordinates
    steps : how often the data come
    coordinates : numbers a node of a curvilinear lattice
    words : all that follows
    """

    dims: tuple[int, ...]
    variables: int
    type: str
    kind: str
    steps: int
    coordinates: int
    words: list[str]

    @property
    def names(self) -> tuple[str, ...]:
        """Of what can be read."""
        one = [f"variable {i + 1}" for i in range(self.variables)]
        one = ["vector", *one] if self.variables == 3 else one
        if self.steps == 1:
            return tuple(one)
        return tuple(f"{name}, step {s + 1}" for s in range(self.steps) for name in one)

    @property
    def places(self) -> int:
        """How many numbers say where the samples lie."""
        if self.kind == "uniform":
            return 2 * len(self.dims)
        return sum(self.dims) if self.kind == "perimeter" else math.prod(self.dims) * self.coordinates


def samples(path: Path, name: str) -> Samples:
    """One variable of one step, or the vector of three variables.

    Raises
    ------
    ReadError : not plain, too few numbers, more than three dimensions, no such variable
    """
    lattice = _lattice(path, path.read_bytes())
    names = lattice.names
    if name and name not in names:
        raise ReadError(f"{path.name!r} has no {name!r}{nearest(name, names)}; it has {', '.join(names)}")
    chosen = name or names[0]
    step = int(chosen.rpartition("step ")[2]) - 1 if "step" in chosen else 0
    nodes = math.prod(lattice.dims)
    fits(path, (*lattice.dims, lattice.variables))
    need = lattice.places + nodes * lattice.variables * lattice.steps
    if len(lattice.words) < need:
        raise ReadError(f"{path.name!r} ends after {len(lattice.words)} of {need} numbers: copy it again")
    first = lattice.places + step * nodes * lattice.variables
    words = lattice.words[first : first + nodes * lattice.variables]
    values = _numbers(path, words).reshape(nodes, lattice.variables)
    halves = np.maximum([half_digit(w) for w in words], np.spacing(np.abs(values.ravel())) / 2).reshape(values.shape)
    part = slice(None) if chosen.startswith("vector") else int(chosen.split(",")[0].split()[1]) - 1
    try:
        grid = _grid(lattice, _numbers(path, lattice.words[: lattice.places]))
    except ReadError:
        raise
    except ValueError as error:
        raise ReadError(f"{path.name!r}: {error}") from None
    extra = (3,) if chosen.startswith("vector") else ()
    own = np.ascontiguousarray(values[:, part]).reshape(*grid.shape, *extra)
    accuracy = _accuracy(lattice, np.ascontiguousarray(halves[:, part]).ravel(), f"{digest(path)}/{chosen}", 3 if extra else 1)
    time = float(step) if lattice.steps > 1 else None
    return Samples(grid=grid, values=own, name=chosen.split(",")[0], time=time, accuracy=accuracy)


def peek(path: Path) -> dict[str, Any]:
    """Names and shape, from the first numbers."""
    with path.open("rb") as file:
        lattice = _lattice(path, file.read(1 << 16))
    return {"names": lattice.names, "shape": tuple(reversed(lattice.dims))}


def _lattice(path: Path, data: bytes) -> Lattice:
    first, _, rest = data.partition(b"\n")
    if HEADER.encode() not in first:
        other = "in IRIS Explorer's other formats" if b"cxLattice" in first or b"explorer" in first.lower() else "no lattice"
        raise ReadError(f"{path.name!r} is {other}: write it as 'plain' with WriteLat, which this reads")
    lines = rest.decode("latin-1").splitlines()
    words = [word for line in lines for word in line.partition("#")[0].split()]
    taken = iter(words)

    def whole(what: str, low: int, high: int) -> int:
        word = next(taken, "")
        if not word.lstrip("+").isdecimal() or not low <= int(word) <= high:
            said = f"{word!r}" if word else "nothing more"
            raise ReadError(f"{path.name!r}: {what} should be a whole number from {low} to {high}; there is {said}")
        return int(word)

    n = whole("the number of dimensions", 1, 3)
    dims = tuple(whole("a dimension", 1, 2**31) for _ in range(n))
    variables = whole("the number of variables", 1, 1000)
    kind_of_number = TYPES[whole("the type of the data", 0, 4)]
    kind = KINDS[whole("the type of the coordinates", 0, 2)]
    steps = whole("the number of steps", 1, 100000)
    coordinates = whole("the number of coordinates", 1, 3) if kind == "curvilinear" else n
    head = 1 + n + 4 + (kind == "curvilinear")
    return Lattice(dims, variables, kind_of_number, kind, steps, coordinates, words[head:])


def _numbers(path: Path, words: list[str]) -> Floats:
    try:
        return np.array(words, float)
    except ValueError:
        bad = next(w for w in words if not is_number(w))
        raise ReadError(f"{path.name!r}: {bad[:20]!r} is not a number") from None


def _grid(lattice: Lattice, places: Floats) -> Grid:
    n, dims = len(lattice.dims), lattice.dims
    shape = tuple(reversed(dims))
    if lattice.kind == "uniform":
        low, high = places[0::2], places[1::2]
        spacing = [(b - a) / (k - 1) if k > 1 and b != a else 1.0 for a, b, k in zip(low, high, dims, strict=True)]
        return regular(shape, spacing, low)
    if lattice.kind == "perimeter":
        return Rectilinear(tuple(np.split(places, np.cumsum(dims)[:-1])))
    nodes = np.zeros((math.prod(dims), 3))
    nodes[:, : lattice.coordinates] = places.reshape(-1, lattice.coordinates)
    if n == 1:  # a row of nodes that lie anywhere: scattered points
        none = np.zeros(0, np.int64)
        return Unstructured(nodes, np.zeros(1, np.int64), none, none)
    return Curvilinear(nodes.reshape(*shape, 3))


def _accuracy(lattice: Lattice, halves: Floats, name: str, components: int) -> Accuracy:
    rule = "half a unit of the last printed digit (rounding of stored numbers/1)"
    digits = Source("Quantisation", "data", "proven", rule)
    term = Term(digits, "bound", "value", "", halves, Identity(len(halves)), components=components, id=f"{name}/quantisation")
    accuracy = Accuracy((term,), (Missing("Measurement error", "the file states none"),))
    if lattice.steps > 1:
        words = f"one of {lattice.steps} steps, taken to follow each other at times 0, 1, 2, ..., which the file does not state"
        accuracy = accuracy.flag(Flag("assumed", words))
    return accuracy
