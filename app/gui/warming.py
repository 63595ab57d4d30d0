"""Kernels are compiled in a child process at the first start, with progress; it can be stopped at any time."""

from __future__ import annotations

import sys

from PySide6.QtCore import QObject, QProcess, Signal

from app.commands.warm import CHILD
from modules.kernels import _jit


class Warming(QObject):
    """The child; `progress` gives (words, fraction), "" at the end."""

    progress = Signal(str, float)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._child: QProcess | None = None

    def begin(self) -> None:
        """Compile what is not compiled."""
        if _jit.is_warm() or _jit.cache_folder() is None:
            return
        self._child = child = QProcess(self)
        child.readyReadStandardOutput.connect(self._read)
        child.finished.connect(lambda *_: self.progress.emit("", 1.0))
        child.start(sys.executable, ["-c", CHILD.format(path=sys.path)])
        self.progress.emit("Compiling the kernels, once", 0.0)

    def _read(self) -> None:
        if self._child is None:
            return
        for line in bytes(self._child.readAllStandardOutput().data()).decode("utf-8", "replace").splitlines():
            fraction, _, name = line.partition(" ")
            try:
                self.progress.emit(f"Compiling the kernels, once: {name}", float(fraction))
            except ValueError:
                continue

    def close(self) -> None:
        """Stop it."""
        if self._child is not None:
            self._child.kill()
            self._child.waitForFinished(2000)
            self._child = None
