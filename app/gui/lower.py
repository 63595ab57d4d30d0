"""The pages below the canvas: what is known of the accuracy, and how the work goes."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QTabWidget, QWidget

from app.gui import style
from app.gui.budget_view import BudgetView
from app.gui.overview_page import OverviewPage
from app.gui.pages import LogPage, ProblemsPage
from app.gui.places_page import FlagsPage, WorstPage
from app.gui.sequence_page import SequencePage
from app.gui.session import Session

PAGES: Final = {
    "budget": "Budget", "overview": "Network", "flags": "Flags", "worst": "Worst places", "sequence": "Sequence",
    "problems": "Problems", "log": "Log",
}  # fmt: skip
"""Pages by the name of the action that shows them."""


class Lower(QTabWidget):
    """The tabs of the lower dock.

    Signals
    -------
    zoomAsked : `Spot` to be brought into view
    went : node that was gone to
    counted : numbers of flags and of problems
    """

    zoomAsked = Signal(object)
    went = Signal(str)
    counted = Signal(int, int)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.budget = BudgetView(session)
        self.overview = OverviewPage(session)
        self.flags = FlagsPage(session)
        self.worst = WorstPage(session)
        self.sequence = SequencePage(session)
        self.problems = ProblemsPage(session)
        self.log = LogPage(session)
        self.setDocumentMode(True)
        for name, words in PAGES.items():
            self.addTab(getattr(self, name), words)
        self.about = style.labelled("", "quiet")
        self.about.setContentsMargins(0, 0, 12, 0)
        self.about.setMinimumHeight(self.tabBar().sizeHint().height())
        self.about.setAlignment(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight)
        self.setCornerWidget(self.about, Qt.Corner.TopRightCorner)
        for places in (self.flags, self.worst):
            places.zoomAsked.connect(self.zoomAsked)
        for page in (self.problems, self.log):
            page.went.connect(self.went)
        self.overview.bars.chosen.connect(lambda row: self.went.emit(row.node))
        session.waveDone.connect(lambda _: self._count())
        self.problems.list.model().rowsInserted.connect(lambda *_: self._count())
        self.problems.list.model().rowsRemoved.connect(lambda *_: self._count())
        session.networkChanged.connect(self._count)
        session.selectionChanged.connect(self._about)

    def show_page(self, name: str) -> None:
        """Bring a page up, ready for the keyboard."""
        page = getattr(self, name)
        self.setCurrentWidget(page)
        inner = getattr(page, "list", page)
        inner.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def show_wire(self, node: str, output: str) -> None:
        """The budget of a wire."""
        if node:
            self.budget.show_wire(node, output)
            self._about()

    def _about(self) -> None:
        chosen, where = self.session.selection, self.budget.where
        if len(chosen) == 1:
            self.about.setText(f"selected: {chosen[0]}")
        elif chosen:
            self.about.setText(f"{len(chosen)} selected")
        else:
            self.about.setText(f"selected wire: from {where[0]}.{where[1]}" if where else "")

    def _count(self) -> None:
        for name, count in (("flags", self.flags.count), ("problems", self.problems.count)):
            words = f"{PAGES[name]}  {count}" if count else PAGES[name]
            at = self.indexOf(getattr(self, name))
            if self.tabText(at) != words:
                self.setTabText(at, words)
        self.counted.emit(self.flags.count, self.problems.count)
