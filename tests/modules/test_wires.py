"""Grids, models, geometry: positions, laws and their errors, judged by closed forms and dense sampling."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from modules.api import (
    EXACT,
    Cells,
    Curvilinear,
    Field,
    Frame,
    Geometry,
    Grid,
    Identity,
    Model,
    Primitive,
    Rectilinear,
    Regular,
    Samples,
    Source,
    Table,
    Term,
    Unstructured,
    Value,
    bound,
    deviation,
    regular,
)
from modules.data.laws import locate, second_derivative


def test_arrays_are_zyx_and_points_are_xyz() -> None:
    grid = regular((2, 3, 4), spacing=(1, 10, 100), origin=(5, 6, 7))
    points = grid.points().reshape(2, 3, 4, 3)
    assert points[1, 2, 3].tolist() == [5 + 3, 6 + 20, 7 + 100]
    assert list(grid.bounds) == [5, 8, 6, 26, 7, 107]
    assert regular((3, 4)).points()[:, 2].tolist() == [0] * 12
    assert (grid.count, grid.cells, grid.dimensions, grid.kind) == (24, 6, 3, "regular")
    assert [g.is_cartesian for g in (grid, regular((3, 4), 0.5))] == [False, True]


def test_the_four_grids_of_the_taxonomy() -> None:
    bent = Curvilinear(np.zeros((3, 4, 3)))
    assert (bent.shape, bent.cells, bent.kind) == ((3, 4), 6, "curvilinear")
    loose = Unstructured(np.zeros((4, 3)), np.array([0, 3, 6]), np.array([0, 1, 2, 1, 2, 3]), np.array([5, 5]))
    assert (loose.shape, loose.cells, loose.dimensions) == ((4,), 2, 2)
    stretched = Rectilinear((np.array([0.0, 1, 4]), np.array([0.0, 2])))
    assert stretched.shape == (2, 3)
    grids: list[Grid] = [bent, loose, stretched, regular((2, 2))]
    for grid in grids:
        assert len(grid.points()) == grid.count
        assert pickle.loads(pickle.dumps(grid)).same_place(grid)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: regular((2, 2), spacing=-1), "must be positive"),
        (lambda: regular((2, 2), spacing=(1, 2, 3)), "broadcast"),
        (lambda: Rectilinear((np.array([0.0, 0.0]),)), "strictly ascending"),
        (lambda: Rectilinear((np.array([0.0, np.nan]),)), "finite coordinates"),
        (lambda: Samples.from_array(np.zeros((2, 2)), axes=[[0, 1], [0, 1, 2]], accuracy=EXACT), "do not fit a grid"),
        (lambda: Samples.from_array(np.array(["a"]), accuracy=EXACT), "are numbers"),
        (lambda: Unstructured(np.zeros((2, 3)), np.array([0, 2]), np.array([0, 2]), np.array([3])), "does not exist"),
        (lambda: Geometry(points=np.zeros((2, 2)), accuracy=EXACT), "x, y, z"),
        (lambda: Geometry(points=np.zeros((2, 3)), lines=Cells.of([[0, 2]]), accuracy=EXACT), "names point 2"),
        (lambda: Geometry(points=np.zeros((2, 3)), values={"a": Field(np.zeros(3))}, accuracy=EXACT), "3 values for 2 points"),
        (lambda: Table(columns={"a": np.zeros(2), "b": np.zeros(3)}, accuracy=EXACT), "different lengths"),
        (lambda: Model.between(Samples.from_array(np.zeros((2, 2)), accuracy=EXACT), "cubik"), "nearest, linear, cubic"),
    ],
)
def test_what_does_not_fit_is_told(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]  # a function of no arguments


def test_axes_of_different_units_have_no_length() -> None:
    frame = Frame(units=("degree", "m", "m"))
    with pytest.raises(ValueError, match="x in degree, y in m"):
        frame.length_unit(2)
    assert Frame(units=("m", "m", "")).length_unit(2) == "m"


def trilinear(p: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, z = p.T
    terms = np.array([np.ones_like(x), x, y, z, x * y, x * z, y * z, x * y * z])
    return np.asarray(c @ terms)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.lists(st.floats(-5, 5), min_size=8, max_size=8), st.integers(0, 999))
def test_a_trilinear_field_is_met_everywhere_with_its_gradient(coefficients: list[float], seed: int) -> None:
    random = np.random.default_rng(seed)
    axes = tuple(np.cumsum(random.uniform(0.2, 2, n)) for n in (4, 3, 5))
    grid = Rectilinear(axes)
    c = np.array(coefficients)
    model = Model.between(Samples(grid=grid, values=trilinear(grid.points(), c).reshape(grid.shape), accuracy=EXACT))
    inside = np.column_stack([random.uniform(a[0], a[-1], 20) for a in axes])
    values, accuracy = model.at(inside)
    scale = 1 + np.abs(c).sum() * 500
    assert np.allclose(values, trilinear(inside, c), atol=1e-11 * scale)
    assert np.allclose(accuracy.total(1, "value"), 0, atol=1e-9 * scale)  # no second derivative, so no model error
    gradient, _ = model.gradient(inside)
    h = 1e-6
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = h
        difference = (trilinear(inside + step, c) - trilinear(inside - step, c)) / (2 * h)
        assert np.allclose(gradient[:, axis], difference, atol=1e-7 * scale)


def test_the_law_has_no_error_at_the_samples_and_the_right_one_between() -> None:
    x = np.linspace(0, 2 * np.pi, 41)
    field = np.sin(x)[None, :] * np.cos(x)[:, None]
    h = x[1] - x[0]
    model = Model.between(Samples.from_array(field, spacing=h, accuracy=EXACT))
    _, at_samples = model.at(model.grid.points())
    assert np.allclose(at_samples.total(1, "value"), 0, atol=1e-15)
    points = np.column_stack([np.random.default_rng(0).uniform(h, 2 * np.pi - h, (500, 2)), np.zeros(500)])
    values, accuracy = model.at(points)
    truth = np.sin(points[:, 0]) * np.cos(points[:, 1])
    signed = accuracy.terms[0].error()
    large = np.abs(values - truth) > 1e-4
    assert np.median((signed / (values - truth))[large]) == pytest.approx(1.0, abs=0.03)
    own = model.own
    assert own is not None
    cell, _ = locate(model.grid, points)
    per_cell = own.size()[cell[:, 1] * 40 + cell[:, 0]]
    assert (np.abs(values - truth) <= per_cell * 1.05 + 1e-6).mean() > 0.99
    assert own.id == accuracy.terms[0].id  # one source on the wire and at the points


@pytest.mark.parametrize("n", [2, 3, 4, 9])
def test_the_cubic_law_is_exact_for_parabolas_of_uneven_samples(n: int) -> None:
    random = np.random.default_rng(n)
    axes = tuple(np.cumsum(random.uniform(0.3, 2, k)) for k in (n, 5))

    def field(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((1 + 2 * x - (x**2 if n > 2 else 0)) * (3 - y + 0.5 * y**2))

    values = field(*np.meshgrid(*axes))
    model = Model.between(Samples(grid=Rectilinear(axes), values=values, accuracy=EXACT), "cubic")
    x, y = (random.uniform(a[0], a[-1], 50) for a in axes)
    points = np.column_stack([x, y, np.zeros(50)])
    assert np.allclose(model.at(points)[0], field(x, y), rtol=1e-10, atol=1e-9)
    h = 1e-6
    slope = (field(x + h, y) - field(x - h, y)) / (2 * h)
    assert np.allclose(model.gradient(points)[0][:, 0], slope, rtol=1e-6, atol=1e-5)


def test_the_cubic_law_knows_its_own_error() -> None:
    x = np.linspace(0, 2 * np.pi, 25)
    field = np.sin(x)[None, :] * np.cos(x)[:, None]
    h = x[1] - x[0]
    cubic, linear = (Model.between(Samples.from_array(field, spacing=h, accuracy=EXACT), law) for law in ("cubic", "linear"))
    inner = np.random.default_rng(0).uniform(2 * h, 2 * np.pi - 2 * h, (800, 2))
    points = np.column_stack([inner, np.zeros(800)])
    truth = np.sin(points[:, 0]) * np.cos(points[:, 1])
    off = cubic.at(points)[0] - truth
    assert np.abs(off).max() < 0.1 * np.abs(linear.at(points)[0] - truth).max()
    signed = cubic.at(points)[1].terms[0].error()
    large = np.abs(off) > 0.3 * np.abs(off).max()
    assert np.median((signed / off)[large]) == pytest.approx(1.0, abs=0.1)
    own = cubic.own
    assert own is not None
    cell, _ = locate(cubic.grid, points)
    assert (np.abs(off) <= 1.5 * own.size()[cell[:, 1] * 24 + cell[:, 0]] + 0.1 * np.abs(off).max()).mean() > 0.97


def test_the_cubic_law_is_smooth_across_cells() -> None:
    model = Model.between(Samples.from_array(np.random.default_rng(0).normal(size=(6, 6)), accuracy=EXACT), "cubic")
    sides = [model.gradient(np.array([[3 + s * 1e-9, 2.3, 0.0]]))[0] for s in (-1, 1)]
    assert np.allclose(sides[0], sides[1], atol=1e-6)


def test_nearest_takes_the_closest_sample_and_says_what_that_costs() -> None:
    samples = Samples.from_array(np.array([[0.0, 1, 4], [0, 1, 4]]), accuracy=EXACT)
    model = Model.between(samples, "nearest")
    values, accuracy = model.at(np.array([[0.4, 0, 0], [0.6, 0, 0], [2, 1, 0]]))
    assert values.tolist() == [0, 1, 4]
    assert np.allclose(accuracy.terms[0].error(), [-0.4, 0.4, 0])
    assert model.gradient([[0.4, 0, 0]])[0].tolist() == [[0, 0, 0]]


def test_errors_of_the_samples_go_through_the_weights() -> None:
    n = 9
    samples = Samples.from_array(np.zeros((3, 3)), accuracy=EXACT.add(deviation("s", 1.0, n), bound("b", 0.5, n)))
    _, accuracy = Model.between(samples).at(np.array([[0.5, 0.5, 0], [1, 1, 0], [0.5, 1, 0]]))
    sizes = {t.name: t.size() for t in accuracy.terms}
    assert np.allclose(sizes["s"], [0.5, 1, np.sqrt(0.5)])
    assert np.allclose(sizes["b"], 0.5)


def test_vector_samples_have_a_value_and_an_error_per_component() -> None:
    field = np.random.default_rng(0).normal(size=(3, 4, 5, 3))
    samples = Samples.from_array(field, accuracy=EXACT.add(replace(deviation("s", 1.0, field.size), components=3)))
    model = Model.between(samples)
    values, accuracy = model.at(np.array([[1, 2, 1], [0.5, 0.5, 0.5]]))
    assert np.allclose(values[0], field[1, 2, 1])
    assert np.allclose(values[1], field[:2, :2, :2].reshape(-1, 3).mean(axis=0))
    assert accuracy.terms[0].error().shape == (2, 3)
    assert np.allclose(accuracy.terms[0].error()[1], 1 / np.sqrt(8))
    with pytest.raises(ValueError, match="tensor"):
        model.gradient([[1, 1, 1]])


def test_points_outside_are_refused_with_the_first_of_them() -> None:
    model = Model.between(Samples.from_array(np.zeros((3, 3)), accuracy=EXACT))
    with pytest.raises(ValueError, match="1 of 2 points lie outside the grid, the first at 3, 0, 0; x goes from 0 to 2"):
        model.at(np.array([[1, 1, 0], [3, 0, 0]]))
    assert model.at(np.array([[2 + 1e-12, 0, 0]]))[0] == 0


def test_beside_a_hole_the_model_error_is_not_made_up() -> None:
    values = np.arange(81.0).reshape(9, 9) ** 2
    values[4, 4] = np.nan
    model = Model.between(Samples.from_array(values, accuracy=EXACT))
    inside, accuracy = model.at(np.array([[0.5, 0.5, 0], [1, 1, 0]]))
    assert np.isfinite(inside).all()
    assert not accuracy.missing
    two = Model.between(Samples.from_array(np.ones((2, 2)), accuracy=EXACT))
    assert two.accuracy.rigour() == "unknown"
    assert two.at(np.array([[0.5, 0.5, 0]]))[1].rigour() == "unknown"


def test_second_derivative_of_uneven_axes_is_exact_for_parabolas() -> None:
    x = np.array([0.0, 1, 1.5, 4, 4.2])
    grid = Rectilinear((x, np.arange(3.0)))
    field = np.broadcast_to(3 * x**2 - x, (3, 5))
    assert np.allclose(second_derivative(grid, field, 0), 6)
    assert np.allclose(second_derivative(grid, field, 1), 0)


def test_geometry_knows_its_lines_triangles_and_segments() -> None:
    shape = Geometry(
        points=np.arange(18.0).reshape(6, 3),
        vertices=Cells.of([[0]]),
        lines=Cells.of([[0, 1, 2, 0], [3, 4]]),
        polygons=Cells.of([[0, 1, 2, 3], [2, 3, 4]]),
        accuracy=EXACT,
    )
    assert shape.counts == {"point": 6, "cell": 5, "segment": 4}
    assert shape.segments().tolist() == [[0, 1], [1, 2], [2, 0], [3, 4]]
    assert shape.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [2, 3, 4]]
    assert [len(p) for p in shape.polylines()] == [4, 2]
    empty = Geometry(points=np.zeros((0, 3)), accuracy=EXACT)
    assert empty.triangles.shape == (0, 3)
    assert empty.segments().shape == (0, 2)
    assert empty.bounds is None


def test_an_accuracy_of_something_else_is_refused() -> None:
    two, three = (Geometry(points=np.zeros((n, 3)), accuracy=EXACT.add(bound("b", 1.0, n))) for n in (2, 3))
    assert two.accept(None) is two.accuracy
    assert two.accept(two.accuracy) is two.accuracy
    with pytest.raises(ValueError, match="Geometry of 3 points; this geometry has 2"):
        two.accept(three.accuracy)


def test_a_sphere_carries_errors_of_its_centre_and_radius() -> None:
    """Thesis 2.3.1: (xc, yc, zc, r) with (dxc, dyc, dzc) and dr."""
    fit = Source("fit", "mapping", "estimated")
    centre = Term(fit, "linear", "centre", "m", np.array([0.1, 0.1, 0.2]), Identity(3), "point", 3)
    radius = bound("fit of the radius", 0.05, 1, quantity="radius", unit="m")
    sphere = Primitive(
        kind="sphere", values={"centre": np.zeros(3), "radius": np.ones(1)}, accuracy=EXACT.add(centre, radius)
    )
    shape = Geometry(points=np.zeros((0, 3)), primitives=(sphere,), accuracy=EXACT)
    assert shape.primitives[0].accuracy.total(1, "radius") == pytest.approx(0.05)
    with pytest.raises(ValueError, match="'height'"):
        Primitive(kind="sphere", values={"radius": np.ones(1)}, accuracy=EXACT.add(bound("x", 1.0, 1, quantity="height")))


def test_facts_are_cheap_and_named() -> None:
    samples = Samples.from_array(np.array([[1.0, np.nan], [3, 2]]), unit="m", name="h", accuracy=EXACT)
    model = Model.between(samples)
    shape = Geometry(points=np.zeros((1, 3)), values={"a": Field(np.array([2.0]))}, accuracy=EXACT)
    for wire in (samples, model, shape, Table(columns={"a": np.zeros(2)}, accuracy=EXACT), Value(value=3.0, accuracy=EXACT)):
        assert set(wire.facts()) == set(type(wire).FACTS)
    assert samples.facts()["range"] == (1.0, 3.0)
    assert isinstance(samples.grid, Regular)
    assert shape.facts()["ranges"] == {"a": (2.0, 2.0)}
