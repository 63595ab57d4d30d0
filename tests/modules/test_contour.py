"""The mapper `contour`, through its public door: lines, their accuracy, and what it refuses."""

from __future__ import annotations

import threading
import time
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from modules.api import (
    EXACT,
    Cancelled,
    Curvilinear,
    Frame,
    Geometry,
    Model,
    Progress,
    Samples,
    Unstructured,
    bound,
    deviation,
)
from modules.mappers.contour import contour, round_step
from modules.modellers.interpolate import interpolate
from modules.progress import Stop

Method = Literal["shoulder", "basic", "four_triangles", "exact"]
LAWS: tuple[Literal["linear", "cubic"], ...] = ("linear", "cubic")
METHODS: tuple[Method, ...] = ("shoulder", "basic")
CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def model(values: object, **words: object) -> Model:
    words.setdefault("accuracy", EXACT)
    return interpolate(Samples.from_array(np.asarray(values, float), **words))  # type: ignore[arg-type]  # any words


def nearest() -> Model:
    return interpolate(Samples.from_array(CELL, accuracy=EXACT), law="nearest")


def area(lines: Geometry) -> float:
    (term,) = lines.accuracy.select("area")
    return float(term.size().sum())


def hills(n: int = 40) -> NDArray[np.float64]:
    y, x = np.mgrid[0:n, 0:n] / n
    return np.asarray(np.sin(9 * x) * np.cos(7 * y) + 0.3 * x)


def test_the_thesis_cell() -> None:
    lines = {m: contour(model(CELL), Progress(), levels=(17.6,), method=m) for m in METHODS}
    assert area(lines["basic"]) == pytest.approx(0.050928223 + 0.170748505, rel=1e-8)
    assert area(lines["shoulder"]) == pytest.approx(0.008539327 + 0.021585992, rel=1e-7)
    assert area(lines["shoulder"]) / area(lines["basic"]) == pytest.approx(0.136, abs=5e-4)
    drawn = sorted(p.tolist() for p in lines["shoulder"].points[:, :2])
    assert np.allclose(drawn[1], [0.3633975, 0.2422650], atol=1e-6)
    assert len(lines["shoulder"].polylines()) == 2
    assert [f.values.tolist() for f in (lines["basic"].values["level"],)] == [[17.6, 17.6]]


@pytest.mark.parametrize("method", METHODS)
def test_area_and_distance_are_those_of_an_independent_integration(method: Method) -> None:
    """The exact contour of each segment is solved for, column by column, from the model itself."""
    field = model(hills(12), spacing=(2.0, 3.0))
    lines = contour(field, Progress(), levels=(0.2,), method=method)
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
        "Contour longer than its line": ("exact", "length", "m", "segment"),
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
        (lambda: contour(nearest(), Progress()), "choose another in interpolate"),
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


# --- further methods and planes


def test_exact_leaves_a_hundred_thousandth_of_a_cell_beside_each_arc() -> None:
    values = hills(20)
    exact = contour(model(values), Progress(), interval=0.2, method="exact")
    (left,) = exact.accuracy.select("area")
    assert left.size().max() <= 1e-5
    coarse = contour(model(values), Progress(), interval=0.2, method="shoulder", tolerance=1e-3)
    plain = contour(model(values), Progress(), interval=0.2, method="shoulder")
    assert coarse.accuracy.select("area")[0].size().max() <= 1e-3
    assert len(plain.points) <= len(coarse.points) < len(exact.points)
    assert len(exact.polylines()) == len(plain.polylines())


def test_a_tolerance_cures_the_near_degenerate_saddle() -> None:
    """One shoulder point leaves more than four triangles there (corners 1, -1, 1.0001, -1)."""
    cell = model([[1.0, -1.0], [-1.0, 1.0001]])
    left = {
        m: area(contour(cell, Progress(), levels=(0.0,), method=m)) for m in ("basic", "shoulder", "four_triangles", "exact")
    }
    assert left["four_triangles"] < left["shoulder"] < left["basic"]
    assert left["exact"] < 2e-5 < 1e-4 < left["shoulder"]


