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
    memo,
)
from modules.mappers._isosurface_accuracy import position
from modules.mappers._isosurface_elsewhere import elsewhere, is_plain
from modules.mappers._isosurface_methods import dots, draw, holes, why_unknown, within
from modules.mappers._isosurface_points import straightened
from modules.mappers._isosurface_together import together

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UNSEEN = "without inflection points tunnels through a cell are not seen"


@mapper(
    "Isosurface",
    version=3,
    aliases=("marching cubes", "level set", "contour surface", "accurate marching cubes"),
    output="surface",
)
def isosurface(
    model: Model,
    progress: Progress,
    *,
    level: Annotated[float | None, Range(of="model.range")] = None,
    method: Literal[
        "accurate", "classic", "decider", "four_triangles", "flying_edges", "tetrahedra_5", "tetrahedra_6", "tetrahedra_12",
        "tetrahedra_24", "cuberille", "discretized", "dividing", "subdivided",
    ] = "accurate",
    cuts: Annotated[int, Range(1, 20)] = 2,
    levels: Annotated[tuple[float, ...] | None, Range(of="model.range")] = None,
    normals: Literal["nodes", "cells", "triangles"] = "nodes",
    both_ways: bool = False,
    on_faces: bool = True,
    inside: bool = True,
    inflections: bool = True,
) -> Geometry:
    """The surface on which a three-dimensional field has a level, in triangles that look to the low side.

    The method 'accurate' has the topology of the trilinear model, tunnels through a cell too, and puts points where the
    surface bends most. The others are there for comparison: they may join the surface wrongly, and say so. Grids of
    tetrahedra and bent ones, and cubic models, are drawn too.

    Parameters
    ----------
    level : in the unit of the field; automatic: the middle of its range
    method : accurate; classic (the table of 1987, with its holes); decider (asymptotic decider, straight polygons);
        four_triangles (means of faces decide); flying_edges (VTK's); tetrahedra (5, 6, 12 or 24 a cell); cuberille (faces of
        boxes); discretized (crossings in the middle of edges); dividing (points only); subdivided (brute force)
    cuts : of a cell along each axis, for dividing and subdivided
    levels : several at once, instead of the one
    normals : for smooth light, from the slopes at the samples (nodes), of the cells' own polynomials (cells), or of the
        triangles; as values "normal" of the points
    both_ways : prove the distance from the surface to the triangles too: slow, and two to three times as large in the middle
    on_faces, inside : shoulder points on faces, and points inside cells, of 'accurate' are put where the surface bends most;
        else in the middle, where a straight polygon has them
    inflections : tunnels and bent-back polygons of 'accurate' are joined at inflection points; else they are not seen

    Raises
    ------
    ValueError : the model is not of single values in three dimensions, or its cells or law cannot be drawn

    Accuracy: errors of the model move the surface by error / slope, to first order (flagged where that fails). The
        distance of each triangle from the trilinear surface is proven; triangles for which only their size does so are flagged.
        The topology of 'accurate' is exact.
    Source: Lopes 1999, chapter 4, with the tunnels of configuration 13; Lorensen and Cline 1987; Schroeder 2015.
    """
    drawing: dict[str, Any] = {
        "method": method, "cuts": cuts, "normals": normals, "both_ways": both_ways, "on_faces": on_faces, "inside": inside,
        "inflections": inflections,
    }  # fmt: skip
    chosen = sorted(set(levels)) if levels is not None else [level]
    if not chosen:
        raise ValueError("levels names no level: give at least one, or leave it automatic")
    if len(chosen) > 1:
        n = len(chosen)
        return together(
            [isosurface(model, progress.part(i / n, (i + 1) / n), level=each, **drawing) for i, each in enumerate(chosen)]
        )
    if not is_plain(model):
        return elsewhere(model, progress, isosurface, level=chosen[0], **drawing)
    return _at(model, progress, chosen[0], **drawing)


