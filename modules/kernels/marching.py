"""Accurate marching cubes: the isosurface of the trilinear interpolant on a rectilinear grid, with its topology.

Rules
-----
- A node or a face's saddle *exactly on the level counts as above* it: the surface is the limit of those just below. Where
  that decides how a cell with several polygons is filled, the surface *is* the one `BELOW` below: sheets that only touch
  in the limit are then apart, or joined, as they are there.
- Faces are joined by the asymptotic decider (exact, without a division); tunnels by the inflection points.
- The right-handed normal of a triangle points to the *low* side. Edges of triangles have two triangles, or one on the
  border of the grid or of a hole (cells with a corner that is not finite).
- Crossings stay `marching_points.APART` of an edge away from nodes, so that no triangle shrinks to nothing.

Source: Lopes 1999, chapter 4; Lopes and Brodlie 2003; with configuration 13's tunnels.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from modules.kernels.marching_cases import Bytes, Floats, Integers, Masks, all_polygons, new_cell
from modules.kernels.marching_cell import patches
from modules.kernels.marching_find import REST, SPECIAL, TOP, TRIANGLES, find, words
from modules.kernels.marching_tables import Tables, tables
from modules.kernels.marching_write import room_to_work, write

LAYERS_A_SLAB = 8
"""Each slab looks once more at the last layer of the one before."""

BELOW = 2.0**-40
"""Of the largest |value - level| of the cells where the level meets a node or saddle: as far the level is lowered for them."""

MOST_POINTS = 2**31 - 1

Slabs = Callable[[Callable[[int], Any], Iterable[int]], list[Any]]


class Grid(NamedTuple):
    """The samples, row after row, and the coordinates along each axis."""

    values: Floats
    x: Floats
    y: Floats
    z: Floats


class Found(NamedTuple):
    """What the first pass knows of a slab.

    Attributes
    ----------
    active : (n,) column of each cell << 32, bits of its new vertices << 8, its code
    rows : where each row of cells starts in it
    counts : (layers, 4) what each layer holds
    joined, patch_count, inner, patch : of the cells that need more thought
    tunnels : cells with a tunnel
    tied : the least size of a cell where the level meets a node or a saddle; infinite if there is none
    """

    active: Integers
    rows: Integers
    counts: Integers
    joined: Integers
    patch_count: Integers
    inner: Floats
    patch: Bytes
    tunnels: int
    tied: float


class Blocks(NamedTuple):
    """The least and the largest value in each block of eight cells along each axis: (bz, by, bx)."""

    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class Surface:
    """An isosurface of n points and m triangles.

    Parameters
    ----------
    points : (n, 3) float64
        x, y, z.
    triangles : (m, 3) int64
        Points; the right-handed normal points to the low side.
    found : what the first pass knows of the slabs
    tunnels : int
        Cells through which the surface has a tunnel.
    special : int
        Cells of more than one polygon or with an ambiguous face.
    level : float
        That was drawn: the one asked for, or a little less where the surface would touch itself.
    """

    points: Floats
    triangles: Integers
    tunnels: int
    special: int
    level: float
    shape: tuple[int, int, int]
    found: tuple[Found, ...]

    @cached_property
    def cell(self) -> Integers:
        """(m,) int64: the grid cell of each triangle, row-major over (nz - 1, ny - 1, nx - 1)."""
        nx, sides = self.shape[2] - 1, 2 * tables().sides.astype(np.int64)
        cells, first = [np.zeros(0, np.int64)], 0
        for part in self.found:
            rows = np.repeat(np.arange(len(part.rows) - 1) + first, np.diff(part.rows))
            count = sides[part.active & 255]
            count[count == 0] = part.patch_count[1::2]
            cells.append(np.repeat(rows * nx + (part.active >> 32), count))
            first += len(part.rows) - 1
        return np.concatenate(cells)


def blocks(values: Floats) -> Blocks | None:
    """The range of each block of samples, so that a new level costs little where the surface is not; None for holes.

    Parameters
    ----------
    values : (nz, ny, nx)
    """
    low = high = np.asarray(values, np.float64)
    for axis in range(3):
        starts = np.arange(0, values.shape[axis] - 1, 8)
        ends = np.minimum(starts + 8, values.shape[axis] - 1)
        low = np.minimum(np.minimum.reduceat(low, starts, axis), low.take(ends, axis))
        high = np.maximum(np.maximum.reduceat(high, starts, axis), high.take(ends, axis))
    return Blocks(low, high) if np.isfinite(low).all() and np.isfinite(high).all() else None


def surface(
    values: Floats, x: Floats, y: Floats, z: Floats, level: float, *, slabs: Slabs | None = None, index: Blocks | None = None,
    bent: bool = True,
) -> Surface:  # fmt: skip
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
    index
        Of `blocks`, made once for these values: empty blocks are then passed by.
    bent
        Whether inflection points are used. Without them tunnels through cells are not seen.

    Returns
    -------
    Surface
        The same, to the bit, however the slabs are shared.

    Raises
    ------
    ValueError
        If the shapes do not fit, the grid has no cell, a coordinate is not ascending, or the level is not finite.

    Accuracy: topology of the trilinear interpolant, exact for the given floats at faces and nodes; vertices lie on the
    surface to rounding, or within 2^-24 of a cell where it passes a node nearer than that. Where it touches itself, the
    level is lowered by 2^-40 of the values there.
    Source: thesis section 4.2.
    """
    nz, ny, nx = np.shape(values)
    grid = _at_the_door(values, x, y, z, level)
    each = slabs or (lambda function, numbers: [function(n) for n in numbers])
    starts, table = range(0, nz - 1, LAYERS_A_SLAB), tables()


    def first_pass(level: float) -> list[Found]:
        busy = _busy(index, level, (nz, ny, nx))
        return each(lambda k: _find(grid, table, busy, level, k, min(k + LAYERS_A_SLAB, nz - 1), bent), starts)

    level = float(level)
    found = first_pass(level)
    tied = min(part.tied for part in found)
    if tied < math.inf:
        level -= max(BELOW * tied, 2.0 * math.ulp(level))
        found = first_pass(level)
    base, sizes = _bases(np.concatenate([part.counts for part in found]))
    if sizes[0] > MOST_POINTS:
        raise ValueError(f"the surface has {sizes[0]} points, more than {MOST_POINTS}: draw a part of the grid at a time")
    points, triangles = np.empty((sizes[0], 3)), np.empty((sizes[1], 3), np.int64)
    rooms: list[Masks] = []
    each(lambda k: _write(grid, table, level, k, base, found, points, triangles, bent, rooms), starts)
    special = sum(len(part.joined) for part in found)
    return Surface(points, triangles, sum(part.tunnels for part in found), special, level, (nz, ny, nx), tuple(found))


