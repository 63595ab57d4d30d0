"""The window: actions from one table, files opened and dropped, the guard of unsaved changes, no stall under load."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

from app import paths, theme
from app.engine.catalogue import Catalogue, mine
from app.gui import dropping, style
from app.gui.actions import ACTIONS, MENUS, TOOLBAR, WORDED, by_id
from app.gui.main_window import MainWindow
from app.gui.palette import Palette
from app.gui.raw_dialog import ReadRaw
from app.gui.session import Session
from modules.api import EXACT, Samples, Value, modeller, reader


@pytest.fixture(autouse=True)
def own_settings(tmp_path: Path, qapp: Any) -> None:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))


@pytest.fixture
def window(session_of: Callable[..., Session], qtbot: Any) -> Iterator[MainWindow]:
    style.choose("dark")
    made = MainWindow(session_of(mine()))
    made.resize(1200, 800)
    made.show()
    yield made
    made.session.history.saved()
    made.close()
    made.deleteLater()


# --- actions


def test_every_action_is_done_by_a_command_and_stands_in_a_menu(window: MainWindow) -> None:
    for action in ACTIONS:
        assert callable(getattr(window.commands, action.id))
        assert action.menu in MENUS
        assert window.made[action.id] in window.menus[action.menu].actions()
    assert {name for name in TOOLBAR if name != "|"} | set(WORDED) <= set(by_id())


def test_no_key_is_given_twice(window: MainWindow) -> None:
    keys = Counter(QKeySequence(a.key).toString() for a in ACTIONS if a.key)
    assert not [key for key, n in keys.items() if n > 1]
    assert not [a.id for a in ACTIONS if a.key and QKeySequence(a.key).isEmpty()]


def test_what_cannot_be_done_is_grey(window: MainWindow) -> None:
    assert not window.made["undo"].isEnabled() and not window.made["fire"].isEnabled()
    session = window.session
    session.edit("Add", session.network.add("interpolate", session.catalogue, id="model"))
    session.select(["model"])
    assert window.made["fire"].isEnabled()
    assert window.made["undo"].text() == "Undo “Add”"


def test_the_palette_finds_and_does(window: MainWindow, qtbot: Any) -> None:
    palette = Palette(window)
    palette.show()
    QTest.keyClicks(palette.field, "light")
    assert palette.list.count() >= 1
    palette.fill("light")
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert style.present().name == "light"
    style.choose("dark")


# --- looks


@pytest.mark.parametrize("name", ["light", "dark"])
def test_a_theme_is_made_of_roles_alone(qapp: Any, name: str) -> None:
    sheet = style.sheet(theme.theme(name))
    assert "$" not in sheet
    assert theme.theme(name)["panel"] in sheet


def test_there_is_no_colour_in_the_window_but_by_its_role() -> None:
    import re

    folder = paths.HERE / "gui"
    for file in folder.rglob("*.py"):
        assert not re.findall(r"#[0-9A-Fa-f]{6}\b", file.read_text("utf-8")), file.name


def test_every_named_icon_is_there() -> None:
    folder = paths.data("resources") / "icons"
    for action in ACTIONS:
        assert not action.icon or (folder / f"{action.icon}.svg").is_file()


# --- files


def test_the_title_shows_the_file_and_a_dot_for_changes(window: MainWindow, tmp_path: Path) -> None:
    session = window.session
    session.edit("Add", session.network.add("interpolate", session.catalogue, id="model"))
    assert window.windowTitle().startswith("New network •")
    session.save(tmp_path / "mine.json")
    assert window.windowTitle().startswith("mine.json –")
    window.commands.open_path(tmp_path / "mine.json")
    assert tmp_path / "mine.json" in window.commands.recent()


def test_a_file_that_cannot_be_opened_says_why_and_keeps_the_network(window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    (tmp_path / "bad.json").write_text("{", "utf-8")
    with qtbot.waitSignal(window.session.message) as said:
        window.commands.open_path(tmp_path / "bad.json")
    assert said.args[0] == "error"
    assert window.status.said.text()


@pytest.mark.parametrize(("answer", "stays"), [("Discard", False), ("Cancel", True)])
def test_unsaved_changes_are_asked_about(window: MainWindow, monkeypatch: pytest.MonkeyPatch, answer: str, stays: bool) -> None:
    session = window.session
    session.edit("Add", session.network.add("interpolate", session.catalogue, id="model"))

    def choose(box: QMessageBox) -> int:
        next(b for b in box.buttons() if b.text() == answer).click()
        return 0

    monkeypatch.setattr(QMessageBox, "exec", choose)
    window.commands.new()
    assert bool(session.network.nodes) is stays


def test_data_that_are_dropped_are_read_modelled_and_drawn(window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    y, x = np.mgrid[-1:1:17j, -1:1:17j]
    np.save(tmp_path / "heights.npy", np.exp(-3 * (x**2 + y**2)))
    window.take([tmp_path / "heights.npy"])
    qtbot.waitUntil(lambda: bool(window.session.network.nodes), timeout=10000)
    session = window.session
    (view,) = session.views()
    qtbot.waitUntil(lambda: session.outputs(view) is not None, timeout=60000)
    qtbot.waitUntil(lambda: window.views.panes[0].back.tag is not None, timeout=60000)
    assert window.stack.currentWidget() is window.work


def test_what_a_file_states_of_its_errors_is_drawn(window: MainWindow, qtbot: Any) -> None:
    """NetCDF with a standard error: contour lines, where they may lie, and a budget of instrument, grid and method."""
    window.take([Path(__file__).resolve().parents[2] / "networks" / "data" / "sea-surface.nc"])
    qtbot.waitUntil(lambda: bool(window.session.network.nodes), timeout=10000)
    session = window.session
    (view,) = session.views()
    qtbot.waitUntil(lambda: session.outputs(view) is not None, timeout=120000)
    assert {n.module for n in session.network.nodes.values()} >= {"readers.gridded.gridded", "accuracy_mappers.band.band"}
    (contour,) = (n for n in session.network.nodes if n.startswith("contour"))
    named = {t.name for t in (session.outputs(contour) or {})["lines"].accuracy.terms}
    assert {"Altimeter, random noise", "Interpolation between samples", "Two chords a cell"} <= named


def test_soundings_are_brought_to_a_grid(window: MainWindow, qtbot: Any) -> None:
    """A table of scattered points: kriging, depth lines and where they may lie."""
    window.take([Path(__file__).resolve().parents[2] / "networks" / "data" / "soundings.csv"])
    qtbot.waitUntil(lambda: bool(window.session.network.nodes), timeout=10000)
    session = window.session
    (view,) = session.views()
    qtbot.waitUntil(lambda: session.outputs(view) is not None, timeout=120000)
    modules = {n.module for n in session.network.nodes.values()}
    assert {"readers.scattered.scattered", "modellers.grid_points.grid_points", "accuracy_mappers.band.band"} <= modules


def test_plain_numbers_are_read_as_the_user_says(window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    """A file without a header: what fits is offered and shown, what does not is told, and the reader gets what was said."""
    z, y, x = np.mgrid[:12, :64, :64]
    (np.hypot(x - 32.0, y - 20.0) + z).astype("<u2").tofile(tmp_path / "ball.raw")
    window.take([tmp_path / "ball.raw"])
    qtbot.waitUntil(lambda: bool(window.findChildren(ReadRaw)), timeout=10000)
    (dialog,) = window.findChildren(ReadRaw)
    qtbot.waitUntil(lambda: dialog.size_.text() == "64, 64, 12", timeout=10000)
    assert dialog.choices["type"].currentText() == "uint16", "the smoothest of the shapes that fit"
    dialog.size_.setText("64, 64, 13")
    qtbot.waitUntil(lambda: "need" in dialog.told.text(), timeout=10000)
    assert not dialog.read.isEnabled()
    dialog.size_.setText("64, 64, 12")
    qtbot.waitUntil(lambda: dialog.read.isEnabled(), timeout=10000)
    assert dialog.told.text().startswith("64 × 64 × 12 samples") and not dialog.picture.pixmap().isNull()
    qtbot.mouseClick(dialog.read, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: bool(window.session.network.nodes), timeout=10000)
    raw = next(n for n in window.session.network.nodes.values() if n.module == "readers.raw.raw")
    assert raw.parameters["size"] == (64, 64, 12) and raw.parameters["type"] == "uint16"


def test_files_of_one_series_become_one_reader(window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    for i in range(3):
        np.save(tmp_path / f"h_{i}.npy", np.random.default_rng(i).normal(size=(9, 9)))
    window.take([tmp_path / f"h_{i}.npy" for i in range(3)])
    qtbot.waitUntil(lambda: bool(window.session.network.nodes), timeout=10000)
    readers = [n.module for n in window.session.network.nodes.values() if n.module.startswith("readers.")]
    assert readers == ["readers.series.series"]


@pytest.mark.parametrize(("name", "data", "words"), [
    ("a.nc", b"no data", "neither NetCDF nor HDF5"), ("a.npy", b"no data", "damaged"),
    ("a.what", b"no data", "no reader takes files"),
])  # fmt: skip
def test_a_broken_file_is_spoken_of_by_the_reader_of_its_kind(
    window: MainWindow, tmp_path: Path, qtbot: Any, name: str, data: bytes, words: str
) -> None:
    (tmp_path / name).write_bytes(data)
    with qtbot.waitSignal(window.session.message, timeout=10000) as said:
        window.take([tmp_path / name])
    assert words in said.args[1]


def test_a_file_that_nobody_reads_says_so(window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    (tmp_path / "what.thing").write_bytes(b"\0" * 16)
    with qtbot.waitSignal(window.session.message, timeout=10000) as said:
        window.take([tmp_path / "what.thing"])
    assert said.args[0] == "error" and "what.thing" in said.args[1]


def test_networks_and_our_pictures_are_opened(made: Path) -> None:
    assert dropping.is_network(made / "peak.json") and dropping.is_network(made / "peak.png")
    assert not dropping.is_network(made / "heights.npy")


def test_a_network_from_a_picture_opens_frozen(window: MainWindow, made: Path, qtbot: Any) -> None:
    said: list[str] = []
    window.session.message.connect(lambda kind, words: said.append(words))
    window.commands.open_path(made / "peak.png")
    assert window.session.frozen and window.session.path is None
    assert any("reads" in words for words in said)
    qtbot.wait(50)
    assert not window.session.runs.busy


# --- the command line


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
@pytest.mark.parametrize("words", [[], ["gui"], ["gui", "jacksboro"]])
def test_without_a_display_the_window_is_refused_in_a_sentence(
    nonius: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, words: list[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    said = nonius(*words)
    assert said.code == 2
    assert "no display" in said.err and "nonius run" in said.err


# --- load

SIDE = 256


@reader("Volume", output="samples")
def volume() -> Samples:
    """A field of 256 x 256 x 256.

    Accuracy: exact.
    """
    z = np.linspace(0, 1, SIDE, dtype=np.float32)
    return Samples.from_array(z[:, None, None] * z[None, :, None] + z[None, None, :], name="field", accuracy=EXACT)


@modeller("Sum", output="value", independent={"value": ("samples",)})
def total(samples: Samples) -> Value:
    """Its sum.

    Accuracy: exact.
    """
    values = np.asarray(samples.values)
    for _ in range(4):
        found = float(np.sqrt(values**2 + 1.0).sum())
    return Value(value=found, accuracy=EXACT)


def test_a_large_field_is_processed_without_a_stall(session_of: Callable[..., Session], qtbot: Any, stalls: Any) -> None:
    catalogue = Catalogue.of([volume, total])
    session = session_of(catalogue)
    window = MainWindow(session)
    qtbot.addWidget(window)
    window.show()
    network = session.network.add("volume", catalogue, id="volume").add("total", catalogue, id="total")
    session.edit("Add", network.connect("volume", "samples", "total", "samples", catalogue))
    qtbot.wait(300)
    with stalls() as worst:
        session.run_all()
        qtbot.waitUntil(lambda: session.state("total").kind == "clean", timeout=60000)
    session.history.saved()
    window.shut()
    assert worst() < 0.05