def _at(
    model: Model, progress: Progress, level: float | None, *, method: Any, cuts: int, normals: str, both_ways: bool,
    on_faces: bool, inside: bool, inflections: bool,
) -> Geometry:
    """The surface at one level of a linear model on a grid of boxes."""
    values, axes, unit = _volume(model)
    chosen = _middle(values) if level is None else level
    if not np.isfinite(chosen):
        raise ValueError(f"the level must be a number, not {chosen}")
    accurate = method == "accurate"
    if accurate:
        points, triangles, cell = _accurate(model, values, axes, chosen, progress, inflections)
        if not (on_faces and inside):
            points = straightened(points, triangles, axes, not on_faces, not inside)
    else:
        points, triangles, cell = draw(method, values, axes, chosen, cuts, progress)
        if method == "dividing":
            return dots(model, points, cell, axes, chosen, cuts)
    progress.check()
    most = within(method, axes, cuts)
    accuracy, reach = position(
        model, axes, chosen, points, triangles, cell, method if inflections else "", unit or "", most,
        progress.part(0.7, 1.0).map, both_ways and accurate,
    )  # fmt: skip
    if not (accurate and inflections):
        accuracy = accuracy.miss(Missing("Topology of the surface", why_unknown(method) if not accurate else UNSEEN))
    open_here, flags = holes(points, triangles, axes) if method == "classic" else (None, [])
    return Geometry(
        points=points,
        polygons=Cells.of(triangles),
        values={
            "level": Field(np.full(len(triangles), chosen), "cell", model.unit),
            "distance": Field(reach, "cell", unit),
            "grid cell": Field(cell, "cell"),
            **({} if open_here is None else {"beside a hole": Field(open_here.astype(np.int64), "cell")}),
            **({} if normals == "triangles" else {"normal": Field(_down(values, axes, points, triangles, cell, normals))}),
        },
        cell=float(np.prod([np.median(np.diff(a)) for a in axes]) ** (1 / 3)),
        frame=model.grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy.flag(*flags),
    )


def _down(
    values: Floats, axes: tuple[Floats, Floats, Floats], points: Floats, triangles: Ints, cell: Ints, normals: str
) -> NDArray[np.float32]:
    """(n, 3) normals at the points, by the slopes at the nodes or in the cells; where these vanish, of the triangles."""
    normal: NDArray[np.float32]
    if normals == "nodes":
        normal = kernels.marching_normals.from_nodes(values, *axes, points)
    else:
        normal = kernels.marching_normals.from_cells(values, *axes, points, triangles, cell)
    flat = np.flatnonzero(~normal.any(axis=1))
    if len(flat):
        beside = triangles[np.isin(triangles, flat).any(axis=1)]
        p, q, r = (points[beside[:, c]] for c in range(3))
        turn, total = np.cross(q - p, r - p), np.zeros_like(points)
        for c in range(3):
            np.add.at(total, beside[:, c], turn)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        normal[flat] = (total / np.where(length > 0, length, 1))[flat]
    return normal


def _volume(model: Model) -> tuple[Floats, tuple[Floats, Floats, Floats], str]:
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
    x, y, z = grid.axes
    return np.ascontiguousarray(model.samples.values, dtype=float), (x, y, z), grid.frame.length_unit(3)


def _accurate(
    model: Model, values: Floats, axes: tuple[Floats, Floats, Floats], level: float, progress: Progress, bent: bool
) -> tuple[Floats, Ints, Ints]:
    """Points, triangles and their cells, in two or three passes; blocks that the level does not cross are passed by."""
    passes = iter((progress.part(0.0, 0.2), progress.part(0.2, 0.4), progress.part(0.4, 0.7)))
    drawn = kernels.marching.surface(
        values, *axes, level, slabs=lambda function, numbers: next(passes).map(function, numbers),
        index=memo(model, "blocks of the isosurface", lambda: kernels.marching.blocks(values)), bent=bent,
    )  # fmt: skip
    return drawn.points, drawn.triangles, drawn.cell


def _middle(values: Floats) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0
