"""The views of a network side by side."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import networkx
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QApplication, QLabel, QSplitter, QVBoxLayout, QWidget

from app.draw.styles import Ranges, common
from app.gui import bookmarks, cameras, zooming
from app.gui.session import Session
from app.gui.studio import Studio
from app.gui.view_pane import ViewPane

MOST = 4
"""Views that are shown at once."""


class Views(QWidget):
    """The views of a network in one or two rows, up to four at once; panes are made once and used again."""

    pictureAsked = Signal(str)

    def __init__(self, session: Session, studio: Studio, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.studio = session, studio
        self.panes: list[ViewPane] = []
        self.as_saved = self.linked = self.shared = False
        self.most = MOST
        self.empty = QLabel("A view shows its picture here. Add one: Space, then “view”.", self)
        self.empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.empty.setProperty("kind", "quiet")
        self.rows = [QSplitter(Qt.Orientation.Horizontal) for _ in range(2)]
        self.columns = QSplitter(Qt.Orientation.Vertical)
        for row in self.rows:
            self.columns.addWidget(row)
        for one in (self.columns, *self.rows):
            one.setChildrenCollapsible(False)
            one.setHandleWidth(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.empty)
        column.addWidget(self.columns)
        self._shown: tuple[str, ...] | None = None
        self._ranges: Ranges = {}
        for n in range(1, bookmarks.MOST + 1):
            QShortcut(QKeySequence(f"Ctrl+{n}"), self, partial(self._to_bookmark, n - 1))
        session.networkChanged.connect(self.sync)
        session.selectionChanged.connect(self.sync)
        self.sync()

    @property
    def shown(self) -> tuple[str, ...]:
        """Nodes whose views are shown."""
        return self._shown or ()

    @property
    def active(self) -> ViewPane | None:
        """The view that has the keys, else the first."""
        there = [pane for pane in self.panes if pane.node]
        focus = QApplication.focusWidget() or self
        return next((pane for pane in there if pane.isAncestorOf(focus)), there[0] if there else None)

    def sync(self) -> None:
        """A pane for each view; of more than fit those that are chosen first."""
        views = sorted(self.session.views(), key=lambda n: (n not in self.session.selection, n not in self.shown, n))
        nodes = tuple(sorted(views[: self.most]))
        while len(self.panes) < len(nodes):
            self._add()
        self.empty.setVisible(not nodes)
        self.columns.setVisible(bool(nodes))
        for i, pane in enumerate(self.panes):
            pane.setVisible(i < len(nodes))
            pane.show_node(nodes[i] if i < len(nodes) else "")
        if nodes != self._shown:
            self._shown = nodes
            self.session.observe("views", nodes)
            self._lay(len(nodes))
            self._compare()

    def _add(self) -> None:
        pane = ViewPane(self.session, self.studio, self)
        pane.as_saved = self.as_saved
        pane.pictureAsked.connect(self.pictureAsked)
        pane.back.steered.connect(partial(self._steered, pane))
        pane.back.cameraChanged.connect(partial(self._settled, pane))
        pane.sceneChanged.connect(self._compare)
        self.panes.append(pane)

    def _lay(self, n: int) -> None:
        """Up to three side by side, four as two by two."""
        for i, pane in enumerate(self.panes):
            row = self.rows[1 if n == 4 and i in (2, 3) else 0]
            if pane.parentWidget() is not row:
                row.addWidget(pane)
        self.rows[1].setVisible(n == 4)
        for one in (self.columns, *self.rows):
            one.setSizes([1000] * one.count())

    # --- comparing

    def split(self, most: int) -> None:
        """Show so many views at once, if there are so many."""
        self.most = most
        self.sync()

    def link(self, on: bool) -> None:
        """Let the views move together: they take the camera of the active one."""
        self.linked = on
        pane = self.active
        if on and pane is not None and pane.back.camera is not None:
            self._settled(pane, pane.back.camera)

    def _steered(self, pane: ViewPane, camera: cameras.Camera) -> None:
        """Someone moved a view: those of as many dimensions go along."""
        if not self.linked:
            return
        for other in self.panes:
            if other is not pane and other.node and other.back.camera is not None and other.back.flat == pane.back.flat:
                other.back.set_camera(camera)

    def _settled(self, pane: ViewPane, camera: cameras.Camera) -> None:
        """It was let go: those that went along keep where they are."""
        self._steered(pane, camera)
        for other in self.panes:
            if self.linked and other is not pane and other.node and other.back.flat == pane.back.flat:
                other.keep_camera(camera)

    def share_colours(self, on: bool) -> None:
        """Give the same value the same colour in all views."""
        self.shared = on
        self._compare()

    def _compare(self) -> None:
        """Find the range of each kind of value over all views."""
        scenes = [scene for pane in self.panes if pane.node and (scene := pane.scene()) is not None]
        ranges = common(scenes) if self.shared and len(scenes) > 1 else {}
        if ranges != self._ranges:
            self._ranges = ranges
            for pane in self.panes:
                pane.colour_on(ranges)

    def _to_bookmark(self, n: int) -> None:
        pane = self.active
        marks = bookmarks.listed(self.session.network, pane.node) if pane is not None else []
        if pane is not None and n < len(marks):
            pane.see(marks[n][1])
            self._settled(pane, marks[n][1])

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
