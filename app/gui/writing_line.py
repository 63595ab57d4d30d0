"""A line to write in, over the canvas: the title of a node or frame, the text of a note."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit

if TYPE_CHECKING:
    from app.gui.canvas import Canvas


class WritingLine(QLineEdit):
    """Enter or leaving takes the text, Esc does not."""

    def __init__(self, canvas: Canvas) -> None:
        super().__init__(canvas.viewport())
        self.canvas = canvas
        self._take: Callable[[str], None] | None = None
        self.hide()
        self.editingFinished.connect(self._done)

    def open(self, box: QRectF, text: str, take: Callable[[str], None]) -> None:
        """Write over a rectangle of the network."""
        rect = self.canvas.mapFromScene(box).boundingRect()
        rect.setWidth(max(rect.width(), 120))
        rect.setHeight(max(rect.height(), 24))
        self.setGeometry(rect)
        self._take = None
        self.setText(text)
        self._take = take
        self.selectAll()
        self.show()
        self.raise_()
        self.setFocus()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc leaves all as it was."""
        if event.key() == Qt.Key.Key_Escape:
            self._take = None
            self._done()
        else:
            super().keyPressEvent(event)
            event.accept()

    def _done(self) -> None:
        take, self._take = self._take, None
        if not self.isVisible():
            return
        self.hide()
        self.canvas.setFocus()
        if take is not None:
            take(self.text())
