"""Small drawings that mean something: ports by colour and shape, rooms, the state of a node. And the colours to draw with."""

from __future__ import annotations

import functools
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QIcon, QPainter, QPainterPath, QPen, QPixmap

from app import theme
from app.gui import style

ROOMS: Final = {
    "readers": "Readers",
    "modellers": "Modellers",
    "mappers": "Mappers",
    "accuracy_mappers": "Accuracy mappers",
    "renderers": "Renderers",
}
"""Room -> what the user reads."""

TYPES: Final = {"ColourMap": "Colour map", "Accuracy": "accuracy", "Value": "Parameter"}
"""Wire type -> what the user reads, where that is not its name."""


class Look:
    """The theme in force: roles as colours. All items of a canvas share one, and a change reaches all."""

    def __init__(self, name: str = "") -> None:
        self.theme = theme.theme(name or current())
        self._made: dict[str, QColor] = {}

    def set(self, name: str) -> bool:
        """Take another theme; whether it is another."""
        if name == self.theme.name:
            return False
        self.theme = theme.theme(name)
        self._made = {}
        return True

    def __getitem__(self, role: str) -> QColor:
        """The colour of a role."""
        made = self._made.get(role)
        if made is None:
            made = self._made[role] = QColor(self.theme[role])
        return made

    def port(self, kind: str) -> QColor:
        """The colour of a wire type."""
        if kind == "Accuracy":
            return self["brass"]
        role = f"port {kind}"
        return self[role if role in self.theme.roles else "port Value"]


def current() -> str:
    """The theme in force in the window."""
    return style.present().name


@functools.cache
def font(pixels: int, strong: bool = False) -> QFont:
    """The font of the interface at a size."""
    made = style.body(pixels)
    made.setWeight(QFont.Weight.DemiBold if strong else QFont.Weight.Normal)
    return made


def pen(colour: QColor, width: float, line: Qt.PenStyle = Qt.PenStyle.SolidLine) -> QPen:
    """A pen with round ends."""
    return QPen(colour, width, line, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin)


# --- ports


def _polygon(*points: tuple[float, float]) -> QPainterPath:
    path = QPainterPath(QPointF(*points[0]))
    for point in points[1:]:
        path.lineTo(*point)
    path.closeSubpath()
    return path


def _ring(outer: float, inner: float) -> QPainterPath:
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.OddEvenFill)
    path.addEllipse(QPointF(), outer, outer)
    path.addEllipse(QPointF(), inner, inner)
    return path


@functools.cache
def shape(kind: str) -> QPainterPath:
    """The filled shape of a wire type, 12 px round (0, 0)."""
    path = QPainterPath()
    match kind:
        case "Samples":
            path.addEllipse(QPointF(), 6, 6)
        case "Model":
            path = _polygon((0, -7), (7, 0), (0, 7), (-7, 0))
        case "Geometry":
            path.addRect(-5.5, -5.5, 11, 11)
        case "Layer":
            path = _polygon((-5, -6.5), (7, 0), (-5, 6.5))
        case "Scene":
            path.setFillRule(Qt.FillRule.WindingFill)
            path.addRect(-2, -6.5, 4, 13)
            path.addRect(-6.5, -2, 13, 4)
        case "Table":
            for y in (-6.0, -1.5, 3.0):
                path.addRect(-6, y, 12, 3)
        case "ColourMap":
            path = _half()
        case _:
            path = _ring(6, 3.4)
    return path


def _half() -> QPainterPath:
    left = QPainterPath(QPointF(0, -5))
    left.arcTo(QRectF(-5, -5, 10, 10), 90, 180)
    left.closeSubpath()
    return _ring(6, 4.5).united(left)


@functools.cache
def scales() -> QPainterPath:
    """Two short scales: the twin socket, lines of 1.5 px."""
    path = QPainterPath()
    for (x, y), (u, v) in (
        ((-5, -2), (5, -2)), ((-5, 2), (5, 2)), ((-3.5, -2), (-3.5, -4.5)), ((0, -2), (0, -4.5)), ((3.5, -2), (3.5, -4.5)),
        ((-2, 2), (-2, 4.5)), ((2, 2), (2, 4.5)),
    ):  # fmt: skip
        path.moveTo(x, y)
        path.lineTo(u, v)
    return path


