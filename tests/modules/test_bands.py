"""The mapper `bands`: what it fills, what its table says, and that errors of the model reach borders and areas."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from modules import kernels
from modules.api import EXACT, Frame, Geometry, Model, Progress, Samples, bound, deviation, stencil
from modules.mappers.bands import bands
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def model(values: object, **words: object) -> Model:
    words.setdefault("accuracy", EXACT)
    return interpolate(Samples.from_array(np.asarray(values, float), **words))  # type: ignore[arg-type]  # any words


def hills(n: int = 40) -> NDArray[np.float64]:
    y, x = np.mgrid[0:n, 0:n] / n
    return np.asarray(np.sin(9 * x + 0.1) * np.cos(7 * y) + 0.3 * x)


def polygon_areas(shapes: Geometry) -> NDArray[np.float64]:
    p = shapes.points[shapes.polygons.connectivity, :2]
    offsets = shapes.polygons.offsets
    following = np.arange(1, len(p) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    cross = p[:, 0] * p[following, 1] - p[following, 0] * p[:, 1]
    return np.asarray(np.add.reduceat(cross, offsets[:-1]) / 2)


def test_each_band_has_its_ends_and_its_polygons() -> None:
    filled = bands(model(hills(), unit="m", name="height"), Progress(), interval=0.5)
    shapes, table = filled
    assert table.columns["low"].tolist() == [-1, -0.5, 0, 0.5, 1]
    assert table.columns["high"].tolist() == [-0.5, 0, 0.5, 1, 1.5]
    band = shapes.values["band"].values
    assert np.array_equal(shapes.values["low"].values, table.columns["low"][band])
    assert np.array_equal(shapes.values["level"].values, table.columns["low"][band] + 0.25)
    assert shapes.values["level"].unit == table.units["low"] == "m"
    middle = np.add.reduceat(shapes.points[shapes.polygons.connectivity], shapes.polygons.offsets[:-1])
    middle = middle / shapes.polygons.sizes()[:, None]
    assert np.array_equal(shapes.origin, middle[:, 1] // 1 * 39 + middle[:, 0] // 1)  # type: ignore[arg-type]  # it has one
    assert table.columns["share"].sum() == pytest.approx(1.0, rel=1e-13)
    assert table.columns["area"].sum() == pytest.approx(39.0**2, rel=1e-13)


def test_areas_are_those_of_the_samples_counted_finely() -> None:
    field = model(hills(12), spacing=(2.0, 3.0))
    _, table = bands(field, Progress(), levels=(-0.4, 0.1, 0.7))
    n = 400
    x, y = (np.arange(n) + 0.5) / n * 22, (np.arange(n) + 0.5) / n * 33
    at = np.stack([*np.meshgrid(x, y), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    counted = np.histogram(field.at(at)[0], (-0.4, 0.1, 0.7))[0] / n**2
    assert table.columns["area"] == pytest.approx(counted * 22 * 33, rel=2e-3)
    assert table.columns["share"] == pytest.approx(counted, rel=2e-3)


@pytest.mark.parametrize("tolerance", [0.3, 1e-3])
def test_polygons_differ_from_the_areas_by_no_more_than_they_say(tolerance: float) -> None:
    shapes, table = bands(model(hills(20)), Progress(), interval=0.25, tolerance=tolerance)
    (left,) = shapes.accuracy.select("area")
    assert left.kind == "metric"
    assert left.source.rigour == "exact"
    band = shapes.values["band"].values
    drawn = np.bincount(band, polygon_areas(shapes), table.rows)
    stated = np.bincount(band, left.size(), table.rows)
    off = np.abs(drawn - table.columns["area"])
    assert (off <= stated + 1e-12).all()
    assert off.max() > 1e-3 * stated.max()


def test_chords_are_no_farther_from_the_border_than_they_say() -> None:
    """The value at the middle of each border's side, over the least slope there."""
    field = model(CELL)
    shapes, _ = bands(field, Progress(), levels=(10.0, 17.6, 24.5), tolerance=0.5)
    (chord,) = [t for t in shapes.accuracy.select("position") if t.name == "Chords of the borders"]
    lines = contour(field, Progress(), levels=(17.6,), method="basic")
    (basic,) = [t for t in lines.accuracy.select("position") if t.name == "One chord a cell"]
    assert sorted(chord.size()[chord.size() > 0]) == pytest.approx(sorted(basic.size()), rel=1e-9)


