"""A network: nodes, wires and settings. Frozen, and legal at every moment: an edit returns a new one or raises.

Undo keeps networks, the engine is handed one, the canvas compares two by identity: nothing is copied or locked.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import networkx

from app.engine import check, following
from app.engine.catalogue import Catalogue
from app.engine.errors import CycleError, NameTaken, PortTaken, TypeMismatch, UnknownName, ValueRefused, hint
from modules.declare import Module, article

NAME: Final = re.compile(r"[^\W]([\w-]*\w)?")
"""What an id may be: it stands in wires as "id.output -> id.port[slot]"."""

SETTINGS: Mapping[str, Any] = {"k": 2.0, "title": ""}
"""Settings of a document and what they are by default. `k` is the coverage factor; none of them enters a key."""

Socket = tuple[str, str, int]
"""(target, port or parameter, slot): the end of a wire. Slot is 0, or the place in a list."""

Origin = tuple[str, str]
"""(source, output): the start of a wire; the output may be a twin, "<output>:accuracy"."""


@dataclass(frozen=True)
class Node:
    """A module in its place.

    Parameters
    ----------
    id : as the user reads it, "contour-1"
    module : id of the module; the record is looked up when it is needed
    version : of the module when the values were given
    parameters : explicit values; the others have their defaults
    view : position, size, camera, open panels: saved, in no key
    extras : keys of the file that this program does not know
    disabled : gives nothing, and blocks what hangs on it
    bypass : output -> port whose wire goes on in its place; the node does not fire; empty for a node that does
    follows : parameter -> "node.parameter" whose value it always has
    """

    id: str
    module: str
    version: int = 1
    parameters: Mapping[str, Any] = field(default_factory=dict)
    view: Mapping[str, Any] = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)
    disabled: bool = False
    bypass: Mapping[str, str] = field(default_factory=dict)
    follows: Mapping[str, str] = field(default_factory=dict)

    @property
    def passes(self) -> bool:
        """Whether what comes in goes on in place of what it gives."""
        return bool(self.bypass) and not self.disabled

    @cached_property
    def memo(self) -> dict[str, Any]:
        """What the scheduler remembers of this node; the node is frozen, so it stays true."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "memo"}


