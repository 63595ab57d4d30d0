"""Scattered points: the weights by which data at points give values elsewhere, and how much these can be trusted.

Every method here is a weighted sum of the data (nearest, linear in triangles, thin plate splines, kriging once its variogram
is chosen), so that errors of the data go through the same weights exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Gather, Matrix, Operator, Samples
from modules.data.operators import Floats, Ints

BATCH = 2048
"""Places whose small systems are solved at once."""


@dataclass(frozen=True)
class Points:
    """Data at points that differ.

    Parameters
    ----------
    at : (n, 2) or (n, 3) positions
    values : (n, components)
    noise : (n,) variance of the random errors that the data state, mean over components
    merge : from the samples' numbers to these values; several at one position are averaged
    twice : how many samples lay where another did
    """

    at: Floats
    values: Floats
    noise: Floats
    merge: Operator
    twice: int


@dataclass(frozen=True)
class Weighted:
    """Where each value comes from.

    Parameters
    ----------
    index : (m, k) int, points
    weight : (m, k) float; a row of zeros where there is no value
    inside : (m,) bool, whether there is a value
    variance : (m,) float, of the field about its estimate by kriging; else of no length
    """

    index: Ints
    weight: Floats
    inside: NDArray[np.bool_]
    variance: Floats


def points_of(samples: Samples) -> Points:
    """The samples that have a value, in the plane or in space.

    Raises
    ------
    ValueError : fewer than four points, all on one line, or positions that are no numbers
    """
    at = np.asarray(samples.grid.points(), float)
    values = samples.values.reshape(len(at), -1).astype(float)
    if not np.isfinite(at).all():
        raise ValueError("some points have no position: leave out the lines without coordinates")
    dimensions = 3 if np.ptp(at[:, 2]) > 0 else 2
    at = at[:, :dimensions]
    there = np.flatnonzero(np.isfinite(values).all(axis=1))
    places, group = np.unique(at[there], axis=0, return_inverse=True)
    group = np.ravel(group)
    if len(places) < dimensions + 2 or np.linalg.matrix_rank(places - places.mean(axis=0)) < dimensions:
        where = "in a plane" if dimensions == 3 else "on a line"
        many = f"{len(places)} different points that have a value"
        raise ValueError(f"{many}, all {where} or too few: {dimensions + 2} or more are needed, spread out")
    merged, merge = _merged(values, there, group, len(places))
    random = [t.push(merge) for t in samples.accuracy.select("value") if t.kind in ("linear", "members")]
    noise = sum((t.size() ** 2 for t in random), np.zeros(merged.size)).reshape(merged.shape).mean(axis=1)
    return Points(places, merged, np.asarray(noise), merge, twice=len(there) - len(places))


def _merged(values: Floats, there: Ints, group: Ints, n: int) -> tuple[Floats, Operator]:
    c = values.shape[1]
    rows = (group[:, None] * c + np.arange(c)).ravel()
    columns = (there[:, None] * c + np.arange(c)).ravel()
    share = np.repeat(1.0 / np.bincount(group, minlength=n)[group], c)
    if len(there) == n:
        order = np.argsort(rows)
        operator: Operator = Gather(columns[order][:, None], np.asarray(1.0), values.size)
    else:
        from scipy.sparse import csr_array

        operator = Matrix(csr_array((share, (rows, columns)), shape=(n * c, values.size)))
    return operator.apply(np.nan_to_num(values).ravel()).reshape(n, c), operator


def operator_of(found: Weighted, points: Points) -> Operator:
    """From the samples' numbers to the values, components fastest."""
    c = points.values.shape[1]
    index, weight = found.index, found.weight
    if c > 1:
        index = (index[:, None, :] * c + np.arange(c)[:, None]).reshape(-1, index.shape[1])
        weight = np.repeat(weight, c, axis=0)
    return Gather(index, weight, points.values.size).after(points.merge)


# --- nearest and linear ------------------------------------------------------------------------------------------


def nearest(at: Floats, wanted: Floats) -> Weighted:
    """The value of the nearest point (Voronoi cells)."""
    from scipy.spatial import cKDTree

    _, index = cKDTree(at).query(wanted)
    return Weighted(index[:, None], np.ones((len(wanted), 1)), np.ones(len(wanted), bool), np.zeros(0))


def linear(at: Floats, wanted: Floats) -> Weighted:
    """Linear in the triangles or tetrahedra of Delaunay; nothing outside of them."""
    from scipy.spatial import Delaunay

    d = at.shape[1]
    middle, size = at.mean(axis=0), float(np.ptp(at, axis=0).max())
    mesh = Delaunay((at - middle) / size)
    local = (wanted - middle) / size
    simplex = mesh.find_simplex(local, tol=1e-10)
    inside = simplex >= 0
    simplex = np.where(inside, simplex, 0)
    turn = mesh.transform[simplex]
    first = np.einsum("mij,mj->mi", turn[:, :d], local - turn[:, d])
    weight = np.column_stack([first, 1 - first.sum(axis=1)])
    inside &= np.isfinite(weight).all(axis=1)
    return Weighted(mesh.simplices[simplex].astype(np.int64), np.where(inside[:, None], weight, 0.0), inside, np.zeros(0))


