"""Undo and redo: a list of (label, network)."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

from app.engine.network import Network

UNDONE = frozenset({"position", "size", "title", "note", "bookmarks", "drawing", "numbers", "pins"})
"""View data that undo takes back; camera and panels stay as they are."""


@dataclass(frozen=True, eq=False)
class Step:
    """A network, and what led to it."""

    label: str
    network: Network
    merge: Hashable = None


class History:
    """The networks of one document.

    Parameters
    ----------
    network : the first
    bound : steps that can be undone; the oldest are forgotten
    """

    def __init__(self, network: Network, bound: int = 1000) -> None:
        self._steps = [Step("", network)]
        self._at = 0
        self._bound = bound
        self._saved: Network | None = network

    @property
    def network(self) -> Network:
        """The present one."""
        return self._steps[self._at].network

    @property
    def undo_label(self) -> str:
        """What would be undone; "" if nothing."""
        return self._steps[self._at].label if self._at else ""

    @property
    def redo_label(self) -> str:
        """What would be redone; "" if nothing."""
        return self._steps[self._at + 1].label if self._at + 1 < len(self._steps) else ""

    @property
    def labels(self) -> tuple[str, ...]:
        """Of all steps, for a list; the first is ""."""
        return tuple(step.label for step in self._steps)

    @property
    def place(self) -> int:
        """Index of the present step among `labels`."""
        return self._at

    @property
    def modified(self) -> bool:
        """Whether the present network differs from the one last saved."""
        return self.network is not self._saved and self.network != self._saved

    def commit(self, label: str, network: Network, merge: Hashable = None) -> Network:
        """Go on from an edit.

        Parameters
        ----------
        merge : edits in a row under one such word (a slider: ("set", node, parameter)) are one step
        """
        here = self._steps[self._at]
        if network is here.network:
            return network
        del self._steps[self._at + 1 :]
        step = Step(label, network, merge)
        if merge is not None and self._at and here.merge == merge:
            self._steps[self._at] = step
        else:
            self._steps.append(step)
        del self._steps[: max(0, len(self._steps) - self._bound - 1)]
        self._at = len(self._steps) - 1
        return network

    def seal(self) -> None:
        """End a row of merged edits: the slider was released."""
        self._steps[self._at] = replace(self._steps[self._at], merge=None)

    def amend(self, network: Network) -> Network:
        """Change the present network without a step: a camera was turned, a panel opened."""
        self._steps[self._at] = replace(self._steps[self._at], network=network)
        return network

    def saved(self, network: Network | None = None) -> None:
        """The present network (as it was written, if that differs) is the one in the file."""
        if network is not None:
            self.amend(network)
        self._saved = self.network

    def undo(self) -> Network:
        """The network before; the present one if there is none."""
        return self.go(self._at - 1)

    def redo(self) -> Network:
        """The network that was undone; the present one if there is none."""
        return self.go(self._at + 1)

    def go(self, place: int) -> Network:
        """To any step."""
        place = min(max(place, 0), len(self._steps) - 1)
        if place != self._at:
            self.seal()
            now, self._at = self.network, place
            self.amend(_seen(self.network, now))
        return self.network


def _seen(network: Network, now: Network) -> Network:
    """The network as it is looked at now: camera and panels of nodes that are in both."""
    changed: dict[str, Any] = {}
    for name, node in network.nodes.items():
        other = now.nodes.get(name)
        if other is None or other.view == node.view or other.module != node.module:
            continue
        view = {k: v for k, v in node.view.items() if k in UNDONE} | {k: v for k, v in other.view.items() if k not in UNDONE}
        if view != node.view:
            changed[name] = replace(node, view=view)
    return replace(network, nodes={**network.nodes, **changed}) if changed else network
