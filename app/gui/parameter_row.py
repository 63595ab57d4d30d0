"""A parameter in the panel: its name, its widget, a tick for automatic, a sentence when a value is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QMenu, QToolButton, QVBoxLayout, QWidget

from app.gui import icons, minis, style
from app.gui.widgets.choosing import field_of
from app.gui.widgets.field import Facts, title
from app.gui.widgets.parts import act
from modules.parameters import Parameter

LABEL = 78


class ParameterRow(QWidget):
    """A row of the panel."""

    changed = Signal(object, bool)
    resetAsked = Signal()
    endsChanged = Signal(object)
    powersChanged = Signal(object)
    pinAsked = Signal()
    letGoAsked = Signal()

    def __init__(self, parameter: Parameter, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.parameter = parameter
        self.field = field_of(parameter)
        self.field.changed.connect(self.changed)
        self.field.refused.connect(self.refuse)
        self.field.endsChanged.connect(self.endsChanged)
        self.field.powersChanged.connect(self.powersChanged)
        self.label = style.labelled(title(parameter.name), "quiet")
        self.label.setFixedWidth(LABEL)
        self.label.setWordWrap(True)
        self.label.setBuddy(self.field)
        self.auto = QToolButton()
        self.auto.setText("auto")
        self.auto.setCheckable(True)
        self.auto.setProperty("small", True)
        self.auto.setToolTip("Let the module choose; what it chose stands on the node")
        self.auto.setAccessibleName(f"{title(parameter.name)} automatic")
        self.auto.setVisible(parameter.automatic)
        self.auto.clicked.connect(self._automatic)
        self.words = style.labelled("", "failed")
        self.words.setWordWrap(True)
        self.words.hide()
        self.link = QToolButton()
        self.link.setIcon(icons.icon("link", "text 2"))
        self.link.setProperty("drawing", "link")
        self.link.setProperty("small", True)
        self.link.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.link.setToolTip("It has the value of that parameter. A click lets it go: it keeps its value and can be set")
        self.link.clicked.connect(lambda: self.letGoAsked.emit())
        self.link.hide()
        self.more: Callable[[QMenu], None] | None = None
        self.pinned = False
        self._last: Any = None
        self._build()
        self._tell()

    def _build(self) -> None:
        row = QHBoxLayout()
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self.label, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addWidget(self.field, 1)
        row.addWidget(self.auto)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(row)
        column.addWidget(self.words)
        column.addWidget(self.link, 0, Qt.AlignmentFlag.AlignLeft)

    def _tell(self) -> None:
        p = self.parameter
        scale = ", the slider moves in powers" if p.range and p.range.log else ""
        unit = f" Unit: {p.range.unit}." if p.range and p.range.unit else ""
        words = f"{p.words[:1].upper()}{p.words[1:]}." if p.words else ""
        default = "automatic" if p.default is None else str(p.plain(p.default))
        tip = f"{words}{unit}\nTakes {p.takes()}{scale}. Default: {default}.\n"
        tip += "Right-click for default, copy, and to let it follow another parameter."
        self.label.setToolTip(tip.strip())

    def show_value(self, value: Any) -> None:
        """Show a value that came from elsewhere."""
        if value is not None:
            self._last = value
        self.auto.setChecked(value is None)
        self.field.show_value(value)
        self.refuse("")

    def show_wired(self, origin: str) -> None:
        """Say that the value comes from a wire."""
        self.field.setEnabled(not origin)
        self.auto.setEnabled(not origin)
        if origin:
            self.words.setText(f"from {origin}")
            style.marked(self.words, "kind", "small")
            self.words.show()

    def show_led(self, led: str, by: tuple[str, ...] = ()) -> None:
        """Say which parameter it follows, if any, and which follow it."""
        self.link.setText(f"follows {led}")
        self.link.setAccessibleName(f"{title(self.parameter.name)} follows {led}: let it go")
        self.link.setVisible(bool(led))
        if led:
            self.field.setEnabled(False)
            self.auto.setEnabled(False)
        elif by:
            self.words.setText(f"followed by {', '.join(by)}")
            style.marked(self.words, "kind", "small")
            self.words.show()

    def show_facts(self, facts: Facts, ends: tuple[float, float] | None, powers: bool | None = None) -> None:
        """What is known of the inputs."""
        self.field.show_facts(facts, ends, powers)

    def refuse(self, sentence: str) -> None:
        """Say why a value was not taken; "" when all is well."""
        self.words.setText(sentence)
        style.marked(self.words, "kind", "failed")
        self.words.setVisible(bool(sentence))

    def _automatic(self, on: bool) -> None:
        if on:
            self.field.give(None)
        else:
            start = self._start()
            if start is None:
                self.auto.setChecked(True)
                self.field.setFocus()
                return
            self.field.give(start)

    def _start(self) -> Any:
        """A value to begin with when automatic is taken away: the last, or the middle of what is known."""
        if self._last is not None:
            return self._last
        ends = self.parameter.range.ends(self._facts()) if self.parameter.range else None
        if ends is None:
            return {int: 1, float: 1.0}.get(self.parameter.type)
        middle = float(f"{(ends[0] + ends[1]) / 2:.3g}")
        if self.parameter.type is int:
            return round(middle)
        return (middle,) if self.parameter.type not in (float, str) else middle

    def _facts(self) -> Facts:
        inner = getattr(self.field, "slider", None)
        found: Facts = getattr(self.field, "_facts", None) or getattr(inner, "_facts", None) or {}
        return found

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Default, copy, paste."""
        menu = QMenu(self)
        menu.addAction(act("Default", self.resetAsked.emit, self))
        menu.addAction(act("Copy value", self._copy, self))
        menu.addAction(act("Paste value", self._paste, self))
        if minis.can(self.parameter):
            pin = act("Show on the node", self.pinAsked.emit, self)
            pin.setCheckable(True)
            pin.setChecked(self.pinned)
            menu.addSeparator()
            menu.addAction(pin)
        if self.more is not None:
            self.more(menu)
        menu.exec(event.globalPos())

    def _copy(self) -> None:
        value = self.parameter.plain(self.field.value)
        text = ", ".join(map(str, value)) if isinstance(value, list) else "" if value is None else str(value)
        QGuiApplication.clipboard().setText(text)

    def _paste(self) -> None:
        self.field.give(QGuiApplication.clipboard().text())
