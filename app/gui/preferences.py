"""What the user prefers: theme, motion, folders, threads, memory for results. It takes effect at once, but for threads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.engine.machine import cores, memory
from app.gui import folders, motion, style
from app.gui.widgets.parts import button, tool

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow

MEGA = 1 << 20
THEMES = {"system": "As the system", "light": "Light", "dark": "Dark"}


class FolderField(QWidget):
    """A folder, typed or chosen; empty: where the work is."""

    def __init__(self, folder: Path | None, words: str) -> None:
        super().__init__()
        self.text = QLineEdit("" if folder is None else str(folder), placeholderText="beside the network")
        self.text.setMinimumWidth(260)
        self.text.setAccessibleName(f"Folder of {words.lower()}")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.text, 1)
        row.addWidget(tool("folder", f"Choose the folder of {words.lower()}", self._choose))
        self.setFocusProxy(self.text)

    def _choose(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Choose a folder", self.text.text())
        if chosen:
            self.text.setText(chosen)


class Preferences(QDialog):
    """A small page of settings."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.owner = window
        self.setWindowTitle("Preferences")
        self.theme = QComboBox()
        for name, words in THEMES.items():
            self.theme.addItem(words, name)
        self.theme.setCurrentIndex(self.theme.findData(style.watch().choice))
        self.cache = QSpinBox()
        self.cache.setRange(64, memory() // MEGA)
        self.cache.setSingleStep(256)
        self.cache.setSuffix(" MB")
        self.cache.setValue(window.session.runs.results.bound // MEGA)
        self.threads = QSpinBox()
        self.threads.setRange(0, 4 * cores())
        self.threads.setSpecialValueText(f"as many as cores ({cores()})")
        self.threads.setValue(int(str(window.commands.settings.value("threads", 0) or 0)))
        self.motion = QComboBox()
        for name, words in motion.CHOICES.items():
            self.motion.addItem(words, name)
        self.motion.setCurrentIndex(max(0, self.motion.findData(window.commands.settings.value("motion", "short"))))
        self.folders = {kind: FolderField(folders.preferred(kind), words) for kind, words in folders.KINDS.items()}
        self._build()

    def _build(self) -> None:
        form = QFormLayout()
        form.setVerticalSpacing(10)
        form.addRow("Theme", self.theme)
        form.addRow("Movements", self.motion)
        form.addRow("Memory for results", self.cache)
        form.addRow("Threads", self.threads)
        form.addRow("", style.labelled("Threads take effect at the next start.", "small"))
        for kind, words in folders.KINDS.items():
            form.addRow(f"Folder of {words.lower()}", self.folders[kind])
        row = QHBoxLayout()
        row.addStretch(1)
        row.addWidget(button("Cancel", self.reject))
        done = button("Use these", self.accept, primary=True)
        done.setDefault(True)
        row.addWidget(done)
        column = QVBoxLayout(self)
        column.setContentsMargins(20, 18, 20, 16)
        column.setSpacing(18)
        column.addLayout(form)
        column.addLayout(row)

    def accept(self) -> None:
        """Take the settings over."""
        settings = self.owner.commands.settings
        choice = str(self.theme.currentData())
        settings.setValue("theme", choice)
        settings.setValue("threads", self.threads.value())
        settings.setValue("cache", self.cache.value())
        settings.setValue("motion", str(self.motion.currentData()))
        for kind, field in self.folders.items():
            folders.prefer(kind, field.text.text())
        self.owner.session.runs.results.bound = self.cache.value() * MEGA
        style.choose(choice)
        super().accept()
