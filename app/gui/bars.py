"""Sources of error as bars: sign, name, what made it, bar, number; what is not known is last and full length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QPushButton, QSizePolicy, QToolTip, QWidget

from app.gui import style
from app.theme import SIZES

ROW: Final = 25
SIGN, NAME, MADE = 26, 240, 200
"""Widths of columns, at most; the bar takes the rest."""
WORDS: Final = {
    "exact": "exact", "proven": "at most, proven", "estimated": "about", "sampled": "in draws", "unknown": "not known",
}  # fmt: skip
"""The five words as a sentence has them."""


@dataclass(frozen=True)
class Row:
    """A source.

    Parameters
    ----------
    made : what made it: its stage, or stage and node
    share : of the longest bar, in [0, 1]
    rule : why it is so large, or why it is not given
    node : where it arises, "" if it is not told
    ask : words of a button, "" for none
    """

    sign: str
    name: str
    made: str
    number: str
    rigour: str
    share: float
    rule: str
    node: str = ""
    ask: str = ""


class Bars(QWidget):
    """Rows of bars.

    Signals
    -------
    chosen : row that was clicked, or taken with Enter
    asked : row whose button was pressed
    """

    chosen = Signal(object)
    asked = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.rows: tuple[Row, ...] = ()
        self.buttons: list[QPushButton] = []
        self.at = 0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self.setAccessibleName("Sources of error")

    def tell(self, rows: Sequence[Row]) -> None:
        """Show other rows."""
        if tuple(rows) == self.rows:
            return
        self.rows = tuple(rows)
        self.at = min(self.at, max(0, len(self.rows) - 1))
        for button in self.buttons:
            button.deleteLater()
        self.buttons = []
        for row in self.rows:
            if row.ask:
                button = QPushButton(row.ask, self)
                button.setProperty("compact", True)
                button.setToolTip("State its size: a step is put in where the data come in, and can be undone")
                button.clicked.connect(lambda _=False, r=row: self.asked.emit(r))
                button.show()
                self.buttons.append(button)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus if any(r.node for r in self.rows) else Qt.FocusPolicy.NoFocus)
        self.setMinimumHeight(ROW * len(self.rows) + 4)
        self.setAccessibleDescription("\n".join(f"{WORDS[r.rigour]} {r.number}: {r.name}, {r.made}" for r in self.rows))
        self._place()
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        """All rows."""
        return QSize(500, ROW * len(self.rows) + 4)

    def columns(self) -> tuple[int, int, int]:
        """Widths of names, of what made them, and of numbers: as wide as the longest, within limits."""
        plain = QFontMetrics(style.body()).horizontalAdvance
        strong = style.body()
        strong.setBold(True)
        names = max((plain(row.name) for row in self.rows), default=0) + 18
        made = max((plain(row.made) for row in self.rows), default=0) + 18
        number = max((QFontMetrics(strong).horizontalAdvance(row.number) for row in self.rows), default=0) + 4
        return min(names, NAME, max(120, self.width() // 3)), min(made, MADE, max(60, self.width() // 4)), number

    def bar(self, row: int) -> QRectF:
        """Where a bar may be; before a button it is shorter."""
        names, made, number = self.columns()
        left = SIGN + names + made
        room = max(60, self.width() - left - number - 16)
        ask = max((button.sizeHint().width() + 14 for button in self.buttons), default=0) if self.rows[row].ask else 0
        return QRectF(left, row * ROW + (ROW - 12) / 2, max(40, room - ask), 12)

    def _place(self) -> None:
        asks = iter(self.buttons)
        for i, row in enumerate(self.rows):
            if row.ask:
                button = next(asks)
                bar = self.bar(i)
                button.setGeometry(round(bar.right() + 12), i * ROW + 1, button.sizeHint().width(), ROW - 2)

    # --- events

    def resizeEvent(self, event: QEvent) -> None:
        """Buttons stand after their bars."""
        self._place()

    def event(self, event: QEvent) -> bool:
        """The rule of a source, or why it is not given, as a tooltip."""
        if isinstance(event, QHelpEvent):
            at = event.pos().y() // ROW
            if 0 <= at < len(self.rows):
                row = self.rows[at]
                where = f"\nIt arises in {row.node}: a click goes there." if row.node else ""
                QToolTip.showText(event.globalPos(), f"{row.name}: {WORDS[row.rigour]} {row.number}\n{row.rule}{where}", self)
                return True
        return super().event(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Choose a row."""
        at = int(event.position().y()) // ROW
        if 0 <= at < len(self.rows):
            self.at = at
            self.update()
            if self.rows[at].node:
                self.chosen.emit(self.rows[at])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows move, Enter chooses."""
        step = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1}.get(Qt.Key(event.key()))
        if step is not None and self.rows:
            self.at = min(max(self.at + step, 0), len(self.rows) - 1)
            self.update()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.rows and self.rows[self.at].node:
            self.chosen.emit(self.rows[self.at])
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """The rows."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for i, row in enumerate(self.rows):
            self._paint(painter, i, row)
        if self.hasFocus() and self.rows:
            painter.setPen(QPen(style.colour("action"), 1, Qt.PenStyle.DashLine))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(0.5, self.at * ROW + 1.5, self.width() - 1, ROW - 3), 3, 3)

    def _paint(self, painter: QPainter, i: int, row: Row) -> None:
        y, bar = i * ROW, self.bar(i)
        names, wide, figures = self.columns()
        role = "text" if row.sign in ("=", "?") else "brass"
        write(painter, QRectF(2, y, SIGN - 2, ROW), row.sign, role, strong=True, pixels=15 if row.sign == "~" else 13)
        short = QFontMetrics(style.body()).elidedText
        write(painter, QRectF(SIGN, y, names, ROW), short(row.name, Qt.TextElideMode.ElideRight, names - 10), "text")
        made = short(row.made, Qt.TextElideMode.ElideRight, wide - 10)
        write(painter, QRectF(SIGN + names, y, wide, ROW), made, "text 2")
        draw_bar(painter, bar, row.share, row.rigour)
        quiet = row.rigour == "unknown"
        place = QRectF(self.width() - figures, y, figures, ROW)
        right = Qt.AlignmentFlag.AlignRight
        write(painter, place, row.number, "text 2" if quiet else "text", strong=not quiet, align=right)


