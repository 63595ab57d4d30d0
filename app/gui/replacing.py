"""Replace a module by another: the list shows what each would keep, and the likeliest stands first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint

from app.draw import numbers
from app.engine.replacing import Replaced, suggestions
from app.gui.quick_add import QuickAdd
from app.gui.ranking import Match, rank
from modules.declare import Module

if TYPE_CHECKING:
    from app.gui.canvas import Canvas


class Replace(QuickAdd):
    """The popup of quick-add for a node that is there; also for one whose module is not installed."""

    def __init__(self, canvas: Canvas, at: QPoint, node: str) -> None:
        self.node = node
        self.done: dict[str, Replaced] = {}
        super().__init__(canvas, at)
        self.field.setPlaceholderText(f"Replace {node} with")

    def offered(self) -> list[Module]:
        """All modules, those that keep most first."""
        session = self.canvas.session
        found = suggestions(session.network, self.node, session.catalogue)
        self.done = {module.id: done for module, done in found}
        return [module for module, _ in found]

    def ranked(self, typed: str) -> list[Match]:
        """What is meant; as offered while nothing is typed."""
        return rank(self.fitting, typed) if typed.strip() else [Match(module, 0.0) for module in self.fitting]

    def said(self) -> str:
        """What the chosen module would keep and lose."""
        match = self.current
        if match is None:
            return "Nothing of that name: try another word"
        done = self.done[match.module.id]
        lost = f"; loses {', '.join(done.lost)}" if done.lost else ""
        return f"Keeps {numbers.plural(done.kept, 'wire or value').replace('wire or values', 'wires and values')}{lost}"

    def hints(self) -> list[tuple[str, str]]:
        """Keys, and what they do."""
        return [("Enter", "replace"), ("↑ ↓", "choose"), ("F1", "help page")]

    def take(self, wired: bool = True) -> None:
        """Put the chosen module in the node's place: one edit."""
        match = self.current
        if match is None:
            return
        done, session = self.done[match.module.id], self.canvas.session
        self.close()
        session.edit(f"Replace {self.node} with {match.module.title}", done.network)
        session.select([self.node])
        if done.lost:
            session.message.emit("warning", f"{match.module.title} could not take over: {', '.join(done.lost)}")
        self.canvas.setFocus()
