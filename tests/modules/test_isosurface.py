"""The isosurface: its level, methods, proven distance and what moves it."""

from typing import Any

import numpy as np
import pytest

from modules.api import Accuracy, Model, Progress, Rectilinear, Samples, bound
from modules.data.grid import Regular
from modules.mappers.isosurface import isosurface
from modules.readers.corner_cell import CELLS, corner_cell
from tests.oracles.topology import components

METHODS = ("accurate", "classic", "flying_edges")


def ball(n: Any = 9, noise: Any = 0.0, axes: Any = None) -> Any:
    a = axes or [np.linspace(-1, 1, n)] * 3
    z, y, x = np.meshgrid(*reversed(a), indexing="ij")
    values = 1 - (x**2 + y**2 + z**2) + noise * np.random.default_rng(1).normal(size=x.shape)
    grid = Rectilinear(tuple(a))
    accuracy = Accuracy((bound("Half a unit", 0.01, values.size, unit="K"),))
    return Model.between(Samples(grid=grid, values=values, unit="K", accuracy=accuracy))


def drawn(model: Any, **parameters: Any) -> Any:
    return isosurface(model, Progress(), **parameters)


def at(model: Any, points: Any) -> Any:
    return model.at(points)[0]


@pytest.mark.parametrize("method", METHODS)
class TestEveryMethod:
    def test_the_law_of_the_budget(self, method: Any) -> None:
        model = ball()
        assert model.accuracy.accounted() <= drawn(model, method=method).accuracy.accounted()

    def test_the_surface_looks_to_the_low_side(self, method: Any) -> None:
        p, q, r = (g.points[g.triangles[:, k]] for g in [drawn(ball(), method=method, level=0.5)] for k in range(3))
        assert np.isclose(np.einsum("ij,ij->", p, np.cross(q, r)) / 6, 4 / 3 * np.pi * 0.5**1.5, rtol=0.15)

    def test_the_proven_distance_holds(self, method: Any) -> None:
        model = ball(noise=0.02)
        g = drawn(model, method=method, level=0.4)
        random, corners = np.random.default_rng(2), g.points[g.triangles]
        weight = random.dirichlet(np.ones(3), size=len(corners))
        place = np.einsum("mc,mca->ma", weight, corners)
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 1] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        reach = g.values["distance"].values
        known = np.isfinite(reach)
        assert known.mean() > 0.9
        low, high = (at(model, (place + s * reach[:, None] * normal)[known]) for s in (-1, 1))
        assert (low <= 0.4 + 1e-12).all()
        assert (high >= 0.4 - 1e-12).all()

    def test_triangles_lie_in_their_cells(self, method: Any) -> None:
        g = drawn(ball(), method=method)
        cell, corners = g.values["grid cell"].values, g.points[g.triangles]
        row, i = np.divmod(cell, 8)
        k, j = np.divmod(row, 8)
        low = np.column_stack([i, j, k]) / 4 - 1
        assert (corners >= low[:, None] - 1e-9).all()
        assert (corners <= low[:, None] + 0.25 + 1e-9).all()


def test_an_automatic_level_is_the_middle_of_the_range() -> None:
    model = ball()
    low, high = model.facts()["range"]
    assert np.unique(drawn(model).values["level"].values) == pytest.approx([(low + high) / 2])


def test_errors_of_values_become_displacements() -> None:
    g = drawn(ball(33), level=0.5)
    term = next(t for t in g.accuracy.terms if t.name == "Half a unit")
    assert term.quantity == "position"
    assert np.median(term.size()) == pytest.approx(0.01 / (2 * np.sqrt(0.5)), rel=0.1)


def test_a_finer_grid_is_nearer_to_its_surface() -> None:
    def distance(n: Any) -> Any:
        samples = ball(n).samples  # the ball's own cells are linear: no distance at all
        bell = Samples(grid=samples.grid, values=np.exp(2 * samples.values), accuracy=Accuracy())
        return np.nanmedian(drawn(Model.between(bell), level=2.0).values["distance"].values)

    assert distance(17) < 0.35 * distance(9)


def test_an_uneven_grid_gives_the_same_ball() -> None:
    axes = [np.sort(np.append(np.random.default_rng(n).uniform(-1, 1, 15), [-1, 1])) for n in range(3)]
    g = drawn(ball(axes=axes), level=0.5)
    assert np.linalg.norm(g.points, axis=1) == pytest.approx(np.sqrt(0.5), abs=0.1)


def test_a_flat_cell_has_a_coarse_distance_and_is_flagged() -> None:
    model = Model.between(corner_cell(figure="4.11"))
    g = drawn(model, level=0.0)
    rough = next(flag for flag in g.accuracy.flags if flag.name == "coarse").items
    fine = drawn(model, level=0.0, method="subdivided", cuts=20).points  # within a twentieth of all of the surface
    corner = np.concatenate([g.points[g.triangles], g.points[g.triangles].mean(axis=1, keepdims=True)], axis=1)
    away = np.linalg.norm(corner[:, :, None] - fine, axis=3).min(axis=2).max(axis=1)
    distance = g.values["distance"].values
    assert (away[rough] <= distance[rough] + 0.05).all()
    assert (distance[rough] < 1.0).all()


def test_several_levels_are_one_geometry() -> None:
    model = ball()
    both, parts = drawn(model, levels=(0.6, 0.2)), [drawn(model, level=level) for level in (0.2, 0.6)]
    assert [len(both.points), len(both.triangles)] == [sum(len(getattr(p, n)) for p in parts) for n in ("points", "triangles")]
    assert set(both.values["level"].values) == {0.2, 0.6}
    for name in ("distance", "normal", "grid cell"):
        np.testing.assert_array_equal(both.values[name].values, np.concatenate([p.values[name].values for p in parts]))
    first = len(parts[0].points)
    for name in {t.name for t in both.accuracy.terms}:
        alone = [sum(t.error() for t in p.accuracy.terms if t.name == name) for p in parts]
        joined = sum(t.error() for t in both.accuracy.terms if t.name == name)
        np.testing.assert_allclose(joined[:first], np.broadcast_to(alone[0], (first,)))
        np.testing.assert_allclose(joined[first:], np.broadcast_to(alone[1], (len(both.points) - first,)))