def port(
    painter: QPainter, kind: str, at: QPointF, look: Look, *, scale: float = 1.0, ground: str = "", free: bool = False
) -> None:
    """Draw a port.

    Parameters
    ----------
    ground : role of the outline that sets it off, "" for none
    free : only its outline: a place where one more wire may end
    """
    painter.save()
    painter.translate(at)
    painter.scale(scale, scale)
    colour = look.port(kind)
    if kind == "Accuracy":
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if ground:
            painter.setPen(pen(look[ground], 4))
            painter.drawPath(scales())
        painter.setPen(QPen(colour, 1.5))
        painter.drawPath(scales())
    else:
        if ground:
            around = QPen(look[ground], 4)
            around.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
            painter.setPen(around)
            painter.setBrush(look[ground])
            painter.drawPath(shape(kind))
        painter.setPen(QPen(colour, 1.4) if free else Qt.PenStyle.NoPen)
        painter.setBrush(look["canvas"] if free else colour)
        if free:
            painter.scale(0.8, 0.8)
        painter.drawPath(shape(kind))
    painter.restore()


# --- rooms


@functools.cache
def _room(name: str) -> QPainterPath:
    """A room's icon in 16 x 16, as lines."""
    p = QPainterPath()
    match name:
        case "readers":
            _lines(p, (2.75, 2.75, 2.75, 13.25), (5.5, 8, 13.25, 8), (10, 4.75, 13.25, 8), (13.25, 8, 10, 11.25))
        case "link":
            _lines(p, (5.8, 10.2, 10.2, 5.8))
            p.addRoundedRect(QRectF(1.8, 8.2, 6, 6), 3, 3)
            p.addRoundedRect(QRectF(8.2, 1.8, 6, 6), 3, 3)
        case "modellers":
            p.moveTo(2, 11.5)
            p.cubicTo(4.5, 11.5, 4.8, 4.5, 8, 4.5)
            p.cubicTo(11.2, 4.5, 11.5, 9.5, 14, 9.5)
            for x, y in ((2.9, 11.3), (8, 4.5), (13.2, 9.5)):
                p.addEllipse(QPointF(x, y), 0.8, 0.8)
        case "mappers":
            p.addEllipse(QRectF(1.8, 1.9, 12.4, 12.2))
            p.addEllipse(QRectF(5.2, 5.3, 5.7, 5.4))
        case "accuracy_mappers":
            _lines(p, (1.75, 6.25, 14.25, 6.25), (1.75, 9.75, 14.25, 9.75))
            _lines(p, *((x, 6.25, x, 3.25) for x in (3.25, 6.4, 9.6, 12.75)))
            _lines(p, *((x, 9.75, x, 12.75) for x in (2.5, 5.3, 8.1, 10.9, 13.7)))
        case "renderers":
            p.moveTo(1.5, 8)
            p.cubicTo(4.2, 2, 11.8, 2, 14.5, 8)
            p.cubicTo(11.8, 14, 4.2, 14, 1.5, 8)
            p.addEllipse(QPointF(8, 8), 2.1, 2.1)
        case "mine":
            p.addEllipse(QPointF(8, 5.25), 2.75, 2.75)
            p.moveTo(2.75, 13.75)
            p.cubicTo(3.6, 8.1, 12.4, 8.1, 13.25, 13.75)
        case "examples":
            _lines(p, (2.5, 3.5, 6.5, 3.5), (6.5, 3.5, 8, 5.5), (8, 5.5, 13.5, 5.5), (13.5, 5.5, 13.5, 12.5),
                   (13.5, 12.5, 2.5, 12.5), (2.5, 12.5, 2.5, 3.5))  # fmt: skip
        case "search":
            p.addEllipse(QPointF(7, 7), 4.5, 4.5)
            _lines(p, (10.3, 10.3, 14, 14))
        case _:
            p.addRoundedRect(QRectF(2, 2, 12, 12), 2, 2)
    return p


def _lines(path: QPainterPath, *lines: tuple[float, float, float, float]) -> None:
    for x, y, u, v in lines:
        path.moveTo(x, y)
        path.lineTo(u, v)


