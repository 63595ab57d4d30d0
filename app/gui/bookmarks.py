"""Places from which a view is seen, by name: kept in the view data of its node, saved with the network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.engine.network import Network
from app.gui.cameras import Camera

MOST = 9
"""As many as there are digits on a keyboard."""
NUMBERS = ("position", "focal", "up", "angle", "height")


def listed(network: Network, node: str) -> list[tuple[str, Camera]]:
    """Names and cameras; what is none is left out."""
    found = network[node].view.get("bookmarks") if node in network.nodes else None
    marks = found if isinstance(found, list | tuple) else ()
    return [(str(m.get("name") or "Bookmark"), dict(m["camera"])) for m in marks if _is_one(m)]


def _is_one(mark: Any) -> bool:
    camera = mark.get("camera") if isinstance(mark, Mapping) else None
    return isinstance(camera, Mapping) and all(name in camera for name in NUMBERS)


def kept(network: Network, node: str, name: str, camera: Camera) -> Network:
    """With a camera under a name; one of that name makes way, and the oldest beyond nine."""
    marks = [mark for mark in listed(network, node) if mark[0] != name]
    return _with(network, node, [*marks, (name, camera)][-MOST:])


def without(network: Network, node: str, name: str) -> Network:
    """Without the one of a name."""
    return _with(network, node, [mark for mark in listed(network, node) if mark[0] != name])


def fresh(network: Network, node: str) -> str:
    """A name that no other has."""
    taken = {name for name, _ in listed(network, node)}
    return next(name for n in range(1, len(taken) + 2) if (name := f"View {n}") not in taken)


def _with(network: Network, node: str, marks: list[tuple[str, Camera]]) -> Network:
    told = [{"name": name, "camera": dict(camera)} for name, camera in marks]
    return network.look(node, bookmarks=told or None)
