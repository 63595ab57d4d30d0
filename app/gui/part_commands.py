"""What the actions about parts of the window do: where the focus goes, panels in windows, wires by keys, help."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from app.gui import focus, key_wiring, panel_window

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


class PartCommands:
    """Each method is named as its action."""

    window: MainWindow

    def settings_of(self) -> None:
        """To the panel of the chosen node."""
        self.window.docks["Control panel"].show()
        focus.into(self.window, self.window.panel)

    def wire(self) -> None:
        """A wire by keys."""
        self.window.canvas.setFocus(Qt.FocusReason.ShortcutFocusReason)
        key_wiring.begin(self.window.canvas)

    def sequence(self) -> None:
        """The page of the sequencer."""
        self.window.show_page("sequence")

    def librarian(self) -> None:
        """To the search of the librarian."""
        self.window.show_work()
        self.window.docks["Librarian"].show()
        focus.into(self.window, self.window.librarian)

    def next_part(self) -> None:
        """To the next part of the window."""
        focus.go(self.window, 1)

    def last_part(self) -> None:
        """To the part before."""
        focus.go(self.window, -1)

    def float_panel(self) -> None:
        """The panel of the chosen node in a window of its own."""
        for node in self.window.session.selection:
            panel_window.show(self.window, node)

    def help(self) -> None:
        """The help of the chosen module; the page of keys without one."""
        session = self.window.session
        self.window.show_help(session.network[session.selection[0]].module if session.selection else "")

    def keys(self) -> None:
        """The page of keys."""
        self.window.show_help("")
