"""A wire by keys: choose a socket of the selected node, then one that it fits; Enter connects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.gui import mouse
from app.gui.glyphs import TYPES, Look
from app.gui.items import NodeItem, Plug
from app.gui.pulling import Pull

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

K = Qt.Key
NEXT = {K.Key_Down: 1, K.Key_Up: -1}
AROUND = {K.Key_Right: 1, K.Key_Down: 1, K.Key_Left: -1, K.Key_Up: -1}
RADIUS = 12.0


class Ring(QGraphicsItem):
    """The dashed ring round the socket that has the focus."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.look = look
        self.setZValue(5)

    def boundingRect(self) -> QRectF:
        """Round its place."""
        return QRectF(-RADIUS - 2, -RADIUS - 2, 2 * RADIUS + 4, 2 * RADIUS + 4)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw it."""
        pen = QPen(self.look["action"], 2)
        pen.setDashPattern([2, 1.5])
        painter.setPen(pen)
        painter.drawEllipse(QPointF(), RADIUS, RADIUS)


class Wiring:
    """The gesture of a wire without a mouse.

    Arrows go from socket to socket, Enter takes one and then connects, Del pulls a wire off, Space asks for a module that
    fits, Esc puts all back.
    """

    def __init__(self, canvas: Canvas, item: NodeItem) -> None:
        self.canvas, self.item = canvas, item
        self.pull: Pull | None = None
        self.ends: list[tuple[NodeItem, Plug]] = []
        self.at = 0
        self.ring = Ring(canvas.look)
        canvas.board.addItem(self.ring)
        item.show_settings(False)
        outs = [p for p in item.plugs if p.out]
        self.plug = next((p for p in outs if p.kind != "Accuracy"), item.plugs[0] if item.plugs else None)
        canvas.show_node(item.node.id)
        self._show()

    # --- the keys

    def key(self, key: Qt.Key) -> bool:
        """Whether the key was one of the wire."""
        if key == K.Key_Escape:
            self.canvas.drop_gesture()
        elif key in (K.Key_Return, K.Key_Enter):
            self._take()
        elif key == K.Key_Space:
            self._ask()
        elif self.pull is None and key in (K.Key_Delete, K.Key_Backspace):
            self._off()
        elif self.pull is not None and key in AROUND:
            self.at = (self.at + AROUND[key]) % max(1, len(self.ends))
            self._aim()
        elif self.pull is None and key in NEXT:
            self._next(NEXT[key])
        elif self.pull is None and key in AROUND:
            self._side(key == K.Key_Right)
        else:
            return False
        return True

    def _next(self, step: int) -> None:
        same = [p for p in self.item.plugs if self.plug and p.out is self.plug.out]
        if self.plug in same:
            self.plug = same[(same.index(self.plug) + step) % len(same)]
        self._show()

    def _side(self, out: bool) -> None:
        there = [p for p in self.item.plugs if p.out is out]
        if there and self.plug is not None:
            self.plug = min(there, key=lambda p: abs(p.y - self.plug.y))  # type: ignore[union-attr]  # it was looked at above
        self._show()

    def _take(self) -> None:
        """Take the socket in the hand, or connect to the one that is aimed at."""
        if self.pull is not None:
            if self.ends:
                self._end(self._place())
            else:
                self.canvas.drop_gesture()
            return
        if self.plug is None:
            return
        at = self.canvas.mapFromScene(self.item.where(self.plug))
        self.pull = mouse.pull(self.canvas, at, self.item, self.plug)
        if self.pull is None:
            return
        self.ends = self._fitting(self.pull)
        self.at = 0
        if self.ends:
            self._aim()
        else:
            self.canvas.bubble.say("Nothing here fits this socket", "Space adds a module that does; Esc puts it back.", at)

    def _fitting(self, pull: Pull) -> list[tuple[NodeItem, Plug]]:
        """Sockets that fit, free ones first and the nearest of them; those that need a module between last."""
        start = pull.canvas.board.nodes[pull.held.node].scene_rect().center()
        found: list[tuple[bool, bool, float, str, float, NodeItem, Plug]] = []
        for name, item in self.canvas.board.nodes.items():
            if name == pull.held.node:
                continue
            item.show_settings(pull.held.kind == "Value" and pull.held.out)
            item.verdicts = pull.fitting.verdicts(name)
            item.update()
            for plug in item.plugs:
                verdict = item.verdicts.get((plug.name, plug.out))
                if verdict and plug.out is not pull.held.out and (verdict.fits or verdict.converters):
                    gap = item.where(plug) - start
                    far = (gap.x() ** 2 + gap.y() ** 2) ** 0.5
                    taken = not plug.out and plug.name in item.wired and not plug.free
                    found.append((not verdict.fits, taken, far, name, plug.y, item, plug))
        return [one[5:] for one in sorted(found, key=lambda f: f[:5])]

    def _place(self) -> QPoint:
        item, plug = self.ends[self.at]
        return self.canvas.mapFromScene(item.where(plug))

    def _aim(self) -> None:
        if not self.ends or self.pull is None:
            return
        item, plug = self.ends[self.at]
        self.canvas.show_node(item.node.id)
        self.ring.setPos(item.where(plug))
        self.pull.moved = True
        self.pull.move(self._place())
        self.canvas.said.emit(f"{item.node.id}.{plug.name}, {self.at + 1} of {len(self.ends)}: Enter connects")

    def _off(self) -> None:
        """Pull off the wire that ends at the socket."""
        if self.plug is not None and not self.plug.out:
            end = (self.item.node.id, self.plug.name, self.plug.slot)
            if end in self.canvas.session.network.wires:
                self.canvas.drop_gesture()
                self.canvas.hands.disconnect(end)

    def _ask(self) -> None:
        """Ask for a module that fits, as a wire dropped on the empty canvas does."""
        if self.pull is None:
            self._take()
        if self.pull is not None:
            held, at = self.pull.held, self.canvas.mapFromScene(self.item.scene_rect().topRight() + QPointF(76, 44))
            self.canvas.drop_gesture()
            self.canvas.quick_add(at, held)

    def _show(self) -> None:
        plug = self.plug
        if plug is None:
            self.canvas.say(f"{self.item.title} has no sockets")
            return
        place = self.item.where(plug)
        self.ring.setPos(place)
        kind = TYPES.get(plug.kind, plug.kind)
        wired = not plug.out and plug.name in self.item.wired
        how = "Enter takes its wire, Del pulls it off" if wired else "Enter begins a wire, Space adds a module that fits"
        self.canvas.bubble.say(f"{plug.name.replace(':', ' ')} · {kind}", f"{how}; arrows choose, Esc leaves.",
                               self.canvas.mapFromScene(place))  # fmt: skip
        self.canvas.said.emit(f"{self.item.node.id}.{plug.name}, {kind}: {how}")

    def _end(self, at: QPoint) -> None:
        pull, self.pull = self.pull, None
        self.canvas.drop_gesture()
        if pull is not None:
            pull.release(at)

    # --- a gesture

    def move(self, at: QPoint) -> None:
        """The mouse says nothing here."""

    def release(self, at: QPoint) -> None:
        """Nor does its button."""

    def cancel(self) -> None:
        """Put all back."""
        self.canvas.bubble.hush()
        if self.ring.scene() is not None:
            self.canvas.board.removeItem(self.ring)
        if self.pull is not None:
            pull, self.pull = self.pull, None
            pull.cancel()


def begin(canvas: Canvas) -> None:
    """Begin a wire at the selected node."""
    chosen = [canvas.board.nodes[n] for n in canvas.session.selection if n in canvas.board.nodes]
    if not chosen:
        canvas.say("Select a module first: Alt and an arrow choose one")
        return
    canvas.drop_gesture()
    canvas.gesture = Wiring(canvas, chosen[0])
