"""Data sets of other programs as wires: their grid, one array, and the errors that lie beside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data import companions
from modules.data.accuracy import Flag, unknown
from modules.data.geometry import Cells, Field, Geometry
from modules.data.grid import Curvilinear, Frame, Grid, Rectilinear, Regular, Unstructured
from modules.data.wires import Samples


class ExchangeError(ValueError):
    """A data set or file that cannot be taken or given; the sentence says what to do."""


def taken(dataset: Any, name: str, content: str) -> Samples | Geometry:
    """The wire of a data set that is not ours.

    Raises
    ------
    ExchangeError : no such array, or on cells
    """
    import pyvista as pv

    time = _time(dataset)
    if isinstance(dataset, pv.PolyData):
        return _geometry(dataset, time)
    array = choose(dataset, name)
    values = np.array(dataset.point_data[array])
    if isinstance(dataset, pv.ImageData) and not np.allclose(np.asarray(dataset.direction_matrix), np.eye(3)):
        dataset = dataset.cast_to_structured_grid()
    grid = grid_in(dataset)
    extra = {1: (), 3: (3,), 9: (3, 3)}.get(values.size // max(1, len(values)))
    if extra is None:
        raise ExchangeError(f"{array!r} has {values.shape[1]} numbers a point; a scalar has 1, a vector 3, a tensor 9")
    flat = values.reshape(len(values), -1)
    beside = dataset.point_data
    try:
        accuracy = companions.found(array, flat, "", beside.keys(), beside.__getitem__, content=content)
    except ValueError as error:
        raise ExchangeError(str(error)) from None
    plane = _plane(dataset, grid)
    accuracy = replace(accuracy, flags=(plane,) if plane else ())
    return Samples(grid=grid, values=values.reshape(*grid.shape, *extra), name=array, accuracy=accuracy, time=time)


def choose(dataset: Any, name: str) -> str:
    """The point array to take: the named one, the active one, or the first that states no error of another."""
    names = list(dataset.point_data.keys())
    numbers = [n for n in names if np.asarray(dataset.point_data[n]).dtype.kind in "fiub"]
    plain = [n for n in numbers if not companions.is_companion(n, names)]
    if name:
        if name in names:
            return name
        there = ", ".join(plain) or "none"
        if name in dataset.cell_data:
            raise ExchangeError(f"{name!r} lies on cells: bring it to points with a filter; on points lie {there}")
        raise ExchangeError(f"there is no array {name!r}; on points lie {there}")
    active = dataset.point_data.active_scalars_name
    if active in plain:
        return str(active)
    if plain:
        return str(plain[0])
    cells = ", ".join(dataset.cell_data.keys())
    instead = f"; on cells lie {cells}: bring one to points" if cells else ""
    raise ExchangeError(f"no array of numbers lies on its points{instead}")


def grid_in(dataset: Any, shape: tuple[int, ...] | None = None, frame: Frame | None = None) -> Grid:
    """The grid of a data set; axes z and y of one sample are left out unless `shape` says otherwise."""
    import pyvista as pv

    frame = frame or Frame()
    if isinstance(dataset, pv.UnstructuredGrid):
        cells = _cells(dataset.GetCells())
        nodes, types = np.array(dataset.points, float), np.array(dataset.celltypes, np.int64)
        return Unstructured(nodes, cells.offsets, cells.connectivity, types, frame=frame)
    size = tuple(int(n) for n in reversed(dataset.dimensions))
    n = len(shape) if shape else next((3 - i for i in range(3) if size[i] > 1), 1)
    size = size[3 - n :]
    if isinstance(dataset, pv.ImageData):
        first = [e * s for e, s in zip(dataset.extent[::2], dataset.spacing, strict=True)]
        origin = tuple(float(o + f) for o, f in zip(dataset.origin, first, strict=True))
        return Regular(size, tuple(float(h) for h in dataset.spacing[:n]), origin[:n], frame=frame)
    if isinstance(dataset, pv.RectilinearGrid):
        axes = tuple(np.array(a, float) for a in (dataset.x, dataset.y, dataset.z))
        return Rectilinear(axes[:n], frame=frame)
    if isinstance(dataset, pv.StructuredGrid):
        size = size if n > 1 else (1, *size)
        return Curvilinear(np.array(dataset.points, float).reshape(*size, 3), frame=frame)
    raise ExchangeError(f"a {type(dataset).__name__} has no grid that is known here")


def cells_in(dataset: Any) -> tuple[Cells, Cells, Cells]:
    """Vertices, lines and polygons of a PolyData."""
    return _cells(dataset.GetVerts()), _cells(dataset.GetLines()), _cells(dataset.GetPolys())


def _cells(array: Any) -> Cells:
    """A copy of VTK's lists of points."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if array is None or not array.GetNumberOfCells():
        return Cells(np.zeros(1, np.int64), np.zeros(0, np.int64))
    parts = [vtk_to_numpy(part).astype(np.int64) for part in (array.GetOffsetsArray(), array.GetConnectivityArray())]
    return Cells(parts[0], parts[1])


def _geometry(dataset: Any, time: float | None) -> Geometry:
    if dataset.n_strips:
        dataset = dataset.triangulate()
    values: dict[str, Field] = {}
    for place, data in (("point", dataset.point_data), ("cell", dataset.cell_data)):
        for name in data:
            array = np.array(data[name])
            if array.dtype.kind in "fiub":
                values[name if name not in values else f"{name} ({place})"] = Field(array, place)  # type: ignore[arg-type]  # one of two words
    accuracy = unknown("the file says nothing of where its shapes may lie")
    vertices, lines, polygons = cells_in(dataset)
    return Geometry(
        points=np.array(dataset.points, float), vertices=vertices, lines=lines, polygons=polygons, values=values, time=time,
        accuracy=accuracy,
    )  # fmt: skip


def _plane(dataset: Any, grid: Grid) -> Flag | None:
    """A flag when a plane elsewhere than z = 0 was taken as z = 0."""
    low = float(dataset.bounds[4])
    if isinstance(grid, Regular | Rectilinear) and grid.dimensions < 3 and low:
        return Flag("plane", f"the samples lie in the plane z = {low:g} of the file; here it is z = 0")
    return None


def _time(dataset: Any) -> float | None:
    if "TimeValue" not in dataset.field_data:
        return None
    stored: NDArray[Any] = np.asarray(dataset.field_data["TimeValue"]).ravel()
    return float(stored[0]) if stored.size else None
