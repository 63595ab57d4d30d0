"""The line at the foot: what runs, what failed, what was said last; threads, memory, the recovery log."""

from __future__ import annotations

import time

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QPushButton, QSizePolicy, QStatusBar, QWidget

from app.draw import numbers
from app.gui import icons, style
from app.gui.session import Session

GIGA = 1 << 30
LONGEST = 34


class Status(QStatusBar):
    """The status bar."""

    pageAsked = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.setSizeGripEnabled(False)
        self.now = style.labelled("")
        self.failed, self.flags = QPushButton(), QPushButton()
        for one in (self.failed, self.flags):
            one.setFlat(True)
            one.setProperty("link", True)
        self.said = QLabel()
        self.said.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.said.setTextFormat(Qt.TextFormat.PlainText)
        self.machine = style.labelled("", "small")
        row = QWidget()
        inner = QHBoxLayout(row)
        inner.setContentsMargins(10, 0, 10, 0)
        inner.setSpacing(14)
        for widget in (self.now, self.failed, self.flags):
            inner.addWidget(widget)
        inner.addWidget(self.said, 1)
        inner.addWidget(self.machine)
        self.addWidget(row, 1)
        self.failed.clicked.connect(lambda: self.pageAsked.emit("problems"))
        self.flags.clicked.connect(lambda: self.pageAsked.emit("flags"))
        self._quiet = QTimer(self, singleShot=True, interval=8000)
        self._quiet.timeout.connect(lambda: self.said.setText(""))
        self._soon = QTimer(self, singleShot=True, interval=60)
        self._soon.timeout.connect(self.refresh)
        self._clock = QTimer(self, interval=1000)
        self._clock.timeout.connect(self._machine)
        self._clock.start()
        session.stateChanged.connect(lambda _: self._later())
        session.networkChanged.connect(self._later)
        session.waveDone.connect(lambda _: self._later())
        session.message.connect(self.say)
        self.refresh()
        self._machine()

    def _later(self) -> None:
        if not self._soon.isActive():
            self._soon.start()

    def say(self, kind: str, words: str) -> None:
        """A sentence; what went wrong stays longer."""
        style.marked(self.said, "kind", {"error": "failed", "warning": "flag"}.get(kind, "quiet"))
        self.said.setText(words)
        self.said.setToolTip(words)
        self._quiet.start(20000 if kind == "error" else 8000)

    def refresh(self) -> None:
        """What runs and what failed."""
        busy = self.session.runs.busy
        self.now.setText(self._running(busy) if busy else "Frozen" if self.session.frozen else "Ready")
        failed = [n for n in self.session.network.nodes if self.session.state(n).kind == "failed"]
        self.failed.setVisible(bool(failed))
        self.failed.setText(f"{len(failed)} failed")
        self.failed.setToolTip(f"{', '.join(failed[:4])}: click for what went wrong" if failed else "")

    def _running(self, busy: tuple[str, ...]) -> str:
        progress = self.session.state(busy[0]).progress
        return f"{busy[0]} {progress:.0%}" if progress else f"{busy[0]} runs"

    def tell_flags(self, count: int) -> None:
        """How many flags there are."""
        self.flags.setVisible(count > 0)
        self.flags.setIcon(icons.icon("flag", "flag"))
        self.flags.setText(numbers.plural(count, "flag"))

    def _machine(self) -> None:
        results = self.session.runs.results
        parts = [f"{numbers.plural(self.session.runs.worker.engine.workers, 'thread')}"]
        parts.append(f"cache {results.bytes / (1 << 20):.0f} MB of {results.bound / GIGA:.1f} GB")
        log = self.session.log
        if log is not None and log.written:
            parts.append(f"recovery log written {_ago(time.monotonic() - log.written)} ago")
        self.machine.setText("     ".join(parts))


class Overall(QWidget):
    """How far the network is, at the right of the tool bar."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self.bar = QProgressBar()
        self.bar.setTextVisible(False)
        self.bar.setFixedWidth(140)
        self.words = style.labelled("", "quiet")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 6, 0)
        row.setSpacing(10)
        row.addWidget(self.bar)
        row.addWidget(self.words)
        self._timer = QTimer(self, singleShot=True, interval=200)
        self._timer.timeout.connect(self.refresh)
        session.stateChanged.connect(lambda _: None if self._timer.isActive() else self._timer.start())
        session.waveDone.connect(lambda _: self.refresh())
        self._other = ("", 0.0)
        self.refresh()

    def tell(self, words: str, fraction: float) -> None:
        """Other work than that of nodes: kernels are compiled; "" when it is done."""
        self._other = (words, fraction)
        self.refresh()

    def refresh(self) -> None:
        """Show it while something runs."""
        busy = self.session.runs.busy
        words, fraction = self._other
        if busy:
            done, whole = self.session.runs.progress
            words = f"{done} of {whole} done, {busy[0]}"
            fraction = done / max(1, whole)
        for part in (self.bar, self.words):
            part.setVisible(bool(words))
        self.words.setText(words if len(words) <= LONGEST else words[: LONGEST - 1] + "…")
        self.words.setToolTip(words)
        self.bar.setValue(round(100 * fraction))


def _ago(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
