"""The error band: it covers the contours of as many draws as it says, fades, and never claims where it may not."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from modules import kernels
from modules.accuracy_mappers.band import band
from modules.api import EXACT, Accuracy, Frame, Geometry, Missing, Model, Progress, Samples, Spread, bound, deviation, stencil
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

Floats = NDArray[np.float64]
N = 40


def hills(n: int = N) -> Floats:
    y, x = np.mgrid[0:n, 0:n] / n
    return np.asarray(np.sin(5 * x + 0.3) * np.cos(4 * y + 0.2) + 0.5 * x)


def model(values: Floats, accuracy: Accuracy, **words: object) -> Model:
    return interpolate(Samples.from_array(values, accuracy=accuracy, **words))  # type: ignore[arg-type]  # any words


def around(field: Model, levels: tuple[float, ...], **words: object) -> Geometry:
    return band(contour(field, Progress(), levels=levels), field, Progress(), **words)  # type: ignore[arg-type]  # any words


def inside(shapes: Geometry, keep: NDArray[np.bool_], at: Floats) -> NDArray[np.bool_]:
    """Whether points lie in some polygons: even-odd over the sides of all."""
    offsets, c = shapes.polygons.offsets, shapes.polygons.connectivity
    following = np.arange(1, len(c) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    mine = np.repeat(keep, np.diff(offsets))
    p, q = shapes.points[c[mine], :2], shapes.points[c[following[mine]], :2]
    found = np.zeros(len(at), bool)
    for i in range(0, len(at), 500):
        x, y = at[i : i + 500, :1], at[i : i + 500, 1:2]
        crosses = (p[:, 1] > y) != (q[:, 1] > y)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            there = p[:, 0] + (y - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0])
        found[i : i + 500] = (crosses & (x < there)).sum(axis=1) % 2 == 1
    return found


def drawn(values: Floats, level: float) -> tuple[Floats, Floats]:
    """Middles and lengths of the segments of a contour."""
    axis = np.arange(float(len(values)))
    lines = kernels.contour.lines(values, axis, axis, level)
    real = np.ones(len(lines.points) - 1, bool)
    real[lines.offsets[1:-1] - 1] = False
    step = np.diff(lines.points, axis=0)[real]
    return lines.points[:-1][real] + step / 2, np.linalg.norm(step, axis=1)


def curved(values: Floats, sigma: Floats) -> NDArray[np.bool_]:
    """Cells where sigma |F''| > 0.4 slope^2, from differences of the samples alone."""
    up, across = np.gradient(values)
    bent = np.maximum(np.abs(np.gradient(up)[0]), np.abs(np.gradient(across)[1]))
    kappa = sigma.reshape(values.shape) * bent / np.maximum(up**2 + across**2, 1e-12)
    f = kappa > 0.4
    return np.asarray(f[:-1, :-1] | f[1:, :-1] | f[:-1, 1:] | f[1:, 1:])


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("sigma", [0.01, 0.05])
def test_a_band_of_two_deviations_covers_95_per_cent_of_the_draws(sigma: float, correlated: bool) -> None:
    values, random = hills(), np.random.default_rng(5)
    accuracy = EXACT.add(deviation("noise", sigma, N * N))
    blur = [stencil((N, N), a, (-1, 0, 1), (0.25, 0.5, 0.25)) for a in (0, 1)] * 2 if correlated else []
    for operator in blur:
        accuracy = accuracy.push(operator)
    shapes = around(model(values, accuracy), (0.3, 0.6), k=2.0, steps=3)
    widest = shapes.values["k"].values == 2.0
    not_here = curved(values, accuracy.terms[0].size())
    covered = total = 0.0
    for _ in range(40):
        error = random.normal(0, sigma, N * N)
        for operator in blur:
            error = operator.apply(error)
        for level in (0.3, 0.6):
            at, length = drawn(values + error.reshape(N, N), level)
            keep = ~not_here[at[:, 1].astype(int), at[:, 0].astype(int)] & (random.random(len(at)) < 0.2)
            hit = inside(shapes, widest & (shapes.values["level"].values == level), at[keep])
            covered, total = covered + length[keep] @ hit, total + length[keep].sum()
    assert total > 1000
    assert 0.92 < covered / total < 0.98


def test_between_samples_the_band_is_as_narrow_as_the_errors_there() -> None:
    """On a plane of slope 1 across x: half-widths 2 sigma at the nodes, 2 sigma / sqrt(2) half way up an edge."""
    sigma = 0.01
    values = np.tile(np.arange(6.0), (5, 1))
    shapes = around(model(values, EXACT.add(deviation("noise", sigma, 30))), (2.0,), steps=1)
    p = shapes.points
    right = p[(p[:, 0] > 2.0)]
    for y, width in ((2.0, 2 * sigma), (2.5, 2 * sigma / math.sqrt(2))):
        here = right[np.abs(right[:, 1] - y) < 1e-12]
        assert here[:, 0].max() - 2.0 == pytest.approx(width, rel=0.02)


def test_bounds_add_to_deviations() -> None:
    values = np.tile(np.arange(6.0), (5, 1))
    common = EXACT.add(deviation("datum", 0.02, 1)).push(Spread(30))  # the same everywhere, so it does not sag
    accuracy = common.add(bound("rounding", 0.1, 30))
    shapes = around(model(values, accuracy), (2.0,), k=3.0, steps=4)
    at = shapes.points[np.abs(shapes.points[:, 1] - 2.0) < 1e-12, 0]
    assert at.max() == pytest.approx(2 + 0.1 + 3 * 0.02, abs=1e-9)
    assert at.min() == pytest.approx(2 - 0.1 - 3 * 0.02, abs=1e-9)


def test_a_bound_is_never_left() -> None:
    values, limit, random = hills(), 0.02, np.random.default_rng(0)
    shapes = around(model(values, EXACT.add(bound("rounding", limit, N * N))), (0.3,), steps=1)
    for _ in range(20):
        at, _ = drawn(values + random.uniform(-limit, limit, (N, N)) * 0.98, 0.3)
        assert inside(shapes, np.ones(len(shapes.polygons), bool), at).all()


def test_regions_are_nested_and_fade_by_equal_steps() -> None:
    shapes = around(model(hills(), EXACT.add(deviation("noise", 0.03, N * N))), (0.3,), k=2.0, steps=5)
    k, density = (np.unique(shapes.values[name].values) for name in ("k", "density"))
    assert k.max() == 2.0
    assert density == pytest.approx(math.exp(-2) + (1 - math.exp(-2)) * np.arange(5) / 5)
    at = np.random.default_rng(0).uniform(0, N - 1, (1500, 2))
    within = [inside(shapes, shapes.values["k"].values == one, at) for one in k]
    assert 0 < within[0].sum() < within[-1].sum()
    for inner, outer in itertools.pairwise(within):
        assert not (inner & ~outer).any()
    assert np.all(np.diff(shapes.values["k"].values) <= 0)  # the widest lies lowest


def test_the_line_lies_in_every_region() -> None:
    field = model(hills(), EXACT.add(deviation("noise", 0.03, N * N)))
    shapes = around(field, (0.3,), steps=4)
    at, _ = drawn(hills(), 0.3)
    for one in np.unique(shapes.values["k"].values):
        assert inside(shapes, shapes.values["k"].values == one, at).all()


def test_each_polygon_stands_for_a_segment_of_its_level() -> None:
    field = model(hills(), EXACT.add(deviation("noise", 0.02, N * N)))
    lines = contour(field, Progress(), levels=(0.3, 0.6))
    shapes = band(lines, field, Progress())
    level = np.repeat(lines.values["level"].values, lines.lines.sizes() - 1)
    assert shapes.origin is not None
    assert np.array_equal(level[shapes.origin], shapes.values["level"].values)
    middle = lines.points[lines.segments()[shapes.origin]].mean(axis=1)
    first = shapes.points[shapes.polygons.connectivity[shapes.polygons.offsets[:-1]]]
    assert np.linalg.norm(middle - first, axis=1).max() < 3


def test_terms_of_the_data_go_on_as_positions_and_the_rest_ends() -> None:
    terms = bound("rounding", 0.01, N * N, unit="m"), deviation("survey", 0.02, N * N, unit="m")
    accuracy = EXACT.add(*terms).miss(Missing("x"))
    field = model(hills(), accuracy, unit="m", frame=Frame(units=("m", "m", "m")))
    lines = contour(field, Progress(), levels=(0.3,))
    shapes = band(lines, field, Progress())
    assert [(t.name, t.quantity, t.unit, t.place) for t in shapes.accuracy.terms] == [
        ("rounding", "position", "m", "cell"),
        ("survey", "position", "m", "cell"),
    ]
    assert [(s.name, s.quantity) for s in shapes.shows] == [("rounding", "position"), ("survey", "position")]
    assert "k = 2" in shapes.shows[1].note
    for given in (lines.accuracy, field.accuracy):
        assert {t.id for t in given.terms} <= shapes.accuracy.accounted()
    assert Missing("x") in shapes.accuracy.missing
    assert all(e.why for e in shapes.accuracy.ended.values())
    survey, theirs = shapes.accuracy.terms[1], next(t for t in lines.accuracy.select("position") if t.name == "survey")
    start = lines.segments()[shapes.origin, 0]
    assert np.median(survey.size() / theirs.size(start)) == pytest.approx(1.0, abs=0.02)


def test_errors_of_the_model_widen_it_when_asked() -> None:
    y, x = np.mgrid[0:20, 0:20] * 1.0
    values = x**2 / 10 + y
    field = model(values, EXACT.add(bound("rounding", 0.01, 400)))
    narrow, wide = (around(field, (12.3,), steps=1, modelled=m) for m in (False, True))
    size = [np.bincount(np.zeros(len(g.polygons), int), polygon_areas(g))[0] for g in (narrow, wide)]
    assert size[1] > 1.3 * size[0]
    truth = np.linspace(2.0, 10.0, 200)
    at = np.column_stack([truth, 12.3 - truth**2 / 10])
    everything = [np.ones(len(g.polygons), bool) for g in (narrow, wide)]
    assert not inside(narrow, everything[0], at).all()
    assert inside(wide, everything[1], at).all()
    assert {t.name for t in wide.accuracy.terms} == {"rounding", "Interpolation between samples"}


def polygon_areas(shapes: Geometry) -> Floats:
    p, offsets = shapes.points[shapes.polygons.connectivity, :2], shapes.polygons.offsets
    following = np.arange(1, len(p) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return np.asarray(np.add.reduceat(p[:, 0] * p[following, 1] - p[following, 0] * p[:, 1], offsets[:-1]) / 2)


def test_accuracy_from_elsewhere_is_that_of_the_same_model() -> None:
    field = model(hills(), EXACT.add(deviation("noise", 0.01, N * N)))
    lines = contour(field, Progress(), levels=(0.3,))
    more = replace(field.accuracy, terms=(deviation("other", 0.04, N * N),))
    wide, narrow = band(lines, field, Progress(), more, steps=1), band(lines, field, Progress(), steps=1)
    assert polygon_areas(wide).sum() > 3 * polygon_areas(narrow).sum()
    assert [t.name for t in wide.accuracy.terms] == ["other"]
    assert {t.id for t in (*field.accuracy.terms, *lines.accuracy.terms)} <= wide.accuracy.accounted()
    with pytest.raises(ValueError, match="speaks of 4"):
        band(lines, field, Progress(), EXACT.add(deviation("other", 0.04, 4)))


def test_flat_places_are_marked_and_flagged() -> None:
    y, x = np.mgrid[-6:7, -6:7] * 1.0
    shapes = around(model(x**2 + y**2, EXACT.add(deviation("noise", 0.5, 169))), (0.5, 20.0))
    valid = shapes.values["valid"].values
    level = shapes.values["level"].values
    first = shapes.points[shapes.polygons.connectivity, :2]
    far = np.maximum.reduceat(np.abs(first - 6.0).max(axis=1), shapes.polygons.offsets[:-1])
    assert (far[level == 0.5] <= 1).any()
    assert not valid[far <= 1].any()
    assert valid[level == 20.0].all()
    (kappa,) = shapes.accuracy.flags
    assert kappa.name == "kappa"
    assert set(level[kappa.items]) == {0.5}


def test_holes_leave_holes_and_no_error_leaves_no_band() -> None:
    values = hills()
    values[10:14, 15:25] = np.nan
    shapes = around(model(values, EXACT.add(deviation("noise", 0.02, N * N))), (0.3, 0.6, 0.9))
    hole = (shapes.points[:, 0] > 14.01) & (shapes.points[:, 0] < 24.99) & (np.abs(shapes.points[:, 1] - 11.5) < 2.49)
    assert len(shapes.polygons) > 0
    assert not hole.any()
    empty = around(model(hills(), EXACT.add(bound("none", 0.0, N * N))), (0.3,))
    assert empty.counts["cell"] == 0
    assert [t.name for t in empty.accuracy.terms] == ["none"]


def test_lines_that_are_not_there_have_no_band() -> None:
    field = model(hills(), EXACT.add(deviation("noise", 0.02, N * N)))
    assert around(field, (99.0,)).counts["cell"] == 0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda f, c: band(Geometry(points=np.zeros((2, 3)), accuracy=EXACT), f, Progress()), "wire the lines of 'contour'"),
        (lambda f, c: band(c, interpolate(f.samples, law="nearest"), Progress()), "needs a linear model"),
        (lambda f, c: band(replace(c, frame=Frame(units=("m", "m", "m"))), f, Progress()), "different frames"),
        (lambda f, c: band(c, f, Progress(), EXACT), "state one with 'state accuracy'"),
        (lambda f, c: band(c, f, Progress(), k=0.0), "k > 0"),
        (lambda f, c: band(c, f, Progress(), steps=0), "one step or more"),
    ],
)
def test_what_it_cannot_draw_is_told(make: object, words: str) -> None:
    field = model(hills(), EXACT.add(deviation("noise", 0.02, N * N)))
    lines = contour(field, Progress(), levels=(0.3,))
    with pytest.raises(ValueError, match=words):
        make(field, lines)  # type: ignore[operator]  # a function
