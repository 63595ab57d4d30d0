"""The legend over a viewport: what is drawn, what is not, what nobody gave. It may be moved, never hidden."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QLinearGradient, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.draw import numbers
from app.draw.parts import Bar, Entry, Legend, Swatch
from app.gui import style

PAD: Final = 11.0
LEADING: Final = 16.0
WIDE: Final = 268.0
SIGNS: Final = 24.0

Ink = Callable[[QPainter, float, float], None]


@dataclass(frozen=True)
class Row:
    """A piece of the legend: its height, and what draws it."""

    height: float
    ink: Ink


NEEDED: Final = 330
"""Pixels of a picture beside which the legend finds room of its own."""


class LegendBox(QWidget):
    """An opaque panel beside the picture of its parent; over a corner of it where there is no room, or it is asked for.

    `placed` gives the width of the column that it takes at the right of the picture, 0 for none.
    """

    placed = Signal(int)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.legend: Legend | None = None
        self.ground = "view"
        self._rows: list[Row] = []
        self._from: QPointF | None = None
        self._free = False
        self.corner = "top left"
        self.setCursor(Qt.CursorShape.SizeAllCursor)
        self.setToolTip("What this picture shows of its accuracy, and what it does not. Drag it aside where it is in the way.")
        self.hide()

    def tell(self, legend: Legend | None, corner: str = "") -> None:
        """Show what a legend says; None while there is no picture.

        Parameters
        ----------
        corner : of the picture, or "right" for beside it
        """
        self.legend = legend
        self.corner = corner or self.corner
        self.setVisible(legend is not None)
        self.setAccessibleDescription("\n".join(legend.lines()) if legend else "")
        self.arrange()

    def arrange(self) -> None:
        """Measure again and stay within the parent."""
        if self.legend is None:
            return
        room = self._room()
        column = round(WIDE + 2 * PAD) + 24
        beside = self.corner == "right" and not self._free and room.width() - column >= NEEDED
        brief = not beside and not self._free and room.width() < column + NEEDED
        self._rows = self._fitting(room.height() - 24.0 - 2 * PAD, brief)
        height = sum(r.height for r in self._rows) + 2 * PAD
        self.resize(QSize(round(WIDE + 2 * PAD), round(height)))
        if not self._free:
            left = not beside and not self.corner.endswith("right")
            low = not beside and self.corner.startswith("bottom")
            self.move(12 if left else room.width() - self.width() - 12, room.height() - self.height() - 12 if low else 12)
        self._inside(self.pos().toPointF())
        self.placed.emit(column if beside else 0)
        self.update()

    def _inside(self, at: QPointF) -> None:
        room = self._room() - self.size()
        self.move(max(0, min(round(at.x()), room.width())), max(0, min(round(at.y()), room.height())))

    def _room(self) -> QSize:
        parent = self.parentWidget()
        return parent.size() if parent else self.size()

    # --- rows

    def _fitting(self, room: float, brief: bool) -> list[Row]:
        """All rows; where they do not fit, or are to be few, fewer of what is not drawn, with their number."""
        assert self.legend is not None
        for kept in range(0 if brief else len(self.legend.not_drawn), -1, -1):
            rows = self._all(kept)
            if sum(r.height for r in rows) <= room:
                return rows
        return self._all(0)

    def _all(self, kept: int) -> list[Row]:
        assert self.legend is not None
        rows: list[Row] = []
        for i, block in enumerate(self.legend.drawn):
            rows += [_gap(7)] if i else []
            rows += self._text(block.title, strong=True, swatch=block.swatch) if block.title else []
            rows += [self._bar(block.bar)] if block.bar else []
            for entry in block.entries:
                rows += self._entry(entry)
            rows += [self._boxes(block.boxes)] if block.boxes else []
        rest = self.legend.not_drawn
        if rest:
            rows += [_gap(5), _rule(), _gap(5), *self._text("Not drawn", role="text 2")]
            for entry in rest[:kept]:
                rows += self._entry(entry, notes=False)
            left = len(rest) - kept
            more = f"and {left} more" if kept else numbers.plural(left, "source")
            rows += self._text(f"{more}, listed in the budget", role="text 2", indent=SIGNS) if left else []
        rows += [_gap(4), *self._text(self.legend.footer, role="text 3")] if self.legend.footer else []
        return rows or self._text("exact: nothing here is in doubt")

    def _entry(self, entry: Entry, notes: bool = True) -> list[Row]:
        number = entry.number
        sign = entry.sign
        wide = QFontMetricsF(_font(strong=True)).horizontalAdvance(number) + 8 if number else 0.0
        words = self._text(entry.words, indent=SIGNS + wide)
        role = "text" if sign in ("=", "?") else "brass"
        first = words[0]

        def ink(painter: QPainter, x: float, y: float) -> None:
            _write(painter, x, y, sign, role, strong=True)
            _write(painter, x + SIGNS, y, number, "text", strong=True)
            first.ink(painter, x, y)

        told = [row for note in entry.notes for row in self._text(note, role="text 2", indent=SIGNS)] if notes else []
        return [Row(first.height, ink), *words[1:], *told]

    def _text(
        self, text: str, *, role: str = "text", strong: bool = False, indent: float = 0.0, swatch: Swatch | None = None
    ) -> list[Row]:
        left = indent + (24.0 if swatch else 0.0)
        rows = []
        for i, words in enumerate(_wrapped(text, _font(strong), WIDE - left)):
            first = i == 0

            def ink(p: QPainter, x: float, y: float, words: str = words, first: bool = first) -> None:
                _write(p, x + left, y, words, role, strong)
                if swatch and first:
                    _swatch(p, QRectF(x, y, 18, LEADING), swatch, self.ground)

            rows.append(Row(LEADING, ink))
        return rows

    def _bar(self, bar: Bar) -> Row:
        ends = numbers.along([bar.low, bar.high])

        def ink(p: QPainter, x: float, y: float) -> None:
            title = f"{bar.title}, {bar.unit}" if bar.unit and bar.title else bar.title or bar.unit
            _write(p, x, y, title, "text 2")
            ramp = QLinearGradient(x, 0, x + WIDE, 0)
            for i, colour in enumerate(bar.colours):
                ramp.setColorAt(i / max(1, len(bar.colours) - 1), QColor.fromRgbF(*colour[:3]))
            p.fillRect(QRectF(x, y + LEADING + 2, WIDE, 8), ramp)
            low = ("< " if bar.under else "") + ends[0]
            high = ends[1] + (" +" if bar.over else "")
            _write(p, x, y + LEADING + 12, low, "text 2")
            _write(p, x + WIDE - QFontMetricsF(_font()).horizontalAdvance(high), y + LEADING + 12, high, "text 2")

        return Row(2 * LEADING + 14, ink)

    def _boxes(self, boxes: Sequence[str]) -> Row:
        def ink(p: QPainter, x: float, y: float) -> None:
            left = x + SIGNS
            for words in boxes:
                wide = QFontMetricsF(_font(strong=True)).horizontalAdvance(words) + 12
                p.setPen(QPen(style.colour("edge"), 1))
                p.drawRoundedRect(QRectF(left + 0.5, y + 2.5, wide, 17), 4, 4)
                _write(p, left + 6, y + 3, words, "text", strong=True)
                left += wide + 6

        return Row(23, ink)

    # --- events

    def paintEvent(self, event: QPaintEvent) -> None:
        """The panel."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(style.colour("divider"), 1))
        painter.setBrush(style.colour("panel"))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 4, 4)
        y = PAD
        for row in self._rows:
            row.ink(painter, PAD, y)
            y += row.height

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to move it."""
        self._from = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move it."""
        if self._from is not None:
            if not self._free:
                self._free = True
                self.placed.emit(0)
            self._inside(self.mapToParent(event.position() - self._from))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Leave it there."""
        self._from = None


def _font(strong: bool = False) -> QFont:
    font = style.body(11)
    font.setWeight(QFont.Weight.DemiBold if strong else QFont.Weight.Normal)
    return font


def _write(painter: QPainter, x: float, y: float, words: str, role: str, strong: bool = False) -> None:
    painter.setFont(_font(strong))
    painter.setPen(style.colour(role))
    painter.drawText(QPointF(x, y + 12), words)


def _wrapped(text: str, font: QFont, width: float) -> list[str]:
    """Lines that fit a width."""
    measure = QFontMetricsF(font)
    lines, line = [], ""
    for word in text.split(" "):
        longer = f"{line} {word}" if line else word
        if line and measure.horizontalAdvance(longer) > width:
            lines.append(line)
            line = word
        else:
            line = longer
    return [*lines, line]


def _gap(height: float) -> Row:
    return Row(height, lambda p, x, y: None)


def _rule() -> Row:
    return Row(1, lambda p, x, y: p.fillRect(QRect(round(x), round(y), round(WIDE), 1), style.colour("divider")))


def _swatch(painter: QPainter, at: QRectF, swatch: Swatch, ground: str) -> None:
    on = "clay" if ground == "clay" else "view"
    colour = QColor(style.present().on(swatch.colour, on))  # type: ignore[arg-type]  # one of the two
    if abs(colour.lightness() - style.colour("panel").lightness()) < 40:
        colour = style.colour("text")
    middle = at.center().y()
    if swatch.kind == "line":
        dash = Qt.PenStyle.DashLine if swatch.dashed else Qt.PenStyle.SolidLine
        painter.setPen(QPen(colour, max(1.0, min(3.0, swatch.size)), dash))
        painter.drawLine(QPointF(at.left(), middle), QPointF(at.right() - 2, middle))
    elif swatch.kind == "surface":
        painter.fillRect(QRectF(at.left(), middle - 4, 14, 9), colour)
    else:
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colour)
        for i, dy in enumerate((1.0, -3.0, 2.0, -1.0)):
            painter.drawEllipse(QPointF(at.left() + 2 + 4 * i, middle + dy), 1.3, 1.3)
