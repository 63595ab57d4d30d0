"""What lies between two contourings: as much as their areas differ, and where they join in another way."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.accuracy_mappers import _between
from modules.accuracy_mappers.difference import Difference, difference
from modules.api import EXACT, Frame, Geometry, Model, Progress, Samples, bound
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

Floats = NDArray[np.float64]
CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def model(values: object, **words: object) -> Model:
    array = np.asarray(values, float)
    accuracy = EXACT.add(bound("rounding", 0.01, array.size))
    return interpolate(Samples.from_array(array, accuracy=accuracy, **words))  # type: ignore[arg-type]  # any words


def drawn(field: Model, method: str, levels: tuple[float, ...] = (17.6,)) -> Geometry:
    return contour(field, Progress(), levels=levels, method=method)  # type: ignore[arg-type]  # a word


def area(lines: Geometry) -> float:
    return float(lines.accuracy.select("area")[0].size().sum())


def noise(seed: int, shape: tuple[int, int] = (25, 30)) -> Floats:
    return np.random.default_rng(seed).normal(size=shape)


def total(got: Difference) -> float:
    return float(got.between.values["area"].values.sum())


def test_the_thesis_cell() -> None:
    field = model(CELL)
    basic, shoulder = drawn(field, "basic"), drawn(field, "shoulder")
    got = difference(basic, shoulder, Progress())
    one, two = 0.050928223 - 0.008539327, 0.170748505 - 0.021585992
    assert sorted(got.between.values["area"].values.tolist()) == pytest.approx([one, two], rel=1e-7)
    assert got.between.polygons.sizes().tolist() == [3, 3]  # triangles, as in figure 3.7
    assert got.table.columns["area"].tolist() == pytest.approx([one + two], rel=1e-7)
    assert not got.between.accuracy.flags


@pytest.mark.parametrize("seed", range(2))
def test_it_is_the_difference_of_the_metric(seed: int) -> None:
    axes = (np.cumsum(np.random.default_rng(seed).uniform(1, 2, 30)), np.cumsum(np.random.default_rng(9).uniform(1, 3, 25)))
    field, levels = model(noise(seed), axes=axes), (-0.7, 0.1)
    basic, shoulder, exact = (drawn(field, m, levels) for m in ("basic", "shoulder", "exact"))
    between = difference(basic, shoulder, Progress())
    assert total(between) == pytest.approx(area(basic) - area(shoulder), rel=1e-12)
    assert total(difference(shoulder, basic, Progress())) == pytest.approx(total(between), rel=1e-12)
    rest = total(difference(shoulder, exact, Progress()))
    assert rest == pytest.approx(area(shoulder) - area(exact), rel=1e-9)


def test_ties_and_degenerate_cells() -> None:
    values = np.random.default_rng(3).integers(-2, 3, (30, 30))  # nodes and saddles on the level in plenty
    field = model(values)
    basic, shoulder = drawn(field, "basic", (0.0, 0.5)), drawn(field, "shoulder", (0.0, 0.5))
    got = difference(basic, shoulder, Progress())
    assert total(got) == pytest.approx(area(basic) - area(shoulder), rel=1e-12)
    assert not got.between.accuracy.flags


def disagreement(one: Geometry, two: Geometry, n: int = 900) -> float:
    """Area of the unit cell on which two drawings differ about the side of the lines: parity of crossings, on a raster."""
    u = (np.arange(n) + 0.5) / n
    x, y = np.meshgrid(u, u)
    sides = []
    for lines in (one, two):
        odd = np.zeros((n, n), bool)
        for line in lines.polylines():
            for p, q in pairwise(line[:, :2]):
                between = (x < p[0]) != (x < q[0])  # of a ray that goes down from each place
                with np.errstate(divide="ignore", invalid="ignore"):
                    height = p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1])
                odd ^= between & (height < y)
        sides.append(odd)
    return float((sides[0] ^ sides[1]).mean())


def test_the_thesis_cell_by_four_triangles_is_joined_in_another_way() -> None:
    field = model(CELL)
    four, shoulder = drawn(field, "four_triangles"), drawn(field, "shoulder")
    got = difference(shoulder, four, Progress())
    assert total(got) == pytest.approx(disagreement(shoulder, four), abs=4e-3)
    (flag,) = got.between.accuracy.flags
    assert flag.name == "joined in another way"
    assert "in 1 cell" in flag.words
    assert set(got.between.values["joined in another way"].values) == {1}
    assert got.table.columns["joined in another way"].tolist() == [1]


@pytest.mark.parametrize("seed", range(12))
def test_any_two_methods_in_one_cell_against_a_raster(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    field, level = model(random.normal(size=(2, 2))), float(random.normal(scale=0.2))
    methods = ("basic", "four_triangles", "shoulder", "exact")
    lines = {m: drawn(field, m, (level,)) for m in methods}
    for i, first in enumerate(methods):
        for second in methods[i + 1 :]:
            got = total(difference(lines[first], lines[second], Progress()))
            assert got == pytest.approx(disagreement(lines[first], lines[second], 500), abs=6e-3), (first, second)


def test_a_corner_on_the_level_that_one_method_passes_and_the_other_does_not() -> None:
    field = model([[247.0, 261.0], [250.0, 249.0]])
    four, shoulder = drawn(field, "four_triangles", (250.0,)), drawn(field, "shoulder", (250.0,))
    assert [len(g.polylines()) for g in (shoulder, four)] == [1, 2]
    got = difference(shoulder, four, Progress())
    assert total(got) == pytest.approx(disagreement(shoulder, four), abs=4e-3)
    assert [f.name for f in got.between.accuracy.flags] == ["joined in another way"]


def test_wrong_joins_are_those_where_centre_and_saddle_differ() -> None:
    """Thesis 3.2.1: four triangles are wrong exactly there; counted here cell by cell from the corner values."""
    values = noise(5, (60, 60))
    field = model(values)
    got = difference(drawn(field, "shoulder", (0.05,)), drawn(field, "four_triangles", (0.05,)), Progress())
    f00, f10, f01, f11 = (v - 0.05 for v in (values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]))
    ambiguous = ((f00 > 0) == (f11 > 0)) & ((f10 > 0) == (f01 > 0)) & ((f00 > 0) != (f10 > 0))
    saddle = (f00 * f11 - f10 * f01) / (f00 + f11 - f10 - f01)
    wrong = ambiguous & ((saddle > 0) != (f00 + f10 + f01 + f11 > 0))
    assert {f.name for f in got.between.accuracy.flags} == {"joined in another way"}
    marked = got.table.columns["grid cell"][got.table.columns["joined in another way"] == 1]
    assert sorted(marked.tolist()) == np.flatnonzero(wrong).tolist()
    assert len(marked) > 20


def test_polygons_are_filled_without_overlap() -> None:
    """Each polygon is convex, so that a fan of triangles fills it."""
    field = model(noise(6))
    got = difference(drawn(field, "shoulder", (0.1,)), drawn(field, "four_triangles", (0.1,)), Progress()).between
    triangles = got.points[got.triangles][:, :, :2]
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    fans = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
    assert fans == pytest.approx(got.values["area"].values.sum(), rel=1e-12)


def test_a_loop_that_crosses_itself_is_cut_there() -> None:
    bow = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)]
    rings = list(_between.simple(bow))
    assert sorted(abs(_between.shoelace(r)) for r in rings) == [1.0, 1.0]
    corners = [[0, 0], [6, 0], [6, 3], [5, 3], [5, 1], [4, 1], [4, 3], [3, 3], [3, 1], [0, 1]]
    comb = [(float(x), float(y)) for x, y in corners]
    parts = _between.convex_parts(comb)
    assert sum(abs(_between.shoelace(p)) for p in parts) == pytest.approx(10.0)
    assert all(len(p) == 3 for p in parts)


def test_the_area_goes_on_and_all_terms_of_the_lines_end() -> None:
    field = model(CELL, frame=Frame(units=("m", "m", "")))
    basic, shoulder = drawn(field, "basic"), drawn(field, "shoulder")
    got = difference(basic, shoulder, Progress())
    for one, place in ((got.between, "cell"), (got.table, "point")):
        (term,) = one.accuracy.terms
        assert (term.quantity, term.unit, term.place, term.source.sign) == ("area", "m²", place, "=")
        assert one.accuracy.accounted() >= basic.accuracy.accounted() | shoulder.accuracy.accounted()
    assert got.table.accuracy.terms[0].size() == pytest.approx(got.table.columns["area"])
    assert got.between.shows[0].name == got.between.accuracy.terms[0].name


def test_axes_of_different_units_are_measured_in_cells() -> None:
    field = model(CELL, spacing=(10, 0.1), frame=Frame(units=("s", "m", "")))
    basic, shoulder = drawn(field, "basic"), drawn(field, "shoulder")
    got = difference(basic, shoulder, Progress())
    assert got.between.accuracy.terms[0].unit == "cell²"
    assert total(got) == pytest.approx(area(basic) - area(shoulder), rel=1e-9)


def test_one_drawing_twice_leaves_nothing() -> None:
    lines = drawn(model(noise(1)), "shoulder", (0.2,))
    got = difference(lines, lines, Progress())
    assert got.between.counts == {"point": 0, "cell": 0, "segment": 0}
    assert got.table.rows == 0


def test_what_cannot_be_compared_is_told() -> None:
    field = model(noise(2))
    lines = drawn(field, "basic", (0.0, 0.3))
    with pytest.raises(ValueError, match=r"lines at 0\.3"):
        difference(lines, drawn(field, "shoulder", (0.0,)), Progress())
    with pytest.raises(ValueError, match="wire two contourings of one model"):
        difference(lines, drawn(model(noise(3)), "shoulder", (0.0, 0.3)), Progress())
    with pytest.raises(ValueError, match="wire the lines of 'contour'"):
        difference(lines, Geometry(points=np.zeros((2, 3)), accuracy=EXACT), Progress())
