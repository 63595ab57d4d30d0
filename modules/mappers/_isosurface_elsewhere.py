"""Isosurfaces where the grid is not a box of boxes or the law is cubic: tetrahedra, bent lattices, refined models."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import EXACT, Cells, Curvilinear, Field, Geometry, Model, Progress, Rectilinear, Regular, Samples, Unstructured
from modules.data.accuracy import Source, Term
from modules.data.grid import lattice_of
from modules.data.laws import Linear
from modules.data.operators import Gather, Identity, scaling
from modules.mappers._contour_accuracy import FLATTEST
from modules.mappers._isosurface_accuracy import displaced, exact_topology

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Plain = Callable[..., Geometry]

TETRAHEDRON = 10
MOST_SAMPLES = 1 << 25
MOST_PIECES = 16

BENT = Source(
    "Triangles instead of the curved surface", "mapping", "estimated",
    "proven distance in the lattice times the largest stretch of the map there, and what the map bends at four points of a "
    "triangle [bent-triangles/1]",
)  # fmt: skip


def is_plain(model: Model) -> bool:
    """Whether the model is drawn as it is: linear on a regular or rectilinear grid, or not to be drawn at all."""
    grid = model.grid
    if grid.dimensions != 3 or model.samples.components != 1 or model.law.name == "nearest":
        return True
    return isinstance(grid, Regular | Rectilinear) and model.law.name == "linear"


def elsewhere(model: Model, progress: Progress, plain: Plain, *, level: float | None, **drawing: Any) -> Geometry:
    """The isosurface of another model, by `plain` where it can be brought to a grid of boxes."""
    values = np.asarray(model.samples.values, float)
    finite = values[np.isfinite(values)]
    if level is None:
        level = float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0
    if not np.isfinite(level):
        raise ValueError(f"the level must be a number, not {level}")
    if isinstance(model.grid, Unstructured):
        return _in_tetrahedra(model, level)
    if isinstance(model.grid, Curvilinear):
        return _bent(model, progress, plain, level, drawing)
    return _smooth(model, progress, plain, level, drawing)


def _in_tetrahedra(model: Model, level: float) -> Geometry:
    """The surface in tetrahedra, where the field is linear: every method draws the same."""
    grid = model.grid
    assert isinstance(grid, Unstructured)
    if (grid.types != TETRAHEDRON).any():
        raise ValueError("isosurface draws tetrahedra of an unstructured grid; it has other cells: cut them into tetrahedra")
    unit, tetrahedra = grid.frame.length_unit(3), grid.connectivity.reshape(-1, 4)
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    (points, triangles, cell), ends, share = kernels.tetrahedra.surface(grid.nodes, tetrahedra, values, level)
    known = model.accuracy.push(Gather(ends, np.column_stack([1 - share, share]), grid.count))
    slope = _least_at_points(_slopes(grid.nodes[tetrahedra[cell]], values[tetrahedra[cell]]), triangles, len(points))
    linear = "straight, as the linear field is in a tetrahedron [linear-tetrahedra/1]"
    straight = Source("Triangles in tetrahedra", "mapping", "exact", linear)
    moved = known.push(scaling(1 / np.maximum(slope, FLATTEST)), quantity="position", unit=unit)
    accuracy = moved.add(
        Term(straight, "bound", "position", unit, np.asarray(0.0), Identity(len(points))),
        exact_topology(len(points), unit, "that of the linear field in tetrahedra [linear-tetrahedra/1]"),
    )
    size = np.median(np.abs(np.linalg.det(np.diff(grid.nodes[tetrahedra], axis=1)))) if len(tetrahedra) else 1.0
    return Geometry(
        points=points,
        polygons=Cells.of(triangles),
        values={
            "level": Field(np.full(len(triangles), level), "cell", model.unit),
            "distance": Field(np.zeros(len(triangles)), "cell", unit),
            "grid cell": Field(cell, "cell"),
        },
        cell=float(np.cbrt(size)),
        frame=grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def _slopes(corner: Floats, value: Floats) -> Floats:
    """(m,) |grad F| in tetrahedra (m, 4, 3) with values (m, 4)."""
    if not len(corner):
        return np.zeros(0)
    gradient = np.linalg.solve(corner[:, 1:] - corner[:, :1], (value[:, 1:] - value[:, :1])[..., None])[..., 0]
    return np.asarray(np.linalg.norm(gradient, axis=1))


def _least_at_points(of_triangle: Floats, triangles: Ints, points: int) -> Floats:
    least = np.full(points, np.inf)
    np.minimum.at(least, triangles.ravel(), np.repeat(of_triangle, 3))
    return least


def _bent(model: Model, progress: Progress, plain: Plain, level: float, drawing: dict[str, Any]) -> Geometry:
    """On a bent lattice: drawn in the cells' own coordinates, where the topology is exact, and mapped to space."""
    grid = model.grid
    assert isinstance(grid, Curvilinear)
    unit, lattice = grid.frame.length_unit(3), lattice_of(grid)
    flat = replace(model.samples, grid=lattice, accuracy=EXACT)
    drawing = {**drawing, "normals": "triangles"}  # those of the lattice are not those of space
    drawn = plain(Model(samples=flat, law=model.law, accuracy=EXACT), progress, level=level, **drawing)
    at = drawn.points
    own = Model(samples=replace(flat, accuracy=model.samples.accuracy), law=model.law, accuracy=model.accuracy)
    points, along = _mapped(grid, at)
    slope, stretch = _through(along, own.gradient(at)[0])
    known = own.at(at)[1]
    accuracy = displaced(own, at, known, slope, unit)
    accuracy = replace(accuracy, missing=tuple(dict.fromkeys([*accuracy.missing, *drawn.accuracy.missing])))
    accuracy = accuracy.add(*(replace(t, unit=unit) for t in drawn.accuracy.terms if t.name == "Topology of the surface"))
    values = dict(drawn.values)
    triangles = drawn.triangles
    if len(triangles):
        reach, farthest = _bent_reach(grid, at, points, triangles, drawn.values["distance"].values, stretch)
        values["distance"] = Field(np.where(np.isfinite(reach), reach, np.nan), "cell", unit)
        accuracy = accuracy.add(Term(BENT, "bound", "position", unit, farthest, Identity(len(points))))
        accuracy = accuracy.flag(*drawn.accuracy.flags)
        handed = np.linalg.det(along[triangles].mean(axis=1))
        triangles = np.where(handed[:, None] < 0, triangles[:, ::-1], triangles)
    size = float(np.nanmedian(np.linalg.norm(np.diff(grid.nodes, axis=2), axis=-1))) or 1.0
    polygons = Cells.of(triangles) if len(triangles) else drawn.polygons
    return replace(drawn, points=points, polygons=polygons, values=values, cell=size, accuracy=accuracy)


