"""What the tests of the window share: modules without science, a session, the real catalogue."""

import os
import sys

if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the program remembers, in a folder of the test."""
    folder = tmp_path / "state"
    monkeypatch.setenv("NONIUS_STATE", str(folder))
    return folder


@pytest.fixture
def session_of(qapp: object) -> Iterator[Callable[..., object]]:
    """Makes sessions and closes them after the test."""
    from app.gui.session import Session

    made: list[Session] = []

    def make(*words: object, **options: object) -> Session:
        made.append(Session(*words, **options))  # type: ignore[arg-type]
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def stalls(qapp: object) -> Callable[[], object]:
    """Measures the longest time in which the event loop did nothing: `with stalls() as worst: ...; worst()`."""
    import time
    from contextlib import contextmanager

    from PySide6.QtCore import QTimer

    @contextmanager
    def measure() -> Iterator[Callable[[], float]]:
        last = [time.perf_counter(), 0.0]

        def tick() -> None:
            now = time.perf_counter()
            last[1] = max(last[1], now - last[0])
            last[0] = now

        timer = QTimer(interval=1)
        timer.timeout.connect(tick)
        timer.start()
        try:
            yield lambda: last[1]
        finally:
            timer.stop()

    return measure