def test_flags_of_several_levels_name_their_own_triangles() -> None:
    model = Model.between(corner_cell(figure="4.11"))
    both, one = drawn(model, levels=(-0.01, 0.0)), drawn(model, level=-0.01)
    items = np.concatenate([f.items for f in both.accuracy.flags if f.name == "coarse"])
    zero = next(f for f in drawn(model, level=0.0).accuracy.flags if f.name == "coarse")
    assert set(zero.items + len(one.triangles)) <= set(items)


@pytest.mark.parametrize("normals", ["nodes", "cells"])
def test_normals_of_a_ball_look_outwards(normals: str) -> None:
    g = drawn(ball(21), level=0.4, normals=normals)
    outwards = g.points / np.linalg.norm(g.points, axis=1, keepdims=True)
    normal = g.values["normal"].values
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (np.einsum("na,na->n", outwards, normal) > 0.99).all()


def test_normals_where_the_field_is_flat_are_those_of_triangles() -> None:
    values = np.zeros((3, 3, 3))
    values[1, 1, 1] = 1e-200  # its square is 0
    g = drawn(Model.between(Samples(grid=Rectilinear((np.arange(3.0),) * 3), values=values, accuracy=Accuracy())), level=5e-201)
    assert np.linalg.norm(g.values["normal"].values, axis=1) == pytest.approx(1.0, abs=1e-5)


def test_each_kind_of_further_point_pays() -> None:
    model = ball(noise=0.05)
    worst = {
        switch: np.quantile(drawn(model, level=0.4, **({switch: False} if switch else {})).values["distance"].values, 0.9)
        for switch in ("", "on_faces", "inside")
    }
    assert worst[""] < worst["on_faces"]
    assert worst[""] < worst["inside"]


def test_without_inflections_tunnels_are_not_seen_and_that_is_said() -> None:
    model = Model.between(corner_cell(figure="4.29 b"))
    with_them, without = (drawn(model, level=0.0, inflections=on) for on in (True, False))
    assert [components(len(g.points), g.triangles) for g in (with_them, without)] == [1, 2]
    assert any(m.name == "Topology of the surface" for m in without.accuracy.missing)
    assert not any(m.name == "Topology of the surface" for m in with_them.accuracy.missing)


def test_the_distance_both_ways_holds_and_is_no_smaller() -> None:
    model = ball(noise=0.05)
    one, both = (drawn(model, level=0.4, both_ways=on) for on in (False, True))
    assert (both.values["distance"].values >= one.values["distance"].values).all()
    fine = drawn(model, level=0.4, method="subdivided", cuts=6)
    most = np.full(int(both.values["grid cell"].values.max()) + 1, 0.0)
    np.maximum.at(most, both.values["grid cell"].values, both.values["distance"].values)
    known = fine.values["grid cell"].values < len(most)
    import pyvista

    mesh = pyvista.PolyData(both.points, np.insert(both.triangles, 0, 3, axis=1).ravel())
    middle = fine.points[fine.triangles].mean(axis=1)[known]
    off = fine.values["distance"].values[known]
    away = np.abs(pyvista.PolyData(middle).compute_implicit_distance(mesh)["implicit_distance"])
    assert (away <= most[fine.values["grid cell"].values[known]] + off + 1e-9).all()


def test_exact_topology_is_said_only_of_the_accurate_method() -> None:
    assert any(t.name == "Topology of the surface" and t.source.rigour == "exact" for t in drawn(ball()).accuracy.terms)
    assert any(m.name == "Topology of the surface" for m in drawn(ball(), method="classic").accuracy.missing)


def test_a_level_beside_the_field_gives_no_surface() -> None:
    assert len(drawn(ball(), level=9.0).points) == 0


def test_holes() -> None:
    model = ball()
    values = np.array(model.samples.values)
    values[4, 4, 2] = np.nan
    holed = Model.between(Samples(grid=model.grid, values=values, accuracy=Accuracy()))
    g = drawn(holed, level=0.7)
    assert 0 < len(g.triangles) < len(drawn(model, level=0.7).triangles)
    with pytest.raises(ValueError, match="accurate"):
        drawn(holed, level=0.7, method="flying_edges")


def test_what_cannot_be_drawn_is_refused() -> None:
    flat = Samples(grid=Regular((3, 3), (1.0, 1.0), (0.0, 0.0)), values=np.zeros((3, 3)), accuracy=Accuracy())
    with pytest.raises(ValueError, match="3 dimensions"):
        drawn(Model.between(flat))
    with pytest.raises(ValueError, match="linear"):
        drawn(Model.between(ball().samples, "nearest"))
    with pytest.raises(ValueError, match="number"):
        drawn(ball(), level=np.nan)


@pytest.mark.parametrize("figure", list(CELLS))
def test_worked_cells_can_be_read(figure: Any) -> None:
    values = corner_cell(figure=figure).values
    assert values[1, 0, 0] == CELLS[figure][1], "001 is the corner at z = 1"
    assert values[0, 0, 1] == CELLS[figure][4]


def test_corners_of_your_own() -> None:
    assert corner_cell(figure="", corners=tuple(range(8))).values[0, 1, 1] == 6
    with pytest.raises(ValueError, match="twelve"):
        corner_cell(figure="", corners=(1.0, 2.0))
