"""The methods with which the accurate isosurface is compared: how each draws, and what it can say of itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Cells, Field, Flag, Geometry, Literal, Missing, Model, Progress, Source, Term
from modules.data.operators import Identity
from modules.mappers._isosurface_accuracy import displaced

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Axes = tuple[Floats, Floats, Floats]
Draw = Callable[[Floats, Axes, float, int], tuple[Floats, Ints, Ints]]

MOST = 1 << 27
"""Samples of a subdivision, at most."""

TABLE = "the table does not test ambiguous faces and tunnels"
LINEAR = "the pieces are linear, and diagonals decide how they join: the trilinear field may join otherwise"


class Method(NamedTuple):
    """How a method draws, and what is known of its topology.

    Attributes
    ----------
    draw : (values, axes, level, cuts) -> points (n, 3), triangles (m, 3), grid cell of each (m,)
    unknown : why its topology may be another than the trilinear model's
    within : (largest cell (3,), cuts) -> a distance from the surface that no point of it exceeds; None: there is none
    holes : whether it may leave holes
    """

    draw: Draw
    unknown: str
    within: Callable[[Floats, int], float] | None = None
    holes: bool = False


def _diagonal(cell: Floats, cuts: int) -> float:
    return float(np.linalg.norm(cell))


def _half(cell: Floats, cuts: int) -> float:
    return 0.5 * _diagonal(cell, cuts)


def _straight(rule: Literal["classic", "decider", "four_triangles"]) -> Draw:
    return lambda values, axes, level, cuts: kernels.straight.surface(values, *axes, level, rule)


def _tetrahedra(pieces: int) -> Draw:
    return lambda values, axes, level, cuts: kernels.tetrahedra.grid_surface(values, *axes, level, pieces)


METHODS: dict[str, Method] = {
    "classic": Method(_straight("classic"), TABLE + ", and neighbours may cut a face differently", holes=True),
    "decider": Method(_straight("decider"), "tunnels through a cell are not seen"),
    "four_triangles": Method(_straight("four_triangles"), "a face joins by the mean of its corners, not by its saddle"),
    "tetrahedra_5": Method(_tetrahedra(5), LINEAR),
    "tetrahedra_6": Method(_tetrahedra(6), LINEAR),
    "tetrahedra_12": Method(_tetrahedra(12), LINEAR),
    "tetrahedra_24": Method(_tetrahedra(24), LINEAR),
    "cuberille": Method(
        lambda values, axes, level, cuts: kernels.cubes.cuberille(values, *axes, level),
        "samples are boxes, which join by faces and edges",
        _half,
    ),
    "discretized": Method(
        lambda values, axes, level, cuts: kernels.cubes.discretized(values, *axes, level),
        "only on which side each sample lies is looked at",
        _diagonal,
    ),
    "subdivided": Method(
        lambda values, axes, level, cuts: kernels.cubes.subdivided(values, *axes, level, cuts),
        "what is thinner than a piece of a cell is not seen",
    ),
}
"""The methods that draw triangles by kernels of ours, by name."""

NAMES = ("accurate", "flying_edges", "dividing", *METHODS)


def draw(method: str, values: Floats, axes: Axes, level: float, cuts: int, progress: Progress) -> tuple[Floats, Ints, Ints]:
    """Points, triangles that look to the low side, and their cells.

    Raises
    ------
    ValueError : a subdivision has too many samples
    """
    if method == "flying_edges":
        return _flying_edges(values, axes, level, progress)
    refuse_too_many(method, values, cuts)
    if method == "dividing":
        points, cell = kernels.cubes.dividing(values, *axes, level, cuts)
        return points, np.zeros((0, 3), np.int64), cell
    points, triangles, cell = METHODS[method].draw(values, axes, level, cuts)
    return points, triangles, cell


def dots(model: Model, points: Floats, cell: Ints, axes: Axes, level: float, cuts: int) -> Geometry:
    """The points of dividing cubes; each is within half a diagonal of its box of the surface, which passes the box."""
    unit = model.grid.frame.length_unit(3)
    sizes = [np.diff(axis) / cuts for axis in axes]
    row, i = np.divmod(cell, len(sizes[0]))
    k, j = np.divmod(row, len(sizes[1]))
    half = 0.5 * np.sqrt(sizes[0][i] ** 2 + sizes[1][j] ** 2 + sizes[2][k] ** 2)
    source = Source(
        "Middles of boxes instead of the surface", "mapping", "proven", "half a diagonal of the box [dividing-cubes/1]"
    )
    slope = np.linalg.norm(model.gradient(points)[0], axis=1)
    accuracy = displaced(model, points, model.at(points)[1], slope, unit)
    accuracy = accuracy.add(Term(source, "bound", "position", unit, half, Identity(len(points))))
    return Geometry(
        points=points,
        vertices=Cells.of(np.arange(len(points))[:, None]),
        values={
            "level": Field(np.full(len(points), level), "cell", model.unit),
            "distance": Field(half, "cell", unit),
            "grid cell": Field(cell, "cell"),
        },
        cell=float(np.prod([np.median(np.diff(a)) for a in axes]) ** (1 / 3)),
        frame=model.grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy.miss(Missing("Topology of the surface", "points do not say how they join")),
    )


def refuse_too_many(method: str, values: Floats, cuts: int) -> None:
    """ValueError if a subdivision would not fit in memory."""
    if method not in ("subdivided", "dividing"):
        return
    if cuts < 1:
        raise ValueError(f"a cell cannot be cut in {cuts} pieces along an axis: give 1 or more")
    samples = values.size * cuts**3
    if samples > MOST:
        most = int((MOST / values.size) ** (1 / 3))
        raise ValueError(f"{cuts} pieces along each axis make {samples:.2g} samples: choose at most {max(1, most)} cuts")


def within(method: str, axes: Axes, cuts: int) -> float:
    """A distance from the surface that the method never exceeds; infinite if there is none."""
    rule = METHODS[method].within if method in METHODS else None
    return rule(np.array([np.diff(axis).max() for axis in axes]), cuts) if rule else np.inf


def why_unknown(method: str) -> str:
    """Why the topology of a method may be another than the model's."""
    return METHODS[method].unknown if method in METHODS else TABLE


