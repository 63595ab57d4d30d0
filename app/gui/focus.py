"""From part to part of the window by keys: librarian, canvas, views, panel, pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QWidget

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


def parts(window: MainWindow) -> list[tuple[QWidget, QWidget]]:
    """(part, what takes the focus in it) of all that is shown, in the order of a clock."""
    panes = [p for p in window.views.panes if p.isVisible()]
    page = window.pages.currentWidget()
    row = next(iter(window.panel.rows.values()), None)
    found: list[tuple[QWidget, QWidget]] = [(window.librarian, window.librarian.field), (window.canvas, window.canvas)]
    found += [(pane, pane.back) for pane in panes]
    found += [(window.panel, row.field if row is not None else window.panel)]
    if page is not None:
        inner = getattr(page, "list", page)
        found.append((window.pages, inner if inner.focusPolicy() != Qt.FocusPolicy.NoFocus else window.pages.tabBar()))
    return [(part, inner) for part, inner in found if part.isVisible()]


def into(window: MainWindow, part: QWidget) -> None:
    """Take the focus into a part."""
    inner = next((inner for one, inner in parts(window) if one is part), part)
    inner.setFocus(Qt.FocusReason.ShortcutFocusReason)


def go(window: MainWindow, step: int) -> None:
    """Take the focus to the next part, or to the one before."""
    there = parts(window)
    now = QApplication.focusWidget()
    at = next((i for i, (part, _) in enumerate(there) if now is not None and (part is now or part.isAncestorOf(now))), -1)
    if there:
        there[(at + step) % len(there) if at >= 0 else 0][1].setFocus(Qt.FocusReason.TabFocusReason)
