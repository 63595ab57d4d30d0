"""How large a picture is to be, and in which colours, before it is written with its certificate."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QSettings, QSize
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QHBoxLayout,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.commands.pictures import Sheet
from app.gui import style
from app.picture import LARGEST, LEAST, automatic_scale

SIZES: Final = (
    ("For a page, 1600 × 1000", (1600, 1000)), ("For a screen, 1920 × 1080", (1920, 1080)),
    ("Square, 1600 × 1600", (1600, 1600)),
    ("A4 across at 300 dpi, 3508 × 2480", (3508, 2480)), ("A column at 300 dpi, 1040 × 780", (1040, 780)),
)  # fmt: skip
COLOURS: Final = (("As the view says", ""), ("Light, for paper", "light"), ("Dark, for a screen", "dark"))
KEY: Final = "picture"


class PictureDialog(QDialog):
    """Asks for a sheet.

    Parameters
    ----------
    window : size of the view in the window, in pixels
    """

    def __init__(self, window: QSize, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save the picture")
        self.sizes = QComboBox()
        self.width_box, self.height_box = _pixels("Width", LEAST[0]), _pixels("Height", LEAST[1])
        self.scale_box = QDoubleSpinBox(minimum=0.5, maximum=4.0, singleStep=0.1, decimals=1)
        self.scale_box.setPrefix("× ")
        self.scale_box.setToolTip("Text and lines so many times as large as suits the size")
        self.colours = QComboBox()
        self.words = style.labelled("", "small")
        self.words.setWordWrap(True)
        for words, theme in COLOURS:
            self.colours.addItem(words, theme)
        there = (max(LEAST[0], window.width()), max(LEAST[1], window.height()))
        for words, size in (*SIZES, (f"As in the window, {there[0]} × {there[1]}", there), ("Another size", None)):
            self.sizes.addItem(words, size)
        self._lay()
        self._remembered()
        self.sizes.activated.connect(self._chosen)
        for box in (self.width_box, self.height_box):
            box.valueChanged.connect(self._told)
        self.scale_box.valueChanged.connect(self._told)
        self._told()

    def _lay(self) -> None:
        form = QFormLayout()
        form.setHorizontalSpacing(16)
        form.setVerticalSpacing(10)
        pixels = QHBoxLayout()
        for part in (self.width_box, style.labelled("×", "quiet"), self.height_box, style.labelled("pixels", "quiet")):
            pixels.addWidget(part)
        pixels.addStretch(1)
        form.addRow("Size", self.sizes)
        form.addRow("", pixels)
        form.addRow("Text and lines", self.scale_box)
        form.addRow("Colours", self.colours)
        buttons = QDialogButtonBox()
        save = buttons.addButton("Save…", QDialogButtonBox.ButtonRole.AcceptRole)
        save.setProperty("primary", True)
        buttons.addButton(QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setContentsMargins(20, 18, 20, 16)
        column.setSpacing(14)
        column.addLayout(form)
        column.addWidget(self.words)
        column.addWidget(buttons)

    @property
    def sheet(self) -> Sheet:
        """What was chosen."""
        size = (self.width_box.value(), self.height_box.value())
        return Sheet(size, round(self.scale_box.value(), 2), str(self.colours.currentData()))

    def accept(self) -> None:
        """Remember it for the next picture."""
        sheet = self.sheet
        QSettings().setValue(KEY, [*sheet.size, sheet.scale, sheet.theme])
        super().accept()

    def _remembered(self) -> None:
        held = QSettings().value(KEY)
        try:
            width, height, scale, theme = held if isinstance(held, list) else (1600, 1000, 1.0, "")
            numbers = int(width), int(height), float(scale)
        except (TypeError, ValueError):
            numbers, theme = (1600, 1000, 1.0), ""
        self.width_box.setValue(numbers[0])
        self.height_box.setValue(numbers[1])
        self.scale_box.setValue(numbers[2])
        self.colours.setCurrentIndex(max(0, self.colours.findData(theme)))

    def _chosen(self) -> None:
        size = self.sizes.currentData()
        if size is not None:
            self.width_box.setValue(size[0])
            self.height_box.setValue(size[1])

    def _told(self) -> None:
        """Name the size if it has a name; say how large the letters are."""
        size = (self.width_box.value(), self.height_box.value())
        names = [self.sizes.itemData(i) for i in range(self.sizes.count())]
        self.sizes.setCurrentIndex(next((i for i, s in enumerate(names) if s is not None and tuple(s) == size), len(names) - 1))
        letters = 11 * automatic_scale(size) * self.scale_box.value()
        self.words.setText(
            f"Letters are {letters:.0f} pixels high. The picture carries its network and a certificate of its accuracy, "
            "which lies beside it too."
        )


def _pixels(name: str, least: int) -> QSpinBox:
    made = QSpinBox(minimum=least, maximum=LARGEST)
    made.setAccessibleName(name)
    made.setFixedWidth(90)
    return made
