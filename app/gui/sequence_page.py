"""The page of the sequencer: a parameter runs through values, and each frame is shown when the one before has run."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSlider,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.engine.errors import NoniusError
from app.engine.sequence import SETTING, Sequence, kept
from app.gui import style
from app.gui.session import Session

HELP = "0..1/11 are eleven even values, 1e-2..1e-8/7 log seven of equal ratios, or: 1, 2, 5"
NOTHING = "Choose a parameter and the values that it shall take; play shows one frame after the other."


class SequencePage(QWidget):
    """Plays a sequence.

    Playing is one step of undo, and leaves the last value that was shown. `exportAsked` gives frames a second.
    """

    exportAsked = Signal(int)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.playing = False
        self._frames: tuple[Any, ...] = ()
        self._shown = ""
        self._clock = QTimer(self, singleShot=True)
        self._clock.timeout.connect(self._tick)
        self.list = self.parameter = QComboBox()
        self.values = QLineEdit(placeholderText="0..1/11")
        self.fps = QSpinBox(minimum=1, maximum=60, value=8)
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.words = style.labelled(NOTHING, "quiet")
        self.buttons = {name: QPushButton(name) for name in ("Back", "Play", "Step", "Export frames…")}
        self._lay()
        self._connect()
        self.follow()

    def _lay(self) -> None:
        self.parameter.setAccessibleName("Parameter that runs")
        self.parameter.setMinimumWidth(240)
        self.values.setAccessibleName("Values")
        self.values.setToolTip(HELP)
        self.fps.setSuffix(" frames a second")
        self.fps.setFixedWidth(180)
        self.fps.setAccessibleName("Frames a second at most")
        self.fps.setToolTip("At most: a frame is shown when the one before has run")
        self.slider.setAccessibleName("Frame")
        self.words.setWordWrap(True)
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(10)
        for row, (words, widget) in enumerate((("Parameter", self.parameter), ("Values", self.values), ("Frame", self.slider))):
            label = style.labelled(words, "quiet")
            label.setBuddy(widget)
            grid.addWidget(label, row, 0)
            grid.addWidget(widget, row, 1)
        grid.setColumnStretch(1, 1)
        hint = style.labelled(HELP, "small")
        grid.addWidget(hint, 1, 2)
        grid.addWidget(self.fps, 0, 2)
        keys = QHBoxLayout()
        keys.setSpacing(8)
        for button in self.buttons.values():
            keys.addWidget(button)
        keys.addWidget(self.words, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 12, 16, 12)
        column.setSpacing(12)
        column.addLayout(grid)
        column.addLayout(keys)
        column.addStretch(1)

    def _connect(self) -> None:
        self.parameter.activated.connect(self._chosen)
        self.values.editingFinished.connect(self._written)
        self.slider.valueChanged.connect(self._moved)
        self.slider.sliderReleased.connect(lambda: self.show_frame(self.slider.value()))
        self.buttons["Play"].clicked.connect(self.toggle)
        self.buttons["Back"].clicked.connect(lambda: self.step(-1))
        self.buttons["Step"].clicked.connect(lambda: self.step(1))
        self.buttons["Export frames…"].clicked.connect(lambda: self.exportAsked.emit(self.fps.value()))
        self.session.networkChanged.connect(self.follow)
        self.session.waveDone.connect(self._ran)

    # --- what the document says

    @property
    def sequence(self) -> Sequence | None:
        """That of the document."""
        return kept(self.session.network.settings)

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self._frames)

    @property
    def place(self) -> int:
        """Which frame the document shows; -1 for none."""
        one = self.sequence
        if one is None or one.node not in self.session.network.nodes:
            return -1
        value = self.session.network[one.node].parameters.get(one.parameter)
        return self._frames.index(value) if value in self._frames else -1

    def value(self) -> dict[str, Any]:
        """What the frame that is shown sets."""
        one = self.sequence
        return {f"{one.node}.{one.parameter}": self._frames[self.place]} if one and self.place >= 0 else {}

    def follow(self) -> None:
        """Show what the document has."""
        said = str(self.session.network.settings.get(SETTING, ""))
        names = self._names()
        one = self.sequence
        chosen = f"{one.node}.{one.parameter}" if one else ""
        listed = ["", *names] if chosen in ("", *names) else ["", chosen, *names]
        if listed != [self.parameter.itemText(i) for i in range(self.parameter.count())]:
            self.parameter.clear()
            self.parameter.addItems(listed)
        self.parameter.setCurrentText(chosen)
        if said != self._shown:
            self._shown = said
            self.values.setText(one.values if one else "")
        self._read()

    def _names(self) -> list[str]:
        """Every parameter without a wire."""
        network, found = self.session.network, []
        for name, node in network.nodes.items():
            record = self.session.catalogue.get(node.module)
            wired = network.incoming.get(name, {})
            found += [f"{name}.{p.name}" for p in record.parameters if p.name not in wired and not p.is_path] if record else []
        return found

    def _read(self) -> None:
        """The frames, or why there are none."""
        one, self._frames, why = self.sequence, (), NOTHING
        if one is not None:
            try:
                self._frames = one.frames(self.session.network, self.session.catalogue)
            except NoniusError as error:
                why = str(error)
        count = len(self._frames)
        at = self.place
        self.slider.blockSignals(True)
        self.slider.setRange(0, max(0, count - 1))
        if not self.slider.isSliderDown():
            self.slider.setValue(max(0, at))
        self.slider.blockSignals(False)
        for widget in (self.slider, *self.buttons.values()):
            widget.setEnabled(count > 0)
        self.buttons["Play"].setText("Stop" if self.playing else "Play")
        if one is not None and count:
            value = self.session.network[one.node].parameters.get(one.parameter)
            place = f"Frame {at + 1} of {count}" if at >= 0 else f"{count} frames; now between them"
            why = f"{place}: {one.node}.{one.parameter} = {value}"
        self.words.setText(why)

    def _chosen(self) -> None:
        name = self.parameter.currentText()
        node, _, parameter = name.partition(".")
        self.stop()
        if not name:
            self._settle("")
            return
        now = self.session.network[node].parameters.get(parameter)
        plain = isinstance(now, int | float) and not isinstance(now, bool)
        values = self.values.text().strip() or (f"0..{2 * now:g}/11" if plain and now else "0..1/11")
        self._settle(str(Sequence(node, parameter, values)))

    def _written(self) -> None:
        one, text = self.sequence, self.values.text().strip()
        if one is not None and text and text != one.values:
            self.stop()
            self._settle(str(Sequence(one.node, one.parameter, text)))

    def _settle(self, text: str) -> None:
        if text != self.session.network.settings.get(SETTING, ""):
            self.session.edit("Set the sequence", self.session.network.settle(**{SETTING: text}))

    # --- playing

    def toggle(self) -> None:
        """Play or stop."""
        if self.playing:
            self.stop()
        elif self.session.frozen:
            self.session.message.emit("warning", "The network is frozen: unfreeze it in the Run menu to play")
        elif self._frames:
            self.playing = True
            self._put(0 if self.place in (-1, len(self._frames) - 1) else self.place, more=True)
            self._clock.start(1000 // self.fps.value())

    def stop(self) -> None:
        """Stay at the frame that is shown."""
        if self.playing:
            self.playing = False
            self._clock.stop()
            self._put(max(0, self.place), more=False)

    def step(self, by: int) -> None:
        """To the frame after or before; round at the ends."""
        self.stop()
        if self._frames:
            self.show_frame((self.place + by) % len(self._frames) if self.place >= 0 or by > 0 else 0)

    def show_frame(self, index: int) -> None:
        """Set the parameter to a frame: a step of undo."""
        if 0 <= index < len(self._frames):
            self._put(index, more=False)

    def _moved(self, index: int) -> None:
        self.playing = False
        self._clock.stop()
        self._put(index, more=self.slider.isSliderDown())

    def _put(self, index: int, more: bool) -> None:
        one = self.sequence
        if one is None or index >= len(self._frames):
            return
        try:
            network = self.session.network.set(one.node, one.parameter, self._frames[index], self.session.catalogue)
        except NoniusError as error:
            self.playing = False
            self.session.message.emit("error", str(error))
            return
        merge = ("sequence", one.node, one.parameter)
        self.session.edit(f"Play {one.node}.{one.parameter}", network, merge=merge, interim=more)
        self._read()

    def _tick(self) -> None:
        """Next, if the frame before has run; else when it has."""
        if not self.playing or self.session.runs.busy:
            return
        at = self.place + 1
        if at >= len(self._frames):
            self.stop()
            return
        self._put(at, more=True)
        self._clock.start(1000 // self.fps.value())

    def _ran(self, outcome: str) -> None:
        if not self.playing:
            return
        if outcome == "cancelled":
            self.stop()
        elif outcome == "settled" and not self._clock.isActive():
            self._clock.start(0)
