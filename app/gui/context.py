"""The menu of the right button: of a node, of a wire, of the canvas."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu

from app.gui import bends
from app.gui.items import NodeItem
from app.gui.wires import WireItem

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

ALIGN = {"left": "Left", "right": "Right", "top": "Top", "bottom": "Bottom", "across": "Spread across", "down": "Spread down"}


def _add(
    menu: QMenu, words: str, act: Callable[[], object], key: str = "", *, on: bool = True, ticked: bool | None = None
) -> QAction:
    action = menu.addAction(words)
    action.triggered.connect(lambda _=False: act())
    if key:
        action.setShortcut(QKeySequence(key))
        action.setShortcutVisibleInContextMenu(True)
    action.setEnabled(on)
    if ticked is not None:
        action.setCheckable(True)
        action.setChecked(ticked)
    return action


def fill(menu: QMenu, canvas: Canvas, node: NodeItem | None, line: WireItem | None, at: QPoint) -> None:
    """Put in what can be done with what is under the pointer."""
    if node is not None:
        _node(menu, canvas, node)
    elif line is not None:
        _add(menu, "Show budget", lambda: canvas.wireSelected.emit(*line.origin))
        _add(menu, "Add or remove a dot", lambda: bends.toggle(canvas, line, canvas.mapToScene(at)))
        _add(menu, "Disconnect", lambda: canvas.hands.disconnect(line.end), "Del")
    else:
        _canvas(menu, canvas, at)


def _node(menu: QMenu, canvas: Canvas, node: NodeItem) -> None:
    session, hands, name = canvas.session, canvas.hands, node.node.id
    here = node.record is not None
    _add(menu, "Fire", lambda: session.fire(name), on=here)
    _add(menu, "Run to here", lambda: session.run_to(name), on=here)
    _add(menu, "Hold", lambda: session.hold(name), on=here, ticked=bool(node.node.view.get("held")))
    _add(menu, "Disable", lambda: session.disable(name), "Ctrl+E", ticked=node.node.disabled)
    _add(menu, "Bypass", lambda: hands.bypass(name), "Ctrl+Shift+E", on=here, ticked=bool(node.node.bypass))
    menu.addSeparator()
    _add(menu, "Panel in a window", lambda: canvas.panelRequested.emit(name), "Ctrl+Alt+P")
    _add(menu, "Replace with…", lambda: canvas.replace(name), "Ctrl+R")
    _add(menu, "Rename", canvas.rename, "F2")
    _add(menu, "Cut", hands.cut, "Ctrl+X")
    _add(menu, "Copy", hands.copy, "Ctrl+C")
    _add(menu, "Duplicate", hands.duplicate, "Ctrl+D")
    _add(menu, "Delete", hands.remove, "Del")
    menu.addSeparator()
    several = len(session.selection) > 1
    align = menu.addMenu("Align")
    align.setEnabled(several)
    for how, words in ALIGN.items():
        _add(align, words, lambda h=how: hands.align(h), on=several)  # type: ignore[misc]
    _add(menu, "Lay out", hands.arrange, "L", on=several)
    _add(menu, "Frame", hands.frame, "Ctrl+G")
    menu.addSeparator()
    _add(menu, "Help", lambda: canvas.helpRequested.emit(node.node.module), "F1", on=here)


def _canvas(menu: QMenu, canvas: Canvas, at: QPoint) -> None:
    hands = canvas.hands
    place = canvas.mapToScene(at)
    some = bool(canvas.board.nodes)
    _add(menu, "Add module", lambda: canvas.quick_add(at), "Space")
    _add(menu, "Add note", lambda: hands.note(place))
    _add(menu, "Paste", hands.paste, "Ctrl+V")
    _add(menu, "Paste with incoming wires", lambda: hands.paste(True), "Ctrl+Shift+V")
    menu.addSeparator()
    _add(menu, "Select all", lambda: canvas.session.select(canvas.board.nodes), "Ctrl+A", on=some)
    _add(menu, "Find", canvas.find, "Ctrl+F", on=some)
    _add(menu, "Lay out", hands.arrange, "L", on=some)
    _add(menu, "Fit", canvas.fit, ".", on=some)
