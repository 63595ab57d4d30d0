"""Guides while nodes are dragged: edges, middles and wires that come to lie in line with others, which then attract."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QLineF, QRectF

NEAR: Final = 5.0
"""Units of the canvas within which a line attracts; the grid is 8."""
ROOM: Final = 1200.0
"""Nodes farther away are not looked at."""
OVER: Final = 12.0


@dataclass(frozen=True)
class Found:
    """How far to move, None along an axis on which nothing attracts, and the lines that are then in line."""

    dx: float | None
    dy: float | None
    lines: tuple[QLineF, ...]


def find(held: QRectF, others: Sequence[QRectF], rows: Iterable[tuple[float, float, QRectF]] = ()) -> Found:
    """The nearest lines across and down.

    Parameters
    ----------
    held : what is dragged
    others : nodes that stay
    rows : (height of a socket that is dragged, height of the socket at the other end, node there): a straight wire goes first
    """
    near = [o for o in others if o.intersects(held.adjusted(-ROOM, -ROOM, ROOM, ROOM))]
    across = [(b - a, b, o) for o in near for a, b in zip(_across(held), _across(o), strict=True)]
    down = [(b - a, b, o) for o in near for a, b in zip(_down(held), _down(o), strict=True)]
    wires = [(end - start, end, o) for start, end, o in rows]
    dx, dy = _nearest(across), _nearest(wires)
    dy = _nearest(down) if dy is None else dy
    moved = held.translated(dx or 0.0, dy or 0.0)
    lines = [_line(at, moved, o, upright=True) for g, at, o in across if dx is not None and abs(g - dx) < 0.01]
    lines += [_line(at, moved, o, upright=False) for g, at, o in (*wires, *down) if dy is not None and abs(g - dy) < 0.01]
    return Found(dx, dy, tuple(_once(lines)))


def _nearest(gaps: Iterable[tuple[float, float, QRectF]]) -> float | None:
    return min((gap for gap, _, _ in gaps if abs(gap) <= NEAR), key=abs, default=None)


def _across(rect: QRectF) -> tuple[float, float, float]:
    return rect.left(), rect.center().x(), rect.right()


def _down(rect: QRectF) -> tuple[float, float, float]:
    return rect.top(), rect.center().y(), rect.bottom()


def _line(at: float, one: QRectF, other: QRectF, *, upright: bool) -> QLineF:
    if upright:
        return QLineF(at, min(one.top(), other.top()) - OVER, at, max(one.bottom(), other.bottom()) + OVER)
    return QLineF(min(one.left(), other.left()) - OVER, at, max(one.right(), other.right()) + OVER, at)


def _once(lines: list[QLineF]) -> list[QLineF]:
    """Of lines at one place the longest."""
    best: dict[tuple[bool, float], QLineF] = {}
    for line in lines:
        upright = line.x1() == line.x2()
        key = (upright, round(line.x1() if upright else line.y1(), 1))
        if key not in best or best[key].length() < line.length():
            best[key] = line
    return list(best.values())

