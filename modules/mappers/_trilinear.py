"""One trilinear cell of a model: its corner values, its patch, and what each vertex of that is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Model, Rectilinear, Regular

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CROSSING, CENTRE = 0, 4
"""Kinds of vertices; 1 to 3 are face shoulder and inflection points of x, y and z."""


def cell_of(model: Model, at: tuple[int, int, int]) -> tuple[Floats, Floats, Floats]:
    """(8,) corner values 000, 001, ..., lower corner and size of a cell."""
    grid = model.grid
    if grid.dimensions != 3 or not isinstance(grid, Regular | Rectilinear) or model.samples.components != 1:
        raise ValueError("a trilinear cell is one of a regular or rectilinear grid of space with one value a sample")
    if model.law.name != "linear":
        raise ValueError(f"the law between samples is {model.law.name}: choose law 'linear' in interpolate")
    if not all(0 <= n < len(axis) - 1 for n, axis in zip(at, grid.axes, strict=True)):
        shape = " x ".join(str(len(axis) - 1) for axis in grid.axes)
        raise ValueError(f"there is no cell {at[0]}, {at[1]}, {at[2]}: the model has {shape} cells")
    i, j, k = at
    corner = np.asarray(model.samples.values, float)[k : k + 2, j : j + 2, i : i + 2].transpose(2, 1, 0).ravel()
    if not np.isfinite(corner).all():
        raise ValueError("a cell with a hole at a corner has no surface: choose another cell")
    low = np.array([axis[n] for n, axis in zip(at, grid.axes, strict=True)])
    return corner, low, np.array([axis[n + 1] - axis[n] for n, axis in zip(at, grid.axes, strict=True)])


def lattice(f: Floats) -> Floats:
    """(8,) corner values as an array [z, y, x]."""
    return np.ascontiguousarray(f.reshape(2, 2, 2).transpose(2, 1, 0))


def told_apart(points: Floats, f: Floats) -> NDArray[np.int64]:
    """Of each vertex of the patch: 0 a crossing, 1 to 3 a face shoulder or inflection point of x, y, z, 4 a bi-shoulder."""
    flat = (points == 0) | (points == 1)
    kind = np.where(flat.sum(axis=1) >= 2, 0, np.where(flat.any(axis=1), 1 + flat.argmax(axis=1), 4))
    bend = kernels.trilinear.inflections(f[None])[0]
    for n in np.flatnonzero(kind == 4):
        away = np.nan_to_num(np.abs(bend - points[n]).max(axis=2), nan=np.inf).min(axis=1)
        if away.min() < 1e-7:
            kind[n] = 1 + away.argmin()
    return np.asarray(kind, np.int64)


def loops(triangles: Ints) -> list[list[int]]:
    """The closed curves of edges with one triangle, as vertices; the first one occurs again at the end."""
    ends = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    there = {(int(a), int(b)) for a, b in ends}
    after = {a: b for a, b in there if (b, a) not in there}
    found = []
    while after:
        line = [next(iter(after))]
        while line[-1] in after:
            line.append(after.pop(line[-1]))
        found.append(line)
    return found
