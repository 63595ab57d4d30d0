"""Numbers without a header: the user says their shape, and sees at once what the file would be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import QComboBox, QDialog, QFormLayout, QHBoxLayout, QLabel, QLineEdit, QVBoxLayout, QWidget

from app.gui import style
from app.gui.session import Session
from app.gui.widgets.parts import button

MODULE: Final = "readers.raw.raw"
WAIT: Final = 200
"""Milliseconds after the last key until the file is looked at."""
SIDE: Final = 320
"""Of the preview, in pixels."""
LOOKED_AT: Final = 20000
"""Values that are compared with their neighbours to find the shape that is likely."""


class ReadRaw(QDialog):
    """Asks for the shape of a file of plain numbers; `parameters` is what was said."""

    def __init__(self, session: Session, file: Path, facts: Mapping[str, Any], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.file = session, file
        self.parameters: dict[str, Any] = {}
        self.setWindowTitle(f"Read {file.name}")
        self._timer = QTimer(self, interval=WAIT, singleShot=True)
        self._timer.timeout.connect(self._look)
        self._said: tuple[object, ...] = ()
        session.looker.ready.connect(self._seen)
        guesses = [str(name) for name in facts.get("names", ())]
        self._fields(guesses)
        many = f"{facts.get('bytes', 0):,}".replace(",", "\u2009")
        self._lay_out(f"{file.name} holds {many} bytes and does not say what they are.")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._ranked = ("raw", str(file), "smoothest")
        self._ranking = lambda: _smoothest(session.catalogue[MODULE].function, file, guesses)
        if not guesses:
            self._changed()
        elif session.looker.ask(self._ranked, self._ranking) is not None:
            self._seen(self._ranked)
        self.size_.setFocus()

    def _fields(self, guesses: list[str]) -> None:
        record = self.session.catalogue[MODULE]
        options = {p.name: [str(o) for o in p.options or ()] for p in record.parameters}
        self.guess = QComboBox()
        self.guess.setAccessibleName("Shapes that fit")
        self.guess.addItems(guesses or ["none of the usual ones"])
        self.guess.setEnabled(bool(guesses))
        self.size_ = QLineEdit(placeholderText="64, 64, 32")
        self.size_.setAccessibleName("Samples along x, y, z")
        self.header = QLineEdit("0")
        self.header.setAccessibleName("Bytes before the first number")
        self.choices: dict[str, QComboBox] = {}
        for name in ("type", "order", "components"):
            self.choices[name] = box = QComboBox()
            box.setAccessibleName(name)
            box.addItems(options[name])
            box.setCurrentText(str(next(p.default for p in record.parameters if p.name == name)))
            box.currentTextChanged.connect(self._changed)
        self.guess.textActivated.connect(self._take)
        self.size_.textChanged.connect(self._changed)
        self.header.textChanged.connect(self._changed)

    def _lay_out(self, about: str) -> None:
        form = QFormLayout()
        form.setVerticalSpacing(10)
        rows = (
            ("Shapes that fit", self.guess), ("Samples along x, y, z", self.size_), ("Type of a number", self.choices["type"]),
            ("Order of its bytes", self.choices["order"]), ("Numbers a sample", self.choices["components"]),
            ("Bytes before the first", self.header),
        )  # fmt: skip
        for words, field in rows:
            form.addRow(words, field)
        self.picture = QLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.picture.setFixedSize(SIDE, SIDE)
        self.picture.setAccessibleName("The middle slice, read so")
        self.told = style.labelled("", "quiet")
        self.told.setWordWrap(True)
        self.told.setFixedWidth(SIDE)
        self.told.setMinimumHeight(3 * self.told.fontMetrics().lineSpacing())
        self.told.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.read = button("Read it so", self.accept, primary=True)
        self.read.setDefault(True)
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        buttons.addWidget(button("Cancel", self.reject))
        buttons.addWidget(self.read)
        left, right, columns = QVBoxLayout(), QVBoxLayout(), QHBoxLayout()
        left.addLayout(form)
        left.addStretch(1)
        right.addWidget(self.picture)
        right.addWidget(self.told)
        columns.addLayout(left)
        columns.addSpacing(24)
        columns.addLayout(right)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(20, 18, 20, 16)
        whole.setSpacing(14)
        whole.addWidget(style.labelled(about, "quiet"))
        whole.addLayout(columns)
        whole.addLayout(buttons)

    def _take(self, guess: str) -> None:
        """A shape that fits goes into the fields."""
        *edges, kind = guess.split()
        self.size_.setText(", ".join(edges))
        self.choices["type"].setCurrentText(kind)
        self.header.setText("0")
        self._changed()

    def _changed(self) -> None:
        self.read.setEnabled(False)
        self._timer.start()

    def _look(self) -> None:
        """Read the file as the fields say, in a thread."""
        try:
            size = tuple(int(word) for word in self.size_.text().replace("x", ",").replace(" ", ",").split(",") if word)
            header = int(self.header.text() or 0)
        except ValueError:
            self._tell("sizes are whole numbers, as 64, 64, 32", failed=True)
            return
        said = {"size": size, "header": header, **{name: box.currentText() for name, box in self.choices.items()}}
        self._said = ("raw", str(self.file), *said.items())
        self.parameters = said
        function = self.session.catalogue[MODULE].function

        def preview() -> tuple[str, Any]:
            try:
                samples = function(path=self.file, **said)
            except (ValueError, OSError, MemoryError) as error:
                return str(error), None
            return _words(samples), _grey(samples)

        self._preview = preview
        if self.session.looker.ask(self._said, preview) is not None:
            self._seen(self._said)

    def _seen(self, key: object) -> None:
        if key == self._ranked and not self.size_.text():
            self.guess.setCurrentText(self.session.looker.ask(self._ranked, self._ranking))
            self._take(self.guess.currentText())
        if key != self._said:
            return
        words, grey = self.session.looker.ask(self._said, self._preview)
        self._tell(words, failed=grey is None)
        if grey is None:
            return
        image = QImage(grey.data, grey.shape[1], grey.shape[0], grey.shape[1], QImage.Format.Format_Grayscale8)
        kept = Qt.AspectRatioMode.KeepAspectRatio
        self.picture.setPixmap(QPixmap.fromImage(image).scaled(SIDE, SIDE, kept, Qt.TransformationMode.FastTransformation))
        self.read.setEnabled(True)

    def _tell(self, words: str, failed: bool) -> None:
        self.told.setText(words)
        style.marked(self.told, "kind", "failed" if failed else "quiet")
        if failed:
            self.picture.setText("no picture")

    def done(self, result: int) -> None:
        """Look no more."""
        self.session.looker.ready.disconnect(self._seen)
        super().done(result)


def _smoothest(function: Callable[..., Any], file: Path, guesses: list[str]) -> str:
    """The shape whose neighbours differ least in the order of all values: a wrong one shears the picture, or cuts numbers."""

    def roughness(guess: str) -> float:
        try:
            values = function(path=file, guess=guess).values
        except (ValueError, OSError, MemoryError):
            return float("inf")
        random = np.random.default_rng(0)
        here = [random.integers(0, max(n - 1, 1), LOOKED_AT) for n in values.shape]
        order = np.sort(values[tuple(here)])
        steps = []
        for axis, n in enumerate(values.shape):
            there = [place + (n > 1) * (axis == a) for a, place in enumerate(here)]
            ranks = [np.searchsorted(order, values[tuple(at)]) for at in (here, there)]
            steps.append(float(np.abs(ranks[0] - ranks[1]).mean()))
        return max(steps)

    return min(guesses, key=roughness, default="")


def _words(samples: Any) -> str:
    facts = samples.facts()
    low, high = facts["range"] or (float("nan"), float("nan"))
    shape = " × ".join(str(n) for n in reversed(facts["shape"]))
    return f"{shape} samples from {low:.6g} to {high:.6g}; the picture is the middle slice, its lowest row at the bottom"


def _grey(samples: Any) -> Any:
    """(h, w) uint8: the middle slice, y upwards, from the 1st to the 99th of a hundred values."""
    values = np.asarray(samples.values, float)
    if samples.components > 1:
        values = np.linalg.norm(values.reshape(*samples.grid.shape, -1), axis=-1)
    while values.ndim > 2:
        values = values[len(values) // 2]
    flat = np.atleast_2d(values)
    finite = flat[np.isfinite(flat)]
    low, high = np.percentile(finite, (1, 99)) if finite.size else (0.0, 1.0)
    shade = np.clip((flat - low) / (high - low if high > low else 1.0), 0, 1)
    return np.ascontiguousarray(np.nan_to_num(shade)[::-1] * 255).astype(np.uint8)
