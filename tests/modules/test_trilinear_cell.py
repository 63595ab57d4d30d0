"""The laboratory of one trilinear cell, its figures, and the open edges of a surface."""

from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Model, Progress, Samples
from modules.mappers.isosurface import isosurface
from modules.mappers.open_edges import open_edges
from modules.mappers.trilinear_cell import trilinear_cell
from modules.readers.corner_cell import corner_cell


def model_of(figure: str, corners: Any = ()) -> Any:
    return Model.between(corner_cell(figure=figure, corners=corners))  # type: ignore[arg-type]  # one of the figures


def laboratory(figure: str, **parameters: Any) -> Any:
    return trilinear_cell(model_of(figure), **parameters)


def at(figure: str, points: Any) -> Any:
    return model_of(figure).at(points)[0]


def test_figure_4_29_the_points_of_a_tunnel() -> None:
    found = laboratory("4.29 b")
    assert [len(g.points) for g in (found.crossings, found.points_x, found.points_y, found.points_z)] == [6, 4, 4, 4]
    assert not len(found.centres.points)
    assert found.saddles.points == pytest.approx(np.array([[0.381554, 0.398733, 0.390806]]), abs=1e-6)
    assert len(found.polygons.lines) == 2
    line = found.hexagon.polylines()[0]
    assert len(line) == 7
    for t in (0.0, 0.3, 0.8):
        assert np.abs(at("4.29 b", (1 - t) * line[:-1] + t * line[1:])).max() < 1e-12
    straight = np.array([0.3 * a + 0.7 * b for a, b in found.lines.polylines()])
    assert np.abs(at("4.29 b", straight)).max() < 1e-12


def test_figure_4_12_the_loci_meet_in_the_bi_shoulder_point() -> None:
    found = trilinear_cell(model_of("", (6.0, -2.0, -3.0, -4.0, -2.0, -3.0, -5.0, -6.0)))
    (centre,) = found.centres.points
    for locus in (found.locus_x, found.locus_y, found.locus_z):
        line = np.concatenate(locus.polylines())
        assert np.linalg.norm(line - centre, axis=1).min() < 0.02
    model = model_of("", (6.0, -2.0, -3.0, -4.0, -2.0, -3.0, -5.0, -6.0))
    slope = model.gradient(centre[None])[0][0] * centre
    assert slope == pytest.approx(slope[0]), "x Fx = y Fy = z Fz (4.35, 4.36)"


def test_figure_4_10_slices_are_contours() -> None:
    found = laboratory("4.22", slices=17, across="z")
    assert len(np.unique(found.slices.points[:, 2])) == 17
    assert np.abs(at("4.22", np.clip(found.slices.points, 0, 1))).max() < 1e-9


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_derivatives_vanish_on_their_surfaces(axis: int) -> None:
    found = laboratory("4.24")
    surface = (found.slope_x, found.slope_y, found.slope_z)[axis]
    slope = model_of("4.24").gradient(surface.points)[0][:, axis]
    assert np.abs(slope).max() < 0.02
    points = (found.points_x, found.points_y, found.points_z)[axis].points
    inner = points[((points > 0) & (points < 1)).all(axis=1)]
    others = [a for a in range(3) if a != axis]
    assert len(inner) == 2
    assert np.abs(model_of("4.24").gradient(inner)[0][:, others]).max() < 1e-9, "two derivatives are 0 at an inflection point"


def test_the_table_tells_the_points() -> None:
    table = laboratory("4.21").table
    rows = dict(zip(table.columns["name"].tolist(), range(table.rows), strict=True))
    inside = [n for n in rows if n.startswith("Iz") and "within" in table.columns["words"][rows[n]]]
    (row,) = [rows[n] for n in inside]
    assert [table.columns[a][row] for a in "xyz"] == pytest.approx([1 / 2, 4 / 7, 2 / 3])


def test_a_cell_of_a_larger_model() -> None:
    values = np.random.default_rng(1).normal(size=(4, 4, 4))
    model = Model.between(Samples.from_array(values, spacing=(1.0, 2.0, 3.0), accuracy=EXACT))
    found = trilinear_cell(model, column=1, row=2, layer=0)
    assert found.corners.bounds == (1.0, 2.0, 4.0, 6.0, 0.0, 3.0)
    assert found.corners.values["value"].values[4] == values[0, 2, 2], "corner 100"
    near = np.concatenate([found.crossings.points, found.points_x.points])
    assert np.abs(model.at(near)[0]).max() < 1e-6
    with pytest.raises(ValueError, match="no cell"):
        trilinear_cell(model, column=3)
    values[0, 0, 0] = np.nan
    with pytest.raises(ValueError, match="hole"):
        trilinear_cell(Model.between(Samples.from_array(values, accuracy=EXACT)))


def test_figure_4_2_two_cells_and_the_hole_between_them() -> None:
    model = model_of("4.2 two cells")
    assert model.grid.shape == (2, 2, 3)
    drawn = isosurface(model, Progress(), level=0.0, method="classic")
    edges = open_edges(drawn)
    inside = [line for line in edges.polylines() if (line[:, 0] == 1).all()]
    assert len(inside) == 4
    accurate = open_edges(isosurface(model, Progress(), level=0.0))
    assert not [line for line in accurate.polylines() if (line[:, 0] == 1).all()]
    assert drawn.accuracy.accounted() <= edges.accuracy.accounted()
    assert all(t.count == len(edges.points) for t in edges.accuracy.terms)


def test_a_closed_surface_has_no_open_edge() -> None:
    values = np.pad(np.ones((2, 2, 2)), 1, constant_values=-1.0)
    drawn = isosurface(Model.between(Samples.from_array(values, accuracy=EXACT)), Progress(), level=0.0)
    assert not len(open_edges(drawn).lines)
