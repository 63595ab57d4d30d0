"""Another module in the place of a node: wires and values that fit are kept, what is lost is told."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace

from app.engine import check, following
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError
from app.engine.network import Network, Node, Origin, Socket, without_gaps
from modules.data.wires import Value
from modules.declare import Module


@dataclass(frozen=True)
class Replaced:
    """The network with another module in a node's place.

    Parameters
    ----------
    kept : wires and values that were taken over
    lost : those that were not, a word each
    """

    network: Network
    kept: int
    lost: tuple[str, ...]


def replaced(network: Network, node: str, module: str, catalogue: Catalogue) -> Replaced:
    """Put a module in the place of a node, also of one whose module is not here.

    A wire goes to the socket of the same name, or to the first free one that it fits; a value to the parameter of its name.

    Raises
    ------
    UnknownName : there is no such node or module
    """
    old, record = network[node], catalogue.find(module)
    lost: list[str] = []
    values = {}
    for name, value in old.parameters.items():
        try:
            values[name] = check.value(node, record, name, value)
        except NetworkError:
            lost.append(name.replace("_", " "))
    follows = {name: led for name, led in old.follows.items() if record.parameter(name) is not None}
    fresh = replace(old, module=record.id, version=record.version, parameters=values, bypass={}, follows=follows)
    nodes = {**network.nodes, node: fresh}
    wires = {end: origin for end, origin in network.wires.items() if node not in (end[0], origin[0])}
    taken = _incoming(network, nodes, record, node, wires, catalogue)
    given = _outgoing(network, nodes, record, node, wires, catalogue)
    lost += taken + given
    kept = len(wires) - sum(node not in (end[0], origin[0]) for end, origin in wires.items()) + len(values)
    changed, loose = following.judged(replace(network, nodes=nodes, wires=without_gaps(wires)), catalogue)
    return Replaced(changed, kept, (*lost, *(sentence for _, sentence in loose)))


def _incoming(
    network: Network, nodes: dict[str, Node], record: Module, node: str, wires: dict[Socket, Origin], catalogue: Catalogue
) -> list[str]:
    """Take over what is wired to the node; the names of what is not."""
    lost = []
    ends = sorted((end, origin) for end, origin in network.wires.items() if end[0] == node)
    ends.sort(key=lambda one: record.port(one[0][1]) is None and record.parameter(one[0][1]) is None)
    for (_, port, slot), origin in ends:
        kinds = [p for p in record.ports if p.name == port] + [p for p in record.ports if p.name != port]
        names = [(p.name, p.many) for p in kinds] + [(p.name, False) for p in record.parameters if p.name == port]
        for name, many in names:
            place = sum(end[:2] == (node, name) for end in wires) if many else 0
            end = (node, name, place if name != port or slot < 0 else max(slot, place))
            if (many or end not in wires) and _fits(nodes, end, origin, catalogue):
                wires[end] = origin
                break
        else:
            lost.append(f"the wire from {'.'.join(origin)}")
    return lost


def _outgoing(
    network: Network, nodes: dict[str, Node], record: Module, node: str, wires: dict[Socket, Origin], catalogue: Catalogue
) -> list[str]:
    """Take over what hangs on the node; the names of what is not."""
    lost = []
    for end, (source, output) in sorted(network.wires.items()):
        if source != node:
            continue
        own = [o.name for o in record.outputs]
        twins = [f"{name}:accuracy" for name in own]
        for name in (*(n for n in (output,) if n in (*own, *twins)), *(twins if ":" in output else own)):
            if _fits(nodes, end, (node, name), catalogue):
                wires[end] = (node, name)
                break
        else:
            lost.append(f"the wire to {end[0]}.{end[1]}")
    return lost


def _fits(nodes: dict[str, Node], end: Socket, origin: Origin, catalogue: Catalogue) -> bool:
    try:
        check.wire(nodes, end, origin, catalogue)
    except NetworkError:
        return False
    target = catalogue.get(nodes[end[0]].module)
    if target is not None and target.port(end[1]) is None and target.parameter(end[1]) is not None:
        start = catalogue.get(nodes[origin[0]].module)
        found = start.output(origin[1]) if start else None
        return found is None or found.type is Value
    return True


def suggestions(network: Network, node: str, catalogue: Catalogue) -> list[tuple[Module, Replaced]]:
    """All modules with what they would keep: those of nearly its name first, then those that lose fewest wires."""
    old = network[node]
    name = old.module.rsplit(".", 1)[-1]
    here = catalogue.get(old.module)
    found = [(m, replaced(network, node, m.id, catalogue)) for m in catalogue if m is not here]

    room = here.room if here else old.module.split(".")[0]

    def rank(one: tuple[Module, Replaced]) -> tuple[int, int, int, int, float, str]:
        module, done = one
        names = (module.id.rsplit(".", 1)[-1], *module.aliases, module.title.lower())
        alike = max(difflib.SequenceMatcher(None, name, other).ratio() for other in names)
        close = alike > 0.8 or name in (n.rsplit(".", 1)[-1] for n in module.was)
        wires = sum(one.startswith("the wire") for one in done.lost)
        return (0 if close else 1, wires, 0 if module.room == room else 1, len(done.lost), -alike, module.title)

    return sorted(found, key=rank)
