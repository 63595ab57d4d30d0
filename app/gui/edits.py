"""What a gesture on the canvas does to the network: pure functions, each gives a new network or raises."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import networkx

from app.engine import check
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError
from app.engine.network import Network, Origin, Socket
from app.gui.items import Verdict
from app.gui.layout import COLUMN, snap
from modules.data.wires import Value
from modules.declare import Module

CONVERTERS: Final = {
    ("Samples", "Model"): ("interpolate",),
    ("Geometry", "Layer"): ("lines", "surface", "points"),
}
"""(offered, needed) -> modules that fit between."""

POINTS: Final = frozenset({"points", "dust", "places", "corners", "shoulders"})
SURFACES: Final = frozenset({"surface", "bands", "band", "cells", "draped"})


KNOWN: Final = ("interpolate", "contour", "isosurface", "lines", "view")
"""Modules that everyone meets first: advice names them."""


@dataclass(frozen=True)
class Held:
    """The end of a wire in the hand: a socket of a node."""

    node: str
    name: str
    kind: str
    out: bool
    slot: int = 0


def record(network: Network, node: str, catalogue: Catalogue) -> Module | None:
    """The module of a node, None if it is not here."""
    return catalogue.get(network[node].module)


def plain(sentence: str) -> str:
    """A refusal without the wire it speaks of: the user sees that."""
    return sentence.split(": ", 1)[1] if " -> " in sentence.split(": ", 1)[0] and ": " in sentence else sentence


class Fitting:
    """What fits a wire in the hand; the nodes upstream and downstream are looked up once."""

    def __init__(self, network: Network, catalogue: Catalogue, held: Held) -> None:
        self.network, self.catalogue, self.held = network, catalogue, held
        graph = network.graph
        self.circle = {held.node, *(networkx.ancestors if held.out else networkx.descendants)(graph, held.node)}

    def verdicts(self, node: str) -> dict[tuple[str, bool], Verdict]:
        """(socket, whether an output) -> verdict, for all sockets of a node at the other end."""
        module = record(self.network, node, self.catalogue)
        if module is None:
            return {}
        if self.held.out:
            names = [p.name for p in module.ports] + [p.name for p in module.parameters]
        else:
            names = [n for o in module.outputs for n in (o.name, f"{o.name}:accuracy")]
        return {(name, not self.held.out): self.verdict(node, name) for name in names}

    def verdict(self, node: str, name: str) -> Verdict:
        """Whether the wire may end at a socket."""
        if node in self.circle:
            why = "cannot be wired to itself" if node == self.held.node else "that closes a circle: data runs one way"
            return Verdict(False, why)
        source, output, target, port = self._ends(node, name)
        start, end = record(self.network, source, self.catalogue), record(self.network, target, self.catalogue)
        if start is None or end is None:
            return Verdict(False, "its module is not installed")
        try:
            check.fit(source, start, output, target, end, port)
        except NetworkError as error:
            return Verdict(False, plain(str(error)), converters(start, output, end, port, self.catalogue))
        return Verdict(True)

    def _ends(self, node: str, name: str) -> tuple[str, str, str, str]:
        if self.held.out:
            return self.held.node, self.held.name, node, name
        return node, name, self.held.node, self.held.name


def converters(start: Module, output: str, end: Module, port: str, catalogue: Catalogue) -> tuple[str, ...]:
    """Modules that would make an output fit a port, the likeliest first."""
    offered, needed = start.output(output), end.port(port)
    if offered is None or needed is None:
        return ()
    found = [n for n in CONVERTERS.get((offered.type.__name__, needed.type.__name__), ()) if _has(catalogue, n)]
    first = "points" if output in POINTS else "surface" if output in SURFACES else "lines"
    return tuple(sorted(found, key=lambda n: n != first))


def between(offered: str, needed: str, catalogue: Catalogue) -> Module | None:
    """A module that takes one type and gives another, for advice; None if none does in one step."""

    def fits(m: Module) -> bool:
        takes = [p.type.__name__ for p in m.ports if not p.optional]
        return takes == [offered] and bool(m.outputs) and m.outputs[0].type.__name__ == needed

    found = [m for m in catalogue if fits(m)]
    return min(found, key=lambda m: (m.id.rsplit(".", 1)[-1] not in KNOWN, m.title), default=None)


def _has(catalogue: Catalogue, name: str) -> bool:
    try:
        catalogue.find(name)
    except NetworkError:
        return False
    return True


def socket_for(module: Module, kind: type, out: bool) -> str:
    """The first socket of a module that a wire of a type fits (`out`: the wire comes from an output); "" if none does."""
    if out:
        fitting = [p.name for p in module.ports if not p.refuses(kind)]
        settings = [p.name for p in module.parameters] if kind is Value else []
        return next(iter([*fitting, *settings]), "")
    return next((o.name for o in module.outputs if o.type is kind), "")


def fits_held(module: Module, held: Held, network: Network, catalogue: Catalogue) -> str:
    """The socket of a module to which the wire in the hand may go; "" if there is none."""
    mine = record(network, held.node, catalogue)
    if mine is None:
        return ""
    if held.out:
        offered = mine.output(held.name)
        return socket_for(module, offered.type, True) if offered else ""
    port = mine.port(held.name)
    if port is None:
        return next((o.name for o in module.outputs if o.type is Value), "")
    plain_output = next((o.name for o in module.outputs if not port.refuses(o.type)), "")
    if not plain_output and port.type.__name__ == "Accuracy" and module.outputs:
        return f"{module.outputs[0].name}:accuracy"
    return plain_output


def join(network: Network, held: Held, node: str, name: str, catalogue: Catalogue, slot: int | None = None) -> Network:
    """With a wire from the socket in the hand to another; a wire that is there gives way, a free slot of a list is taken."""
    source, output, target, port = (held.node, held.name, node, name) if held.out else (node, name, held.node, held.name)
    place = slot if held.out else held.slot
    module = record(network, target, catalogue)
    declared = module.port(port) if module else None
    if declared is None or not declared.many:
        return network.connect(source, output, target, port, catalogue, instead=True)
    there = len(network.incoming.get(target, {}).get(port, ()))
    taken = place is not None and place < there
    return network.connect(source, output, target, port, catalogue, slot=place if taken else None, instead=taken)


def convert(
    network: Network, held: Held, node: str, name: str, converter: str, catalogue: Catalogue, slot: int | None = None
) -> Network:
    """`join` with a module between."""
    module = catalogue.find(converter)
    a, b = _place(network, held.node), _place(network, node)
    place = [snap((a[0] + b[0]) / 2), snap((a[1] + b[1]) / 2)]
    fresh = network.fresh_id(module.id)
    grown = network.add(module.id, catalogue, view={"position": place})
    if held.out:
        grown = grown.connect(held.node, held.name, fresh, module.ports[0].name, catalogue)
        return join(grown, Held(fresh, module.outputs[0].name, "", True), node, name, catalogue, slot)
    grown = grown.connect(node, name, fresh, module.ports[0].name, catalogue)
    return join(grown, held, fresh, module.outputs[0].name, catalogue)


def add(
    network: Network, module: str, place: tuple[float, float], catalogue: Catalogue, held: Held | None = None
) -> tuple[Network, str]:
    """With a module at a place, wired to the socket in the hand; and the id of its node."""
    found = catalogue.find(module)
    fresh = network.fresh_id(found.id)
    grown = network.add(found.id, catalogue, view={"position": [snap(place[0]), snap(place[1])]})
    if held is not None and (name := fits_held(found, held, network, catalogue)):
        grown = join(grown, held, fresh, name, catalogue)
    return grown, fresh


def insert(network: Network, node: str, wire: Socket, catalogue: Catalogue) -> Network | None:
    """With a node put into a wire; None if it does not fit there."""
    source, output = network.wires[wire]
    target, port, slot = wire
    module, start = record(network, node, catalogue), record(network, source, catalogue)
    offered = start.output(output) if start else None
    if module is None or offered is None or node in (source, target):
        return None
    free = [p for p in module.ports if not p.refuses(offered.type) and not network.incoming.get(node, {}).get(p.name)]
    for end in free:
        for out in module.outputs:
            try:
                grown = network.connect(source, output, node, end.name, catalogue)
                return join(grown, Held(node, out.name, "", True), target, port, catalogue, slot)
            except NetworkError:
                continue
    return None


def move(network: Network, held_wire: Socket) -> Network:
    """Without one wire."""
    return network.disconnect(*held_wire)


def bridge(network: Network, nodes: Iterable[str], catalogue: Catalogue) -> Network:
    """Without nodes; where a node stood in a line and its ends fit, the line is closed."""
    gone = set(nodes)
    shrunk = network.remove(*gone)
    for (target, port, _), (source, _output) in sorted(network.wires.items()):
        if source not in gone or target in gone:
            continue
        origin = _origin(network, source, gone)
        if origin is None:
            continue
        try:
            shrunk = join(shrunk, Held(origin[0], origin[1], "", True), target, port, catalogue)
        except NetworkError:
            continue
    return shrunk


def _origin(network: Network, node: str, gone: set[str]) -> Origin | None:
    """What first comes into a row of nodes, from outside it."""
    for wires in network.incoming.get(node, {}).values():
        for source, output in wires:
            return (source, output) if source not in gone else _origin(network, source, gone)
    return None


def _place(network: Network, node: str) -> tuple[float, float]:
    x, y = network[node].view.get("position", (0.0, 0.0))
    return float(x), float(y)


def after(network: Network, node: str) -> tuple[float, float]:
    """A place for a node that follows another, below what already stands there."""
    x, y = _place(network, node)
    x += COLUMN
    taken = [_place(network, n) for n in network.nodes]
    while any(abs(x - tx) < 150 and abs(y - ty) < 94 for tx, ty in taken):
        y += 96.0
    return x, y


# --- frames and notes: they stand in the file beside the nodes

KEY: Final = "canvas"


def marks(network: Network, kind: str) -> list[dict[str, Any]]:
    """The frames or notes of a network; what is not one is left out."""
    found = network.extras.get(KEY)
    items = found.get(kind) if isinstance(found, Mapping) else None
    good = [m for m in items or () if isinstance(m, Mapping) and _four(m.get("rect"))]
    return [dict(m) for m in good]


def _four(rect: Any) -> bool:
    return isinstance(rect, list | tuple) and len(rect) == 4 and all(isinstance(v, int | float) for v in rect)


def with_marks(network: Network, kind: str, items: list[dict[str, Any]]) -> Network:
    """With other frames or notes."""
    found = network.extras.get(KEY)
    here = {**(found if isinstance(found, Mapping) else {}), kind: items}
    here = {k: v for k, v in here.items() if v}
    extras = {k: v for k, v in network.extras.items() if k != KEY}
    return replace(network, extras={**extras, KEY: here} if here else extras)
