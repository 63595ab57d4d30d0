"""The threads behind the window: one that runs networks, one that looks at what is known of results."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import QObject, QThread, Signal

from app.engine.events import Done, Event
from app.engine.executor import Engine
from app.engine.network import Network

KEPT = 64
"""Networks that were asked for of which the place in the row of edits is remembered."""


@dataclass(frozen=True)
class Told:
    """An event, the number of the edit whose network it is about, and at the end of a wave the keys of all nodes."""

    event: Event
    serial: int
    keys: Mapping[str, str] = field(default_factory=dict)


class Worker(QThread):
    """Iterates the engine's events and hands them over in batches; `arrived` is emitted once for each batch."""

    arrived = Signal()

    def __init__(self, engine: Engine, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("nonius-engine")
        self.engine = engine
        self._asked: deque[tuple[Network, int]] = deque(maxlen=KEPT)
        self._box: list[Told] = []
        self._lock = threading.Lock()

    def want(self, network: Network, wanted: Iterable[str], interim: bool, serial: int) -> None:
        """Ask for results of a network; `serial` comes back with what happens to it."""
        with self._lock:
            self._asked.append((network.around, serial))
        self.engine.want(network, wanted, interim)

    def take(self) -> list[Told]:
        """What has happened since the last time."""
        with self._lock:
            taken, self._box = self._box, []
        return taken

    def run(self) -> None:
        """What the thread does."""
        wave, serial = 0, 0
        for event in self.engine.events():
            if event.wave != wave:
                wave, serial = self._place(event.wave, wave, serial)
            now = self.engine.wave if isinstance(event, Done) else None
            keys = now.keys if now is not None and now.number == event.wave else {}
            with self._lock:
                first = not self._box
                self._box.append(Told(event, serial, keys))
            if first:
                self.arrived.emit()

    def _place(self, number: int, wave: int, serial: int) -> tuple[int, int]:
        """(number of the wave, number of the edit that it is about); as before while its files are still digested."""
        now = self.engine.wave
        if now is None or now.number != number:
            return wave, serial
        with self._lock:
            return number, next((s for n, s in reversed(self._asked) if n is now.want.network), serial)

    def close(self) -> None:
        """Stop the work and the thread."""
        self.engine.close()
        self.wait(5000)


class Looker(QThread):
    """Evaluates budgets and reads files outside the window's thread; what was asked for last comes first.

    `ready` is emitted with the key of each answer.
    """

    ready = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("nonius-looks")
        self._jobs: dict[Hashable, Callable[[], Any]] = {}
        self._answers: dict[Hashable, Any] = {}
        self._some = threading.Condition()
        self._closed = False

    def ask(self, key: Hashable, job: Callable[[], Any]) -> Any:
        """The answer if it is there; else None, and the job is done soon."""
        with self._some:
            if key in self._answers:
                return self._answers[key]
            if key not in self._jobs and not self._closed:
                self._jobs[key] = job
                self._some.notify()
        if not self.isRunning():
            self.start()
        return None

    def has(self, key: Hashable) -> bool:
        """Whether the answer is there."""
        return key in self._answers

    def forget(self) -> None:
        """Answers and questions of a document that was closed."""
        with self._some:
            self._jobs.clear()
            self._answers.clear()

    def run(self) -> None:
        """What the thread does."""
        while True:
            with self._some:
                while not self._jobs and not self._closed:
                    self._some.wait()
                if self._closed:
                    return
                key, job = next(reversed(self._jobs.items()))
            try:
                answer = job()
            except Exception as error:
                answer = error
            with self._some:
                wanted = self._jobs.pop(key, None) is not None
                if wanted:
                    self._answers[key] = answer
                    while len(self._answers) > 2000:
                        self._answers.pop(next(iter(self._answers)))
            if wanted:
                self.ready.emit(key)

    def close(self) -> None:
        """End the thread."""
        with self._some:
            self._closed = True
            self._jobs.clear()
            self._some.notify()
        self.wait(5000)
