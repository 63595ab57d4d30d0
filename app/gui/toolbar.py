"""The tool bar and the heads of docks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QFrame, QHBoxLayout, QSizePolicy, QToolBar, QToolButton, QVBoxLayout, QWidget

from app.gui import style
from app.gui.actions import TOOLBAR, WORDED, by_id

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


def build(window: MainWindow) -> QToolBar:
    """The tool bar, from the table of actions."""
    bar = QToolBar("Tools")
    bar.setObjectName("tools")
    bar.setMovable(False)
    bar.setIconSize(QSize(16, 16))
    bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
    table = by_id()
    for name in TOOLBAR:
        if name == "|":
            bar.addSeparator()
            continue
        button = QToolButton()
        button.setDefaultAction(window.made[name])
        button.setAccessibleName(table[name].words)
        if name in WORDED:
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setProperty("framed", True)
            button.setText(f" {table[name].words.rstrip('…')}   {table[name].keys}")
            words = button.text()
            window.made[name].changed.connect(lambda b=button, w=words: b.setText(w))
        bar.addWidget(button)
    space = QWidget()
    space.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
    bar.addWidget(space)
    bar.addWidget(window.overall)
    return bar


def headed(title: str, inside: QWidget) -> QWidget:
    """A part of the window under a head with its name."""
    head = QFrame()
    head.setProperty("kind", "bar")
    head.setFixedHeight(32)
    row = QHBoxLayout(head)
    row.setContentsMargins(12, 0, 6, 0)
    row.addWidget(style.labelled(title, "title"))
    made = QWidget()
    made.setProperty("kind", "panel")
    column = QVBoxLayout(made)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(0)
    column.addWidget(head)
    column.addWidget(inside, 1)
    return made
