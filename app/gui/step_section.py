"""What a node adds to the error: inherited and added here, with the rule behind the largest part."""

from __future__ import annotations

import math

from PySide6.QtWidgets import QGridLayout, QLabel, QVBoxLayout, QWidget

from app.draw import numbers
from app.gui import style
from app.gui.budgets import SPREAD, Budget
from app.gui.session import Session
from app.gui.widgets.parts import section
from modules.data.accuracy import SIGNS, Line


class StepSection(QWidget):
    """The section "What this step adds" of the panel."""

    def __init__(self, session: Session, node: str) -> None:
        super().__init__()
        self.session, self.node = session, node
        self.head = section("What this step adds")
        self.inherited, self.added = style.labelled("", "title"), style.labelled("", "title")
        self.words = style.labelled("", "quiet")
        self.words.setWordWrap(True)
        self.grid = QGridLayout()
        self.grid.setContentsMargins(0, 0, 0, 0)
        self.grid.setVerticalSpacing(4)
        self.names = style.labelled("Inherited", "quiet"), style.labelled("Added here", "quiet")
        for i, (name, number) in enumerate(zip(self.names, (self.inherited, self.added), strict=True)):
            self.grid.addWidget(name, i, 0)
            self.grid.addWidget(number, i, 2)
        self.grid.setColumnStretch(1, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addWidget(self.head)
        column.addLayout(self.grid)
        column.addWidget(self.words)
        self.refresh()

    def refresh(self) -> None:
        """Show what is known now."""
        outputs = self.session.outputs(self.node) or {}
        budgets = [b for o in outputs if (b := self.session.budget(self.node, o)) is not None]
        budget = budgets[0] if budgets else None
        for part in (*self.names, self.inherited, self.added):
            part.setVisible(budget is not None and bool(budget.lines))
        if budget is None:
            self.words.setText("Known when it has run." if not outputs else "Looking…")
            return
        if not budget.lines:
            missing = f"{SIGNS['unknown']} {budget.missing[0].name}: {budget.missing[0].reason}" if budget.missing else ""
            self.words.setText(missing or "Exact: nothing here is in doubt.")
            return
        quantity = budget.lines[0].quantity
        key = self.session.runs.key(self.node)
        mine = [one for one in budget.lines if one.quantity == quantity and one.id.startswith(key)]
        rest = [one for one in budget.lines if one.quantity == quantity and not one.id.startswith(key)]
        _tell(self.inherited, rest, budget, bool(budget.missing))
        _tell(self.added, mine, budget, False)
        self.words.setText(_rule(mine, quantity))


def _tell(label: QLabel, lines: list[Line], budget: Budget, missing: bool) -> None:
    """A sum of terms with its sign."""
    bounds = sum(budget.size(one) for one in lines if one.kind not in SPREAD)
    spread = math.sqrt(sum(budget.size(one) ** 2 for one in lines if one.kind in SPREAD))
    word = max((one.rigour for one in lines), key=list(SIGNS).index, default="exact")
    number = numbers.quantity(bounds + spread, lines[0].unit, up=word == "proven") if lines else "nothing"
    sign = SIGNS[word] if lines else SIGNS["exact"]
    label.setText(f"{sign} {number}{' + ?' if missing else ''}")


def _rule(lines: list[Line], quantity: str) -> str:
    """The rule of the largest part, in words."""
    if not lines:
        return f"This step adds nothing to the {quantity}."
    largest = max(lines, key=lambda one: one.max)
    rule = largest.rule.partition(" [")[0]
    return f"{largest.name}: {rule}." if rule else f"{largest.name}."