def _at_the_door(values: Floats, x: Floats, y: Floats, z: Floats, level: float) -> Grid:
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
    values = values.reshape(-1)
    for array in (values, x, y, z):
        array.flags.writeable = False  # one signature for arrays that may and may not be written
    return Grid(values, x, y, z)


def _busy(index: Blocks | None, level: float, shape: tuple[int, int, int]) -> tuple[Bytes, Bytes]:
    """Of each block of cells whether the surface may pass it, of each block of nodes whether such cells have one; lines too."""
    busy = np.zeros([(n + 7) // 8 for n in shape], np.uint8)
    if index is None:
        busy[:] = 1
        return _with_lines(busy), _with_lines(busy)
    depth, height, width = index.low.shape
    busy[:depth, :height, :width] = (index.low < level) & (index.high >= level)
    wanted = busy.copy()
    for axis in range(3):
        after, before = [slice(None)] * 3, [slice(None)] * 3
        after[axis], before[axis] = slice(1, None), slice(None, -1)
        wanted[tuple(after)] |= wanted[tuple(before)].copy()
    return _with_lines(busy), _with_lines(wanted)


def _with_lines(busy: Bytes) -> Bytes:
    """The blocks one after the other, and then of each line of blocks along x whether any is busy."""
    return np.concatenate([busy.ravel(), busy.any(axis=2).ravel()])


def _find(grid: Grid, table: Tables, busy: tuple[Bytes, Bytes], level: float, first: int, last: int, bent: bool) -> Found:
    """The first pass over layers first to last - 1."""
    nx, ny = len(grid.x), len(grid.y)
    cells = (last - first) * (ny - 1) * (nx - 1)
    plane = np.zeros(3 * ny * 8 * words(nx), np.uint8)
    # memory that is never touched costs nothing; what is kept of it is copied
    active, special = np.empty(cells, np.int64), np.empty(cells, np.int64)
    rows, counts = np.empty((last - first) * (ny - 1) + 1, np.int64), np.zeros((last - first, 4), np.int64)
    n = find(
        grid.values, nx, ny, level, first, last, plane, plane.view(np.uint64), active, rows, special, counts.reshape(-1),
        *busy, table.used, table.shared, table.open, table.ones, table.sides,
    )  # fmt: skip
    strange = int(counts[:, SPECIAL].sum())
    nodes, joined, patch_count = special[:strange], np.empty(strange, np.int64), np.empty((strange, 2), np.int64)
    inner, patch, tunnels = np.empty(24 * strange), np.empty(144 * strange, np.uint8), np.zeros(1, np.int64)
    tied = np.full(1, math.inf)
    if strange:
        patches(
            grid.values, nx, ny, level, nodes, new_cell(), *all_polygons(), joined, patch_count.reshape(-1), inner, patch,
            tunnels, tied, bent,
        )  # fmt: skip
        layer = nodes // (nx * ny) - first
        np.add.at(counts[:, REST], layer, patch_count[:, 0])
        np.add.at(counts[:, TRIANGLES], layer, patch_count[:, 1])
    of_patches = patch_count.reshape(-1)
    return Found(active[:n].copy(), rows, counts, joined, of_patches, inner, patch, int(tunnels[0]), float(tied[0]))


def _bases(counts: Integers) -> tuple[Integers, tuple[int, int]]:
    """(layers, 3): the first vertex in each layer's upper plane, its first other one, its first triangle; and the totals."""
    points = np.concatenate([[0], np.cumsum(counts[:, [TOP, REST]].ravel())])
    triangles = np.concatenate([[0], np.cumsum(counts[:, TRIANGLES])])
    base = np.column_stack([points[:-1].reshape(-1, 2), triangles[:-1]])
    return np.ascontiguousarray(base), (int(points[-1]), int(triangles[-1]))


def _write(
    grid: Grid, table: Tables, level: float, first: int, base: Integers, found: list[Found], points: Floats,
    triangles: Integers, bent: bool, rooms: list[Masks],
) -> None:  # fmt: skip
    """The second pass over a slab; `rooms` are those that no thread uses at the moment."""
    number = first // LAYERS_A_SLAB
    part, before = found[number], found[number - 1] if number else found[0]
    nx, ny, layers = len(grid.x), len(grid.y), len(part.counts)
    below = before.rows[-ny:]
    failed = np.empty(2 * len(part.active) + 2, np.int64)
    failed[0] = 0
    try:
        ids = rooms.pop()
    except IndexError:
        ids = np.empty(4 * (2 * ny + 3) * nx, np.int32)
    bases = np.concatenate([base[first - 1 : first] if first else np.zeros((1, 3), np.int64), base[first : first + layers]])
    write(
        grid.values, level, grid.x, grid.y, grid.z, first, first + layers, bases.reshape(-1), before.active, below,
        part.active, part.rows, part.joined, part.patch_count, part.inner, part.patch, table.lowest, table.sides,
        table.around, table.turned, table.axes, table.start, table.face, ids, failed, points, triangles, *room_to_work(),
    )  # fmt: skip
    rooms.append(ids)
    if failed[0]:
        _mend(grid, level, failed[2 : 2 * failed[0] + 2].reshape(-1, 2), points, bent)


def _mend(grid: Grid, level: float, failed: Integers, points: Floats, bent: bool) -> None:
    """The inner points that the fast search did not find, in the careful way."""
    nx, ny, n = len(grid.x), len(grid.y), len(failed)
    nodes, counts, inner = np.ascontiguousarray(failed[:, 1]), np.empty(2 * n, np.int64), np.empty(24 * n)
    patches(
        grid.values, nx, ny, level, nodes, new_cell(), *all_polygons(), np.empty(n, np.int64), counts, inner,
        np.empty(144 * n, np.uint8), np.zeros(1, np.int64), np.full(1, math.inf), bent,
    )  # fmt: skip
    at = inner[: 3 * n].reshape(n, 3)
    for axis, (coordinates, step) in enumerate(((grid.x, 1), (grid.y, nx), (grid.z, nx * ny))):
        i = nodes // step % len(coordinates)
        points[failed[:, 0], axis] = (1.0 - at[:, axis]) * coordinates[i] + at[:, axis] * coordinates[i + 1]


def warm() -> None:
    """Compile the kernels of this file and of those it is made of."""
    values = np.random.default_rng(1).normal(size=(3, 3, 3))
    surface(values, np.arange(3.0), np.arange(3.0), np.arange(3.0), 0.1)