def _mapped(grid: Curvilinear, at: Floats) -> tuple[Floats, Floats]:
    """(n, 3) positions in space of points of the lattice, and (n, 3, 3) the derivative of x, y, z (last) along each axis."""
    lattice, law = lattice_of(grid), Linear()
    weights, slopes = law.weights(lattice, at), law.slopes(lattice, at)
    node = grid.nodes.reshape(-1, 3)
    points = np.stack([weights.apply(node[:, c]) for c in range(3)], axis=-1)
    along = np.stack([np.stack([s.apply(node[:, c]) for c in range(3)], axis=-1) for s in slopes], axis=1)
    return points, along


def _through(along: Floats, gradient: Floats) -> tuple[Floats, Floats]:
    """|grad F| in space, and the largest stretch of the map, at each point."""
    values = np.linalg.svd(along, compute_uv=False) if len(along) else np.zeros((0, 3))
    flat = values[:, 2] <= 1e-12 * values[:, 0]  # a collapsed cell: the slope there is not bounded
    safe = np.where(flat[:, None, None], np.eye(3), along)
    slope = np.linalg.norm(np.linalg.solve(safe, gradient[..., None])[..., 0], axis=1) if len(along) else np.zeros(0)
    return np.where(flat, np.inf, slope), np.asarray(values[:, 0])


