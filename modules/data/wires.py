"""What travels on a wire. Each value carries its accuracy; to leave it out is an error of the program.

Samples    data on a grid                    Layer      a shape and how it looks
Model      samples and the law between them  Scene      the layers of one view
Geometry   points, lines, polygons           Table, Value, ColourMap
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modules.data.accuracy import Accuracy, Flag, Missing, Term
from modules.data.cubic import Cubic
from modules.data.geometry import Geometry
from modules.data.grid import Curvilinear, Frame, Grid, Rectilinear, Unstructured, lattice_of, regular
from modules.data.laws import Law, Linear, Nearest, corner_max
from modules.data.memo import memo
from modules.data.operators import Floats, Gather, Identity
from modules.data.scene import ColourMap, Layer, Scene, Text

LAWS: Mapping[str, Law] = {law.name: law for law in (Nearest(), Linear(), Cubic())}
"""By the name that a user writes."""

TOO_FEW = "not estimated where fewer than three samples in a row tell"

__all__ = ["ColourMap", "Geometry", "Layer", "Model", "Samples", "Scene", "Table", "Text", "Value"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Samples:
    """Data on a grid: the thesis's raw data with its accuracy raw data.

    Parameters
    ----------
    grid : where the samples lie
    values : grid.shape for a scalar, (..., 3) for a vector, (..., 3, 3) for a tensor; NaN is a hole
    unit, name : of the quantity
    accuracy : what is known of the values' errors; rows are samples, components fastest
    time : of the data, if it has one
    """

    FACTS: ClassVar[tuple[str, ...]] = ("range", "shape", "bounds", "names", "times", "unit", "kind")

    grid: Grid
    values: Floats
    unit: str = ""
    name: str = ""
    accuracy: Accuracy
    time: float | None = None

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.dtype.kind not in "fiub":
            raise ValueError(f"samples are numbers, not {values.dtype}")
        values = values.astype(values.dtype.newbyteorder("="), copy=False)
        extra = values.shape[len(self.grid.shape) :]
        if values.shape[: len(self.grid.shape)] != self.grid.shape or extra not in ((), (3,), (3, 3)):
            raise ValueError(
                f"values of shape {values.shape} do not fit a grid of {self.grid.shape}: a scalar has that shape, "
                "a vector one more axis of 3, a tensor two"
            )
        object.__setattr__(self, "values", values)
        counts = {"point": self.grid.count, "cell": self.grid.cells}
        object.__setattr__(self, "accuracy", self.accuracy.carried("Samples", counts))

    @classmethod
    def from_array(
        cls,
        values: ArrayLike,
        *,
        spacing: ArrayLike | None = None,
        origin: ArrayLike | None = None,
        axes: Sequence[ArrayLike] | None = None,
        unit: str = "",
        name: str = "",
        accuracy: Accuracy,
        frame: Frame | None = None,
        vector: bool | None = None,
    ) -> Samples:
        """Samples from an array [z, y, x]; spacing, origin and axes are in x, y, z.

        Parameters
        ----------
        values : a scalar array of 1 to 3 axes, or a vector array (..., 3), tensor array (..., 3, 3)
        spacing, origin : of a regular grid; 1 and 0 by default
        axes : coordinates along x, y[, z] for a rectilinear grid, instead of spacing and origin
        vector : whether the last axis of 3 is the components of a vector; by default it is when there are four axes
        """
        array = np.asarray(values)
        components = 0
        if vector or (vector is None and array.ndim >= 4):
            components = 2 if array.ndim >= 5 else 1
        shape = array.shape[: array.ndim - components]
        grid: Grid
        if axes is not None:
            if spacing is not None or origin is not None:
                raise ValueError("give axes, or spacing and origin; not both")
            grid = Rectilinear(tuple(np.asarray(a, float) for a in axes), frame=frame or Frame())
        else:
            grid = regular(shape, spacing, origin, frame)
        return cls(grid=grid, values=array, unit=unit, name=name, accuracy=accuracy)

    @property
    def components(self) -> int:
        """1 for a scalar, 3 for a vector, 9 for a tensor."""
        return math.prod(self.values.shape[len(self.grid.shape) :])

    def facts(self) -> dict[str, Any]:
        """Cheap facts for panels: range, shape, bounds, names, times, unit, kind."""
        finite = self.values[np.isfinite(self.values)] if self.values.dtype.kind == "f" else self.values.ravel()
        return {
            "range": (float(finite.min()), float(finite.max())) if finite.size else None,
            "shape": self.grid.shape,
            "bounds": self.grid.bounds,
            "names": (self.name,),
            "times": () if self.time is None else (self.time,),
            "unit": self.unit,
            "kind": self.grid.kind,
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Model:
    """Samples and the law between them: a value anywhere, with what is known of its error there.

    Parameters
    ----------
    samples : the data
    law : weights between samples, and the law's own error
    accuracy : the samples' terms, and the law's own term per cell
    """

    FACTS: ClassVar[tuple[str, ...]] = ("range", "shape", "bounds", "unit", "law", "kind")

    samples: Samples
    law: Law
    accuracy: Accuracy

    def __post_init__(self) -> None:
        counts = {"point": self.samples.grid.count, "cell": self.samples.grid.cells}
        object.__setattr__(self, "accuracy", self.accuracy.carried("Model", counts))

    @classmethod
    def between(cls, samples: Samples, law: str = "linear") -> Model:
        """The model of a law by name, its own error estimated per cell from the samples.

        Raises
        ------
        ValueError : unknown law, or a grid that the law cannot sample
        """
        if law not in LAWS:
            raise ValueError(f"there is no law {law!r}: laws are {', '.join(LAWS)}")
        chosen = LAWS[law]
        return cls(samples=samples, law=chosen, accuracy=_with_own_cells(samples, chosen))

    @property
    def grid(self) -> Grid:
        """Where the samples lie."""
        return self.samples.grid

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return self.samples.unit

    @property
    def own(self) -> Term | None:
        """The law's own term, per cell; None where the law states none."""
        return next((t for t in self.accuracy.terms if t.source == self.law.source and t.place == "cell"), None)

    def at(self, points: ArrayLike) -> tuple[Floats, Accuracy]:
        """Values at points, and their accuracy: the samples' terms through the law's weights, and the law's own term.

        Parameters
        ----------
        points : (n, 3) float, in the grid's frame

        Returns
        -------
        (n,) or (n, 3) float values; Accuracy with n rows

        Raises
        ------
        ValueError : a point lies outside the grid
        """
        where = np.asarray(points, float).reshape(-1, 3)
        weights = self.law.weights(self.grid, where)
        flat = self.samples.values.reshape(self.grid.count, -1).astype(float, copy=False)
        values = np.stack([weights.apply(column) for column in flat.T], axis=-1)
        accuracy = self._through(weights)
        own = self.own
        if own is not None:
            errors = [self._own_error(where, flat[:, c]) for c in range(flat.shape[1])]
            accuracy = _with_own(accuracy, own, np.stack(errors, axis=-1))
        return values.reshape(len(where), *self.samples.values.shape[len(self.grid.shape) :]), accuracy

    def gradient(self, points: ArrayLike) -> tuple[Floats, Accuracy]:
        """Gradient of a scalar model at points, and its accuracy.

        Parameters
        ----------
        points : (n, 3) float

        Returns
        -------
        (n, 3) float, in unit / length; 0 along axes that the grid does not have; Accuracy with 3 components a row

        Raises
        ------
        ValueError : the samples are not scalar, or a point lies outside the grid
        """
        if self.samples.components != 1:
            raise ValueError("the gradient of a vector model is a tensor: use the gradient modeller")
        where = np.asarray(points, float).reshape(-1, 3)
        slopes = self.law.slopes(self.grid, where)
        flat = self.samples.values.ravel().astype(float, copy=False)
        values = np.zeros((len(where), 3))
        for axis, slope in enumerate(slopes):
            values[:, axis] = slope.apply(flat)
        accuracy = self._through(_interleaved(slopes, len(where), self.grid.count))
        terms = tuple(
            Term(t.source, t.kind, "gradient", t.unit, t.value, t.operator, "point", 3, t.id) for t in accuracy.terms
        )
        gradient = Accuracy(terms, accuracy.missing, (), accuracy.ended)
        if self.own is not None:
            gradient = gradient.miss(Missing("Interpolation error of the gradient", "only that of values is estimated"))
            why = "an error of values between samples says nothing of slopes"
            gradient = gradient.end_from(Accuracy((self.own,)), why)
        return values, gradient

    def _through(self, weights: Gather) -> Accuracy:
        per_sample = [t for t in self.accuracy.terms if t.place == "point"]
        c = self.samples.components
        operator = weights if c == 1 else by_component(weights, c)
        terms = tuple(t.push(operator) for t in per_sample)
        return Accuracy(terms, self.accuracy.missing, (), self.accuracy.ended)

    def _own_error(self, where: Floats, values: Floats) -> Floats:
        return self.law.error(self.grid, values.reshape(self.grid.shape), where)

    def facts(self) -> dict[str, Any]:
        """Cheap facts for panels: range, shape, bounds, unit, law, kind."""
        known = memo(self.samples, "facts", self.samples.facts)
        return {**{k: known[k] for k in ("range", "shape", "bounds", "unit", "kind")}, "law": self.law.name}


