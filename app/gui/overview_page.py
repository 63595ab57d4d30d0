"""The page "Network": where the error of a picture comes from, over all steps that lead to it."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtWidgets import QComboBox, QFrame, QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from app.gui import stating, style
from app.gui.bars import Bars, Row, TotalLabel
from app.gui.budget_view import tell_total
from app.gui.session import Session
from app.gui.sources import Overview, made_in, overview_of, overview_rows
from modules.data.accuracy import SIGNS
from modules.data.wires import Scene


class OverviewPage(QWidget):
    """One picture, one quantity; every source as a bar with its stage and the node that made it. A click goes there."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.overview: Overview | None = None
        self.picture, self.quantity = QComboBox(), QComboBox()
        self.picture.setAccessibleName("Picture")
        self.quantity.setAccessibleName("Errors of")
        self.total = TotalLabel()
        self.words = style.labelled("", "small")
        self.words.setWordWrap(True)
        self.bars = Bars()
        self._build()
        self.picture.activated.connect(lambda _: self.refresh())
        self.quantity.activated.connect(lambda _: self.refresh())
        self.bars.chosen.connect(lambda row: session.select([row.node]))
        self.bars.asked.connect(self.give)
        session.networkChanged.connect(self._edited)
        session.resultChanged.connect(self._result)
        style.watch().changed.connect(self.bars.update)
        self._edited()

    def _build(self) -> None:
        left = QVBoxLayout()
        left.setSpacing(6)
        choices = QHBoxLayout()
        choices.setSpacing(6)
        choices.addWidget(self.picture, 3)
        choices.addWidget(self.quantity, 2)
        left.addLayout(choices)
        left.addWidget(self.total)
        left.addWidget(self.words)
        left.addStretch(1)
        side = QWidget()
        side.setProperty("kind", "panel")
        side.setLayout(left)
        side.setFixedWidth(250)
        inner = QWidget()
        inner.setProperty("kind", "panel")
        column = QVBoxLayout(inner)
        column.setContentsMargins(0, 0, 8, 0)
        column.addWidget(self.bars)
        column.addStretch(1)
        room = QScrollArea()
        room.setWidgetResizable(True)
        room.setFrameShape(QFrame.Shape.NoFrame)
        room.setWidget(inner)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 10, 4, 4)
        row.setSpacing(16)
        row.addWidget(side)
        row.addWidget(room, 1)

    # --- following

    @property
    def view(self) -> str:
        """The node of the picture that is looked at."""
        return str(self.picture.currentData() or "")

    def _edited(self) -> None:
        session, kept = self.session, self.view
        views = session.views()
        titles = {n: str(session.network[n].parameters.get("title") or n) for n in views}
        if [(self.picture.itemData(i), self.picture.itemText(i)) for i in range(self.picture.count())] != list(titles.items()):
            self.picture.clear()
            for name, title in titles.items():
                self.picture.addItem(title, name)
            self.picture.setCurrentIndex(max(0, self.picture.findData(kept)))
        self.picture.setVisible(len(views) > 1)
        self.refresh()

    def _result(self, node: str) -> None:
        if node == self.view:
            self.refresh()

    def refresh(self) -> None:
        """Show what is known now."""
        scene = next((v for v in (self.session.outputs(self.view) or {}).values() if isinstance(v, Scene)), None)
        self.overview = None
        if scene is not None:
            k, key = self.session.network.k, self.session.runs.key(self.view)
            found = self.session.look("overview", self.view, key, k, job=lambda: overview_of(scene, k))
            self.overview = found if isinstance(found, Overview) else None
        self._quantities()
        self._show(scene is not None)

    def _quantities(self) -> None:
        names = list(self.overview.quantities) if self.overview else []
        kept = self.quantity.currentData()
        if names != [self.quantity.itemData(i) for i in range(self.quantity.count())]:
            self.quantity.clear()
            for name in names:
                self.quantity.addItem(f"Errors of {name}", name)
            self.quantity.setCurrentIndex(max(0, self.quantity.findData(kept)))
        self.quantity.setVisible(len(names) > 1)

    def _show(self, drawn: bool) -> None:
        overview, quantity = self.overview, str(self.quantity.currentData() or "")
        if overview is None:
            self.total.tell("", "", False)
            self.bars.tell(())
            waits = "Known when the network has run." if self.view else "Add a view to see where its error comes from."
            self.words.setText("Looking…" if drawn else waits)
            return
        missing = bool(overview.missing)
        found = overview.total(quantity)
        tell_total(self.total, found[0] if found else None, missing, not missing and not found)
        self.words.setText(self._said(found[0].quantity if found else "", found[1] if found else "", missing))
        terms, gaps = made_in(self.session.network, self.view, self.session.outputs)
        rows = overview_rows(overview, quantity, terms, gaps)
        self.bars.tell([self._asking(row) for row in rows])

    def _said(self, quantity: str, layer: str, missing: bool) -> str:
        if not quantity:
            return "Nothing is known of how large the error is." if missing else "Nothing in this picture is in doubt."
        where = f" of “{layer}”" if layer else ""
        unknown = " One source is not known: the true error may be larger." if missing else ""
        return f"Largest error of {quantity}{where}, k = {self.session.network.k:g}.{unknown} Click a source to go to its step."

    def _asking(self, row: Row) -> Row:
        here = row.sign == SIGNS["unknown"] and stating.gap(self.session, self.view, row.name)
        return replace(row, ask=stating.words(row.name)) if here else row

    def give(self, row: Row) -> None:
        """Ask for the size of a source that is not given."""
        if found := stating.gap(self.session, self.view, row.name):
            stating.GiveError(self.session, found, self.window()).open()
