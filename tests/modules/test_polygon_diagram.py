"""Flat diagrams of the polygons of a cell: planar, and with the points and triangles that the thesis counts."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from modules.api import Model
from modules.mappers.polygon_diagram import polygon_diagram
from modules.readers.corner_cell import corner_cell


def diagram(figure: str, **parameters: Any) -> Any:
    return polygon_diagram(Model.between(corner_cell(figure=figure)), **parameters)  # type: ignore[arg-type]  # a figure's name


def named(found: Any) -> list[str]:
    return sorted(str(w) for w in found.names.values["name"].values)


def segments(found: Any) -> Any:
    parts = (found.edges_x, found.edges_y, found.edges_z, found.inside)
    return np.concatenate([g.points[g.segments()][:, :, :2] for g in parts if len(g.lines)])


FIGURES = [
    ("4.19", ["P 3/0", "P 6/1"]), ("4.20", ["P 7/1"]), ("4.22", ["P 8/2"]), ("4.23", ["P 9/3"]), ("4.24", ["P 12/3"]),
    ("4.26", ["P 3/0", "P 5/0"]), ("4.29 b", ["P 3/0", "P 3/0"]), ("4.34", ["P 4/0", "P 4/0"]),
]  # fmt: skip


@pytest.mark.parametrize(("figure", "names"), FIGURES)
def test_polygons_are_named_and_no_edges_cross(figure: str, names: list[str]) -> None:
    found = diagram(figure)
    assert named(found) == names
    lines = segments(found)
    for (a, b), (c, d) in combinations(lines, 2):
        if np.linalg.norm(np.array([a, a, b, b]) - np.array([c, d, c, d]), axis=1).min() < 1e-12:
            continue
        (u, v), w = np.stack([b - a, c - d]).T, c - a
        t = np.linalg.lstsq(np.stack([b - a, c - d]).T, w, rcond=None)[0]
        crosses = abs(u[0] * v[1] - u[1] * v[0]) > 1e-12 and (t > 1e-9).all() and (t < 1 - 1e-9).all()
        assert not crosses, (a, b, c, d)


@pytest.mark.parametrize(
    ("figure", "inner", "triangles"),
    [("4.22", 2, 18), ("4.23", 3, 22), ("4.24", 6, 34), ("4.26", 2, 6 + 10), ("4.29 b", 12, 24), ("4.34", 12, 28)],
)
def test_points_and_triangles_are_as_many_as_in_the_thesis(figure: str, inner: int, triangles: int) -> None:
    found = diagram(figure)
    dots = [found.crossings, found.points_x, found.points_y, found.points_z, found.centres]
    count, edges = sum(len(g.points) for g in dots), len(segments(found))
    rim = 2 * len(found.crossings.points)
    assert count - rim == inner
    holes = 2 if inner == 12 else 0  # between the six inflection points of a tunnel there is nothing
    assert edges - count + len(named(found)) - holes == triangles, "Euler"


def test_loop_back_faces_are_marked_outside_of_the_boundary() -> None:
    found = diagram("4.22")
    assert [len(g.polygons) for g in (found.marks_x, found.marks_y, found.marks_z)] == [0, 2, 2]
    assert (np.linalg.norm(found.marks_y.points[:, :2], axis=1) > 1).all()
    assert found.marks_y.accuracy.rigour("position") == "unknown", "the error between samples is not known, and said to be so"


def test_an_empty_cell_has_an_empty_diagram_and_a_wrong_one_a_sentence() -> None:
    found = diagram("4.22", level=100.0)
    assert not named(found) and not len(found.crossings.points)
    with pytest.raises(ValueError, match="there is no cell 1, 0, 0"):
        diagram("4.22", column=1)
