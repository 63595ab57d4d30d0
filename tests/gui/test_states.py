"""Bypass, disable and problems, driven through the window: menus, keys, lists that lead to their node."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from app.engine.catalogue import Catalogue
from app.gui import style
from app.gui.main_window import MainWindow
from app.gui.run_section import FailureCard
from app.gui.session import Session
from modules.api import EXACT, Table, Value, modeller, reader


@reader("Number", output="value")
def number(*, amount: float = 2.0) -> Value:
    """A number.

    Accuracy: exact.
    """
    return Value(value=amount, accuracy=EXACT)


@modeller("Double", output="value", independent={"value": ("value",)})
def double(value: Value) -> Value:
    """Twice as much.

    Accuracy: exact.
    """
    assert isinstance(value.value, float)
    return Value(value=2 * value.value, accuracy=EXACT)


@modeller("Row", output="table", independent={"table": ("value",)})
def row(value: Value, *, least: float = 0.0) -> Table:
    """A table of one number.

    Accuracy: exact.
    """
    assert isinstance(value.value, float)
    if value.value < least:
        raise ValueError(f"{value.value} is less than {least}: lower the least")
    return Table(columns={"value": np.array([value.value])}, accuracy=EXACT)


@modeller("Slow", output="value", independent={"value": ("value",)})
def slow(value: Value) -> Value:
    """The same, late: it does not look whether it is stopped.

    Accuracy: exact.
    """
    begun.append(1)
    time.sleep(0.4)
    return Value(value=value.value, accuracy=EXACT)


begun: list[int] = []
CATALOGUE = Catalogue.of([number, double, row, slow])


@pytest.fixture
def window(session_of: Callable[..., Session], qtbot: Any, tmp_path: Path) -> Iterator[MainWindow]:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    style.choose("dark")
    session = session_of(CATALOGUE)
    made = MainWindow(session)
    made.resize(1200, 800)
    made.show()
    network = session.network
    for i, name in enumerate(("number", "double", "row")):
        network = network.add(name, CATALOGUE, id=name, view={"position": [226.0 * i, 0.0]})
    network = network.connect("number", "value", "double", "value", CATALOGUE)
    session.edit("Build", network.connect("double", "value", "row", "value", CATALOGUE))
    session.run_all()
    qtbot.waitUntil(lambda: session.state("row").kind == "clean", timeout=10000)
    made.activateWindow()
    yield made
    session.history.saved()
    made.close()
    made.deleteLater()


def given(window: MainWindow) -> float:
    return float((window.session.outputs("row") or {})["table"].columns["value"][0])


def test_a_bypassed_node_passes_on_and_is_undone(window: MainWindow, qtbot: Any) -> None:
    session = window.session
    assert given(window) == 4.0
    session.select(["double"])
    session.observe("test", ["row"])
    window.made["bypass"].trigger()
    assert session.state("double").kind == "bypassed" and window.canvas.board.nodes["double"].kind == "bypassed"
    qtbot.waitUntil(lambda: session.state("row").kind == "clean" and not session.stale("row"), timeout=10000)
    assert given(window) == 2.0
    session.undo()
    qtbot.waitUntil(lambda: not session.stale("row"), timeout=10000)
    assert given(window) == 4.0 and session.state("double").kind in ("clean", "cached")


def test_a_node_that_cannot_be_bypassed_says_why(window: MainWindow, qtbot: Any) -> None:
    window.session.select(["row"])
    before = window.session.network
    with qtbot.waitSignal(window.session.message) as said:
        window.made["bypass"].trigger()
    assert said.args[0] == "error" and "takes a Value and gives a Table" in said.args[1]
    assert window.session.network is before


def test_the_panel_bypasses(window: MainWindow) -> None:
    window.session.select(["double"])
    section = window.panel._run
    assert section is not None
    QTest.mouseClick(section.past, Qt.MouseButton.LeftButton)
    assert window.session.network["double"].passes and section.past.text() == "Let fire"
    assert "bypassed" in section.state.text()


def test_a_problem_is_listed_with_its_inputs_and_leads_to_its_node(window: MainWindow, qtbot: Any) -> None:
    session, page = window.session, window.pages.problems
    assert page.count == 0 and not page.empty.isHidden()
    session.select(["row"])
    session.edit("Set", session.network.set("row", "least", 10.0, CATALOGUE))
    qtbot.waitUntil(lambda: page.count == 1, timeout=10000)
    session.select(())
    window.commands("problems")
    assert window.pages.currentWidget() is page and window.pages.tabText(window.pages.indexOf(page)).endswith("1")
    item = page.list.topLevelItem(0)
    assert item is not None
    QTest.mouseClick(page.list.viewport(), Qt.MouseButton.LeftButton, pos=page.list.visualItemRect(item).center())
    assert session.selection == ("row",)
    card = page.card.widget()
    assert isinstance(card, FailureCard)
    assert "value ← double.value: Value" in card.inputs.text() and "least = 10" in card.inputs.text()
    QTest.mouseClick(card.copy, Qt.MouseButton.LeftButton)
    report = QGuiApplication.clipboard().text()
    assert "lower the least" in report and "ValueError" in report and "least = 10" in report


def test_an_entry_of_the_log_leads_to_its_node(window: MainWindow) -> None:
    log = window.pages.log
    window.commands("log")
    at = next(i for i in range(log.count()) if "double ran" in log.item(i).text())
    log.setCurrentRow(at)
    QTest.keyClick(log, Qt.Key.Key_Return)
    assert window.session.selection == ("double",)
    QTest.keyClick(log, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert "double ran" in QGuiApplication.clipboard().text()


def test_fire_while_a_stopped_firing_has_not_ended(window: MainWindow, qtbot: Any) -> None:
    session = window.session
    network = session.network.add("slow", CATALOGUE, id="slow").connect("number", "value", "slow", "value", CATALOGUE)
    session.edit("Add", network)
    begun.clear()
    session.select(["slow"])
    qtbot.waitUntil(lambda: len(begun) == 1, timeout=10000)
    session.cancel()
    qtbot.waitUntil(lambda: session.state("slow").kind == "dirty", timeout=10000)
    window.made["fire"].trigger()
    qtbot.waitUntil(lambda: session.state("slow").kind == "clean", timeout=10000)
    assert len(begun) == 2 and not session.stale("slow")
