"""What the tests of the window share: modules without science, a session, the real catalogue."""

import os
import sys

if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

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


@pytest.fixture
def views(session_of: Callable[..., Any], qtbot: Any) -> Iterator[Any]:
    """The views of a new session over the real catalogue, on the screen."""
    from app.engine.catalogue import mine
    from app.gui.studio import Studio
    from app.gui.viewport_widget import Views

    session = session_of(mine())
    studio = Studio()
    made = Views(session, studio)
    qtbot.addWidget(made)
    made.resize(420, 320)
    made.show()
    yield made
    studio.close()


@pytest.fixture
def drawn(views: Any, qtbot: Any) -> Callable[..., Any]:
    """Waits until a network of modules and wires is drawn: `drawn({"id": ("module", {...})}, [("a", "b.port")])`."""

    def build(nodes: dict[str, tuple[str, dict[str, Any]]], wires: list[tuple[str, str]], timeout: int = 60000) -> Any:
        session = views.session
        catalogue, network = session.catalogue, session.network
        for name, (module, parameters) in nodes.items():
            network = network.add(module, catalogue, id=name, parameters=parameters)
        for source, end in wires:
            target, _, port = end.partition(".")
            output = catalogue[network[source].module].outputs[0].name
            network = network.connect(source, output, target, port, catalogue)
        session.edit("Add", network)
        qtbot.waitUntil(lambda: bool(views.panes) and views.panes[0].back.tag is not None, timeout=timeout)
        qtbot.waitUntil(lambda: views.panes[0].back.camera is not None, timeout=5000)
        return views

    return build


@pytest.fixture
def seen(drawn: Callable[..., Any]) -> Any:
    """A field as a surface in three dimensions."""
    nodes = {
        "field": ("readers.analytic.analytic", {"samples": (17, 17)}), "model": ("interpolate", {}),
        "up": ("mappers.elevation.elevation", {}), "surface": ("surface", {}), "view": ("view", {}),
    }  # fmt: skip
    wires = [("field", "model.samples"), ("model", "up.model"), ("up", "surface.geometry"), ("surface", "view.layers")]
    return drawn(nodes, wires)
