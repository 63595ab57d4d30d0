"""What all widgets of parameters have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from modules.parameters import Parameter

Facts = Mapping[str, Mapping[str, Any]]


class Field(QWidget):
    """The widget of one parameter.

    `changed` gives (value, interim); `refused` a sentence, "" when all is well again.
    """

    changed = Signal(object, bool)
    refused = Signal(str)
    endsChanged = Signal(object)
    powersChanged = Signal(object)

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.parameter = parameter
        self.value: Any = parameter.default
        self.setAccessibleName(title(parameter.name))

    def show_value(self, value: Any) -> None:
        """Show a value that came from elsewhere."""
        self.value = value

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None, powers: bool | None = None) -> None:
        """What is known of the inputs, and what the user chose for a slider: its ends, and whether it moves in powers."""

    def give(self, value: Any, interim: bool = False) -> None:
        """The user gave a value; text is brought to the declared type."""
        try:
            coerced = self.parameter.coerce(value)
        except ValueError as error:
            self.refused.emit(str(error))
            return
        self.refused.emit("")
        self.value = coerced
        self.changed.emit(coerced, interim)


def title(name: str) -> str:
    """A parameter's name as a label: "point_area" -> "Point area"."""
    return name.replace("_", " ").capitalize()
