"""Frames round nodes and notes beside them: drawn from the network's extras, so that they are saved and undone."""

from __future__ import annotations

from typing import Any, Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.gui.glyphs import Look, font

TITLE: Final = 26.0
CORNER: Final = 14.0


class MarkItem(QGraphicsItem):
    """A frame (title above, nodes inside) or a note (text)."""

    def __init__(self, kind: str, index: int, mark: dict[str, Any], look: Look) -> None:
        super().__init__()
        self.kind, self.index, self.look = kind, index, look
        self.mark = mark
        x, y, w, h = mark["rect"]
        self.size = (float(w), float(h))
        self.chosen = False
        self.setPos(float(x), float(y))
        self.setZValue(-10 if kind == "frames" else -2)

    @property
    def text(self) -> str:
        """The title of a frame, the text of a note."""
        return str(self.mark.get("title" if self.kind == "frames" else "text", ""))

    @property
    def rect(self) -> QRectF:
        """The body."""
        return QRectF(0, 0, *self.size)

    def scene_rect(self) -> QRectF:
        """The body on the canvas."""
        return self.rect.translated(self.pos())

    def resize(self, width: float, height: float) -> None:
        """Take another size."""
        self.prepareGeometryChange()
        self.size = (max(width, 72.0), max(height, 40.0))

    def record(self) -> dict[str, Any]:
        """As the network keeps it."""
        return {**self.mark, "rect": [self.pos().x(), self.pos().y(), *self.size]}

    def takes(self, place: QPointF) -> bool:
        """Whether a press there is on it: anywhere on a note, title or corner of a frame."""
        local = place - self.pos()
        if not self.rect.contains(local):
            return False
        return self.kind == "notes" or local.y() < TITLE or self.corner(place)

    def corner(self, place: QPointF) -> bool:
        """Whether a place is on the corner that changes its size."""
        local = place - self.pos()
        return QRectF(self.size[0] - CORNER, self.size[1] - CORNER, CORNER, CORNER).contains(local)

    def boundingRect(self) -> QRectF:
        """The body and its border."""
        return self.rect.adjusted(-2, -2, 2, 2)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw it."""
        look, rect = self.look, self.rect
        frame = self.kind == "frames"
        edge = look["action" if self.chosen else ("divider" if frame else "edge")]
        painter.setPen(QPen(edge, 2 if self.chosen else 1))
        ground = QColor(look["panel"])
        ground.setAlphaF(0.6 if frame else 1.0)
        painter.setBrush(ground)
        painter.drawRoundedRect(rect, 8 if frame else 4, 8 if frame else 4)
        detail = option.levelOfDetailFromTransform(painter.worldTransform())
        if detail >= 0.3:
            painter.setFont(font(12, frame))
            painter.setPen(look["text 2"])
            if frame:
                title = QFontMetricsF(font(12, True)).elidedText(self.text, Qt.TextElideMode.ElideRight, rect.width() - 24)
                painter.drawText(QRectF(12, 0, rect.width() - 24, TITLE + 2), Qt.AlignmentFlag.AlignVCenter, title)
            else:
                painter.setPen(look["text" if self.text else "text 3"])
                painter.drawText(rect.adjusted(10, 8, -10, -8), Qt.TextFlag.TextWordWrap, self.text or "Double-click to write")
        painter.setPen(QPen(look["edge"], 1))
        w, h = self.size
        for gap in (4.0, 8.0):
            painter.drawLine(QPointF(w - 3 - gap, h - 3), QPointF(w - 3, h - 3 - gap))
