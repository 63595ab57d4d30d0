"""The views of a network side by side."""

from __future__ import annotations

from collections.abc import Sequence

import networkx
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QSplitter, QWidget

from app.gui import zooming
from app.gui.session import Session
from app.gui.studio import Studio
from app.gui.view_pane import ViewPane

MOST = 4
"""Views that are shown at once."""


class Views(QSplitter):
    """All views of the network, up to four at once; panes are made once and used again."""

    pictureAsked = Signal(str)

    def __init__(self, session: Session, studio: Studio, parent: QWidget | None = None) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self.session, self.studio = session, studio
        self.panes: list[ViewPane] = []
        self.as_saved = False
        self.empty = QLabel("A view shows its picture here. Add one: Space, then “view”.", self)
        self.empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.empty.setProperty("kind", "quiet")
        self.addWidget(self.empty)
        self.setChildrenCollapsible(False)
        self.setHandleWidth(1)
        self._shown: tuple[str, ...] | None = None
        session.networkChanged.connect(self.sync)
        session.selectionChanged.connect(self.sync)
        self.sync()

    @property
    def shown(self) -> tuple[str, ...]:
        """Nodes whose views are shown."""
        return self._shown or ()

    def sync(self) -> None:
        """A pane for each view; of more than four those that are chosen first."""
        views = sorted(self.session.views(), key=lambda n: (n not in self.session.selection and n not in self.shown, n))
        nodes = tuple(sorted(views[:MOST]))
        while len(self.panes) < len(nodes):
            pane = ViewPane(self.session, self.studio, self)
            pane.as_saved = self.as_saved
            pane.pictureAsked.connect(self.pictureAsked)
            self.panes.append(pane)
            self.addWidget(pane)
        self.empty.setVisible(not nodes)
        for i, pane in enumerate(self.panes):
            pane.setVisible(i < len(nodes))
            pane.show_node(nodes[i] if i < len(nodes) else "")
        if nodes != self._shown:
            self._shown = nodes
            self.session.observe("views", nodes)
            self.setSizes([0 if w is self.empty and nodes else 1000 for w in map(self.widget, range(self.count()))])

    def pane(self, node: str) -> ViewPane | None:
        """That shows a node."""
        return next((p for p in self.panes if p.node == node), None)

    def look_at(self, node: str, point: Sequence[float], seen: float) -> bool:
        """Bring a place of the data into the middle of the views that show what a node gives; whether there are any.

        Parameters
        ----------
        seen : how much of the world is to be seen there, from top to bottom
        """
        network = self.session.network
        below = {node} | (networkx.descendants(network.graph, node) if node in network.nodes else set())
        flown = [zooming.fly(pane.back, point, seen) for pane in self.panes if pane.node in below]
        return any(camera is not None for camera in flown)

    def show_as_saved(self, on: bool) -> None:
        """In the theme of the pictures that are saved, or in that of the window."""
        self.as_saved = on
        for pane in self.panes:
            pane.as_saved = on
            pane._restyle()
