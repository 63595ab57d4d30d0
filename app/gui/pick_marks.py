"""Marks over a picture: the ring where something was picked, and handles of positions that a module takes."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPixmap
from PySide6.QtWidgets import QWidget

from app.gui import style

Ink = QColor | Qt.GlobalColor
SIZE = 35
RING = 7.0
ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0), Qt.Key.Key_Right: (1.0, 0.0), Qt.Key.Key_Up: (0.0, -1.0), Qt.Key.Key_Down: (0.0, 1.0),
}  # fmt: skip


class Mark(QWidget):
    """A small drawing whose `middle` stands on a place of the picture; it lets all else of the picture be seen."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setFixedSize(SIZE, SIZE)
        self.middle = QPointF()
        self.hide()

    def put(self, at: QPointF | None) -> None:
        """Stand on a place of the parent; None hides it."""
        parent = self.parentWidget()
        inside = at is not None and parent is not None and QRectF(parent.rect()).contains(at)
        if inside and at is not None:
            self.middle = at
            self.move(round(at.x() - SIZE / 2), round(at.y() - SIZE / 2))
        self.setVisible(inside)

    def shaped(self) -> None:
        """Only where it is painted, for a parent that is drawn by the graphics card and shows through nothing."""
        picture = QPixmap(self.size())
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        self.draw(painter, Qt.GlobalColor.black, 3.0)
        painter.end()
        self.setMask(picture.mask())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Dark below, light above: it is seen on any ground."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.draw(painter, style.colour("line on clay"), 3.4)
        self.draw(painter, style.colour("text on action"), 1.6)

    def draw(self, painter: QPainter, colour: Ink, width: float) -> None:
        """Its lines in one colour."""
        raise NotImplementedError


class Ring(Mark):
    """Where something was picked."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def draw(self, painter: QPainter, colour: Ink, width: float) -> None:
        """A ring with four ticks, its middle free."""
        painter.setPen(QPen(colour, width))
        middle = QPointF(SIZE / 2, SIZE / 2)
        painter.drawEllipse(middle, RING, RING)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            step = QPointF(dx, dy)
            painter.drawLine(middle + step * (RING - 3), middle + step * (RING + 6))


class Handle(Mark):
    """A position that a module takes: dragged with the mouse, moved by arrow keys.

    `dragged` gives the new place in the parent, and whether more is to come.
    """

    dragged = Signal(QPointF, bool)

    def __init__(self, parent: QWidget, words: Callable[[], str]) -> None:
        super().__init__(parent)
        self._words = words
        self._from: QPointF | None = None
        self._moved = False
        self.setCursor(Qt.CursorShape.SizeAllCursor)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.tell()

    def tell(self) -> None:
        """Say what it moves."""
        self.setToolTip(f"{self._words()}. Drag it, or press the arrow keys.")
        self.setAccessibleName(self._words())

    @property
    def held(self) -> bool:
        """Whether it is being dragged."""
        return self._from is not None

    def draw(self, painter: QPainter, colour: Ink, width: float) -> None:
        """A diamond with a dot; a ring around it when the keys move it."""
        painter.setPen(QPen(colour, width))
        middle, r = QPointF(SIZE / 2, SIZE / 2), 7.0
        painter.drawPolygon([middle + QPointF(*p) for p in ((0, -r), (r, 0), (0, r), (-r, 0))])
        painter.drawPoint(middle)
        if self.hasFocus():
            painter.drawEllipse(middle, 12.0, 12.0)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of it."""
        self._from, self._moved = self.mapToParent(event.position()) - self.middle, False
        self.setFocus(Qt.FocusReason.MouseFocusReason)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Take it along."""
        if self._from is not None:
            to = self.mapToParent(event.position()) - self._from
            self.put(to)
            self._moved = True
            self.dragged.emit(to, True)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Leave it there."""
        if self._from is not None:
            self._from = None
            if self._moved:
                self.dragged.emit(self.middle, False)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move it by a pixel, with Shift by ten."""
        step = ARROWS.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        far = 10.0 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1.0
        self.dragged.emit(self.middle + QPointF(*step) * far, event.isAutoRepeat())
