"""The states of the window that a person meets, each brought about with mouse and keyboard, and pictures of them.

    python tests/gui/showcase.py [FOLDER] [STATE ...]     writes window-STATE-dark.png and window-STATE-light.png

`STATES` is also what the tests run over, off screen and on a display.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from PySide6.QtCore import QEvent, QPoint, QPointF, QRect, QSettings, Qt
from PySide6.QtGui import QImage, QMouseEvent, QPainter
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from app.engine import document
from app.engine.catalogue import mine
from app.engine.results import Results
from app.gui import style
from app.gui.main_window import MainWindow
from app.gui.recovery import Lost
from app.gui.session import Session

ROOT = Path(__file__).parents[2]
NETWORK = ROOT / "networks" / "jacksboro.json"
SIZE = (1600, 1000)
RESULTS = Results()
"""Shared, so that the network runs once."""

LEFT, NONE = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier


def until(holds: Callable[[], bool], seconds: float = 120.0) -> None:
    """Let the event loop run until something holds."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError(f"not so within {seconds:g} s")
        QTest.qWait(10)


def shown(window: MainWindow) -> None:
    """Wait until every view has drawn what its node gives."""
    session = window.session
    until(lambda: bool(session.views()) and all(session.outputs(v) and not session.stale(v) for v in session.views()))
    until(lambda: not session.runs.busy)
    until(lambda: all(pane.back.tag is not None for pane in window.views.panes if pane.node))
    QTest.qWait(600)


def opened(window: MainWindow, network: Path = NETWORK) -> None:
    """A network opened as a person does, and run."""
    window.commands.open_path(network)
    shown(window)


def first(window: MainWindow) -> None:
    """The page that a new user sees."""
    QTest.qWait(300)


def network(window: MainWindow) -> None:
    """A network that has run, its contour chosen, so that the panel shows its parameters."""
    opened(window)
    window.session.select(["contour"])
    QTest.qWait(600)


def quick_add(window: MainWindow) -> None:
    """Space on the canvas, and a word typed."""
    opened(window)
    window.canvas.setFocus()
    QTest.mouseMove(window.canvas.viewport(), QPoint(330, 60))
    QTest.keyClick(window.canvas, Qt.Key.Key_Space)
    popup = window.canvas.popup
    assert popup is not None
    QTest.keyClicks(popup.field, "error")
    QTest.qWait(300)


def wire(window: MainWindow) -> None:
    """A wire in the hand: what fits grows, the rest fades."""
    opened(window)
    window.canvas.set_zoom(0.9)
    item = window.canvas.board.nodes["model"]
    plug = item.plug("model", True)
    assert plug is not None
    window.canvas.centerOn(item.where(plug) + QPointF(120, 40))
    start = window.canvas.mapFromScene(item.where(plug))
    view = window.canvas.viewport()
    QTest.mousePress(view, LEFT, NONE, start)
    for i in range(1, 9):
        at = QPointF(start + QPoint(14 * i, 9 * i))
        move = QMouseEvent(QEvent.Type.MouseMove, at, QPointF(view.mapToGlobal(at.toPoint())), LEFT, LEFT, NONE)
        QApplication.sendEvent(view, move)
        QTest.qWait(15)
    QTest.qWait(200)


def error(window: MainWindow) -> None:
    """A module that failed: the sentence on its node, the panel with what it was given."""
    opened(window)
    session = window.session
    session.edit("Set interval", session.network.set("contour", "interval", 1e-6, session.catalogue))
    until(lambda: session.state("contour").kind == "failed")
    session.select(["contour"])
    QTest.qWait(600)


def budget(window: MainWindow) -> None:
    """The budget of the contour lines: each source, its share and its sign."""
    opened(window)
    window.session.select(["contour"])
    window.commands.budget()
    QTest.qWait(1500)


def overview(window: MainWindow) -> None:
    """Where the error of a picture comes from, over the whole network."""
    opened(window)
    window.commands.overview()
    QTest.qWait(2000)


def pick(window: MainWindow) -> None:
    """A place of the picture read: value, and each source of error in words and signs."""
    opened(window)
    pane = window.views.panes[0]
    surface = pane.back.surface
    assert surface is not None
    for step in range(60):  # a line is thin: the nearest place that is drawn
        QTest.mouseClick(surface, LEFT, Qt.KeyboardModifier.ControlModifier, pane.back.plot.center() + QPoint(2 * step, step))
        with suppress(TimeoutError):
            until(lambda: pane.pick.box.readout is not None, 0.5)
            break
    assert pane.pick.box.readout is not None
    QTest.qWait(300)


def comparison(window: MainWindow) -> None:
    """Three views of one network, side by side."""
    opened(window, ROOT / "networks" / "thesis-2-07.json")
    QTest.qWait(600)


def palette(window: MainWindow) -> None:
    """Every action by its words."""
    opened(window)
    window.commands.palette()
    QTest.qWait(300)


def lost() -> list[Lost]:
    """A document that a killed process left."""
    text = document.dumps(document.load(NETWORK, mine()), mine())
    return [Lost(Path(tempfile.gettempdir()) / "none.log", Path("slopes-of-my-valley.json"), text, 7, time.time() - 95)]


def recovery(window: MainWindow) -> None:
    """After a process was killed: restore, restore frozen, or discard."""
    QTest.qWait(300)


STATES: dict[str, Callable[[MainWindow], None]] = {
    state.__name__.replace("_", "-"): state
    for state in (first, network, quick_add, wire, error, budget, overview, pick, comparison, palette, recovery)
}


def make(state: str, theme: str) -> MainWindow:
    """The window in a state."""
    style.choose(theme)
    window = MainWindow(Session(mine(), results=RESULTS), lost() if state == "recovery" else None)
    window.resize(*SIZE)
    window.show()
    QTest.qWait(100)
    STATES[state](window)
    return window


def picture(window: MainWindow) -> QImage:
    """The window with its popups and dialogs where they stand."""
    image = window.grab().toImage()
    painter = QPainter(image)
    corner = window.mapToGlobal(QPoint(0, 0))
    for other in QApplication.topLevelWidgets():
        if other is not window and other.isVisible() and isinstance(other, QWidget):
            place = QRect(other.mapToGlobal(QPoint(0, 0)) - corner, other.size())
            painter.drawImage(place.topLeft(), other.grab().toImage())
    painter.end()
    return image


def close(window: MainWindow) -> None:
    """Let it go without a question."""
    window.session.history.saved()
    for other in QApplication.topLevelWidgets():
        if other is not window:
            with suppress(RuntimeError):
                other.close()
    window.shut()
    window.close()
    window.deleteLater()
    QTest.qWait(20)


def main(words: list[str]) -> int:
    """Write the pictures."""
    folder = Path(words[0]) if words else ROOT / "resources" / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as state:
        os.environ["NONIUS_STATE"] = state
        QSettings.setDefaultFormat(QSettings.Format.IniFormat)
        QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, state)
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
        app = QApplication.instance() or QApplication([])
        assert isinstance(app, QApplication)
        for name in words[1:] or STATES:
            for theme in ("dark", "light"):
                window = make(name, theme)
                file = folder / f"window-{name}-{theme}.png"
                picture(window).save(str(file))
                close(window)
                print(file)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
