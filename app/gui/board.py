"""The scene of the canvas: one item a node, one a wire, kept equal to the network by identity."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QPointF, QRectF, QTimer
from PySide6.QtWidgets import QGraphicsScene

from app.commands.budget import reach
from app.engine.network import Network, Node, Origin, Socket
from app.gui import badges, bends, edits, layout, minis, motion
from app.gui.glyphs import Look
from app.gui.items import REACH, NodeItem, Plug
from app.gui.marks import MarkItem
from app.gui.wires import WireItem

if TYPE_CHECKING:
    from app.gui.session import Session

TURN = 60
"""Milliseconds between two pictures of a ring that turns."""
STALE = frozenset({"dirty", "queued", "running", "blocked"})


class Board(QGraphicsScene):
    """What is drawn of a network.

    Attributes
    ----------
    nodes, lines, frames : items by id, by socket, in order
    """

    def __init__(self, session: Session, look: Look, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.look = session, look
        self.shown = Network()
        self.nodes: dict[str, NodeItem] = {}
        self.lines: dict[Socket, WireItem] = {}
        self.marks: list[MarkItem] = []
        self.by_keys = False
        self._touching: dict[str, set[Socket]] = {}
        self._places: layout.Places = {}
        self._bends: dict[str, bends.Dots] = {}
        self._timer = QTimer(self, interval=TURN)
        self._timer.timeout.connect(self._turn)
        self.setItemIndexMethod(QGraphicsScene.ItemIndexMethod.NoIndex)
        self.setSceneRect(-200_000, -200_000, 400_000, 400_000)

    # --- following the network

    def sync(self, network: Network) -> int:
        """Draw another network; how many items were touched."""
        old, self.shown = self.shown, network
        if network is old:
            return 0
        touched: set[str] = set()
        if network.nodes is not old.nodes:
            touched = self._sync_nodes(network)
        changed = self._sync_wires(network, touched, old.wires)
        if network.extras is not old.extras:
            self._sync_marks(network)
            self._bends = bends.bends(network)
            for line in self.lines.values():
                if (dots := self._bends.get(bends.name(line.end, line.origin), ())) != line.dots:
                    line.bend(dots)
        return len(touched) + changed

    def _sync_nodes(self, network: Network) -> set[str]:
        for name in [n for n in self.nodes if n not in network.nodes]:
            self.removeItem(self.nodes.pop(name))
        touched = set()
        lost = [n for n, node in network.nodes.items() if n not in self.nodes and "position" not in node.view]
        if lost:
            self._places |= self._place(network, lost)
        for name, node in network.nodes.items():
            item = self.nodes.get(name)
            if item is None:
                touched.add(name)
                self._new_node(node)
            elif item.node is not node:
                touched.add(name)
                record = self.session.catalogue.get(node.module)
                item.set_node(node, record)
                item.setPos(self.place(node))
                item.set_state(self.session.state(name), self.session.facts(name))
                self._know(item)
        return touched

    def _place(self, network: Network, lost: list[str]) -> layout.Places:
        """Places for nodes that have none."""
        known = [n.view["position"] for n in network.nodes.values() if "position" in n.view]
        below = max((y for _, y in known), default=-layout.COLUMN) + layout.COLUMN
        return layout.arrange(network, lost, origin=(min((x for x, _ in known), default=0.0), below if known else 0.0))

    def _new_node(self, node: Node) -> None:
        record, state = self.session.catalogue.get(node.module), self.session.state(node.id)
        item = NodeItem(node, record, self.look, state, self.session.facts(node.id))
        item.chosen = node.id in self.session.selection
        item.by_keys = self.by_keys
        self._know(item)
        item.setPos(self.place(node))
        self.nodes[node.id] = item
        self.addItem(item)

    def place(self, node: Node) -> QPointF:
        """Where a node stands."""
        x, y = node.view.get("position") or self._places.get(node.id, (0.0, 0.0))
        return QPointF(float(x), float(y))

    def _sync_wires(self, network: Network, touched: set[str], old: Mapping[Socket, Origin]) -> int:
        ends: set[str] = set()
        sources: set[str] = set()
        if network.wires is old:
            self.route(touched)
            return 0
        for end, line in list(self.lines.items()):
            if network.wires.get(end) != line.origin:
                ends.add(end[0])
                sources.add(line.origin[0])
                self._drop(end)
        fresh = [(end, origin) for end, origin in network.wires.items() if end not in self.lines]
        for end, _ in fresh:
            ends.add(end[0])
        unknown = {n for n in touched | ends if n in self.nodes}
        for target in unknown:
            if target in network.incoming or self.nodes[target].wired or self.nodes[target].record is None:
                self._count(network, target)
        for end, origin in fresh:
            self._new_wire(end, origin)
            sources.add(origin[0])
            if (start := self.nodes.get(origin[0])) and start.record is None:
                self._count(network, origin[0])
        self.route(touched | ends)
        for source in sources & set(self.nodes):
            self.tell(source)
        return len(fresh)

    def _count(self, network: Network, node: str) -> None:
        wired = {port: len(origins) for port, origins in network.incoming.get(node, {}).items()}
        item = self.nodes[node]
        given: tuple[str, ...] = ()
        if item.record is None:
            given = tuple(sorted({o for s, o in network.wires.values() if s == node}))
        item.set_wired(wired, given)

    def _new_wire(self, end: Socket, origin: Origin) -> None:
        start = self.nodes[origin[0]]
        plug = start.plug(origin[1], True)
        target = self.nodes[end[0]].plug(end[1], False, end[2])
        kind = plug.kind if plug and start.record else target.kind if target else "Value"
        line = WireItem(end, origin, kind, self.look)
        self.lines[end] = line
        line.dots = self._bends.get(bends.name(end, origin), ()) if self._bends else ()
        for node in (end[0], origin[0]):
            self._touching.setdefault(node, set()).add(end)
        self.addItem(line)

    def _drop(self, end: Socket) -> None:
        line = self.lines.pop(end)
        self.removeItem(line)
        if line.badge is not None:
            self.removeItem(line.badge)
        for node in (end[0], line.origin[0]):
            self._touching.get(node, set()).discard(end)

    def _sync_marks(self, network: Network) -> None:
        for item in self.marks:
            self.removeItem(item)
        self.marks = []
        for kind in ("frames", "notes"):
            for i, mark in enumerate(edits.marks(network, kind)):
                item = MarkItem(kind, i, mark, self.look)
                self.marks.append(item)
                self.addItem(item)

    # --- following places and results

    def route(self, nodes: Iterable[str]) -> None:
        """Lay the wires of some nodes again."""
        for end in {e for n in nodes for e in self._touching.get(n, ())}:
            line = self.lines[end]
            start, stop = self.nodes[line.origin[0]], self.nodes[end[0]]
            out, into = start.plug(line.origin[1], True), stop.plug(end[1], False, end[2])
            a = start.where(out) if out else start.scene_rect().topRight() + QPointF(0, 44)
            b = stop.where(into) if into else stop.pos() + QPointF(0, 44)
            line.route(a, b)

    def refresh(self, node: str) -> None:
        """A state changed."""
        item = self.nodes.get(node)
        if item is None:
            return
        state = self.session.state(node)
        was = item.state.kind in STALE
        if item.set_state(state, self.session.facts(node)):
            self.route([node])
        if was != (state.kind in STALE):
            self.tell(node)
        if state.kind == "running" and state.progress is None and not self._timer.isActive() and not motion.reduced():
            self._timer.start()

    def result(self, node: str) -> None:
        """A result, or what is known of it, changed."""
        self.refresh(node)
        if node in self.nodes:
            self.tell(node)
            for below in self.shown.graph.successors(node):
                if below in self.nodes:
                    self._know(self.nodes[below])

    def _know(self, item: NodeItem) -> None:
        """Tell a node with mini controls what is known of its inputs."""
        if minis.pins(item.node):
            item.set_known(self.session.input_facts(item.node.id))

    def tell(self, source: str) -> None:
        """Say on the wires of a node what is known."""
        by: dict[str, list[WireItem]] = {}
        for end in self._touching.get(source, ()):
            if (line := self.lines[end]).origin[0] == source:
                by.setdefault(line.origin[1], []).append(line)
        stale = self.nodes[source].state.kind in STALE
        for output, lines in by.items():
            value = (self.session.outputs(source) or {}).get(output.partition(":")[0])
            known = badges.known(self.session.budget(source, output), reach(value))
            first = min(lines, key=lambda line: (abs(line.path.boundingRect().height()), line.end))
            for line in lines:
                line.set_known(known, line is first and line.kind not in ("Layer", "Scene", "Accuracy"), stale)

    def select(self, chosen: Iterable[str]) -> None:
        """Ring the selected nodes."""
        names = set(chosen)
        for name, item in self.nodes.items():
            if item.chosen != (name in names):
                item.chosen = name in names
                item.setZValue(1 if item.chosen else 0)
                item.update()

    def show_focus(self, on: bool) -> None:
        """Dash the ring of what is selected, since it was chosen by keys; or draw it whole."""
        if on != self.by_keys:
            self.by_keys = on
            for item in self.nodes.values():
                item.by_keys = on
                if item.chosen:
                    item.update()

    def _turn(self) -> None:
        turning = [i for i in self.nodes.values() if i.kind == "running" and i.state.progress is None]
        for item in turning:
            item.turn = (item.turn + TURN / 1200) % 1.0
            item.update()
        if not turning:
            self._timer.stop()

    # --- asking

    def bounds(self, nodes: Iterable[str] | None = None) -> QRectF:
        """The rectangle round some nodes, all and the frames by default."""
        rect = QRectF()
        for name in self.nodes if nodes is None else nodes:
            if name in self.nodes:
                rect = rect.united(self.nodes[name].scene_rect())
        if nodes is None:
            for mark in self.marks:
                rect = rect.united(mark.scene_rect())
        return rect

    def sizes(self, nodes: Iterable[str]) -> dict[str, tuple[float, float]]:
        """Width and height of nodes."""
        return {n: self.nodes[n].size for n in nodes if n in self.nodes}

    def plug_at(self, place: QPointF, reach: float = REACH) -> tuple[NodeItem, Plug] | None:
        """The socket at a place of the canvas."""
        best: tuple[float, NodeItem, Plug] | None = None
        for item in self.near(place, reach):
            if plug := item.plug_at(place, reach):
                gap = item.where(plug) - place
                far = gap.x() ** 2 + gap.y() ** 2
                if best is None or far < best[0]:
                    best = (far, item, plug)
        return best[1:] if best else None

    def near(self, place: QPointF, reach: float = 0.0) -> list[NodeItem]:
        """Nodes at a place, the uppermost first."""
        x, y = place.x(), place.y()
        found = []
        for item in self.nodes.values():
            at, (w, h) = item.pos(), item.size
            if at.x() - reach <= x <= at.x() + w + reach and at.y() - reach <= y <= at.y() + h + reach:
                found.append(item)
        return sorted(found, key=lambda i: -i.zValue())

    def wire_at(self, place: QPointF) -> WireItem | None:
        """The wire at a place."""
        box = QRectF(place.x() - 6, place.y() - 6, 12, 12)
        for line in self.lines.values():
            if line.badge is not None and line.badge.isVisible() and line.badge.rect.contains(place):
                return line
        for line in self.lines.values():
            if line.boundingRect().intersects(box) and line.shape().intersects(box):
                return line
        return None

    def mark_at(self, place: QPointF) -> MarkItem | None:
        """The note at a place, or the frame whose title or corner is there."""
        return next((m for m in reversed(self.marks) if m.takes(place)), None)

    def ends(self, item: NodeItem, held: Container[str]) -> list[tuple[float, float, QRectF]]:
        """Of each wire of a node to one that is not held: height of its socket in the node, of that at the other end; node."""
        found = []
        for end in self._touching.get(item.node.id, ()):
            line = self.lines[end]
            out = line.origin[0] == item.node.id
            other = self.nodes[end[0] if out else line.origin[0]]
            start, stop = self.nodes[line.origin[0]].plug(line.origin[1], True), self.nodes[end[0]].plug(end[1], False, end[2])
            if start is None or stop is None or other.node.id in held:
                continue
            mine, theirs = (start, stop) if out else (stop, start)
            found.append((mine.y, other.where(theirs).y(), other.scene_rect()))
        return found

    def colour(self) -> None:
        """Draw all in another theme."""
        for item in self.items():
            item.update()
        self.update()