def _bent_reach(
    grid: Curvilinear, at: Floats, points: Floats, triangles: Ints, lattice_reach: Floats, stretch: Floats
) -> tuple[Floats, Floats]:
    """Estimated distance of each triangle, and the largest at each point."""
    sag = np.zeros(len(triangles))
    for weights in ((0.5, 0.5, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5), (1 / 3, 1 / 3, 1 / 3)):
        w = np.array(weights)
        image = _mapped(grid, np.einsum("c,mca->ma", w, at[triangles]))[0]
        sag = np.maximum(sag, np.linalg.norm(image - np.einsum("c,mca->ma", w, points[triangles]), axis=1))
    reach = lattice_reach * stretch[triangles].max(axis=1) + sag
    farthest = np.zeros(len(points))
    np.maximum.at(farthest, triangles.ravel(), np.repeat(np.nan_to_num(reach, nan=0.0, posinf=0.0), 3))
    return reach, farthest


def _smooth(model: Model, progress: Progress, plain: Plain, level: float, drawing: dict[str, Any]) -> Geometry:
    """A cubic model in trilinear pieces, so many that they stay within a thousandth of its range where memory allows."""
    grid = model.grid
    assert isinstance(grid, Regular | Rectilinear)
    values = np.asarray(model.samples.values, float)
    pieces = pieces_of(model)
    axes = tuple(np.append((a[:-1, None] + np.arange(pieces) / pieces * np.diff(a)[:, None]).ravel(), a[-1]) for a in grid.axes)
    fine = Rectilinear(axes, frame=grid.frame)
    layers = progress.map(lambda z: model.at(_plane(axes, z))[0], axes[2])
    sampled = np.concatenate(layers).reshape(fine.shape)
    samples = Samples(
        grid=fine, values=sampled, unit=model.unit, name=model.samples.name, time=model.samples.time, accuracy=EXACT
    )
    drawn = plain(Model(samples=samples, law=Linear(), accuracy=EXACT), progress, level=level, **drawing)
    at, unit = drawn.points, grid.frame.length_unit(3)
    rule = f"{pieces} a cell along each axis, second differences between them [cubic-in-pieces/1]"
    source = Source("Cubic field in trilinear pieces", "mapping", "estimated", rule)
    error = np.nan_to_num(Linear().error(fine, sampled, at))
    known = model.at(at)[1].add(Term(source, "signed", "value", model.unit, error, Identity(len(at))))
    slope = np.linalg.norm(model.gradient(at)[0], axis=1)
    accuracy = displaced(model, at, known, slope, unit)
    accuracy = accuracy.add(*drawn.accuracy.terms).flag(*drawn.accuracy.flags)
    accuracy = accuracy.miss(*drawn.accuracy.missing)
    cell = kernels.cubes.coarse_cell(np.asarray(drawn.values["grid cell"].values, np.int64), values.shape, pieces)
    coarse = {**drawn.values, "grid cell": Field(cell, "cell")}
    return replace(drawn, values=coarse, cell=(drawn.cell or 1.0) * pieces, accuracy=accuracy)


def _plane(axes: tuple[Floats, ...], z: float) -> Floats:
    """(n, 3) the points of a lattice at one height, x fastest."""
    y, x = np.meshgrid(axes[1], axes[0], indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def pieces_of(model: Model) -> int:
    """Pieces of a cell along each axis: a power of two, as many as accuracy asks for and memory allows."""
    grid = model.grid
    bend = Linear().largest(grid, np.asarray(model.samples.values, float))
    low, high = model.facts()["range"] or (0.0, 0.0)
    wanted = np.nanmax(bend, initial=0.0) / max(1e-3 * (high - low), np.finfo(float).tiny)
    pieces = int(np.clip(2 ** math.ceil(math.log2(max(1.0, math.sqrt(wanted)))), 2, MOST_PIECES))
    while pieces > 2 and grid.count * pieces**3 > MOST_SAMPLES:
        pieces //= 2
    if grid.count * pieces**3 > MOST_SAMPLES:
        size = f"a cubic model of {grid.count} samples"
        raise ValueError(f"{size} is too large to be cut in pieces: crop it, or choose law 'linear'")
    return pieces
