"""A model sampled on another lattice: a small matrix along each axis, and the law's own error there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import (
    Accuracy,
    Flag,
    Grid,
    Identity,
    Missing,
    Model,
    Operator,
    Progress,
    Rectilinear,
    Regular,
    Samples,
    Stencil,
    Term,
)
from modules.data.grid import Axial
from modules.data.laws import locate
from modules.data.operators import Floats
from modules.data.wires import TOO_FEW, by_component
from modules.modellers._linear import axial, dimension, extra_of, flat, lattice_of

BLOCK = 1 << 16
"""Points that are looked at together."""


def sampled(model: Model, grid: Grid, progress: Progress) -> Samples:
    """The model at the samples of another grid, with the law's own error there.

    Raises
    ------
    ValueError : the grid reaches beyond the model's
    """
    source, samples = axial(model.samples, "sampling"), model.samples
    boxes = isinstance(grid, Regular | Rectilinear) and len(grid.shape) == len(source.shape)
    operator = _by_axes(model, source, grid) if boxes else _by_points(model, source, grid)
    progress(0.1)
    terms = tuple(t.push(operator) for t in model.accuracy.select(place="point"))
    result = Samples(
        grid=grid,
        values=np.asarray(operator.apply(flat(samples))).reshape(*grid.shape, *extra_of(samples)),
        unit=samples.unit,
        name=samples.name,
        accuracy=Accuracy(terms, model.accuracy.missing, (), model.accuracy.ended),
        time=samples.time,
    )
    progress(0.4)
    result = _with_law(result, model, progress.part(0.4, 1.0))
    why = "it speaks of cells, and samples have none of these"
    return replace(result, accuracy=result.accuracy.end_from(model.accuracy, why))


def _by_axes(model: Model, source: Axial, grid: Grid) -> Operator:
    assert isinstance(grid, Regular | Rectilinear)
    lattice = lattice_of(model.samples)
    operator: Operator = Identity(model.samples.values.size)
    for axis, wanted in enumerate(grid.axes):
        step = along_axis(model, source, axis, wanted, lattice)
        lattice, operator = step.outcome, step.after(operator)
    return operator


def along_axis(model: Model, source: Axial, axis: int, wanted: Floats, lattice: tuple[int, ...]) -> Stencil:
    """The law's weights for some coordinates of one axis: laws are products along the axes."""
    d, coordinates = dimension(source, axis), source.axes[axis]
    if len(coordinates) == 1 and np.array_equal(coordinates, wanted):
        return Stencil(lattice, d, np.zeros((1, 1), np.int64), np.ones((1, 1)))
    names = (source.frame.axes[axis], *source.frame.axes[1:])
    line = Rectilinear((coordinates,), frame=replace(source.frame, axes=names))
    weights = model.law.weights(line, np.column_stack([wanted, np.zeros((len(wanted), 2))]))
    return Stencil(lattice, d, weights.index, np.broadcast_to(weights.weight, weights.index.shape).copy())


def _by_points(model: Model, source: Axial, grid: Grid) -> Operator:
    weights = model.law.weights(source, grid.points())
    return weights if model.samples.components == 1 else by_component(weights, model.samples.components)


def _with_law(result: Samples, model: Model, progress: Progress) -> Samples:
    """The result with the law's own error; places in cells that the model flagged stay flagged."""
    own, c = model.own, result.components
    if own is None:
        return result
    columns = flat(model.samples).reshape(-1, c)
    error = np.empty((result.grid.count, c))
    flagged = _flagged(model)
    below = np.zeros(result.grid.count, bool)
    points = result.grid.points()
    for start in range(0, len(points), BLOCK):
        progress(start / len(points))
        part = slice(start, start + BLOCK)
        for k in range(c):
            error[part, k] = model.law.error(model.grid, columns[:, k].reshape(model.grid.shape), points[part])
        if flagged is not None:
            cell, _ = locate(model.grid, points[part])
            below[part] = flagged[tuple(cell.T[::-1])]
    known = np.isfinite(error)
    accuracy = result.accuracy
    if (~known & np.isfinite(result.values.reshape(-1, c))).any():
        accuracy = accuracy.miss(Missing(own.source.name, TOO_FEW))
    values = np.where(known, error, 0.0).ravel()
    accuracy = accuracy.add(
        Term(own.source, "signed", "value", own.unit, values, Identity(len(values)), components=c, id=own.id)
    )
    if below.any():
        words = f"the interpolation error cannot be told from the noise at {int(below.sum())} of {len(below)} samples"
        accuracy = accuracy.flag(Flag("not resolvable", words, "point", np.flatnonzero(below)))
    return replace(result, accuracy=accuracy)


def _flagged(model: Model) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]] | None:
    """The cells in which the law's error is within the noise."""
    flags = [f for f in model.accuracy.flags if f.name == "not resolvable" and f.place == "cell" and f.items is not None]
    if not flags:
        return None
    cells = np.zeros(tuple(n - 1 for n in model.grid.shape), bool)
    for flag in flags:
        cells.ravel()[flag.items] = True
    return cells
