"""A word beside the pointer: why a wire does not fit here, and what to do."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRect, QRectF, QSize, Qt, QTimer
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.gui.glyphs import Look, font

AFTER = 150
"""Milliseconds before it appears."""


class Bubble(QWidget):
    """One strong line and one quiet, 12 px from the pointer."""

    def __init__(self, parent: QWidget, look: Look) -> None:
        super().__init__(parent)
        self.ground = parent
        self.look, self.title, self.text = look, "", ""
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()
        self._timer = QTimer(self, singleShot=True, interval=AFTER)
        self._timer.timeout.connect(self.show)

    def say(self, title: str, text: str, at: QPoint) -> None:
        """Say something beside a place; the same again only moves."""
        if not title:
            self.hush()
            return
        if (title, text) != (self.title, self.text):
            self.title, self.text = title, text
            self.hide()
            self._timer.start()
            self.resize(self._size())
        wide, high = self.ground.width(), self.ground.height()
        x, y = at.x() + 12, at.y() + 12
        x = x if x + self.width() < wide else max(4, at.x() - 12 - self.width())
        y = y if y + self.height() < high else max(4, at.y() - 12 - self.height())
        self.move(x, y)
        self.raise_()
        self.update()

    def hush(self) -> None:
        """Say nothing."""
        self._timer.stop()
        self.title = self.text = ""
        self.hide()

    def _size(self) -> QSize:
        flags = int(Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignLeft)
        room = QRect(0, 0, 300, 400)
        strong = QFontMetrics(font(11, True)).boundingRect(room, flags, self.title)
        quiet = QFontMetrics(font(11)).boundingRect(room, flags, self.text) if self.text else QRect()
        gap = 3 if self.text else 0
        return QSize(max(strong.width(), quiet.width()) + 24, strong.height() + quiet.height() + gap + 15)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw it."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.look["edge"], 1))
        painter.setBrush(self.look["head"])
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 4, 4)
        painter.setPen(self.look["text"])
        painter.setFont(font(11, True))
        inner = self.rect().adjusted(10, 7, -10, -7)
        flags = int(Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignLeft)
        painter.drawText(inner, flags, self.title)
        painter.setPen(self.look["text 2"])
        painter.setFont(font(11))
        high = QFontMetrics(font(11, True)).boundingRect(QRect(0, 0, inner.width(), 400), flags, self.title).height()
        painter.drawText(inner.adjusted(0, high + 3, 0, 0), flags, self.text)
