"""Order, keys and plan: pure functions of a network, a catalogue and the identities of its files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from app.engine import check
from app.engine.catalogue import Catalogue
from app.engine.errors import FileMissing, ModuleFailed, NoniusError, Unwired
from app.engine.keys import FORMAT, canonical, digest, tag
from app.engine.network import Network, Node
from app.engine.paths import Identities, Identity
from modules.declare import Module
from modules.parameters import plain


def order(network: Network, wanted: Iterable[str] | None = None) -> list[str]:
    """What is wanted and all it hangs on, sources first; the same for the same network, whatever the order of edits."""
    if wanted is None:
        return list(network.order)
    needed = upstream(network, wanted)
    return [n for n in network.order if n in needed]


def upstream(network: Network, wanted: Iterable[str]) -> set[str]:
    """What is wanted and all it hangs on."""
    stack, seen = [network[n].id for n in wanted], set[str]()
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            stack.extend(network.graph.predecessors(node))
    return seen


def effective(node: Node, record: Module) -> dict[str, Any]:
    """All parameter values: the explicit ones in their declared types, defaults for the others.

    Raises
    ------
    ValueRefused : an explicit value does not fit (the module is another one than when it was given)
    """
    known = node.memo.get("effective")
    if known is None or known[0] is not record:
        values = {
            p.name: check.value(node.id, record, p.name, node.parameters[p.name]) if p.name in node.parameters else p.default
            for p in record.parameters
        }
        known = node.memo["effective"] = (record, values)
    values = known[1]
    return dict(values)


def keys(network: Network, catalogue: Catalogue, identities: Identities | None = None) -> dict[str, str]:
    """The key of each node's firing. Nodes with equal keys give equal results and run once, here and anywhere.

    Parameters
    ----------
    identities : of the files, from `paths.identities`; a file without one has no result yet
    """
    found: dict[str, str] = {}
    for name in order(network):
        found[name] = _key(network, network.nodes[name], catalogue, identities or {}, found)
    return found


def _key(network: Network, node: Node, catalogue: Catalogue, identities: Identities, known: Mapping[str, str]) -> str:
    record = catalogue.get(node.module)
    wires = network.incoming.get(node.id, {})
    ends = tuple(
        (port, slot, output, known[source])
        for port, origins in wires.items()
        for slot, (source, output) in enumerate(origins)
    )
    files = tuple(
        identities.get((node.id, p.name)) for p in (record.parameters if record else ()) if p.is_path and p.name not in wires
    )
    memo = node.memo.get("key")
    if memo is not None and memo[0] is record and memo[1] == ends and memo[2] == files:
        return str(memo[3])
    key = digest(tag(b"l", _own(node, record, frozenset(wires), identities) + canonical(sorted(ends))))
    node.memo["key"] = (record, ends, files, key)
    return key


def _own(node: Node, record: Module | None, wired: frozenset[str], identities: Identities) -> bytes:
    """Canonical engine format, module, version, code digest and parameters: all but the wires."""
    if record is None:
        values = {n: repr(plain(v)) for n, v in node.parameters.items()}
        return b"".join(map(canonical, (FORMAT, node.module, node.version, "not here", values)))
    try:
        values = effective(node, record)
    except NoniusError as error:
        return b"".join(map(canonical, (FORMAT, record.id, record.version, "refused", str(error))))
    pairs = []
    for parameter in sorted(record.parameters, key=lambda p: p.name):
        if parameter.name in wired:
            continue
        value: Any = values[parameter.name]
        if parameter.is_path and value is not None:
            value = _file(identities.get((node.id, parameter.name)), value)
        pairs.append((parameter.name, value))
    return _head(record) + canonical(pairs)


@lru_cache(4096)
def _head(record: Module) -> bytes:
    return b"".join(map(canonical, (FORMAT, record.id, record.version, record.digest)))


def _file(identity: Identity | None, value: Any) -> Any:
    if identity is None or identity.problem:
        return {"no file": plain(value)}
    return identity.content


def obstacle(network: Network, node: str, catalogue: Catalogue, identities: Identities) -> ModuleFailed | None:
    """Why a node cannot fire, whatever the others give; None if it can."""
    here = network[node]
    record = catalogue.get(here.module)
    if record is None:
        return ModuleFailed(f"its module {here.module!r} is not here{catalogue.nearest(here.module)}", node=node)
    wires = network.incoming.get(node, {})
    try:
        effective(here, record)
        for port, origins in wires.items():
            for slot, origin in enumerate(origins):
                check.wire(network.nodes, (node, port, slot), origin, catalogue)
    except NoniusError as error:
        return ModuleFailed(_bare(error, node), node=node, port=error.port, title=record.title)
    for declared in record.ports:
        if not declared.optional and declared.name not in wires:
            return Unwired(check.unwired(record, declared), node=node, port=declared.name, title=record.title)
    for parameter in record.parameters:
        identity = identities.get((node, parameter.name))
        if identity is not None and identity.problem and parameter.name not in wires:
            return FileMissing(identity.problem, node=node, port=parameter.name, title=record.title)
    return None


def _bare(error: NoniusError, node: str) -> str:
    return error.sentence.removeprefix(f"{node}: ")


@dataclass(frozen=True)
class Plan:
    """One wave.

    Parameters
    ----------
    fire : nodes to fire, in order; several of one key run once
    reuse : nodes whose result is there
    failed : node -> why it cannot fire, or failed before
    blocked : node -> the node that blocks it
    """

    fire: tuple[str, ...]
    reuse: tuple[str, ...]
    failed: Mapping[str, ModuleFailed]
    blocked: Mapping[str, str]


def plan(
    network: Network,
    catalogue: Catalogue,
    identities: Identities,
    keys: Mapping[str, str],
    wanted: Iterable[str],
    there: Callable[[str], bool],
    failures: Mapping[str, ModuleFailed],
) -> Plan:
    """Walk up from what is wanted and stop at results that are there.

    Parameters
    ----------
    there : whether a key's result is kept
    failures : key -> why it failed
    """
    names = order(network, wanted)
    blocked = _disabled(network, names)
    fire, reuse, failed = set[str](), set[str](), dict[str, ModuleFailed]()
    stack = sorted(set(wanted), reverse=True)
    while stack:
        name = stack.pop()
        if name in fire or name in reuse or name in failed or name in blocked:
            continue
        if there(keys[name]):
            reuse.add(name)
        elif error := obstacle(network, name, catalogue, identities) or failures.get(keys[name]):
            failed[name] = error.at(name)
        else:
            fire.add(name)
            stack.extend(network.graph.predecessors(name))
    for name in names:
        if name in fire:
            before = [s for s in sorted(network.graph.predecessors(name)) if s in failed or s in blocked]
            if before:
                blocked[name] = blocked.get(before[0], before[0])
    return Plan(
        tuple(n for n in names if n in fire and n not in blocked), tuple(n for n in names if n in reuse), failed, blocked
    )


def _disabled(network: Network, names: Iterable[str]) -> dict[str, str]:
    """Disabled nodes and what hangs on them -> the disabled node. A bypassed one gives nothing itself either."""
    blocked: dict[str, str] = {}
    if not any(network.nodes[n].disabled or network.nodes[n].passes for n in names):
        return blocked
    for name in names:
        if network.nodes[name].disabled or network.nodes[name].passes:
            blocked[name] = name
        elif culprits := [blocked[s] for s in sorted(network.graph.predecessors(name)) if s in blocked]:
            blocked[name] = culprits[0]
    return blocked
