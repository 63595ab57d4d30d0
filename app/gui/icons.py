"""Icons: one drawing of 16 x 16 a file, tinted with a role of the theme after painting."""

from __future__ import annotations

import functools

from PySide6.QtCore import QByteArray, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from app import paths
from app.gui import style

SCALES = (1, 2, 3)


def icon(name: str, role: str = "text", off: str = "text 3") -> QIcon:
    """An icon in the present theme; grey where what it stands for cannot be done."""
    return _icon(name, style.present()[role], style.present()[off])


def pixmap(name: str, role: str = "text", size: int = 16, ratio: float = 1.0) -> QPixmap:
    """A drawing at a size, in logical pixels."""
    return _pixmap(name, style.present()[role], size, ratio)


def application() -> QIcon:
    """The icon of the program."""
    made = QIcon()
    for size in (16, 32, 48, 64, 128):
        made.addPixmap(_pixmap("nonius", "", size, 1.0))
    return made


@functools.cache
def _icon(name: str, colour: str, off: str) -> QIcon:
    made = QIcon()
    for scale in SCALES:
        made.addPixmap(_pixmap(name, colour, 16, float(scale)), QIcon.Mode.Normal)
        made.addPixmap(_pixmap(name, off, 16, float(scale)), QIcon.Mode.Disabled)
    return made


@functools.cache
def _drawing(name: str) -> QSvgRenderer:
    return QSvgRenderer(QByteArray((paths.data("resources") / "icons" / f"{name}.svg").read_bytes()))


def _pixmap(name: str, colour: str, size: int, ratio: float) -> QPixmap:
    """Painted, then filled with the colour where something was painted; as it is without one."""
    pixels = max(1, round(size * ratio))
    made = QPixmap(pixels, pixels)
    made.fill(Qt.GlobalColor.transparent)
    painter = QPainter(made)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    _drawing(name).render(painter, QRectF(0, 0, pixels, pixels))
    if colour:
        painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_SourceIn)
        painter.fillRect(made.rect(), QColor(colour))
    painter.end()
    made.setDevicePixelRatio(ratio)
    return made
