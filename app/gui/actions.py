"""Every action of the window as data: menus, keys, tool bar, palette and tests are made from this one table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

Need = Literal["", "selection", "undo", "redo", "view", "running", "text", "network"]

MENUS: Final = ("File", "Edit", "View", "Network", "Run", "Accuracy", "Window", "Help")


@dataclass(frozen=True)
class Action:
    """Something that the user can do.

    Parameters
    ----------
    id : of the method of `Commands` that does it
    words : in the menu; "…" where it asks first
    menu : that holds it
    key : shortcut of the window
    shown : shortcut that is said and not set, since the canvas takes it
    icon : in the tool bar and the menu
    need : what must be there
    check : whether it is on or off
    apart : a line stands before it
    tip : what it does, for who has not done it before
    """

    id: str
    words: str
    menu: str
    key: str = ""
    shown: str = ""
    icon: str = ""
    need: Need = ""
    check: bool = False
    apart: bool = False
    tip: str = ""

    @property
    def label(self) -> str:
        """In the menu, with the shortcut that is only said."""
        return f"{self.words}\t{self.shown}" if self.shown else self.words

    @property
    def keys(self) -> str:
        """The shortcut in words, either kind."""
        return self.key or self.shown


ACTIONS: Final = (
    Action("new", "New network", "File", "Ctrl+N", icon="new", tip="An empty canvas"),
    Action("open", "Open…", "File", "Ctrl+O", icon="open", tip="A network, or a picture saved here: it carries its network"),
    Action("open_data", "Open data…", "File", "Ctrl+Shift+O", icon="reader", tip="Read a data file, model it and draw it"),
    Action("save", "Save", "File", "Ctrl+S", icon="save", apart=True, tip="Write the network to its file"),
    Action("save_as", "Save as…", "File", "Ctrl+Shift+S"),
    Action("save_picture", "Save picture…", "File", "Ctrl+P", icon="camera", need="view",
           tip="The view with its network and a certificate of its accuracy"),
    Action("quit", "Quit", "File", "Ctrl+Q", apart=True),
    Action("undo", "Undo", "Edit", "Ctrl+Z", icon="undo", need="undo"),
    Action("redo", "Redo", "Edit", "Ctrl+Shift+Z", icon="redo", need="redo"),
    Action("cut", "Cut", "Edit", "Ctrl+X", need="selection", apart=True),
    Action("copy", "Copy", "Edit", "Ctrl+C", icon="copy", need="selection"),
    Action("paste", "Paste", "Edit", "Ctrl+V"),
    Action("paste_wired", "Paste with wires from outside", "Edit", "Ctrl+Shift+V"),
    Action("duplicate", "Duplicate", "Edit", "Ctrl+D", need="selection"),
    Action("remove", "Delete", "Edit", shown="Del", need="selection"),
    Action("select_all", "Select all", "Edit", "Ctrl+A", need="network", apart=True),
    Action("find", "Find in the network…", "Edit", "Ctrl+F", icon="search", need="network"),
    Action("preferences", "Preferences…", "Edit", "Ctrl+,", apart=True),
    Action("fit_canvas", "Fit the network", "View", shown=".", icon="fit", need="network"),
    Action("zoom_selection", "Zoom to the selection", "View", shown="Z", need="selection"),
    Action("zoom_in", "Zoom in", "View", "Ctrl++"),
    Action("zoom_out", "Zoom out", "View", "Ctrl+-"),
    Action("zoom_one", "Zoom to 100 %", "View", "Ctrl+0"),
    Action("fit_views", "See all in the views", "View", "Ctrl+Shift+Home", icon="cube", need="view", apart=True),
    Action("split_one", "One view", "View", "Ctrl+Alt+1", check=True, tip="The chosen one"),
    Action("split_two", "Up to two views", "View", "Ctrl+Alt+2", check=True, icon="split"),
    Action("split_four", "Up to four views", "View", "Ctrl+Alt+4", check=True),
    Action("link_cameras", "Move the views together", "View", "Ctrl+Alt+L", need="view", icon="link", check=True, apart=True,
           tip="All views are seen from where the active one is"),
    Action("same_colours", "Same colours in all views", "View", "Ctrl+Alt+C", need="view", check=True,
           tip="A value has the same colour wherever it is shown; pictures that are saved keep their own ends"),
    Action("bookmark", "Bookmark the view…", "View", "Ctrl+Alt+D", need="view", tip="Ctrl+1 to Ctrl+9 lead back to it"),
    Action("as_saved", "Views in the theme of their pictures", "View", check=True,
           tip="Off: views follow the window, pictures keep their own theme"),
    Action("add_module", "Add module…", "Network", shown="Space", icon="plus", tip="Search all modules"),
    Action("settings_of", "Settings of the module", "Network", shown="Enter", need="selection", tip="To its panel"),
    Action("wire", "Wire by keys", "Network", shown="W", need="selection",
           tip="Arrows choose a socket, Enter takes it, arrows choose where it goes, Enter connects"),
    Action("rename", "Rename", "Network", shown="F2", need="selection"),
    Action("replace", "Replace with…", "Network", "Ctrl+R", need="selection",
           tip="Another module in its place; wires and values that fit are kept"),
    Action("arrange", "Arrange", "Network", shown="L", icon="layout", need="network"),
    Action("frame", "Frame the selection", "Network", "Ctrl+G", icon="box", need="selection"),
    Action("note", "Add a note", "Network", icon="note"),
    Action("run_all", "Run everything", "Run", "F5", icon="play", need="network",
           tip="Also what no view looks at"),
    Action("run_to", "Run to here", "Run", "Shift+F5", need="selection"),
    Action("fire", "Fire", "Run", "Ctrl+Return", need="selection", tip="Run the chosen module again"),
    Action("stop", "Stop", "Run", shown="Esc", icon="stop", need="running", tip="What has been computed is kept"),
    Action("sequence", "Sequence", "Run", "Ctrl+Shift+P", icon="clock", apart=True,
           tip="A parameter runs through values: a level that sweeps, a step of time, a ladder of tolerances"),
    Action("freeze", "Freeze", "Run", "Ctrl+Shift+F", icon="freeze", check=True, apart=True,
           tip="Nothing runs until you unfreeze; edits go on"),
    Action("hold", "Hold", "Run", "Ctrl+H", need="selection", tip="The module fires only when you press Fire"),
    Action("disable", "Disable", "Run", "Ctrl+E", need="selection", tip="The module gives nothing"),
    Action("bypass", "Bypass", "Run", "Ctrl+Shift+E", need="selection",
           tip="What comes into the module goes on in place of what it gives"),
    Action("budget", "Budget", "Accuracy", "Ctrl+B", tip="Where the error of the chosen wire or module comes from"),
    Action("overview", "Where the error comes from", "Accuracy", "Ctrl+Alt+B", icon="accuracy",
           tip="Every source behind a picture, over the whole network"),
    Action("flags", "Flags", "Accuracy", "Ctrl+Shift+B", icon="flag", tip="What to look at twice"),
    Action("worst", "Worst places", "Accuracy", "Ctrl+Alt+W", tip="The largest errors of a shape, and where they are"),
    Action("next_place", "Zoom to the next place", "Accuracy", "Ctrl+J", icon="zoomto", need="view",
           tip="Of the chosen flag, or the chosen row of the worst places"),
    Action("coverage", "Coverage factor…", "Accuracy", apart=True,
           tip="k: standard deviations count k times in totals, legends and certificates"),
    Action("theme_system", "Theme of the system", "Window", check=True),
    Action("theme_light", "Light", "Window", check=True),
    Action("theme_dark", "Dark", "Window", check=True),
    Action("librarian", "Find a module", "Window", "Ctrl+L", apart=True, tip="To the search of the librarian"),
    Action("next_part", "Next part of the window", "Window", "F6", tip="Librarian, canvas, views, panel, pages"),
    Action("last_part", "Part before", "Window", "Shift+F6"),
    Action("float_panel", "Panel in a window of its own", "Window", "Ctrl+Alt+P", need="selection", apart=True,
           tip="It stays with its module whatever is chosen"),
    Action("start_page", "Start page", "Window", apart=True),
    Action("palette", "Find an action…", "Help", "Ctrl+K", icon="search"),
    Action("help", "Help on the module", "Help", "F1", icon="help", tip="Of the chosen module; the page of keys without one"),
    Action("keys", "Keys", "Help", "Ctrl+F1", tip="What can be done by keys alone"),
    Action("problems", "Problems", "Help", "Ctrl+Shift+M", apart=True, tip="What does not run, and why"),
    Action("log", "Log", "Help", tip="What was said, and what ran"),
    Action("about", "About Nonius Explorer", "Help"),
)  # fmt: skip

TOOLBAR: Final = (
    "new", "open", "save", "|", "undo", "redo", "|", "add_module", "arrange", "fit_canvas", "note", "|", "stop", "freeze",
)  # fmt: skip
WORDED: Final = ("add_module", "stop")
"""Of the tool bar, those with words and their key."""


def by_id() -> dict[str, Action]:
    """The table by id."""
    return {action.id: action for action in ACTIONS}