@dataclass(frozen=True, eq=False, kw_only=True)
class Table:
    """Columns of equal length.

    Parameters
    ----------
    columns : name -> (n,) values
    units : name -> unit, where there is one
    accuracy : rows are the table's rows; a term's quantity is the column's name
    """

    FACTS: ClassVar[tuple[str, ...]] = ("names", "rows")

    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = ""
    accuracy: Accuracy

    def __post_init__(self) -> None:
        lengths = {name: len(c) for name, c in self.columns.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"columns have different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
        rows = next(iter(lengths.values()), 0)
        object.__setattr__(self, "accuracy", self.accuracy.carried("Table", {"point": rows}))

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values()), ()))

    def facts(self) -> dict[str, Any]:
        """Names of the columns, number of rows."""
        return {"names": tuple(self.columns), "rows": self.rows}


@dataclass(frozen=True, eq=False, kw_only=True)
class Value:
    """One number, text or short list, which may be wired to a parameter.

    Parameters
    ----------
    value : what the parameter takes
    accuracy : one row
    """

    FACTS: ClassVar[tuple[str, ...]] = ("value", "unit")

    value: bool | int | float | str | tuple[Any, ...]
    unit: str = ""
    name: str = ""
    accuracy: Accuracy

    def __post_init__(self) -> None:
        object.__setattr__(self, "accuracy", self.accuracy.carried("Value", {"point": 1}))

    def facts(self) -> dict[str, Any]:
        """The value and its unit."""
        return {"value": self.value, "unit": self.unit}


