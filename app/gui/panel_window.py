"""The panel of one node in a window of its own: it stays with its node whatever is chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout

from app.gui import summary
from app.gui.control_panel import ControlPanel

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


class PanelWindow(QDialog):
    """A floating panel. It closes with its node; Esc closes it."""

    def __init__(self, window: MainWindow, node: str) -> None:
        super().__init__(window, Qt.WindowType.Tool)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.session, self.node = window.session, node
        self.panel = ControlPanel(window.session, self, node)
        self.panel.helpAsked.connect(window.show_help)
        self.panel.replaceAsked.connect(window.canvas.replace)
        self.panel.gone.connect(self.close)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.panel)
        window.session.networkChanged.connect(self._titled)
        self._titled()

    def sizeHint(self) -> QSize:
        """As the docked panel."""
        return QSize(320, 560)

    def _titled(self) -> None:
        there = self.session.network.nodes.get(self.node)
        if there is not None:
            self.setWindowTitle(f"{summary.title(there, self.session.catalogue.get(there.module))} – {self.node}")


def show(window: MainWindow, node: str) -> PanelWindow:
    """The window of a node's panel: the one that is open, or a new one."""
    found = next((w for w in window.findChildren(PanelWindow) if w.node == node and w.isVisible()), None)
    made = found or PanelWindow(window, node)
    made.show()
    made.raise_()
    made.activateWindow()
    return made