def in_hull(at: Floats, wanted: Floats) -> NDArray[np.bool_]:
    """Whether places lie within the convex hull of the points."""
    return linear(at, wanted).inside


# --- thin plate splines and kriging: small systems of the neighbours ----------------------------------------------


@dataclass(frozen=True)
class Variogram:
    """How fast values at two points cease to have anything in common.

    Parameters
    ----------
    shape : spherical, exponential or gaussian
    reach : distance at which they have (nearly) nothing in common: the practical range
    sill : variance of the field
    nugget : variance of what differs between points however near, beyond the noise that the data state
    """

    shape: str
    reach: float
    sill: float
    nugget: float

    def shared(self, distance: Floats) -> Floats:
        """(...) covariance at a distance."""
        h = distance / self.reach
        if self.shape == "spherical":
            part = np.where(h < 1, 1 - 1.5 * h + 0.5 * h**3, 0.0)
        else:
            part = np.exp(-3 * h) if self.shape == "exponential" else np.exp(-3 * h**2)
        return np.asarray(self.sill * part + np.where(h == 0, self.nugget, 0.0))


def spline(at: Floats, wanted: Floats, neighbours: int, leave: bool = False) -> Weighted:
    """The surface of least bending through the neighbours of each place.

    Source: Duchon 1977; thin plate splines with a plane.
    """

    def kernel(distance: Floats) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(distance > 0, distance**2 * np.log(distance), 0.0)

    return _solved(at, wanted, neighbours, leave, kernel, 0.0 * at[:, 0], degree=1)[0]


def kriging(
    at: Floats, wanted: Floats, neighbours: int, variogram: Variogram, noise: Floats, leave: bool = False
) -> Weighted:
    """The weighted mean of the neighbours whose error has the least variance.

    Parameters
    ----------
    noise : (n,) variance of the data's own random errors, which the weights then smooth out

    Source: Matheron 1963, ordinary kriging; Cressie 1993, 3.2, with known variances of measurement.
    """
    total = variogram.sill + variogram.nugget
    found, gained = _solved(at, wanted, neighbours, leave, variogram.shared, noise + 1e-9 * total, degree=0)
    known = total - gained - np.sum(found.weight**2 * noise[found.index], axis=1)
    return replace(found, variance=np.maximum(known, 0.0))


def _apart(one: Floats, other: Floats) -> Floats:
    """(m, k, k) distances."""
    squares = sum((one[:, :, None, i] - other[:, None, :, i]) ** 2 for i in range(one.shape[2]))
    return np.sqrt(squares)


def _solved(
    at: Floats,
    wanted: Floats,
    neighbours: int,
    leave: bool,
    kernel: Callable[[Floats], Floats],
    diagonal: Floats,
    degree: int,
) -> tuple[Weighted, Floats]:
    """Weights by one small system a place, and what `_systems` says beside; `leave` leaves out the point that lies there."""
    from scipy.spatial import cKDTree

    k = min(neighbours, len(at) - int(leave))
    _, index = cKDTree(at).query(wanted, k=k + int(leave))
    index = np.asarray(index).reshape(len(wanted), -1)[:, int(leave) :]
    weight, gained = np.empty(index.shape), np.empty(len(wanted))
    for start in range(0, len(wanted), BATCH):
        part = slice(start, start + BATCH)
        weight[part], gained[part] = _systems(at[index[part]], wanted[part], kernel, diagonal[index[part]], degree)
    return Weighted(index.astype(np.int64), weight, np.ones(len(wanted), bool), np.zeros(0)), gained


def _systems(
    near: Floats, wanted: Floats, kernel: Callable[[Floats], Floats], diagonal: Floats, degree: int
) -> tuple[Floats, Floats]:
    """(m, k) weights, and (m,) right side times solution: of kriging, by how much the data lessen the variance."""
    m, k, d = near.shape
    used = near - wanted[:, None, :]
    if degree:  # a spline does not depend on the unit of length, its numbers do
        size = np.abs(used).max(axis=(1, 2), keepdims=True)
        used = used / np.where(size > 0, size, 1.0)
    free = 1 + d * degree
    left, right = np.zeros((m, k + free, k + free)), np.zeros((m, k + free, 1))
    left[:, :k, :k] = kernel(_apart(used, used))
    left[:, range(k), range(k)] += diagonal
    right[:, :k, 0] = kernel(np.linalg.norm(used, axis=2))
    largest = np.abs(left[:, :k, :k]).max(axis=(1, 2), keepdims=True) + 1e-300
    left[:, :k, :k] /= largest
    right[:, :k] /= largest
    left[:, :k, k] = left[:, k, :k] = right[:, k, 0] = 1.0
    if degree:
        left[:, :k, k + 1 :] = used
        left[:, k + 1 :, :k] = used.transpose(0, 2, 1)
    try:
        solution = np.linalg.solve(left, right)
    except np.linalg.LinAlgError:  # neighbours on one line, or a field without any variance
        solution = np.linalg.pinv(left, hermitian=True) @ right
    return solution[:, :k, 0], (right * solution).sum(axis=(1, 2)) * largest[:, 0, 0]
