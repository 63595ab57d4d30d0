"""The budget of a wire or node: the total first, then each source as a bar, then how it adds up."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtWidgets import QFrame, QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from app.draw import numbers
from app.gui import stating, style
from app.gui.bars import Bars, Row, TotalLabel
from app.gui.budgets import SPREAD, Budget, Total
from app.gui.session import Session
from app.gui.sources import rows_of
from modules.data.accuracy import SIGNS


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
        self.bars.asked.connect(self.give)
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
        tell_total(self.total, total, missing, self.budget is not None and self.budget.exact)
        self.words.setText(self._said(total))
        self.sums.setText(_sums(self.budget, total) if self.budget and total else "")
        self.how.setVisible(bool(self.sums.text()))
        self.bars.tell(self._rows(total.quantity if total else ""))

    def _rows(self, quantity: str) -> list[Row]:
        """The sources of a quantity; what is not given has a button where its size can be stated."""
        if self.budget is None or self.where is None:
            return []
        lines = [(one, self.budget.size(one)) for one in self.budget.lines if one.quantity == quantity]
        rows = rows_of(lines, {m.name: m.reason for m in self.budget.missing})
        node = self.where[0]
        return [replace(r, ask=stating.words(r.name)) if r.sign == SIGNS["unknown"] and self._gap(node, r) else r for r in rows]

    def _gap(self, node: str, row: Row) -> stating.Gap | None:
        return stating.gap(self.session, node, row.name)

    def give(self, row: Row) -> None:
        """Ask for the size of a source that is not given."""
        found = self._gap(self.where[0], row) if self.where else None
        if found is not None:
            stating.GiveError(self.session, found, self.window()).open()

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


def tell_total(label: TotalLabel, total: Total | None, missing: bool, exact: bool) -> None:
    """Show a total with its sign; "exact" where nothing is in doubt, "not given" where nothing is known."""
    if total is not None and not (total.rigour == "exact" and total.value == 0):
        label.tell(total.sign, total.number, missing)
    elif exact or total is not None:
        label.tell(SIGNS["exact"], "exact", missing)
    else:
        label.tell(SIGNS["unknown"] if missing else "", "not given", missing)


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
