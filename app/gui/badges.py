"""What is known of the accuracy on a wire: its word, its number, its second line and its badge."""

from __future__ import annotations

import math
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetricsF, QPainter, QPen

from app.draw import numbers
from app.gui.budgets import SPREAD, Budget
from app.gui.glyphs import Look, font
from modules.data.terms import SIGNS

HEIGHT = 18.0


@dataclass(frozen=True)
class Known:
    """What a badge says.

    Parameters
    ----------
    word : the weakest among the known terms; "unknown" if there is none
    number : their sum with its unit, "" for none
    missing : whether a source is not given besides
    """

    word: str
    number: str = ""
    missing: bool = False

    @property
    def sign(self) -> str:
        """The sign of the word."""
        return SIGNS[self.word]

    def words(self) -> str:
        """The badge in words, for a tooltip."""
        text = {"exact": "exact", "proven": "at most, proven:", "estimated": "about", "sampled": "in draws:"}
        known = f"{text.get(self.word, 'accuracy not given')} {self.number}".strip()
        return f"{known}. One source is not known, so it may be more." if self.missing else known


def known(budget: Budget | None, reach: float = math.inf) -> Known | None:
    """What a budget comes to, by its first quantity; None while nothing was said.

    Parameters
    ----------
    reach : size of the shape; a larger error of position says only that there is no bound, so that on 95 % is told
    """
    if budget is None:
        return None
    missing = bool(budget.missing)
    if not budget.totals:
        return Known("unknown") if missing else Known("exact")
    total = budget.totals[0]
    if total.rigour == "exact" and total.value == 0:
        return Known("exact", missing=missing)
    if total.quantity == "position" and total.value > reach:
        return Known(total.rigour, _mostly(budget, total.quantity, total.unit), missing)
    return Known(total.rigour, total.number, missing)


def _mostly(budget: Budget, quantity: str, unit: str) -> str:
    """The sum on 95 % of the items."""
    lines = [one for one in budget.lines if one.quantity == quantity]
    bounds = sum(one.p95 for one in lines if one.kind not in SPREAD)
    spread = math.sqrt(sum(one.p95**2 for one in lines if one.kind in SPREAD))
    number = numbers.with_unit(numbers.significant(bounds + budget.k * spread, up=True), unit)
    return f"{number} on 95{numbers.SPACE}%"


def second_line(word: str, look: Look) -> QPen | None:
    """The pen of the line under the data line; None for exact."""
    if word == "exact":
        return None
    pen = QPen(look["text 2" if word == "unknown" else "brass"], 1.4)
    dashes = {"estimated": (9, 5), "sampled": (0.01, 5), "unknown": (3, 8)}.get(word)
    if word == "sampled":
        pen.setWidthF(2.4)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    if dashes:
        pen.setDashPattern([d / pen.widthF() for d in dashes])
    return pen


def width(one: Known) -> float:
    """How wide the badge is."""
    return sum(w for _, w in _cells(one)) + 12 if one.word not in ("exact", "unknown") or one.missing else 22.0


def _cells(one: Known) -> list[tuple[str, float]]:
    strong, plain = QFontMetricsF(font(11, True)), QFontMetricsF(font(11))
    sign = strong.horizontalAdvance(one.sign) * (1.35 if one.sign == "~" else 1.0)
    cells = [("sign", sign)]
    if one.number:
        cells.append(("number", plain.horizontalAdvance(one.number) + 4))
    if one.missing:
        cells.append(("missing", plain.horizontalAdvance("?") + 11))
    return cells


def badge(painter: QPainter, one: Known, at: QPointF, look: Look, *, chosen: bool = False, stale: bool = False) -> QRectF:
    """Draw a badge round a place; its rectangle."""
    wide = width(one)
    rect = QRectF(at.x() - wide / 2, at.y() - HEIGHT / 2, wide, HEIGHT)
    painter.setPen(QPen(look["action" if chosen else "edge"], 1.0))
    painter.setBrush(look["panel"])
    painter.drawRoundedRect(rect, 4, 4)
    painter.setOpacity(painter.opacity() * (0.62 if stale else 1.0))
    cells = _cells(one)
    x = rect.center().x() - sum(w for _, w in cells) / 2
    middle = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
    for what, size in cells:
        cell = QRectF(x, rect.top(), size + 4, HEIGHT - 1)
        if what == "sign":
            painter.setPen(look["text" if one.word in ("exact", "unknown") else "brass"])
            painter.setFont(font(15 if one.sign == "~" else 12, True))
            painter.drawText(cell.translated(0, 1 if one.sign == "~" else 0), middle, one.sign)
        elif what == "number":
            painter.setPen(look["text"])
            painter.setFont(font(11))
            painter.drawText(cell.translated(4, 0), middle, one.number)
        else:
            painter.setPen(QPen(look["divider"], 1))
            painter.drawLine(QPointF(x + 5, rect.top() + 3), QPointF(x + 5, rect.bottom() - 3))
            painter.setPen(look["text"])
            painter.setFont(font(11, True))
            painter.drawText(cell.translated(11, 0), middle, "?")
        x += size
    return rect
