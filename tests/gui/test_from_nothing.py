"""The README's network from nothing, with mouse and keys: built, run, changed, undone, saved, found again, and as headless."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QSettings, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QStyle, QStyleOptionSlider

from app import paths
from app.engine import document, scheduler
from app.engine import paths as files
from app.engine.catalogue import mine
from app.engine.network import Network
from app.gui import style
from app.gui.main_window import MainWindow
from app.gui.session import Session
from app.gui.widgets.number import NumberField
from app.gui.widgets.plain import Options, Segments

README = paths.data("networks") / "jacksboro.json"
LEFT, NONE, CTRL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier
RETURN = Qt.Key.Key_Return


class User:
    """Mouse and keys of one window."""

    def __init__(self, window: MainWindow, qtbot: Any) -> None:
        self.window, self.qtbot, self.session = window, qtbot, window.session

    def types(self, words: str) -> str:
        """In quick-add, which is open; the id of what came of it."""
        popup = self.window.canvas.popup
        assert popup is not None and popup.isVisible()
        QTest.keyClicks(popup.field, words)
        QTest.keyClick(popup.field, RETURN)
        (fresh,) = self.session.selection
        return fresh

    def begins(self, words: str) -> str:
        """Space, and a name."""
        QTest.keyClick(self.window.canvas, Qt.Key.Key_Space)
        return self.types(words)

    def pulls(self, node: str, output: str, words: str, column: int, row: int) -> str:
        """A wire dropped on the empty canvas, and a name."""
        self.sees()
        self._drag(self._socket(node, output, True), self.window.canvas.mapFromScene(232.0 * column, 112.0 * row))
        return self.types(words)

    def connects(self, node: str, output: str, target: str, port: str) -> None:
        """A wire dropped on a port."""
        self.sees()
        self._drag(self._socket(node, output, True), self._socket(target, port, False))

    def sees(self) -> None:
        """All of the network, with room around it."""
        QTest.keyClick(self.window.canvas, Qt.Key.Key_Escape)
        self.window.canvas.zoom_to(None)
        self.window.canvas.zoom_by(0.6)

    def _socket(self, node: str, name: str, out: bool) -> QPoint:
        item = self.window.canvas.board.nodes[node]
        wanted = [p for p in item.plugs if p.name == name and p.out is out]
        return self.window.canvas.mapFromScene(item.where(next((p for p in wanted if p.free), wanted[0])))

    def _drag(self, start: QPoint, end: QPoint) -> None:
        view = self.window.canvas.viewport()
        assert view.rect().contains(start) and view.rect().contains(end)
        QTest.mousePress(view, LEFT, NONE, start)
        for i in range(1, 5):
            QTest.mouseMove(view, start + (end - start) * i / 4)
        QTest.mouseRelease(view, LEFT, NONE, end)

    def chooses(self, node: str) -> None:
        """A click on its title."""
        self.sees()
        canvas = self.window.canvas
        at = canvas.mapFromScene(canvas.board.nodes[node].scenePos() + QPoint(60, 14).toPointF())
        QTest.mouseClick(canvas.viewport(), LEFT, NONE, at)
        assert self.session.selection == (node,)

    def sets(self, node: str, **values: str) -> None:
        """In the panel of a node, by typing or by a click on an option."""
        self.chooses(node)
        for name, text in values.items():
            field = self.window.panel.rows[name].field
            if isinstance(field, Segments):
                QTest.mouseClick(field.buttons[text], LEFT)
            elif isinstance(field, Options):
                QTest.keyClicks(field.list, text)
            else:
                line: Any = getattr(field, "text")  # noqa: B009  each kind of field has its own class
                line.selectAll()
                QTest.keyClicks(line, text)
                QTest.keyClick(line, RETURN)

    def slides(self, node: str, name: str, by: int) -> None:
        """The slider of a number taken by its handle, moved, let go."""
        self.chooses(node)
        field = self.window.panel.rows[name].field
        assert isinstance(field, NumberField)
        slider, option = field.slider, QStyleOptionSlider()
        slider.initStyleOption(option)
        part = QStyle.SubControl.SC_SliderHandle
        start = slider.style().subControlRect(QStyle.ComplexControl.CC_Slider, option, part, slider).center()
        QTest.mousePress(slider, LEFT, NONE, start)
        for i in range(1, 5):
            QTest.mouseMove(slider, start + QPoint(by * i // 4, 0))
        QTest.mouseRelease(slider, LEFT, NONE, start + QPoint(by, 0))

    def presses(self, key: Qt.Key) -> None:
        """A key with Ctrl."""
        self.window.activateWindow()
        self.qtbot.waitUntil(self.window.isActiveWindow, timeout=5000)
        QTest.keyClick(self.window.canvas, key, CTRL)

    def waits(self, view: str) -> None:
        """Until a view is drawn as the network now says."""
        session = self.session
        self.qtbot.waitUntil(lambda: session.outputs(view) is not None and not session.stale(view), timeout=120000)
        self.qtbot.waitUntil(lambda: not session.runs.busy, timeout=60000)
        self.qtbot.waitUntil(lambda: self.window.views.panes[0].back.tag is not None, timeout=60000)


@pytest.fixture
def user(session_of: Callable[..., Session], qtbot: Any, tmp_path: Path) -> Iterator[User]:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    style.choose("dark")
    window = MainWindow(session_of(mine()))
    window.resize(1600, 1100)
    window.show()
    window.commands.new()
    yield User(window, qtbot)
    window.session.history.saved()
    window.close()
    window.deleteLater()


def build(user: User) -> str:
    """Nine modules and eleven wires; the view."""
    read = user.begins("read elevation")
    user.sets(read, path="package:matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz", unit="m")
    model = user.pulls(read, "samples", "interpolate", 2, 0)
    relief = user.pulls(read, "samples", "image", 2, 2)
    contour = user.pulls(model, "model", "contour", 4, 0)
    dust = user.pulls(contour, "lines", "dust cloud", 6, 0)
    labels = user.pulls(contour, "lines", "labels", 6, 1)
    lines = user.pulls(contour, "lines", "lines", 6, 2)
    points = user.pulls(dust, "dust", "points", 8, 0)
    view = user.pulls(relief, "layer", "view", 10, 0)
    for node in (points, lines, labels):
        user.connects(node, "layer", view, "layers")
    user.sets(contour, interval="100")
    user.sets(dust, points="8000", exaggeration="20")
    user.sets(lines, width="0.8", major="5")
    user.sets(relief, show="relief")
    user.sets(view, title="Jacksboro fault, Tennessee")
    return view


def keys(network: Network) -> dict[str, str]:
    """Of all results, by module."""
    found = scheduler.keys(network, mine(), files.identities(network, mine()) or {})
    return {network[name].module: key for name, key in found.items()}


def test_the_network_of_the_readme_from_nothing(
    user: User, nonius: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, file = user.session, tmp_path / "mine.json"
    view = build(user)
    known = keys(document.load(README, mine()))
    assert keys(session.network) == known, "built by hand it is the network of the README"
    user.waits(view)

    contour = next(n for n, node in session.network.nodes.items() if node.module == "mappers.contour.contour")
    step, first = session.history.place, session.runs.key(view)
    user.slides(contour, "interval", 12)
    assert session.network[contour].parameters["interval"] != 100.0
    assert session.history.place == step + 1, "a drag is one step"
    user.waits(view)
    assert session.runs.key(view) != first
    user.presses(Qt.Key.Key_Z)
    assert session.network[contour].parameters["interval"] == 100.0
    user.waits(view)
    assert session.runs.key(view) == first == known["renderers.view.view"]

    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(file), ""))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(file), ""))
    user.presses(Qt.Key.Key_S)
    saved = file.read_bytes()
    user.presses(Qt.Key.Key_N)
    assert not session.network.nodes
    user.presses(Qt.Key.Key_O)
    assert keys(session.network) == known and not session.modified
    user.waits(view)
    user.presses(Qt.Key.Key_S)
    assert file.read_bytes() == saved, "two saves of one network are equal"

    with user.qtbot.waitSignal(user.window.studio.did, timeout=60000, check_params_cb=lambda tag, _: tag[0] == "picture"):
        user.window.commands.write_picture(view, tmp_path / "window.png")
    assert nonius("run", file, "--out", f"{view}={tmp_path / 'alone.png'}").code == 0
    np.testing.assert_array_equal(pixels(tmp_path / "window.png"), pixels(tmp_path / "alone.png"))


def pixels(path: Path) -> Any:
    image = QImage(str(path)).convertToFormat(QImage.Format.Format_RGB32)
    assert not image.isNull()
    return np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), image.width()).copy()
