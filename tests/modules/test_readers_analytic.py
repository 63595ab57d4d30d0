"""Fields by a formula: on lines, maps and volumes, with noise that is stated."""

from typing import Any

import numpy as np
import pytest

from modules.api import Accuracy, Model
from modules.data.expression import FormulaError
from modules.declare import record_of
from modules.readers.analytic import analytic


@pytest.mark.parametrize("n", [1, 2, 3])
def test_values_lie_where_the_box_says(n: int) -> None:
    low, high, samples = (-1.0, 0.0, 2.0), (1.0, 3.0, 2.5), (5, 7, 4)
    got = analytic(formula="x + 10*y + 100*z", low=low, high=high, samples=samples[:n])
    x, y, z = got.grid.points().T
    assert got.values.shape == tuple(reversed(samples[:n])) and got.grid.dimensions == n
    np.testing.assert_allclose(got.values.ravel(), x + 10 * y + 100 * z, atol=1e-12)
    assert got.grid.bounds[:2] == (-1.0, 1.0)


def test_it_is_exact_and_says_why() -> None:
    got = analytic(unit="m", lengths="km", name="ripple", time=2.0, formula="t * x")
    assert got.accuracy.rigour() == "exact" and not got.accuracy.missing
    assert (got.accuracy.total(2.0, "value") == 0).all() and "rounding" in got.accuracy.terms[0].source.rule
    assert (got.unit, got.name, got.time, got.grid.frame.units[0]) == ("m", "ripple", 2.0, "km")
    assert got.values.max() == 2.0


@pytest.mark.parametrize("formula", ["-y; x", "-y; x; 0 * z"])
def test_several_formulas_make_a_vector(formula: str) -> None:
    got = analytic(formula=formula, low=(-1,) * 3, high=(1,) * 3, samples=(4, 5, 6))
    x, y, _ = got.grid.points().T
    np.testing.assert_allclose(got.values.reshape(-1, 3), np.column_stack([-y, x, 0 * x]), atol=1e-15)
    assert got.accuracy.terms[0].components == 3


def test_noise_is_stated_and_repeats() -> None:
    clean, noisy, again = analytic(), analytic(noise=0.3), analytic(noise=0.3)
    np.testing.assert_array_equal(noisy.values, again.values)
    assert (noisy.values - clean.values).std() == pytest.approx(0.3, rel=0.04)
    term = noisy.accuracy.terms[1]
    np.testing.assert_allclose(term.error(), 0.3)
    assert term.id == again.accuracy.terms[1].id
    noise = (noisy.values - clean.values).ravel()
    others: list[dict[str, Any]] = [{"seed": 2}, {"formula": "x"}]
    for more in others:
        other = analytic(noise=0.3, **more)
        assert other.accuracy.terms[1].id != term.id
        assert abs(np.corrcoef((other.values - analytic(**more).values).ravel(), noise)[0, 1]) < 0.06
    joined = Accuracy.join([(noisy.accuracy, None), (again.accuracy, None)])
    np.testing.assert_allclose(joined.terms[1].error(), 0.6)


def test_a_place_without_a_number_is_a_hole_with_a_flag() -> None:
    got = analytic(formula="1 / x", samples=(5, 3))
    assert np.isnan(got.values[:, 2]).all() and np.isfinite(got.values).sum() == 12
    assert "3 of 15 samples, first at x = 0, y = -1" in got.accuracy.flags[0].words
    np.testing.assert_array_equal(got.accuracy.flags[0].items, [2, 7, 12])


def test_a_model_of_it_finds_the_field_between_samples() -> None:
    model = Model.between(analytic(formula="3 * x - y", samples=(9, 9)))
    points = np.random.default_rng(0).uniform(-1, 1, (20, 3)) * [1, 1, 0]
    np.testing.assert_allclose(model.at(points)[0], 3 * points[:, 0] - points[:, 1], atol=1e-12)