def room(painter: QPainter, name: str, corner: QPointF, colour: QColor, size: float = 16) -> None:
    """Draw a room's icon with its upper left corner at a place."""
    painter.save()
    painter.translate(corner)
    painter.scale(size / 16, size / 16)
    painter.setPen(pen(colour, 1.5, Qt.PenStyle.DashLine if name == "missing" else Qt.PenStyle.SolidLine))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPath(_room(name))
    painter.restore()


def icon(name: str, look: Look, role: str = "text 2") -> QIcon:
    """A room's icon for lists."""
    pixmap = QPixmap(32, 32)
    pixmap.setDevicePixelRatio(2)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    room(painter, name, QPointF(), look[role])
    painter.end()
    return QIcon(pixmap)


# --- states


def state(painter: QPainter, kind: str, at: QPointF, look: Look, progress: float | None = None, turn: float = 0.0) -> None:
    """Draw the badge of a state round a place; the shape says it first, the colour second.

    Parameters
    ----------
    progress : 0 to 1 of a running node; None if the length is unknown
    turn : of the ring then, in turns
    """
    painter.save()
    painter.translate(at)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(pen(look["text 2"], 1.7))
    match kind:
        case "running":
            _running(painter, look, progress, turn)
        case "failed":
            _failed(painter, look)
        case "missing":
            painter.setPen(QPen(look["flag"], 1.5, Qt.PenStyle.DashLine))
            painter.drawRoundedRect(QRectF(-6.5, -6.5, 13, 13), 2, 2)
            painter.setFont(font(11, True))
            painter.drawText(QRectF(-7, -7, 14, 14), Qt.AlignmentFlag.AlignCenter, "?")
        case "cached":
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(look["text 2"])
            painter.drawPath(_state(kind))
        case _:
            painter.drawPath(_state(kind))
    painter.restore()


def _running(painter: QPainter, look: Look, progress: float | None, turn: float) -> None:
    ring = QRectF(-7, -7, 14, 14)
    painter.setPen(QPen(look["track"], 2.5))
    painter.drawEllipse(ring)
    painter.setPen(pen(look["action"], 2.5))
    if progress is None:
        painter.drawArc(ring, round((90 - 360 * turn) * 16), -90 * 16)
    else:
        painter.drawArc(ring, 90 * 16, round(-360 * 16 * min(max(progress, 0.0), 1.0)))
    painter.fillRect(QRectF(-2, -2, 4, 4), look["action"])


def _failed(painter: QPainter, look: Look) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(look["failed"])
    painter.drawPath(_polygon((0, -7.3), (7.3, 0), (0, 7.3), (-7.3, 0)))
    painter.setPen(pen(look["raised"], 1.9))
    painter.drawLine(QPointF(0, -3.4), QPointF(0, 0.6))
    painter.drawPoint(QPointF(0, 3.3))


@functools.cache
def _state(kind: str) -> QPainterPath:
    p = QPainterPath()
    match kind:
        case "clean":
            _lines(p, (-4, 0.3, -1.2, 3), (-1.2, 3, 4.2, -3))
        case "queued":
            for x in (-4.0, 0.0, 4.0):
                p.addEllipse(QPointF(x, 0), 0.6, 0.6)
        case "cached":
            p = _polygon((1.2, -6), (-3.6, 1), (-0.3, 1), (-1.2, 6), (3.6, -1), (0.3, -1))
        case "blocked":
            _lines(p, (-2.5, -4, -2.5, 4), (2.5, -4, 2.5, 4))
        case "held":
            _lines(p, (-4.5, 0, -4.5, -2.5), (-1.5, -1, -1.5, -5), (1.5, -1, 1.5, -5), (4.5, 0, 4.5, -3))
            p.moveTo(-4.5, 0)
            p.cubicTo(-4.5, 3.5, -2.7, 5.5, 0, 5.5)
            p.cubicTo(2.7, 5.5, 4.5, 3.5, 4.5, 0)
        case "disabled":
            p.addEllipse(QPointF(), 5.5, 5.5)
            _lines(p, (-3.9, 3.9, 3.9, -3.9))
        case "bypassed":
            p.moveTo(-5.5, 3)
            p.cubicTo(-5.5, -6, 5, -6, 5, 2)
            _lines(p, (2.2, -0.4, 5, 2.6), (5, 2.6, 7.2, -0.8))
            p.addEllipse(QPointF(0, 3.4), 1.2, 1.2)
        case _:
            p.addEllipse(QPointF(), 4, 4)
    return p
