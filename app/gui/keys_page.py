"""The page of keys: every action that has one, by menu, and the keys of the canvas; made from the tables."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from app.gui import keys, style
from app.gui.actions import ACTIONS, MENUS
from app.gui.glyphs import Look
from app.gui.page_view import PageView


def page() -> str:
    """The page as rich text."""
    quiet = style.present()["text 2"]
    sections = [("On the canvas", list(keys.WORDS))]
    for menu in MENUS:
        rows = [(a.keys, a.words.rstrip("…")) for a in ACTIONS if a.menu == menu and a.keys]
        sections.append((menu, rows))
    parts = ["<p style='font-size:15px'><b>Keys</b></p>"]
    for title, rows in sections:
        body = "".join(
            f"<tr><td style='padding:3px 22px 3px 0'><b>{escape(key)}</b></td>"
            f"<td style='padding:3px 0;color:{quiet}'>{escape(words)}</td></tr>"
            for key, words in rows
        )
        parts.append(f"<p style='margin-top:14px'>{escape(title)}</p><table cellspacing='0'>{body}</table>")
    return f"<div style='color:{style.present()['text']};font-size:12px'>{''.join(parts)}</div>"


class KeysPage(QDialog):
    """The page in a window."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Keys")
        self.view = PageView(Look(style.present().name), self)
        self.view.show_page(page())
        column = QVBoxLayout(self)
        column.setContentsMargins(20, 16, 8, 8)
        column.addWidget(self.view)
        self.resize(620, 720)
