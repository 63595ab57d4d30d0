"""How many cells of each kind an isosurface passes, and where the special ones are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Geometry,
    Literal,
    Model,
    NamedTuple,
    Range,
    Rectilinear,
    Regular,
    Table,
    exactly,
    mapper,
)

RULE = "asymptotic decider on faces, six inflection points for tunnels; Lopes 1999, 4.1.1 and 4.2.2 [cell-types/1]"
WHY = "cells are counted for the values as they are given; what their errors may change is told by 'isosurface risk'"

Bools = NDArray[np.bool_]


class CellStatistics(NamedTuple):
    """Where the special cells are, and the counts of tables 4.5 to 4.7."""

    places: Geometry
    table: Table


@mapper("Cell statistics", aliases=("polygon statistics", "ambiguous cells", "tunnels", "topology", "table 4.5"))
def cell_statistics(
    model: Model,
    *,
    level: Annotated[float | None, Range(of="model.range")] = None,
    show: Literal["tunnels", "ambiguous", "classic wrong", "means wrong", "saddle test wrong"] = "tunnels",
) -> CellStatistics:
    """The cells that a level passes, counted by their topological polygons, and the places of special ones.

    The table has, as tables 4.5 to 4.7 of the thesis, cells, empty cells and triangles, the polygons of each class, and
    tunnels by the polygons they join; and in how many cells simpler methods join wrongly: the table of 1987, the means of
    faces, the decider on faces alone (which sees no tunnel), and Natarajan's test of the body saddle.

    Parameters
    ----------
    level : in the unit of the field; automatic: the middle of its range
    show : the cells whose middles are given as points

    Raises
    ------
    ValueError : the model is not a linear one of single values on a regular or rectilinear grid of three dimensions

    Accuracy: counts are exact for the values as they are; errors of the values end here, for they may change a count.
    Source: Lopes 1999, tables 4.5 to 4.7; Natarajan 1994.
    """
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or min(grid.shape) < 2:
        raise ValueError(f"cells are counted on a regular or rectilinear grid of 3 dimensions, not on this {grid.kind} one")
    if model.samples.components != 1 or model.law.name != "linear":
        raise ValueError("cells are counted for a linear model of one value a sample: choose law 'linear' and a component")
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    finite = values[np.isfinite(values)]
    if level is None:
        level = float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0
    known = kernels.cell_types.cells(values, level)
    chosen: dict[str, Bools] = {
        "tunnels": known.tunnel,
        "ambiguous": known.ambiguous > 0,
        "classic wrong": known.classic_wrong,
        "means wrong": known.mean_wrong,
        "saddle test wrong": known.saddle_wrong,
    }
    accuracy = Accuracy().end_from(model.accuracy, WHY).miss(*model.accuracy.missing)
    places = _places(model, grid, known, chosen[show], show, accuracy)
    return CellStatistics(places, _table(model, known, level, accuracy))


def _places(
    model: Model, grid: Regular | Rectilinear, known: kernels.cell_types.Cells, which: Bools, name: str, accuracy: Accuracy
) -> Geometry:
    """The middles of some cells."""
    cell = known.active.cell[which]
    row, i = np.divmod(cell, grid.shape[2] - 1)
    k, j = np.divmod(row, grid.shape[1] - 1)
    middle = [0.5 * (axis[1:] + axis[:-1]) for axis in grid.axes]
    points = np.column_stack([middle[0][i], middle[1][j], middle[2][k]])
    types = kernels.cell_types
    kinds = [types.configuration(code) for code in known.active.code[which].tolist()]
    exact = exactly("Places of cells", "mapping", len(points), quantity="position", unit=_unit(grid), rule=RULE)
    return Geometry(
        points=points,
        vertices=Cells.of(np.arange(len(points))[:, None]),
        values={
            "grid cell": Field(cell, "point"),
            "configuration": Field(np.array(kinds, np.int64), "point"),
            "ambiguous faces": Field(known.ambiguous[which], "point"),
        },
        cell=float(np.prod([np.median(np.diff(a)) for a in grid.axes]) ** (1 / 3)),
        frame=grid.frame,
        name=f"cells: {name}",
        accuracy=accuracy.add(exact),
    )


def _unit(grid: Regular | Rectilinear) -> str:
    return grid.frame.units[0] if len(set(grid.frame.units)) == 1 else ""


def _table(model: Model, known: kernels.cell_types.Cells, level: float, accuracy: Accuracy) -> Table:
    """Cells, polygons and tunnels with their numbers, shares and triangles."""
    types = kernels.cell_types
    discs, tunnels, triangles = types.count(known)
    passed, cells = len(known.active.cell), model.grid.cells
    polygons = sum(discs.values()) + 2 * sum(tunnels.values())
    rows: list[tuple[str, int, float, int, str]] = [
        ("cells", cells, 100.0, triangles, "of the grid"),
        ("empty cells", cells - passed, 100 * (cells - passed) / max(cells, 1), 0, "share of the cells"),
        ("cells passed", passed, 100 * passed / max(cells, 1), triangles, f"by the level {level:g}"),
        ("polygons", polygons, 100.0, triangles, "in all cells"),
    ]
    for name in types.KNOWN:
        n = discs[name]
        three = 2 * int(known.third.sum()) if name == "P8/2" else 0
        rows.append((name, n, 100 * n / max(polygons, 1), n * types.triangles_of(name) + three, "share of the polygons"))
    for pair in types.PAIRS:
        n = tunnels[pair]
        words = "tunnels; share of the polygons, two each"
        rows.append((" ".join(pair), n, 200 * n / max(polygons, 1), n * types.triangles_of_tunnel(pair), words))
    special = (
        ("ambiguous cells", known.ambiguous > 0, "with an ambiguous face"),
        ("tunnels", known.tunnel, "which tests of faces do not see"),
        ("classic wrong", known.classic_wrong, "the table of 1987 joins otherwise"),
        ("means wrong", known.mean_wrong, "four triangles a face join otherwise"),
        ("face test wrong", known.tunnel, "the asymptotic decider alone joins otherwise"),
        ("saddle test wrong", known.saddle_wrong, "the body saddle says another thing of a tunnel"),
    )
    for name, which, words in special:
        rows.append((name, int(which.sum()), 100 * int(which.sum()) / max(passed, 1), 0, f"{words}; share of the cells passed"))
    columns = list(zip(*rows, strict=True))
    return Table(
        columns={
            "name": np.array(columns[0], dtype=str),
            "number": np.array(columns[1], np.int64),
            "share": np.array(columns[2], float),
            "triangles": np.array(columns[3], np.int64),
            "words": np.array(columns[4], dtype=str),
        },
        units={"share": "%"},
        name="cells of an isosurface",
        accuracy=accuracy.add(exactly("Counts", "mapping", len(rows), quantity="number", rule=RULE)),
    )
