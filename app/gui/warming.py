"""Kernels are compiled in a child process, with progress; it can be stopped at any time.

The compiler holds the interpreter for seconds. So a module that needs a kernel which is not compiled waits, in its own
thread, until the child has done that one, which then comes first.
"""

from __future__ import annotations

import sys
import threading

from PySide6.QtCore import QObject, QProcess, Signal

from app.commands.warm import CHILD
from modules import kernels
from modules.kernels import _jit

LOOK = 0.02
"""Seconds between two looks at what has been compiled."""


class Warming(QObject):
    """The child; `progress` gives (words, fraction), "" at the end."""

    progress = Signal(str, float)
    _asked = Signal(str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._child: QProcess | None = None
        self._over = threading.Event()
        self._first: list[str] = []
        self._asked.connect(self._ask)
        if _jit.cache_folder() is not None and not _jit.is_warm():
            kernels.before_loading.append(self.wait)

    def begin(self) -> None:
        """Compile what is not compiled."""
        if self._child is not None or self._over.is_set():
            return
        if _jit.is_warm() or _jit.cache_folder() is None:
            self._end()
            return
        self._child = child = QProcess(self)
        child.readyReadStandardOutput.connect(self._read)
        child.started.connect(self._tell)
        child.finished.connect(lambda *_: self._end())
        child.errorOccurred.connect(lambda *_: self._end())
        child.start(sys.executable, ["-c", CHILD.format(path=sys.path)])
        self.progress.emit("Compiling the kernels, once", 0.0)

    def wait(self, name: str) -> None:
        """Wait until the child has compiled a kernel file, or has ended; from any thread but the window's."""
        if threading.current_thread() is threading.main_thread():
            return
        self._asked.emit(name)
        while not (_jit.is_warm(name) or self._over.wait(LOOK)):
            pass

    def _ask(self, name: str) -> None:
        self._first.append(name)
        self.begin()
        self._tell()

    def _tell(self) -> None:
        if self._child is not None and self._child.state() == QProcess.ProcessState.Running:
            self._child.write("".join(f"{name}\n" for name in self._first).encode())
            self._first.clear()

    def _read(self) -> None:
        if self._child is None:
            return
        for line in bytes(self._child.readAllStandardOutput().data()).decode("utf-8", "replace").splitlines():
            fraction, _, name = line.partition(" ")
            try:
                self.progress.emit(f"Compiling the kernels, once: {name}", float(fraction))
            except ValueError:
                continue

    def _end(self) -> None:
        if self._over.is_set():
            return
        self._over.set()
        if self.wait in kernels.before_loading:
            kernels.before_loading.remove(self.wait)
        self.progress.emit("", 1.0)

    def close(self) -> None:
        """Stop it."""
        child, self._child = self._child, None
        self._end()
        if child is not None:
            child.kill()
            child.waitForFinished(2000)
