"""Numbers: a slider with ends that can be set, and a field that takes units and formulas."""

from __future__ import annotations

import math
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QContextMenuEvent, QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QHBoxLayout, QInputDialog, QLineEdit, QMenu, QSlider, QWidget

from app.draw import numbers
from app.gui.widgets.field import Facts, Field, title
from modules.data.formula import Formula, FormulaError
from modules.parameters import Parameter

STEPS = 1000
WHOLE = 200
"""Whole numbers up to which a slider has one step each."""


class NumberField(Field):
    """A number: slider and field. Live while the slider is held, final when it is let go."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.whole = parameter.type is int
        self.unit = parameter.range.unit if parameter.range else ""
        self.log = bool(parameter.range and parameter.range.log)
        self.ends: tuple[float, float] | None = None
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
        if not self._held and self.ends is not None and value is not None:
            self.slider.blockSignals(True)
            self.slider.setValue(self._place(float(value)))
            self.slider.blockSignals(False)

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None) -> None:
        """Ends of the slider from the inputs, or those that the user chose."""
        self._facts, self._own = facts, ends
        self.show_value(self.value)

    def _measure(self) -> None:
        """The ends: the user's, else those declared, else some about the value."""
        if self._held:
            return
        given = self.parameter.range
        found = self._own or (given.ends(self._facts) if given else None) or self._about()
        if found is not None and self.value is not None and self._own is None:
            value = float(self.value)
            if math.isfinite(value):
                found = (min(found[0], value), max(found[1], value))
        self.ends = found if found is not None and found[0] < found[1] else None
        if self.log and self.ends is not None and self.ends[0] <= 0:
            self.ends = (self.ends[1] * 1e-6, self.ends[1])
        self.slider.setVisible(self.ends is not None)
        self.slider.setEnabled(self.value is not None)
        span = self.ends[1] - self.ends[0] if self.ends else 0.0
        self.slider.setMaximum(int(span) if self.whole and not self.log and 0 < span <= WHOLE else STEPS)
        if self.ends:
            low, high = (self._words(e) for e in self.ends)
            scale = ", in powers" if self.log else ""
            self.slider.setToolTip(f"{low} to {high}{scale}\nRight-click to set other ends")

    def _about(self) -> tuple[float, float] | None:
        if self.value is None or not math.isfinite(self.value) or self.value == 0:
            return None
        value = float(self.value)
        given = self.parameter.range
        low = given.low if given and given.low else value / 5
        high = given.high if given and given.high is not None else value * 5
        if self.whole:
            low, high = math.floor(low), math.ceil(high)
        return (min(low, high), max(low, high))

    # --- between slider and number

    def _place(self, value: float) -> int:
        assert self.ends is not None
        low, high = self.ends
        if self.log:
            share = math.log(max(value, low) / low) / math.log(high / low)
        else:
            share = (value - low) / (high - low)
        return round(min(1.0, max(0.0, share)) * self.slider.maximum())

    def _number(self, place: int) -> float:
        assert self.ends is not None
        low, high = self.ends
        share = place / self.slider.maximum()
        value = low * (high / low) ** share if self.log else low + share * (high - low)
        if self.whole:
            return float(round(value))
        if place in (0, self.slider.maximum()):
            return (low, high)[place > 0]
        digits = 3 if self.log else max(0, 3 - math.floor(math.log10(high - low)))
        return float(f"{value:.{digits}g}") if self.log else round(value, digits)

    def _slid(self, place: int) -> None:
        if self.ends is None:
            return
        number = self._number(place)
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
            if step and self.ends is not None and self.value is not None:
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
        menu.exec(event.globalPos())

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
    """What was typed: a number, a formula such as 1/3 or 2*pi, with or without its unit; nothing is automatic.

    Raises
    ------
    FormulaError : it is no number
    """
    plain = text.strip().replace("−", "-").replace("\u2009", "").replace("\u00a0", " ")
    if not plain or plain == "automatic":
        return None
    if unit and plain.endswith(unit):
        plain = plain.removesuffix(unit).strip()
    try:
        return float(plain.replace(",", ".") if plain.count(",") == 1 and "." not in plain else plain)
    except ValueError:
        return float(Formula.parse(plain, ()).value({}))
