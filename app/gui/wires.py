"""Wires: the data line in the colour of its type, the second line that says what is known, and the badge."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPainterPathStroker, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.gui import badges
from app.gui.badges import Known
from app.gui.glyphs import Look

if TYPE_CHECKING:
    from app.engine.network import Origin, Socket

ABOVE, OVER = 17.0, 58.0
"""How far a badge lies above a short wire; and above one that is shorter than the badge."""
STEPS = 20
UNDER = 5.0
"""The second line lies this far under the data line."""


def curve(start: QPointF, end: QPointF) -> QPainterPath:
    """From an output to an input, leaving and arriving level."""
    dx, dy = end.x() - start.x(), end.y() - start.y()
    pull = max(abs(dx) / 2, min(40.0, abs(dy) / 2)) if dx >= 0 else min(60 - dx / 3, 220.0)
    path = QPainterPath(start)
    if abs(dy) < 0.5 and dx >= 0:
        path.lineTo(end)
    else:
        path.cubicTo(start + QPointF(pull, 0), end - QPointF(pull, 0), end)
    return path


def beside(path: QPainterPath, by: float = UNDER) -> QPainterPath:
    """A path at a distance on the lower side of another that runs to the right."""
    if path.elementCount() == 2:
        return path.translated(0, by)
    steps = STEPS * max(1, (path.elementCount() - 1) // 3)
    points = [path.pointAtPercent(i / steps) for i in range(steps + 1)]
    shifted = []
    for i, point in enumerate(points):
        a, b = points[max(0, i - 1)], points[min(steps, i + 1)]
        length = math.hypot(b.x() - a.x(), b.y() - a.y()) or 1.0
        shifted.append(QPointF(point.x() - by * (b.y() - a.y()) / length, point.y() + by * (b.x() - a.x()) / length))
    found = QPainterPath(shifted[0])
    for point in shifted[1:]:
        found.lineTo(point)
    return found


def through(start: QPointF, dots: tuple[tuple[float, float], ...], end: QPointF) -> QPainterPath:
    """From an output through some places to an input."""
    stops = [start, *(QPointF(x, y) for x, y in dots), end]
    path = curve(stops[0], stops[1])
    for a, b in pairwise(stops[1:]):
        path.connectPath(curve(a, b))
    return path


class WireItem(QGraphicsItem):
    """One wire."""

    def __init__(self, end: Socket, origin: Origin, kind: str, look: Look) -> None:
        super().__init__()
        self.end, self.origin, self.kind, self.look = end, origin, kind, look
        self.known: Known | None = None
        self.badge_shown = self.stale = self.chosen = self.faded = self.target = False
        self.path = QPainterPath()
        self.dots: tuple[tuple[float, float], ...] = ()
        self._lower: QPainterPath | None = None
        self._start, self._end = QPointF(), QPointF()
        self.setZValue(-1)
        self.badge: BadgeItem | None = None
        self._bounds = QRectF()

    def route(self, start: QPointF, end: QPointF) -> None:
        """Lie between two places."""
        self.prepareGeometryChange()
        self.path, self._lower = through(start, self.dots, end), None
        self._start, self._end = start, end
        self._bounds = self.path.controlPointRect().adjusted(-9, -9, 9, 9)
        if self.badge is not None:
            self.badge.place()

    def bend(self, dots: tuple[tuple[float, float], ...]) -> None:
        """Go through some places."""
        self.dots = dots
        self.route(self._start, self._end)

    def set_known(self, known: Known | None, badge: bool, stale: bool) -> None:
        """Say what is known; `badge` on one wire of each output."""
        if (known, badge, stale) != (self.known, self.badge_shown, self.stale):
            self.known, self.badge_shown, self.stale = known, badge, stale
            if self.badge is None and badge and known is not None and (scene := self.scene()):
                self.badge = BadgeItem(self)
                scene.addItem(self.badge)
            if self.badge is not None:
                self.badge.place()
            self.update()

    def badge_at(self) -> QPointF:
        """The middle; above it where the wire is too short to carry a badge, above the nodes where it is wider than the gap."""
        middle = self.path.pointAtPercent(0.5)
        gap = self._end.x() - self._start.x()
        if self.dots or not 0 <= gap < 120 or abs(self._end.y() - self._start.y()) > 60:
            return middle
        wide = badges.width(self.known) + 6 if self.known else 0.0
        return QPointF(middle.x(), min(self._start.y(), self._end.y()) - (ABOVE if wide <= gap else OVER))

    def boundingRect(self) -> QRectF:
        """Line and halo."""
        return self._bounds

    def shape(self) -> QPainterPath:
        """What a click hits: 12 px round the line, and the badge."""
        stroker = QPainterPathStroker()
        stroker.setWidth(12)
        return stroker.createStroke(self.path)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw halo, casing, data line, second line."""
        detail = option.levelOfDetailFromTransform(painter.worldTransform())
        look, colour = self.look, self.look.port(self.kind)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if self.faded:
            painter.setOpacity(0.35)
        if detail < 0.3:
            painter.setPen(QPen(look["action"] if self.chosen else colour, 2.25 / max(detail, 0.1) * 0.4))
            painter.drawPath(self.path)
            return
        if self.chosen or self.target:
            halo = look["action"]
            painter.setPen(QPen(_clear(halo), 11))
            painter.drawPath(self.path)
        else:
            painter.setPen(QPen(look["canvas"], 5))
            painter.drawPath(self.path)
        painter.setPen(QPen(colour, 2.25 if self.kind != "Accuracy" else 1.6))
        painter.drawPath(self.path)
        for x, y in self.dots:
            painter.setBrush(colour)
            painter.setPen(QPen(look["canvas"], 2))
            painter.drawEllipse(QPointF(x, y), 5, 5)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if self.known is None or detail < 0.45:
            return
        painter.setOpacity(painter.opacity() * (0.62 if self.stale else 1.0))
        if pen := badges.second_line(self.known.word, look):
            if self._lower is None:
                self._lower = beside(self.path)
            painter.setPen(pen)
            painter.drawPath(self._lower)


