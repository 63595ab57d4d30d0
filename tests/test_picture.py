"""The page: a picture with axes, labels and a legend that is always there; and whether it can be drawn at all."""

import os
import subprocess
import sys
import threading
from typing import Any

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy

from app import opengl
from app.draw import numbers, page, placing
from app.draw.extent import of_layers
from app.draw.meshes import chart_of
from app.draw.panel import fitted
from app.draw.pen import Pen
from app.legend import legend
from app.picture import averaged, render
from app.theme import theme
from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    ChartLook,
    Field,
    Frame,
    Geometry,
    Layer,
    Missing,
    Samples,
    Table,
    bound,
    unknown,
)
from modules.data.scene import Text
from modules.renderers.chart import chart
from modules.renderers.image import image
from modules.renderers.labels import labels
from modules.renderers.lines import lines
from modules.renderers.surface import surface
from modules.renderers.view import view

SIZE = (480, 320)


def field(n: Any = 24, accuracy: Any = None) -> Any:
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    known = accuracy or Accuracy(terms=(bound("Rounding", 0.5, n * n, unit="m"),)).miss(Missing("Survey error"))
    frame = Frame(units=("m", "m", "m"))
    return Samples.from_array(100 * np.exp(-x * x - y * y), spacing=100.0, unit="m", name="height", accuracy=known, frame=frame)


def cross(level: Any = 100.0) -> Any:
    """An upright and a level line through the middle of a square of 2 km."""
    t = np.linspace(0, 2000, 41)
    points = np.concatenate([np.column_stack([t, 0 * t + 1000, 0 * t]), np.column_stack([0 * t + 1000, t, 0 * t])])
    values = {"level": Field(np.array([level, level + 100]), "cell", "m")}
    cells = Cells.of(np.arange(82).reshape(2, 41))
    return Geometry(points=points, lines=cells, values=values, frame=Frame(units=("m", "m", "m")), accuracy=EXACT)


def ground(picture: Any) -> Any:
    return picture.image[2, 2, :3]


def test_a_picture_has_the_size_that_was_asked_for_and_is_opaque() -> None:
    picture = render(view([image(field())]), size=SIZE)
    assert picture.image.shape == (SIZE[1], SIZE[0], 4) and picture.image.dtype == np.uint8
    assert (picture.image[..., 3] == 255).all()
    assert picture.unit == "m"


@pytest.mark.parametrize("name", ["light", "dark"])
def test_the_ground_is_the_theme_s(name: Any) -> None:
    picture = render(view([lines(cross())], theme=name), size=SIZE)
    assert ground(picture) == pytest.approx(np.array(theme(name).rgb("view")) * 255, abs=1)


