"""The grid that samples lie on, as lines (thesis 2.2, figure 2.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Geometry,
    Range,
    Samples,
    Unstructured,
    exactly,
    mapper,
)

Ints = NDArray[np.int64]

MOST = 20_000_000
"""More nodes along lines are refused: they would fill the picture and the memory."""

EDGES: dict[int, tuple[tuple[int, int], ...]] = {
    3: ((0, 1),),
    10: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    12: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    13: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    14: ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
}
"""VTK's cell type -> its edges; flat cells run round their nodes."""
FLAT = (5, 7, 9)


@mapper("Grid lines", aliases=("wireframe", "mesh lines", "cells", "lattice", "taxonomy"), output="lines")
def grid_lines(samples: Samples, *, every: Annotated[int, Range(1, 100)] = 1) -> Geometry:
    """The grid of samples as lines through their positions.

    Parameters
    ----------
    samples : on any grid
    every : only every so-many-th line of each direction, and the last; an unstructured grid is always drawn whole

    Raises
    ------
    ValueError : every is less than 1, the grid is too large to be drawn, or has cells of a kind that is not known

    Accuracy: positions are those of the samples; errors of position go on. Errors of the values end here, for grid lines
        show where the samples are, not what they are.
    Source: Lopes 1999, 2.2 and figure 2.1.
    """
    if every < 1:
        raise ValueError(f"every must be at least 1, not {every}")
    grid = samples.grid
    points = grid.points()
    if isinstance(grid, Unstructured):
        lines = Cells.of(_edges(grid))
        axis = np.zeros(len(lines), np.int64)
    else:
        lines, axis = _lattice(grid.shape, every)
    why = "grid lines show where the samples are, not what they are"
    kept = tuple(t for t in samples.accuracy.terms if t.quantity == "position" and t.place == "point")
    accuracy = Accuracy(kept, samples.accuracy.missing, (), samples.accuracy.ended).end_from(samples.accuracy, why)
    rule = "through the positions of the samples [grid-lines/1]"
    unit = grid.frame.units[0] if len(set(grid.frame.units[: grid.dimensions])) == 1 else ""
    whole = exactly(f"Lines of the {grid.kind} grid", "mapping", len(points), quantity="position", unit=unit, rule=rule)
    return Geometry(
        points=points,
        lines=lines,
        values={"axis": Field(axis, "cell"), **_sampled(samples)},
        frame=grid.frame,
        name=samples.name,
        time=samples.time,
        accuracy=accuracy.add(whole),
    )


def _sampled(samples: Samples) -> dict[str, Field]:
    """The values of the samples, to colour their positions by."""
    if samples.components != 1:
        return {}
    name = samples.name if samples.name not in ("", "axis") else "value"
    return {name: Field(np.asarray(samples.values, float).ravel(), "point", samples.unit)}


def _lattice(shape: tuple[int, ...], every: int) -> tuple[Cells, Ints]:
    """The lines of a lattice, first those along x; and along which axis each runs."""
    index = np.arange(int(np.prod(shape))).reshape(shape)
    bundles: list[Ints] = []
    for axis in range(len(shape)):
        along = np.moveaxis(index, len(shape) - 1 - axis, -1)
        for place in range(along.ndim - 1):
            n = along.shape[place]
            along = along.take(np.unique([*range(0, n, every), n - 1]), place)
        if along.size > MOST:
            raise ValueError(f"a grid of {' x '.join(map(str, reversed(shape)))} samples is too large: draw every 10th line")
        bundles.append(along.reshape(-1, along.shape[-1]))
    sizes = np.concatenate([np.full(len(b), b.shape[1], np.int64) for b in bundles])
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    axis_of = np.repeat(np.arange(len(bundles)), [len(b) for b in bundles])
    return Cells(offsets, np.concatenate([b.ravel() for b in bundles])), axis_of


def _edges(grid: Unstructured) -> Ints:
    """(m, 2) nodes of each edge, once, ascending."""
    sizes = np.diff(grid.offsets)
    found = [np.zeros((0, 2), np.int64)]
    for kind in np.unique(grid.types):
        for size in np.unique(sizes[grid.types == kind]):
            cells = np.flatnonzero((grid.types == kind) & (sizes == size))
            nodes = grid.connectivity[grid.offsets[cells][:, None] + np.arange(size)]
            if kind not in EDGES and kind not in FLAT:
                raise ValueError(f"the grid has cells of VTK's type {kind}, whose edges are not known here")
            pairs = EDGES.get(int(kind)) or tuple((i, (i + 1) % int(size)) for i in range(int(size)))
            found += [nodes[:, list(pair)] for pair in pairs]
    return np.unique(np.sort(np.concatenate(found), axis=1), axis=0)