def test_four_triangles_joins_wrongly_in_the_cell_of_the_thesis_and_says_what_that_costs() -> None:
    wrong = contour(model(CELL), Progress(), levels=(17.6,), method="four_triangles")
    t = (np.arange(600) + 0.5) / 600
    u, v = np.meshgrid(t, t)
    bilinear = 15 + 6 * u + 9 * v - 20 * u * v
    p, q = u - 0.5, v - 0.5
    s = 2 * np.maximum(abs(p), abs(q))
    rim_u, rim_v = 0.5 + p / np.where(s > 0, s, 1), 0.5 + q / np.where(s > 0, s, 1)
    four = (1 - s) * 17.5 + s * (15 + 6 * rim_u + 9 * rim_v - 20 * rim_u * rim_v)  # linear from the middle to the rim
    truth = ((bilinear >= 17.6) != (four >= 17.6)).mean()
    assert area(wrong) == pytest.approx(truth, abs=0.004)
    assert wrong.accuracy.word("area") == "sampled"
    assert wrong.accuracy.word("position") == "estimated"


def test_the_length_of_a_contour_is_that_of_its_arcs() -> None:
    lines = contour(model(CELL), Progress(), levels=(17.6,), method="basic")
    (longer,) = lines.accuracy.select("length")
    t = np.linspace(0, 13 / 30, 200_001)
    y = (2.6 - 6 * t) / (9 - 20 * t)
    arc = np.hypot(np.diff(t), np.diff(y)).sum()
    chord = np.hypot(13 / 30, 2.6 / 9)
    assert longer.size().min() == pytest.approx(arc - chord, rel=1e-6)


def test_a_stretched_grid_is_contoured_as_the_unit_grid_and_mapped() -> None:
    values = hills(15)
    x, y = (np.cumsum(np.random.default_rng(s).uniform(0.5, 2, 15)) for s in (1, 2))
    flat = contour(model(values), Progress(), levels=(0.2,))
    stretched = contour(model(values, axes=[x, y]), Progress(), levels=(0.2,))
    mapped = np.column_stack([np.interp(flat.points[:, 0], np.arange(15), x), np.interp(flat.points[:, 1], np.arange(15), y)])
    assert np.allclose(stretched.points[:, :2], mapped, atol=1e-12)
    assert np.array_equal(stretched.lines.connectivity, flat.lines.connectivity)


def polar(n: int) -> Samples:
    r, a = np.meshgrid(np.linspace(1, 2, n), np.linspace(0, np.pi / 2, 2 * n), indexing="xy")
    nodes = np.stack([r * np.cos(a), r * np.sin(a), 0 * r], axis=-1)
    values = nodes[..., 0] * nodes[..., 1]
    accuracy = EXACT.add(deviation("sensor", 0.01, values.size, unit="K"))
    return Samples(grid=Curvilinear(nodes, frame=Frame(units=("m", "m", "m"))), values=values, unit="K", accuracy=accuracy)


def test_a_bent_lattice_is_contoured_in_its_own_coordinates() -> None:
    """x y = 0.8 on a quarter ring: the lines approach the hyperbola as the lattice is refined."""
    off, left = [], []
    for n in (9, 17, 33):
        lines = contour(interpolate(polar(n)), Progress(), levels=(0.8,))
        off.append(np.abs(lines.points[:, 0] * lines.points[:, 1] - 0.8).max())
        left.append(area(lines))
        radius = np.hypot(*lines.points[:, :2].T)
        assert radius.min() > 0.98
        assert radius.max() <= 2 + 1e-12
    assert off[0] / off[1] > 3
    assert off[1] / off[2] > 3
    assert left[0] > 3 * left[2]
    assert lines.accuracy.word("area") == "estimated"
    sensor = next(t for t in lines.accuracy.select("position") if t.name == "sensor")
    slope = np.hypot(lines.points[:, 0], lines.points[:, 1])  # |grad x y| = |(y, x)|
    assert np.all(sensor.size() <= 0.0105 / slope)
    assert np.median(sensor.size() * slope) > 0.004
    assert {t.unit for t in lines.accuracy.select("position")} == {"m"}


def test_the_area_on_a_bent_lattice_is_that_of_the_image() -> None:
    """A sheared and scaled unit square: the area scales with its determinant."""
    square = Samples.from_array(CELL, accuracy=EXACT)
    nodes = np.array([[[0.0, 0, 0], [3, 0, 0]], [[1, 2, 0], [4, 2, 0]]])
    bent = Samples(grid=Curvilinear(nodes), values=CELL, accuracy=EXACT)
    flat, mapped = (contour(interpolate(s), Progress(), levels=(17.6,), method="basic") for s in (square, bent))
    assert area(mapped) == pytest.approx(6 * area(flat), rel=2e-2)


