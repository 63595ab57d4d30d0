"""Keys of the canvas. The menus of the window have the same; this works wherever the canvas stands alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent

from app.gui import key_wiring
from app.gui.key_wiring import Wiring
from app.gui.layout import SNAP

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

K = Qt.Key
WORDS: Final = (
    ("Alt and arrows", "select the nearest module that way"), ("Arrows", "move what is selected, by a step of the grid"),
    ("Shift and arrows", "move it by four steps"), ("Enter", "go to the settings of the selected module"),
    ("W", "wire it: arrows choose a socket, Enter takes it, arrows choose where it goes, Enter connects"),
    ("Space or Tab", "add a module"), ("Menu key", "what can be done with the selected module"), ("F2", "rename"),
    ("Del", "delete; a gap in a line is closed"), ("L", "arrange"), (".", "see the whole network"),
    ("Z", "zoom to the selection"),
    ("Space and drag", "move the canvas"), ("Ctrl+Shift+D", "duplicate without wires"),
    ("Esc", "put back, select nothing, stop"),
)  # fmt: skip
"""Keys of the canvas, for the page of keys."""
ARROWS = {K.Key_Left: (-1, 0), K.Key_Right: (1, 0), K.Key_Up: (0, -1), K.Key_Down: (0, 1)}


def press(canvas: Canvas, event: QKeyEvent) -> bool:
    """Whether the key was one of the canvas."""
    key = K(event.key())
    canvas.board.show_focus(True)
    if isinstance(canvas.gesture, Wiring):
        return canvas.gesture.key(key)
    ctrl = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
    shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
    if ctrl:
        return _ctrl(canvas, key, shift)
    if key in ARROWS and event.modifiers() & Qt.KeyboardModifier.AltModifier:
        _step(canvas, *ARROWS[key])
        return True
    if key in ARROWS:
        dx, dy = ARROWS[key]
        step = SNAP * (4 if shift else 1)
        if canvas.session.selection:
            canvas.hands.nudge(dx * step, dy * step)
        else:
            canvas.pan(dx * 48, dy * 48)
        return True
    return _plain(canvas, key, event.isAutoRepeat())


def _step(canvas: Canvas, dx: int, dy: int) -> None:
    """Select the nearest node in a direction; the first if none is selected."""
    items = canvas.board.nodes
    chosen = [items[n] for n in canvas.session.selection if n in items]
    if not chosen:
        names = sorted(items, key=lambda n: (items[n].pos().x(), items[n].pos().y()))
        canvas.session.select(names[:1])
        return
    here = chosen[-1].scene_rect().center()
    best: tuple[float, str] | None = None
    for name, item in items.items():
        gap = item.scene_rect().center() - here
        ahead, aside = gap.x() * dx + gap.y() * dy, abs(gap.x() * dy) + abs(gap.y() * dx)
        if ahead > 1 and (best is None or ahead + 2 * aside < best[0]):
            best = (ahead + 2 * aside, name)
    if best is not None:
        canvas.session.select([best[1]])
        canvas.show_node(best[1])


def _ctrl(canvas: Canvas, key: Qt.Key, shift: bool) -> bool:
    hands, session = canvas.hands, canvas.session
    acts: dict[tuple[Qt.Key, bool], Callable[[], object]] = {
        (K.Key_C, False): hands.copy,
        (K.Key_X, False): hands.cut,
        (K.Key_V, False): hands.paste,
        (K.Key_V, True): lambda: hands.paste(True),
        (K.Key_D, False): hands.duplicate,
        (K.Key_D, True): lambda: hands.duplicate(False),
        (K.Key_A, False): lambda: session.select(canvas.board.nodes),
        (K.Key_F, False): canvas.find,
        (K.Key_G, False): hands.frame,
        (K.Key_Z, False): session.undo,
        (K.Key_Z, True): session.redo,
        (K.Key_Y, False): session.redo,
        (K.Key_0, False): lambda: canvas.set_zoom(1.0),
    }
    if key in (K.Key_Plus, K.Key_Equal, K.Key_Minus):
        canvas.zoom_by(1 / 1.25 if key == K.Key_Minus else 1.25)
        return True
    act = acts.get((key, shift))
    if act is not None:
        act()
    return act is not None


def _plain(canvas: Canvas, key: Qt.Key, again: bool) -> bool:
    session, chosen = canvas.session, canvas.session.selection
    acts: dict[Qt.Key, Callable[[], object]] = {
        K.Key_Delete: canvas.hands.remove,
        K.Key_Backspace: canvas.hands.remove,
        K.Key_Escape: lambda: _escape(canvas),
        K.Key_L: canvas.hands.arrange,
        K.Key_Period: canvas.fit,
        K.Key_Z: lambda: canvas.zoom_to(chosen or None),
        K.Key_F2: canvas.rename,
        K.Key_W: lambda: key_wiring.begin(canvas),
        K.Key_F1: lambda: canvas.helpRequested.emit(session.network[chosen[0]].module if chosen else ""),
    }
    if key == K.Key_Space and not again:
        canvas.spaced, canvas.panned = True, False
        canvas.viewport().setCursor(Qt.CursorShape.OpenHandCursor)
    elif key in (K.Key_Return, K.Key_Enter) and chosen:
        canvas.settingsRequested.emit()
    elif key in acts:
        acts[key]()
    return key == K.Key_Space or key in acts or (key in (K.Key_Return, K.Key_Enter) and bool(chosen))


def _escape(canvas: Canvas) -> None:
    """Put back a gesture; else select nothing; else stop."""
    if canvas.gesture is not None:
        canvas.drop_gesture()
    elif canvas.session.selection or canvas.wire is not None:
        canvas.session.select(())
        canvas.choose_wire(None)
    else:
        canvas.session.cancel()


def release(canvas: Canvas, event: QKeyEvent) -> bool:
    """Space let go without a drag asks for a module."""
    if event.key() != K.Key_Space or event.isAutoRepeat() or not canvas.spaced:
        return False
    canvas.spaced = False
    canvas.viewport().unsetCursor()
    if not canvas.panned:
        canvas.quick_add()
    return True