def open_edges(points: Floats, triangles: Ints) -> Ints:
    """(e, 2) the edges, by their points, that have only one triangle."""
    ends = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    keys = np.sort(ends, axis=1) @ np.array([len(points), 1])
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    single: Ints = ends[first[count == 1]]
    return single


def holes(points: Floats, triangles: Ints, axes: Axes) -> tuple[NDArray[np.bool_], list[Flag]]:
    """(m,) whether a triangle has an open edge inside the grid, and a flag with their number."""
    edges = open_edges(points, triangles)
    low, high = (np.array([axis[end] for axis in axes]) for end in (0, -1))
    p, q = points[edges[:, 0]], points[edges[:, 1]]
    inside = ~(((p == low) & (q == low)) | ((p == high) & (q == high))).any(axis=1)
    bad = np.sort(edges[inside], axis=1) @ np.array([len(points), 1])
    keys = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 3, 2), axis=2) @ np.array([len(points), 1])
    beside: NDArray[np.bool_] = np.asarray(np.isin(keys, bad).any(axis=1))
    if not len(bad):
        return beside, []
    words = f"the surface is open along {len(bad)} edges inside the grid: neighbours cut their common face differently"
    return beside, [Flag("holes", words, "cell", np.flatnonzero(beside))]


def _flying_edges(values: Floats, axes: Axes, level: float, progress: Progress) -> tuple[Floats, Ints, Ints]:
    """VTK's filter on the lattice, moved to the axes."""
    import pyvista
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    if not np.isfinite(values).all():
        raise ValueError("method 'flying_edges' takes no samples that are not known: choose 'accurate'")
    lattice: Any = pyvista.ImageData(dimensions=values.shape[::-1])
    lattice.point_data["values"] = values.ravel()
    algorithm = vtkFlyingEdges3D()
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
    place = np.column_stack([np.interp(at[:, a], np.arange(len(axis)), axis) for a, axis in enumerate(axes)])
    return place, triangles, (k * size[1] + j) * size[0] + i