def test_the_same_scene_gives_the_same_pixels_in_two_threads() -> None:
    scene = view([image(field(), show="relief"), lines(cross()), labels(cross())])
    made = {}
    threads = [threading.Thread(target=lambda i=i: made.update({i: render(scene, size=SIZE)})) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(made[0].image, made[1].image)
    assert made[0].caption == made[1].caption


def test_a_line_stands_where_its_axis_says() -> None:
    bare = render(view([lines(cross(), width=2.0)], axes=False), size=SIZE, scale=1.0).image[..., :3].astype(int)
    dark = bare.sum(axis=2) < 200
    upright = np.flatnonzero(dark[:300, :300].sum(axis=0) > 150)
    level = np.flatnonzero(dark[:300, :300].sum(axis=1) > 150)
    assert len(upright) and len(level)
    # both lines cross in the middle of the plot, which is square
    rows = np.flatnonzero(dark[:, upright[0]])
    columns = np.flatnonzero(dark[level[0]])
    assert abs((rows[0] + rows[-1]) / 2 - level.mean()) <= 1.5
    assert abs((columns[0] + columns[-1]) / 2 - upright.mean()) <= 1.5


def test_half_the_diagonal_of_a_pixel_is_what_drawing_adds() -> None:
    camera = {"position": [0, 0, 1], "focal": [1000, 1000, 0], "up": [0, 1, 0], "height": 1000.0}
    small = render(view([lines(cross())]), size=SIZE, camera=camera)
    large = render(view([lines(cross())]), size=(960, 640), camera=camera)
    assert 0.5 * 1000 / SIZE[1] < small.pixel_unit < 2 * 1000 / SIZE[1]
    assert large.pixel_unit < small.pixel_unit
    assert small.camera["focal"][:2] == [1000, 1000]


def test_the_legend_is_in_every_picture_wherever_it_stands() -> None:
    for place in ("right", "top left", "bottom right"):
        scene = view([image(field(), show="relief")], legend=place)
        known = render(scene, size=SIZE)
        assert [e.sign for e in known.legend.not_drawn] == ["≤", "?"]
        silent = render(view([image(field(accuracy=Accuracy()), show="relief")], legend=place), size=SIZE)
        assert np.abs(known.image.astype(int) - silent.image.astype(int)).sum() > 10_000


def test_a_long_legend_shrinks_until_all_of_it_fits() -> None:
    many = Accuracy(terms=tuple(bound(f"Source number {i} of a long list", 0.1 + i, 576, unit="m") for i in range(14)))
    scene = view([image(field(accuracy=many))])
    pen = Pen((900, 400), theme("light"), 1.0)
    panel = fitted(legend(scene), pen, 280.0, 250.0, on="view", boxed=False)
    assert panel.height <= 250
    assert panel.shrink < 1
    assert len(panel.legend.not_drawn) == 14


def test_pictures_in_space_have_numbers_along_three_edges() -> None:
    corners = np.array([[0, 0, 0], [2000, 0, 0], [2000, 2000, 900], [0, 2000, 0]], float)
    shape = Geometry(points=corners, polygons=Cells.of([[0, 1, 2], [0, 2, 3]]), accuracy=EXACT)
    with_axes = render(view([surface(shape), labels(cross())]), size=SIZE)
    without = render(view([surface(shape)], axes=False), size=SIZE)
    assert (with_axes.image != without.image).any(axis=2).sum() > 300
    assert not with_axes.camera["parallel"]


def test_a_chart_fills_its_page_whatever_its_units() -> None:
    table = Table(columns={"t": np.arange(9.0), "v": 1e-3 * np.arange(9.0) ** 2}, accuracy=unknown("test"))
    chart = Layer(shape=table, look=ChartLook(), title="Growth", accuracy=table.accuracy)
    picture = render(view([chart]), size=SIZE)
    dark = np.argwhere(picture.image[20:260, 60:260, :3].sum(axis=2) < 150)
    assert np.ptp(dark[:, 0]) > 100 and np.ptp(dark[:, 1]) > 80


def _dark_rows(picture: object) -> int:
    image = picture.image[30:240, 70:255, :3]  # type: ignore[attr-defined]  # a picture
    return int(np.ptp(np.argwhere(image.sum(axis=2) < 250)[:, 0]))


def test_a_small_column_over_a_large_one_fills_its_chart() -> None:
    table = Table(columns={"t": 1000.0 * np.arange(9.0), "v": 1e-3 * np.arange(9.0)}, accuracy=unknown("test"))
    picture = render(view([Layer(shape=table, look=ChartLook(), title="", accuracy=table.accuracy)]), size=SIZE)
    assert _dark_rows(picture) > 150


def test_powers_are_straight_on_logarithmic_axes() -> None:
    x = np.geomspace(1, 1e4, 5)
    table = Table(columns={"n": x, "error": x**-2.0}, accuracy=unknown("test"))
    layer = chart(table, x_scale="logarithmic", y_scale="logarithmic")
    points = vtk_to_numpy(chart_of(table, "n", "error", "curve", logs=(True, True)).GetPoints().GetData())
    assert points[:, :2] == pytest.approx(np.column_stack([np.arange(5.0), -2.0 * np.arange(5)]))
    box = of_layers([layer])
    assert (box.low, box.high) == ((0.0, -8.0, 0.0), (4.0, 0.0, 0.0))
    upright = page.axis("error", "m", -8.0, 0.0, 400.0, 70.0, True)
    told = dict(zip(upright.at, upright.words, strict=True))
    assert upright.name == "error (m)"
    assert [told[p] for p in (-8.0, -4.0, 0.0)] == ["10⁻⁸", "10⁻⁴", "10⁰"]
    narrow = page.axis("n", "", 0.0, 1.0, 400.0, 70.0, True)
    assert [w for w in narrow.words if w] == ["1", "2", "5", "10"]
    assert np.diff(narrow.at) == pytest.approx(np.diff(np.log10(np.arange(1, 11))))
    close = page.axis("n", "", np.log10(2.1), np.log10(2.5), 400.0, 70.0, True)
    assert "2.30" in close.words
    assert 10 ** np.array(close.at) == pytest.approx([float(w) for w in close.words])
    assert _dark_rows(render(view([layer]), size=SIZE)) > 150


def test_what_has_no_place_on_a_logarithmic_axis_is_told() -> None:
    table = Table(columns={"n": np.arange(4.0), "error": np.array([1.0, -1.0, 2.0, 4.0])}, accuracy=unknown("test"))
    layer = chart(table, x_scale="logarithmic", y_scale="logarithmic")
    assert layer.title == "Error, 2 of 4 not above 0 and left out"
    assert np.isfinite(of_layers([layer]).bounds).all()
    with pytest.raises(ValueError, match="bars stand on 0"):
        chart(table, kind="bars", y_scale="logarithmic")
    empty = Table(columns={"n": np.arange(4.0), "error": -np.ones(4)}, accuracy=unknown("test"))
    with pytest.raises(ValueError, match="'error' has no number above 0"):
        chart(empty, y_scale="logarithmic")
    with pytest.raises(ValueError, match="cannot be shared"):
        view([layer, chart(table)])


def test_an_empty_scene_is_an_empty_page() -> None:
    assert render(view([]), size=SIZE).caption == ""


def test_a_page_too_small_for_a_legend_is_refused() -> None:
    with pytest.raises(ValueError, match="320 x 240 is the least"):
        render(view([]), size=(100, 100))


def test_averaging_keeps_the_mean() -> None:
    fine = np.zeros((4, 4, 3), np.uint8)
    fine[:2, :2] = [[[255], [0]], [[255], [0]]]
    assert averaged(fine, 2)[..., 0].tolist() == [[128, 0], [0, 0]]


def place(text: Any, **more: Any) -> Any:
    more = {"pad": 2.0, "apart": 0.0, **more}
    return placing.place(text, lambda at: at[:, :2], lambda words: (8.0 * len(words), 10.0), (0, 0, 400, 300), **more)


def test_labels_never_lie_over_one_another() -> None:
    rng = np.random.default_rng(3)
    n = 300
    at = rng.uniform(0, 400, (n, 3))
    along = rng.normal(0, 60, (n, 3))
    text = Text(tuple(f"{i}00" for i in range(n)), tuple(map(tuple, at)), tuple(map(tuple, along)), tuple(np.full(n, 60.0)))
    found = place(text)
    assert len(found) > 20
    for i, one in enumerate(found):
        assert not any(placing.overlap(one.corners(), other.corners()) for other in found[:i])
        low, high = one.corners().min(axis=0), one.corners().max(axis=0)
        assert low.min() >= 0 and high[0] <= 400 and high[1] <= 300


def test_labels_stand_upright_along_their_lines() -> None:
    for degrees in range(0, 360, 15):
        turn = np.radians(degrees)
        text = Text(("500",), ((200.0, 150.0, 0.0),), ((90 * np.cos(turn), 90 * np.sin(turn), 0.0),), (90.0,))
        (label,) = place(text)
        assert -90 < label.angle <= 90
        assert np.cos(np.radians(2 * (label.angle + degrees))) == pytest.approx(1.0)


def test_a_label_without_room_is_left_out_and_equal_ones_keep_their_distance() -> None:
    short = Text(("1000",), ((200.0, 150.0, 0.0),), ((10.0, 0.0, 0.0),), (10.0,))
    assert place(short) == []
    pair = Text(("5", "5", "6"), ((100.0, 99.0, 0.0), (150.0, 99.0, 0.0), (200.0, 99.0, 0.0)))
    assert [label.words for label in place(pair, apart=90.0)] == ["5", "6"]


def test_axes_have_round_numbers_with_their_units() -> None:
    told = page.axis("x", "m", 0.0, 36_180.0, 900.0, 95.0)
    assert (told.name, told.words[:3]) == ("x (km)", ("0", "5", "10"))
    assert told.at[1] == 5000.0
    assert page.axis("depth", "m", -3.0, 1.0, 300.0, 70.0).words == ("−3", "−2", "−1", "0", "1")
    assert numbers.labels([0.0, 0.25, 0.5]) == ["0", "0.25", "0.50"]
    assert numbers.labels([20_000.0, 25_000.0]) == ["20\u2009000", "25\u2009000"]
    assert numbers.decades(0.1, 1000.0) == pytest.approx([0.1, 1.0, 10.0, 100.0, 1000.0])


def test_opengl_is_probed_in_a_process_of_its_own_and_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def run(command: Any, **more: Any) -> Any:
        calls.append(more["env"].get(opengl.VARIABLE))
        works = more["env"].get(opengl.VARIABLE) == opengl.OSMESA
        return subprocess.CompletedProcess(command, 0 if works else -11, f"{opengl.OSMESA}\n" if works else "", "")

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv(opengl.VARIABLE, "")
    monkeypatch.delenv("DISPLAY", raising=False)
    opengl.probe.cache_clear()
    found = opengl.probe()
    assert (found.ok, found.window_class) == (True, opengl.OSMESA)
    assert os.environ[opengl.VARIABLE] == opengl.OSMESA
    assert calls == ["vtkEGLRenderWindow", opengl.OSMESA]
    assert opengl.probe() is found
    opengl.probe.cache_clear()


def test_without_opengl_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    dead = subprocess.CompletedProcess([], -11, "", "")
    monkeypatch.setattr(subprocess, "run", lambda *a, **k: dead)
    monkeypatch.setattr(sys, "platform", "linux")
    opengl.probe.cache_clear()
    found = opengl.probe()
    opengl.probe.cache_clear()
    assert not found.ok
    assert opengl.INSTALL in found.sentence and "signal 11" in found.sentence