class TotalLabel(QWidget):
    """The total: sign, number, and what is not known."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedHeight(36)
        self.parts: tuple[tuple[str, str], ...] = ()

    def tell(self, sign: str, number: str, missing: bool) -> None:
        """Show a total; nothing for no sign."""
        more = [(" + ?", "text 2")] if missing and sign != "?" else []
        self.parts = ((sign, "text" if sign in "=?" else "brass"), (number, "text"), *more) if sign else ()
        self.setAccessibleName(" ".join(words for words, _ in self.parts))
        self.setVisible(bool(self.parts))
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The parts side by side."""
        painter = QPainter(self)
        x = 0.0
        for i, (words, role) in enumerate(self.parts):
            font = style.body(round(SIZES["total"]))
            font.setBold(role != "text 2")
            painter.setFont(font)
            painter.setPen(style.colour(role))
            painter.drawText(QPointF(x, 28), words)
            x += painter.fontMetrics().horizontalAdvance(words) + (9 if i == 0 else 0)


def draw_bar(painter: QPainter, at: QRectF, share: float, rigour: str) -> None:
    """A bar in the pattern of its word; what is not known is hatched over the full length, never short."""
    brass = style.colour("brass")
    bar = QRectF(at.left(), at.top(), max(2.0, at.width() * share), at.height())
    painter.setPen(Qt.PenStyle.NoPen)
    if rigour == "exact":
        painter.fillRect(QRectF(at.left(), at.top() - 1, 2, at.height() + 2), style.colour("text"))
    elif rigour == "proven":
        painter.fillRect(bar, brass)
    elif rigour == "unknown":
        painter.fillRect(at, QBrush(style.colour("text 3"), Qt.BrushStyle.BDiagPattern))
        painter.setPen(QPen(style.colour("edge"), 1, Qt.PenStyle.DashLine))
        painter.drawRect(at.adjusted(0.5, 0.5, -0.5, -0.5))
    else:
        faint = QColor(brass)
        faint.setAlphaF(0.28)
        painter.fillRect(bar, faint)
        dash = Qt.PenStyle.DashLine if rigour == "estimated" else Qt.PenStyle.DotLine
        painter.setPen(QPen(brass, 1.5, dash))
        painter.drawRect(bar.adjusted(0.75, 0.75, -0.75, -0.75))


def write(
    painter: QPainter, at: QRectF, words: str, role: str, *, strong: bool = False, pixels: int = 13,
    align: Qt.AlignmentFlag = Qt.AlignmentFlag.AlignLeft,
) -> None:  # fmt: skip
    """Text in the middle of a row."""
    font = style.body(pixels)
    font.setBold(strong)
    painter.setFont(font)
    painter.setPen(style.colour(role))
    painter.drawText(at, align | Qt.AlignmentFlag.AlignVCenter, words)