def test_a_noisy_field_moves_borders_as_it_moves_contour_lines() -> None:
    field = model(hills(20), accuracy=EXACT.add(deviation("sensor", 0.002, 400)))
    shapes, _ = bands(field, Progress(), levels=(-9.0, 0.3, 9.0))
    lines = contour(field, Progress(), levels=(0.3,), method="basic")
    (mine,) = [t for t in shapes.accuracy.select("position") if t.name == "sensor"]
    (theirs,) = [t for t in lines.accuracy.select("position") if t.name == "sensor"]
    place = {tuple(p): i for i, p in enumerate(shapes.points.tolist())}
    same = np.array([place[tuple(p)] for p in lines.points.tolist()])
    assert mine.size(same) == pytest.approx(theirs.size(), rel=1e-9)
    off_border = np.flatnonzero(np.isin(shapes.points, np.arange(20)).all(axis=1))
    assert mine.size(off_border).max() == 0.0  # a grid node inside a band is no border


@pytest.mark.parametrize("smooth", [False, True])
def test_a_noisy_field_changes_areas_by_the_stated_deviation(smooth: bool) -> None:
    """Monte Carlo over the samples, for noise that is independent and for one that a stencil has correlated."""
    sigma, draws, n = 0.01, 250, 30
    values, random = hills(n), np.random.default_rng(2)
    accuracy = EXACT.add(deviation("sensor", sigma, n * n))
    blur = [stencil((n, n), axis, (-1, 0, 1), (0.25, 0.5, 0.25)) for axis in (0, 1)] if smooth else []
    for operator in blur:
        accuracy = accuracy.push(operator)
    marks = (-0.6, -0.1, 0.4, 0.9)
    _, table = bands(model(values, accuracy=accuracy), Progress(), levels=marks)
    (noise,) = [t for t in table.accuracy.select("area") if t.name == "sensor"]
    axis = np.arange(float(n))
    found = np.empty((draws, 3))
    for i in range(draws):
        error = random.normal(0, sigma, n * n)
        for operator in blur:
            error = operator.apply(error)
        drawn = kernels.bands.fill(values + error.reshape(n, n), axis, axis, marks, 0.5)
        found[i] = np.bincount(drawn.band, drawn.area, 3)
    assert found.std(axis=0) == pytest.approx(noise.size(), rel=0.15)
    assert np.abs(found.mean(axis=0) - table.columns["area"]).max() < 0.3 * noise.size().max()


def test_every_term_goes_on_to_shapes_and_table() -> None:
    accuracy = EXACT.add(bound("rounding", 0.5, 1600, unit="m"))
    field = model(100 * hills(), unit="m", frame=Frame(units=("m", "m", "m")), accuracy=accuracy)
    shapes, table = bands(field, Progress(), interval=50)
    names = {t.name: (t.source.rigour, t.quantity, t.unit, t.place) for t in shapes.accuracy.terms}
    assert names == {
        "rounding": ("proven", "position", "m", "point"),
        "Interpolation between samples": ("estimated", "position", "m", "point"),
        "Chords of the borders": ("proven", "position", "m", "point"),
        "Area between border and polygon": ("exact", "area", "m²", "cell"),
    }
    assert {t.name: (t.quantity, t.unit) for t in table.accuracy.terms} == {
        "rounding": ("area", "m²"),
        "Interpolation between samples": ("area", "m²"),
        "Area by closed form": ("area", "m²"),
    }
    ids = {t.id for t in field.accuracy.terms}
    assert ids <= shapes.accuracy.accounted()
    assert ids <= table.accuracy.accounted()


