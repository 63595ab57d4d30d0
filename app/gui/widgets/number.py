"""Numbers: a slider with ends that can be set, and a field that takes units and formulas."""

from __future__ import annotations

import re
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QContextMenuEvent, QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QHBoxLayout, QInputDialog, QLineEdit, QMenu, QSlider, QWidget

from app.draw import numbers
from app.gui.widgets.field import Facts, Field, title
from app.gui.widgets.scale import STEPS, Scale, scale_of
from modules.data import units
from modules.data.formula import Formula, FormulaError
from modules.parameters import Parameter


class NumberField(Field):
    """A number: slider and field. Live while the slider is held, final when it is let go."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.whole = parameter.type is int
        self.unit = parameter.range.unit if parameter.range else ""
        self.scale: Scale | None = None
        self._powers: bool | None = None
        self._facts: Facts = {}
        self._own: tuple[float, float] | None = None
        self._held = False
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, STEPS)
        self.slider.setAccessibleName(title(parameter.name))
        self.text = QLineEdit()
        self.text.setAccessibleName(f"{title(parameter.name)}, as a number")
        self.text.setMinimumWidth(58)
        self.slider.setMinimumWidth(40)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self.slider, 3)
        row.addWidget(self.text, 2)
        self.setFocusProxy(self.text)
        self.slider.sliderPressed.connect(lambda: setattr(self, "_held", True))
        self.slider.sliderReleased.connect(self._released)
        self.slider.valueChanged.connect(self._slid)
        self.text.editingFinished.connect(self._typed)
        self.text.installEventFilter(self)
        self.slider.installEventFilter(self)

    # --- shown

    def show_value(self, value: Any) -> None:
        """Show a value; while the slider is held it is not moved."""
        self.value = value
        if not (self.text.hasFocus() and self.text.isModified()):
            self.text.setText("" if value is None else self._words(value))
            self.text.setModified(False)
        self.text.setPlaceholderText("automatic" if value is None else "")
        self._measure()
        if not self._held and self.scale is not None and value is not None:
            self.slider.blockSignals(True)
            self.slider.setValue(round(self.scale.share(float(value)) * self.slider.maximum()))
            self.slider.blockSignals(False)

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None, powers: bool | None = None) -> None:
        """Ends of the slider from the inputs, or those that the user chose; the unit of what it is compared with."""
        self._facts, self._own, self._powers = facts, ends, powers
        given = self.parameter.range
        if given and given.of and not given.unit:
            port, _, fact = given.of.partition(".")
            self.unit = str(facts.get(port, {}).get("unit") or "") if fact == "range" else ""
        self.show_value(self.value)

    def _measure(self) -> None:
        """The ends, as far as they are known."""
        if self._held:
            return
        number = None if self.value is None else float(self.value)
        self.scale = scale_of(self.parameter, number, self._facts, self._own, self._powers)
        self.slider.setVisible(self.scale is not None)
        self.slider.setEnabled(self.value is not None)
        if self.scale is not None:
            self.slider.setMaximum(self.scale.steps)
            low, high = self._words(self.scale.low), self._words(self.scale.high)
            powers = ", in powers" if self.scale.log else ""
            self.slider.setToolTip(f"{low} to {high}{powers}\nRight-click to set other ends")

    @property
    def ends(self) -> tuple[float, float] | None:
        """Of the slider."""
        return None if self.scale is None else (self.scale.low, self.scale.high)

    def _slid(self, place: int) -> None:
        if self.scale is None:
            return
        number = self.scale.number(place / self.slider.maximum())
        self.text.setText(self._words(number))
        self.text.setModified(False)
        self.give(int(number) if self.whole else number, interim=self._held)

    def _released(self) -> None:
        self._held = False
        if self.value is not None:
            self.give(self.value)

    def _typed(self) -> None:
        if not self.text.isModified():
            return
        self.text.setModified(False)
        try:
            self.give(number_of(self.text.text(), self.unit))
        except FormulaError as error:
            self.refused.emit(str(error))

    def _words(self, value: float) -> str:
        text = f"{value:.8g}" if abs(value) < 1e7 else f"{value:g}"
        return numbers.with_unit(text.replace("-", "−") if "e" not in text else text, self.unit)

    # --- events

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Arrow keys step the number; the wheel scrolls the panel unless the slider has the focus."""
        if isinstance(event, QWheelEvent) and watched is self.slider and not self.slider.hasFocus():
            event.ignore()
            return True
        if isinstance(event, QContextMenuEvent) and watched is self.slider:
            self._menu(event)
            return True
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress and watched is self.text:
            step = {Qt.Key.Key_Up: 1, Qt.Key.Key_Down: -1}.get(Qt.Key(event.key()))
            if step and self.scale is not None and self.value is not None:
                fine = 1 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 10
                self.slider.setValue(self.slider.value() + step * max(1, fine * self.slider.maximum() // STEPS))
                return True
        return False

    def _menu(self, event: QContextMenuEvent) -> None:
        menu = QMenu(self)
        menu.addAction("Lower end…", lambda: self._set_end(0))
        menu.addAction("Upper end…", lambda: self._set_end(1))
        if self._own:
            menu.addAction("Ends as declared", lambda: self.endsChanged.emit(None))
        powers = menu.addAction("In powers", self._turn)
        powers.setCheckable(True)
        powers.setChecked(bool(self.scale and self.scale.log))
        menu.exec(event.globalPos())

    def _turn(self) -> None:
        """Evenly, or in powers."""
        declared = bool(self.parameter.range and self.parameter.range.log)
        now = not (self.scale and self.scale.log)
        self.powersChanged.emit(None if now is declared else now)

    def _set_end(self, which: int) -> None:
        if self.ends is None:
            return
        words = ("Lower end", "Upper end")[which]
        text, done = QInputDialog.getText(self, words, f"{words} of the slider", text=self._words(self.ends[which]))
        if not done:
            return
        try:
            number = number_of(text, self.unit)
        except FormulaError as error:
            self.refused.emit(str(error))
            return
        if number is None:
            return
        ends = (number, self.ends[1]) if which == 0 else (self.ends[0], number)
        if ends[0] < ends[1]:
            self.endsChanged.emit(ends)


def number_of(text: str, unit: str = "") -> float | None:
    """What was typed: a number or a formula such as 1/3 or 2*pi, also in another unit of the same kind; nothing is automatic.

    Parameters
    ----------
    unit : in which the number is wanted: "3 km" is 3000 where metres are; "" if it is a plain number

    Raises
    ------
    FormulaError : it is no number, or its unit does not fit
    """
    plain = text.strip().replace("−", "-").replace("\u2009", "").replace("\u00a0", " ")
    if not plain or plain == "automatic":
        return None
    if unit:
        plain = re.sub(rf"(?<=[\d\s).]){re.escape(unit)}$", "", plain).strip()
    try:
        return _plain(plain)
    except FormulaError as error:
        number, called = _split(plain)
        if not called:
            raise FormulaError(f"{plain!r} is no number: type one, or a formula such as 2*pi or 1/3") from error
        if not unit:
            raise FormulaError(f"{plain!r} has a unit, and this number has none: type a plain number") from error
        try:
            return _plain(number) * units.factor(called, unit)
        except units.UnitError as wrong:
            raise FormulaError(f"{plain!r} cannot be brought to {unit}: {wrong}") from error


def _plain(text: str) -> float:
    try:
        return float(text.replace(",", ".") if text.count(",") == 1 and "." not in text else text)
    except ValueError:
        return float(Formula.parse(text, ()).value({}))


def _split(text: str) -> tuple[str, str]:
    """(number, unit) of a text that ends with a known unit; the unit is "" if it does not."""
    for found in re.finditer(r"(?<=[\d\s).])[A-Za-zµμÅ°%]", text):
        number, called = text[: found.start()].strip(), text[found.start() :].strip()
        if number and units.known(called):
            return number, called
    return text, ""
