"""What the actions on views do, each a method named as in the table of actions."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
