"""The pages that tell how the work goes: what does not run and why, and the log. Each entry leads to its node."""

from __future__ import annotations

import time

from PySide6.QtCore import QEvent, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.engine.errors import Unwired
from app.gui import icons, style
from app.gui.run_section import FailureCard
from app.gui.session import Session

KEPT = 2000
NODE = Qt.ItemDataRole.UserRole
RANK = {"failed": 0, "missing": 1, "blocked": 2}


class ProblemsPage(QWidget):
    """Every node that does not run, with its sentence; at the right what failed, with its inputs and traceback.

    `went` gives the node that was gone to.
    """

    went = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.list = QTreeWidget()
        self.list.setHeaderLabels(["Module", "What is wrong"])
        self.list.setRootIsDecorated(False)
        self.list.setAccessibleName("Problems")
        self.list.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.empty = style.labelled("No problems: every module that was asked for has run.", "quiet")
        self.card = QScrollArea()
        self.card.setWidgetResizable(True)
        self.card.setFrameShape(QScrollArea.Shape.NoFrame)
        self.card.setFixedWidth(380)
        left = QVBoxLayout()
        left.addWidget(self.empty, 0, Qt.AlignmentFlag.AlignTop)
        left.addWidget(self.list, 1)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 8, 12, 8)
        row.setSpacing(16)
        row.addLayout(left, 1)
        row.addWidget(self.card)
        self.list.currentItemChanged.connect(lambda *_: self._tell())
        self.list.itemClicked.connect(lambda item, _: self._go(item))
        self.list.itemActivated.connect(lambda item, _: self._go(item))
        self._soon = QTimer(self, singleShot=True, interval=60)
        self._soon.timeout.connect(self.refresh)
        session.stateChanged.connect(lambda _: self._later())
        session.networkChanged.connect(self._later)
        style.watch().changed.connect(self._later)
        self.problems: tuple[tuple[str, str], ...] = ()
        self.refresh()

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.problems)

    @property
    def node(self) -> str:
        """That is chosen."""
        item = self.list.currentItem()
        return str(item.data(0, NODE)) if item else ""

    def _later(self) -> None:
        if not self._soon.isActive():
            self._soon.start()

    def refresh(self) -> None:
        """Gather what does not run: what failed first, then what is not installed, then what is not wired."""
        found: list[tuple[int, str, str]] = []
        for node in self.session.network.order:
            state = self.session.state(node)
            if state.kind in RANK and (state.kind != "blocked" or isinstance(state.error, Unwired)):
                found.append((RANK[state.kind], node, state.sentence))
        problems = tuple((node, sentence) for _, node, sentence in sorted(found, key=lambda f: f[0]))
        kept = self.node
        if problems != self.problems:
            self.problems = problems
            self.list.clear()
            for node, sentence in problems:
                failed = self.session.state(node).kind == "failed"
                item = QTreeWidgetItem([node, sentence])
                item.setData(0, NODE, node)
                item.setIcon(0, icons.icon("flag", "failed" if failed else "flag"))
                item.setToolTip(1, f"{sentence}\nClick to go there")
                self.list.addTopLevelItem(item)
                if node == kept:
                    self.list.setCurrentItem(item)
            if problems and self.list.currentIndex().row() < 0:
                self.list.setCurrentIndex(self.list.model().index(0, 0))
        self.empty.setVisible(not problems)
        self.list.setVisible(bool(problems))
        self._tell()

    def _tell(self) -> None:
        card = self.card.widget()
        if isinstance(card, FailureCard) and card.node == self.node:
            card.refresh()
        elif self.node:
            self.card.setWidget(FailureCard(self.session, self.node))
        self.card.setVisible(bool(self.node) and self.session.state(self.node).kind == "failed")

    def _go(self, item: QTreeWidgetItem) -> None:
        node = str(item.data(0, NODE))
        self.session.select([node])
        self.went.emit(node)


class LogPage(QListWidget):
    """What was said, and what ran. An entry about a node leads to it; Ctrl+C copies the chosen entries."""

    went = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.setFont(style.mono(11))
        self.setFrameShape(QListWidget.Shape.NoFrame)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setStyleSheet("QListView::item { padding: 1px 8px; }")
        self.setAccessibleName("Log")
        self.itemActivated.connect(self._go)
        session.message.connect(lambda kind, words: self.write(f"{kind}: {words}"))
        session.waveDone.connect(lambda outcome: self.write(f"run: {outcome}"))
        session.stateChanged.connect(self._state)

    def write(self, words: str, node: str = "") -> None:
        """A line with the time; it stays in sight if the last one was."""
        bar = self.verticalScrollBar()
        last = bar.value() >= bar.maximum() - 2
        item = QListWidgetItem(f"{time.strftime('%H:%M:%S')}  {words}")
        item.setData(NODE, node)
        if node:
            item.setToolTip(f"Double-click goes to {node}")
        self.addItem(item)
        while self.count() > KEPT:
            self.takeItem(0)
        if last:
            self.scrollToBottom()

    def _go(self, item: QListWidgetItem) -> None:
        node = str(item.data(NODE) or "")
        if node in self.session.network.nodes:
            self.session.select([node])
            self.went.emit(node)

    def _state(self, node: str) -> None:
        state = self.session.state(node)
        if state.kind == "failed":
            self.write(f"{node} failed: {state.sentence}", node)
        elif state.kind == "clean" and state.seconds:
            self.write(f"{node} ran {1000 * state.seconds:.0f} ms{'; ' + state.sentence if state.sentence else ''}", node)

    def event(self, event: QEvent) -> bool:
        """Copy is the log's own while it has the focus, and not that of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            if event.matches(QKeySequence.StandardKey.Copy):
                event.accept()
                return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Copy."""
        if event.matches(QKeySequence.StandardKey.Copy):
            rows = sorted(self.selectedItems(), key=self.row)
            QGuiApplication.clipboard().setText("\n".join(item.text() for item in rows))
        else:
            super().keyPressEvent(event)
