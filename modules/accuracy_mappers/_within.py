"""Where a field is within its own error of a level, cell by cell: what the band around a contour is drawn from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Accuracy, Model, Progress, Rectilinear, Regular, Term
from modules.data.laws import Linear, second_derivative

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FINE = 2
"""Pieces of a cell along each axis in which a standard deviation is taken as linear: between samples it sags. A band is
then up to 8 % too wide along a grid edge, 17 % within a cell, where errors are independent; never too narrow."""
CHUNK = 20_000
"""Cells looked at between two polls."""
VALID = 0.4
"""Largest kappa = error |F_nn| / slope^2 for which 95 % bands of a first-order position cover 94 to 98 %."""

@dataclass(frozen=True, eq=False)
class Patches:
    """Cells cut finely, with what is known of the values there.

    Parameters
    ----------
    cell : (m,) grid cells, row-major, ascending
    x, y : (m, p) coordinates of the pieces' nodes
    values, straight, random : (m, p, p) field, bounds (and estimates) added, standard deviations added in squares
    kappa : (m,) error |F_nn| / slope^2 at the middle of each cell, for one standard deviation, the largest of the cell
    """

    cell: Ints
    x: Floats
    y: Floats
    values: Floats
    straight: Floats
    random: Floats
    kappa: Floats


def restricted(model: Model, chosen: tuple[Term, ...]) -> Model:
    """The model with only some of its terms known."""
    point = tuple(t for t in chosen if t.place == "point")
    samples = replace(model.samples, accuracy=Accuracy(tuple(t for t in model.samples.accuracy.terms if t in point)))
    return Model(samples=samples, law=model.law, accuracy=Accuracy(chosen))


def parts(known: Accuracy, n: int) -> tuple[Floats, Floats]:
    """(n,) sum of bounds and estimates, and (n,) root of the sum of squared standard deviations."""
    straight, squares = np.zeros(n), np.zeros(n)
    for term in known.terms:
        if term.kind in ("linear", "members"):
            squares += term.size() ** 2
        else:
            straight += term.size()
    return straight, np.sqrt(squares)


def candidates(model: Model, levels: Floats, k: float) -> list[Ints]:
    """For each level, the cells that a band of k standard deviations may reach.

    Between samples neither a bound nor a standard deviation of weighted samples is larger than at the corners.
    """
    values = np.asarray(model.samples.values, float)
    own = model.own
    straight, random = parts(Accuracy(model.accuracy.select(place="point")), values.size)
    error = (straight + k * random).reshape(values.shape)
    between = own.size().reshape(np.array(values.shape) - 1) if own is not None else 0.0
    most, low, high = _corners(error, np.maximum), _corners(values, np.minimum), _corners(values, np.maximum)
    reach = most + between
    finite = np.isfinite(low) & np.isfinite(high)
    return [np.flatnonzero((finite & (low - level < reach) & (high - level >= -reach)).ravel()) for level in levels]


def _corners(f: Floats, choose: np.ufunc) -> Floats:
    return np.asarray(choose(choose(f[:-1, :-1], f[:-1, 1:]), choose(f[1:, :-1], f[1:, 1:])))


def patches(model: Model, cell: Ints, progress: Progress) -> Patches:
    """The cells cut in `FINE` pieces along each axis (one where no standard deviation sags between samples)."""
    pieces = FINE if any(t.kind in ("linear", "members") for t in model.accuracy.terms) or model.own is not None else 1
    chunks = [cell[i : i + CHUNK] for i in range(0, len(cell), CHUNK)] or [cell]
    found = []
    for i, chunk in enumerate(chunks):
        progress(i / len(chunks))
        found.append(_patch(model, chunk, pieces))
    return Patches(*(np.concatenate([getattr(p, name) for p in found]) for name in Patches.__dataclass_fields__))


def _patch(model: Model, cell: Ints, pieces: int) -> Patches:
    grid = model.grid
    assert isinstance(grid, Regular | Rectilinear)
    row, column = np.divmod(cell, len(grid.axes[0]) - 1)
    t = np.linspace(0.0, 1.0, pieces + 1)
    x, y = (a[i][:, None] * (1 - t) + a[i + 1][:, None] * t for a, i in zip(grid.axes, (column, row), strict=True))
    shape = (len(cell), pieces + 1, pieces + 1)
    at = np.zeros((*shape, 3))
    at[..., 0], at[..., 1] = x[:, None, :], y[:, :, None]
    values, known = model.at(at.reshape(-1, 3))
    straight, random = parts(known, len(values))
    middle = np.column_stack([x.mean(axis=1), y.mean(axis=1), np.zeros(len(cell))])
    kappa = _kappa(model, middle, (straight + random).reshape(len(cell), (pieces + 1) ** 2).max(axis=1))
    return Patches(cell, x, y, values.reshape(shape), straight.reshape(shape), random.reshape(shape), kappa)


def _kappa(model: Model, middle: Floats, error: Floats) -> Floats:
    """Error |F_nn| / slope^2 at points; infinite where the field is level and there is an error."""
    field, grid = np.asarray(model.samples.values, float), model.grid
    slope = slope_at(model, middle)
    weights = Linear().weights(grid, middle)
    bent = [np.abs(np.nan_to_num(weights.apply(second_derivative(grid, field, axis).ravel()))) for axis in (0, 1)]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(error * np.maximum(*bent) / slope**2, nan=0.0, posinf=np.inf))


def slope_at(model: Model, points: Floats) -> Floats:
    """(n,) slope of the model, per unit of its axes."""
    return np.asarray(np.linalg.norm(model.gradient(points)[0], axis=1))


def regions(found: Patches, mine: Ints, level: float, k: float, tolerance: float) -> tuple[Floats, list[Ints], Ints]:
    """Where |F - level| is within bounds and k standard deviations: points, polygons, and the patch of each.

    Parameters
    ----------
    mine : the patches that the band may reach
    tolerance : area that an arc may leave

    Returns
    -------
    (p, 2) points; offsets and connectivity of the polygons; (polygons,) patch
    """
    error = found.straight[mine] + k * found.random[mine]
    mine = mine[(error > 0).any(axis=(1, 2))]
    error = found.straight[mine] + k * found.random[mine]
    above, below = found.values[mine] - level + error, found.values[mine] - level - error
    whole = ((above >= 0) & (below < 0)).all(axis=(1, 2))
    x, y, ends = found.x[mine], found.y[mine], np.array([0, -1])
    full = kernels.bands.between(
        above[whole][:, ends][:, :, ends], below[whole][:, ends][:, :, ends], x[whole][:, ends], y[whole][:, ends], tolerance
    )
    part = kernels.bands.between(above[~whole], below[~whole], x[~whole], y[~whole], tolerance, merged=True)
    points = np.concatenate([full.points, part.points])
    offsets = np.concatenate([full.offsets, part.offsets[1:] + full.offsets[-1]])
    connectivity = np.concatenate([full.connectivity, part.connectivity + len(full.points)])
    cells_a_patch = (found.x.shape[1] - 1) ** 2
    patch = np.concatenate([mine[whole][full.cell], mine[~whole][part.cell // cells_a_patch]])
    return points, [offsets, connectivity], patch
