"""The control panel, generated from declarations: every kind of parameter, live while dragging, refused with a sentence."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.engine.catalogue import Catalogue, mine
from app.gui.control_panel import ControlPanel
from app.gui.parameter_row import ParameterRow
from app.gui.session import Session
from app.gui.widgets.choosing import field_of
from app.gui.widgets.number import NumberField, number_of
from app.gui.widgets.plain import File, Named, Options, Segments, Several, Words, YesNo
from modules.api import EXACT, Choice, Range, Value, reader
from modules.data.formula import FormulaError
from modules.parameters import Parameter


@reader("All kinds", output="value")
def kinds(
    *,
    real: Annotated[float, Range(0, 10, unit="m")] = 1.0,
    maybe: Annotated[float | None, Range(1e-6, 1, log=True)] = None,
    whole: Annotated[int, Range(1, 5)] = 2,
    on: bool = False,
    few: Literal["a", "b"] = "a",
    many: Literal["one thing", "another thing", "a third thing", "more"] = "more",
    words: str = "",
    levels: tuple[float, ...] | None = None,
    path: Path | None = None,
) -> Value:
    """Everything.

    Parameters
    ----------
    real : a real number

    Accuracy: exact.
    """
    return Value(value=real, accuracy=EXACT)


CATALOGUE = Catalogue.of([kinds])


@pytest.fixture
def panel(session_of: Callable[..., Session], qtbot: Any) -> ControlPanel:
    session = session_of(CATALOGUE)
    session.freeze(True)
    session.edit("Add", session.network.add("kinds", CATALOGUE, id="it"))
    made = ControlPanel(session)
    qtbot.addWidget(made)
    made.resize(300, 900)
    made.show()
    session.select(["it"])
    return made


def row(panel: ControlPanel, name: str) -> ParameterRow:
    return panel.rows[name]


def held(panel: ControlPanel) -> Any:
    return panel.session.network["it"].parameters


def test_each_kind_has_its_widget(panel: ControlPanel) -> None:
    assert {name: type(r.field) for name, r in panel.rows.items()} == {
        "real": NumberField, "maybe": NumberField, "whole": NumberField, "on": YesNo, "few": Segments, "many": Options,
        "words": Words, "levels": Several, "path": File,
    }  # fmt: skip


def test_every_parameter_of_every_module_has_a_widget(qapp: Any) -> None:
    for record in mine():
        for parameter in record.parameters:
            field = field_of(parameter)
            field.show_facts({}, None)
            field.show_value(parameter.default)
            assert field.value == parameter.default


def test_typing_a_number_with_unit_or_formula(panel: ControlPanel) -> None:
    field = row(panel, "real").field
    assert isinstance(field, NumberField)
    for typed, value in (("2.5 m", 2.5), ("1/4", 0.25), ("2*pi", pytest.approx(6.2831853)), ("-3", -3.0)):
        field.text.clear()
        QTest.keyClicks(field.text, typed)
        QTest.keyClick(field.text, Qt.Key.Key_Return)
        assert held(panel)["real"] == value


def test_a_value_that_is_refused_says_why_and_changes_nothing(panel: ControlPanel) -> None:
    one = row(panel, "real")
    assert isinstance(one.field, NumberField)
    one.field.text.clear()
    QTest.keyClicks(one.field.text, "much")
    QTest.keyClick(one.field.text, Qt.Key.Key_Return)
    assert "real" not in held(panel)
    assert one.words.isVisible() and one.words.text()


def test_dragging_the_slider_is_live_and_one_step(panel: ControlPanel, monkeypatch: pytest.MonkeyPatch) -> None:
    field = row(panel, "real").field
    assert isinstance(field, NumberField)
    told: list[tuple[float, bool]] = []
    field.changed.connect(lambda value, interim: told.append((value, interim)))
    slider = field.slider
    y = slider.height() // 2
    start = QPoint(int(slider.width() * 0.1), y)
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=start)
    for x in range(start.x(), int(slider.width() * 0.8), 6):
        QTest.mouseMove(slider, QPoint(x, y))
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(int(slider.width() * 0.8), y))
    assert any(interim for _, interim in told)
    assert told[-1][1] is False
    assert held(panel)["real"] == told[-1][0] > 1.0
    panel.session.undo()
    assert held(panel).get("real", 1.0) == 1.0
    assert field.text.text().startswith("1")


def test_ends_in_powers_and_of_whole_numbers(panel: ControlPanel) -> None:
    maybe, whole = row(panel, "maybe").field, row(panel, "whole").field
    assert isinstance(maybe, NumberField) and isinstance(whole, NumberField)
    maybe.give(1e-3)
    assert maybe.slider.value() == pytest.approx(500, abs=1)
    assert whole.slider.maximum() == 4
    whole.slider.setValue(4)
    assert held(panel)["whole"] == 5


def test_automatic_and_back(panel: ControlPanel) -> None:
    one = row(panel, "maybe")
    assert one.auto.isChecked()
    one.auto.click()
    assert held(panel)["maybe"] is not None
    one.auto.click()
    assert held(panel)["maybe"] is None


def test_options_ticks_text_and_lists(panel: ControlPanel) -> None:
    few, many, on = row(panel, "few").field, row(panel, "many").field, row(panel, "on").field
    levels, words = row(panel, "levels").field, row(panel, "words").field
    assert isinstance(few, Segments) and isinstance(many, Options) and isinstance(on, YesNo)
    assert isinstance(levels, Several) and isinstance(words, Words)
    few.buttons["b"].click()
    on.box.click()
    many.list.setCurrentIndex(1)
    many.list.activated.emit(1)
    QTest.keyClicks(levels.text, "1, 2.5; 1/2")
    QTest.keyClick(levels.text, Qt.Key.Key_Return)
    QTest.keyClicks(words.text, "hello")
    QTest.keyClick(words.text, Qt.Key.Key_Return)
    assert dict(held(panel)) == {
        "few": "b", "on": True, "many": "another thing", "levels": (1.0, 2.5, 0.5), "words": "hello",
    }  # fmt: skip


def test_reset_goes_back_to_the_default(panel: ControlPanel) -> None:
    panel.session.edit("Set", panel.session.network.set("it", "real", 5.0, CATALOGUE))
    row(panel, "real").resetAsked.emit()
    assert "real" not in held(panel)


def test_names_come_from_the_input(qapp: Any) -> None:
    field = field_of(Parameter("by", str, "", choice=Choice(of="geometry.names")))
    assert isinstance(field, Named)
    field.show_facts({"geometry": {"names": ("level", "error")}}, None)
    assert [field.list.itemText(i) for i in range(field.list.count())] == ["level", "error"]


def test_ends_come_from_the_input(qapp: Any) -> None:
    field = field_of(Parameter("level", float, 3.0, range=Range(of="model.range")))
    assert isinstance(field, NumberField)
    field.show_value(3.0)
    field.show_facts({"model": {"range": (2.0, 4.0)}}, None)
    assert field.ends == (2.0, 4.0)
    assert field.slider.value() == 500
    field.show_facts({"model": {"range": (2.0, 4.0)}}, (0.0, 30.0))
    assert field.ends == (0.0, 30.0)


def test_the_tooltip_teaches(panel: ControlPanel) -> None:
    tip = row(panel, "real").label.toolTip()
    assert "A real number" in tip and "Unit: m" in tip and "Default: 1.0" in tip


def test_what_was_typed_is_read() -> None:
    assert number_of("") is None
    assert number_of("12,5") == 12.5
    assert number_of("−3 m", "m") == -3.0
    with pytest.raises(FormulaError):
        number_of("x + 1")
