"""What menus and keys do to the network through the canvas: each is one edit of the session."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QGuiApplication

from app.engine.errors import NoniusError
from app.engine.network import Network, Socket
from app.gui import edits, layout
from app.gui.edits import Held
from app.gui.layout import Places, snap

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

MARGIN, ABOVE = 20.0, 44.0


class Hands:
    """Edits of one canvas."""

    def __init__(self, canvas: Canvas) -> None:
        self.canvas = canvas
        self.session = canvas.session

    def _edit(self, label: str, make: Callable[[], Network], merge: Any = None) -> bool:
        """Make an edit; a refusal is said, not raised."""
        try:
            network = make()
        except NoniusError as error:
            self.canvas.say(str(error))
            return False
        if network is not self.session.network:
            self.session.edit(label, network, merge=merge)
        return True

    # --- nodes

    def add(self, module: str, place: QPointF | None = None, held: Held | None = None) -> str:
        """Add a module at a place (beside the selection, or in the middle of the view), wire it, select it; its id."""
        session = self.session
        network, catalogue = self._placed(), session.catalogue
        alone = session.selection[0] if len(session.selection) == 1 and held is None and place is None else ""
        try:
            if place is not None:
                at = self._free(place) if held else (place.x(), place.y())
            elif alone:
                at = edits.after(network, alone)
            else:
                middle = self.canvas.middle()
                at = (middle.x() - layout.WIDTH / 2, middle.y() - layout.HEIGHT / 2)
            grown, fresh = edits.add(network, module, at, catalogue, held)
            if alone:
                grown = self._wired(grown, alone, fresh)
        except NoniusError as error:
            self.canvas.say(str(error))
            return ""
        session.edit(f"Add {catalogue.find(module).title}", grown)
        session.select([fresh])
        return fresh

    def _free(self, place: QPointF) -> tuple[float, float]:
        """The next place below where a plain node covers none."""
        box = QRectF(place.x() - 12, place.y() - 6, layout.WIDTH + 24, layout.HEIGHT + 12)
        taken = [item.scene_rect() for item in self.canvas.board.nodes.values()]
        for _ in range(40):
            if not any(rect.intersects(box) for rect in taken):
                break
            box.translate(0, 2 * layout.SNAP)
        return place.x(), box.top() + 6

    def _wired(self, network: Network, source: str, node: str) -> Network:
        """With the first output of a node that fits wired to a new one, if nothing hangs on it yet."""
        start, end = (edits.record(network, n, self.session.catalogue) for n in (source, node))
        for output in start.outputs if start else ():
            if end and (name := edits.socket_for(end, output.type, True)):
                return network.connect(source, output.name, node, name, self.session.catalogue)
        return network

    def _placed(self) -> Network:
        """The network with a place for every node, so that new ones do not move the others."""
        network = self.session.network
        items = self.canvas.board.nodes
        lost = {n: (i.pos().x(), i.pos().y()) for n, i in items.items() if n in network.nodes and "position" not in i.node.view}
        return network.move(lost) if lost else network

    def remove(self) -> None:
        """Delete what is selected: nodes, a wire, notes and frames."""
        session, canvas = self.session, self.canvas
        marks = [m for m in canvas.board.marks if m.chosen]
        if session.selection:
            names = session.selection
            label = f"Delete {names[0]}" if len(names) == 1 else f"Delete {len(names)} nodes"
            self._edit(label, lambda: edits.bridge(session.network, names, session.catalogue))
        elif canvas.wire is not None:
            self.disconnect(canvas.wire)
        elif marks:
            network = session.network
            for kind in ("frames", "notes"):
                left = [m.record() for m in canvas.board.marks if m.kind == kind and not m.chosen]
                network = edits.with_marks(network, kind, left)
            session.edit("Delete note or frame", network)

    def disconnect(self, wire: Socket) -> None:
        """Take a wire off."""
        self._edit("Disconnect", lambda: self.session.network.disconnect(*wire))

    def copy(self) -> None:
        """The selection to the clipboard, as text."""
        self.session.copy()

    def cut(self) -> None:
        """The selection to the clipboard and out of the network."""
        if names := self.session.selection:
            self.session.copy()
            self._edit("Cut", lambda: self.session.network.remove(*names))

    def paste(self, incoming: bool = False) -> None:
        """Nodes from the clipboard; `incoming` keeps wires from nodes that were not copied."""
        if text := QGuiApplication.clipboard().text():
            self.session.paste(text, incoming)

    def duplicate(self, incoming: bool = True) -> None:
        """The selection once more, with its incoming wires."""
        session = self.session
        names = session.selection
        if not names:
            return
        network = self._placed()
        part = network.part(names)
        fresh = network.pasted_ids(part)
        if self._edit("Duplicate", lambda: network.paste(part, session.catalogue, incoming=incoming, by=(32.0, 32.0))):
            session.select(fresh.values())

    def bypass(self, node: str) -> None:
        """Let what comes into a node go on, or let it fire again; a refusal is said."""
        try:
            self.session.bypass([node])
        except NoniusError as error:
            self.canvas.say(str(error))

    def rename(self, node: str, title: str) -> None:
        """Give a node another title; its own again if it is empty."""
        network = self.session.network
        old = network[node].view.get("title", "")
        if title.strip() != old:
            self._edit("Rename", lambda: network.look(node, title=title.strip() or None))

    # --- places

    def _move(self, label: str, places: Places, merge: Any = None) -> None:
        network = self.session.network
        items = self.canvas.board.nodes
        moved = {n: p for n, p in places.items() if (items[n].pos().x(), items[n].pos().y()) != p}
        if moved:
            self._edit(label, lambda: network.move(moved), merge)

    def _places(self) -> Places:
        items = self.canvas.board.nodes
        return {n: (items[n].pos().x(), items[n].pos().y()) for n in self.session.selection if n in items}

    def nudge(self, dx: float, dy: float) -> None:
        """Move the selection a step; steps in a row are undone as one."""
        places = {n: (x + dx, y + dy) for n, (x, y) in self._places().items()}
        self._move("Nudge", places)

    def align(self, how: str) -> None:
        """Put the selection in a line (left, right, top, bottom) or spread it (across, down)."""
        places = self._places()
        if len(places) > 1:
            self._move("Align", layout.align(places, how, self.canvas.board.sizes(places)))

    def arrange(self) -> None:
        """Lay out the selection, or all, from left to right."""
        board = self.canvas.board
        chosen = [n for n in self.session.selection if n in board.nodes]
        names = chosen if len(chosen) > 1 else list(board.nodes)
        corner = board.bounds(names).topLeft()
        at = (snap(corner.x()), snap(corner.y())) if len(chosen) > 1 else (0.0, 0.0)
        self._move("Lay out", layout.arrange(self.session.network, names, sizes=board.sizes(names), origin=at))
        if len(chosen) <= 1:
            self.canvas.fit()

    # --- frames and notes

    def frame(self) -> None:
        """A frame round the selection."""
        board, network = self.canvas.board, self.session.network
        if not self.session.selection:
            self.canvas.say("Select nodes first: a frame goes round them")
            return
        rect = board.bounds(self.session.selection).adjusted(-MARGIN, -ABOVE, MARGIN, MARGIN)
        self._mark("frames", rect, {"title": "Frame"}, "Frame the selection", network)
        self.canvas.write(board.marks[len(edits.marks(self.session.network, "frames")) - 1])

    def note(self, place: QPointF | None = None) -> None:
        """An empty note, to be written."""
        at = place or self.canvas.middle()
        rect = QRectF(snap(at.x()), snap(at.y()), 200, 88)
        self._mark("notes", rect, {"text": ""}, "Add a note", self.session.network)
        self.canvas.write(self.canvas.board.marks[-1])

    def _mark(self, kind: str, rect: QRectF, words: dict[str, str], label: str, network: Network) -> None:
        box = [float(v) for v in (rect.x(), rect.y(), rect.width(), rect.height())]
        self.session.edit(label, edits.with_marks(network, kind, [*edits.marks(network, kind), {**words, "rect": box}]))

    def written(self, kind: str, index: int, text: str) -> None:
        """Take the text of a note or the title of a frame."""
        network = self.session.network
        items = edits.marks(network, kind)
        key = "title" if kind == "frames" else "text"
        if index < len(items) and items[index].get(key) != text:
            items[index] = {**items[index], key: text}
            self.session.edit("Write", edits.with_marks(network, kind, items))

    def kept(self, network: Network) -> Network:
        """With frames and notes as they stand on the canvas now."""
        for kind in ("frames", "notes"):
            network = edits.with_marks(network, kind, [m.record() for m in self.canvas.board.marks if m.kind == kind])
        return network
