"""Where samples lie: the taxonomy of thesis 2.2, and the frame that says what the axes are.

    Regular       evenly spaced along each axis (Cartesian if the spacing is one for all)
    Rectilinear   unevenly spaced axes
    Curvilinear   a bent lattice with explicit coordinates
    Unstructured  cells with explicit topology

Arrays are [z, y, x]; points are (n, 3) in x, y, z, with z = 0 in two dimensions; spacing, origin and axes are in x, y, z.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modules.data.operators import Floats

Bounds = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class Frame:
    """What the axes are: names, a unit per axis, handedness, and a coordinate reference system in words."""

    axes: tuple[str, str, str] = ("x", "y", "z")
    units: tuple[str, str, str] = ("", "", "")
    handed: str = "right"
    crs: str = ""

    def length_unit(self, dimensions: int) -> str:
        """The one unit of lengths and, squared, of areas.

        Raises
        ------
        ValueError : the axes have different units, so a length over them means nothing
        """
        units = self.units[:dimensions]
        if len(set(units)) > 1:
            named = ", ".join(f"{a} in {u or 'plain numbers'}" for a, u in zip(self.axes, units, strict=False))
            raise ValueError(f"the axes have different units ({named}): bring them to one before measuring lengths or areas")
        return units[0]


@dataclass(frozen=True, eq=False)
class Grid:
    """Positions of samples, and the cells between them."""

    frame: Frame = field(default=Frame(), kw_only=True)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a scalar array on the grid."""
        raise TypeError(f"{type(self).__name__} has no shape")

    @property
    def dimensions(self) -> int:
        """Number of coordinates that vary: 1, 2 or 3."""
        return len(self.shape)

    @property
    def count(self) -> int:
        """Number of samples."""
        return math.prod(self.shape)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return math.prod(max(0, n - 1) for n in self.shape)

    @property
    def kind(self) -> str:
        """regular, rectilinear, curvilinear or unstructured."""
        return type(self).__name__.lower()

    def points(self) -> Floats:
        """(count, 3) positions in x, y, z."""
        raise TypeError(f"{type(self).__name__} has no points")

    @property
    def bounds(self) -> Bounds:
        """(xmin, xmax, ymin, ymax, zmin, zmax)."""
        points = self.points()
        if not len(points):
            return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        low, high = points.min(axis=0), points.max(axis=0)
        return tuple(float(v) for pair in zip(low, high, strict=True) for v in pair)  # type: ignore[return-value]  # six numbers

    def same_place(self, other: Grid) -> bool:
        """Whether the samples lie at the same positions, in the same frame."""
        return (
            self is other
            or (self.shape == other.shape and self.frame == other.frame and np.array_equal(self.points(), other.points()))
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Rectilinear(Grid):
    """Axes of their own spacing.

    Parameters
    ----------
    axes : (nx,), (ny,)[, (nz,)] strictly ascending coordinates, in x, y, z
    """

    axes: tuple[Floats, ...]

    def __post_init__(self) -> None:
        axes = tuple(np.ascontiguousarray(a, dtype=float) for a in self.axes)
        if not 1 <= len(axes) <= 3:
            raise ValueError(f"a grid has 1 to 3 axes, not {len(axes)}")
        for name, axis in zip(self.frame.axes, axes, strict=False):
            if axis.ndim != 1 or not len(axis) or not np.isfinite(axis).all():
                raise ValueError(f"axis {name} is not a list of finite coordinates")
            if (np.diff(axis) <= 0).any():
                raise ValueError(f"axis {name} is not strictly ascending: sort it, and the values with it")
        object.__setattr__(self, "axes", axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a scalar array, [z, y, x]."""
        return tuple(len(a) for a in reversed(self.axes))

    def points(self) -> Floats:
        """(count, 3) positions in x, y, z."""
        return lattice_points(self.axes)

    @property
    def bounds(self) -> Bounds:
        """(xmin, xmax, ymin, ymax, zmin, zmax)."""
        ends = [float(v) for a in self.axes for v in (a[0], a[-1])] + [0.0] * (2 * (3 - len(self.axes)))
        return tuple(ends)  # type: ignore[return-value]  # six numbers


@dataclass(frozen=True, eq=False)
class Regular(Grid):
    """Evenly spaced along each axis.

    Parameters
    ----------
    size : shape of a scalar array, [z, y, x]
    spacing : (hx, hy[, hz]) > 0
    origin : (x0, y0[, z0]) of the first sample
    """

    size: tuple[int, ...]
    spacing: tuple[float, ...]
    origin: tuple[float, ...]

    def __post_init__(self) -> None:
        n = len(self.size)
        if not 1 <= n <= 3 or min(self.size) < 1:
            raise ValueError(f"a grid has 1 to 3 axes of at least one sample, not shape {self.size}")
        if len(self.spacing) != n or len(self.origin) != n:
            raise ValueError(f"spacing and origin need {n} numbers each, in {', '.join('xyz'[:n])}")
        if not all(math.isfinite(h) and h > 0 for h in self.spacing):
            raise ValueError(f"spacing {self.spacing} must be positive: turn the array round instead of a negative step")

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a scalar array, [z, y, x]."""
        return self.size

    @property
    def axes(self) -> tuple[Floats, ...]:
        """Coordinates along x, y, z."""
        lengths = reversed(self.size)
        steps = zip(self.origin, self.spacing, lengths, strict=True)
        return tuple(np.asarray(o + h * np.arange(n), dtype=np.float64) for o, h, n in steps)

    @property
    def is_cartesian(self) -> bool:
        """Whether the spacing is one for all axes (the thesis's Cartesian, or uniform, grid)."""
        return max(self.spacing) - min(self.spacing) <= 1e-12 * max(self.spacing)

    def points(self) -> Floats:
        """(count, 3) positions in x, y, z."""
        return lattice_points(self.axes)

    @property
    def bounds(self) -> Bounds:
        """(xmin, xmax, ymin, ymax, zmin, zmax)."""
        ends = [float(v) for a in self.axes for v in (a[0], a[-1])] + [0.0] * (2 * (3 - len(self.size)))
        return tuple(ends)  # type: ignore[return-value]  # six numbers


@dataclass(frozen=True, eq=False)
class Curvilinear(Grid):
    """A bent lattice.

    Parameters
    ----------
    nodes : (ny, nx, 3) or (nz, ny, nx, 3) positions in x, y, z
    """

    nodes: Floats

    def __post_init__(self) -> None:
        nodes = np.ascontiguousarray(self.nodes, dtype=float)
        if nodes.ndim not in (3, 4) or nodes.shape[-1] != 3:
            raise ValueError(f"nodes of a curvilinear grid are (ny, nx, 3) or (nz, ny, nx, 3), not {nodes.shape}")
        object.__setattr__(self, "nodes", nodes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a scalar array, [z, y, x]."""
        return self.nodes.shape[:-1]

    def points(self) -> Floats:
        """(count, 3) positions in x, y, z."""
        return self.nodes.reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Unstructured(Grid):
    """Cells with explicit topology.

    Parameters
    ----------
    nodes : (n, 3) positions in x, y, z
    offsets : (m + 1,) int, cell i is connectivity[offsets[i]:offsets[i + 1]]
    connectivity : int, nodes of the cells
    types : (m,) int, VTK's cell types: 3 line, 5 triangle, 9 quadrilateral, 10 tetrahedron, 12 hexahedron
    """

    nodes: Floats
    offsets: NDArray[np.int64]
    connectivity: NDArray[np.int64]
    types: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3:
            raise ValueError(f"nodes are (n, 3), not {self.nodes.shape}")
        if len(self.offsets) != len(self.types) + 1 or (len(self.offsets) and self.offsets[-1] != len(self.connectivity)):
            raise ValueError("offsets, connectivity and types of the cells do not agree")
        if len(self.connectivity) and not 0 <= self.connectivity.min() <= self.connectivity.max() < len(self.nodes):
            raise ValueError("a cell names a node that does not exist")

    @property
    def shape(self) -> tuple[int, ...]:
        """(n,)."""
        return (len(self.nodes),)

    @property
    def dimensions(self) -> int:
        """2 when all cells are flat, else 3."""
        return 2 if not np.isin(self.types, (10, 12, 13, 14)).any() else 3

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(self.types)

    def points(self) -> Floats:
        """(n, 3) positions in x, y, z."""
        return self.nodes


def lattice_of(grid: Grid) -> Regular:
    """The lattice of a structured grid in its own coordinates: spacing 1, origin 0."""
    n = len(grid.shape)
    return Regular(grid.shape, (1.0,) * n, (0.0,) * n, frame=grid.frame)


Axial = Regular | Rectilinear
"""Grids whose cells are boxes along the axes."""


def lattice_points(axes: Sequence[Floats]) -> Floats:
    """(n, 3) positions of the lattice of some axes (in x, y, z), x fastest; coordinates without an axis are 0."""
    mesh = np.meshgrid(*reversed(axes), indexing="ij")
    flat = [m.ravel() for m in reversed(mesh)]
    return np.column_stack([*flat, *[np.zeros(len(flat[0]))] * (3 - len(flat))])


def regular(
    shape: Sequence[int],
    spacing: ArrayLike | None = None,
    origin: ArrayLike | None = None,
    frame: Frame | None = None,
) -> Regular:
    """A regular grid for an array of `shape`; spacing 1 and origin 0 unless given (one number serves all axes)."""
    n = len(shape)

    def numbers(given: ArrayLike | None, default: float) -> tuple[float, ...]:
        array: Any = np.broadcast_to(np.asarray(default if given is None else given, dtype=float), (n,))
        return tuple(float(v) for v in array)

    return Regular(tuple(int(s) for s in shape), numbers(spacing, 1.0), numbers(origin, 0.0), frame=frame or Frame())
