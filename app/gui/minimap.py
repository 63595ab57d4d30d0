"""The whole network in a corner: click or drag to go there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

WIDTH, HEIGHT = 134, 72


class Minimap(QWidget):
    """Shown while part of the network is out of sight."""

    def __init__(self, canvas: Canvas) -> None:
        super().__init__(canvas)
        self.canvas = canvas
        self.setFixedSize(WIDTH, HEIGHT)
        self.setToolTip("The whole network: drag to go there")
        self.setAccessibleName("Map of the network")
        self.wanted = True

    def place(self) -> None:
        """Stand at the lower left."""
        self.move(12, self.canvas.height() - HEIGHT - 12)

    def show_map(self, wanted: bool) -> None:
        """Show it, or never."""
        self.wanted = wanted
        self.setVisible(wanted)

    def _frame(self) -> tuple[QRectF, float, QPointF]:
        """What is shown, its scale, and where it begins."""
        whole = self.canvas.board.bounds().united(self._seen())
        inner = QRectF(4, 4, WIDTH - 8, HEIGHT - 8)
        scale = min(inner.width() / max(whole.width(), 1), inner.height() / max(whole.height(), 1))
        corner = inner.center() - whole.center() * scale
        return whole, scale, corner

    def _seen(self) -> QRectF:
        return self.canvas.mapToScene(self.canvas.viewport().rect()).boundingRect()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Nodes as rectangles in the colour of their state, and what is seen."""
        look = self.canvas.look
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(look["divider"], 1))
        painter.setBrush(look["panel"])
        painter.drawRoundedRect(QRectF(0.5, 0.5, WIDTH - 1, HEIGHT - 1), 4, 4)
        if not self.canvas.board.nodes:
            return
        _, scale, corner = self._frame()
        roles = {"failed": "failed", "running": "action", "missing": "flag"}
        for item in self.canvas.board.nodes.values():
            at, (w, h) = item.pos() * scale + corner, item.size
            role = "action" if item.chosen else roles.get(item.kind, "edge")
            painter.fillRect(QRectF(at.x(), at.y(), max(2.0, w * scale), max(1.5, h * scale)), look[role])
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(look["text 2"], 1))
        seen = self._seen()
        box = QRectF(seen.topLeft() * scale + corner, seen.size() * scale)
        painter.drawRoundedRect(box.intersected(QRectF(1, 1, WIDTH - 2, HEIGHT - 2)), 2, 2)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Go there."""
        self._go(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Go along."""
        if event.buttons() & Qt.MouseButton.LeftButton:
            self._go(event.position())

    def _go(self, at: QPointF) -> None:
        _, scale, corner = self._frame()
        spot = (at - corner) / scale
        off = self.canvas.mapFromScene(spot) - self.canvas.viewport().rect().center()
        self.canvas.pan(off.x(), off.y())
