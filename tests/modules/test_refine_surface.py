"""Surfaces refined to a tolerance: proven, joined as before, with few triangles; and the recursion that stalls."""

from typing import Any

import numpy as np
import pytest

from modules import kernels
from modules.api import Accuracy, Model, Progress, Rectilinear, Samples, bound
from modules.mappers.isosurface import isosurface
from modules.mappers.refine_surface import refine_surface
from tests.oracles import topology


def model_of(values: Any, axes: Any = None) -> Any:
    axes = axes or [np.arange(float(n)) for n in reversed(values.shape)]
    accuracy = Accuracy((bound("Half a unit", 0.01, values.size, unit="K"),))
    return Model.between(Samples(grid=Rectilinear(tuple(axes)), values=values, unit="K", accuracy=accuracy))


def gyroid(n: int = 7) -> Any:
    a = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    return np.sin(4 * x) * np.cos(4 * y) + np.sin(4 * y) * np.cos(4 * z) + np.sin(4 * z) * np.cos(4 * x)


def drawn(model: Any, level: float = 0.0, method: Any = "accurate") -> Any:
    return isosurface(model, Progress(), level=level, method=method)


def refined(model: Any, surface: Any = None, **parameters: Any) -> Any:
    return refine_surface(surface or drawn(model), model, Progress(), **parameters)


def parts(surface: Any) -> Any:
    return surface.points, surface.triangles, np.asarray(surface.values["grid cell"].values)


def spread(surface: Any, each: int = 6) -> Any:
    """Points on each triangle."""
    u, v = np.random.default_rng(3).random((2, each))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    return a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]


class TestTolerance:
    @pytest.mark.parametrize("tolerance", [0.1, 0.02])
    @pytest.mark.parametrize("merge", [True, False])
    def test_every_triangle_is_proven_and_joined_as_before(self, tolerance: float, merge: bool) -> None:
        model = model_of(gyroid())
        surface = refined(model, tolerance=tolerance, merge=merge)
        assert np.asarray(surface.values["distance"].values).max() <= tolerance
        assert not surface.accuracy.flags or {f.name for f in surface.accuracy.flags} == {"kappa"}
        verdict = topology.judged(gyroid(), model.grid.axes, 0.0, parts(surface))
        assert verdict.right, str(verdict)

    def test_no_point_of_a_triangle_is_farther_than_is_said(self) -> None:
        model = model_of(gyroid())
        surface = refined(model, tolerance=0.05)
        reach = np.asarray(surface.values["distance"].values)
        points = spread(surface)
        values = np.asarray(model.at(points.reshape(-1, 3))[0]).reshape(points.shape[:2])
        # within its distance, in some direction, F must change its sign
        step = 1e-5
        flat = points.reshape(-1, 3)
        slopes = [(np.asarray(model.at(np.clip(flat + step * e, 0, 6))[0]).reshape(values.shape) - values) / step
                  for e in np.eye(3)]  # fmt: skip
        normal = np.stack(slopes, axis=-1)
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        found = np.zeros(values.shape, bool)
        for axis in [normal / length, *(np.broadcast_to(e, normal.shape) for e in np.eye(3))]:
            for share in np.linspace(-1, 1, 21):
                moved = np.clip(points + share * reach[:, None, None] * axis, 0, 6)
                there = np.asarray(model.at(moved.reshape(-1, 3))[0]).reshape(values.shape)
                found |= (there >= 0) != (values >= 0)
        assert (found | (np.abs(values) < 1e-9)).mean() > 0.999

    def test_fewer_triangles_for_a_larger_tolerance(self) -> None:
        model = model_of(gyroid())
        surface = drawn(model)
        counts = [len(refined(model, surface, tolerance=t).triangles) for t in (0.2, 0.05, 0.01)]
        assert counts[0] < counts[1] < counts[2]
        assert counts[0] < 0.55 * len(surface.triangles)
        assert counts[2] < len(refined(model, surface, tolerance=0.01, merge=False).triangles)

    def test_points_lie_on_the_surface(self) -> None:
        model = model_of(gyroid())
        assert np.abs(model.at(refined(model, tolerance=0.01).points)[0]).max() < 1e-6

    @pytest.mark.parametrize("method", ["decider", "flying_edges"])
    def test_other_methods_are_refined_too(self, method: str) -> None:
        model = model_of(gyroid(), [np.cumsum(0.5 + np.arange(7) % 3), np.arange(7.0), np.arange(7.0) * 2])
        surface = refined(model, drawn(model, method=method), tolerance=0.05)
        assert len(surface.triangles)
        assert [m.name for m in surface.accuracy.missing] == ["Topology of the surface"]

    def test_random_values_keep_their_topology(self) -> None:
        values = np.random.default_rng(4).normal(size=(5, 5, 5))
        model = model_of(values)
        before, after = drawn(model), refined(model, tolerance=0.1)
        assert topology.euler(len(after.points), after.triangles) == topology.euler(len(before.points), before.triangles)
        pieces = [topology.components(len(s.points), s.triangles) for s in (before, after)]
        assert pieces[0] == pieces[1]
        verdict = topology.judged(values, model.grid.axes, 0.0, parts(after))
        rest = {name: n for name, n in verdict.wrong.items() if n and name != "self-intersections"}
        assert not rest
        far = np.asarray(after.values["distance"].values) > 0.1
        named = {f.name: f.count for f in after.accuracy.flags if f.name != "kappa"}
        assert named.get("tolerance not reached", 0) == far.sum()
        assert named.get("unproven", 0) == np.isnan(np.asarray(after.values["distance"].values)).sum()

    def test_a_hole_stays_a_hole(self) -> None:
        values = gyroid()
        values[3, 3, 3] = np.nan
        surface = refined(model_of(values), tolerance=0.02)
        assert np.isfinite(surface.points).all()
        assert np.nanmax(np.asarray(surface.values["distance"].values)) <= 0.02


