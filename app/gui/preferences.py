"""What the user prefers: theme, threads, memory for results. It takes effect at once, but for threads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QComboBox, QDialog, QFormLayout, QHBoxLayout, QSpinBox, QVBoxLayout

from app.engine.machine import cores, memory
from app.gui import style
from app.gui.widgets.parts import button

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow

MEGA = 1 << 20
THEMES = {"system": "As the system", "light": "Light", "dark": "Dark"}


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
        form = QFormLayout()
        form.setVerticalSpacing(10)
        form.addRow("Theme", self.theme)
        form.addRow("Memory for results", self.cache)
        form.addRow("Threads", self.threads)
        form.addRow("", style.labelled("Threads take effect at the next start.", "small"))
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
        self.owner.session.runs.results.bound = self.cache.value() * MEGA
        style.choose(choice)
        super().accept()
