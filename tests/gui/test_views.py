"""Views side by side: how many, moved together, one range of colours, bookmarks, ways to draw, axes, the legend's room."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QSettings, QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QInputDialog

from app.commands.pictures import Sheet
from app.draw.sight import Sight
from app.gui import bookmarks, cameras, view_menu
from app.gui.picture_dialog import PictureDialog
from app.gui.view_pane import ViewPane
from app.gui.viewport_widget import Views

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def two(drawn: Callable[..., Views], qtbot: Any) -> Views:
    """Two fields in views of the plane, and a third in space."""
    nodes: dict[str, Any] = {
        "low": ("readers.analytic.analytic", {"samples": (9, 9)}),
        "high": ("readers.analytic.analytic", {"samples": (9, 9), "formula": "3*x"}),
        "image-1": ("renderers.image.image", {}), "image-2": ("renderers.image.image", {}),
        "view-1": ("view", {}), "view-2": ("view", {}),
        "model": ("interpolate", {}), "up": ("mappers.elevation.elevation", {}), "surface": ("surface", {}),
        "view-3": ("view", {}),
    }  # fmt: skip
    wires = [
        ("low", "image-1.samples"), ("high", "image-2.samples"), ("image-1", "view-1.layers"), ("image-2", "view-2.layers"),
        ("low", "model.samples"), ("model", "up.model"), ("up", "surface.geometry"), ("surface", "view-3.layers"),
    ]  # fmt: skip
    views = drawn(nodes, wires)
    views.resize(900, 500)
    qtbot.waitUntil(lambda: all(p.back.tag is not None and p.back.camera for p in views.panes if p.node), timeout=60000)
    return views


def pane(views: Views, node: str) -> ViewPane:
    found = views.pane(node)
    assert found is not None
    return found


def legend_of(views: Views, node: str, qtbot: Any) -> Any:
    one = pane(views, node)
    qtbot.waitUntil(lambda: one.legend.legend is not None, timeout=20000)
    return one.legend.legend


def test_as_many_views_as_are_asked_for(two: Views) -> None:
    shown: list[tuple[str, ...]] = [two.shown]
    two.split(1)
    shown.append(two.shown)
    two.session.select(["view-3"])
    shown.append(two.shown)
    assert shown == [("view-1", "view-2", "view-3"), ("view-1",), ("view-3",)]
    two.split(4)
    network = two.session.network.add("view", two.session.catalogue, id="view-4")
    two.session.edit("Add", network)
    assert len(two.panes) == 4
    assert [two.rows[i].count() for i in (0, 1)] == [2, 2]


def settled(views: Views, qtbot: Any) -> None:
    """Wait until no view makes room for its legend any more."""
    seen: list[Any] = []

    def still() -> bool:
        seen.append([dict(pane.back.camera or {}) for pane in views.panes if pane.node])
        return len(seen) > 10 and all(cameras == seen[-1] for cameras in seen[-10:]) and all(seen[-1])

    for name in ("view-1", "view-2", "view-3"):
        legend_of(views, name, qtbot)
    while not still():
        qtbot.wait(50)


def test_linked_views_move_together_live_and_keep_it(two: Views, qtbot: Any) -> None:
    one, other, space = (pane(two, f"view-{n}") for n in (1, 2, 3))
    settled(two, qtbot)
    before, apart = dict(space.back.camera or {}), dict(other.back.camera or {})
    at = one.back.plot.center()
    QTest.mousePress(one.back, LEFT, pos=at)
    QTest.mouseMove(one.back, at + QPoint(20, 0))
    QTest.mouseRelease(one.back, LEFT, pos=at + QPoint(20, 0))
    assert (other.back.camera or {})["focal"] == apart["focal"]
    two.link(True)
    QTest.mousePress(one.back, LEFT, pos=at)
    QTest.mouseMove(one.back, at + QPoint(30, 10))
    focal = (one.back.camera or {})["focal"]
    assert (other.back.camera or {})["focal"] == focal, "it goes along while the mouse is held"
    QTest.mouseRelease(one.back, LEFT, pos=at + QPoint(30, 10))

    def kept() -> bool:
        return bool(two.session.network["view-2"].view.get("camera", {}).get("focal") == pytest.approx(focal))

    qtbot.waitUntil(kept, timeout=5000)
    assert (space.back.camera or {})["position"] == before["position"], "a view in space does not follow one of the plane"
    qtbot.wait(300)
    assert (one.back.camera or {})["focal"] == pytest.approx(focal), "nothing echoes"


def test_one_range_of_colours_for_all_and_the_legend_says_it(two: Views, qtbot: Any) -> None:
    ranges = {n: legend_of(two, n, qtbot).drawn[0].bar for n in ("view-1", "view-2")}
    assert ranges["view-1"].high < ranges["view-2"].high == pytest.approx(3)
    two.share_colours(True)

    def same() -> bool:
        bars = [legend_of(two, n, qtbot).drawn[0].bar for n in ("view-1", "view-2")]
        return bool((bars[0].low, bars[0].high) == (bars[1].low, bars[1].high) == pytest.approx((-3, 3)))

    qtbot.waitUntil(same, timeout=20000)
    untouched: Any = pane(two, "view-1").scene()
    assert untouched.layers[0].look.colouring.range[1] < 2
    two.share_colours(False)
    qtbot.waitUntil(lambda: not same(), timeout=20000)


def test_bookmarks_have_names_are_saved_and_undone(two: Views, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from app.engine import document

    one, session = pane(two, "view-1"), two.session
    start = dict(one.back.camera or {})
    monkeypatch.setattr(QInputDialog, "getText", lambda *_, **__: ("North edge", True))
    one.bookmark()
    one.see(cameras.nearer(start, 4.0))
    assert [name for name, _ in bookmarks.listed(session.network, "view-1")] == ["North edge"]
    two._to_bookmark(0)
    assert one.back.camera is not None and one.back.camera["height"] == pytest.approx(start["height"])
    file = tmp_path / "kept.json"
    session.save(file)
    again = document.load(file, session.catalogue)
    network = getattr(again, "network", again)
    assert bookmarks.listed(network, "view-1")[0][1]["focal"] == pytest.approx(start["focal"])
    assert session.history.undo_label == "Bookmark North edge"
    session.undo()
    assert not bookmarks.listed(session.network, "view-1")
    session.redo()
    one.forget("North edge")
    assert not bookmarks.listed(session.network, "view-1")


def test_what_is_no_bookmark_in_a_file_is_left_out(two: Views) -> None:
    network = two.session.network.look("view-1", bookmarks=[{"name": "x"}, 3, {"camera": {"focal": [0, 0, 0]}}])
    assert bookmarks.listed(network, "view-1") == []
    for n in range(12):
        network = bookmarks.kept(network, "view-1", f"b{n}", dict(pane(two, "view-1").back.camera or {}))
    assert [name for name, _ in bookmarks.listed(network, "view-1")] == [f"b{n}" for n in range(3, 12)]


def test_keys_see_from_axes_and_draw_in_other_ways(two: Views, qtbot: Any) -> None:
    space, session = pane(two, "view-3"), two.session
    QTest.keyClick(space.back, Qt.Key.Key_Z)
    camera = space.back.camera or {}
    assert np.allclose(np.subtract(camera["position"], camera["focal"])[:2], 0, atol=1e-9)
    QTest.keyClick(space.back, Qt.Key.Key_O)
    assert (space.back.camera or {})["parallel"]
    ran = session.runs.key("view-3")
    QTest.keyClick(space.back, Qt.Key.Key_W)
    assert session.network["view-3"].view["drawing"] == "wireframe" and session.runs.key("view-3") == ran

    def actor() -> Any:
        back: Any = space.back
        return back.stage.drawn._drawn[0].props[0].GetProperty()

    qtbot.waitUntil(lambda: actor().GetRepresentation() == 1, timeout=10000)
    session.undo()
    qtbot.waitUntil(lambda: actor().GetRepresentation() == 2, timeout=10000)
    QTest.keyClick(space.back, Qt.Key.Key_E)
    qtbot.waitUntil(lambda: bool(actor().GetEdgeVisibility()), timeout=10000)
    QTest.keyClick(space.back, Qt.Key.Key_A)
    assert "drawing" not in session.network["view-3"].view
    QTest.keyClick(space.back, Qt.Key.Key_N)
    assert space.numbered


def test_the_menu_of_a_view_names_its_keys(two: Views) -> None:
    words = [action.text() for action in view_menu.build(pane(two, "view-3")).actions()]
    assert "From above\tZ" in words and "Wireframe\tW" in words and "Bookmark this view…\tCtrl+Alt+D" in words
    flat = [action.text() for action in view_menu.build(pane(two, "view-1")).actions()]
    assert not any("From above" in text and "\t" in text for text in flat)


def test_a_flat_view_has_axes_that_tell_where_a_pixel_is(two: Views, qtbot: Any) -> None:
    one = pane(two, "view-1")
    plot = one.back.plot
    assert plot.left() > 20 and one.back.height() - plot.bottom() > 20
    space = pane(two, "view-3").back
    assert space.plot.left() == 0 and space.plot.bottom() == space.height() - 1
    image = one.back.grab().toImage()
    ground = image.pixel(2, 2)
    below = [image.pixel(x, plot.bottom() + 12) for x in range(plot.left(), plot.right())]
    assert any(colour != ground for colour in below), "no numbers below the plot"

    def left() -> float:
        return float(Sight(one.back.camera or {}, (plot.width(), plot.height())).place(0.0, plot.height() / 2, 0.0)[0])

    qtbot.waitUntil(lambda: left() <= -1.0, timeout=10000)  # all of the field is seen


def test_the_legend_has_room_of_its_own_and_makes_way_when_dragged(two: Views, qtbot: Any) -> None:
    two.split(1)
    legend_of(two, "view-1", qtbot)
    one = pane(two, "view-1")
    qtbot.waitUntil(lambda: one.legend.x() >= one.back.plot.right(), timeout=5000)
    QTest.mousePress(one.legend, LEFT, pos=QPoint(20, 10))
    QTest.mouseMove(one.legend, QPoint(-200, 40))
    QTest.mouseRelease(one.legend, LEFT, pos=QPoint(20, 10))
    assert one.back.plot.right() > one.back.width() - 60
    two.split(4)
    two.resize(560, 400)
    qtbot.wait(50)
    narrow = pane(two, "view-2")
    legend_of(two, "view-2", qtbot)
    narrow.legend.arrange()
    assert narrow.back.plot.width() > narrow.back.width() * 0.6, "a narrow view is not given to its legend"


def test_only_what_changed_is_drawn_anew(two: Views, qtbot: Any) -> None:
    space, session = pane(two, "view-3"), two.session
    seen: list[Any] = []
    view = space.back.stage.drawn  # type: ignore[union-attr]  # painted
    real = view.show
    view.show = lambda scene: seen.append(real(scene))
    network = session.network.set("surface", "edges", True, session.catalogue)
    session.edit("Set", network)
    qtbot.waitUntil(lambda: bool(seen), timeout=20000)
    assert (seen[-1].fed, seen[-1].made, seen[-1].dressed) == (0, 0, 1)
    seen.clear()
    space.number()
    qtbot.waitUntil(lambda: bool(seen), timeout=20000)
    assert seen[-1].same == 1 and not seen[-1].dressed


# --- the size of a picture


def test_a_picture_of_any_size_is_asked_for_and_remembered(qapp: Any, tmp_path: Path, qtbot: Any) -> None:
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, os.fspath(tmp_path))
    QSettings().remove("picture")
    dialog = PictureDialog(QSize(733, 411))
    qtbot.addWidget(dialog)
    assert dialog.sheet == Sheet((1600, 1000), 1.0, "")
    dialog.sizes.setCurrentIndex(3)
    dialog.sizes.activated.emit(3)
    dialog.colours.setCurrentIndex(2)
    dialog.scale_box.setValue(1.5)
    assert dialog.sheet == Sheet((3508, 2480), 1.5, "dark")
    dialog.width_box.setValue(3000)
    assert dialog.sizes.currentText() == "Another size"
    dialog.accept()
    again = PictureDialog(QSize(100, 100))
    qtbot.addWidget(again)
    assert again.sheet == Sheet((3000, 2480), 1.5, "dark")
    QSettings().remove("picture")


def test_a_small_dark_picture_carries_its_certificate(seen: Views, qtbot: Any, tmp_path: Path) -> None:
    from PIL import Image

    from app.engine import certificate, pngtext
    from app.gui import pictures

    session, target = seen.session, tmp_path / "small.png"
    scene = seen.panes[0].scene()
    assert scene is not None
    sheet = Sheet((640, 420), 1.0, "dark")
    job = lambda: pictures.write(scene, "view", "layer", target, session.network, None, session.catalogue, sheet)  # noqa: E731
    with qtbot.waitSignal(seen.studio.did, timeout=60000) as done:
        seen.studio.do("it", job)
    assert not isinstance(done.args[1], Exception), done.args[1]
    with Image.open(target) as image:
        assert image.size == (640, 420) and np.asarray(image.convert("RGB"))[2, 2].max() < 60
    assert certificate.ACCURACY in pngtext.texts(target.read_bytes()) and certificate.beside(target).exists()
