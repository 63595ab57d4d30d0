"""The panel of the chosen node: its parameters, what it adds to the error, its ports, how it ran."""

from __future__ import annotations

from functools import partial
from typing import Any

from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from app.engine.errors import NoniusError
from app.engine.network import Node
from app.gui import icons, linking, minis, style, summary
from app.gui.glyphs import TYPES, Look, port
from app.gui.parameter_row import ParameterRow
from app.gui.run_section import RunSection
from app.gui.session import Session
from app.gui.step_section import StepSection
from app.gui.widgets.parts import button, line, section, tool
from modules.records import Module

ROOM_ICONS = {"readers": "reader", "modellers": "modeller", "mappers": "mapper", "accuracy_mappers": "accuracy",
              "renderers": "renderer"}  # fmt: skip


LEAST = 288


class ControlPanel(QScrollArea):
    """The docked panel follows the selection, one with a node of its own stays with it; edits are live while a slider is held.

    Signals
    -------
    helpAsked : id of a module
    replaceAsked : node whose module is not here
    gone : the panel's own node is no longer there
    """

    helpAsked = Signal(str)
    replaceAsked = Signal(str)
    gone = Signal()

    def __init__(self, session: Session, parent: QWidget | None = None, node: str = "") -> None:
        super().__init__(parent)
        self.session = session
        self.node = self.own = node
        self._module = session.network[node].module if node else ""
        self.rows: dict[str, ParameterRow] = {}
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setMinimumWidth(LEAST)
        self._run: RunSection | None = None
        self._step: StepSection | None = None
        session.selectionChanged.connect(self._chosen)
        session.networkChanged.connect(self._edited)
        session.resultChanged.connect(self._result)
        session.stateChanged.connect(self._state)
        style.watch().changed.connect(self._build)
        self._build()

    # --- building

    def _chosen(self) -> None:
        nodes = self.session.network.nodes
        if self.own and self.own not in nodes:
            self.gone.emit()
            return
        node = self.own or next((n for n in self.session.selection if n in nodes), "")
        module = nodes[node].module if node else ""
        if (node, module) != (self.node, self._module):
            self.node, self._module = node, module
            self._build()

    def _build(self) -> None:
        old = self.takeWidget()
        if old is not None:
            old.deleteLater()
        self.rows, self._run, self._step = {}, None, None
        body = QWidget()
        body.setProperty("kind", "panel")
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 12)
        column.setSpacing(0)
        node = self.session.network.nodes.get(self.node)
        record = self.session.catalogue.get(node.module) if node else None
        if node is None:
            self._empty(column)
        else:
            column.addWidget(self._head(node, record))
            if record is not None:
                self._sections(column, record)
            else:
                column.addWidget(self._placeholder(node))
        column.addStretch(1)
        self.setWidget(body)
        self._edited()
        self._facts()

    def _empty(self, column: QVBoxLayout) -> None:
        words = style.labelled("Choose a module on the canvas to see its settings here.", "quiet")
        words.setWordWrap(True)
        words.setContentsMargins(14, 18, 14, 0)
        column.addWidget(words)

    def _placeholder(self, node: Node) -> QWidget:
        """A node whose module is not here: why, what is kept of it, and the way out."""
        made = QWidget()
        column = QVBoxLayout(made)
        column.setContentsMargins(12, 12, 12, 0)
        column.setSpacing(10)
        sentence = self.session.state(node.id).sentence
        words = style.labelled(f"{sentence[:1].upper()}{sentence[1:]}. It is kept as it is, and saved as it was.")
        words.setWordWrap(True)
        column.addWidget(words)
        ask = button("Replace with…", lambda: self.replaceAsked.emit(node.id), primary=True, tip="Another module (Ctrl+R)")
        column.addWidget(ask, 0, Qt.AlignmentFlag.AlignLeft)
        if node.parameters:
            column.addWidget(section("Values that are kept"))
        for name, value in sorted(node.parameters.items()):
            kept = style.labelled(f"{name.replace('_', ' ')}: {value}", "quiet")
            kept.setWordWrap(True)
            column.addWidget(kept)
        return made

    def _head(self, node: Node, record: Module | None) -> QWidget:
        bar = QFrame()
        bar.setProperty("kind", "bar")
        row = QHBoxLayout(bar)
        row.setContentsMargins(12, 3, 6, 3)
        row.setSpacing(9)
        if record is not None:
            drawing = QLabel()
            drawing.setPixmap(icons.pixmap(ROOM_ICONS[record.room], ratio=self.devicePixelRatioF()))
            row.addWidget(drawing)
        row.addWidget(style.labelled(summary.title(node, record), "title"))
        name = style.labelled(node.id, "quiet")
        name.setFont(style.mono(11))
        row.addWidget(name)
        row.addStretch(1)
        if record is not None:
            row.addWidget(tool("help", "What this module does (F1)", lambda: self.helpAsked.emit(record.id)))
        bar.setFixedHeight(32)
        return bar

    def _sections(self, column: QVBoxLayout, record: Module) -> None:
        inside = QWidget()
        inner = QVBoxLayout(inside)
        inner.setContentsMargins(12, 10, 12, 0)
        inner.setSpacing(8)
        column.addWidget(inside)
        self._step = StepSection(self.session, self.node)
        self._run = RunSection(self.session, self.node)
        inner.addWidget(self._run.failure)
        if record.parameters:
            reset = tool("reset", "Reset all to their defaults", self._reset_all)
            inner.addWidget(section("Parameters", reset))
            for parameter in record.parameters:
                row = ParameterRow(parameter)
                row.changed.connect(partial(self._set, parameter.name))
                row.resetAsked.connect(partial(self._reset, parameter.name))
                row.endsChanged.connect(partial(self._ends, parameter.name))
                row.powersChanged.connect(partial(self._powers, parameter.name))
                row.pinAsked.connect(partial(self._pin, parameter.name))
                row.letGoAsked.connect(partial(linking.let_go, self.session, self.node, parameter.name))
                row.more = partial(linking.fill, self.session, self.node, parameter.name)
                self.rows[parameter.name] = row
                inner.addWidget(row)
            inner.addWidget(line())
        inner.addWidget(self._step)
        inner.addWidget(line())
        inner.addWidget(section("Ports"))
        for port_ in record.ports:
            inner.addWidget(PortRow(port_.type.__name__, port_.name, port_.words or _taken(port_.optional, port_.many)))
        for output in record.outputs:
            inner.addWidget(PortRow(output.type.__name__, output.name, "output"))
        inner.addWidget(line())
        inner.addWidget(section("Last run"))
        inner.addWidget(self._run)

    # --- following

    def _edited(self) -> None:
        node = self.session.network.nodes.get(self.node)
        if node is None or node.module != self._module:
            if self.node:
                self._chosen()
            return
        wired = self.session.network.incoming.get(self.node, {})
        for name, row in self.rows.items():
            row.show_value(node.parameters.get(name, row.parameter.default))
            row.show_wired(".".join(wired[name][0]) if name in wired else "")
            row.show_led(node.follows.get(name, ""), linking.led_by(self.session.network, self.node, name))
            row.pinned = name in minis.pins(node)
        if self._run is not None:
            self._run.refresh()

    def _facts(self) -> None:
        node = self.session.network.nodes.get(self.node)
        if node is None or not self.rows:
            return
        facts = {**self.session.input_facts(self.node), **self.session.peeked(self.node)}
        for name, row in self.rows.items():
            row.show_facts(facts, minis.ends(node, name), minis.powers(node, name))

    def _result(self, node: str) -> None:
        near = self.node in self.session.network.nodes and node in self.session.network.graph.predecessors(self.node)
        if node == self.node or near:
            self._facts()
            for part in (self._run, self._step):
                if part is not None:
                    part.refresh()

    def _state(self, node: str) -> None:
        if node == self.node and self._run is not None:
            self._run.refresh()

    # --- editing

    def _set(self, name: str, value: Any, interim: bool) -> None:
        session, node = self.session, self.node
        try:
            network = session.network.set(node, name, value, session.catalogue)
        except NoniusError as error:
            self.rows[name].refuse(str(error))
            return
        session.edit(f"Set {name.replace('_', ' ')} of {node}", network, merge=("set", node, name), interim=interim)

    def _reset(self, name: str) -> None:
        session = self.session
        network = session.network.reset(self.node, name, session.catalogue)
        session.edit(f"Reset {name.replace('_', ' ')} of {self.node}", network)

    def _reset_all(self) -> None:
        network = self.session.network
        for name in self.rows.keys() - network[self.node].follows.keys():
            network = network.reset(self.node, name, self.session.catalogue)
        self.session.edit(f"Reset {self.node}", network)

    def _ends(self, name: str, ends: tuple[float, float] | None) -> None:
        network = self.session.network
        held: Any = network[self.node].view.get("ends", {})
        chosen = {n: e for n, e in (held.items() if isinstance(held, dict) else ()) if n != name}
        if ends is not None:
            chosen[name] = list(ends)
        self.session.amend(network.look(self.node, ends=chosen or None))
        self._facts()

    def _powers(self, name: str, on: bool | None) -> None:
        network = self.session.network
        held: Any = network[self.node].view.get("powers", {})
        chosen = {n: p for n, p in (held.items() if isinstance(held, dict) else ()) if n != name}
        if on is not None:
            chosen[name] = on
        self.session.amend(network.look(self.node, powers=chosen or None))
        self._facts()

    def _pin(self, name: str) -> None:
        try:
            self.session.edit(*minis.pinned(self.session.network, self.node, name))
        except NoniusError as error:
            self.session.message.emit("warning", str(error))


class PortRow(QWidget):
    """A port: its glyph, its name, its words."""

    def __init__(self, kind: str, name: str, words: str) -> None:
        super().__init__()
        self.kind = kind
        row = QHBoxLayout(self)
        row.setContentsMargins(26, 2, 0, 2)
        row.setSpacing(8)
        label = style.labelled(name)
        label.setFixedWidth(70)
        told = style.labelled(f"{TYPES.get(kind, kind)}; {words}" if words else TYPES.get(kind, kind), "quiet")
        told.setWordWrap(True)
        row.addWidget(label, 0, Qt.AlignmentFlag.AlignTop)
        row.addWidget(told, 1)

    def paintEvent(self, event: QPaintEvent) -> None:
        """The glyph of the type."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        port(painter, self.kind, QPointF(10, 11), Look(style.present().name))


def _taken(optional: bool, many: bool) -> str:
    return "any number" if many else "optional" if optional else ""

