"""Yes or no, options, text, files, lists, colours."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import Any

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QLinearGradient, QPainter, QPixmap
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QColorDialog,
    QComboBox,
    QFileDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.gui import folders, icons, style
from app.gui.widgets.field import Facts, Field, title
from app.gui.widgets.number import NumberField, number_of
from modules.data import colours
from modules.data.formula import FormulaError
from modules.parameters import Parameter

SEGMENTS = 3
LETTERS = 22
"""Options up to which they stand side by side: their number, and letters of all."""


def _row(widget: QWidget) -> QHBoxLayout:
    row = QHBoxLayout(widget)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(6)
    return row


class YesNo(Field):
    """A tick."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.box = QCheckBox()
        self.box.setAccessibleName(title(parameter.name))
        _row(self).addWidget(self.box)
        self.setFocusProxy(self.box)
        self.box.clicked.connect(lambda on: self.give(bool(on)))

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        self.box.setChecked(bool(value))


class Segments(Field):
    """A few options side by side."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.group = QButtonGroup(self)
        row = _row(self)
        row.setSpacing(0)
        self.buttons: dict[str, QPushButton] = {}
        for option in parameter.options:
            button = QPushButton(option.replace("_", " ").capitalize())
            button.setCheckable(True)
            button.setProperty("segment", True)
            button.clicked.connect(lambda _=False, o=option: self.give(o))
            self.group.addButton(button)
            row.addWidget(button, 1)
            self.buttons[option] = button

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        button = self.buttons.get(str(getattr(value, "name", value)))
        if button:
            button.setChecked(True)


class Options(Field):
    """A list of options; a colour table is shown beside its name."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.list = QComboBox()
        self.list.setAccessibleName(title(parameter.name))
        ramps = set(parameter.options) & set(colours.TABLES) and "map" in parameter.name
        for option in parameter.options:
            words = option.replace("_", " ").capitalize()
            if ramps and option in colours.TABLES:
                self.list.addItem(ramp(option), words, option)
            else:
                self.list.addItem(words, option)
        if ramps:
            self.list.setIconSize(self.list.iconSize() * 3)
        _row(self).addWidget(self.list, 1)
        self.setFocusProxy(self.list)
        self.list.activated.connect(lambda i: self.give(self.list.itemData(i)))
        self.list.wheelEvent = lambda event: event.ignore()  # type: ignore[method-assign]  # the panel scrolls

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        self.list.setCurrentIndex(self.list.findData(str(getattr(value, "name", value))))


class Named(Field):
    """Text that is one of the names of an input; another may be typed."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.list = QComboBox()
        self.list.setEditable(True)
        self.list.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.list.setAccessibleName(title(parameter.name))
        _row(self).addWidget(self.list, 1)
        self.setFocusProxy(self.list)
        self.list.activated.connect(lambda _: self._given())
        edit = self.list.lineEdit()
        if edit is not None:
            edit.editingFinished.connect(self._given)
            edit.setPlaceholderText("automatic" if parameter.automatic else "none")

    def _given(self) -> None:
        text = self.list.currentText().strip()
        value: Any = None if not text and self.parameter.automatic else text
        if value != self.value:
            self.give(value)

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        self.list.setEditText("" if value is None else str(value))

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None, powers: bool | None = None) -> None:
        """The names that there are."""
        assert self.parameter.choice is not None
        port, _, fact = self.parameter.choice.of.partition(".")
        names = [str(n) for n in facts.get(port, {}).get(fact, ())]
        if names != [self.list.itemText(i) for i in range(self.list.count())]:
            self.list.clear()
            self.list.addItems(names)
        self.show_value(self.value)


class Words(Field):
    """Text."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.text = QLineEdit()
        self.text.setAccessibleName(title(parameter.name))
        self.text.setPlaceholderText("automatic" if parameter.automatic else "")
        self.row = _row(self)
        self.row.addWidget(self.text, 1)
        self.setFocusProxy(self.text)
        self.text.editingFinished.connect(self._given)

    def _given(self) -> None:
        text = self.text.text()
        value: Any = None if not text and self.parameter.automatic else text
        if value != self.value:
            self.give(value)

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        if not (self.text.hasFocus() and self.text.isModified()):
            self.text.setText("" if value is None else str(value))


