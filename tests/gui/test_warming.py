"""A module that needs a kernel waits for the child that compiles it; the window does not."""

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.gui import warming
from app.gui.warming import Warming
from modules import kernels
from modules.kernels import _jit

CHILD = """
import pathlib, sys, time
sys.path[:] = {path}
from modules.kernels import _jit
first, second = (sys.stdin.readline().strip() for _ in range(2))
print("0.5 " + second, flush=True)
marker = _jit._marker(pathlib.Path({folder!r}), second)
marker.parent.mkdir()
marker.touch()
time.sleep(60)
"""


@pytest.fixture
def cold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, qapp: Any) -> Iterator[Warming]:
    monkeypatch.setattr(_jit, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(warming, "CHILD", CHILD.replace("{folder!r}", repr(str(tmp_path))))
    monkeypatch.setattr(kernels, "before_loading", [])
    made = Warming()
    yield made
    made.close()


def waiting(cold: Warming, name: str) -> threading.Thread:
    thread = threading.Thread(target=kernels.before_loading[0], args=(name,))
    thread.start()
    return thread


def test_who_needs_a_kernel_waits_until_the_child_has_compiled_that_one(cold: Warming, qtbot: Any) -> None:
    said: list[str] = []
    cold.progress.connect(lambda words, fraction: said.append(words))
    arcs, contour = waiting(cold, "arcs"), waiting(cold, "contour")
    qtbot.waitUntil(lambda: not (arcs.is_alive() and contour.is_alive()), timeout=20000)
    assert arcs.is_alive() or contour.is_alive(), "the other is not compiled yet"
    assert any("contour" in words or "arcs" in words for words in said)
    cold.close()
    arcs.join(5)
    contour.join(5)
    assert not arcs.is_alive() and not contour.is_alive(), "without a child they compile for themselves"
    assert kernels.before_loading == [] and said[-1] == ""


def test_the_window_itself_never_waits(cold: Warming) -> None:
    kernels.before_loading[0]("arcs")


def test_nobody_waits_where_all_is_compiled(cold: Warming, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_jit, "is_warm", lambda name="": True)
    monkeypatch.setattr(kernels, "before_loading", [])
    second = Warming()
    assert kernels.before_loading == []
    second.begin()
    assert second._child is None
