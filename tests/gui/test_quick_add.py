"""Quick-add: ranking, filtering by the wire in the hand, keys; a module made and wired in one step of undo."""

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QPointF, QSettings, Qt
from PySide6.QtTest import QTest

from app.engine.catalogue import Catalogue
from app.gui.canvas import Canvas
from app.gui.edits import Held
from app.gui.quick_add import QuickAdd, used
from app.gui.ranking import letters, rank
from app.gui.replacing import Replace
from app.gui.session import Session


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    made = Catalogue()
    made._rooms = True
    made.reload()
    return made


@pytest.fixture
def canvas(qtbot: Any, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch) -> Iterator[Canvas]:
    kept: dict[str, Any] = {}
    monkeypatch.setattr(QSettings, "value", lambda self, key, default=None: kept.get(key, default))
    monkeypatch.setattr(QSettings, "setValue", lambda self, key, value: kept.update({key: value}))
    session = Session(catalogue)
    session.freeze(True)
    made = Canvas(session)
    qtbot.addWidget(made)
    made.resize(1000, 600)
    made.show()
    yield made
    session.close()


def titles(catalogue: Catalogue, typed: str, **words: Any) -> list[str]:
    return [m.module.title for m in rank(catalogue, typed, **words)]


def test_prefix_before_word_before_letters() -> None:
    assert letters("contour", "con") == (0.0, (0, 1, 2))
    word, inside, scattered = letters("error band", "ba"), letters("subtle band", "btl"), letters("contour", "ctr")
    assert word and inside and scattered and word[0] < inside[0] < scattered[0]
    assert scattered[1] == (0, 3, 6) and letters("contour", "x") is None


def test_titles_before_aliases(catalogue: Catalogue) -> None:
    assert titles(catalogue, "cont")[0] == "Contour"
    assert "Contour" in titles(catalogue, "isoline") and rank(catalogue, "isoline")[0].also == "isoline"
    assert "Interpolate" in titles(catalogue, "trilinear")
    assert titles(catalogue, "no such thing") == []
    assert len(titles(catalogue, "")) == len(catalogue)


def test_what_is_used_often_comes_first(catalogue: Catalogue) -> None:
    read = titles(catalogue, "read")
    last = next(r for r in catalogue if r.title == read[2])
    assert titles(catalogue, "read", used={last.id: 5})[0] == last.title


def test_three_hundred_modules_within_a_frame(catalogue: Catalogue) -> None:
    many = [replace(m, id=f"{m.id}{i}", title=f"{m.title} {i}") for i in range(12) for m in catalogue][:300]
    rank(many, "x")  # words are prepared once
    start = time.thread_time()
    assert rank(many, "iso")
    assert time.thread_time() - start < 0.016 * 3


def test_space_types_and_enter_adds(canvas: Canvas) -> None:
    QTest.keyClick(canvas, Qt.Key.Key_Space)
    popup = canvas.popup
    assert popup is not None and popup.isVisible()
    QTest.keyClicks(popup.field, "conto")
    assert popup.current is not None and popup.current.module.title == "Contour"
    assert "field" in popup.page.toPlainText() and "Accuracy" in popup.page.toPlainText()
    QTest.keyClick(popup.field, Qt.Key.Key_Return)
    assert canvas.session.selection == ("contour-1",) and canvas.session.history.undo_label == "Add Contour"
    assert used() == {"mappers.contour.contour": 1}


def test_a_double_click_and_tab_ask_too(canvas: Canvas) -> None:
    QTest.mouseDClick(canvas.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, QPoint(300, 200))
    assert canvas.popup is not None and canvas.popup.isVisible()
    QTest.keyClick(canvas.popup.field, Qt.Key.Key_Escape)
    canvas.popup = None
    canvas.setFocus()
    QTest.keyClick(canvas, Qt.Key.Key_Tab)
    second: QuickAdd | None = canvas.popup
    assert second is not None
    QTest.keyClick(second.field, Qt.Key.Key_Escape)
    assert not canvas.session.network.nodes


def test_a_wire_dropped_on_the_canvas_offers_what_fits_and_wires_it(canvas: Canvas) -> None:
    session = canvas.session
    session.edit("Add", session.network.add("interpolate", session.catalogue, view={"position": [0.0, 0.0]}))
    canvas.set_zoom(1.0)
    steps = session.history.place
    item = canvas.board.nodes["interpolate-1"]
    plug = item.plug("model", True)
    assert plug is not None
    start = canvas.mapFromScene(item.where(plug))
    view, left, none = canvas.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    QTest.mousePress(view, left, none, start)
    QTest.mouseMove(view, start + QPoint(60, 40))
    QTest.mouseRelease(view, left, none, start + QPoint(160, 90))
    popup = canvas.popup
    assert popup is not None and popup.held == Held("interpolate-1", "model", "Model", True)
    assert all(any(not p.refuses(plug_type(session, "Model")) for p in m.module.ports) for m in popup.matches.found)
    QTest.keyClicks(popup.field, "contour")
    QTest.keyClick(popup.field, Qt.Key.Key_Return)
    assert session.network.wires["contour-1", "model", 0] == ("interpolate-1", "model")
    assert session.history.place == steps + 1
    session.undo()
    assert set(session.network.nodes) == {"interpolate-1"}


