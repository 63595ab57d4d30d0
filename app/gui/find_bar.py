"""Find in the network: by title, id or module; Enter goes to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QKeyEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QWidget

from app.gui.glyphs import font

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

WIDTH, HEIGHT = 300, 40


class FindBar(QWidget):
    """A line at the top of the canvas."""

    def __init__(self, canvas: Canvas) -> None:
        super().__init__(canvas)
        self.canvas = canvas
        self.field = QLineEdit(placeholderText="Find in the network")
        self.count = QLabel()
        self.found: list[str] = []
        self.at = 0
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 6, 12, 6)
        row.addWidget(self.field, 1)
        row.addWidget(self.count)
        self.count.setFont(font(11))
        self.field.textChanged.connect(self._look)
        self.setFixedSize(WIDTH, HEIGHT)
        self.hide()

    def place(self) -> None:
        """Stand at the upper right."""
        self.move(max(0, self.canvas.width() - WIDTH - 12), 12)

    def open(self) -> None:
        """Show, with what was looked for last."""
        self.place()
        self.show()
        self.raise_()
        self.field.setFocus()
        self.field.selectAll()
        self._look(self.field.text())

    def _look(self, text: str) -> None:
        typed = text.casefold().strip()
        items = self.canvas.board.nodes
        where = {n: (i.pos().y(), i.pos().x()) for n, i in items.items()}
        said = {n: f"{n}\n{i.title}\n{i.node.module}\n{i.first}".casefold() for n, i in items.items()}
        names = [n for n, text in said.items() if typed and typed in text]
        self.found = sorted(names, key=lambda n: where[n])
        self.at = 0
        self._go()

    def _go(self) -> None:
        if self.found:
            name = self.found[self.at % len(self.found)]
            self.canvas.session.select([name])
            self.canvas.show_node(name)
        said = f"{self.at % len(self.found) + 1} of {len(self.found)}" if self.found else "none"
        self.count.setText(said if self.field.text().strip() else "")

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Enter: the next, with Shift the one before; Esc closes."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.at += -1 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
            self._go()
        elif event.key() == Qt.Key.Key_Escape:
            self.hide()
            self.canvas.setFocus()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """A panel."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.canvas.look["edge"], 1))
        painter.setBrush(self.canvas.look["panel"])
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 6, 6)
