"""Accurate marching cubes: the isosurface of the trilinear interpolant on a rectilinear grid, with its topology.

Rules
-----
- A node or a face's saddle *exactly on the level counts as above* it: the surface is the limit of those just below.
- Faces are joined by the asymptotic decider (exact, without a division); tunnels by the inflection points.
- The right-handed normal of a triangle points to the *low* side. Edges of triangles have two triangles, or one on the
  border of the grid or of a hole (cells with a corner that is not finite).
- Crossings stay `marching_points.APART` of an edge away from nodes, so that no triangle shrinks to nothing.

Source: Lopes 1999, chapter 4; Lopes and Brodlie 2003; with configuration 13's tunnels.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.marching_cases import Floats, Integers, new_cell, simple
from modules.kernels.marching_sweep import Lattice, Slab, find, write

CELLS_A_SLAB = 1 << 17
"""Cells of a slab: about ten milliseconds."""

Slabs = Callable[[Callable[[int], Any], Iterable[int]], list[Any]]


class Surface(NamedTuple):
    """An isosurface of n points and m triangles.

    Attributes
    ----------
    points : (n, 3) float64
        x, y, z.
    triangles : (m, 3) int64
        Points; the right-handed normal points to the low side.
    cell : (m,) int64
        The grid cell of each triangle, row-major over (nz - 1, ny - 1, nx - 1).
    tunnels : int
        Cells through which the surface has a tunnel.
    special : int
        Cells of more than one polygon or with an ambiguous face.
    """

    points: Floats
    triangles: Integers
    cell: Integers
    tunnels: int
    special: int


class _Part(NamedTuple):
    point: Floats
    triangle: Integers
    origin: Integers
    bottom: Integers
    top: npt.NDArray[np.int32]
    early: int
    tunnels: int
    special: int


def surface(values: Floats, x: Floats, y: Floats, z: Floats, level: float, *, slabs: Slabs | None = None) -> Surface:
    """The isosurface F = level.

    Parameters
    ----------
    values : (nz, ny, nx)
        At the nodes. Not finite: a hole.
    x, y, z : (nx,), (ny,), (nz,)
        Strictly ascending coordinates of the nodes.
    level
        In units of the values.
    slabs
        Applies a function to each of some numbers and gives the list of results, perhaps in several threads; what it
        raises ends the work.

    Returns
    -------
    Surface
        The same, to the bit, however the slabs are shared.

    Raises
    ------
    ValueError
        If the shapes do not fit, the grid has no cell, a coordinate is not ascending, or the level is not finite.

    Accuracy: topology of the trilinear interpolant, exact for the given floats at faces and nodes; vertices lie on the
    surface to rounding, or within 2^-24 of a cell where it passes a node nearer than that.
    Source: thesis section 4.2.
    """
    lattice = _at_the_door(values, x, y, z, level)
    nz, ny, nx = lattice.values.shape
    layers = max(1, CELLS_A_SLAB // ((ny - 1) * (nx - 1)))
    starts = range(0, nz - 1, layers)
    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    simple()  # made once, before the threads
    return _joined(each(lambda first: _slab(lattice, float(level), first, min(first + layers, nz - 1)), starts))


def _at_the_door(values: Floats, x: Floats, y: Floats, z: Floats, level: float) -> Lattice:
    values, x, y, z = (np.ascontiguousarray(array, np.float64).view() for array in (values, x, y, z))
    if values.shape != (z.size, y.size, x.size):
        raise ValueError(f"values of shape {values.shape} do not fit {z.size} x {y.size} x {x.size} coordinates")
    if min(values.shape) < 2:
        raise ValueError(f"a grid of {' x '.join(map(str, values.shape))} nodes has no cell")
    for name, axis in (("x", x), ("y", y), ("z", z)):
        if not (np.isfinite(axis).all() and (np.diff(axis) > 0).all()):
            raise ValueError(f"the {name} coordinates must ascend strictly")
    if not math.isfinite(level):
        raise ValueError(f"the level must be a finite number, not {level}")
    for array in (values, x, y, z):
        array.flags.writeable = False  # one signature for arrays that may and may not be written
    return Lattice(values, x, y, z)


def _slab(lattice: Lattice, level: float, first: int, last: int) -> _Part:
    """The surface in layers first to last - 1, its vertices numbered from 0."""
    _, ny, nx = lattice.values.shape
    table = simple()
    # memory that is never touched costs nothing
    active = np.empty((last - first) * (ny - 1) * (nx - 1) + 1, np.int64)
    found, crossings = find(lattice.values, level, first, last, active, np.ascontiguousarray(table["crossings"]))
    inner = 8 * found
    slab = Slab(
        np.empty((2 * crossings + inner, 3)), np.empty((2 * crossings + 12 * found, 3), np.int64),
        np.empty(2 * crossings + 12 * found, np.int64), np.full((3, ny, nx, 5), -1, np.int32),
        np.empty((2 * crossings, 2), np.int64), np.zeros(8, np.int64),
    )  # fmt: skip
    write(lattice, level, first, active[:found], table, new_cell(), slab)
    points, triangles, below, _, floor, tunnels, special = (int(n) for n in slab.state[:7])
    top = slab.ids[last & 1]
    reached = found > 0 and int(active[found - 1] >> 8) // ((ny - 1) * (nx - 1)) == last - first - 1
    top = np.where(top >= floor, top, -1) if reached else np.full_like(top, -1)
    bottom = slab.bottom[:below].copy()
    early = int(bottom[-1, 1]) + 1 if below else 0
    return _Part(
        slab.point[:points], slab.triangle[:triangles], slab.origin[:triangles], bottom, top, early, tunnels, special
    )


def _joined(parts: list[_Part]) -> Surface:
    """The slabs as one: vertices of a plane between two slabs are those of the lower one."""
    offset, shift = 0, 0
    points, triangles = [], []
    below = np.zeros(0, np.int64)
    for number, part in enumerate(parts):
        keep = np.ones(part.early, bool)
        found = np.full(part.early, -1, np.int64)
        if number and len(part.bottom):
            found[part.bottom[:, 1]] = below[part.bottom[:, 0]]
            keep = found < 0
        shift = offset - int(part.early - keep.sum())  # from number in the slab to number in all, after the early ones
        found[keep] = offset + np.arange(int(keep.sum()))
        triangles.append(_renumbered(part.triangle, found, shift))
        points += [part.point[: part.early][keep], part.point[part.early :]]
        top = part.top.ravel()
        below = np.where(top >= 0, _renumbered(np.maximum(top, 0).astype(np.int64), found, shift), -1)
        offset += len(part.point) - int(part.early - keep.sum())
    return Surface(
        np.concatenate(points) if points else np.zeros((0, 3)),
        np.concatenate(triangles),
        np.concatenate([part.origin for part in parts]),
        sum(part.tunnels for part in parts),
        sum(part.special for part in parts),
    )


def _renumbered(ids: Integers, early: Integers, shift: int) -> Integers:
    moved = ids + shift
    if len(early):
        first = ids < len(early)
        moved[first] = early[ids[first]]
    return moved


def warm() -> None:
    """Compile the kernels of this file and of those it is made of."""
    values = np.random.default_rng(1).normal(size=(3, 3, 3))
    surface(values, np.arange(3.0), np.arange(3.0), np.arange(3.0), 0.1)
