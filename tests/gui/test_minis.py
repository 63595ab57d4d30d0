"""Parameters on the node, in windows of their own, with units and ends that can be set."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu

from app.engine import following
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError
from app.gui import folders, minis, motion, mouse, style
from app.gui.main_window import MainWindow
from app.gui.panel_window import PanelWindow, show
from app.gui.preferences import Preferences
from app.gui.session import Session
from app.gui.widgets.number import NumberField, number_of
from app.gui.widgets.scale import scale_of
from modules.api import EXACT, Range, Samples, Value, modeller, reader
from modules.data.formula import FormulaError
from modules.parameters import Parameter


@reader("Track", output="samples")
def track() -> Samples:
    """Heights along a track.

    Accuracy: exact.
    """
    return Samples.from_array(np.linspace(100.0, 300.0, 5), unit="m", name="height", accuracy=EXACT)


@modeller("Above", output="value", independent={"value": ("samples",)})
def above(
    samples: Samples,
    *,
    level: Annotated[float, Range(of="samples.range")] = 200.0,
    count: Annotated[int, Range(1, 9)] = 3,
    strict: bool = False,
    law: Literal["or more", "more"] = "more",
    name: str = "",
) -> Value:
    """How many heights are above a level.

    Accuracy: exact.
    """
    return Value(value=float((np.asarray(samples.values) > level).sum() + count), accuracy=EXACT)


CATALOGUE = Catalogue.of([track, above])


@pytest.fixture
def window(session_of: Callable[..., Session], qtbot: Any, tmp_path: Path) -> Iterator[MainWindow]:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    QSettings().clear()
    style.choose("dark")
    session = session_of(CATALOGUE)
    made = MainWindow(session)
    made.resize(1200, 800)
    made.show()
    network = session.network.add("track", CATALOGUE, id="track", view={"position": [0.0, 0.0]})
    network = network.add("above", CATALOGUE, id="above", view={"position": [226.0, 0.0]})
    session.edit("Build", network.connect("track", "samples", "above", "samples", CATALOGUE))
    session.select(["above"])
    qtbot.waitUntil(lambda: session.state("above").kind == "clean", timeout=10000)
    made.canvas.set_zoom(1.0)
    made.canvas.centerOn(made.canvas.board.nodes["above"].scene_rect().center())
    yield made
    session.history.saved()
    made.close()
    made.deleteLater()


def pin(window: MainWindow, *names: str) -> None:
    for name in names:
        window.panel.rows[name].pinAsked.emit()


def on_screen(window: MainWindow, place: QPointF) -> QPoint:
    return window.canvas.mapFromScene(window.canvas.board.nodes["above"].pos() + place)


def test_a_pinned_slider_is_dragged_on_the_node_live_and_as_one_step(window: MainWindow) -> None:
    session, item = window.session, window.canvas.board.nodes["above"]
    before = item.size[1]
    pin(window, "level")
    assert item.size[1] == before + minis.HEIGHT and session.history.undo_label == "Show level on above"
    (mini,) = item.minis
    assert mini.scale is not None and (mini.scale.low, mini.scale.high) == (100.0, 300.0)
    view, groove = window.canvas.viewport(), mini.groove
    start = on_screen(window, QPointF(groove.left() + groove.width() * 0.5, groove.center().y()))
    stop = on_screen(window, QPointF(groove.left() + groove.width() * 0.75, groove.center().y()))
    QTest.mousePress(view, Qt.MouseButton.LeftButton, pos=start)
    for x in range(start.x(), stop.x(), 2):
        QTest.mouseMove(view, QPoint(x, start.y()))
    assert session.network["above"].parameters["level"] != 200.0
    QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=stop)
    assert session.network["above"].parameters["level"] == pytest.approx(250.0, abs=3.0)
    session.undo()
    assert session.network["above"].parameters.get("level", 200.0) == 200.0
    assert session.history.undo_label == "Show level on above"
    session.undo()
    assert not item.minis and item.size[1] == before


def test_a_switch_and_a_choice_on_the_node(window: MainWindow) -> None:
    session, item = window.session, window.canvas.board.nodes["above"]
    pin(window, "strict", "law")
    view = window.canvas.viewport()
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=on_screen(window, item.minis[0].rect.center()))
    assert session.network["above"].parameters["strict"] is True and item.minis[0].words == "on"
    assert item.minis[1].words == "more"
    with pytest.raises(NetworkError, match="take one off first"):
        minis.pinned(session.network, "above", "count")
    pin(window, "law")
    assert minis.pins(session.network["above"]) == ("strict",)


def test_the_number_is_typed_on_the_node(window: MainWindow) -> None:
    session, item = window.session, window.canvas.board.nodes["above"]
    pin(window, "count")
    (mini,) = item.minis
    at = on_screen(window, QPointF(mini.rect.right() - 8, mini.rect.center().y()))
    QTest.mouseClick(window.canvas.viewport(), Qt.MouseButton.LeftButton, pos=at)
    line = window.canvas.line
    assert line.isVisible() and line.text() == "3"
    QTest.keyClicks(line, "2*3")
    QTest.keyClick(line, Qt.Key.Key_Return)
    assert session.network["above"].parameters["count"] == 6


def test_pins_are_saved_and_only_what_fits_is_offered(window: MainWindow, tmp_path: Path) -> None:
    pin(window, "level")
    window.session.save(tmp_path / "pinned.json")
    window.session.open(tmp_path / "pinned.json")
    assert minis.pins(window.session.network["above"]) == ("level",)
    assert not minis.can(Parameter("name", str, "")) and minis.can(Parameter("level", float, 1.0))


# --- panels in windows


def test_a_panel_in_a_window_stays_with_its_node(window: MainWindow, qtbot: Any) -> None:
    session = window.session
    window.made["float_panel"].trigger()
    (floating,) = window.findChildren(PanelWindow)
    session.select(["track"])
    assert floating.panel.node == "above" and window.panel.node == "track"
    field = floating.panel.rows["count"].field
    assert isinstance(field, NumberField)
    QTest.keyClicks(field.text, "")
    field.text.selectAll()
    QTest.keyClicks(field.text, "8")
    QTest.keyClick(field.text, Qt.Key.Key_Return)
    assert session.network["above"].parameters["count"] == 8
    assert show(window, "above") is floating
    session.edit("Delete", session.network.remove("above"))
    qtbot.waitUntil(lambda: not floating.isVisible(), timeout=3000)


# --- numbers


@pytest.mark.parametrize(("typed", "unit", "number"), [
    ("3 km", "m", 3000.0), ("1/4 m", "m", 0.25), ("2*pi", "", 6.283185307179586), ("90 deg", "°", 90.0), ("1.5 h", "s", 5400.0),
    ("250 cm", "m", 2.5), ("7", "m", 7.0), ("2 min", "s", 120.0), ("-3 ft", "m", -0.9144), ("12,5 mm", "m", 0.0125),
])  # fmt: skip
def test_a_number_in_another_unit(typed: str, unit: str, number: float) -> None:
    assert number_of(typed, unit) == pytest.approx(number)


@pytest.mark.parametrize(("typed", "unit", "why"), [
    ("3 s", "m", "measure different things"), ("3 km", "", "this number has none"),
    ("much", "m", "is no number"), ("3 foos", "m", "is no number"),
])  # fmt: skip
def test_what_does_not_fit_is_refused(typed: str, unit: str, why: str) -> None:
    with pytest.raises(FormulaError, match=why):
        number_of(typed, unit)


def test_a_level_has_the_unit_of_what_it_is_compared_with(window: MainWindow) -> None:
    field = window.panel.rows["level"].field
    assert isinstance(field, NumberField) and field.unit == "m" and field.text.text().replace("\u00a0", " ") == "200 m"
    field.text.selectAll()
    QTest.keyClicks(field.text, "0.15 km")
    QTest.keyClick(field.text, Qt.Key.Key_Return)
    assert window.session.network["above"].parameters["level"] == 150.0


def test_a_slider_in_powers_is_kept_with_the_node(window: MainWindow) -> None:
    row = window.panel.rows["level"]
    assert isinstance(row.field, NumberField)
    row.field.powersChanged.emit(True)
    assert window.session.network["above"].view["powers"] == {"level": True}
    assert row.field.scale is not None and row.field.scale.log
    assert row.field.slider.value() == pytest.approx(1000 * np.log(2) / np.log(3), abs=1)
    row.field.powersChanged.emit(None)
    assert "powers" not in window.session.network["above"].view and not row.field.scale.log


@pytest.mark.parametrize("log", [True, False])
@pytest.mark.parametrize("kind", [int, float])
def test_a_scale_gives_back_what_it_was_given(kind: type, log: bool) -> None:
    parameter = Parameter("p", kind, None, True, Range(2, 900))
    scale = scale_of(parameter, 30.0, {}, None, log)
    assert scale is not None and (scale.number(0.0), scale.number(1.0)) == (2.0, 900.0)
    for share in (0.1, 0.37, 0.8):
        assert scale.share(scale.number(share)) == pytest.approx(share, abs=0.01 if kind is float else 0.06)


# --- preferences


def test_preferences_are_taken_over(window: MainWindow, tmp_path: Path) -> None:
    asked = Preferences(window)
    asked.motion.setCurrentIndex(asked.motion.findData("reduced"))
    asked.folders["data"].text.setText(str(tmp_path))
    asked.cache.setValue(128)
    asked.accept()
    assert motion.reduced() and folders.start("data") == tmp_path and folders.start("networks") == Path.home()
    assert window.session.runs.results.bound == 128 << 20
    folders.prefer("data", str(tmp_path / "gone"))
    assert folders.preferred("data") is None


# --- one parameter follows another


@pytest.fixture
def two(window: MainWindow) -> MainWindow:
    """Two nodes that count above a level; the first is chosen."""
    session = window.session
    session.edit("Add", session.network.add("above", CATALOGUE, id="also", view={"position": [226.0, 200.0]}))
    session.select(["also"])
    return window


def test_a_parameter_follows_another_and_is_let_go_by_a_click(two: MainWindow, qtbot: Any) -> None:
    session, row = two.session, two.panel.rows["level"]
    menu = QMenu(two)
    assert row.more is not None
    row.more(menu)
    (inner,) = (a.menu() for a in menu.actions() if a.menu() is not None)
    assert isinstance(inner, QMenu)
    first = inner.actions()[0]
    assert first.text().startswith("above.level") and all("strict" not in a.text() for a in inner.actions())
    first.trigger()
    assert session.history.undo_label == "Link level of also to above"
    assert row.link.isVisible() and row.link.text() == "follows above.level" and not row.field.isEnabled()
    session.edit("Set level", session.network.set("above", "level", 150.0, CATALOGUE))
    assert session.network["also"].parameters["level"] == 150.0
    assert isinstance(row.field, NumberField) and row.field.value == 150.0
    session.select(["above"])
    assert "followed by also.level" in two.panel.rows["level"].words.text()
    session.select(["also"])
    QTest.mouseClick(two.panel.rows["level"].link, Qt.MouseButton.LeftButton)
    assert not session.network["also"].follows and two.panel.rows["level"].field.isEnabled()
    session.undo()
    assert session.network["also"].follows == {"level": "above.level"}


def test_a_node_shows_that_it_follows(two: MainWindow) -> None:
    session, canvas = two.session, two.canvas
    plain = canvas.grab().toImage()
    network = following.follow(session.network.look("also", pins=["level"]), "also", "level", ("above", "level"), CATALOGUE)
    session.edit("Link", network)
    (mini,) = canvas.board.nodes["also"].minis
    assert mini.led == "above.level" and not mini.slides
    assert minis.press(canvas, canvas.board.nodes["also"], mini, QPoint()) is None
    assert session.network is network and canvas.grab().toImage() != plain
    at = canvas.mapFromScene(canvas.board.nodes["also"].scenePos() + QPointF(60, 14))
    assert "level follows above.level" in mouse.words(canvas, at)
