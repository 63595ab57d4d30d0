"""The mapper `contour`, through its public door: lines, their accuracy, and what it refuses."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.api import (
    EXACT,
    Cancelled,
    Frame,
    Geometry,
    Model,
    Progress,
    Samples,
    bound,
    deviation,
)
from modules.mappers.contour import contour, round_step
from modules.modellers.interpolate import interpolate
from modules.progress import Stop

METHODS = ("shoulder", "basic")
CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def model(values: object, **words: object) -> Model:
    words.setdefault("accuracy", EXACT)
    return interpolate(Samples.from_array(np.asarray(values, float), **words))  # type: ignore[arg-type]  # any words


def area(lines: Geometry) -> float:
    (term,) = lines.accuracy.select("area")
    return float(term.size().sum())


def hills(n: int = 40) -> NDArray[np.float64]:
    y, x = np.mgrid[0:n, 0:n] / n
    return np.asarray(np.sin(9 * x) * np.cos(7 * y) + 0.3 * x)


def test_the_thesis_cell() -> None:
    lines = {m: contour(model(CELL), Progress(), levels=(17.6,), method=m) for m in METHODS}  # type: ignore[arg-type]  # the two words
    assert area(lines["basic"]) == pytest.approx(0.050928223 + 0.170748505, rel=1e-8)
    assert area(lines["shoulder"]) == pytest.approx(0.008539327 + 0.021585992, rel=1e-7)
    assert area(lines["shoulder"]) / area(lines["basic"]) == pytest.approx(0.136, abs=5e-4)
    drawn = sorted(p.tolist() for p in lines["shoulder"].points[:, :2])
    assert np.allclose(drawn[1], [0.3633975, 0.2422650], atol=1e-6)
    assert len(lines["shoulder"].polylines()) == 2
    assert [f.values.tolist() for f in (lines["basic"].values["level"],)] == [[17.6, 17.6]]


@pytest.mark.parametrize("method", METHODS)
def test_area_and_distance_are_those_of_an_independent_integration(method: str) -> None:
    """The exact contour of each segment is solved for, column by column, from the model itself."""
    field = model(hills(12), spacing=(2.0, 3.0))
    lines = contour(field, Progress(), levels=(0.2,), method=method)  # type: ignore[arg-type]  # a word
    (area_term,) = lines.accuracy.select("area")
    segments, points = lines.segments(), lines.points
    t = (np.arange(4000) + 0.5) / 4000
    checked = 0
    for (a, b), stated in zip(segments, area_term.size(), strict=True):
        p, q = points[a], points[b]
        if abs(q[0] - p[0]) < 1e-3 or stated < 1e-9:
            continue
        x = p[0] + t * (q[0] - p[0])
        chord = p[1] + t * (q[1] - p[1])
        j, i = int((p[1] + q[1]) / 2 // 3), int((p[0] + q[0]) / 2 // 2)
        f = np.asarray(field.samples.values)[j : j + 2, i : i + 2]
        u = x / 2 - i
        low, high = f[0, 0] + u * (f[0, 1] - f[0, 0]), f[1, 0] + u * (f[1, 1] - f[1, 0])
        exact = 3 * (j + (0.2 - low) / (high - low))
        assert abs(np.mean(exact - chord) * (q[0] - p[0])) == pytest.approx(stated, rel=2e-4, abs=1e-9)
        reach = np.abs(exact - chord).max() * abs(q[0] - p[0]) / np.hypot(*(q - p)[:2])
        name = "Two chords a cell" if method == "shoulder" else "One chord a cell"
        (distance,) = [d for d in lines.accuracy.select("position") if d.name == name]
        assert reach <= distance.size(np.array([a]))[0] * (1 + 1e-9) + 1e-12
        checked += 1
    assert checked > 20


def test_every_point_lies_on_the_level() -> None:
    field = model(hills())
    lines = contour(field, Progress(), interval=0.25)
    values, _ = field.at(lines.points)
    level = np.zeros(len(lines.points))
    for cell, value in enumerate(lines.values["level"].values):
        level[lines.lines.connectivity[lines.lines.offsets[cell] : lines.lines.offsets[cell + 1]]] = value
    assert np.abs(values - level).max() < 1e-12


def test_a_noisy_field_moves_its_lines_by_the_stated_deviation() -> None:
    """Monte Carlo: the crossing of each line with a grid edge, over draws of the noise."""
    sigma, draws = 0.002, 600
    values = hills(20)
    field = model(values, accuracy=EXACT.add(deviation("sensor", sigma, values.size)))
    lines = contour(field, Progress(), levels=(0.3,), method="basic")
    noise = next(t for t in lines.accuracy.select("position") if t.name == "sensor")
    stated = noise.size()
    on_x = np.flatnonzero(np.abs(lines.points[:, 1] - np.round(lines.points[:, 1])) < 1e-9)[:40]
    random = np.random.default_rng(1)
    for p in on_x:
        x, y = lines.points[p, 0], round(float(lines.points[p, 1]))
        i = int(x)
        a = values[y, i] + random.normal(0, sigma, draws)
        b = values[y, i + 1] + random.normal(0, sigma, draws)
        moved = (i + (0.3 - a) / (b - a) - x).std()  # along the edge
        f = values[y, i + 1] - values[y, i]
        up = min(
            abs(np.hypot(f, g))
            for g in (
                (1 - (x - i)) * (values[r + 1, i] - values[r, i]) + (x - i) * (values[r + 1, i + 1] - values[r, i + 1])
                for r in (y - 1, y)
                if 0 <= r < 19
            )
        )
        assert stated[p] == pytest.approx(moved * abs(f) / up, rel=0.15)


def test_accuracy_names_all_that_is_known() -> None:
    accuracy = EXACT.add(bound("rounding", 0.5, 1600, unit="m")).miss()
    field = model(100 * hills(), unit="m", frame=Frame(units=("m", "m", "m")), accuracy=accuracy)
    lines = contour(field, Progress(), interval=20)
    names = {t.name: (t.source.rigour, t.quantity, t.unit, t.place) for t in lines.accuracy.terms}
    assert names == {
        "rounding": ("proven", "position", "m", "point"),
        "Interpolation between samples": ("estimated", "position", "m", "point"),
        "Two chords a cell": ("proven", "position", "m", "point"),
        "Area between line and contour": ("exact", "area", "m²", "segment"),
        "Joining of the lines": ("exact", "position", "m", "point"),
    }
    assert {t.id for t in field.accuracy.terms} <= lines.accuracy.accounted()
    assert lines.accuracy.total(2, "position").max() > 0


def test_axes_of_different_units_are_measured_in_cells() -> None:
    frame = Frame(units=("s", "m", ""))
    lines = contour(model(CELL, spacing=(10, 0.1), frame=frame), Progress(), levels=(17.6,), method="basic")
    assert {t.unit for t in lines.accuracy.select("position")} == {"cell"}
    assert area(lines) == pytest.approx(0.2216767, rel=1e-6)


def test_flat_places_are_flagged_and_never_called_certain() -> None:
    y, x = np.mgrid[-5:6, -5:6] * 1.0
    values = x**2 + y**2  # a basin: at level 0.01 the slope is nearly zero
    lines = contour(model(values, accuracy=EXACT.add(bound("b", 0.5, 121))), Progress(), levels=(0.01, 9.0))
    (kappa,) = [f for f in lines.accuracy.flags if f.name == "kappa"]
    low = np.flatnonzero(np.hypot(*lines.points[:, :2].T) < 1)
    assert set(low) <= set(kappa.items.tolist())  # type: ignore[union-attr]  # it has items


def test_a_saddle_within_the_error_is_flagged() -> None:
    cell = np.pad(CELL, 2, mode="edge")
    wide = EXACT.add(bound("b", 0.2, cell.size))
    lines = contour(model(cell, accuracy=wide), Progress(), levels=(17.6,))
    assert any(f.name == "topology at risk" and "1 cells" in f.words for f in lines.accuracy.flags)
    narrow = EXACT.add(bound("b", 0.001, cell.size))
    sure = model(cell, accuracy=narrow)
    sure = Model(samples=sure.samples, law=sure.law, accuracy=narrow)  # no interpolation error: the bilinear field itself
    assert not any(f.name == "topology at risk" for f in contour(sure, Progress(), levels=(17.6,)).accuracy.flags)


def test_levels_are_multiples_of_a_round_interval() -> None:
    drawn = contour(model(np.linspace(0, 97, 20).reshape(2, 10)), Progress())
    assert sorted(set(drawn.values["level"].values.tolist())) == [10, 20, 30, 40, 50, 60, 70, 80, 90]
    given = contour(model(np.linspace(0, 97, 20).reshape(2, 10)), Progress(), levels=(50.0, 10.0, 50.0))
    assert sorted(set(given.values["level"].values.tolist())) == [10, 50]
    assert [round_step(v) for v in (0.12, 3, 7, 0)] == pytest.approx([0.2, 5, 10, 0])


@pytest.mark.parametrize("values", [np.ones((3, 3)), np.full((3, 3), np.nan)])
def test_nothing_to_draw_is_an_empty_geometry(values: object) -> None:
    empty = contour(model(values), Progress())
    assert empty.counts == {"point": 0, "cell": 0, "segment": 0}
    assert empty.accuracy.total(2, "position").shape == (0,)


def test_holes_leave_holes() -> None:
    values = hills()
    values[10:14, 20:25] = np.nan
    lines = contour(model(values), Progress(), interval=0.2)
    inside = (lines.points[:, 0] > 19.01) & (lines.points[:, 0] < 24.99) & (lines.points[:, 1] > 9.01)
    assert not (inside & (lines.points[:, 1] < 13.99)).any()
    for t in lines.accuracy.terms:
        assert np.isfinite(t.size()).all()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: contour(model(np.zeros((3, 3, 3))), Progress()), "take a slice first"),
        (lambda: contour(model(np.zeros((2, 2, 2, 3))[0], vector=True), Progress()), "choose a component"),
        (lambda: contour(interpolate(Samples.from_array(CELL, accuracy=EXACT), law="nearest"), Progress()), "law 'linear'"),
        (lambda: contour(model(CELL), Progress(), interval=-1.0), "interval must be positive"),
        (lambda: contour(model(CELL), Progress(), interval=1e-9), "choose a larger one"),
    ],
)
def test_what_it_cannot_draw_is_told(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]  # a function of no arguments


def test_cancel_is_heard_within_a_tenth_of_a_second() -> None:
    field = model(np.random.default_rng(0).normal(size=(3000, 3000)))
    contour(model(CELL), Progress())  # compiled
    stop = Stop()
    raised: list[float] = []

    def cancel() -> None:
        raised.append(time.perf_counter())
        stop.set()

    threading.Timer(0.3, cancel).start()
    with pytest.raises(Cancelled):
        contour(field, Progress(stop=stop), levels=tuple(np.linspace(-1, 1, 50).tolist()))
    assert time.perf_counter() - raised[0] < 0.1
