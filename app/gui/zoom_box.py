"""How large the network is shown, in a corner of the canvas."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from app.gui.glyphs import font

if TYPE_CHECKING:
    from app.gui.canvas import Canvas


class ZoomBox(QWidget):
    """Fit, smaller, the scale (a click shows 100 %), larger."""

    def __init__(self, canvas: Canvas) -> None:
        super().__init__(canvas)
        self.canvas = canvas
        row = QHBoxLayout(self)
        row.setContentsMargins(3, 2, 3, 2)
        row.setSpacing(0)
        row.addWidget(self._button("Fit", "Show the whole network (.)", canvas.fit))
        row.addWidget(self._button("−", "Smaller (Ctrl+−)", lambda: canvas.zoom_by(0.8)))
        self.scale = self._button("100 %", "Show at 100 % (Ctrl+0)", lambda: canvas.set_zoom(1.0))
        self.scale.setFixedWidth(48)
        row.addWidget(self.scale)
        row.addWidget(self._button("+", "Larger (Ctrl++)", lambda: canvas.zoom_by(1.25)))
        canvas.zoomChanged.connect(self._told)
        self.adjustSize()

    def _button(self, words: str, tip: str, act: Callable[[], object]) -> QToolButton:
        button = QToolButton(self)
        button.setText(words)
        button.setToolTip(tip)
        button.setAutoRaise(True)
        button.setFont(font(11))
        button.setStyleSheet("QToolButton { padding: 2px 5px; }")
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        button.clicked.connect(lambda _=False: act())
        return button

    def _told(self, scale: float) -> None:
        self.scale.setText(f"{round(100 * scale)} %")

    def place(self) -> None:
        """Stand at the lower right."""
        size = self.sizeHint()
        self.resize(size)
        self.move(self.canvas.width() - size.width() - 12, self.canvas.height() - size.height() - 12)

    def paintEvent(self, event: QPaintEvent) -> None:
        """A panel."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.canvas.look["divider"], 1))
        painter.setBrush(self.canvas.look["panel"])
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 4, 4)