def test_the_bound_of_an_area_holds() -> None:
    values, limit = hills(30), 0.003
    field = model(values, accuracy=EXACT.add(bound("rounding", limit, 900)))
    _, table = bands(field, Progress(), levels=(-0.1, 0.4))
    (stated,) = [t for t in table.accuracy.terms if t.name == "rounding"]
    axis, random = np.arange(30.0), np.random.default_rng(0)
    worst = max(
        abs(kernels.bands.fill(values + e, axis, axis, (-0.1, 0.4), 0.5).area.sum() - table.columns["area"][0])
        for e in (random.choice([-limit, limit], (30, 30)) for _ in range(50))
    )
    low, high = (kernels.bands.fill(values + e, axis, axis, (-0.1, 0.4), 0.5).area.sum() for e in (-limit, limit))
    assert 0 < worst < stated.size()[0]
    assert abs(high - low) / 2 < stated.size()[0] * 1.02


def test_flat_places_are_flagged_in_shapes_and_table() -> None:
    y, x = np.mgrid[-5:6, -5:6] * 1.0
    basin = model(x**2 + y**2, accuracy=EXACT.add(bound("b", 0.5, 121)))
    shapes, table = bands(basin, Progress(), levels=(0.01, 9.0, 20.0, 30.0))
    (kappa,) = [f for f in shapes.accuracy.flags if f.name == "kappa"]
    assert kappa.items is not None
    assert np.hypot(*(shapes.points[kappa.items, :2] - 5.0).T).min() < 1
    (rows,) = [f for f in table.accuracy.flags if f.name == "kappa"]
    assert rows.items is not None
    assert 0 in rows.items.tolist()
    assert 2 not in rows.items.tolist()


@pytest.mark.parametrize(("count", "rows"), [(1, 1), (7, 7)])
def test_so_many_bands_hold_every_value(count: int, rows: int) -> None:
    _, table = bands(model(hills()), Progress(), count=count)
    assert table.rows == rows
    assert table.columns["share"].sum() == pytest.approx(1.0, rel=1e-13)
    assert np.diff(table.columns["low"]) == pytest.approx(np.ptp(hills()) / count)


def test_a_plateau_at_the_top_is_filled() -> None:
    values = np.minimum(hills(), 0.5)
    for words in ({"interval": 0.5}, {"count": 4}):
        _, table = bands(model(values), Progress(), **words)
        assert table.columns["share"].sum() == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("values", [np.ones((3, 3)), np.full((3, 3), np.nan)])
def test_a_constant_and_a_hole(values: NDArray[np.float64]) -> None:
    shapes, table = bands(model(values), Progress())
    assert table.columns["area"].sum() == (4.0 if np.isfinite(values).all() else 0.0)
    assert shapes.accuracy.total(2, "position").max(initial=0.0) == 0.0


def test_axes_of_different_units_are_measured_in_cells() -> None:
    frame = Frame(units=("s", "m", ""))
    _, table = bands(model(CELL, spacing=(10, 0.1), frame=frame), Progress(), levels=(0.0, 17.6, 30.0))
    assert table.units["area"] == "cell²"
    assert table.columns["area"].sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bands(model(np.zeros((3, 3, 3))), Progress()), "take a slice first"),
        (lambda: bands(model(np.zeros((2, 2, 2, 3))[0], vector=True), Progress()), "choose a component"),
        (lambda: bands(interpolate(Samples.from_array(CELL, accuracy=EXACT), law="nearest"), Progress()), "law 'linear'"),
        (lambda: bands(model(CELL), Progress(), interval=-1.0), "interval must be positive"),
        (lambda: bands(model(CELL), Progress(), interval=1e-9), "choose a larger one"),
        (lambda: bands(model(CELL), Progress(), levels=(1.0,)), "two or more"),
        (lambda: bands(model(CELL), Progress(), count=0), "1 to 1000 bands"),
        (lambda: bands(model(CELL), Progress(), tolerance=0.0), "must be positive"),
    ],
)
def test_what_it_cannot_fill_is_told(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]  # a function of no arguments
