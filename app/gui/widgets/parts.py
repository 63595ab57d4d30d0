"""Small parts of panels: heads of sections, lines between them, buttons with an icon."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QToolButton, QWidget

from app.gui import icons, style


class Elided(QLabel):
    """A line of words that ends in dots where there is no room; all of it in its tooltip."""

    def __init__(self, kind: str) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setProperty("kind", kind)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)

    def minimumSizeHint(self) -> QSize:
        """Room for a few letters."""
        return QSize(24, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        """The words, or as many as there is room for."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        shown = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, self.width())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
        self.setToolTip(self.text() if shown != self.text() else "")


def section(words: str, *tools: QToolButton) -> QWidget:
    """The head of a section."""
    made = QWidget()
    row = QHBoxLayout(made)
    row.setContentsMargins(0, 2, 0, 2)
    row.addWidget(style.labelled(words, "section"))
    row.addStretch(1)
    for one in tools:
        row.addWidget(one)
    return made


def line() -> QFrame:
    """Between sections."""
    made = QFrame()
    made.setProperty("kind", "line")
    made.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
    return made


def tool(drawing: str, words: str, do: Callable[[], object]) -> QToolButton:
    """A small button with an icon."""
    made = QToolButton()
    made.setIcon(icons.icon(drawing, "text 2"))
    made.setProperty("drawing", drawing)
    made.setToolTip(words)
    made.setAccessibleName(words)
    made.clicked.connect(lambda: do())
    return made


def button(words: str, do: Callable[[], object], *, primary: bool = False, link: bool = False, tip: str = "") -> QPushButton:
    """A button with words."""
    made = QPushButton(words)
    made.setProperty("primary", primary)
    made.setProperty("link", link)
    made.setToolTip(tip)
    made.clicked.connect(lambda: do())
    return made


def act(words: str, do: Callable[[], object], parent: QWidget) -> QAction:
    """An entry of a context menu."""
    made = QAction(words, parent)
    made.triggered.connect(lambda: do())
    return made