def _with_own_cells(samples: Samples, law: Law) -> Accuracy:
    """The samples' accuracy and the law's own error per cell: a size that no sample states, so it is estimated."""
    if isinstance(samples.grid, Unstructured):
        return samples.accuracy.miss(Missing(law.source.name, "not estimated on an unstructured grid"))
    grid = lattice_of(samples.grid) if isinstance(samples.grid, Curvilinear) else samples.grid
    flat = samples.values.reshape(grid.count, -1).astype(float, copy=False)
    largest = np.zeros(grid.cells)
    for column in flat.T:
        lattice = column.reshape(grid.shape)
        error = law.largest(grid, lattice)
        error[np.isnan(corner_max(lattice).ravel())] = 0.0  # a hole: there is no model
        largest = np.hypot(largest, error)
    sizes = np.nan_to_num(largest, nan=0.0)
    own = Term(law.source, "bound", "value", samples.unit, sizes, Identity(len(sizes)), "cell")
    accuracy = samples.accuracy.add(own)
    if np.isnan(largest).any():
        return accuracy.miss(Missing(law.source.name, TOO_FEW))
    return accuracy


def _with_own(accuracy: Accuracy, own: Term, error: Floats) -> Accuracy:
    """The law's own signed error at points added to an accuracy, under the identity of the model's own term."""
    unknown = np.isnan(error).any(axis=1)
    flat = np.nan_to_num(error, nan=0.0).ravel()
    term = Term(
        own.source, "signed", own.quantity, own.unit, flat, Identity(len(flat)), "point", error.shape[1], own.id
    )  # fmt: skip
    accuracy = accuracy.add(term)
    if unknown.any():
        accuracy = accuracy.miss(Missing(own.source.name, TOO_FEW)).flag(
            Flag("not resolvable", "too few samples around to estimate the interpolation", "point", np.flatnonzero(unknown))
        )
    return accuracy


def by_component(weights: Gather, c: int) -> Gather:
    """Weights of scalar samples made weights of interleaved components."""
    n, k = weights.index.shape
    index = (weights.index[:, None, :] * c + np.arange(c)[None, :, None]).reshape(n * c, k)
    weight = weights.weight if weights.weight.ndim == 0 else np.repeat(weights.weight, c, axis=0)
    return Gather(index, weight, weights.n_in * c)


def _interleaved(slopes: Sequence[Gather], n: int, n_in: int) -> Gather:
    """Three rows a point, from one operator per axis; axes that the grid does not have give 0."""
    k = slopes[0].index.shape[1]
    index, weight = np.zeros((n, 3, k), np.int64), np.zeros((n, 3, k))
    for axis, slope in enumerate(slopes):
        index[:, axis], weight[:, axis] = slope.index, slope.weight
    return Gather(index.reshape(-1, k), weight.reshape(-1, k), n_in)
