"""A killed process loses at most its last second; the file of the user is never touched."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.engine.catalogue import Catalogue
from app.gui.recovery import Log, lost
from app.gui.session import Session
from modules.api import EXACT, Value, reader


@reader("Number", output="value")
def number(*, number: float = 1.0) -> Value:
    """A number.

    Accuracy: exact.
    """
    return Value(value=number, accuracy=EXACT)


CATALOGUE = Catalogue.of([number])

CHILD = """
import sys, time
sys.path[:] = {path!r}
from PySide6.QtCore import QCoreApplication
from app.gui.session import Session
from app.gui.recovery import Log
from app.engine.catalogue import Catalogue
catalogue = Catalogue.load()
app = QCoreApplication([])
session = Session(catalogue, log=Log(catalogue))
session.open({file!r})
print("ready", flush=True)
i = 0
while True:
    i += 1
    session.edit("Set count", session.network.set("field", "noise", float(i), catalogue))
    print(i, flush=True)
    app.processEvents()
    time.sleep(0.02)
"""


@pytest.mark.parametrize("after", [0.7, 1.3])
def test_a_killed_process_loses_at_most_its_last_second(after: float, tmp_path: Path, own_state: Path) -> None:
    file = tmp_path / "mine.json"
    field = '{"id": "field", "module": "readers.analytic.analytic", "version": 1, "parameters": {}}'
    file.write_text(f'{{"format": "nonius-network", "schema": 1, "nodes": [{field}], "wires": []}}', "utf-8")
    before = file.read_bytes()
    code = CHILD.format(path=[p for p in sys.path if p], file=str(file))
    env = {**os.environ, "NONIUS_STATE": str(own_state), "QT_QPA_PLATFORM": "offscreen"}
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=env)
    assert child.stdout is not None
    assert child.stdout.readline().strip() == "ready"
    stamps: list[tuple[float, int]] = []
    end = time.monotonic() + after
    while time.monotonic() < end:
        stamps.append((time.monotonic(), int(child.stdout.readline())))
    child.send_signal(signal.SIGKILL)
    killed = time.monotonic()
    child.wait()
    child.stdout.close()
    assert file.read_bytes() == before
    (one,) = lost()
    assert one.path == file
    found = one.network(Catalogue.load())["field"].parameters["noise"]
    assert found >= max((i for at, i in stamps if at < killed - 1.0), default=0)
    one.discard()
    assert lost() == []


def test_a_closed_window_leaves_nothing(session_of: Callable[..., Session], own_state: Path) -> None:
    log = Log(CATALOGUE)
    session = session_of(CATALOGUE, log=log)
    session.edit("Add", session.network.add("number", CATALOGUE))
    assert log.flush()
    assert log.file.exists()
    assert lost() == []  # the window is open: it is not offered to another
    session.close()
    assert not log.file.exists()
    assert lost() == []


def test_a_saved_document_needs_no_recovery(session_of: Callable[..., Session], tmp_path: Path) -> None:
    log = Log(CATALOGUE)
    session = session_of(CATALOGUE, log=log)
    session.edit("Add", session.network.add("number", CATALOGUE))
    log.flush()
    session.save(tmp_path / "a.json")
    log.flush()
    assert not log.file.exists()


def test_a_line_that_was_being_written_is_passed_over(own_state: Path) -> None:
    folder = own_state / "recovery"
    folder.mkdir(parents=True)
    whole = '{"at": 1.0, "label": "Add", "edits": 2, "path": null, "network": "text"}\n'
    (folder / "1-1.jsonl").write_text(whole + '{"at": 2.0, "lab', "utf-8")
    (folder / "1-2.jsonl").write_text('{"at"', "utf-8")
    (one,) = lost()
    assert (one.text, one.edits, one.name) == ("text", 2, "an unsaved network")


def test_what_was_lost_is_restored_as_unsaved(session_of: Callable[..., Session], qtbot: Any, own_state: Path) -> None:
    from app.gui.main_window import MainWindow

    folder = own_state / "recovery"
    folder.mkdir(parents=True)
    writer = session_of(CATALOGUE, log=(log := Log(CATALOGUE)))
    writer.edit("Add", writer.network.add("number", CATALOGUE, parameters={"number": 5.0}))
    log.flush()
    kept = log.file.read_bytes()
    writer.close()
    (folder / "1-1.jsonl").write_bytes(kept)
    session = session_of(CATALOGUE)
    window = MainWindow(session, lost())
    qtbot.addWidget(window)
    window.restore(window.first.lost[0], frozen=True)
    assert session.network["number-1"].parameters["number"] == 5.0
    assert session.frozen and session.modified
    assert lost() == []
    session.history.saved()
    window.shut()
