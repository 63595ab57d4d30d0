"""An isosurface with few triangles, all proven to lie within a tolerance of the surface of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Annotated,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    Literal,
    Model,
    Progress,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    mapper,
    select,
)
from modules.mappers._isosurface_accuracy import displaced

if TYPE_CHECKING:
    from modules.kernels.mesh_split import Mesh

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

RULE = "Bernstein coefficients over the least slope in the swept box, in 16 pieces; largest at a point [triangle-pieces/1]"
WHY = "the triangles it was of are replaced by others, whose distance is proven anew"
ROUNDS = 8
"""Of the recursion at G."""
ON = 1e-6
"""Of the range of the values: a point that is farther from the level does not lie on the surface."""


@mapper(
    "Refine surface",
    aliases=("decimate", "adaptive", "simplify", "tolerance", "split triangles", "fewest triangles"),
    output="surface",
)
def refine_surface(
    surface: Geometry,
    model: Model,
    progress: Progress,
    *,
    tolerance: Annotated[float, Range(1e-4, 0.5, log=True, unit="cell")] = 0.02,
    method: Literal["edges", "centres"] = "edges",
    merge: bool = True,
    most: Annotated[int, Range(1_000, 20_000_000, log=True)] = 5_000_000,
) -> Geometry:
    """An isosurface with as few triangles as a tolerance allows, each proven to lie within it.

    Triangles that are too far are cut at points on the surface, without cracks; then points that are not needed are merged
    away. The way it is joined never changes.

    Parameters
    ----------
    surface : of 'isosurface', by a method whose points lie on the surface: accurate, decider, classic, flying_edges
    model : of which it was drawn
    tolerance : largest distance of a triangle from the surface, as a part of a cell
    method : edges (cut where they are farthest), or centres (a triangle becomes three at its point G, as in the thesis: it
        stalls, for edges are never cut)
    merge : away what is not needed; else triangles are only cut
    most : triangles

    Raises
    ------
    ValueError : no isosurface of this model, a tolerance that cannot be proven, or more triangles than the limit

    Accuracy: the distance of each triangle is proven, rounding included; those for which the tolerance is not reached are
        flagged. Errors of the model move the points by error / slope, to first order.
    Source: Lopes 1999, 4.4 and 4.5; the stop is a proof instead of the estimate at G.
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance must be positive, not {tolerance:g}")
    axes, level = _asked(surface, model)
    edge = surface.cell or float(np.prod([np.median(np.diff(a)) for a in axes]) ** (1 / 3))
    values = np.asarray(model.samples.values, float)
    triangles, cell = surface.triangles, np.asarray(surface.values["grid cell"].values, np.int64)
    parts, levels = [], np.unique(level)
    for n, one in enumerate(levels):
        share = progress.part(n / len(levels), (n + 1) / len(levels))
        field = kernels.mesh_proof.Field(values, *axes, float(one))
        here = level == one
        used, ids = np.unique(triangles[here], return_inverse=True)
        mesh = surface.points[used], ids.reshape(-1, 3).astype(np.int64), cell[here]
        if method == "edges":
            done = kernels.mesh_refine.refined(
                field, *mesh, tolerance * edge, merge=merge, most=most, slabs=progress.map, check=share
            )
        else:
            asked = field.asked(tolerance * edge)
            done = kernels.mesh_centre.recursed(field, *mesh, asked, ROUNDS, most, slabs=progress.map)
        parts.append((float(one), done))
    return _geometry(surface, model, values, axes, tolerance * edge, parts)


