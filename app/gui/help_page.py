"""The help page of a module, made from its declaration."""

from __future__ import annotations

from PySide6.QtCore import QUrl, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app import paths
from app.commands.describe import examples
from app.engine.catalogue import Catalogue
from app.gui import glyphs, rows, style
from app.gui.glyphs import Look
from app.gui.page_view import PageView


class HelpPage(QWidget):
    """What a module takes, gives and does to the accuracy, its settings, and networks in which it stands.

    Signals
    -------
    openRequested : path of an example network that was clicked
    """

    openRequested = Signal(str)

    def __init__(self, catalogue: Catalogue, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.catalogue, self.look, self.module = catalogue, Look(), ""
        self.view = PageView(self.look, self)
        self.view.anchorClicked.connect(self._go)
        column = QVBoxLayout(self)
        column.setContentsMargins(12, 12, 12, 12)
        column.addWidget(self.view)
        self.setAccessibleName("Help")
        style.watch().changed.connect(self.follow_theme)
        self.show_module("")

    def show_module(self, module: str) -> None:
        """Show the page of a module; "" for what to do."""
        self.module = module
        record = self.catalogue.get(module)
        if record is None:
            quiet = self.look["text 2"].name()
            why = "Select a node or a module and press F1: its help stands here."
            if module:
                why = f"{module} is not installed, so nothing is known of it here."
            self.view.show_page(f"<p style='color:{quiet}'>{why}</p>")
            return
        self.view.show_page(rows.page(record, self.look, examples(record)))

    def _go(self, url: QUrl) -> None:
        place = paths.networks().get(url.path())
        if url.scheme() == "network" and place is not None:
            self.openRequested.emit(str(place))

    def follow_theme(self) -> None:
        """Draw in the theme in force."""
        if self.look.set(glyphs.current()):
            self.show_module(self.module)