@dataclass(frozen=True)
class Network:
    """Nodes by id, wires by where they end, settings of the document.

    Parameters
    ----------
    nodes : id -> node
    wires : (target, port, slot) -> (source, output)
    settings : k (coverage factor), title, and whatever a file holds
    extras : keys of the file that this program does not know
    files : data file -> size and digest, as they were when the network was saved
    folder : where relative paths start; not saved
    """

    nodes: Mapping[str, Node] = field(default_factory=dict)
    wires: Mapping[Socket, Origin] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=lambda: dict(SETTINGS))
    extras: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    folder: Path | None = field(default=None, compare=False)

    # --- asking

    def __getitem__(self, node: str) -> Node:
        if node not in self.nodes:
            raise UnknownName(f"there is no node {node!r}{hint(node, self.nodes)}", node=node)
        return self.nodes[node]

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k not in ("graph", "order", "incoming", "around")}

    @property
    def k(self) -> float:
        """The coverage factor of totals and certificates."""
        return float(self.settings.get("k", SETTINGS["k"]))

    @cached_property
    def graph(self) -> networkx.DiGraph:
        """The nodes, and an edge from each source to each target; for order, ancestors and cycles. Nobody edits it."""
        graph = networkx.DiGraph()
        graph.add_nodes_from(sorted(self.nodes))
        graph.add_edges_from(sorted({(source, target) for (target, _, _), (source, _) in self.wires.items()}))
        return graph

    @cached_property
    def order(self) -> tuple[str, ...]:
        """All nodes, sources first, by name where either may be first."""
        return tuple(networkx.lexicographical_topological_sort(self.graph))

    @cached_property
    def incoming(self) -> Mapping[str, Mapping[str, tuple[Origin, ...]]]:
        """What is wired to each port of each node, in slot order."""
        ends: dict[str, dict[str, list[tuple[int, Origin]]]] = {}
        for (target, port, slot), origin in self.wires.items():
            ends.setdefault(target, {}).setdefault(port, []).append((slot, origin))
        return {
            target: {port: tuple(origin for _, origin in sorted(wires)) for port, wires in sorted(ports.items())}
            for target, ports in ends.items()
        }

    @cached_property
    def around(self) -> Network:
        """As it is run: wires go round the nodes that are bypassed. Itself if there are none."""
        off = {n for n, node in self.nodes.items() if node.passes}
        if not off:
            return self
        ends = {end: self._behind(origin) for end, origin in self.wires.items() if end[0] not in off}
        return replace(self, wires=without_gaps({end: origin for end, origin in ends.items() if origin is not None}))

    def _behind(self, origin: Origin) -> Origin | None:
        """What really comes over a wire; None if nothing is wired to the port that a bypassed node passes on."""
        source, output = origin
        node = self.nodes.get(source)
        if node is None or not node.passes:
            return origin
        plain, _, twin = output.partition(":")
        origins = self.incoming.get(source, {}).get(node.bypass.get(plain, ""), ())
        found = self._behind(origins[0]) if origins else None
        return found if found is None or not twin else (found[0], f"{found[1].partition(':')[0]}:{twin}")

    def sinks(self) -> tuple[str, ...]:
        """Nodes on which no other hangs: what is wanted if nothing is said."""
        used = {source for source, _ in self.around.wires.values()}
        return tuple(sorted(n for n, node in self.nodes.items() if n not in used and not node.passes))

    def fresh_id(self, module: str, taken: Iterable[str] = ()) -> str:
        """The id that `add` would give: "contour-1", one above the highest there is."""
        stem = module.rsplit(".", 1)[-1]
        names = re.compile(rf"{re.escape(stem)}-(\d+)")
        numbers = [int(found[1]) for n in (*self.nodes, *taken) if (found := names.fullmatch(n))]
        return f"{stem}-{max(numbers, default=0) + 1}"

    # --- nodes

    def add(
        self,
        module: str,
        catalogue: Catalogue,
        *,
        id: str = "",
        parameters: Mapping[str, Any] | None = None,
        view: Mapping[str, Any] | None = None,
    ) -> Network:
        """With a node of a module, named by its id or the part of it that only one has; see `fresh_id` for the id.

        Raises
        ------
        UnknownName, ValueRefused, NameTaken
        """
        record = catalogue.find(module)
        name = self._free(id or self.fresh_id(record.id))
        values = {n: check.value(name, record, n, v) for n, v in (parameters or {}).items()}
        return self._with(Node(name, record.id, record.version, values, dict(view or {})))

    def remove(self, *nodes: str) -> Network:
        """Without these nodes and their wires; gaps in lists close. What followed them keeps its value."""
        gone = {self[node].id for node in nodes}
        kept = {n: v for n, v in self.nodes.items() if n not in gone}
        kept = following.within(kept, kept)
        wires = {end: o for end, o in self.wires.items() if end[0] not in gone and o[0] not in gone}
        return replace(self, nodes=kept, wires=without_gaps(wires))

    def rename(self, node: str, new: str) -> Network:
        """With another id for a node. Its result keeps its key."""
        old = self[node]
        if new == node:
            return self
        self._free(new)
        nodes = {(new if n == node else n): (replace(old, id=new) if n == node else v) for n, v in self.nodes.items()}
        wires = {
            (new if t == node else t, port, slot): (new if s == node else s, output)
            for (t, port, slot), (s, output) in self.wires.items()
        }
        return replace(self, nodes=following.renamed(nodes, {node: new}), wires=wires)

    def set(self, node: str, parameter: str, value: Any, catalogue: Catalogue) -> Network:
        """With another value of a parameter, brought to its declared type, and of all that follow it.

        Raises
        ------
        UnknownName, ValueRefused
        """
        old = self[node]
        following.free(old, parameter)
        coerced = check.value(node, check.known(old.module, node, catalogue), parameter, value)
        if parameter in old.parameters and check.same(old.parameters[parameter], coerced):
            return self
        changed = self._with(replace(old, parameters={**old.parameters, parameter: coerced}))
        return following.passed_on(changed, node, parameter, catalogue)

    def reset(self, node: str, parameter: str, catalogue: Catalogue) -> Network:
        """With the default of a parameter, which all that follow it take too."""
        old = self[node]
        following.free(old, parameter)
        changed = self._with(replace(old, parameters={n: v for n, v in old.parameters.items() if n != parameter}))
        return following.passed_on(changed, node, parameter, catalogue)

    def disable(self, node: str, disabled: bool = True) -> Network:
        """With a node that gives nothing, or gives again."""
        return self._with(replace(self[node], disabled=disabled))

    def pass_through(self, node: str, on: bool, catalogue: Catalogue) -> Network:
        """With a node that passes on what comes in: for each output the first port of its type, a wired one before others.

        Raises
        ------
        TypeMismatch : no port has the type of an output
        """
        old = self[node]
        through = check.through(check.known(old.module, node, catalogue), self.incoming.get(node, {})) if on else {}
        if on and not through:
            record = check.known(old.module, node, catalogue)
            takes = " and ".join(dict.fromkeys(article(p.type) for p in record.ports)) or "nothing"
            gives = article(record.outputs[0].type)
            raise TypeMismatch(f"{record.title} cannot be bypassed: it takes {takes} and gives {gives}; disable it", node=node)
        return self._with(replace(old, bypass=through))

    def look(self, node: str, **view: Any) -> Network:
        """With other view data of a node (camera, panels); None takes a key out."""
        old = self[node]
        merged = {**old.view, **view}
        return self._with(replace(old, view={n: v for n, v in merged.items() if v is not None}))

    def move(self, places: Mapping[str, tuple[float, float]]) -> Network:
        """With nodes at other places of the canvas."""
        moved = {n: replace(self[n], view={**self[n].view, "position": [float(x), float(y)]}) for n, (x, y) in places.items()}
        return self._wired_alike({**self.nodes, **moved})

    def settle(self, **settings: Any) -> Network:
        """With other settings of the document.

        Raises
        ------
        ValueRefused : k is not a positive number
        """
        merged = {**self.settings, **settings}
        k = merged.get("k")
        if isinstance(k, bool) or not isinstance(k, int | float) or not 0 < k < float("inf"):
            raise ValueRefused(f"the coverage factor k is a positive number, not {k!r}: 2 covers about 95 %")
        if not isinstance(merged.get("title", ""), str):
            raise ValueRefused(f"the title is text, not {merged['title']!r}")
        return replace(self, settings={**merged, "k": float(k)})

    # --- wires

    def connect(
        self,
        source: str,
        output: str,
        target: str,
        port: str,
        catalogue: Catalogue,
        *,
        slot: int | None = None,
        instead: bool = False,
    ) -> Network:
        """With a wire from an output (or its twin "<output>:accuracy") to a port or, for a Value, to a parameter.

        Parameters
        ----------
        slot : place in a list; the last by default; a wire that is there moves up
        instead : take the place of a wire that is there

        Raises
        ------
        UnknownName, TypeMismatch, PortTaken, CycleError
        """
        start = check.known(self[source].module, source, catalogue)
        end = check.known(self[target].module, target, catalogue)
        check.fit(source, start, output, target, end, port)
        if port in self.nodes[target].follows or following.followers(self, target, port):
            raise PortTaken(f"{target}.{port} is linked to another parameter: let it go first", node=target, port=port)
        if source == target or networkx.has_path(self.graph, target, source):
            raise CycleError(_circle(self, source, target), node=target, port=port)
        return replace(self, wires=self._wired((source, output), target, end, port, slot, instead))

    def disconnect(self, target: str, port: str, slot: int | None = None) -> Network:
        """Without a wire, or without all of a port if no slot is given; the gap in a list closes.

        Raises
        ------
        UnknownName : there is no such wire
        """
        self[target]
        ends = [e for e in self.wires if e[:2] == (target, port) and slot in (None, e[2])]
        if not ends:
            at = "" if slot is None else f"[{slot}]"
            raise UnknownName(f"no wire ends at {target}.{port}{at}", node=target, port=port)
        return replace(self, wires=without_gaps({e: o for e, o in self.wires.items() if e not in ends}))

    # --- parts

    def part(self, nodes: Iterable[str]) -> Network:
        """These nodes with the wires that end at them: what a copy holds. Sources outside are named, not held."""
        names = [self[n].id for n in nodes]
        wires = {end: o for end, o in self.wires.items() if end[0] in names}
        return Network({n: self.nodes[n] for n in names}, wires, folder=self.folder)

    def pasted_ids(self, part: Network) -> dict[str, str]:
        """The ids that `paste` gives, by the ids in the part."""
        names: dict[str, str] = {}
        for old in sorted(part.nodes):
            fresh = self.fresh_id(part.nodes[old].module, names.values())
            names[old] = old if old not in self.nodes and old not in names.values() else fresh
        return names

    def paste(
        self,
        part: Network,
        catalogue: Catalogue,
        *,
        incoming: bool = True,
        by: tuple[float, float] = (0.0, 0.0),
    ) -> Network:
        """With a copy of a part, its nodes moved by (x, y).

        Parameters
        ----------
        incoming : keep wires from nodes outside the part, where such nodes are here and still fit
        """
        names = self.pasted_ids(part)
        nodes = dict(self.nodes)
        for old, new in names.items():
            node = part.nodes[old]
            x, y = node.view.get("position", (0.0, 0.0))
            place = {"position": [x + by[0], y + by[1]]} if "position" in node.view else {}
            nodes[new] = replace(node, id=new, view={**node.view, **place})
        copies = following.renamed({n: nodes[n] for n in names.values()}, names)
        nodes |= following.within(copies, nodes if incoming else copies)
        wires = dict(self.wires)
        for (target, port, slot), (source, output) in part.wires.items():
            inside = source in names
            if inside or (incoming and source in self.nodes):
                wires[names[target], port, slot] = (names[source] if inside else source, output)
        pasted = replace(self, nodes=nodes, wires=without_gaps(wires))
        check.network(pasted.nodes, pasted.wires, catalogue, only=set(names.values()))
        return following.judged(pasted, catalogue)[0]

    # --- inside

    def _with(self, node: Node) -> Network:
        nodes = {**self.nodes, node.id: node}
        return self._wired_alike(nodes) if node.id in self.nodes else replace(self, nodes=nodes)

    def _wired_alike(self, nodes: Mapping[str, Node]) -> Network:
        """With other nodes of the same names: what is known of order and wires stays true."""
        network = replace(self, nodes=nodes)
        network.__dict__.update({name: self.__dict__[name] for name in ("graph", "order", "incoming") if name in self.__dict__})
        return network

    def _free(self, name: str) -> str:
        if not NAME.fullmatch(name):
            raise NameTaken(f"{name!r} cannot be the id of a node: use letters, digits, '_' and '-' inside", node=name)
        if name in self.nodes:
            raise NameTaken(f"there is a node {name!r} already: take {self.fresh_id(name.rsplit('-', 1)[0])!r}", node=name)
        return name

    def _wired(
        self, origin: Origin, target: str, end: Module, port: str, slot: int | None, instead: bool
    ) -> dict[Socket, Origin]:
        there = list(self.incoming.get(target, {}).get(port, ()))
        declared = end.port(port)
        if declared is None or not declared.many:
            if there and not instead:
                sentence = f"{target}.{port} has a wire from {'.'.join(there[0])} already: disconnect that first"
                raise PortTaken(sentence, node=target, port=port)
            there = [origin]
        elif slot is None:
            there.append(origin)
        else:
            there[slot : slot + instead] = [origin]
        kept = {e: o for e, o in self.wires.items() if e[:2] != (target, port)}
        return kept | {(target, port, i): o for i, o in enumerate(there)}


def without_gaps(wires: Mapping[Socket, Origin]) -> dict[Socket, Origin]:
    """The wires with the slots of each list counted 0, 1, 2 again. Slot -1 (a port nobody knows) stays."""
    slots: dict[tuple[str, str], int] = {}
    result: dict[Socket, Origin] = {}
    for target, port, slot in sorted(wires):
        place = slot
        if slot >= 0:
            place = slots.get((target, port), 0)
            slots[target, port] = place + 1
        result[target, port, place] = wires[target, port, slot]
    return result


def _circle(network: Network, source: str, target: str) -> str:
    if source == target:
        return f"{source!r} cannot be wired to itself"
    way = networkx.shortest_path(network.graph, target, source)
    return f"wiring {source!r} to {target!r} closes a circle: {' -> '.join([*way, target])}; data runs one way"