def _clear(colour: QColor) -> QColor:
    half = QColor(colour)
    half.setAlphaF(0.5)
    return half


class BadgeItem(QGraphicsItem):
    """The badge of a wire, above the nodes."""

    def __init__(self, wire: WireItem) -> None:
        super().__init__()
        self.wire = wire
        self.rect = QRectF()
        self.setZValue(3)

    def place(self) -> None:
        """Go where the wire carries it."""
        wire = self.wire
        shown = wire.known is not None and wire.badge_shown
        self.setVisible(shown)
        if shown and wire.known is not None:
            self.prepareGeometryChange()
            at, wide = wire.badge_at(), badges.width(wire.known)
            self.rect = QRectF(at.x() - wide / 2, at.y() - badges.HEIGHT / 2, wide, badges.HEIGHT)
            self.update()

    def boundingRect(self) -> QRectF:
        """The badge."""
        return self.rect.adjusted(-2, -2, 2, 2)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw it."""
        wire = self.wire
        if wire.known is None or option.levelOfDetailFromTransform(painter.worldTransform()) < 0.6:
            return
        painter.setOpacity(0.35 if wire.faded else 1.0)
        badges.badge(painter, wire.known, self.rect.center(), wire.look, chosen=wire.chosen, stale=wire.stale)


class LooseWire(QGraphicsItem):
    """The wire in the hand: solid, or round dots where a converter would go between."""

    def __init__(self, kind: str, look: Look) -> None:
        super().__init__()
        self.kind, self.look, self.dotted = kind, look, False
        self.path = QPainterPath()
        self.setZValue(5)

    def route(self, start: QPointF, end: QPointF, dotted: bool) -> None:
        """Lie between two places."""
        self.prepareGeometryChange()
        self.path, self.dotted = curve(start, end), dotted

    def boundingRect(self) -> QRectF:
        """The line."""
        return self.path.controlPointRect().adjusted(-6, -6, 6, 6)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw it."""
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(self.look["canvas"], 5))
        painter.drawPath(self.path)
        pen = QPen(self.look.port(self.kind), 2.25)
        if self.dotted:
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            pen.setDashPattern([0.01, 2.4])
        painter.setPen(pen)
        painter.drawPath(self.path)
