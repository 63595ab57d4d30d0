"""How a node ran: time, memory, key; what failed with its traceback; and what can be done about it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFormLayout, QFrame, QGridLayout, QHBoxLayout, QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from app.engine.errors import NoniusError
from app.gui import style, summary
from app.gui.session import Session
from app.gui.widgets.parts import button

WORDS = {
    "clean": "done", "cached": "done, its result was there already", "dirty": "has not run since the last edit",
    "queued": "in line", "running": "running", "failed": "failed", "blocked": "waits", "held": "held until you press Fire",
    "disabled": "disabled", "bypassed": "bypassed: what comes in goes on", "missing": "its module is not installed",
}  # fmt: skip


class RunSection(QWidget):
    """The section "Last run" of the panel; `failure` is the card at its top."""

    def __init__(self, session: Session, node: str) -> None:
        super().__init__()
        self.session, self.node = session, node
        self.failure = FailureCard(session, node)
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(6)
        form.setHorizontalSpacing(8)
        self.state, self.time, self.memory, self.key = (self._told(form, w) for w in ("State", "Time", "Memory", "Result"))
        self.key.setFont(style.mono(11))
        self.said = style.labelled("", "flag")
        self.said.setWordWrap(True)
        self.hold = button("Hold", self._hold, tip="Let it fire only when you press Fire")
        self.off = button("Disable", lambda: session.disable(node), tip="It gives nothing, and what hangs on it waits")
        self.past = button("Bypass", self._bypass, tip="What comes in goes on in place of what it gives")
        self.fire = button("Fire", lambda: session.fire(node), tip="Run it again, also if its result is there")
        self.run = button("Run to here", lambda: session.run_to(node), tip="Run all that it needs, and it (Shift+F5)")
        row = QGridLayout()
        row.setContentsMargins(0, 4, 0, 0)
        row.setSpacing(6)
        for i, one in enumerate((self.hold, self.off, self.past, self.fire, self.run)):
            one.setProperty("compact", True)
            row.addWidget(one, i // 3, i % 3)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addLayout(form)
        column.addWidget(self.said)
        column.addLayout(row)
        self.refresh()

    def _told(self, form: QFormLayout, words: str) -> QLabel:
        label = style.labelled(words, "quiet")
        label.setFixedWidth(84)
        told = style.labelled("")
        told.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        form.addRow(label, told)
        return told

    def _hold(self) -> None:
        self.session.hold(self.node)
        self.refresh()

    def _bypass(self) -> None:
        try:
            self.session.bypass([self.node])
        except NoniusError as error:
            self.session.message.emit("error", str(error))

    def refresh(self) -> None:
        """Show how the node is."""
        session, node = self.session, self.node
        if node not in session.network.nodes:
            return
        state = session.state(node)
        part = f", {state.progress:.0%}" if state.kind == "running" and state.progress else ""
        self.state.setText(WORDS[state.kind] + part)
        entry = session.runs.entry(node)
        self.time.setText(summary.elapsed(state.seconds or entry.seconds) if entry else "–")
        self.memory.setText(megabytes(entry.bytes) if entry else "–")
        key = session.runs.key(node)
        self.key.setText(f"{key[:4]} {key[4:8]}" if key else "–")
        said = "; ".join(entry.warnings) if entry else ""
        self.said.setText(said)
        self.said.setVisible(bool(said))
        self.hold.setText("Let go" if session.network[node].view.get("held") else "Hold")
        self.past.setText("Let fire" if session.network[node].bypass else "Bypass")
        self.off.setText("Enable" if session.network[node].disabled else "Disable")
        self.failure.refresh()


class FailureCard(QFrame):
    """What failed, in a sentence; what went in, the traceback, and a button that copies all of it."""

    def __init__(self, session: Session, node: str) -> None:
        super().__init__()
        self.session, self.node = session, node
        self.setProperty("kind", "failure")
        self.sentence = style.labelled("")
        self.sentence.setWordWrap(True)
        self.sentence.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.inputs = style.labelled("", "small")
        self.inputs.setWordWrap(True)
        self.inputs.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.trace = QPlainTextEdit()
        self.trace.setReadOnly(True)
        self.trace.setFont(style.mono(11))
        self.trace.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.trace.setFixedHeight(150)
        self.trace.hide()
        self.more = button("Traceback", self._more, link=True)
        self.copy = button("Copy", self._copy, link=True, tip="Copy the sentence, the inputs and the traceback")
        self.again = button("Try again", lambda: session.fire(node), link=True)
        row = QHBoxLayout()
        for one in (self.again, self.more, self.copy):
            row.addWidget(one)
        row.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(10, 8, 10, 6)
        column.setSpacing(4)
        column.addWidget(self.sentence)
        column.addWidget(self.inputs)
        column.addLayout(row)
        column.addWidget(self.trace)
        column.addStretch(1)
        self.refresh()

    def refresh(self) -> None:
        """Show what failed, or nothing."""
        state = self.session.state(self.node)
        failed = state.kind == "failed"
        self.setVisible(failed)
        if failed:
            self.sentence.setText(state.sentence)
            self.inputs.setText("\n".join(summary.inputs(self.session, self.node)))
            self.inputs.setVisible(bool(self.inputs.text()))
            self.trace.setPlainText(state.error.traceback if state.error else "")
            self.more.setVisible(bool(state.error and state.error.traceback))

    def _more(self) -> None:
        self.trace.setVisible(not self.trace.isVisible())
        self.more.setText("Hide it" if self.trace.isVisible() else "Traceback")

    def report(self) -> str:
        """All that is known of the failure, as text."""
        parts = (f"{self.node}: {self.sentence.text()}", self.inputs.text(), self.trace.toPlainText())
        return "\n\n".join(part for part in parts if part).strip()

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.report())


def megabytes(size: int) -> str:
    """Bytes in words."""
    for unit in ("bytes", "kB", "MB"):
        if size < 1000:
            return f"{size:.0f} {unit}" if unit == "bytes" or size >= 10 else f"{size:.1f} {unit}"
        size = size / 1000  # type: ignore[assignment]  # a number of the next unit
    return f"{size:.1f} GB"
