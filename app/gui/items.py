"""A node on the canvas: one item that paints header, lines, ports and state, and knows where its ports are."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetricsF, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.gui import glyphs, minis, summary
from app.gui.glyphs import Look, font

if TYPE_CHECKING:
    from app.engine.network import Node
    from app.gui.session import NodeState
    from modules.declare import Module

WIDTH: Final = 150.0
WIDEST: Final = 264.0
HEADER: Final = 28.0
PLAIN: Final = 76.0
FIRST: Final = 44.0
PITCH: Final = 22.0
PITCH_TWIN: Final = 30.0
TWIN: Final = 15.0
REACH: Final = 10.0
"""Half the hit area of a port."""
NO_TWIN: Final = ("Layer", "Scene", "Table", "Value", "ColourMap")


@dataclass(frozen=True)
class Plug:
    """A socket of a node: where a wire starts or may end.

    Parameters
    ----------
    name : port, parameter or output; a twin is "<output>:accuracy"
    kind : wire type, by name
    out : whether it gives
    slot : place in a list
    free : the place after the last of a list
    """

    name: str
    kind: str
    out: bool
    x: float
    y: float
    slot: int = 0
    free: bool = False

    @property
    def at(self) -> QPointF:
        """Place in the node."""
        return QPointF(self.x, self.y)


@dataclass(frozen=True)
class Verdict:
    """Whether the wire in the hand fits a plug, and why not; `converters` would make it fit."""

    fits: bool
    why: str = ""
    converters: tuple[str, ...] = ()


@functools.lru_cache(maxsize=4096)
def _wide(title: str) -> float:
    return QFontMetricsF(font(12, True)).horizontalAdvance(title)


class NodeItem(QGraphicsItem):
    """One node.

    Attributes
    ----------
    plugs : sockets, inputs first
    verdicts : plug name -> verdict while a wire is dragged; None otherwise
    """

    def __init__(self, node: Node, record: Module | None, look: Look, state: NodeState, facts: Mapping[str, Any]) -> None:
        super().__init__()
        self.node, self.record, self.look, self.state, self.facts = node, record, look, state, facts
        self._first: str | None = None
        self._bounds = QRectF()
        self.known: Mapping[str, Mapping[str, Any]] = {}
        self.wired: Mapping[str, int] = {}
        self.given: tuple[str, ...] = ()
        self.chosen = self.hovered = self.settings_shown = self.by_keys = False
        self.verdicts: Mapping[tuple[str, bool], Verdict] | None = None
        self.turn = 0.0
        self.plugs: tuple[Plug, ...] = ()
        self.size = (WIDTH, PLAIN)
        self.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)
        self._measure()

    # --- changing

    def set_node(self, node: Node, record: Module | None) -> None:
        """Take another version of the node."""
        self.node, self.record, self._first = node, record, None
        self._measure()

    def set_state(self, state: NodeState, facts: Mapping[str, Any]) -> bool:
        """Take a state; whether the size changed."""
        before = self.size
        again = (state.kind == "failed") != (self.state.kind == "failed") or state.sentence != self.state.sentence
        self.state, self.facts = state, facts
        if again:
            self._measure()
        self.update()
        return self.size != before

    def set_wired(self, wired: Mapping[str, int], given: tuple[str, ...]) -> bool:
        """Say how many wires each port has, and which outputs are used though nobody declares them; whether plugs changed."""
        before = self.plugs
        if (wired, given) == (self.wired, self.given):
            return False
        self.wired, self.given = wired, given
        self._measure()
        return self.plugs != before

    def set_known(self, known: Mapping[str, Mapping[str, Any]]) -> None:
        """Say what is known of the inputs: the ends of mini sliders hang on it."""
        if known != self.known:
            self.known = known
            self._measure()
            self.update()

    def show_settings(self, shown: bool) -> None:
        """Show the sockets of all parameters, or only of those that are wired."""
        if shown != self.settings_shown:
            self.settings_shown = shown
            self._measure()

    # --- asking

    @property
    def first(self) -> str:
        """What it does here."""
        if self._first is None:
            self._first = summary.does(self.node, self.record)
        return self._first

    @property
    def kind(self) -> str:
        """The state to draw; a node without a module or that is disabled says so whatever the engine knows."""
        if self.record is None:
            return "missing"
        return "disabled" if self.node.disabled else "bypassed" if self.node.bypass else self.state.kind

    @property
    def rect(self) -> QRectF:
        """The body."""
        return QRectF(0, 0, *self.size)

    def scene_rect(self) -> QRectF:
        """The body on the canvas."""
        return self.rect.translated(self.pos())

    def plug(self, name: str, out: bool, slot: int = 0) -> Plug | None:
        """The socket of a name."""
        named = [p for p in self.plugs if p.name == name and p.out is out]
        return next((p for p in named if p.slot == slot), named[-1] if named else None)

    def plug_at(self, place: QPointF, reach: float = REACH) -> Plug | None:
        """The nearest socket to a place of the canvas, within reach."""
        local = place - self.pos()
        best, found = reach * reach, None
        for plug in self.plugs:
            dx, dy = plug.x - local.x(), plug.y - local.y()
            far = dx * dx + dy * dy
            if far <= best:
                best, found = far, plug
        return found

    def mini_at(self, place: QPointF) -> minis.Mini | None:
        """The control at a place of the canvas."""
        return next((m for m in self.minis if m.rect.contains(place - self.pos())), None)

    def stop_rect(self) -> QRectF:
        """The state badge, on the canvas."""
        return QRectF(self.size[0] - 25, 4, 20, 20).translated(self.pos())

    def where(self, plug: Plug) -> QPointF:
        """The place of a socket on the canvas."""
        return self.pos() + plug.at

    # --- measuring

    def _measure(self) -> None:
        self.prepareGeometryChange()
        self.title = summary.title(self.node, self.record)
        failed = self.kind == "failed"
        wide = _wide(self.title) + 32 + 36
        if failed and self.state.sentence:
            wide = max(wide, QFontMetricsF(font(11)).horizontalAdvance(self.state.sentence) + 28)
        outputs = self._outputs()
        self.named = len(outputs) > 2
        if self.named:
            wide = max(wide, 128 + max(_wide(name) for name, _, _ in outputs))
        if minis.pins(self.node):
            wide = max(wide, minis.LEAST)
        self.width = min(WIDEST, WIDTH + 8 * max(0, -(-(wide - WIDTH) // 8)))
        inputs = self._inputs()
        pitch = PITCH_TWIN if any(twin for _, _, twin in outputs) else PITCH
        plugs = [Plug(n, k, False, 0, FIRST + PITCH * i, s, f) for i, (n, k, s, f) in enumerate(inputs)]
        low = FIRST + PITCH * (len(inputs) - 1) + 14
        for i, (name, kind, twin) in enumerate(outputs):
            y = FIRST + pitch * i
            plugs.append(Plug(name, kind, True, self.width, y))
            if twin:
                plugs.append(Plug(f"{name}:accuracy", "Accuracy", True, self.width, y + TWIN))
            low = max(low, y + (TWIN + 12 if twin else 16))
        self.plugs = tuple(plugs)
        self.sentence = QRectF()
        self.minis = minis.of(self.node, self.record, self.wired, self.known, self.width, 50)
        self.below = minis.HEIGHT * len(self.minis)
        height = max(PLAIN + self.below, 4 * -(-low // 4))
        if failed:
            height = max(height, self._failed_height())
        self.size = (self.width, height)
        self._bounds = self.rect.adjusted(-20, -8, 20, 8)

    def _failed_height(self) -> float:
        room = QRectF(0, 0, self.width - 28, 400)
        flags = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignLeft
        text = QFontMetricsF(font(11)).boundingRect(room, flags, self.state.sentence or "failed")
        top = 54 + self.below
        height = 4 * -(-(top + text.height() + 12) // 4)
        self.sentence = QRectF(0, top, self.width, height - top)
        return float(height)

    def _inputs(self) -> list[tuple[str, str, int, bool]]:
        """(name, type, slot, free) of each socket at the left."""
        if self.record is None:
            return [(name, "Value", slot, False) for name, n in sorted(self.wired.items()) for slot in range(n)]
        found = []
        for port in self.record.ports:
            n = self.wired.get(port.name, 0)
            found += [(port.name, port.type.__name__, slot, False) for slot in range(max(n, 1))]
            if port.many and n:
                found.append((port.name, port.type.__name__, n, True))
        for parameter in self.record.parameters:
            if self.settings_shown or parameter.name in self.wired:
                found.append((parameter.name, "Value", 0, parameter.name not in self.wired))
        return found

    def _outputs(self) -> list[tuple[str, str, bool]]:
        """(name, type, whether it has a twin) of each output."""
        if self.record is None:
            return [(name, "Value", False) for name in self.given]
        return [(o.name, o.type.__name__, o.type.__name__ not in NO_TWIN) for o in self.record.outputs]

    # --- painting

    def boundingRect(self) -> QRectF:
        """The body, its ring and ports at double size."""
        return self._bounds

    def shape(self) -> QPainterPath:
        """The body and the reach of its ports."""
        path = QPainterPath()
        path.addRect(self.rect.adjusted(-REACH, 0, REACH, 0))
        return path

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw what the zoom leaves room for."""
        detail = option.levelOfDetailFromTransform(painter.worldTransform())
        if self.verdicts is not None and not any(v.fits or v.converters for v in self.verdicts.values()):
            painter.setOpacity(0.35)
        if detail < 0.3:
            self._paint_far(painter)
            return
        self._paint_body(painter)
        if detail >= 0.6:
            self._paint_text(painter)
        self._paint_ports(painter)

    def _paint_far(self, painter: QPainter) -> None:
        role = {"failed": "failed", "running": "action", "missing": "flag"}.get(self.kind, "edge")
        painter.fillRect(self.rect, self.look["action" if self.chosen else role])

    def _paint_body(self, painter: QPainter) -> None:
        look, rect, kind = self.look, self.rect, self.kind
        edge = QPen(look["text 2" if self.hovered else "node edge"], 1.0)
        if kind == "failed":
            edge = QPen(look["failed"], 1.5)
        elif kind == "missing":
            edge.setDashPattern([4, 3])
        body = QPainterPath()
        body.addRoundedRect(rect, 6, 6)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.fillPath(body, look["raised"])
        painter.save()
        painter.setClipRect(QRectF(0, 0, self.width, HEADER), Qt.ClipOperation.IntersectClip)
        painter.fillPath(body, look["track" if self.hovered else "head"])
        painter.restore()
        if not self.sentence.isNull():
            painter.save()
            painter.setClipRect(self.sentence, Qt.ClipOperation.IntersectClip)
            painter.fillPath(body, look["failed ground"])
            painter.restore()
            painter.setPen(QPen(look["failed"], 1))
            painter.drawLine(self.sentence.topLeft(), self.sentence.topRight())
        if kind == "running" and self.state.progress is not None:
            self._paint_bar(painter)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(edge)
        painter.drawPath(body)
        if kind == "bypassed":
            self._paint_through(painter)
        if self.chosen:
            ring = QPen(look["action"], 2)
            if self.by_keys:
                ring.setDashPattern([2, 1.5])
            painter.setPen(ring)
            painter.drawRoundedRect(rect.adjusted(-3.5, -3.5, 3.5, 3.5), 9, 9)
        quiet = kind in ("blocked", "disabled", "bypassed", "held")
        glyphs.room(painter, self.record.room if self.record else "missing", QPointF(10, 6), look["text 2"])
        painter.setFont(font(12, True))
        painter.setPen(look["text 2" if quiet else "text"])
        linked = bool(self.node.follows)
        if linked:
            glyphs.room(painter, "link", QPointF(self.width - 42, 8), look["text 2"], 12)
        room = QRectF(32, 0, self.width - 32 - (48 if linked else 32), HEADER)
        title = QFontMetricsF(font(12, True)).elidedText(self.title, Qt.TextElideMode.ElideRight, room.width())
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, title)
        glyphs.state(painter, kind, QPointF(self.width - 15, 14), look, self.state.progress, self.turn)

    def _paint_through(self, painter: QPainter) -> None:
        """Lines from the ports that go on to the outputs in their place."""
        for output, port in self.node.bypass.items():
            start, end = self.plug(port, False), self.plug(output, True)
            if start and end:
                pen = QPen(self.look.port(end.kind), 2.25)
                pen.setDashPattern([2, 2])
                painter.setPen(pen)
                way = QPainterPath(start.at)
                way.cubicTo(QPointF(self.width / 2, start.y), QPointF(self.width / 2, end.y), end.at)
                painter.drawPath(way)

    def _paint_bar(self, painter: QPainter) -> None:
        y = self.size[1] - 3
        painter.fillRect(QRectF(2, y, self.width - 4, 2), self.look["track"])
        painter.fillRect(QRectF(2, y, (self.width - 4) * min(1.0, self.state.progress or 0.0), 2), self.look["action"])

    def _paint_text(self, painter: QPainter) -> None:
        look = self.look
        painter.setFont(font(11))
        metrics = QFontMetricsF(font(11))
        wide = 96.0 if self.named else self.width - 24
        painter.setPen(look["text 2"])
        if self.kind != "bypassed":  # there the way through is drawn
            painter.drawText(QPointF(12, 45), metrics.elidedText(self.first, Qt.TextElideMode.ElideRight, wide))
        if not self.sentence.isNull():
            painter.setPen(look["text"])
            flags = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(self.sentence.adjusted(14, 2, -14, -2), flags, self.state.sentence or "failed")
        else:
            painter.setPen(look["action" if self.kind == "running" else "text 3"])
            said = self.kind in ("missing", "disabled", "bypassed")
            text = summary.WAITS[self.kind] if said else summary.went(self.state, self.facts)
            painter.drawText(QPointF(12, 66 + self.below), metrics.elidedText(text, Qt.TextElideMode.ElideRight, wide))
        for mini in self.minis:
            minis.paint(painter, mini, look)
        if self.named:
            painter.setPen(look["text 3"])
            for plug in self.plugs:
                if plug.out and plug.kind != "Accuracy":
                    place = QRectF(self.width - 92, plug.y - 8, 80, 16)
                    painter.drawText(place, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, plug.name)

    def _paint_ports(self, painter: QPainter) -> None:
        whole = painter.opacity()
        for plug in self.plugs:
            verdict = self.verdicts.get((plug.name, plug.out)) if self.verdicts is not None else None
            scale = 0.8 if plug.kind == "Accuracy" else 1.0
            if verdict and verdict.fits:
                painter.setPen(QPen(self.look.port(plug.kind), 1.5))
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawEllipse(plug.at, 17, 17)
                scale *= 2
            elif self.verdicts is not None and not (verdict and verdict.converters):
                painter.setOpacity(min(whole, 0.35))
            glyphs.port(painter, plug.kind, plug.at, self.look, scale=scale, ground="canvas", free=plug.free)
            painter.setOpacity(whole)