def test_triangles_are_drawn_exactly() -> None:
    random = np.random.default_rng(0)
    nodes = np.column_stack([random.uniform(0, 1, (80, 2)), np.zeros(80)])
    faces = Delaunay(nodes[:, :2]).simplices.astype(np.int64)
    grid = Unstructured(nodes, np.arange(len(faces) + 1) * 3, faces.ravel(), np.full(len(faces), 5))
    values = 3 * nodes[:, 0] + nodes[:, 1]
    accuracy = EXACT.add(deviation("sensor", 0.1, 80))
    lines = contour(interpolate(Samples(grid=grid, values=values, accuracy=accuracy)), Progress(), levels=(1.5,))
    assert np.allclose(3 * lines.points[:, 0] + lines.points[:, 1], 1.5)
    assert area(lines) == 0.0
    assert lines.accuracy.word("area") == "exact"
    sensor = next(t for t in lines.accuracy.terms if t.name == "sensor")
    assert np.all(sensor.size() <= 0.1 / np.sqrt(10) + 1e-12)
    assert lines.accuracy.rigour() == "unknown"  # nobody knows what lies between the nodes


def test_a_cubic_model_is_sampled_finely_and_says_how_finely() -> None:
    x = np.linspace(0, 3, 13)
    field = np.sin(2 * x)[None, :] * np.cos(x)[:, None]
    samples = Samples.from_array(field, axes=[x, x], accuracy=EXACT)
    lines = {law: contour(interpolate(samples, law=law), Progress(), levels=(0.3,)) for law in LAWS}

    def off(lines: Geometry) -> float:
        inner = lines.points[((lines.points[:, :2] > 0.5) & (lines.points[:, :2] < 2.5)).all(axis=1)]
        return float(np.abs(np.sin(2 * inner[:, 0]) * np.cos(inner[:, 1]) - 0.3).max())

    assert off(lines["cubic"]) < 0.2 * off(lines["linear"])
    piece = next(t for t in lines["cubic"].accuracy.terms if t.name == "Cubic field in bilinear pieces")
    assert piece.size().max() < 0.01
    assert {t.id for t in interpolate(samples, law="cubic").accuracy.terms} != set()


def test_a_saddle_flips_as_often_as_the_flag_says() -> None:
    """Monte Carlo over the noise of the corners of the thesis's cell, padded by cells of its own."""
    sigma = 0.15
    cell = np.pad(CELL, 2, mode="edge")
    lines = contour(model(cell, accuracy=EXACT.add(deviation("s", sigma, cell.size))), Progress(), levels=(17.6,))
    (flag,) = [f for f in lines.accuracy.flags if f.name == "topology at risk"]
    draws = CELL.ravel() - 17.6 + np.random.default_rng(0).normal(0, sigma, (200_000, 4))
    flipped = (draws[:, 0] * draws[:, 3] - draws[:, 1] * draws[:, 2] > 0) != (
        (15 - 17.6) * (10 - 17.6) - (21 - 17.6) * (24 - 17.6) > 0
    )
    assert flag.values is not None
    assert flag.values.max() == pytest.approx(flipped.mean(), abs=0.02)
    assert f"{flag.values.max():.0%}" in flag.words


def test_lines_thinner_than_their_errors_are_flagged() -> None:
    values = hills()
    noisy = model(values, accuracy=EXACT.add(deviation("s", 0.2, values.size)))
    flags = {f.name: f for f in contour(noisy, Progress(), interval=0.25).accuracy.flags}
    assert flags["lines closer than their errors"].count > 100
    quiet = model(values, accuracy=EXACT.add(deviation("s", 1e-4, values.size)))
    assert "lines closer than their errors" not in {f.name for f in contour(quiet, Progress(), interval=0.25).accuracy.flags}
    bump = np.zeros((21, 21))
    bump[10, 10] = 1.0
    thin = model(bump, accuracy=EXACT.add(bound("b", 0.5, bump.size)))
    assert "thinner than the error" in {f.name for f in contour(thin, Progress(), levels=(0.9,)).accuracy.flags}


def test_a_count_of_levels_is_even() -> None:
    drawn = contour(model(np.linspace(0, 10, 20).reshape(2, 10)), Progress(), count=4)
    assert np.allclose(np.unique(drawn.values["level"].values), [2, 4, 6, 8])
    with pytest.raises(ValueError, match="count must be"):
        contour(model(CELL), Progress(), count=0)
    with pytest.raises(ValueError, match="tolerance must be positive"):
        contour(model(CELL), Progress(), tolerance=-1.0)
