"""Reroute dots: places through which a wire goes, kept beside frames and notes, so that they are saved and undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QPoint, QPointF

from app.engine.network import Network, Origin, Socket
from app.gui.edits import KEY
from app.gui.layout import snap
from app.gui.wires import WireItem

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

Dots = tuple[tuple[float, float], ...]
REACH = 9.0


def name(end: Socket, origin: Origin) -> str:
    """What the file calls a wire; its place in a list may change, so it is left out."""
    return f"{origin[0]}.{origin[1]} -> {end[0]}.{end[1]}"


def bends(network: Network) -> dict[str, Dots]:
    """Wire -> its dots; what are none is left out."""
    found = network.extras.get(KEY)
    wires = found.get("bends") if isinstance(found, Mapping) else None
    return {str(w): d for w, dots in wires.items() if (d := _dots(dots))} if isinstance(wires, Mapping) else {}


def _dots(value: Any) -> Dots:
    pairs = [p for p in value if isinstance(p, list | tuple) and len(p) == 2] if isinstance(value, list | tuple) else []
    return tuple((float(x), float(y)) for x, y in pairs if isinstance(x, int | float) and isinstance(y, int | float))


def with_dots(network: Network, wire: str, dots: Dots) -> Network:
    """With other dots on a wire; those of wires that are gone are forgotten."""
    there = {name(end, origin) for end, origin in network.wires.items()}
    every = {w: [list(d) for d in ds] for w, ds in {**bends(network), wire: dots}.items() if ds and w in there}
    found = network.extras.get(KEY)
    here = {**(found if isinstance(found, Mapping) else {}), "bends": every}
    here = {k: v for k, v in here.items() if v}
    extras = {k: v for k, v in network.extras.items() if k != KEY}
    return replace(network, extras={**extras, KEY: here} if here else extras)


def dot_at(line: WireItem, place: QPointF) -> int | None:
    """Which dot of a wire is there."""
    for i, (x, y) in enumerate(line.dots):
        if abs(x - place.x()) <= REACH and abs(y - place.y()) <= REACH:
            return i
    return None


def toggle(canvas: Canvas, line: WireItem, place: QPointF) -> None:
    """Put a dot on a wire, or take away the one that is there."""
    session, wire = canvas.session, name(line.end, line.origin)
    at = dot_at(line, place)
    if at is not None:
        dots = line.dots[:at] + line.dots[at + 1 :]
        session.edit("Take a dot off a wire", with_dots(session.network, wire, dots))
        return
    spots = [line.path.pointAtPercent(i / 60) for i in range(61)]

    def along(x: float, y: float) -> int:
        return min(range(61), key=lambda i: (spots[i].x() - x) ** 2 + (spots[i].y() - y) ** 2)

    fresh = (snap(place.x()), snap(place.y()))
    dots = tuple(sorted((*line.dots, fresh), key=lambda d: along(*d)))
    session.edit("Put a dot on a wire", with_dots(session.network, wire, dots))


class Bend:
    """A dot follows the hand on the grid; one edit at release."""

    def __init__(self, canvas: Canvas, line: WireItem, index: int) -> None:
        self.canvas, self.line, self.index, self.before = canvas, line, index, line.dots

    def move(self, at: QPoint) -> None:
        """Move it."""
        place = self.canvas.mapToScene(at)
        dots = list(self.line.dots)
        dots[self.index] = (snap(place.x()), snap(place.y()))
        self.line.bend(tuple(dots))

    def release(self, at: QPoint) -> None:
        """One edit, if it moved."""
        if self.line.dots != self.before:
            session = self.canvas.session
            wire = name(self.line.end, self.line.origin)
            session.edit("Move a dot", with_dots(session.network, wire, self.line.dots))

    def cancel(self) -> None:
        """Put it back."""
        self.line.bend(self.before)
