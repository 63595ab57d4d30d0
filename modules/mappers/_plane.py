"""The plane in which lines are drawn: a rectangle of cells, a bent lattice, or triangles.

Each kind answers the same questions: the lines of a level, where they lie in space, what is known of the values there,
how steep the field is, and what is left between a segment and the exact contour.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.data.accuracy import EXACT, Accuracy, Source, Term
from modules.data.geometry import Cells, points_of
from modules.data.grid import Curvilinear, Rectilinear, Regular, Unstructured, lattice_of
from modules.data.laws import Linear, second_derivative
from modules.data.operators import Gather, Identity
from modules.data.wires import Model, Samples

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Check = Callable[[float], None]
TRIANGLE = 5

MOST_PIECES = 16
"""Of a cubic cell along each axis."""

STEPS = 16
"""Pieces of an arc in which its image on a bent lattice is measured."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Lines of all levels, in the plane.

    Parameters
    ----------
    points : (n, 2)
    lines : the points of each line; a closed one names its first point again
    segments : (s, 2) int, consecutive points
    cell, bend : (s,) the cell of each segment, and the bend of its exact arc
    line_level : (lines,)
    """

    points: Floats
    lines: Cells
    segments: Ints
    cell: Ints
    bend: Floats
    line_level: Floats

    @cached_property
    def of_point(self) -> Ints:
        """(n,) a segment that each point belongs to."""
        segment = np.zeros(len(self.points), np.int64)
        for end in (1, 0):
            segment[self.segments[:, end]] = np.arange(len(self.segments))
        return segment

    @cached_property
    def segment_level(self) -> Floats:
        """(s,) level of each segment."""
        return np.repeat(self.line_level, np.maximum(self.lines.sizes() - 1, 0))

    @cached_property
    def level(self) -> Floats:
        """(n,) level of each point."""
        return self.segment_level[self.of_point] if len(self.segments) else np.zeros(len(self.points))


class Rectangle:
    """Cells that are boxes along the axes: exact areas in closed form."""

    exact = True

    def __init__(self, model: Model) -> None:
        grid = model.grid
        assert isinstance(grid, Regular | Rectilinear)
        self.model, self.axes = model, grid.axes
        self.values = np.ascontiguousarray(model.samples.values, dtype=float)
        try:
            self.measure, self.unit = np.ones(2), grid.frame.length_unit(2)
        except ValueError:  # axes of different units: everything is measured in cells
            self.measure, self.unit = np.array([np.median(np.diff(a)) for a in grid.axes]), "cell"

    @property
    def cell(self) -> float:
        """Edge of a cell, for lengths in cells."""
        steps = [float(np.median(np.diff(a))) for a in self.axes]
        return float(np.sqrt(steps[0] * steps[1]))

    def draw(self, level: float, method: str, tolerance: float | None, check: Check) -> Any:
        """Lines of a level by a method; arcs leave at most `tolerance` of a cell, if given."""
        x, y = self.axes
        if method == "four_triangles":
            return kernels.triangles.four_triangles(self.values, x, y, level, check=check)
        lines = kernels.contour.lines(self.values, x, y, level, method != "basic", check=check)
        if tolerance is None:
            return lines
        row, column = np.divmod(lines.cell, len(x) - 1)
        return kernels.refine.refined(lines, tolerance * np.diff(x)[column] * np.diff(y)[row])

    def place(self, drawn: Drawn) -> Floats:
        """(n, 3) positions in space."""
        return points_of(drawn.points)

    def at(self, drawn: Drawn) -> Accuracy:
        """What is known of the values at the points."""
        return self.known(points_of(drawn.points))

    def known(self, points: Floats) -> Accuracy:
        """What is known of the values at any points (n, 3) of the plane."""
        return self.model.at(points)[1]

    def slope(self, drawn: Drawn) -> Floats:
        """(n,) the smaller slope of the two cells that meet at each point, per unit of length."""
        slope = np.full(len(drawn.points), np.inf)
        for end in (0, 1):
            at = drawn.segments[:, end]
            np.minimum.at(slope, at, self._steepness(drawn.points[at], drawn.cell))
        return slope

    def _steepness(self, points: Floats, cell: Ints) -> Floats:
        return np.asarray(np.hypot(*(g * m for g, m in zip(self._gradient(points, cell), self.measure, strict=True))))

    def _gradient(self, points: Floats, cell: Ints) -> tuple[Floats, Floats]:
        row, column, u, v = self.within(points, cell)
        hx, hy = np.diff(self.axes[0])[column], np.diff(self.axes[1])[row]
        f00, f10, f01, f11 = self.corners(row, column)
        return ((1 - v) * (f10 - f00) + v * (f11 - f01)) / hx, ((1 - u) * (f01 - f00) + u * (f11 - f10)) / hy

    def within(self, points: Floats, cell: Ints) -> tuple[Ints, Ints, Floats, Floats]:
        """Row and column of cells, and the position of a point in each."""
        x, y = self.axes
        row, column = np.divmod(cell, len(x) - 1)
        u = (points[:, 0] - x[column]) / np.diff(x)[column]
        return row, column, u, (points[:, 1] - y[row]) / np.diff(y)[row]

    def corners(self, row: Ints, column: Ints) -> tuple[Floats, Floats, Floats, Floats]:
        """f00, f10, f01, f11 of cells."""
        f = self.values
        return f[row, column], f[row, column + 1], f[row + 1, column], f[row + 1, column + 1]

    def bending(self, drawn: Drawn) -> Floats:
        """(n,) the larger |second derivative| of the field, per unit of length squared."""
        points, grid = points_of(drawn.points), self.model.grid
        weights = Linear().weights(grid, points)
        values = np.asarray(self.model.samples.values, float)
        parts = [
            np.abs(np.nan_to_num(weights.apply(second_derivative(grid, values, axis).ravel()))) * self.measure[axis] ** 2
            for axis in (0, 1)
        ]
        return np.asarray(np.maximum(*parts))

    def left(self, drawn: Drawn) -> tuple[Floats, Floats, Floats]:
        """Area, largest distance and difference of length between each segment and the exact contour."""
        step = (drawn.points[drawn.segments[:, 1]] - drawn.points[drawn.segments[:, 0]]) / self.measure
        given = (step[:, 0], step[:, 1], drawn.bend)
        longer = kernels.arcs.length(*given) - np.hypot(step[:, 0], step[:, 1])
        return kernels.arcs.area(*given), kernels.arcs.sagitta(*given), np.maximum(longer, 0.0)

    def saddles(self, cell: Ints) -> Floats:
        """(m, 3) positions of the saddle points of cells."""
        x, y = self.axes
        row, column = np.divmod(cell, len(x) - 1)
        u, v, _ = kernels.bilinear.saddle(*self.corners(row, column))
        px = x[column] + np.clip(u, 0, 1) * np.diff(x)[column]
        py = y[row] + np.clip(v, 0, 1) * np.diff(y)[row]
        return np.column_stack([px, py, np.zeros(len(px))])

    def decider(self, cell: Ints, level: float) -> tuple[Floats, Gather]:
        """N = f00 f11 - f10 f01 above the level, whose sign joins the corners, and its derivative by the samples."""
        row, column = np.divmod(cell, len(self.axes[0]) - 1)
        f00, f10, f01, f11 = (f - level for f in self.corners(row, column))
        nx = len(self.axes[0])
        index = (row * nx + column)[:, None] + np.array([0, 1, nx, nx + 1])
        return f00 * f11 - f10 * f01, Gather(index, np.column_stack([f11, -f01, -f10, f00]), self.model.grid.count)


class Smooth(Rectangle):
    """A cubic model, sampled so finely that bilinear pieces are within a thousandth of its range."""

    def __init__(self, model: Model) -> None:
        grid = model.grid
        if not isinstance(grid, Regular | Rectilinear):
            raise ValueError(f"contour draws a cubic model of a regular or rectilinear grid, not of a {grid.kind} one")
        self.smooth = model
        bend = Linear().largest(grid, np.asarray(model.samples.values, float))
        low, high = model.facts()["range"] or (0.0, 0.0)
        wanted = np.nanmax(bend, initial=0.0) / max(1e-3 * (high - low), np.finfo(float).tiny)
        self.pieces = int(np.clip(2 ** math.ceil(math.log2(max(1.0, math.sqrt(wanted)))), 2, MOST_PIECES))
        axes = tuple(_cut(axis, self.pieces) for axis in grid.axes)
        fine = Rectilinear(axes, frame=grid.frame)
        values = model.at(fine.points())[0].reshape(fine.shape)
        super().__init__(Model(samples=Samples(grid=fine, values=values, accuracy=EXACT), law=Linear(), accuracy=EXACT))

    def known(self, points: Floats) -> Accuracy:
        """What is known of the cubic values, and how far the bilinear pieces are from them."""
        n, grid = len(points), self.model.grid
        error = Linear().error(grid, self.values, points)
        source = Source("Cubic field in bilinear pieces", "mapping", "estimated", f"{self.pieces} a cell [cubic-in-pieces/1]")
        piece = Term(source, "signed", "value", self.smooth.unit, np.nan_to_num(error), Identity(n))
        return self.smooth.at(points)[1].add(piece)


class Bent(Rectangle):
    """A curvilinear grid: each cell is contoured in its own coordinates and mapped; areas are measured on the image."""

    exact = False

    def __init__(self, model: Model) -> None:
        bent = model.grid
        assert isinstance(bent, Curvilinear)
        flat = replace(model.samples, grid=lattice_of(bent))
        super().__init__(Model(samples=flat, law=model.law, accuracy=model.accuracy))
        self.nodes, self.measure = bent.nodes, np.ones(2)
        self.unit = bent.frame.length_unit(3 if np.ptp(bent.nodes[..., 2]) else 2)

    @property
    def cell(self) -> float:
        """Edge of a cell: the square root of the median of their areas."""
        along, up = np.diff(self.nodes, axis=1)[:-1], np.diff(self.nodes, axis=0)[:, :-1]
        return float(np.sqrt(np.nanmedian(np.linalg.norm(np.cross(along, up), axis=-1))))

    def place(self, drawn: Drawn) -> Floats:
        """(n, 3) positions in space."""
        segment = drawn.of_point
        return self._map(drawn.points, drawn.cell[segment]) if len(drawn.cell) else np.zeros((0, 3))

    def _map(self, points: Floats, cell: Ints) -> Floats:
        row, column, u, v = self.within(points, cell)
        p = self.nodes
        u, v = u[:, None], v[:, None]
        low = (1 - u) * p[row, column] + u * p[row, column + 1]
        high = (1 - u) * p[row + 1, column] + u * p[row + 1, column + 1]
        return np.asarray((1 - v) * low + v * high)

    def _steepness(self, points: Floats, cell: Ints) -> Floats:
        """Length of the gradient on the image: sqrt(g' M^-1 g), M the metric of the cell's map."""
        row, column, u, v = self.within(points, cell)
        p, (gu, gv) = self.nodes, self._gradient(points, cell)
        u, v = u[:, None], v[:, None]
        a = (1 - v) * (p[row, column + 1] - p[row, column]) + v * (p[row + 1, column + 1] - p[row + 1, column])
        b = (1 - u) * (p[row + 1, column] - p[row, column]) + u * (p[row + 1, column + 1] - p[row, column + 1])
        aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
        determinant = np.maximum(aa * bb - ab**2, np.finfo(float).tiny)
        return np.asarray(np.sqrt(np.maximum(bb * gu**2 - 2 * ab * gu * gv + aa * gv**2, 0) / determinant))

    def bending(self, drawn: Drawn) -> Floats:
        """(n,) the larger |second derivative| along the lattice, per unit of length squared."""
        return np.asarray(super().bending(drawn) / self.cell**2)

    def left(self, drawn: Drawn) -> tuple[Floats, Floats, Floats]:
        """Area, largest distance and difference of length, from the image of each arc at 17 points."""
        start, end = drawn.points[drawn.segments[:, 0]], drawn.points[drawn.segments[:, 1]]
        t = np.linspace(0, 1, STEPS + 1)
        arc = [kernels.arcs.point(start, end, drawn.bend, np.full(len(start), s)) for s in t]
        image = np.stack([self._map(p, drawn.cell) for p in arc])
        around = image - image[0]
        area = np.linalg.norm(np.cross(around[:-1], around[1:]).sum(axis=0), axis=1) / 2
        chord = around[-1]
        length = np.linalg.norm(chord, axis=1)
        along = np.einsum("ksd,sd->ks", around, chord / np.where(length > 0, length, 1.0)[:, None])
        off = np.sqrt(np.maximum((around**2).sum(axis=2) - along**2, 0.0)).max(axis=0)
        longer = np.linalg.norm(np.diff(image, axis=0), axis=2).sum(axis=0) - length
        return area, off, np.maximum(longer, 0.0)


class Triangles:
    """A field that is linear in each triangle: its contours are straight, nothing is left beside them."""

    exact = True

    def __init__(self, model: Model) -> None:
        grid = model.grid
        assert isinstance(grid, Unstructured)
        if (grid.types != TRIANGLE).any():
            raise ValueError("contour draws triangles of an unstructured grid; it has other cells: triangulate it first")
        self.model, self.nodes = model, grid.nodes
        self.faces = grid.connectivity.reshape(-1, 3)
        self.values = np.ascontiguousarray(model.samples.values, dtype=float)
        self.unit = grid.frame.length_unit(3 if np.ptp(grid.nodes[:, 2]) else 2)

    @property
    def cell(self) -> float:
        """Edge of a cell: the square root of twice the median area of the triangles."""
        p, q, r = (self.nodes[self.faces[:, k]] for k in range(3))
        return float(np.sqrt(np.median(np.linalg.norm(np.cross(q - p, r - p), axis=1)))) if len(self.faces) else 1.0

    def draw(self, level: float, method: str, tolerance: float | None, check: Check) -> Any:
        """Lines of a level; every method draws the same, for the field is linear."""
        return kernels.triangles.lines(self.nodes[:, :2], self.faces, self.values, level, check=check)

    def place(self, drawn: Drawn) -> Floats:
        """(n, 3) positions in space."""
        return np.column_stack([drawn.points, self._weights(drawn).apply(self.nodes[:, 2])])

    def at(self, drawn: Drawn) -> Accuracy:
        """What is known of the values at the points: errors of the nodes through the weights in a triangle."""
        return self.model.accuracy.push(self._weights(drawn))

    def _weights(self, drawn: Drawn) -> Gather:
        segment = drawn.of_point
        corner = self.faces[drawn.cell[segment]] if len(drawn.cell) else np.zeros((0, 3), np.int64)
        p, q, r = (self.nodes[corner[:, k], :2] for k in range(3))
        x = drawn.points
        whole = _turn(p, q, r)
        safe = np.where(whole == 0, 1.0, whole)
        weights = np.column_stack([_turn(x, q, r) / safe, _turn(p, x, r) / safe, _turn(p, q, x) / safe])
        return Gather(corner, np.clip(weights, 0.0, 1.0), len(self.nodes))

    def slope(self, drawn: Drawn) -> Floats:
        """(n,) the smaller slope of the two triangles that meet at each point, per unit of length."""
        p, q, r = (self.nodes[self.faces[drawn.cell, k]] for k in range(3))
        f, g, h = (self.values[self.faces[drawn.cell, k]] for k in range(3))
        normal = np.cross(q - p, r - p)
        twice = np.maximum((normal**2).sum(axis=1), np.finfo(float).tiny)
        gradient = np.cross(normal, (r - p) * (g - f)[:, None] - (q - p) * (h - f)[:, None]) / twice[:, None]
        slope = np.full(len(drawn.points), np.inf)
        for end in (0, 1):
            np.minimum.at(slope, drawn.segments[:, end], np.linalg.norm(gradient, axis=1))
        return slope

    def bending(self, drawn: Drawn) -> Floats:
        """(n,) zeros: a linear field does not bend."""
        return np.zeros(len(drawn.points))

    def left(self, drawn: Drawn) -> tuple[Floats, Floats, Floats]:
        """Zeros: the lines are exact."""
        nothing = np.zeros(len(drawn.segments))
        return nothing, nothing, nothing


Plane = Rectangle | Triangles


def plane_of(model: Model) -> Plane:
    """The plane of a model.

    Raises
    ------
    ValueError : the model is not two-dimensional, its values are no scalars, or its cells cannot be contoured
    """
    grid = model.grid
    if grid.dimensions != 2:
        raise ValueError(f"contour needs a plane of cells, got {grid.dimensions} dimensions: take a slice first")
    if model.samples.components != 1:
        raise ValueError(f"contour needs one value a sample, got {model.samples.components}: choose a component or the length")
    if model.law.name == "cubic":
        return Smooth(model)
    if model.law.name != "linear":
        raise ValueError(f"contour draws linear and cubic models; this one is {model.law.name}: choose another in interpolate")
    if isinstance(grid, Unstructured):
        return Triangles(model)
    return Bent(model) if isinstance(grid, Curvilinear) else Rectangle(model)


def _cut(axis: Floats, pieces: int) -> Floats:
    """The axis with each step cut in equal pieces, its own coordinates kept to the bit."""
    t = np.arange(pieces) / pieces
    return np.append((axis[:-1, None] + t * np.diff(axis)[:, None]).ravel(), axis[-1])


def _turn(p: Floats, q: Floats, r: Floats) -> Floats:
    return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])