def _asked(surface: Geometry, model: Model) -> tuple[tuple[Floats, Floats, Floats], Floats]:
    """The axes of the model, and the level of each triangle."""
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or model.law.name != "linear":
        raise ValueError("surfaces are refined of linear models on regular or rectilinear grids of 3 dimensions")
    only = surface.counts["cell"] == len(surface.polygons) and (surface.polygons.sizes() == 3).all()
    if not {"grid cell", "level"} <= set(surface.values) or not only:
        raise ValueError("refining needs triangles that know their level and grid cell: wire the surface of 'isosurface'")
    x, y, z = grid.axes
    level = np.asarray(surface.values["level"].values, float)
    cell = np.asarray(surface.values["grid cell"].values, np.int64)
    corner = surface.triangles
    if len(cell) and not 0 <= cell.min() <= cell.max() < grid.cells:
        raise ValueError(f"the surface passes cell {cell.max()} of {grid.cells}: wire the model it was drawn of")
    values = np.asarray(model.samples.values, float)
    size = float(np.nanmax(np.abs(values), initial=0.0)) + float(np.abs(level).max(initial=0.0))
    at, _ = model.at(surface.points)
    away = np.zeros(len(surface.points))
    for c in range(3):
        np.maximum.at(away, corner[:, c], np.abs(np.asarray(at)[corner[:, c]] - level))
    off = int((~(away <= ON * size)).sum())
    if off:
        raise ValueError(
            f"{off} of {len(away)} points do not lie on the surface of this model: wire the model it was drawn of, and a "
            "method that puts points on the surface, such as 'accurate'"
        )
    return (x, y, z), level


def _geometry(
    surface: Geometry, model: Model, values: Floats, axes: tuple[Floats, Floats, Floats], tolerance: float,
    parts: list[tuple[float, Mesh]],
) -> Geometry:  # fmt: skip
    """The meshes of all levels as one."""
    unit = model.grid.frame.length_unit(3)
    first = np.cumsum([0, *(len(mesh.points) for _, mesh in parts)])
    points = np.concatenate([np.zeros((0, 3)), *(mesh.points for _, mesh in parts)])
    triangles = np.concatenate(
        [np.zeros((0, 3), np.int64), *(mesh.triangles + n for n, (_, mesh) in zip(first[:-1], parts, strict=True))]
    )
    cell = np.concatenate([np.zeros(0, np.int64), *(mesh.cell for _, mesh in parts)])
    reach = np.concatenate([np.zeros(0), *(mesh.reach for _, mesh in parts)])
    slope = [kernels.marching_distance.distances(values, *axes, level, mesh.points, mesh.triangles, mesh.cell)[1]
             for level, mesh in parts]  # fmt: skip
    proven = np.isfinite(reach)
    farthest = np.zeros(len(points))
    np.maximum.at(farthest, triangles.ravel(), np.repeat(np.where(proven, reach, 0.0), 3))
    source = Source("Triangles instead of the curved surface", "mapping", "proven", RULE)
    accuracy = displaced(model, points, model.at(points)[1], np.concatenate([np.zeros(0), *slope]), unit or "")
    accuracy = accuracy.add(
        Term(source, "bound", "position", unit or "", farthest, Identity(len(points))), *_topology(surface, len(points))
    )
    accuracy = accuracy.miss(*surface.accuracy.missing).flag(*_flags(reach, tolerance))
    normals = "normal" in surface.values
    return Geometry(
        points=points,
        polygons=Cells.of(triangles),
        values={
            "level": Field(np.repeat([level for level, _ in parts], [len(m.triangles) for _, m in parts]), "cell", model.unit),
            "distance": Field(np.where(proven, reach, np.nan), "cell", unit or ""),
            "grid cell": Field(cell, "cell"),
            **({"normal": Field(kernels.marching_normals.from_nodes(values, *axes, points))} if normals else {}),
        },
        cell=surface.cell,
        frame=surface.frame,
        name=surface.name,
        time=surface.time,
        accuracy=accuracy.end_from(surface.accuracy, WHY),
    )


def _topology(surface: Geometry, points: int) -> list[Term]:
    """What is known of the way the surface is joined goes on: refining never changes it."""
    known = [t for t in surface.accuracy.terms if t.source.name == "Topology of the surface" and t.count]
    return [t.push(select(np.zeros(points, np.int64), t.count)) for t in known]


def _flags(reach: Floats, tolerance: float) -> list[Flag]:
    flags = []
    unproven, far = np.flatnonzero(~np.isfinite(reach)), np.flatnonzero(np.isfinite(reach) & (reach > tolerance))
    if len(unproven):
        words = f"no distance could be proven for {len(unproven)} of {len(reach)} triangles: the slope may vanish beside them"
        flags.append(Flag("unproven", words, "cell", unproven))
    if len(far):
        most = reach[far].max()
        words = f"the tolerance is not reached by {len(far)} of {len(reach)} triangles; the farthest is {most:.3g} away"
        flags.append(Flag("tolerance not reached", words, "cell", far, reach[far]))
    return flags

