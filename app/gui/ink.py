"""The painter of the window with the doors of a sheet, so that a view has the same axes as its picture."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen

from app.gui import style
from app.theme import Theme


class QtInk:
    """Draws with a painter in logical pixels.

    Parameters
    ----------
    painter : active; None to measure only
    theme : colours by role
    """

    def __init__(self, painter: QPainter | None, theme: Theme) -> None:
        self.painter, self.theme = painter or QPainter(), theme
        if painter is not None:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def px(self, value: float) -> float:
        """Qt counts in pixels at 100 % itself."""
        return value

    def extent(self, words: str, size: float, bold: bool = False) -> tuple[float, float]:
        """Width and height of words."""
        measure = QFontMetricsF(style.body(round(size)))
        return measure.horizontalAdvance(words), measure.capHeight()

    def text(
        self, x: float, y: float, words: str, *, size: float = 11.0, role: str = "text", bold: bool = False,
        across: str = "left", up: str = "baseline", angle: float = 0.0, halo: str = "",
    ) -> None:  # fmt: skip
        """Words at a place."""
        wide = self.extent(words, size)[0]
        self.painter.save()
        self.painter.translate(x, y)
        self.painter.rotate(-angle)
        self.painter.setFont(style.body(round(size)))
        self.painter.setPen(QColor(self.theme[role]))
        self.painter.drawText(QPointF(-{"left": 0.0, "center": 0.5, "right": 1.0}[across] * wide, 0.0), words)
        self.painter.restore()

    def line(self, points: Sequence[Sequence[float]], *, role: str = "text", width: float = 1.0, dashed: bool = False) -> None:
        """A line through points."""
        kind = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
        self.painter.setPen(QPen(QColor(self.theme[role]), width, kind))
        self.painter.setBrush(Qt.BrushStyle.NoBrush)
        self.painter.drawPolyline([QPointF(float(x), float(y)) for x, y in points])

    def box(
        self, x: float, y: float, width: float, height: float, *, fill: str = "", edge: str = "", radius: float = 0.0,
        line: float = 1.0,
    ) -> None:  # fmt: skip
        """A rectangle from its upper left corner."""
        self.painter.setPen(QPen(QColor(self.theme[edge]), line) if edge else Qt.PenStyle.NoPen)
        self.painter.setBrush(QColor(self.theme[fill]) if fill else Qt.BrushStyle.NoBrush)
        self.painter.drawRoundedRect(QRectF(x + 0.5, y + 0.5, width, height), radius, radius)