def plug_type(session: Session, name: str) -> type:
    return next(o.type for m in session.catalogue for o in m.outputs if o.type.__name__ == name)


def test_shift_enter_adds_without_the_wire_and_arrows_choose(canvas: Canvas) -> None:
    session = canvas.session
    session.edit("Add", session.network.add("contour", session.catalogue, view={"position": [0.0, 0.0]}))
    canvas.quick_add(QPoint(200, 200), Held("contour-1", "model", "Model", False))
    popup = canvas.popup
    assert popup is not None and popup.matches.found[0].module.title == "Interpolate"
    QTest.keyClick(popup.field, Qt.Key.Key_Down)
    QTest.keyClick(popup.field, Qt.Key.Key_Up)
    QTest.keyClick(popup.field, Qt.Key.Key_Return, Qt.KeyboardModifier.ShiftModifier)
    assert "interpolate-1" in session.network.nodes and not session.network.wires


def test_it_draws_and_says_when_nothing_fits(canvas: Canvas) -> None:
    canvas.quick_add(QPoint(200, 200))
    popup = canvas.popup
    assert popup is not None
    QTest.keyClicks(popup.field, "zzzz")
    assert popup.current is None and popup.grab().width() > 0
    QTest.keyClick(popup.field, Qt.Key.Key_Return)
    assert popup.isVisible() and not canvas.session.network.nodes
    popup.close()


def test_by_keyboard_alone_a_row_is_built_and_wired(canvas: Canvas) -> None:
    for words in ("analytic", "interpolate", "contour", "lines", "view"):
        QTest.keyClick(canvas, Qt.Key.Key_Space)
        popup = canvas.popup
        assert popup is not None
        popup.beside = True  # the pointer is elsewhere
        QTest.keyClicks(popup.field, words)
        QTest.keyClick(popup.field, Qt.Key.Key_Return)
    network = canvas.session.network
    assert network.order == ("analytic-1", "interpolate-1", "contour-1", "lines-1", "view-1")
    assert len(network.wires) == 4


def test_a_second_module_is_wired_to_the_selected_one(canvas: Canvas) -> None:
    canvas.hands.add("readers.analytic.analytic")
    canvas.hands.add("modellers.interpolate.interpolate")
    network = canvas.session.network
    assert network.wires["interpolate-1", "samples", 0] == ("analytic-1", "samples")
    assert canvas.board.nodes["interpolate-1"].pos() - canvas.board.nodes["analytic-1"].pos() == QPointF(224, 0)


# --- in the place of a node


def test_a_module_that_is_not_here_is_replaced_and_keeps_its_wires(canvas: Canvas) -> None:
    session = canvas.session
    catalogue = session.catalogue
    network = session.network.add("readers.analytic.analytic", catalogue, id="field").add("interpolate", catalogue, id="model")
    network = network.add("contour", catalogue, id="lines", parameters={"count": 7})
    network = network.connect("field", "samples", "model", "samples", catalogue)
    network = network.connect("model", "model", "lines", "model", catalogue)
    gone = replace(network["lines"], module="mappers.isolines.countours", parameters={"count": 7, "shade": "red"})
    session.edit("Open", replace(network, nodes={**network.nodes, "lines": gone}))
    assert canvas.board.nodes["lines"].kind == "missing"
    canvas.replace("lines")
    popup = canvas.popup
    assert isinstance(popup, Replace) and popup.isVisible()
    assert popup.current is not None and popup.current.module.title == "Contour"
    assert popup.said().startswith("Keeps 2 wires and values; loses shade")
    QTest.keyClick(popup.field, Qt.Key.Key_Return)
    assert session.network["lines"].module == "mappers.contour.contour"
    assert session.network["lines"].parameters == {"count": 7}
    assert session.network.wires["lines", "model", 0] == ("model", "model")
    session.undo()
    assert session.network["lines"].module == "mappers.isolines.countours"


def test_typing_chooses_another_replacement(canvas: Canvas) -> None:
    session = canvas.session
    session.edit("Add", session.network.add("contour", session.catalogue, id="lines"))
    canvas.replace("lines")
    popup = canvas.popup
    assert isinstance(popup, Replace)
    QTest.keyClicks(popup.field, "isosurf")
    QTest.keyClick(popup.field, Qt.Key.Key_Return)
    assert session.network["lines"].module == "mappers.isosurface.isosurface" and session.selection == ("lines",)
