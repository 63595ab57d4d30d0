"""The window without a mouse: a network is built, wired, set, helped with and left by keys alone."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QSettings, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMenu, QWidget

from app.engine.catalogue import mine
from app.gui import focus, keys_page, style
from app.gui.actions import ACTIONS
from app.gui.key_wiring import Wiring
from app.gui.main_window import MainWindow
from app.gui.session import Session

K = Qt.Key
ALT = Qt.KeyboardModifier.AltModifier


@pytest.fixture
def window(session_of: Callable[..., Session], qtbot: Any, tmp_path: Path) -> Iterator[MainWindow]:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    style.choose("dark")
    session = session_of(mine())
    session.freeze(True)
    made = MainWindow(session)
    made.resize(1300, 900)
    made.show()
    made.show_work()
    made.activateWindow()
    yield made
    session.history.saved()
    made.close()
    made.deleteLater()


def add(window: MainWindow, name: str) -> str:
    """Space, a name, Enter; the id of what was added."""
    QTest.keyClick(window.canvas, K.Key_Space)
    popup = window.canvas.popup
    assert popup is not None
    QTest.keyClicks(popup.field, name)
    QTest.keyClick(popup.field, K.Key_Return)
    return window.session.selection[0]


def inside(part: QWidget) -> bool:
    """Whether the focus is in a part of the window."""
    now = QApplication.focusWidget()
    return now is not None and (part is now or part.isAncestorOf(now))


def press(window: MainWindow, *pressed: Qt.Key) -> None:
    for key in pressed:
        QTest.keyClick(window.canvas, key)


def test_a_network_is_wired_by_keys(window: MainWindow) -> None:
    session = window.session
    field = add(window, "analytic field")
    model = add(window, "interpolate")
    assert session.network.wires[model, "samples", 0] == (field, "samples"), "what follows is wired"
    session.select(())
    contour = add(window, "contour")
    assert not session.network.incoming.get(contour)
    press(window, K.Key_W)
    wiring = window.canvas.gesture
    assert isinstance(wiring, Wiring) and wiring.plug is not None and wiring.plug.out
    press(window, K.Key_Left, K.Key_Return)
    assert wiring.pull is not None
    assert {(item.node.id, plug.name) for item, plug in wiring.ends} >= {(model, "model")}
    while (wiring.ends[wiring.at][0].node.id, wiring.ends[wiring.at][1].name) != (model, "model"):
        press(window, K.Key_Down)
    press(window, K.Key_Return)
    assert session.network.wires[contour, "model", 0] == (model, "model")
    assert session.history.undo_label == "Connect" and window.canvas.gesture is None
    press(window, K.Key_W, K.Key_Left, K.Key_Delete)
    assert not session.network.incoming.get(contour) and session.history.undo_label == "Disconnect"


def test_a_wire_is_put_back_and_asks_for_modules(window: MainWindow) -> None:
    session, canvas = window.session, window.canvas
    field = add(window, "analytic field")
    before = session.network
    press(window, K.Key_W, K.Key_Return, K.Key_Escape)
    assert session.network is before and canvas.gesture is None and not canvas.bubble.isVisible()
    assert not any(item.verdicts for item in canvas.board.nodes.values())
    press(window, K.Key_W, K.Key_Space)
    popup = canvas.popup
    assert popup is not None and popup.held is not None and popup.held.node == field
    QTest.keyClicks(popup.field, "interp")
    QTest.keyClick(popup.field, K.Key_Return)
    (fresh,) = session.selection
    assert session.network.wires[fresh, "samples", 0] == (field, "samples")


def test_the_ring_is_dashed_after_keys_and_whole_after_the_mouse(window: MainWindow) -> None:
    name = add(window, "analytic field")
    item = window.canvas.board.nodes[name]
    QTest.keyClick(window.canvas, K.Key_Right, ALT)
    assert item.by_keys and item.chosen
    QTest.mouseClick(window.canvas.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(5, 5))
    assert not item.by_keys


def test_enter_goes_to_the_settings_and_the_next_part_is_reached(window: MainWindow, qtbot: Any) -> None:
    add(window, "analytic field")
    press(window, K.Key_Return)
    qtbot.waitUntil(lambda: inside(window.panel), timeout=2000)
    seen = []
    for _ in focus.parts(window):
        window.made["next_part"].trigger()
        seen.append(next(i for i, (part, _) in enumerate(focus.parts(window)) if inside(part)))
    assert sorted(seen) == list(range(len(focus.parts(window))))
    window.made["librarian"].trigger()
    assert QApplication.focusWidget() is window.librarian.field
    window.made["last_part"].trigger()
    assert inside(window.pages)


def test_the_menu_key_opens_the_menu_of_the_selected_node(window: MainWindow) -> None:
    add(window, "analytic field")
    canvas = window.canvas
    event = QContextMenuEvent(QContextMenuEvent.Reason.Keyboard, QPoint(), QPoint())
    QApplication.sendEvent(canvas, event)
    menu = QApplication.activePopupWidget()
    assert isinstance(menu, QMenu) and any(a.text() == "Bypass" for a in menu.actions())
    menu.close()


def test_help_is_of_the_module_or_of_the_keys(window: MainWindow) -> None:
    window.commands("help")
    (page,) = window.findChildren(keys_page.KeysPage)
    words = page.view.toPlainText()
    assert all(a.words.rstrip("…") in words and a.keys in words for a in ACTIONS if a.keys)
    assert "Alt and arrows" in words
    page.close()
