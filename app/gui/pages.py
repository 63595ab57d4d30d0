"""The pages beside the budget: flags, and the log of what was said and run."""

from __future__ import annotations

import time

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QPlainTextEdit, QVBoxLayout, QWidget

from app.draw import numbers
from app.gui import icons, style
from app.gui.session import Session

KEPT = 2000
WORDS = {"kappa": "Slope too small for the error"}


class FlagsPage(QWidget):
    """What to look at twice, over the whole network; a click chooses the module that says it."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.list = QListWidget()
        self.list.setWordWrap(True)
        self.list.setAccessibleName("Flags")
        self.empty = style.labelled("No flags: nothing here asks to be looked at twice.", "quiet")
        column = QVBoxLayout(self)
        column.setContentsMargins(12, 8, 12, 8)
        column.addWidget(self.empty)
        column.addWidget(self.list)
        self.count = 0
        self.list.itemClicked.connect(lambda item: session.select([str(item.data(Qt.ItemDataRole.UserRole))]))
        session.waveDone.connect(lambda _: self.refresh())
        session.networkChanged.connect(lambda: None if session.network.nodes else self.refresh())
        self.refresh()

    def refresh(self) -> None:
        """Gather the flags; each stands once, at the first module that has it."""
        self.list.clear()
        seen: set[tuple[str, str]] = set()
        for node in self.session.network.order:
            for output in self.session.outputs(node) or {}:
                accuracy = self.session.accuracy(node, output)
                for flag in accuracy.flags if accuracy else ():
                    if (flag.name, flag.words) in seen:
                        continue
                    seen.add((flag.name, flag.words))
                    name = WORDS.get(flag.name, flag.name[:1].upper() + flag.name[1:])
                    places = f", {numbers.plural(flag.count, 'place')}" if flag.items is not None else ""
                    item = QListWidgetItem(icons.icon("flag", "flag"), f"{name}{places}\n{flag.words}")
                    item.setData(Qt.ItemDataRole.UserRole, node)
                    item.setToolTip(f"Said by {node}. Click to choose it.")
                    self.list.addItem(item)
        self.count = len(seen)
        self.empty.setVisible(not seen)
        self.list.setVisible(bool(seen))


class LogPage(QPlainTextEdit):
    """What was said, and what ran."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.setReadOnly(True)
        self.setMaximumBlockCount(KEPT)
        self.setFont(style.mono(11))
        self.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.setAccessibleName("Log")
        session.message.connect(lambda kind, words: self.write(f"{kind}: {words}"))
        session.waveDone.connect(lambda outcome: self.write(f"run: {outcome}"))
        session.stateChanged.connect(self._state)

    def write(self, words: str) -> None:
        """A line with the time."""
        self.appendPlainText(f"{time.strftime('%H:%M:%S')}  {words}")

    def _state(self, node: str) -> None:
        state = self.session.state(node)
        if state.kind == "failed":
            self.write(f"{node} failed: {state.sentence}")
        elif state.kind == "clean" and state.seconds:
            self.write(f"{node} ran {1000 * state.seconds:.0f} ms{'; ' + state.sentence if state.sentence else ''}")
