"""The theme of the window: a palette and one generated style sheet, both from the roles of `app.theme`."""

from __future__ import annotations

import re
from typing import Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication, QLabel, QWidget

from app.theme import SIZES, THEMES, Theme

BODY: Final = 13
"""Pixels of body text; whole, since Qt asks for it."""

SHEET: Final = """
* { outline: none; }
QToolTip { background: $head; color: $text; border: 1px solid $edge; padding: 5px 7px; }
QMainWindow, QDialog, QScrollArea, QStackedWidget { background: $panel; }
QMainWindow::separator { background: $divider; width: 1px; height: 1px; }
QSplitter::handle { background: $divider; }
QMenuBar { background: $head; padding: 2px 6px; }
QMenuBar::item { padding: 4px 9px; background: transparent; border-radius: 4px; }
QMenuBar::item:selected, QMenuBar::item:pressed { background: $raised; }
QMenu { background: $panel; border: 1px solid $edge; padding: 5px 0; }
QMenu::item { padding: 5px 28px 5px 12px; }
QMenu::icon { padding-left: 10px; }
QMenu::item:selected { background: $selected_row; }
QMenu::item:disabled { color: $text_3; }
QMenu::separator { height: 1px; background: $divider; margin: 5px 0; }
QToolBar { background: $panel; border: 0; border-bottom: 1px solid $divider; spacing: 4px; padding: 4px 8px; }
QToolBar::separator { background: $divider; width: 1px; margin: 5px 6px; }
QStatusBar { background: $head; color: $text_2; }
QStatusBar::item { border: 0; }
QToolButton { background: transparent; border: 1px solid transparent; border-radius: 4px; padding: 4px; }
QToolButton:hover { background: $head; }
QToolButton:pressed, QToolButton:checked { background: $selected_row; }
QToolButton[small="true"] { font-size: 11px; padding: 2px 4px; color: $text_2; border: 1px solid $divider; }
QToolButton[small="true"]:checked { color: $text; background: $selected_row; border-color: $edge; }
QToolButton:focus { border-color: $action; }
QToolButton::menu-indicator { image: none; }
QPushButton, QToolButton[framed="true"] {
    background: $raised; border: 1px solid $edge; border-radius: 4px; padding: 4px 12px; min-height: 16px; }
QPushButton[compact="true"] { padding: 3px 8px; }
QPushButton:hover { background: $head; }
QPushButton:pressed { background: $selected_row; }
QPushButton:disabled, QToolButton[framed="true"]:disabled { color: $text_3; border-color: $divider; }
QPushButton:focus { border: 1px solid $action; }
QPushButton[primary="true"] { background: $action_fill; color: $text_on_action; border-color: $action_fill; font-weight: 600; }
QPushButton[primary="true"]:focus { border: 1px solid $text; }
QPushButton[segment="true"] { border-radius: 0; padding: 4px 10px; margin-left: -1px; }
QPushButton[segment="true"]:checked { background: $action_fill; color: $text_on_action; border-color: $action_fill; }
QPushButton[link="true"] { background: transparent; border: 1px solid transparent; color: $action; padding: 2px 3px; }
QPushButton[link="true"]:hover { text-decoration: underline; }
QPushButton[link="true"]:focus { border-color: $action; }
QLineEdit, QSpinBox, QDoubleSpinBox, QComboBox, QPlainTextEdit, QTextBrowser {
    background: $field; color: $text; border: 1px solid $edge; border-radius: 4px; padding: 3px 7px; min-height: 18px;
    selection-background-color: $action_fill; selection-color: $text_on_action; }
QLineEdit:focus, QSpinBox:focus, QDoubleSpinBox:focus, QComboBox:focus, QPlainTextEdit:focus { border-color: $action; }
QLineEdit[wrong="true"] { border-color: $failed; }
QLineEdit:disabled, QComboBox:disabled { color: $text_3; border-color: $divider; }
QComboBox::drop-down { border: 0; width: 20px; }
QComboBox::down-arrow { image: url("$chevron"); width: 12px; height: 12px; }
QComboBox QAbstractItemView { background: $panel; border: 1px solid $edge; selection-background-color: $selected_row;
    selection-color: $text; }
QCheckBox { spacing: 7px; }
QCheckBox::indicator { width: 14px; height: 14px; border: 1px solid $edge; border-radius: 3px; background: $field; }
QCheckBox::indicator:checked { background: $action_fill; border-color: $action_fill; image: url("$tick"); }
QCheckBox::indicator:focus, QCheckBox:focus::indicator { border-color: $action; }
QSlider { min-height: 20px; }
QSlider::groove:horizontal { height: 4px; background: $track; border-radius: 2px; }
QSlider::sub-page:horizontal { background: $action; border-radius: 2px; }
QSlider::sub-page:horizontal:disabled { background: $track; }
QSlider::handle:horizontal { background: $text; border: 1px solid $edge; width: 12px; height: 12px; margin: -5px 0;
    border-radius: 7px; }
QSlider::handle:horizontal:disabled { background: $text_3; }
QSlider::handle:horizontal:focus { border: 2px solid $action; }
QProgressBar { background: $track; border: 0; border-radius: 2px; max-height: 4px; }
QProgressBar::chunk { background: $action; border-radius: 2px; }
QTabBar { background: transparent; }
QTabBar::tab { padding: 9px 12px 7px 12px; color: $text_2; border: 0; border-bottom: 2px solid transparent; }
QTabBar::tab:selected { color: $text; border-bottom-color: $action; font-weight: 600; }
QTabBar::tab:hover { color: $text; }
QTabWidget::pane { border: 0; border-top: 1px solid $divider; }
QListView, QTreeView, QTableView { background: $panel; border: 0; selection-background-color: $selected_row;
    selection-color: $text; alternate-background-color: $panel; gridline-color: $divider; }
QListView::item { padding: 4px; }
QHeaderView::section { background: $panel; color: $text_2; border: 0; border-bottom: 1px solid $divider; padding: 5px 8px; }
QScrollBar { background: transparent; }
QScrollBar:vertical { width: 10px; }
QScrollBar:horizontal { height: 10px; }
QScrollBar::handle { background: $track; border-radius: 3px; margin: 2px; min-height: 24px; min-width: 24px; }
QScrollBar::handle:hover { background: $edge; }
QScrollBar::add-line, QScrollBar::sub-line { width: 0; height: 0; }
QScrollBar::add-page, QScrollBar::sub-page { background: transparent; }
QDockWidget { titlebar-close-icon: none; }
QLabel[kind="title"] { font-weight: 600; }
QLabel[kind="section"] { font-weight: 600; font-size: 13px; }
QLabel[kind="heading"] { font-weight: 600; font-size: $title_px; }
QLabel[kind="page"] { font-weight: 600; font-size: 25px; }
QLabel[kind="quiet"] { color: $text_2; }
QLabel[kind="small"] { color: $text_2; font-size: 11px; }
QLabel[kind="faint"] { color: $text_3; font-size: 11px; }
QLabel[kind="sign"] { color: $brass; font-weight: 600; }
QLabel[kind="flag"] { color: $flag; }
QLabel[kind="failed"] { color: $failed; }
QLabel[kind="boxed"] { border: 1px solid $edge; border-radius: 4px; padding: 1px 7px; font-size: 11px; }
QFrame[kind="line"] { background: $divider; max-height: 1px; min-height: 1px; border: 0; }
QFrame[kind="bar"] { background: $panel; border-bottom: 1px solid $divider; }
QFrame[kind="card"] { background: $raised; border: 1px solid $edge; border-radius: 4px; }
QFrame[kind="readout"] { background: $panel; border: 1px solid $edge; border-radius: 4px; }
QFrame[kind="recovery"] { background: $raised; border: 1px solid $edge; border-left: 3px solid $flag; }
QFrame[kind="failure"] { background: $failed_ground; border: 1px solid $failed; border-radius: 4px; }
QWidget[kind="panel"] { background: $panel; }
"""


