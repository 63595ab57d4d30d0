"""Which gesture a press begins, what the pointer is over, and the menu of the right button."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QMenu

from app.gui import bends, minis
from app.gui.edits import Held
from app.gui.gestures import Band, Move, Pan, Resize
from app.gui.glyphs import TYPES
from app.gui.items import REACH, NodeItem, Plug
from app.gui.pulling import Pull
from app.gui.wires import WireItem

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

LOOKING = (Pan, Band, minis.Slide)
"""Gestures that an edit does not disturb: they look only, or make edits while they last."""
LEFT, MIDDLE, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton
END = 28.0
"""Pixels at the end of a wire by which it is pulled off."""


def press(canvas: Canvas, event: QMouseEvent) -> None:
    """Begin a gesture."""
    at = event.position().toPoint()
    canvas.setFocus(Qt.FocusReason.MouseFocusReason)
    canvas.drop_gesture()
    if event.button() == MIDDLE or (event.button() == LEFT and canvas.spaced):
        canvas.gesture = Pan(canvas, at)
    elif event.button() == RIGHT:
        menu(canvas, at)
    elif event.button() == LEFT:
        _left(canvas, at, bool(event.modifiers() & (Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier)))


def _left(canvas: Canvas, at: QPoint, more: bool) -> None:
    place, board, session = canvas.mapToScene(at), canvas.board, canvas.session
    if found := board.plug_at(place, max(REACH, REACH / canvas.zoom)):
        canvas.gesture = pull(canvas, at, *found)
        return
    node = next(iter(board.near(place)), None)
    if node is not None:
        _on_node(canvas, at, place, node, more)
        return
    if line := board.wire_at(place):
        session.select(())
        canvas.choose_wire(line.end)
        dot = bends.dot_at(line, place)
        canvas.gesture = _by_end(canvas, at, place, line) if dot is None else bends.Bend(canvas, line, dot)
        return
    mark = board.mark_at(place)
    canvas.choose_wire(None)
    for other in board.marks:
        other.chosen = other is mark
        other.update()
    if mark is None:
        canvas.gesture = Band(canvas, at, more)
    elif mark.corner(place):
        canvas.gesture = Resize(canvas, mark)
    else:
        session.select(())
        inside = [n for n in board.nodes.values() if mark.kind == "frames" and mark.scene_rect().contains(n.scene_rect())]
        notes = [m for m in board.marks if m.kind == "notes" and m is not mark and mark.scene_rect().contains(m.scene_rect())]
        canvas.gesture = Move(canvas, at, inside, [mark, *(notes if mark.kind == "frames" else [])])


def _on_node(canvas: Canvas, at: QPoint, place: QPointF, node: NodeItem, more: bool) -> None:
    session, name = canvas.session, node.node.id
    if node.kind == "running" and node.stop_rect().contains(place):
        session.cancel()
        return
    chosen = tuple(session.selection)
    if more:
        session.select([n for n in chosen if n != name] if name in chosen else [*chosen, name])
    elif name not in chosen:
        session.select([name])
    canvas.choose_wire(None)
    if not more and (mini := node.mini_at(place)) is not None and canvas.zoom >= 0.6:
        canvas.gesture = minis.press(canvas, node, mini, at)
        return
    held = [canvas.board.nodes[n] for n in session.selection if n in canvas.board.nodes]
    if node in held:
        held.sort(key=lambda i: i is not node)
        canvas.gesture = Move(canvas, at, held, [])


def pull(canvas: Canvas, at: QPoint, item: NodeItem, plug: Plug) -> Pull | None:
    """A new wire from a socket, or the one that ends there pulled off."""
    end = (item.node.id, plug.name, plug.slot)
    network = canvas.session.network
    if not plug.out and end in network.wires:
        source, output = network.wires[end]
        out = canvas.board.nodes[source].plug(output, True)
        if item.record is None and out is None:
            return None
        return Pull(canvas, at, Held(source, output, out.kind if out else plug.kind, True), end)
    if item.record is None:
        canvas.say(f"{item.title} is not installed: its wires are kept as they are")
        return None
    return Pull(canvas, at, Held(item.node.id, plug.name, plug.kind, plug.out, plug.slot))


def _by_end(canvas: Canvas, at: QPoint, place: QPointF, line: WireItem) -> Pull | None:
    gap = line.path.pointAtPercent(1.0) - place
    if (gap.x() ** 2 + gap.y() ** 2) ** 0.5 > END or line.origin[0] not in canvas.board.nodes:
        return None
    return Pull(canvas, at, Held(*line.origin, line.kind, True), line.end)


def move(canvas: Canvas, event: QMouseEvent) -> None:
    """Go on with a gesture, or light what is under the pointer."""
    at = event.position().toPoint()
    if canvas.gesture is not None:
        canvas.gesture.move(at)
        return
    place = canvas.mapToScene(at)
    over = next(iter(canvas.board.near(place)), None)
    for item in canvas.board.nodes.values():
        if item.hovered != (item is over):
            item.hovered = item is over
            item.update()
    plug = canvas.board.plug_at(place, max(REACH, REACH / canvas.zoom))
    stop = over is not None and over.kind == "running" and over.stop_rect().contains(place)
    shape = Qt.CursorShape.CrossCursor if plug else Qt.CursorShape.PointingHandCursor if stop else None
    if canvas.spaced:
        shape = Qt.CursorShape.OpenHandCursor
    if shape is None:
        canvas.viewport().unsetCursor()
    else:
        canvas.viewport().setCursor(shape)


def leave(canvas: Canvas) -> None:
    """The pointer is elsewhere."""
    for item in canvas.board.nodes.values():
        if item.hovered:
            item.hovered = False
            item.update()


def release(canvas: Canvas, event: QMouseEvent) -> None:
    """End a gesture; here alone it may edit."""
    gesture, canvas.gesture = canvas.gesture, None
    if gesture is not None:
        gesture.release(event.position().toPoint())
        if canvas.spaced:
            canvas.panned = True
    canvas.minimap.update()


def double_click(canvas: Canvas, event: QMouseEvent) -> None:
    """Rename a node, write a note, bend a wire, ask for a module on the empty canvas."""
    if event.button() != LEFT:
        return
    canvas.drop_gesture()
    at = event.position().toPoint()
    place = canvas.mapToScene(at)
    node = next(iter(canvas.board.near(place)), None)
    if node is not None:
        canvas.session.select([node.node.id])
        if (mini := node.mini_at(place)) is None:
            canvas.rename()
        elif mini.slides:
            minis.write(canvas, node, mini)
    elif mark := canvas.board.mark_at(place):
        canvas.write(mark)
    elif line := canvas.board.wire_at(place):
        bends.toggle(canvas, line, place)
    elif canvas.board.plug_at(place) is None:
        canvas.quick_add(at)


def wheel(canvas: Canvas, event: QWheelEvent) -> None:
    """Zoom at the pointer; a touch pad scrolls, with Ctrl it zooms; Shift scrolls across."""
    pixels, turn = event.pixelDelta(), event.angleDelta()
    ctrl = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
    shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
    if not ctrl and not pixels.isNull() and event.phase() != Qt.ScrollPhase.NoScrollPhase:
        canvas.pan(-pixels.x(), -pixels.y())
    elif shift:
        canvas.pan(-(turn.y() or turn.x()), 0)
    else:
        canvas.zoom_by(1.0015 ** turn.y(), event.position())
    event.accept()


def words(canvas: Canvas, at: QPoint) -> str:
    """What is under the pointer, and what one can do with it."""
    place = canvas.mapToScene(at)
    if found := canvas.board.plug_at(place):
        return _of_plug(*found)
    if node := next(iter(canvas.board.near(place)), None):
        if node.kind == "running" and node.stop_rect().contains(place):
            return "Stop (Esc)"
        summary = node.record.summary.split("\n")[0] if node.record else "This module is not installed; its values are kept"
        led = "".join(f"\n{name.replace('_', ' ')} follows {led}" for name, led in sorted(node.node.follows.items()))
        return f"{node.title} · {node.node.id}\n{summary}{led}\nF1 opens its help"
    if (line := canvas.board.wire_at(place)) and line.known is not None:
        said = f"{line.origin[0]}.{line.origin[1]}: {line.known.words()}"
        return f"{said}\nClick shows the budget; a double-click puts a dot to bend it"
    return ""


def _of_plug(item: NodeItem, plug: Plug) -> str:
    kind = TYPES.get(plug.kind, plug.kind)
    if plug.kind == "Accuracy" and plug.out:
        return "What is known of its accuracy: drag to an accuracy mapper"
    port = item.record.port(plug.name) if item.record and not plug.out else None
    more = f"\n{port.words}" if port and port.words else ""
    how = "Drag to connect" if plug.out or plug.name not in item.wired else "Drag to pull the wire off"
    return f"{plug.name} · {kind}{more}\n{how}"


def menu(canvas: Canvas, at: QPoint) -> None:
    """The menu of what is under the pointer."""
    from app.gui import context

    place = canvas.mapToScene(at)
    node = next(iter(canvas.board.near(place)), None)
    line = None if node else canvas.board.wire_at(place)
    if node is not None and node.node.id not in canvas.session.selection:
        canvas.session.select([node.node.id])
    if line is not None:
        canvas.session.select(())
        canvas.choose_wire(line.end)
    shown = QMenu(canvas)
    shown.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    context.fill(shown, canvas, node, line, at)
    shown.popup(canvas.viewport().mapToGlobal(at))
