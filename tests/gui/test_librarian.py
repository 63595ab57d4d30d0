"""The librarian: rooms, search, examples, the user's own modules, help."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QTreeWidgetItem

from app import paths
from app.engine.catalogue import Catalogue
from app.gui.canvas import MODULE, Canvas
from app.gui.help_page import HelpPage
from app.gui.librarian import WHAT, Librarian
from app.gui.ranking import Match
from app.gui.session import Session

OWN = '''"""Mine."""
from modules.api import EXACT, Samples, reader

import numpy as np


@reader("Snow line")
def snow() -> Samples:
    """Snow.

    Accuracy: exact.
    """
    return Samples.from_array(np.zeros((2, 2)), accuracy=EXACT)
'''


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory: pytest.TempPathFactory) -> Catalogue:
    folder = tmp_path_factory.mktemp("mine")
    (folder / "snow_line.py").write_text(OWN, "utf-8")
    (folder / "my_filter.py").write_text("def broken(:\n", "utf-8")
    return Catalogue.load(folder)


@pytest.fixture
def librarian(qtbot: Any, catalogue: Catalogue) -> Iterator[Librarian]:
    session = Session(catalogue)
    session.freeze(True)
    made = Librarian(session)
    qtbot.addWidget(made)
    made.resize(224, 900)
    made.show()
    yield made
    session.close()


def heads(librarian: Librarian) -> dict[str, QTreeWidgetItem]:
    tree = librarian.tree
    found = [tree.topLevelItem(i) for i in range(tree.topLevelItemCount())]
    return {h.text(0): h for h in found if h is not None}


def under(head: QTreeWidgetItem) -> list[str]:
    return [child(head, i).text(0) for i in range(head.childCount())]


def child(head: QTreeWidgetItem, i: int) -> QTreeWidgetItem:
    found = head.child(i)
    assert found is not None
    return found


def test_modules_stand_by_room_and_examples_below(librarian: Librarian) -> None:
    found = heads(librarian)
    rooms = ["Readers", "Modellers", "Mappers", "Accuracy mappers", "Renderers"]
    assert list(found) == [*rooms, "My modules", "Example networks"]
    assert under(found["Mappers"]) == [m.title for m in librarian.session.catalogue.room("mappers")]
    assert under(found["Example networks"]) == list(paths.networks())
    assert librarian.grab().width() == 224


def test_a_broken_module_says_why(librarian: Librarian) -> None:
    mine = heads(librarian)["My modules"]
    assert under(mine) == ["Snow line", "my_filter.py"]
    assert "line 1" in child(mine, 1).toolTip(0)
    asked: list[str] = []
    librarian.brokenRequested.connect(asked.append)
    librarian._double(child(mine, 1))
    assert asked == ["my_filter.py"]


def test_search_keeps_what_is_meant_and_enter_adds(librarian: Librarian) -> None:
    asked: list[str] = []
    librarian.addRequested.connect(asked.append)
    QTest.keyClicks(librarian.field, "isoline")
    found = heads(librarian)
    assert under(found["Mappers"]) == ["Contour"] and "Readers" not in found
    QTest.keyClick(librarian.field, Qt.Key.Key_Return)
    assert asked == ["mappers.contour.contour"]
    librarian.field.clear()
    assert "Readers" in heads(librarian)


def test_a_double_click_adds_and_opens(librarian: Librarian) -> None:
    added: list[str] = []
    opened: list[str] = []
    librarian.addRequested.connect(added.append)
    librarian.openRequested.connect(opened.append)
    tree = librarian.tree
    rect = tree.visualItemRect(child(heads(librarian)["Readers"], 0))
    view, left, none = tree.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    QTest.mouseClick(view, left, none, rect.center())
    QTest.mouseDClick(view, left, none, rect.center())
    assert added == ["readers.analytic.analytic"]
    librarian._double(child(heads(librarian)["Example networks"], 0))
    assert Path(opened[0]).is_file()


def test_sections_fold(librarian: Librarian) -> None:
    readers = heads(librarian)["Readers"]
    at = librarian.tree.visualItemRect(readers).center()
    QTest.mouseClick(librarian.tree.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, at)
    assert not readers.isExpanded()
    librarian.fill()
    assert not heads(librarian)["Readers"].isExpanded() and heads(librarian)["Mappers"].isExpanded()


def test_a_row_dropped_on_the_canvas_adds_there(librarian: Librarian, qtbot: Any) -> None:
    canvas = Canvas(librarian.session)
    qtbot.addWidget(canvas)
    canvas.resize(600, 400)
    canvas.show()
    what = child(heads(librarian)["Mappers"], 2).data(0, WHAT)
    assert isinstance(what, Match)
    data = QMimeData()
    data.setData(MODULE, what.module.id.encode())
    left, none = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    at = QPoint(300, 200)
    canvas.dropEvent(QDropEvent(QPointF(at), Qt.DropAction.CopyAction, data, left, none))
    (node,) = librarian.session.network.nodes.values()
    assert node.module == what.module.id
    assert canvas.board.nodes[node.id].scene_rect().contains(canvas.mapToScene(at)) or canvas.board.bounds().width()


def test_each_module_has_a_help_page(qtbot: Any, catalogue: Catalogue) -> None:
    page = HelpPage(catalogue)
    qtbot.addWidget(page)
    assert "F1" in page.view.toPlainText()
    for record in catalogue:
        page.show_module(record.id)
        text = page.view.toPlainText()
        assert record.title in text and "Accuracy" in text and "Gives" in text
        assert all(p.name.replace("_", " ") in text for p in record.parameters)
    page.show_module("mappers.contour.contour")
    assert "jacksboro" in page.view.toPlainText()
    opened: list[str] = []
    page.openRequested.connect(opened.append)
    page.view.anchorClicked.emit(QUrl("network:jacksboro"))
    assert Path(opened[0]).name == "jacksboro.json"
    page.show_module("acme.surfer")
    assert "not installed" in page.view.toPlainText()
