"""The topology of the accurate isosurface on a small sample by the oracle of `nonius bench topology`, and the oracle itself."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modules.kernels import marching
from tests.oracles import topology

HEAD = Path(__file__).resolve().parents[3] / "shared" / "data" / "headsq"


def axes_of(values: Any) -> tuple[Any, Any, Any]:
    x, y, z = (np.arange(float(n)) for n in reversed(values.shape))
    return x, y, z


@pytest.mark.parametrize("kind", ["normal", "log-normal", "padded"])
def test_no_cell_is_wrong(kind: str) -> None:
    for values in topology.grids(kind, 4, 11):
        verdict = judged(values)
        assert verdict.right, str(verdict)
        assert verdict.cells > 20


def judged(values: Any, level: float = 0.0) -> topology.Verdict:
    """At the level that is drawn: where the surface would touch itself, a little less."""
    drawn = marching.surface(values, *axes_of(values), level)
    assert drawn.level <= level < drawn.level + 1e-9 * np.abs(values).max()
    return topology.judged(values, axes_of(values), drawn.level, (drawn.points, drawn.triangles, drawn.cell))


def test_ties_are_drawn_as_the_surface_just_below() -> None:
    tunnels = 0
    for values in topology.grids("ties", 6, 12):
        verdict = judged(values)
        assert verdict.right, str(verdict)
        tunnels += verdict.tunnels
    assert tunnels > 3


@pytest.mark.parametrize(
    ("corner", "level"),
    [
        ((-2, -2, 1, 0, 2, 1, -1, 0), 0.0),  # two sheets touch along an edge: just below they are one, a tunnel
        ((2, 0, -2, 0, -1, -1, 1, 0), 0.0),
        ((0, -1, 2, 2, 0, 0, -2, 1), 0.0),
        ((50, 36, 18, 30, 38, 12, 35, 38), 31.5),  # a tunnel about to open: no corner and no face is on the level
    ],
)
def test_a_cell_where_sheets_touch(corner: Any, level: float) -> None:
    verdict = judged(np.array(corner, float).reshape(2, 2, 2).transpose(2, 1, 0).copy(), level)
    assert verdict.right, str(verdict)


@pytest.mark.skipif(not HEAD.is_dir(), reason="the CT head is not here: ../shared/data is absent")
@pytest.mark.parametrize("level", [1150.0, 1150.5])
def test_a_part_of_a_real_head(level: float) -> None:
    values = np.stack([np.fromfile(HEAD / f"quarter.{n}", "<u2").reshape(64, 64) for n in range(40, 52)]).astype(float)
    verdict = judged(values, level)
    assert verdict.right, str(verdict)
    assert verdict.cells > 2000


class TestOracle:
    """It finds what is put in."""

    def test_known_cells(self) -> None:
        cells = {
            (5, -1.5, -2, -3, -3, -2, -1, 5): (2, 2),  # figure 4.29 (a): two discs
            (5, -1.5, -2, -3, -3, -2, -1, 15): (0, 1),  # (b): a tunnel
            (1, -1, -1, -1, -1, -1, -1, -1): (1, 1),
            (1, -3, -1.5, 2, -3, 2, 2, -1): (3, 3),  # figure 4.5
        }
        corner = np.array(list(cells), float).reshape(-1, 2, 2, 2)
        chi, pieces = topology.truth(corner, 0.0, 16)
        assert list(zip(chi.tolist(), pieces.tolist(), strict=True)) == list(cells.values())

    def test_a_missing_triangle_a_turned_one_and_a_doubled_one(self) -> None:
        values = next(topology.grids("padded", 1, 3))
        drawn = marching.surface(values, *axes_of(values), 0.0)
        points, triangles, cell = drawn.points, drawn.triangles, drawn.cell
        turned = triangles.copy()
        turned[0] = turned[0, ::-1]
        for mesh, name in (
            ((points, triangles[1:], cell[1:]), "open edges"),
            ((points, turned, cell), "edges of two triangles of one sense"),
            ((points, np.vstack([triangles, triangles[:1]]), np.append(cell, cell[0])), "doubled triangles"),
        ):
            assert topology.judged(values, axes_of(values), 0.0, mesh).wrong[name] > 0

    def test_two_balls_that_touch_in_a_vertex(self) -> None:
        four = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]])
        ball = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        other = np.where(ball > 0, ball + 3, 0)[:, ::-1]
        mesh = np.vstack([ball, other])
        axes = (np.array([-9.0, 9.0]),) * 3
        assert topology.faults(four, mesh, np.zeros(8, int), axes)["vertices of two fans"] == 1
        assert topology.faults(four[:4], ball, np.zeros(4, int), axes)["vertices of two fans"] == 0

    def test_triangles_that_cross(self) -> None:
        points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 0]])
        mesh = np.array([[0, 1, 2], [3, 4, 5]])
        assert topology.self_intersections(points, mesh, np.zeros(2, int)) > 0
        assert topology.self_intersections(points, mesh, np.arange(2)) == 0

    def test_loops_and_components(self) -> None:
        values = np.broadcast_to(np.arange(4.0) - 1.4, (4, 4, 4)).copy()
        drawn = marching.surface(values, *axes_of(values), 0.0)
        points, triangles = drawn.points, drawn.triangles
        assert topology.boundary_loops(len(points), triangles) == 1
        assert topology.components(len(points), triangles) == 1
        assert topology.euler(len(points), triangles) == 1
