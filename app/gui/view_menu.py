"""How a view is seen: from where, with or without perspective, how surfaces are drawn; as a menu and as keys."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu

from app.gui import bookmarks, cameras

if TYPE_CHECKING:
    from app.gui.view_pane import ViewPane

K = Qt.Key
AXES = (
    ("From the east", "+x", K.Key_X, False), ("From the west", "-x", K.Key_X, True), ("From the north", "+y", K.Key_Y, False),
    ("From the south", "-y", K.Key_Y, True), ("From above", "+z", K.Key_Z, False), ("From below", "-z", K.Key_Z, True),
)  # fmt: skip
DRAWN = (
    ("As its renderer says", "as made", K.Key_A), ("Smooth", "smooth", K.Key_S), ("Flat", "flat", K.Key_F),
    ("With edges", "edges", K.Key_E), ("Wireframe", "wireframe", K.Key_W),
)  # fmt: skip


def build(pane: ViewPane) -> QMenu:
    """The menu of the cube."""
    menu = QMenu(pane)
    camera = pane.back.camera
    _entry(menu, "See all", pane.back.fit, "Home")
    if pane.back.flat:
        menu.addAction("A flat view is seen from above: set dimensions to 3 to turn it").setEnabled(False)
    elif camera is not None:
        for words, axis, key, shift in AXES:
            _entry(menu, words, partial(pane.see, cameras.along(camera, axis)), f"{'Shift+' if shift else ''}{key.name[-1]}")
        menu.addSeparator()
        even = bool(camera.get("parallel"))
        _entry(menu, "Without perspective", partial(pane.see, cameras.parallel(camera, not even)), "O", even)
        _entry(menu, "Numbers on the axes", pane.number, "N", pane.numbered)
    menu.addSeparator()
    for words, drawing, key in DRAWN:
        _entry(menu, words, partial(pane.draw_as, drawing), key.name[-1], pane.drawing == drawing)
    menu.addSeparator()
    network = pane.session.network
    for i, (name, there) in enumerate(bookmarks.listed(network, pane.node)):
        _entry(menu, name, partial(pane.see, there), f"Ctrl+{i + 1}")
    _entry(menu, "Bookmark this view…", pane.bookmark, "Ctrl+Alt+D")
    known = bookmarks.listed(network, pane.node)
    if known:
        gone = menu.addMenu("Forget a bookmark")
        for name, _ in known:
            gone.addAction(name, partial(pane.forget, name))
    return menu


def _entry(menu: QMenu, words: str, do: Callable[[], object], keys: str, on: bool | None = None) -> None:
    made = menu.addAction(f"{words}\t{keys}", do)
    if on is not None:
        made.setCheckable(True)
        made.setChecked(on)


def press(pane: ViewPane, event: QKeyEvent) -> bool:
    """Whether the key was one of the view."""
    shift = event.modifiers() == Qt.KeyboardModifier.ShiftModifier
    if event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier and not shift:
        return False
    key, camera = K(event.key()), pane.back.camera
    if key == K.Key_Home:
        pane.back.fit()
        return True
    drawing = next((d for _, d, k in DRAWN if k == key), None)
    if drawing is not None and not shift:
        pane.draw_as(drawing)
        return True
    if camera is None or pane.back.flat:
        return False
    axis = next((a for _, a, k, s in AXES if (k, s) == (key, shift)), None)
    if axis is not None:
        pane.see(cameras.along(camera, axis))
    elif key == K.Key_O:
        pane.see(cameras.parallel(camera, not camera.get("parallel")))
    elif key == K.Key_N:
        pane.number()
    return axis is not None or key in (K.Key_O, K.Key_N)