@pytest.mark.parametrize(("more", "sentence"), [
    ({"formula": ""}, "the formula is empty"),
    ({"formula": "x; "}, "the formula is empty"),
    ({"formula": "x;y;z;t"}, "there are 4 formulas"),
    ({"formula": "log(-1 - x**2)"}, "look for a division by 0"),
    ({"formula": "q"}, "there is no 'q'"),
    ({"samples": ()}, "one to three numbers"),
    ({"samples": (1, 5)}, "of 2 or more"),
    ({"samples": (4, 4, 4)}, "should have 3 numbers"),
    ({"low": (1.0, 1.0)}, "should be larger"),
    ({"samples": (10**6, 10**7)}, "more than half of the memory"),
    ({"noise": -1.0}, "must be 0 or more"),
])  # fmt: skip
def test_nonsense_is_refused_with_a_sentence(more: dict[str, Any], sentence: str) -> None:
    with pytest.raises((FormulaError, ValueError), match=sentence):
        analytic(**more)


def test_every_parameter_has_its_words() -> None:
    assert all(p.words for p in record_of(analytic).parameters)


@pytest.mark.parametrize("grid", ["rectilinear", "curvilinear", "triangles"])
def test_other_grids_fill_the_same_box_with_as_many_samples(grid: Any) -> None:
    box: dict[str, Any] = {"low": (1.0, -2.0), "high": (4.0, 3.0), "samples": (9, 7)}
    got = analytic(formula="x + 10*y", grid=grid, lengths="km", **box)
    assert got.grid.kind == {"triangles": "unstructured"}.get(grid, grid)
    assert got.grid.count == 63 and got.grid.dimensions == 2 and got.grid.frame.units[0] == "km"
    np.testing.assert_allclose(got.grid.bounds, (1, 4, -2, 3, 0, 0), atol=1e-12)
    x, y, _ = got.grid.points().T
    np.testing.assert_allclose(got.values.ravel(), x + 10 * y, rtol=1e-14)
    assert np.array_equal(analytic(formula="x", grid=grid, **box).grid.points(), got.grid.points())
    assert got.accuracy.rigour() == "exact"
    noisy = analytic(grid=grid, noise=0.1, **box)
    assert noisy.accuracy.terms[1].count == 63


def test_bent_cells_turn_the_right_way_and_volumes_bend_in_the_plane() -> None:
    nodes = analytic(grid="curvilinear", samples=(9, 5)).grid.points().reshape(5, 9, 3)
    u, v = np.diff(nodes, axis=1)[:-1], np.diff(nodes, axis=0)[:, :-1]
    assert (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] > 0).all()
    solid = analytic(formula="z", grid="curvilinear", low=(0, 0, 5), high=(1, 1, 7), samples=(4, 3, 5))
    assert solid.grid.shape == (5, 3, 4)
    np.testing.assert_allclose(np.unique(solid.values), np.linspace(5, 7, 5))


def test_triangles_turn_one_way_and_fill_the_box() -> None:
    from modules.api import Unstructured

    grid = analytic(grid="triangles", low=(0, 0), high=(3, 2), samples=(9, 8)).grid
    assert isinstance(grid, Unstructured)
    p, q, r = grid.nodes[grid.connectivity.reshape(-1, 3)].transpose(1, 0, 2)
    area = 0.5 * ((q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0])
    assert (area > 0).all() and area.sum() == pytest.approx(6.0)


def test_a_rectilinear_axis_is_denser_towards_its_ends() -> None:
    step = np.diff(np.unique(analytic(grid="rectilinear", samples=(12, 3)).grid.points()[:, 0]))
    assert step.argmax() == 5 and step[0] == pytest.approx(step[-1]) and step.max() > 3 * step.min()


@pytest.mark.parametrize(("grid", "samples"), [("curvilinear", (5,)), ("triangles", (5,)), ("triangles", (4, 4, 4))])
def test_a_grid_that_does_not_bend_is_told(grid: Any, samples: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=f"kind {grid} needs two"):
        analytic(formula="x", low=(0, 0, 0), high=(1, 1, 1), samples=samples, grid=grid)
