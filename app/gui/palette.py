"""Find an action by typing a part of its name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QListWidget, QListWidgetItem, QVBoxLayout

from app.gui.actions import ACTIONS, Action
from app.gui.icons import icon

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow

WIDE, HIGH = 460, 380
MOVES = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


class Palette(QDialog):
    """A field over a list of all actions; Enter does the chosen one."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.owner = window
        self.setAccessibleName("Find an action")
        self.field = QLineEdit(placeholderText="Find an action")
        self.list = QListWidget()
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 8, 8, 8)
        column.addWidget(self.field)
        column.addWidget(self.list)
        self.field.textChanged.connect(self.fill)
        self.field.installEventFilter(self)
        self.list.itemActivated.connect(lambda _: self.take())
        self.list.itemClicked.connect(lambda _: self.take())
        self.fill("")
        at = window.mapToGlobal(window.rect().topLeft())
        self.setGeometry(at.x() + (window.width() - WIDE) // 2, at.y() + 72, WIDE, HIGH)
        self.field.setFocus()

    def fill(self, typed: str) -> None:
        """Show the actions that fit what was typed."""
        self.list.clear()
        words = typed.casefold().split()
        for action in sorted((a for a in ACTIONS if _fits(a, words)), key=lambda a: _rank(a, typed.casefold())):
            if not self.owner.made[action.id].isEnabled() or action.id == "palette":
                continue
            keys = f"    {action.keys}" if action.keys else ""
            item = QListWidgetItem(f"{action.menu}: {action.words.rstrip('…')}{keys}")
            item.setData(Qt.ItemDataRole.UserRole, action.id)
            item.setToolTip(action.tip)
            if action.icon:
                item.setIcon(icon(action.icon, "text 2"))
            self.list.addItem(item)
        self.list.setCurrentRow(0)

    def take(self) -> None:
        """Do the chosen one."""
        item = self.list.currentItem()
        self.close()
        if item is not None:
            self.owner.made[str(item.data(Qt.ItemDataRole.UserRole))].trigger()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Arrows move in the list while one types."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            if event.key() in MOVES:
                self.list.event(event)
                return True
            if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
                self.take()
                return True
        return False


def _fits(action: Action, words: list[str]) -> bool:
    text = f"{action.words} {action.menu} {action.tip}".casefold()
    return all(word in text for word in words)


def _rank(action: Action, typed: str) -> tuple[bool, int]:
    return (not action.words.casefold().startswith(typed), ACTIONS.index(action))
