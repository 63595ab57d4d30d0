"""The surface on which a field has a level, with the topology of the trilinear model and its error."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Annotated,
    Cells,
    Field,
    Geometry,
    Literal,
    Missing,
    Model,
    Progress,
    Range,
    Rectilinear,
    Regular,
    mapper,
)
from modules.mappers._isosurface_accuracy import position

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@mapper("Isosurface", aliases=("marching cubes", "level set", "contour surface", "accurate marching cubes"), output="surface")
def isosurface(
    model: Model,
    progress: Progress,
    *,
    level: Annotated[float | None, Range(of="model.range")] = None,
    method: Literal["accurate", "classic", "flying_edges"] = "accurate",
) -> Geometry:
    """The surface on which a three-dimensional field has a level, in triangles that look to the low side.

    The method 'accurate' has the topology of the trilinear model, tunnels through a cell too, and puts points where the
    surface bends most. The two others are the usual ones, for comparison: they may join the surface wrongly.

    Parameters
    ----------
    level : in the unit of the field; automatic: the middle of its range
    method : accurate, classic (the table of 1987) or flying_edges

    Raises
    ------
    ValueError : the model is not a linear one of single values on a regular or rectilinear grid of three dimensions

    Accuracy: errors of the model move the surface by error / slope, to first order (flagged where that fails). The
        distance of each triangle from the trilinear surface is proven; triangles for which that fails are flagged.
        The topology of 'accurate' is exact.
    Source: Lopes 1999, chapter 4, with the tunnels of configuration 13; Lorensen and Cline 1987; Schroeder 2015.
    """
    values, axes, unit = _volume(model)
    chosen = _middle(values) if level is None else level
    if not np.isfinite(chosen):
        raise ValueError(f"the level must be a number, not {chosen}")
    if method == "accurate":
        drawn = kernels.marching.surface(values, *axes, chosen, slabs=progress.map)
        points, triangles, cell = drawn.points, drawn.triangles, drawn.cell
    else:
        points, triangles, cell = _filtered(model, values, axes, chosen, method, progress)
    progress.check()
    accuracy, reach = position(model, axes, chosen, points, triangles, cell, method, unit or "")
    if method != "accurate":
        accuracy = accuracy.miss(Missing("Topology of the surface", "the table does not test ambiguous faces and tunnels"))
    return Geometry(
        points=points,
        polygons=Cells.of(triangles),
        values={
            "level": Field(np.full(len(triangles), chosen), "cell", model.unit),
            "distance": Field(reach, "cell", unit),
            "grid cell": Field(cell, "cell"),
        },
        cell=float(np.prod([np.median(np.diff(a)) for a in axes]) ** (1 / 3)),
        frame=model.grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def _volume(model: Model) -> tuple[Floats, tuple[Floats, ...], str]:
    """Values, axes and the unit of lengths of a model that can be drawn."""
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3:
        got = f"got a {grid.kind} one of {grid.dimensions}"
        raise ValueError(f"isosurface needs a regular or rectilinear grid of 3 dimensions, {got}")
    if model.samples.components != 1:
        raise ValueError(f"isosurface needs one value a sample, got {model.samples.components}: choose a component or length")
    if model.law.name != "linear":
        raise ValueError(f"isosurface draws linear models; this one is {model.law.name}: choose linear in interpolate")
    if min(grid.shape) < 2:
        raise ValueError(f"isosurface needs at least two samples along each axis, got {grid.shape}")
    return np.ascontiguousarray(model.samples.values, dtype=float), grid.axes, grid.frame.length_unit(3)


def _middle(values: Floats) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0


def _filtered(
    model: Model, values: Floats, axes: tuple[Floats, ...], level: float, method: str, progress: Progress
) -> tuple[Floats, Ints, Ints]:
    """Points, triangles that look to the low side, and their cells, by a filter of VTK on the lattice."""
    import pyvista

    if not np.isfinite(values).all():
        raise ValueError(f"method {method!r} takes no samples that are not known: choose 'accurate'")
    lattice: Any = pyvista.ImageData(dimensions=values.shape[::-1])
    lattice.point_data["values"] = values.ravel()
    algorithm = _filter(method)
    algorithm.SetInputData(lattice)
    algorithm.SetValue(0, level)
    algorithm.ComputeNormalsOff()
    algorithm.ComputeGradientsOff()
    algorithm.ComputeScalarsOff()
    mesh: Any = pyvista.wrap(progress.run(algorithm))
    at = np.asarray(mesh.points, float).reshape(-1, 3)
    triangles = np.asarray(mesh.faces, np.int64).reshape(-1, 4)[:, 1:]
    middle = at[triangles].mean(axis=1) if len(triangles) else np.zeros((0, 3))
    size = np.array(values.shape[::-1]) - 1
    i, j, k = np.clip(np.floor(middle).astype(np.int64), 0, size - 1).T
    cell = (k * size[1] + j) * size[0] + i
    place = [np.interp(at[:, a], np.arange(len(axis)), axis) for a, axis in enumerate(axes)]
    return np.column_stack(place), _turned(model, np.column_stack(place), triangles), cell


def _filter(method: str) -> Any:
    if method == "classic":
        from vtkmodules.vtkFiltersCore import vtkMarchingCubes

        return vtkMarchingCubes()
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    return vtkFlyingEdges3D()


def _turned(model: Model, points: Floats, triangles: Ints) -> Ints:
    """The triangles, all turned round if most of them look to the high side."""
    if not len(triangles):
        return triangles
    p, q, r = (points[triangles[:, c]] for c in range(3))
    slope = model.gradient((p + q + r) / 3)[0]
    outward = np.einsum("ij,ij->", np.cross(q - p, r - p), slope)
    return np.ascontiguousarray(triangles[:, ::-1]) if outward > 0 else triangles
