"""What the actions on views do, each a method named as in the table of actions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QFileDialog

from app.gui import folders
from app.gui.film import Film

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


class ViewCommands:
    """The actions of one window on its views."""

    window: MainWindow

    def fit_views(self) -> None:
        """All of each scene."""
        for pane in self.window.views.panes:
            if pane.node:
                pane.back.fit()

    def as_saved(self) -> None:
        """Views in the theme of their pictures."""
        self.window.views.show_as_saved(not self.window.views.as_saved)

    def split_one(self) -> None:
        """One view."""
        self.window.views.split(1)

    def split_two(self) -> None:
        """Two views."""
        self.window.views.split(2)

    def split_four(self) -> None:
        """Four views."""
        self.window.views.split(4)

    def link_cameras(self) -> None:
        """Views move together, or no longer."""
        self.window.views.link(not self.window.views.linked)

    def same_colours(self) -> None:
        """The same value has the same colour in all views, or each view its own range."""
        self.window.views.share_colours(not self.window.views.shared)

    def bookmark(self) -> None:
        """Keep from where the view is seen."""
        pane = self.window.views.active
        if pane is not None:
            pane.bookmark()

    def export_frames(self, fps: int) -> None:
        """Ask where, and write each frame of the sequence with its certificate, an index and a film."""
        session, shown = self.window.session, self.window.views.shown
        node = next((n for n in session.selection if n in shown), shown[0] if shown else "")
        if not node:
            session.message.emit("warning", "There is no view whose frames could be written: add a view")
            return
        stem = session.path.stem if session.path else "sequence"
        start = str(folders.start("pictures", session.path) / f"{stem}-{node}.png")
        words = "Export the frames: NAME-001.png and on"
        chosen, _ = QFileDialog.getSaveFileName(self.window, words, start, "Pictures (*.png)")
        if chosen:
            Film(self.window, node, Path(chosen).with_suffix(".png"), fps)