class TestWords:
    def test_the_law_of_the_budget(self) -> None:
        model = model_of(gyroid())
        surface = drawn(model)
        known = refined(model, surface).accuracy.accounted()
        assert model.accuracy.accounted() | surface.accuracy.accounted() <= known

    def test_an_empty_surface_stays_empty(self) -> None:
        assert not len(refined(model_of(gyroid()), drawn(model_of(gyroid()), 99.0)).polygons)

    @pytest.mark.parametrize(
        ("parameters", "words"),
        [({"tolerance": 0.0}, "must be positive"), ({"tolerance": 1e-15}, "cannot be proven"),
         ({"tolerance": 1e-4, "most": 5000}, "more than 5000 triangles")],
    )  # fmt: skip
    def test_what_cannot_be_done_is_said(self, parameters: Any, words: str) -> None:
        with pytest.raises(ValueError, match=words):
            refined(model_of(gyroid()), **parameters)

    def test_another_model_is_refused(self) -> None:
        with pytest.raises(ValueError, match="do not lie on the surface of this model"):
            refined(model_of(gyroid() + 0.2), drawn(model_of(gyroid())))

    def test_a_surface_off_the_level_is_refused(self) -> None:
        model = model_of(gyroid())
        with pytest.raises(ValueError, match="do not lie on the surface"):
            refined(model, drawn(model, method="cuberille"))


class TestRecursionAtG:
    def test_g_lies_on_the_surface_and_underestimates(self) -> None:
        model = model_of(gyroid())
        surface = drawn(model)
        x, y, z = model.grid.axes
        field = kernels.mesh_proof.Field(gyroid(), x, y, z, 0.0)
        centre, away = kernels.mesh_centre.centres(field, *parts(surface))
        found = away >= 0
        assert found.mean() > 0.95
        assert np.abs(model.at(centre[found])[0]).max() < 1e-9
        reach = np.asarray(surface.values["distance"].values)
        both = found & np.isfinite(reach)
        assert (away[both] < reach[both]).mean() > 0.9

    def test_it_stalls_where_cutting_edges_arrives(self) -> None:
        model = model_of(gyroid())
        surface = drawn(model)
        stalled, arrived = refined(model, surface, tolerance=0.02, method="centres"), refined(model, surface, tolerance=0.02)
        assert len(stalled.triangles) > 4 * len(arrived.triangles)
        assert np.nanmax(np.asarray(stalled.values["distance"].values)) > 0.1
        assert any(f.name == "tolerance not reached" for f in stalled.accuracy.flags)
