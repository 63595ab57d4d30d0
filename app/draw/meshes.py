"""Shapes as VTK data sets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import charts
from modules.data.geometry import Cells, Geometry, Primitive
from modules.data.grid import Curvilinear, Rectilinear, Regular
from modules.data.wires import Samples, Table

Floats = NDArray[np.float64]
ROUND = 48
"""Facets around a sphere."""


def frame(corners: Floats, without: tuple[int, int, int]) -> Any:
    """The sides of a box, corners in the order of `itertools.product`, but those that meet in one corner."""
    left_out = without[0] * 4 + without[1] * 2 + without[2]
    sides = [(a, a + step) for step in (1, 2, 4) for a in range(8) if not a & step]
    return poly(corners, lines=Cells.of(np.array([s for s in sides if left_out not in s])))


def cell_array(cells: Cells) -> Any:
    """Our cells as VTK's."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    array = vtkCellArray()
    offsets = np.ascontiguousarray(cells.offsets, np.int64)
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(_ids(cells.connectivity), deep=True))
    return array


def _ids(connectivity: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.ascontiguousarray(connectivity, np.int64)


def poly(points: Floats, *, vertices: Cells | None = None, lines: Cells | None = None, polygons: Cells | None = None) -> Any:
    """Points and cells as vtkPolyData."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    data, where = vtkPolyData(), vtkPoints()
    where.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    data.SetPoints(where)
    if vertices is not None:
        data.SetVerts(cell_array(vertices))
    if lines is not None:
        data.SetLines(cell_array(lines))
    if polygons is not None:
        data.SetPolys(cell_array(polygons))
    return data


def attach(data: Any, values: NDArray[Any], on: str) -> None:
    """The values that give the colours: on "point" or "cell"."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName("colour")
    where = data.GetPointData() if on == "point" else data.GetCellData()
    where.SetScalars(array)


def take_normals(data: Any, geometry: Geometry) -> bool:
    """The geometry's own normals at its points, values "normal", for smooth light; whether it has any."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    own = geometry.values.get("normal")
    if own is None or own.place != "point" or own.values.ndim != 2 or geometry.primitives:
        return False
    data.GetPointData().SetNormals(numpy_to_vtk(np.ascontiguousarray(own.values, np.float32), deep=True))
    return True


def one_each(n: int) -> Cells:
    """N points, each a cell of its own."""
    return Cells(np.arange(n + 1, dtype=np.int64), np.arange(n, dtype=np.int64))


def picked(cells: Cells, keep: NDArray[np.bool_]) -> Cells:
    """Only some of the cells."""
    sizes = cells.sizes()
    return Cells(np.concatenate([[0], np.cumsum(sizes[keep])]).astype(np.int64), cells.connectivity[np.repeat(keep, sizes)])


def lines_of(geometry: Geometry, keep: NDArray[np.bool_] | None = None) -> Any:
    """The lines of a geometry, or some of them."""
    cells = geometry.lines if keep is None else picked(geometry.lines, keep)
    return poly(geometry.points, lines=cells)


def segments_of(geometry: Geometry) -> Any:
    """Each segment of the lines as a line of its own, for values that lie on segments."""
    return poly(geometry.points, lines=Cells.of(geometry.segments()))


def dashes_of(geometry: Geometry, period: float) -> Any:
    """The lines cut into dashes of half a period, measured along each line."""
    points: list[Floats] = []
    sizes: list[int] = []
    for line in geometry.polylines():
        run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        for start in np.arange(0.0, run[-1], period) if run[-1] > 0 else ():
            end = min(start + 0.55 * period, run[-1])
            at = np.concatenate([[start], run[(run > start) & (run < end)], [end]])
            points.append(np.stack([np.interp(at, run, line[:, c]) for c in range(3)], axis=1))
            sizes.append(len(at))
    total = int(np.sum(sizes))
    cells = Cells(np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), np.arange(total, dtype=np.int64))
    return poly(np.concatenate(points) if points else np.zeros((0, 3)), lines=cells)


def points_of(geometry: Geometry) -> Any:
    """The vertices of a geometry; all its points if it names none."""
    vertices = geometry.vertices if len(geometry.vertices) else one_each(len(geometry.points))
    return poly(geometry.points, vertices=vertices)


def surface_of(geometry: Geometry, keep: NDArray[np.bool_] | None = None) -> Any:
    """Polygons, or some of them, and tessellated primitives, with texture coordinates if there are any."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    data = poly(geometry.points, polygons=geometry.polygons if keep is None else picked(geometry.polygons, keep))
    if geometry.texture_at is not None:
        data.GetPointData().SetTCoords(numpy_to_vtk(np.ascontiguousarray(geometry.texture_at, np.float32), deep=True))
    if not geometry.primitives:
        return data
    from vtkmodules.vtkFiltersCore import vtkAppendPolyData

    append = vtkAppendPolyData()
    if len(geometry.polygons):
        append.AddInputData(data)
    for primitive in geometry.primitives:
        append.AddInputData(tessellated(primitive))
    append.Update()
    return append.GetOutput()


def hatched(geometry: Geometry, which: NDArray[np.bool_], period: float) -> Any:
    """Some polygons, each on its own, with coordinates in an image of one stripe: diagonal, `period` from stripe to stripe."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    cells = picked(geometry.polygons, which)
    points = geometry.points[cells.connectivity]
    sizes, first = cells.sizes(), cells.offsets[:-1]
    normals = np.abs(np.cross(points[first + 1] - points[first], points[first + 2] - points[first])) if len(cells) else points
    across = np.repeat(np.argmax(normals, axis=1), sizes)  # the axis that the polygon lies across
    rest = np.array([[1, 2], [0, 2], [0, 1]])[across]
    along = np.take_along_axis(points, rest, axis=1).sum(axis=1) / (period * np.sqrt(2.0))
    data = poly(points, polygons=Cells(cells.offsets, np.arange(len(points), dtype=np.int64)))
    at = np.column_stack([along - np.floor(along.min(initial=0.0)), np.full(len(along), 0.5)]).astype(np.float32)
    data.GetPointData().SetTCoords(numpy_to_vtk(at, deep=True))
    return data


def tessellated(primitive: Primitive) -> Any:
    """A primitive as polygons or lines.

    Raises
    ------
    ValueError : a kind that nobody draws
    """
    from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkLineSource, vtkPlaneSource, vtkSphereSource

    def value(*names: str, default: Any = None) -> Any:
        found = next((primitive.values[n] for n in names if n in primitive.values), default)
        if found is None:
            raise ValueError(f"a {primitive.kind} needs {' or '.join(names)}; it has {', '.join(primitive.values)}")
        return np.asarray(found, float).ravel()

    if primitive.kind == "sphere":
        source = vtkSphereSource()
        source.SetCenter(*value("centre", "center"))
        source.SetRadius(float(value("radius")[0]))
        source.SetThetaResolution(ROUND)
        source.SetPhiResolution(ROUND // 2)
    elif primitive.kind == "line":
        source = vtkLineSource()
        source.SetPoint1(*value("start", "from"))
        source.SetPoint2(*value("end", "to"))
    elif primitive.kind == "box":
        source = vtkCubeSource()
        low, high = value("low", "from"), value("high", "to")
        source.SetBounds(low[0], high[0], low[1], high[1], low[2], high[2])
    elif primitive.kind == "plane":
        source = vtkPlaneSource()
        origin, u, v = _plane(value("origin", "centre"), value("normal"), float(value("size", default=[1.0])[0]))
        source.SetOrigin(*origin)
        source.SetPoint1(*(origin + u))
        source.SetPoint2(*(origin + v))
    else:
        raise ValueError(f"there is no primitive {primitive.kind!r} to draw: sphere, plane, line and box are")
    source.Update()
    return source.GetOutput()


def _plane(centre: Floats, normal: Floats, size: float) -> tuple[Floats, Floats, Floats]:
    """A corner and the two sides of a square around a centre, square to a normal."""
    n = normal / np.linalg.norm(normal)
    u = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    u *= size / np.linalg.norm(u)
    v = np.cross(n, u)
    return centre - (u + v) / 2, u, v


def quad(samples: Samples, height: int, width: int) -> Any:
    """The rectangle that samples of the plane cover, with coordinates in their image from the first centre to the last."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    x0, x1, y0, y1, z0, _ = samples.grid.bounds
    corners = np.array([[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]], float)
    data = poly(corners, polygons=Cells.of(np.array([[0, 1, 2, 3]])))
    u, v = 0.5 / width, 0.5 / height
    at = np.array([[u, v], [1 - u, v], [1 - u, 1 - v], [u, 1 - v]], np.float32)
    data.GetPointData().SetTCoords(numpy_to_vtk(at, deep=True))
    return data


def lattice(samples: Samples) -> Any:
    """Samples in space as VTK's image, rectilinear or structured grid; values as float.

    Raises
    ------
    ValueError : the grid is unstructured
    """
    import pyvista

    grid = samples.grid
    data: Any
    if isinstance(grid, Regular):
        extra = 3 - len(grid.spacing)
        size = (*reversed(grid.size), *[1] * extra)
        steps, origin = (*grid.spacing, *[1.0] * extra), (*grid.origin, *[0.0] * extra)
        data = pyvista.ImageData(dimensions=size, spacing=steps, origin=origin)
    elif isinstance(grid, Rectilinear):
        data = pyvista.RectilinearGrid(*grid.axes)
    elif isinstance(grid, Curvilinear):
        data = pyvista.StructuredGrid(*(np.moveaxis(grid.nodes, -1, 0)[c].T for c in range(3)))
    else:
        raise ValueError(f"a volume needs a lattice of samples, got a {grid.kind} grid")
    data.point_data["colour"] = np.asarray(samples.values, float).ravel()
    return data


CAP = 0.25
"""Half the width of the ends of error bars, in distances between them."""


def _between(points: Floats, upper: Floats, kind: str) -> Any:
    """A band between two curves, with gaps where a number is missing, or bars of error with ends."""
    top = np.column_stack([points[:, 0], upper, points[:, 2]])
    told = np.isfinite(np.hstack([points, top])).all(axis=1)
    n, both = len(points), np.nan_to_num(np.concatenate([points, top]))
    if kind == "band":
        i = np.flatnonzero(told[:-1] & told[1:])
        return poly(both, polygons=Cells.of(np.column_stack([i, i + 1, i + 1 + n, i + n])))
    i = np.flatnonzero(told)
    half = CAP * float(np.min(np.diff(np.unique(points[i, 0])), initial=np.inf))
    side = np.array([half if np.isfinite(half) else 0.5, 0.0, 0.0])
    ends = np.concatenate([both[i] - side, both[i] + side, both[i + n] - side, both[i + n] + side])
    m, first = len(i), np.arange(len(i)) + 2 * n
    bars = [np.column_stack([i, i + n]), np.column_stack([first, first + m])]
    bars.append(np.column_stack([first + 2 * m, first + 3 * m]))
    return poly(np.concatenate([both, ends]), lines=Cells.of(np.concatenate(bars)))


def chart_of(table: Table, x: str, y: str, kind: str, upper: str = "", logs: charts.Logs = charts.PLAIN) -> Any:
    """Two columns of a table as a curve, bars or a scatter in the plane; what lies between two as a band or bars of error.

    Parameters
    ----------
    logs : which axes are logarithmic: there exponents of ten are drawn, with gaps where a number is not above 0

    Raises
    ------
    ValueError : no such column
    """
    for name in (x, y, upper) if upper else (x, y):
        if name not in table.columns:
            raise ValueError(f"the table has no column {name!r}: it has {', '.join(table.columns)}")
    at = np.column_stack([charts.drawn(table.columns[name], log) for name, log in zip((x, y), logs, strict=True)])
    points = np.column_stack([at, np.zeros(len(at))])
    if kind == "scatter":
        return poly(points, vertices=one_each(len(points)))
    if kind == "curve":
        return poly(points, lines=Cells.of([list(range(len(points)))]))
    if upper:
        return _between(points, charts.drawn(table.columns[upper], logs[1]), kind)
    feet = points * [1.0, 0.0, 1.0]
    half = 0.4 * float(np.min(np.diff(np.unique(at[:, 0])), initial=np.inf))
    half = half if np.isfinite(half) else 0.5
    sides = np.array([half, 0.0, 0.0])
    corners = np.stack([feet - sides, feet + sides, points + sides, points - sides], axis=1).reshape(-1, 3)
    return poly(corners, polygons=Cells.of(np.arange(len(corners)).reshape(-1, 4)))
