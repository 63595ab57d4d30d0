"""A model, or a series of them in time, as the field that the kernel marches through; and where seeds are in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Curvilinear, Model, Rectilinear, Regular, Unstructured
from modules.data.cubic import not_a_knot
from modules.data.grid import lattice_of
from modules.data.laws import Linear

if TYPE_CHECKING:
    from modules.kernels.trace import Traces
    from modules.kernels.trace_cell import Flow

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEWTON = 40
"""Most steps to find a position within a bent cell."""


@dataclass(frozen=True, eq=False)
class Medium:
    """A field, and seeds in it.

    Parameters
    ----------
    flow : the field in the direction of the march
    seeds : (p, 3) in coordinates of the march; NaN outside
    cells : (p,) tetrahedra of the seeds, -1 outside; None where cells are found by coordinates
    cell : a typical edge of a cell
    carries : whether errors of samples can be brought along: a steady linear field in boxes
    lattice : the bent grid whose lattice is marched through as if it were space; None in physical space
    """

    flow: Flow
    seeds: Floats
    cells: Ints | None
    cell: float
    carries: bool
    lattice: Curvilinear | None = None


def medium(
    models: Sequence[Model], sign: int, seeds: Floats, space: str = "physical", *, spline: bool = False
) -> Medium:
    """The field of a model, or of one model for each of several times, for particles from some seeds.

    Parameters
    ----------
    models : one for a steady flow; else in the order of their times
    sign : 1 forward, -1 backward
    seeds : (p, 3)
    space : physical, or computational: on a bent grid velocities are brought to the lattice at the samples and interpolated
        there, which is another field between them
    spline : through the samples goes a not-a-knot spline in place of the law of the model

    Raises
    ------
    ValueError : no vectors, a grid or law that cannot be marched through, models of different grids
    """
    model = models[0]
    for one in models:
        _check(one, model)
    grid, law = model.grid, model.law.name
    values = np.stack([np.asarray(one.samples.values, float) for one in models])
    times = np.array([one.samples.time for one in models], float) if len(models) > 1 else None
    common: dict[str, Any] = {"backwards": sign < 0, "times": times}
    if times is None:
        values = values[0]
    at = seeds.copy()
    if grid.dimensions == 2:
        at[:, 2] = 0.0
    if isinstance(grid, Regular | Rectilinear):
        if law not in ("linear", "nearest", "cubic"):
            raise ValueError(f"particles are followed through a linear, nearest or cubic model, not through a {law} one")
        edge = float(min(np.diff(a).min() for a in grid.axes))
        if spline:
            flow = kernels.trace_fields.flow_of(values, *grid.axes, spline=not_a_knot, **common)
            return Medium(flow, at, None, edge, False)
        flow = kernels.trace_fields.flow_of(values, *grid.axes, between=law, **common)
        return Medium(flow, at, None, edge, times is None and law == "linear")
    if spline:
        raise ValueError(f"a spline goes through samples on a regular or rectilinear grid, not on a {grid.kind} one")
    if law != "linear":
        raise ValueError(f"on a {grid.kind} grid particles are followed through a linear model, not through a {law} one")
    if isinstance(grid, Curvilinear):
        return _bent(grid, values, at, space, common)
    assert isinstance(grid, Unstructured)
    return _tetrahedra(grid, values, at, common)


def _check(model: Model, first: Model) -> None:
    if model.samples.components != 3:
        raise ValueError("particles follow a velocity: wire a model of vectors, two or three components a sample")
    grid = model.grid
    if isinstance(grid, Unstructured) and grid.dimensions < 3:
        raise ValueError("particles are followed in cells that fill space: this unstructured grid has flat cells")
    if not isinstance(grid, Unstructured) and grid.dimensions < 2:
        raise ValueError("particles are followed on grids of 2 or 3 axes")
    if model is not first and not grid.same_place(first.grid):
        raise ValueError("the models of a series must lie on one grid: resample them to it")


def _bent(grid: Curvilinear, values: Floats, at: Floats, space: str, common: dict[str, Any]) -> Medium:
    flow = kernels.trace_fields.bent_flow(values, grid.nodes, **common)
    edges = [np.linalg.norm(np.diff(grid.nodes, axis=a), axis=-1) for a in range(len(grid.shape))]
    edge = float(np.mean([e.mean() for e in edges]))
    seeds = located(grid, at)
    if space == "physical":
        return Medium(flow, seeds, None, edge, False)
    moved = on_lattice(grid, values)
    axes = [np.arange(n, dtype=float) for n in reversed(grid.shape)]
    flow = kernels.trace_fields.flow_of(moved, *axes, **common)
    return Medium(flow, seeds, None, edge, False, grid)


def _tetrahedra(grid: Unstructured, values: Floats, at: Floats, common: dict[str, Any]) -> Medium:
    import pyvista

    cells = np.insert(grid.connectivity, grid.offsets[:-1], np.diff(grid.offsets))
    whole = pyvista.UnstructuredGrid(cells, grid.types.astype(np.uint8), grid.nodes)
    if (grid.types != pyvista.CellType.TETRA).any():
        whole.point_data["node"] = np.arange(len(grid.nodes))
        whole = whole.triangulate()
    tetrahedra = whole.cells_dict.get(np.uint8(pyvista.CellType.TETRA), np.zeros((0, 4), np.int64)).astype(np.int64)
    if "node" in whole.point_data:
        tetrahedra = np.asarray(whole.point_data["node"])[tetrahedra].astype(np.int64)
    p = grid.nodes[tetrahedra]
    volume = np.abs(np.linalg.det(p[:, 1:] - p[:, :1])) / 6 if len(p) else np.zeros(0)
    reach = np.ptp(p, axis=1).max(axis=1) if len(p) else np.zeros(0)
    solid = volume > 1e-12 * reach**3
    if not solid.any():
        raise ValueError("the unstructured grid has no cell that fills space")
    flow = kernels.trace_fields.tetra_flow(values, grid.nodes, tetrahedra[solid], **common)
    inside = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: tetrahedra[solid]}, grid.nodes)
    found = np.atleast_1d(np.asarray(inside.find_containing_cell(at), np.int64))
    return Medium(flow, at, found, float(np.cbrt(6 * np.median(volume[solid]))), False)


def located(grid: Curvilinear, points: Floats) -> Floats:
    """(n, 3) coordinates in the lattice of a bent grid, by Newton's method in the cell that holds a point; NaN outside."""
    import pyvista

    nodes = grid.nodes if grid.nodes.ndim == 4 else grid.nodes[None]
    found = pyvista.StructuredGrid(*(np.ascontiguousarray(nodes[..., m].transpose(2, 1, 0)) for m in range(3)))
    inside = np.atleast_1d(np.asarray(found.find_containing_cell(points), np.int64))
    sizes = [max(n - 1, 1) for n in reversed(nodes.shape[:3])]
    cell = np.column_stack([inside % sizes[0], inside // sizes[0] % sizes[1], inside // (sizes[0] * sizes[1])])
    d = grid.dimensions
    lattice, linear = lattice_of(grid), Linear()
    at = cell + 0.5
    low, high = cell - 0.5, cell + 1.5
    flat = grid.nodes.reshape(-1, 3)
    top = np.array([n - 1.0 for n in reversed(grid.shape)])
    known = inside >= 0
    at[:, d:] = 0.0
    for _ in range(NEWTON):
        q = np.clip(at, 0.0, None)
        q[:, :d] = np.clip(at[:, :d], np.maximum(cell[:, :d] + 1e-12, 0.0), np.minimum(cell[:, :d] + 1 - 1e-12, top))
        away = points - np.column_stack([linear.weights(lattice, q).apply(flat[:, m]) for m in range(3)])
        slopes = np.stack([[s.apply(flat[:, m]) for s in linear.slopes(lattice, q)] for m in range(d)], axis=0)
        matrix = np.moveaxis(slopes, 2, 0)
        change = np.zeros((len(points), d))
        good = known & (np.abs(np.linalg.det(matrix)) > 0)
        change[good] = np.linalg.solve(matrix[good], away[good, :d, None])[..., 0]
        at[:, :d] = np.clip(q[:, :d] + change, low[:, :d], high[:, :d])
        if not good.any() or np.abs(change[good]).max() < 1e-13:
            break
    at[:, :d] = np.clip(at[:, :d], 0.0, top)
    at[~known] = np.nan
    return at


def on_lattice(grid: Curvilinear, values: Floats) -> Floats:
    """Velocities at the samples in coordinates of the lattice, by the derivative of the positions by central differences."""
    d = grid.dimensions
    lattice = [np.gradient(grid.nodes, axis=d - 1 - a) for a in range(d)]  # along x, y[, z] of the lattice
    matrix = np.stack(lattice, axis=-1)[..., :d, :]
    moved = np.zeros(values.shape)
    moved[..., :d] = np.linalg.solve(np.broadcast_to(matrix, (*values.shape[:-1], d, d)), values[..., :d, None])[..., 0]
    return moved


def in_space(grid: Curvilinear, traces: Traces) -> Traces:
    """A march through a lattice as one through space: positions, and to first order what is small beside them."""
    lattice, linear, flat = lattice_of(grid), Linear(), grid.nodes.reshape(-1, 3)
    d = grid.dimensions
    q = traces.points
    points = np.column_stack([linear.weights(lattice, q).apply(flat[:, m]) for m in range(3)])
    slopes = np.stack([[s.apply(flat[:, m]) for s in linear.slopes(lattice, q)] for m in range(3)])  # (3, d, n)
    small = ("velocity", "residual", "error", "local")
    carried = {name: np.einsum("mdn,nd->nm", slopes, getattr(traces, name)[:, :d]) for name in small}
    return traces._replace(points=points, **carried)
