"""The budget of a wire or node: the total first, then each source as a bar, then how it adds up."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QColor, QFontMetrics, QHelpEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QFrame, QHBoxLayout, QScrollArea, QSizePolicy, QToolTip, QVBoxLayout, QWidget

from app.draw import numbers
from app.gui import style
from app.gui.budgets import SPREAD, Budget, Total
from app.gui.session import Session
from app.theme import SIZES
from modules.data.accuracy import SIGNS, Line

ROW: Final = 25
COLUMNS: Final = (26, 230, 74, 116)
"""Widths of sign, name, stage and number; the bar takes the rest."""
STAGES = {"data": "data", "model": "model", "mapping": "mapping", "render": "render"}


class Bars(QWidget):
    """The sources of one budget, the largest first, what is not known last and full length."""

    def __init__(self) -> None:
        super().__init__()
        self.budget: Budget | None = None
        self.quantity = ""
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)

    def tell(self, budget: Budget | None, quantity: str) -> None:
        """Show a budget."""
        self.budget, self.quantity = budget, quantity
        self.setMinimumHeight(ROW * len(self.rows()) + 4)
        self.setAccessibleDescription("\n".join(" ".join(row[:4]) for row in self.rows()))
        self.update()

    def sizeHint(self) -> QSize:
        """All rows."""
        return QSize(500, ROW * len(self.rows()) + 4)

    def rows(self) -> list[tuple[str, str, str, str, str, float, str]]:
        """(sign, name, stage, number, rigour, share of the longest, rule) of each source."""
        if self.budget is None:
            return []
        lines = sorted((one for one in self.budget.lines if one.quantity == self.quantity), key=lambda o: -self.budget_size(o))
        longest = max((self.budget_size(one) for one in lines), default=0.0)
        found: list[tuple[str, str, str, str, str, float, str]] = []
        for one in lines:
            share = self.budget_size(one) / longest if longest else 0.0
            found.append((one.sign, one.name, one.stage, self._number(one), one.rigour, share, one.rule))
        for gap in self.budget.missing:
            found.append((SIGNS["unknown"], gap.name, "", "not given", "unknown", 1.0, gap.reason))
        return found

    def event(self, event: QEvent) -> bool:
        """The rule of a source, or why it is not given, as a tooltip."""
        if isinstance(event, QHelpEvent):
            rows = self.rows()
            at = event.pos().y() // ROW
            if 0 <= at < len(rows):
                QToolTip.showText(event.globalPos(), f"{rows[at][1]}\n{rows[at][6]}", self)
                return True
        return super().event(event)

    def budget_size(self, line: Line) -> float:
        """As it counts in the total."""
        return self.budget.size(line) if self.budget else 0.0

    def _number(self, line: Line) -> str:
        spread = "±" if line.kind in SPREAD else ""
        return f"{spread}{numbers.quantity(self.budget_size(line), line.unit, up=line.rigour == 'proven')}"

    def paintEvent(self, event: QPaintEvent) -> None:
        """The rows."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        left, width = 0, self.width()
        signs, names, stages, figures = COLUMNS
        names = min(names, max(120, width // 3))
        bar = QRectF(left + signs + names + stages, 0, max(40, width - signs - names - stages - figures - 16), 12)
        for i, (sign, name, stage, number, rigour, share, _) in enumerate(self.rows()):
            y = i * ROW
            role = "text" if sign in ("=", "?") else "brass"
            _text(painter, QRectF(0, y, signs, ROW), sign, role, strong=True, pixels=15 if sign == "~" else 13)
            short = QFontMetrics(style.body()).elidedText(name, Qt.TextElideMode.ElideRight, names - 10)
            _text(painter, QRectF(signs, y, names, ROW), short, "text")
            _text(painter, QRectF(signs + names, y, stages, ROW), STAGES.get(stage, stage), "text 2")
            at = bar.translated(0, y + (ROW - 12) / 2)
            draw_bar(painter, at, share, rigour)
            quiet = rigour == "unknown"
            place = QRectF(bar.right() + 16, y, figures, ROW)
            right = Qt.AlignmentFlag.AlignRight
            _text(painter, place, number, "text 2" if quiet else "text", strong=not quiet, align=right)


class BudgetView(QWidget):
    """The page "Budget" below the canvas."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.where: tuple[str, str] | None = None
        self.budget: Budget | None = None
        self.what = style.labelled("", "quiet")
        self.total = TotalLabel()
        self.words = style.labelled("", "small")
        self.words.setWordWrap(True)
        self.sums = style.labelled("", "small")
        self.sums.setWordWrap(True)
        self.bars = Bars()
        self._build()
        session.selectionChanged.connect(self._chosen)
        session.resultChanged.connect(self._result)
        session.networkChanged.connect(self._edited)
        style.watch().changed.connect(self.refresh)
        self.refresh()

    def _build(self) -> None:
        left = QVBoxLayout()
        left.setSpacing(3)
        for widget in (self.what, self.total, self.words):
            left.addWidget(widget)
        left.addStretch(1)
        side = QWidget()
        side.setProperty("kind", "panel")
        side.setLayout(left)
        side.setFixedWidth(250)
        room = QScrollArea()
        room.setWidgetResizable(True)
        room.setFrameShape(QFrame.Shape.NoFrame)
        inner = QWidget()
        inner.setProperty("kind", "panel")
        column = QVBoxLayout(inner)
        column.setContentsMargins(0, 0, 8, 0)
        column.addWidget(self.bars)
        self.how = style.labelled("How it adds up", "title")
        column.addSpacing(6)
        column.addWidget(self.how)
        column.addWidget(self.sums)
        column.addStretch(1)
        room.setWidget(inner)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 10, 4, 4)
        row.setSpacing(16)
        row.addWidget(side)
        row.addWidget(room, 1)

    # --- what it is about

    def show_wire(self, node: str, output: str) -> None:
        """The budget of a wire, by where it begins."""
        self.where = (node, output.partition(":")[0])
        self.session.observe("budget", (node,))
        self.refresh()

    def _chosen(self) -> None:
        if self.session.selection:
            node = self.session.selection[0]
            record = self.session.catalogue.get(self.session.network[node].module)
            self.where = (node, record.outputs[0].name) if record else None
            self.session.observe("budget", ())
            self.refresh()

    def _edited(self) -> None:
        if self.where and self.where[0] not in self.session.network.nodes:
            self.where = None
            self.refresh()

    def _result(self, node: str) -> None:
        if self.where and node == self.where[0]:
            self.refresh()

    def refresh(self) -> None:
        """Show what is known now."""
        node, output = self.where or ("", "")
        self.budget = self.session.budget(node, output) if node else None
        total = self.budget.totals[0] if self.budget and self.budget.totals else None
        missing = bool(self.budget and self.budget.missing)
        self.what.setText(self._about(node, output, total))
        self.total.tell(total, missing, self.budget is not None and self.budget.exact)
        self.words.setText(self._said(total))
        self.sums.setText(_sums(self.budget, total) if self.budget and total else "")
        self.how.setVisible(bool(self.sums.text()))
        self.bars.tell(self.budget, total.quantity if total else "")

    def _about(self, node: str, output: str, total: Total | None) -> str:
        if not node:
            return "Choose a module or a wire."
        return f"{total.quantity.capitalize()} of {node}.{output}" if total else f"{node}.{output}"

    def _said(self, total: Total | None) -> str:
        if self.budget is None:
            if self.where is None:
                return ""
            there = self.session.outputs(self.where[0]) is not None
            carries = self.session.accuracy(*self.where) is not None
            return "Looking…" if carries else "It carries no accuracy of its own." if there else "Known when it has run."
        if total is None:
            return "" if not self.budget.missing else "Nothing is known of how large the error is."
        look = total.note or f"largest of {numbers.count(total.count)} {total.place}s"
        looked = f", {numbers.count(total.looked)} of {numbers.count(total.count)} looked at"
        some = looked if total.looked < total.count else ""
        unknown = " One source is not known: the true error may be larger." if self.budget.missing else ""
        return f"k = {self.budget.k:g}, {look}{some}.{unknown}"


class TotalLabel(QWidget):
    """The total: sign, number, and what is not known."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedHeight(36)
        self.parts: tuple[tuple[str, str], ...] = ()

    def tell(self, total: Total | None, missing: bool, exact: bool) -> None:
        """Show a total."""
        if total is not None and not (total.rigour == "exact" and total.value == 0):
            role = "text" if total.sign == "=" else "brass"
            self.parts = ((total.sign, role), (total.number, "text"), *([(" + ?", "text 2")] if missing else []))
        elif exact or total is not None:
            self.parts = (("=", "text"), ("exact", "text"), *([(" + ?", "text 2")] if missing else []))
        else:
            self.parts = (("?", "text"), ("not given", "text 2")) if missing else ()
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


def _text(
    painter: QPainter, at: QRectF, words: str, role: str, *, strong: bool = False, pixels: int = 13,
    align: Qt.AlignmentFlag = Qt.AlignmentFlag.AlignLeft,
) -> None:  # fmt: skip
    font = style.body(pixels)
    font.setBold(strong)
    painter.setFont(font)
    painter.setPen(style.colour(role))
    painter.drawText(at, align | Qt.AlignmentFlag.AlignVCenter, words)


def _sums(budget: Budget, total: Total) -> str:
    """How the total comes about, in a line each."""
    mine = [one for one in budget.lines if one.quantity == total.quantity]
    bounds = [budget.size(one) for one in mine if one.kind not in SPREAD and budget.size(one) > 0]
    spreads = [budget.size(one) for one in mine if one.kind in SPREAD]
    said = []
    if len(bounds) > 1:
        parts = " + ".join(numbers.significant(b) for b in bounds[:4]) + (" + …" if len(bounds) > 4 else "")
        said.append(f"{parts} {total.unit}: bounds add, item by item")
    if spreads:
        said.append(f"{budget.k:g} × standard deviations, added in squares")
    if budget.missing:
        said.append("what is not given is never counted as zero")
    others = [f"{t.quantity} {t.sign} {t.number}" for t in budget.totals[1:]]
    said += [f"besides: {', '.join(others)}"] if others else []
    return "\n".join(said) or "one source"