class Colour(Words):
    """A colour by its role or as #rrggbb, with a sample that opens a choice."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.sample = QToolButton()
        self.sample.setProperty("framed", True)
        self.sample.setToolTip("Choose a colour")
        self.sample.setAccessibleName("Choose a colour")
        self.row.addWidget(self.sample)
        self.sample.clicked.connect(self._choose)

    def _colour(self) -> QColor:
        try:
            return QColor(style.present()[str(self.value)]) if self.value else QColor()
        except (KeyError, ValueError):
            return QColor()

    def show_value(self, value: Any) -> None:
        """Show a value."""
        super().show_value(value)
        made = QPixmap(16, 16)
        colour = self._colour()
        made.fill(colour if colour.isValid() else Qt.GlobalColor.transparent)
        self.sample.setIcon(QIcon(made))

    def _choose(self) -> None:
        chosen = QColorDialog.getColor(self._colour(), self, "Colour")
        if chosen.isValid():
            self.give(chosen.name())
            self.show_value(self.value)


class File(Words):
    """A file, typed, chosen, or dropped."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.text.setFont(style.mono(11))
        self.pick = QToolButton()
        self.pick.setProperty("framed", True)
        self.pick.setIcon(icons.icon("folder", "text 2"))
        self.pick.setToolTip("Choose a file")
        self.pick.setAccessibleName("Choose a file")
        self.row.addWidget(self.pick)
        self.pick.clicked.connect(self._choose)

    def _given(self) -> None:
        text = self.text.text().strip()
        value = Path(text) if text else None
        if value is not None and value != self.value:
            self.give(value)
        elif value is None and self.parameter.automatic and self.value is not None:
            self.give(None)

    def show_value(self, value: Any) -> None:
        """Show a path; its end is what one wants to see."""
        self.value = value
        words = "" if value is None else PurePath(value).as_posix()
        if not (self.text.hasFocus() and self.text.isModified()):
            self.text.setText("" if words == "." else words)
            self.text.setToolTip(words)

    def _choose(self) -> None:
        there = self.value if isinstance(self.value, Path) and self.value.is_absolute() else None
        start = str(there.parent if there is not None else folders.preferred("data") or "")
        chosen, _ = QFileDialog.getOpenFileName(self, title(self.parameter.name), start)
        if chosen:
            self.give(Path(chosen))
            self.show_value(self.value)


class Several(Field):
    """A list of numbers; with one of them and known ends, a slider too."""

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parameter, parent)
        self.text = QLineEdit()
        self.text.setAccessibleName(title(parameter.name))
        self.text.setPlaceholderText("automatic" if parameter.automatic else "numbers, with commas between")
        self.slider = NumberField(_single(parameter))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.text)
        column.addWidget(self.slider)
        self.setFocusProxy(self.text)
        self.slider.setVisible(False)
        self.slider.changed.connect(lambda value, interim: self.give((value,), interim))
        self.slider.endsChanged.connect(self.endsChanged)
        self.slider.powersChanged.connect(self.powersChanged)
        self.text.editingFinished.connect(self._typed)

    def _typed(self) -> None:
        if not self.text.isModified():
            return
        self.text.setModified(False)
        parts = [p for p in self.text.text().replace(";", ",").split(",") if p.strip()]
        try:
            values = tuple(number_of(p, self.slider.unit) for p in parts)
        except FormulaError as error:
            self.refused.emit(str(error))
            return
        self.give(None if not values and self.parameter.automatic else values)
        self.show_value(self.value)

    def show_value(self, value: Any) -> None:
        """Show a value."""
        self.value = value
        if not (self.text.hasFocus() and self.text.isModified()):
            self.text.setText("" if value is None else ", ".join(f"{v:.8g}" for v in value))
        single = value is not None and len(value) == 1
        self.slider.setVisible(single and any(self.findChildren(QSlider)))
        if single:
            self.slider.show_value(value[0])
            self.slider.text.setVisible(False)
            self.slider.setVisible(self.slider.ends is not None)

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None, powers: bool | None = None) -> None:
        """Ends of the slider."""
        self.slider.show_facts(facts, ends, powers)
        self.show_value(self.value)


def _single(parameter: Parameter) -> Parameter:
    kind = parameter.type.__args__[0] if hasattr(parameter.type, "__args__") else float
    return Parameter(parameter.name, kind if kind in (int, float) else float, None, True, parameter.range)


def ramp(name: str) -> QIcon:
    """A colour table as a small picture."""
    made = QPixmap(96, 24)
    made.fill(Qt.GlobalColor.transparent)
    table = colours.rgb(colours.TABLES[name])
    gradient = QLinearGradient(0, 0, 96, 0)
    for i, colour in enumerate(table):
        gradient.setColorAt(i / max(1, len(table) - 1), QColor.fromRgbF(*(float(c) for c in colour)))
    painter = QPainter(made)
    painter.fillRect(QRectF(0, 6, 96, 12), gradient)
    painter.end()
    return QIcon(made)
