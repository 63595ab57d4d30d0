"""Scattered points joined by triangles or tetrahedra, so that a model may lie between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modules.api import Annotated, Flag, Range, Samples, Unstructured, modeller
from modules.modellers._scattered import points_of


@modeller("Triangulate", output="samples", aliases=("delaunay", "tin", "mesh points", "scattered data", "tetrahedralise"))
def triangulate(samples: Samples, *, longest: Annotated[float | None, Range(0, 1000)] = None) -> Samples:
    """The points as corners of Delaunay's triangles, or of tetrahedra if they lie in space.

    Parameters
    ----------
    samples : data with positions; what has no value is left out, samples at one place are averaged
    longest : edge of a triangle; longer ones are left out, as they lie at the rim or across gaps; automatic keeps all

    Raises
    ------
    ValueError : too few points, all on one line, or no triangle that is small enough

    Accuracy: errors of the samples stay as they are; those of samples at one place are averaged.
    Source: Delaunay 1934.
    """
    from scipy.spatial import Delaunay

    found = points_of(samples)
    d = found.at.shape[1]
    size = float(np.ptp(found.at, axis=0).max())
    cells = Delaunay((found.at - found.at.mean(axis=0)) / size).simplices
    if longest is not None:
        corners = found.at[cells]
        edges = np.linalg.norm(corners[:, :, None, :] - corners[:, None, :, :], axis=3).max(axis=(1, 2))
        cells = cells[edges <= longest]
        if not len(cells):
            raise ValueError(f"every triangle has an edge longer than {longest:g}; the shortest of these is {edges.min():g}")
    nodes = np.zeros((len(found.at), 3))
    nodes[:, :d] = found.at
    offsets = np.arange(len(cells) + 1, dtype=np.int64) * (d + 1)
    types = np.full(len(cells), 5 if d == 2 else 10, np.int64)
    grid = Unstructured(nodes, offsets, cells.astype(np.int64).ravel(), types, frame=samples.grid.frame)
    extra = samples.values.shape[len(samples.grid.shape) :]
    accuracy = samples.accuracy.push(found.merge)
    if found.twice:
        accuracy = accuracy.flag(Flag("averaged", f"{found.twice} samples lay where others did, and were averaged with them"))
    return replace(samples, grid=grid, values=found.values.reshape(len(nodes), *extra), accuracy=accuracy)
