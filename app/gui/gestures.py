"""What the mouse does between press and release: pan, rubber band, move. Each ends in at most one edit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from PySide6.QtCore import QPoint, QPointF, QRectF, Qt

from app.engine.network import Network, Socket
from app.gui import edits, guides
from app.gui.items import NodeItem
from app.gui.layout import snap
from app.gui.marks import MarkItem

if TYPE_CHECKING:
    from app.gui.canvas import Canvas


class Gesture(Protocol):
    """From press to release."""

    def move(self, at: QPoint) -> None:
        """The pointer is there now."""

    def release(self, at: QPoint) -> None:
        """The button is up: make the edit."""

    def cancel(self) -> None:
        """Put all back."""


class Pan:
    """The canvas follows the hand."""

    def __init__(self, canvas: Canvas, at: QPoint) -> None:
        self.canvas, self.last, self.moved = canvas, at, False
        canvas.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    def move(self, at: QPoint) -> None:
        """Scroll by what the hand moved."""
        step = at - self.last
        if step.manhattanLength():
            self.moved = True
        self.last = at
        self.canvas.pan(-step.x(), -step.y())

    def release(self, at: QPoint) -> None:
        """Let go."""
        self.cancel()

    def cancel(self) -> None:
        """Let go."""
        self.canvas.viewport().unsetCursor()


class Band:
    """A rubber band selects what it touches."""

    def __init__(self, canvas: Canvas, at: QPoint, more: bool) -> None:
        self.canvas, self.start = canvas, canvas.mapToScene(at)
        self.before = tuple(canvas.session.selection) if more else ()
        self.at = at

    def move(self, at: QPoint) -> None:
        """Stretch it."""
        rect = QRectF(self.start, self.canvas.mapToScene(at)).normalized()
        self.canvas.band = rect
        self.canvas.board.select((*self.before, *self._inside(rect)))
        self.canvas.viewport().update()

    def _inside(self, rect: QRectF) -> list[str]:
        return [n for n, item in self.canvas.board.nodes.items() if item.scene_rect().intersects(rect)]

    def release(self, at: QPoint) -> None:
        """Select."""
        rect = self.canvas.band
        self.cancel()
        self.canvas.session.select((*self.before, *(self._inside(rect) if not rect.isNull() else ())))

    def cancel(self) -> None:
        """Take it away."""
        self.canvas.band = QRectF()
        self.canvas.board.select(self.canvas.session.selection)
        self.canvas.viewport().update()


class Move:
    """Nodes, frames and notes follow the hand on the grid; a node without wires may be dropped into a wire."""

    def __init__(self, canvas: Canvas, at: QPoint, nodes: list[NodeItem], marks: list[MarkItem]) -> None:
        self.canvas, self.start = canvas, canvas.mapToScene(at)
        self.nodes = [(n, n.pos()) for n in nodes]
        self.marks = [(m, m.pos()) for m in marks]
        self.moved = False
        self.wire: Socket | None = None
        network = canvas.session.network
        wired = {n for (t, _, _), (s, _) in network.wires.items() for n in (t, s)}
        self.loose = nodes[0].node.id if len(nodes) == 1 and nodes[0].node.id not in wired else ""

    def move(self, at: QPoint) -> None:
        """Move what is held."""
        by = self.canvas.mapToScene(at) - self.start
        if not self.moved and by.manhattanLength() * self.canvas.zoom < 4:
            return
        self.moved = True
        lead = (self.nodes or self.marks)[0][1]
        near = 4 / self.canvas.zoom
        step = QPointF(_step(lead.x(), by.x(), near), _step(lead.y(), by.y(), near))
        if self.nodes:
            step = self._guided(by, step, near)
        for item, place in (*self.nodes, *self.marks):
            item.setPos(place + step)
        self.canvas.board.route(n.node.id for n, _ in self.nodes)
        if self.loose:
            self._look_for_wire(self.nodes[0][0])

    def _guided(self, by: QPointF, step: QPointF, near: float) -> QPointF:
        """Where guides are near, to them; else to the grid."""
        item, place = self.nodes[0]
        held = {n.node.id for n, _ in self.nodes}
        others = [i.scene_rect() for name, i in self.canvas.board.nodes.items() if name not in held]
        rows = [(place.y() + by.y() + mine, y, rect) for mine, y, rect in self.canvas.board.ends(item, held)]
        found = guides.find(item.rect.translated(place + by), others, rows)
        moved = [abs(by.x()) > near, abs(by.y()) > near]
        self.canvas.guides = tuple(line for line in found.lines if moved[line.x1() != line.x2()])
        self.canvas.viewport().update()
        return QPointF(
            by.x() + found.dx if found.dx is not None and moved[0] else step.x(),
            by.y() + found.dy if found.dy is not None and moved[1] else step.y(),
        )

    def _look_for_wire(self, item: NodeItem) -> None:
        found = self.canvas.board.wire_at(item.scene_rect().center())
        end = found.end if found else None
        if end != self.wire:
            session = self.canvas.session
            if end is not None and edits.insert(session.network, self.loose, end, session.catalogue) is None:
                end = None
            for old in (self.wire, end):
                if old is not None and (line := self.canvas.board.lines.get(old)):
                    line.target = old == end
                    line.update()
            self.wire = end

    def release(self, at: QPoint) -> None:
        """One edit, if anything moved."""
        self._unguided()
        if not self.moved:
            return
        session = self.canvas.session
        network: Network = session.network
        if self.wire is not None:
            network = edits.insert(network, self.loose, self.wire, session.catalogue) or network
            self.canvas.board.lines[self.wire].target = False
        places = {n.node.id: (n.pos().x(), n.pos().y()) for n, _ in self.nodes}
        network = network.move(places)
        if self.marks:
            network = self.canvas.hands.kept(network)
        what = "a node" if len(places) == 1 else f"{len(places)} nodes"
        label = "Insert into wire" if self.wire else f"Move {what}" if places else "Move note or frame"
        session.edit(label, network)

    def cancel(self) -> None:
        """Put all back."""
        self._unguided()
        for item, place in (*self.nodes, *self.marks):
            item.setPos(place)
        self.canvas.board.route(n.node.id for n, _ in self.nodes)


    def _unguided(self) -> None:
        if self.canvas.guides:
            self.canvas.guides = ()
            self.canvas.viewport().update()


def _step(start: float, by: float, near: float) -> float:
    """To the grid; nothing along an axis on which the hand hardly moved."""
    return snap(start + by) - start if abs(by) > near else 0.0


class Resize:
    """The corner of a frame or note follows the hand."""

    def __init__(self, canvas: Canvas, mark: MarkItem) -> None:
        self.canvas, self.mark, self.before = canvas, mark, mark.size

    def move(self, at: QPoint) -> None:
        """Stretch it."""
        far = self.canvas.mapToScene(at) - self.mark.pos()
        self.mark.resize(snap(far.x()), snap(far.y()))

    def release(self, at: QPoint) -> None:
        """One edit."""
        if self.mark.size != self.before:
            session = self.canvas.session
            session.edit("Change size", self.canvas.hands.kept(session.network))

    def cancel(self) -> None:
        """Put it back."""
        self.mark.resize(*self.before)