class _Present(QObject):
    """The theme in force."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.theme: Theme = THEMES["dark"]
        self.choice = "system"


_present: _Present | None = None


def watch() -> _Present:
    """Tells of changes by its signal `changed`."""
    global _present
    if _present is None:
        _present = _Present()
    return _present


def present() -> Theme:
    """The theme in force."""
    return watch().theme


def colour(role: str) -> QColor:
    """The colour of a role."""
    return QColor(present()[role])


def choose(choice: str) -> None:
    """Put a theme in force: dark, light, or that of the system."""
    app = QApplication.instance()
    if not isinstance(app, QApplication):
        return
    now = watch()
    now.choice = choice
    now.theme = THEMES[choice] if choice in THEMES else THEMES[_of_system(app)]
    app.setStyle("Fusion")
    app.setPalette(palette(now.theme))
    app.setFont(body())
    app.setStyleSheet(sheet(now.theme))
    now.changed.emit()


def body(pixels: int = BODY) -> QFont:
    """The font of the interface."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    if not QFontDatabase.hasFamily(font.family()) or "Noto Sans" in QFontDatabase.families():
        font.setFamily("Noto Sans")
    font.setPixelSize(pixels)
    return font


def mono(pixels: int = 12) -> QFont:
    """The font of ids, keys, paths and coordinates."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    font.setPixelSize(pixels)
    return font


def palette(theme: Theme) -> QPalette:
    """The roles of a theme as a palette."""
    made = QPalette()
    pairs = {
        QPalette.ColorRole.Window: "panel", QPalette.ColorRole.WindowText: "text", QPalette.ColorRole.Base: "field",
        QPalette.ColorRole.AlternateBase: "panel", QPalette.ColorRole.Text: "text", QPalette.ColorRole.Button: "raised",
        QPalette.ColorRole.ButtonText: "text", QPalette.ColorRole.ToolTipBase: "head", QPalette.ColorRole.ToolTipText: "text",
        QPalette.ColorRole.Highlight: "action fill", QPalette.ColorRole.HighlightedText: "text on action",
        QPalette.ColorRole.Link: "action", QPalette.ColorRole.PlaceholderText: "text 3", QPalette.ColorRole.Mid: "divider",
        QPalette.ColorRole.Dark: "divider", QPalette.ColorRole.Light: "raised", QPalette.ColorRole.BrightText: "failed",
    }  # fmt: skip
    for role, name in pairs.items():
        made.setColor(role, QColor(theme[name]))
    for role in (QPalette.ColorRole.WindowText, QPalette.ColorRole.Text, QPalette.ColorRole.ButtonText):
        made.setColor(QPalette.ColorGroup.Disabled, role, QColor(theme["text 3"]))
    return made


def sheet(theme: Theme) -> str:
    """The style sheet of a theme."""
    words = {role.replace(" ", "_"): colour for role, colour in theme.roles.items()}
    words |= {"title_px": f"{SIZES['title']:.0f}px", **_images(theme)}
    return re.sub(r"\$(\w+)", lambda found: words[found[1]], SHEET)


def labelled(text: str, kind: str = "", parent: QWidget | None = None) -> QLabel:
    """A label in one of the kinds of the style sheet."""
    made = QLabel(text, parent)
    made.setTextFormat(Qt.TextFormat.PlainText)
    if kind:
        made.setProperty("kind", kind)
    return made


def marked(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet looks at."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)


def _of_system(app: QGuiApplication) -> str:
    return "light" if app.styleHints().colorScheme() == Qt.ColorScheme.Light else "dark"


def _images(theme: Theme) -> dict[str, str]:
    """Files of the small drawings that a style sheet can only take from a file, in the colours of the theme."""
    from app.gui import icons
    from app.gui.recovery import state_folder

    folder = state_folder() / "drawings"
    found = {}
    for word, name, role in (("chevron", "chev", "text 2"), ("tick", "check", "text on action")):
        file = folder / f"{name}-{theme.name}.png"
        try:
            if not file.exists():
                folder.mkdir(parents=True, exist_ok=True)
                icons._pixmap(name, theme[role], 16, 2.0).save(str(file), "PNG")
        except OSError:
            pass
        found[word] = file.as_posix()
    return found
