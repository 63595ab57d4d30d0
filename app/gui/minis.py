"""Mini controls: one or two parameters shown on their node, as a slider, a switch or a choice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QMenu

from app.draw import numbers
from app.engine.errors import NetworkError, NoniusError
from app.engine.network import Network, Node
from app.gui import glyphs
from app.gui.glyphs import Look, font
from app.gui.widgets.field import Facts, title
from app.gui.widgets.number import number_of
from app.gui.widgets.scale import Scale, scale_of
from modules.data.formula import FormulaError
from modules.parameters import Parameter

if TYPE_CHECKING:
    from app.gui.canvas import Canvas
    from app.gui.items import NodeItem
    from modules.declare import Module

MOST: Final = 2
HEIGHT: Final = 24.0
LEAST: Final = 184.0
"""Width of a node with mini controls."""
LABEL, NUMBER = 56.0, 44.0


def can(parameter: Parameter) -> bool:
    """Whether a parameter can be shown on a node."""
    return parameter.type in (int, float, bool) or bool(parameter.options)


def pins(node: Node) -> tuple[str, ...]:
    """The parameters that a node shows."""
    held = node.view.get("pins", ())
    return tuple(str(n) for n in held)[:MOST] if isinstance(held, list | tuple) else ()


def ends(node: Node, name: str) -> tuple[float, float] | None:
    """Ends of a slider that the user chose."""
    held = node.view.get("ends")
    found = held.get(name) if isinstance(held, Mapping) else None
    return (float(found[0]), float(found[1])) if isinstance(found, list | tuple) and len(found) == 2 else None


def powers(node: Node, name: str) -> bool | None:
    """Whether the user wants a slider in powers; None for as declared."""
    held = node.view.get("powers")
    found = held.get(name) if isinstance(held, Mapping) else None
    return found if isinstance(found, bool) else None


def pinned(network: Network, node: str, name: str) -> tuple[str, Network]:
    """(label, network) with a parameter on its node, or taken off it.

    Raises
    ------
    NetworkError : there are two already
    """
    there = pins(network[node])
    words = name.replace("_", " ")
    if name in there:
        kept = [n for n in there if n != name]
        return f"Take {words} off {node}", network.look(node, pins=kept or None)
    if len(there) >= MOST:
        raise NetworkError(f"{node} shows {' and '.join(there)} already: take one off first", node=node)
    return f"Show {words} on {node}", network.look(node, pins=[*there, name])


@dataclass(frozen=True)
class Mini:
    """One control on a node.

    Parameters
    ----------
    rect : in the node
    scale : of a number whose ends are known
    wired : whether its value comes from a wire
    led : the parameter that it follows, "" for none
    """

    parameter: Parameter
    value: Any
    rect: QRectF
    scale: Scale | None
    unit: str
    wired: bool
    led: str = ""

    @property
    def groove(self) -> QRectF:
        """Where the slider is."""
        r = self.rect
        return QRectF(r.left() + LABEL, r.center().y() - 2, r.width() - LABEL - NUMBER - 8, 4)

    @property
    def words(self) -> str:
        """The value."""
        if self.wired:
            return "wired"
        if self.value is None:
            return "auto"
        if isinstance(self.value, bool):
            return "on" if self.value else "off"
        if isinstance(self.value, int | float):
            text = f"{self.value:.4g}".replace("-", "−")
            return numbers.with_unit(text, self.unit)
        return str(getattr(self.value, "name", self.value)).replace("_", " ")

    @property
    def slides(self) -> bool:
        """Whether it is a slider."""
        return self.scale is not None and self.value is not None and not self.wired and not self.led


def of(node: Node, record: Module | None, wired: Mapping[str, int], facts: Facts, width: float, top: float) -> tuple[Mini, ...]:
    """The controls of a node, one below the other."""
    found: list[Mini] = []
    for name in pins(node):
        parameter = record.parameter(name) if record else None
        if parameter is None or not can(parameter):
            continue
        value = node.parameters.get(name, parameter.default)
        number = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
        slides = parameter.type in (int, float)
        scale = scale_of(parameter, number, facts, ends(node, name), powers(node, name)) if slides else None
        unit = parameter.range.unit if parameter.range else ""
        rect = QRectF(12, top + HEIGHT * len(found), width - 24, HEIGHT)
        found.append(Mini(parameter, value, rect, scale, unit, name in wired, node.follows.get(name, "")))
    return tuple(found)


def paint(painter: QPainter, mini: Mini, look: Look) -> None:
    """Draw a control: name, slider, value."""
    middle = Qt.AlignmentFlag.AlignVCenter
    metrics = QFontMetricsF(font(11))
    painter.setFont(font(11))
    painter.setPen(look["text 2"])
    name = metrics.elidedText(title(mini.parameter.name), Qt.TextElideMode.ElideRight, LABEL - 6)
    painter.drawText(QRectF(mini.rect.left(), mini.rect.top(), LABEL, HEIGHT), middle, name)
    right = Qt.AlignmentFlag.AlignRight | middle
    room = QRectF(mini.rect.right() - NUMBER, mini.rect.top(), NUMBER, HEIGHT)
    if not mini.slides:
        room = mini.rect.adjusted(LABEL, 3, 0, -3)
        painter.setPen(QPen(look["divider"], 1))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRoundedRect(room, 3, 3)
        room = room.adjusted(6, 0, -6, 0)
        right = Qt.AlignmentFlag.AlignLeft | middle
    if mini.led:
        glyphs.room(painter, "link", QPointF(room.right() - 11, room.center().y() - 6), look["text 2"], 12)
        room = room.adjusted(0, 0, -16, 0)
    painter.setPen(look["text 3" if mini.wired or mini.led or mini.value is None else "text"])
    painter.drawText(room, right, metrics.elidedText(mini.words, Qt.TextElideMode.ElideRight, room.width()))
    if mini.slides and mini.scale is not None:
        _slider(painter, mini.groove, mini.scale.share(float(mini.value)), look)


def _slider(painter: QPainter, groove: QRectF, share: float, look: Look) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(look["track"])
    painter.drawRoundedRect(groove, 2, 2)
    painter.setBrush(look["action"])
    painter.drawRoundedRect(QRectF(groove.left(), groove.top(), groove.width() * share, 4), 2, 2)
    painter.setBrush(look["text"])
    painter.setPen(QPen(look["edge"], 1))
    painter.drawEllipse(QPointF(groove.left() + groove.width() * share, groove.center().y()), 5.5, 5.5)


class Slide:
    """The gesture on a mini slider: live while it is held, one step of undo."""

    def __init__(self, canvas: Canvas, item: NodeItem, mini: Mini, at: QPoint) -> None:
        self.canvas, self.node, self.mini = canvas, item.node.id, mini
        self.left = item.pos().x() + mini.groove.left()
        self.before = canvas.session.network
        self.moved = False
        self._give(at, True)

    def _give(self, at: QPoint, interim: bool) -> None:
        scale = self.mini.scale
        assert scale is not None
        number = scale.number((self.canvas.mapToScene(at).x() - self.left) / self.mini.groove.width())
        give(self.canvas, self.node, self.mini.parameter, int(number) if scale.whole else number, interim)

    def move(self, at: QPoint) -> None:
        """The knob follows."""
        self._give(at, True)

    def release(self, at: QPoint) -> None:
        """The last value counts."""
        self._give(at, False)

    def cancel(self) -> None:
        """Back to the value before."""
        value = self.before[self.node].parameters.get(self.mini.parameter.name, self.mini.parameter.default)
        give(self.canvas, self.node, self.mini.parameter, value, False)


def give(canvas: Canvas, node: str, parameter: Parameter, value: Any, interim: bool = False) -> None:
    """Set a parameter, as the panel does; a refusal is said."""
    session, name = canvas.session, parameter.name
    try:
        network = session.network.set(node, name, value, session.catalogue)
    except NoniusError as error:
        canvas.say(str(error))
        return
    session.edit(f"Set {name.replace('_', ' ')} of {node}", network, merge=("set", node, name), interim=interim)


def press(canvas: Canvas, item: NodeItem, mini: Mini, at: QPoint) -> Slide | None:
    """A slider is held, a switch turns, a choice opens its list."""
    if mini.wired:
        canvas.say(f"{title(mini.parameter.name)} comes from a wire")
        return None
    if mini.led:
        canvas.say(f"{title(mini.parameter.name)} follows {mini.led}: set that, or let it go in the panel")
        return None
    place = canvas.mapToScene(at) - item.pos()
    if mini.slides and mini.groove.adjusted(-8, -10, 8, 10).contains(place):
        return Slide(canvas, item, mini, at)
    node = item.node.id
    if mini.parameter.type is bool:
        give(canvas, node, mini.parameter, not mini.value)
    elif mini.parameter.options:
        menu = QMenu(canvas)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for option in mini.parameter.options:
            action = menu.addAction(option.replace("_", " "))
            action.setCheckable(True)
            action.setChecked(option == str(getattr(mini.value, "name", mini.value)))
            action.triggered.connect(lambda _=False, o=option: give(canvas, node, mini.parameter, o))
        menu.popup(canvas.viewport().mapToGlobal(at))
    else:
        write(canvas, item, mini)
    return None


def write(canvas: Canvas, item: NodeItem, mini: Mini) -> None:
    """Type the number on the node."""
    node = item.node.id

    def take(text: str) -> None:
        try:
            give(canvas, node, mini.parameter, number_of(text, mini.unit))
        except FormulaError as error:
            canvas.say(str(error))

    box = mini.rect.adjusted(LABEL, 0, 0, 0).translated(item.pos())
    text = "" if mini.value is None else f"{mini.value:.8g}"
    canvas.line.open(box, text, take)
