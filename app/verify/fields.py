"""Manufactured data: smooth fields of the same kind, lattice and range as what a reader gave, and on finer lattices.

A field is a sum of plane waves of fourteen samples a period or more, brought to the range of the real values, so that
levels and settings of the network keep their meaning. A lattice of fewer than five samples along each axis is a worked
cell: it keeps its own values, and the truth between them is their multilinear interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from modules.data.accuracy import Accuracy, Term
from modules.data.grid import Curvilinear, Grid, Rectilinear, Regular
from modules.data.operators import Gather, Identity, Spread
from modules.data.wires import Samples

Floats = NDArray[np.float64]

PERIOD = 14.0
"""Samples a period, at least."""
WAVES = 2.0
"""Periods along an axis, at most."""
FEWEST = 5
"""Samples along an axis from which on waves are resolved."""
MOST = {1: 2_000, 2: 6_500, 3: 9_300}
"""Samples of the manufactured lattice, by dimensions: larger ones are thinned, so that many runs stay cheap."""

NUMBERS = np.array([[0.9, 0.5, -0.6], [-0.5, 0.8, 0.4], [0.3, -0.4, 0.7]])
"""Wave numbers along x, y, z, as parts of the highest."""


@dataclass(frozen=True, eq=False)
class Manufactured:
    """A field of known truth in place of some samples.

    Parameters
    ----------
    real : what the reader gave
    base : the lattice that the study calls its own: that of the samples, or a thinner one
    seed : of the waves' phases
    """

    real: Samples
    base: Grid
    seed: int = 0

    @classmethod
    def of(cls, real: Samples, seed: int = 0) -> Manufactured:
        """With a lattice small enough for many runs."""
        return cls(real, thinned(real.grid), seed)

    @property
    def refines(self) -> bool:
        """Whether there are finer lattices of its kind."""
        return isinstance(self.base, Regular | Rectilinear | Curvilinear)

    @property
    def thinner(self) -> bool:
        """Whether it has fewer samples than the real data."""
        return self.base.count < self.real.grid.count

    def samples(self, times: int = 1) -> Samples:
        """The field on the lattice whose cells are cut in `times` along each axis, with what is stated of the real errors."""
        grid = self.base if times == 1 else finer(self.base, times)
        accuracy = self.real.accuracy
        if grid is not self.real.grid:
            accuracy = moved(accuracy, self.real.grid, grid, self.real.components)
        values = self._scaled(grid).reshape(*grid.shape, *self.real.values.shape[len(self.real.grid.shape) :])
        return replace(self.real, grid=grid, values=values, accuracy=accuracy)

    def _scaled(self, grid: Grid) -> Floats:
        """(count, components): the field in the range of the real values."""
        real = np.asarray(self.real.values, float).reshape(self.real.grid.count, -1)
        if max(self.base.shape) < FEWEST and isinstance(self.base, Regular | Rectilinear):
            return self._own(grid, real)
        columns = []
        for c in range(real.shape[1]):
            finite = real[np.isfinite(real[:, c]), c]
            low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
            here, all_of = self._waves(grid, c), self._waves(self.base, c)
            bottom, top = float(all_of.min()), float(all_of.max())
            part = (here - bottom) / (top - bottom) if top > bottom else np.zeros(len(here))
            columns.append(low + (high - low) * part)
        return np.stack(columns, axis=-1)

    def _own(self, grid: Grid, real: Floats) -> Floats:
        axes = self.base.axes  # type: ignore[attr-defined]  # a rectangle or box, as the caller has seen
        d = len(axes)
        between = RegularGridInterpolator(tuple(reversed(axes)), real.reshape(*self.base.shape, -1), method="linear")
        return np.asarray(between(grid.points()[:, :d][:, ::-1]))

    def _waves(self, grid: Grid, component: int) -> Floats:
        """(count,) the sum of plane waves at the samples of a grid, before it is brought to a range."""
        low, high = np.array(self.base.bounds).reshape(3, 2).T
        size = np.where(high > low, high - low, 1.0)
        n = _along(self.base)
        periods = np.where(n >= FEWEST, np.minimum(WAVES, (n - 1) / PERIOD), 0.0)
        phases = np.random.default_rng([self.seed, component]).uniform(0, 2 * np.pi, 3)
        u = (grid.points() - low) / size
        waves = np.sin(2 * np.pi * (u * periods) @ NUMBERS.T + phases).sum(axis=1)
        return np.asarray(waves + u @ np.where((periods == 0) & (high > low), [0.4, 0.3, 0.2], 0.0))


def _along(grid: Grid) -> Floats:
    """(3,) samples along x, y, z; of an unstructured grid as if they were spread evenly."""
    if len(grid.shape) == grid.dimensions:
        return np.array([*reversed(grid.shape), 1, 1][:3], float)
    return np.array([grid.count ** (1 / grid.dimensions)] * grid.dimensions + [1.0, 1.0])[:3]


def thinned(grid: Grid) -> Grid:
    """The grid, or one of the same ends with fewer samples along each axis."""
    most = MOST.get(grid.dimensions, MOST[3])
    if grid.count <= most or not isinstance(grid, Regular | Rectilinear):
        return grid
    ratio = (most / grid.count) ** (1 / len(grid.shape))
    shape = [max(min(n, FEWEST), int(n * ratio)) for n in reversed(grid.shape)]
    axes = [np.interp(np.linspace(0, len(a) - 1, n), np.arange(len(a)), a) for a, n in zip(grid.axes, shape, strict=True)]
    return _of_axes(grid, axes)


def finer(grid: Grid, times: int) -> Grid:
    """The lattice with each cell cut in `times` along each axis; the samples of the first are among its own."""
    if isinstance(grid, Curvilinear):
        nodes = grid.nodes
        for axis in range(nodes.ndim - 1):
            nodes = _cut(nodes, axis, times)
        return Curvilinear(nodes=nodes, frame=grid.frame)
    assert isinstance(grid, Regular | Rectilinear)
    return _of_axes(grid, [_cut(a, 0, times) for a in grid.axes])


def _cut(values: Floats, axis: int, times: int) -> Floats:
    a = np.moveaxis(values, axis, 0)
    t = (np.arange(times) / times).reshape(1, -1, *[1] * (a.ndim - 1))
    inner = (a[:-1, None] * (1 - t) + a[1:, None] * t).reshape(-1, *a.shape[1:])
    return np.moveaxis(np.concatenate([inner, a[-1:]]), 0, axis)


def _of_axes(grid: Regular | Rectilinear, axes: list[Floats]) -> Grid:
    if isinstance(grid, Rectilinear):
        return Rectilinear(tuple(axes), frame=grid.frame)
    spacing = tuple(
        float(a[-1] - a[0]) / (len(a) - 1) if len(a) > 1 else h for a, h in zip(axes, grid.spacing, strict=True)
    )
    return Regular(tuple(len(a) for a in reversed(axes)), spacing, grid.origin, frame=grid.frame)


# --- what is stated of the real errors, on another lattice -----------------------------------------------------------


def moved(accuracy: Accuracy, old: Grid, new: Grid, components: int) -> Accuracy:
    """The terms of samples as they would be on another lattice of the same ends: the nearest sample's sizes.

    Errors that are alike within a length are taken as independent there; runs with noise keep to the first lattice
    wherever it was not thinned.
    """
    nearest = _nearest(old, new)
    rows = (nearest[:, None] * components + np.arange(components)).ravel()
    terms = tuple(_moved(t, rows, components) for t in accuracy.terms if t.place == "point")
    return Accuracy(terms, accuracy.missing, (), accuracy.ended).end_from(accuracy, "it belongs to the cells of the real data")


def _nearest(old: Grid, new: Grid) -> NDArray[np.int64]:
    """(new.count,) the old sample at the same part of each axis."""
    parts = [
        np.rint(np.linspace(0, n_old - 1, n_new)).astype(np.int64) for n_old, n_new in zip(old.shape, new.shape, strict=True)
    ]
    return np.asarray(np.ravel_multi_index(np.meshgrid(*parts, indexing="ij"), old.shape)).ravel()


def _moved(term: Term, rows: NDArray[np.int64], components: int) -> Term:
    operator: Any = term.operator
    n = len(rows)
    if isinstance(operator, Spread):
        return replace(term, operator=Spread(n))
    if isinstance(operator, Gather) and operator.n_in == components:
        weight = operator.weight if operator.weight.ndim == 0 else operator.weight[rows]
        return replace(term, operator=Gather(operator.index[rows], weight, components))
    if isinstance(operator, Identity):
        value = term.value if term.value.ndim == 0 else term.value[..., rows]
        return replace(term, value=value, operator=Identity(n))
    size = term.error().ravel()[rows]
    if term.kind == "members":
        members = np.stack([operator.apply(m)[rows] for m in term.value])
        return replace(term, value=members, operator=Identity(n))
    return replace(term, value=np.abs(size) if term.kind == "linear" else size, operator=Identity(n))
