"""A wire in the hand: what fits grows, what does not fades and says why; release connects, converts, or asks for a module."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, QPointF

from app.engine.errors import NoniusError
from app.engine.network import Socket
from app.gui import edits
from app.gui.edits import Fitting, Held
from app.gui.glyphs import TYPES
from app.gui.items import NodeItem, Plug, Verdict
from app.gui.wires import LooseWire

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

SNAP = 24.0
"""Pixels round a socket within which the wire jumps to it."""


class Pull:
    """One end of a wire is held by a socket, the other follows the hand.

    Parameters
    ----------
    held : the socket that keeps its end
    off : the wire that was pulled off, None for a new one
    """

    def __init__(self, canvas: Canvas, at: QPoint, held: Held, off: Socket | None = None) -> None:
        self.canvas, self.held, self.off, self.start = canvas, held, off, at
        session = canvas.session
        self.network = edits.move(session.network, off) if off else session.network
        self.fitting = Fitting(self.network, session.catalogue, held)
        self.over: tuple[NodeItem, Plug, Verdict] | None = None
        self.moved = False
        self.loose = LooseWire(held.kind, canvas.look)
        canvas.board.addItem(self.loose)
        if off and (line := canvas.board.lines.get(off)):
            line.hide()
        seen = canvas.mapToScene(canvas.viewport().rect()).boundingRect()
        for name, item in canvas.board.nodes.items():
            if name != held.node and item.scene_rect().intersects(seen):
                item.show_settings(held.kind == "Value" and held.out)
                item.verdicts = self.fitting.verdicts(name)
                item.update()
        for line in canvas.board.lines.values():
            line.faded = True
        canvas.board.update()
        self._draw(canvas.mapToScene(at), False)

    # --- while it is held

    def move(self, at: QPoint) -> None:
        """Look for a socket near the pointer."""
        if (at - self.start).manhattanLength() > 5:
            self.moved = True
        place = self.canvas.mapToScene(at)
        self.over = self._target(place)
        dotted = bool(self.over and not self.over[2].fits and self.over[2].converters)
        good = self.over and (self.over[2].fits or dotted)
        self._draw(self.over[0].where(self.over[1]) if self.over and good else place, dotted)
        self.canvas.bubble.say(*self._words(), at)

    def _target(self, place: QPointF) -> tuple[NodeItem, Plug, Verdict] | None:
        board = self.canvas.board
        reach = SNAP / self.canvas.zoom
        best: tuple[float, NodeItem, Plug, Verdict] | None = None
        for item in board.near(place, reach):
            if item.node.id == self.held.node:
                continue
            if item.verdicts is None:
                item.verdicts = self.fitting.verdicts(item.node.id)
            body = item.rect.contains(place - item.pos())
            for plug in item.plugs:
                gap = item.where(plug) - place
                far = (gap.x() ** 2 + gap.y() ** 2) ** 0.5
                verdict = item.verdicts.get((plug.name, plug.out))
                if verdict is None or plug.out == self.held.out or not (body or far <= reach):
                    continue
                rank = far + (0 if verdict.fits else 1e4 if verdict.converters else 2e4)
                rank += 500 if body and far >= reach else 0
                if far <= reach / 2 and plug.free is False:
                    rank = far + (0 if verdict.fits else 300)
                if best is None or rank < best[0]:
                    best = (rank, item, plug, verdict)
        return best[1:] if best else None

    def _words(self) -> tuple[str, str]:
        if self.over is None:
            return "", ""
        item, plug, verdict = self.over
        kind = TYPES.get(plug.kind, plug.kind)
        if verdict.fits:
            full = plug.name in item.wired and not plug.out and not plug.free
            how = "fits: drop to take the place of the wire there" if full else "fits: drop to connect"
            return f"{plug.name} · {kind}", how
        if verdict.converters:
            record = self.canvas.session.catalogue.find(verdict.converters[0])
            return f"{plug.name} · {kind}", f"drop to put {record.title} between"
        why, _, advice = verdict.why.partition(": ")
        return f"{item.title}: {why}", f"{advice[:1].upper() + advice[1:] if advice else self._advice(plug.kind)}."

    def _advice(self, kind: str) -> str:
        pair = (self.held.kind, kind) if self.held.out else (kind, self.held.kind)
        found = edits.between(*pair, self.canvas.session.catalogue)
        if found is None:
            return "Drop on the empty canvas to choose a module that fits"
        return f"Put a module between, such as {found.title}: drop on the empty canvas"

    def _draw(self, place: QPointF, dotted: bool) -> None:
        item = self.canvas.board.nodes[self.held.node]
        plug = item.plug(self.held.name, self.held.out, self.held.slot)
        anchor = item.where(plug) if plug else item.scene_rect().center()
        self.loose.route(*((anchor, place) if self.held.out else (place, anchor)), dotted)

    # --- at the end

    def release(self, at: QPoint) -> None:
        """Connect, convert, disconnect, or ask for a module."""
        self.move(at)
        over = self.over
        self.cancel()
        if not self.moved:
            return
        session = self.canvas.session
        if over is None:
            if self.off:
                session.edit("Disconnect", self.network)
            else:
                self.canvas.quick_add(at, self.held)
            return
        item, plug, verdict = over
        node, catalogue, slot = item.node.id, session.catalogue, None if plug.free else plug.slot
        try:
            if verdict.fits:
                network = edits.join(self.network, self.held, node, plug.name, catalogue, slot)
                if network.wires != session.network.wires:
                    session.edit("Move wire" if self.off else "Connect", network)
            elif verdict.converters:
                title = catalogue.find(verdict.converters[0]).title
                network = edits.convert(self.network, self.held, node, plug.name, verdict.converters[0], catalogue, slot)
                session.edit(f"Connect through {title}", network)
        except NoniusError as error:
            self.canvas.say(str(error))

    def cancel(self) -> None:
        """Put all back."""
        canvas = self.canvas
        canvas.bubble.hush()
        canvas.board.removeItem(self.loose)
        for item in canvas.board.nodes.values():
            item.show_settings(False)
            item.verdicts = None
            item.update()
        for line in canvas.board.lines.values():
            line.faded = False
        if self.off and (back := canvas.board.lines.get(self.off)):
            back.show()
        canvas.board.update()
