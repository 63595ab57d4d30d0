"""The error background: each cell that a line passes, with the area left in it, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from modules.accuracy_mappers._cells import corners
from modules.accuracy_mappers.background import background
from modules.api import EXACT, Curvilinear, Geometry, Model, Progress, Samples, Unstructured, bound
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def model(n: int = 24, **words: object) -> Model:
    y, x = np.mgrid[0:n, 0 : n + 3] / n
    values = np.sin(9 * x) * np.cos(7 * y) + 0.3 * x
    accuracy = EXACT.add(bound("rounding", 0.01, values.size))
    return interpolate(Samples.from_array(values, accuracy=accuracy, **words))  # type: ignore[arg-type]  # any words


def lines_of(field: Model, method: str = "basic") -> Geometry:
    return contour(field, Progress(), levels=(0.1, 0.3), method=method)  # type: ignore[arg-type]  # a word


def test_the_thesis_cell_holds_the_area_of_both_arcs() -> None:
    field = interpolate(Samples.from_array(CELL, accuracy=EXACT))
    for method, area in (("basic", 0.050928223 + 0.170748505), ("shoulder", 0.008539327 + 0.021585992)):
        got = background(contour(field, Progress(), levels=(17.6,), method=method), field)  # type: ignore[arg-type]  # a word
        assert got.values["area"].values.tolist() == pytest.approx([area], rel=1e-7)
        assert sorted(got.points.tolist()) == [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]
        assert [len(c) for c in (got.polygons, got.lines, got.vertices)] == [1, 0, 0]


@pytest.mark.parametrize("method", ["basic", "shoulder"])
def test_each_cell_holds_the_segments_that_lie_in_it(method: str) -> None:
    """Which segments lie in a cell is decided here from positions, not from the lines' own numbers."""
    field = model(axes=(np.cumsum(np.linspace(1, 2, 27)), np.cumsum(np.linspace(3, 1, 24))))
    lines = lines_of(field, method)
    got = background(lines, field)
    (term,) = lines.accuracy.select("area")
    middle = lines.points[lines.segments()].mean(axis=1)
    total = 0.0
    for k, area in enumerate(got.values["area"].values):
        box = got.points[got.polygons.connectivity[got.polygons.offsets[k] : got.polygons.offsets[k + 1]]]
        low, high = box.min(axis=0), box.max(axis=0)
        inside = ((middle[:, :2] > low[:2]) & (middle[:, :2] < high[:2])).all(axis=1)
        assert inside.any()
        assert area == pytest.approx(term.size()[inside].sum(), rel=1e-12)
        total += area
    assert total == pytest.approx(term.size().sum(), rel=1e-12)


def test_corners_go_round_against_the_clock() -> None:
    got = background(lines_of(model()), model())
    x, y = got.points[got.polygons.connectivity.reshape(-1, 4), :2].transpose(2, 0, 1)
    areas = 0.5 * (x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1)
    assert areas == pytest.approx(1.0)
    assert len(np.unique(got.points, axis=0)) == len(got.points)


def test_the_area_goes_on_per_cell_and_all_else_ends_with_a_reason() -> None:
    field = model()
    lines = lines_of(field)
    got = background(lines, field)
    (term,) = got.accuracy.terms
    assert (term.quantity, term.place, term.kind, term.source.rigour) == ("area", "cell", "metric", "exact")
    assert term.id == lines.accuracy.select("area")[0].id
    assert term.size() == pytest.approx(got.values["area"].values)
    some = np.array([5, 2])
    assert term.size(some) == pytest.approx(got.values["area"].values[some])
    assert got.accuracy.accounted() >= lines.accuracy.accounted() | field.accuracy.accounted()
    assert all(e.why for e in got.accuracy.ended.values())
    (shown,) = got.shows
    assert (shown.name, shown.quantity, shown.note, shown.factor) == (term.name, "area", "per cell", 1.0)


def test_the_lines_are_not_changed() -> None:
    field = model()
    lines = lines_of(field)
    before = (lines.points.copy(), dict(lines.values), lines.accuracy)
    background(lines, field)
    assert np.array_equal(before[0], lines.points)
    assert before[1:] == (dict(lines.values), lines.accuracy)


def test_no_lines_no_cells() -> None:
    field = model()
    got = background(contour(field, Progress(), levels=(99.0,)), field)
    assert got.counts == {"point": 0, "cell": 0, "segment": 0}


def test_what_does_not_belong_together_is_told() -> None:
    field = model()
    lines = lines_of(field)
    with pytest.raises(ValueError, match="wire the lines of 'contour'"):
        background(Geometry(points=np.zeros((2, 3)), accuracy=EXACT), field)
    with pytest.raises(ValueError, match="wire the model"):
        background(lines, interpolate(Samples.from_array(CELL, accuracy=EXACT)))
    with pytest.raises(ValueError, match="do not lie in the cells"):
        background(lines, model(origin=(0.5, 0.0)))
    with pytest.raises(ValueError, match="take a slice"):
        background(lines, interpolate(Samples.from_array(np.zeros((9, 9, 9)), accuracy=EXACT)))


def test_cells_of_bent_lattices_and_of_triangles() -> None:
    nodes = np.stack(np.meshgrid(np.arange(3.0), np.arange(2.0)), axis=-1)
    nodes = np.concatenate([nodes + 0.1 * nodes**2, np.zeros((2, 3, 1))], axis=-1)
    points, cells = corners(Curvilinear(nodes=nodes), np.array([1]))
    assert points[cells.connectivity].tolist() == nodes[[0, 0, 1, 1], [1, 2, 2, 1]].tolist()
    flat = Unstructured(nodes=nodes.reshape(-1, 3), offsets=np.array([0, 3, 7]), connectivity=np.array([0, 1, 3, 1, 2, 5, 4]),
                        types=np.array([5, 9]))  # fmt: skip
    points, cells = corners(flat, np.array([0, 1]))
    assert cells.sizes().tolist() == [3, 4]
    assert points[cells.connectivity].tolist() == nodes.reshape(-1, 3)[[0, 1, 3, 1, 2, 5, 4]].tolist()
