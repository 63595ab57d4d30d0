"""The sequencer in the window: play shows one frame after the other, is one step of undo, and exports pictures and a film."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pytestqt.qtbot import QtBot

from app.engine.sequence import SETTING
from app.gui.main_window import MainWindow
from app.gui.sequence_page import SequencePage
from app.gui.session import Session

FORMULA = "readers.analytic.analytic"


@pytest.fixture
def playing(session_of: Callable[..., Session], qtbot: QtBot) -> Any:
    session = session_of()
    network = session.network.add(FORMULA, session.catalogue, id="wave", parameters={"formula": "x + t", "samples": (4, 4)})
    session.edit("Add", network)
    page = SequencePage(session)
    qtbot.addWidget(page)
    return session, page


def test_play_runs_through_the_values_and_is_one_step_of_undo(playing: Any, qtbot: QtBot) -> None:
    session, page = playing
    page.parameter.setCurrentText("wave.time")
    page.parameter.activated.emit(0)
    page.values.setText("0..0.5/6")
    page.values.editingFinished.emit()
    assert session.network.settings[SETTING] == "wave.time=0..0.5/6" and page.count == 6
    session.observe("test", ["wave"])
    seen: list[float] = []
    session.networkChanged.connect(lambda: seen.append(session.network["wave"].parameters.get("time", -1.0)))
    page.fps.setValue(60)
    page.toggle()
    qtbot.waitUntil(lambda: not page.playing, timeout=20_000)
    assert list(dict.fromkeys(seen)) == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    qtbot.waitUntil(lambda: session.state("wave").kind in ("clean", "cached"), timeout=10_000)
    assert session.outputs("wave")["samples"].time == 0.5, "the last frame is never lost"
    session.undo()
    assert "time" not in session.network["wave"].parameters or session.network["wave"].parameters["time"] in (None, 0.0)
    assert session.network.settings[SETTING]
    session.undo()
    session.undo()
    assert not session.network.settings.get(SETTING)


def test_step_stop_and_what_cannot_run(playing: Any) -> None:
    session, page = playing
    session.edit("Set", session.network.settle(**{SETTING: "wave.time=1, 2, 5"}))
    page.step(1)
    assert session.network["wave"].parameters["time"] == 1.0
    page.step(-1)
    assert session.network["wave"].parameters["time"] == 5.0 and "Frame 3 of 3" in page.words.text()
    page.step(1)
    assert session.network["wave"].parameters["time"] == 1.0
    page.toggle()
    assert page.playing and page.buttons["Play"].text() == "Stop"
    page.toggle()
    assert not page.playing
    session.edit("Set", session.network.settle(**{SETTING: "wave.samples=many, few"}))
    assert not page.count and "samples" in page.words.text() and not page.buttons["Play"].isEnabled()
    session.edit("Remove", session.network.remove("wave"))
    assert not page.count and "wave" in page.words.text()


@pytest.mark.usefixtures("little_pictures")
def test_frames_are_exported_with_certificates_and_a_film(
    session_of: Callable[..., Session], qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.gui import film

    session = session_of()
    network = session.network.add(FORMULA, session.catalogue, id="wave", parameters={"formula": "x + t*y", "samples": (4, 4)})
    for module, name, port, origin in (
        ("renderers.image.image", "image", "samples", ("wave", "samples")),
        ("renderers.view.view", "view", "layers", ("image", "layer")),
    ):
        network = network.add(module, session.catalogue, id=name).connect(*origin, name, port, session.catalogue)
    window = MainWindow(session)
    qtbot.addWidget(window)
    session.edit("Add", network.settle(**{SETTING: "wave.time=0, 1"}))
    said: list[str] = []
    session.message.connect(lambda kind, words: said.append(words))
    film.Film(window, "view", tmp_path / "sweep.png", 4)
    qtbot.waitUntil(lambda: any("Saved 2 frames" in s for s in said), timeout=60_000)
    told = json.loads((tmp_path / "sweep.frames.json").read_text("utf-8"))
    assert [f["set"] for f in told["pictures"]] == [{"wave.time": 0.0}, {"wave.time": 1.0}]
    assert (tmp_path / "sweep-001.png").read_bytes() != (tmp_path / "sweep-002.png").read_bytes()
    assert (tmp_path / "sweep-002.accuracy.json").is_file() and (tmp_path / "sweep.apng").is_file()
    session.history.saved()
    window.shut()
