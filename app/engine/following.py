"""One parameter follows another: whoever sets the leader sets all that follow it.

A link is kept on the node that follows, `{"interval": "contour-1.interval"}`, and saved with it. The values that follow are
explicit values like all others, so keys, certificates and files hold what was computed with; the engine knows of no links.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.engine import check
from app.engine.catalogue import Catalogue
from app.engine.errors import CycleError, NetworkError, PortTaken, UnknownName, ValueRefused

if TYPE_CHECKING:
    from app.engine.network import Network, Node

End = tuple[str, str]
"""(node, parameter)."""


def leader(node: Node, parameter: str) -> End | None:
    """What a parameter follows."""
    text = node.follows.get(parameter)
    return None if text is None else end(text)


def end(text: str) -> End:
    """(node, parameter) of "contour-1.interval"."""
    name, _, parameter = text.partition(".")
    return name, parameter


def followers(network: Network, node: str, parameter: str) -> tuple[End, ...]:
    """Those that follow a parameter at first hand."""
    text = f"{node}.{parameter}"
    nodes = sorted((n, other.follows) for n, other in network.nodes.items() if other.follows)
    return tuple((n, p) for n, follows in nodes for p, led in sorted(follows.items()) if led == text)


def free(node: Node, parameter: str) -> None:
    """Raise ValueRefused if a parameter follows another: it has no value of its own."""
    led = node.follows.get(parameter)
    if led is not None:
        raise ValueRefused(f"{node.id}.{parameter} follows {led}: set that, or let it go first", node=node.id, port=parameter)


def follow(network: Network, node: str, parameter: str, led: End, catalogue: Catalogue) -> Network:
    """With a parameter that follows another from now on, beginning with its value.

    Raises
    ------
    UnknownName, ValueRefused : there is no such parameter, or the value does not fit
    PortTaken : one of the two has a wire
    CycleError : the leader follows the parameter already
    """
    value = value_of(network, led, catalogue)
    for name, given in ((node, parameter), led):
        if network.incoming.get(name, {}).get(given):
            raise PortTaken(f"{name}.{given} comes from a wire: disconnect that first", node=name, port=given)
    way = chain(network.nodes, led)
    if (node, parameter) in way:
        around = " -> ".join(".".join(one) for one in ((node, parameter), *way[: way.index((node, parameter)) + 1]))
        raise CycleError(f"{node}.{parameter} would follow itself: {around}", node=node, port=parameter)
    linked = replace(network[node], follows={**network[node].follows, parameter: ".".join(led)})
    return _given(_with(network, linked), node, parameter, value, catalogue)


def let_go(network: Network, node: str, parameter: str) -> Network:
    """With a parameter that follows nothing; its value stays."""
    old = network[node]
    if parameter not in old.follows:
        return network
    return _with(network, replace(old, follows={p: led for p, led in old.follows.items() if p != parameter}))


def passed_on(network: Network, node: str, parameter: str, catalogue: Catalogue) -> Network:
    """With the value of a parameter given to all that follow it.

    Raises
    ------
    ValueRefused : one that follows cannot take the value
    """
    for name, given in followers(network, node, parameter):
        network = _given(network, name, given, value_of(network, (node, parameter), catalogue), catalogue)
    return network


def value_of(network: Network, of: End, catalogue: Catalogue) -> Any:
    """The value of a parameter, its default if none was given."""
    node, name = network[of[0]], of[1]
    record = check.known(node.module, node.id, catalogue)
    found = record.parameter(name)
    if found is None:
        raise UnknownName(f"{node.id} ({record.title}) has no parameter {name!r}", node=node.id, port=name)
    return node.parameters.get(name, found.default)


def chain(nodes: Mapping[str, Node], of: End) -> list[End]:
    """A parameter, what it follows, what that follows; ends where it would come round."""
    way = [of]
    while (node := nodes.get(way[-1][0])) is not None and (led := leader(node, way[-1][1])) is not None:
        if led in way:
            return [*way, led]
        way.append(led)
    return way


def renamed(nodes: Mapping[str, Node], names: Mapping[str, str]) -> dict[str, Node]:
    """Nodes whose links name leaders by other ids: old -> new."""
    return {n: _relinked(node, {p: _named(led, names) for p, led in node.follows.items()}) for n, node in nodes.items()}


def within(nodes: Mapping[str, Node], there: Collection[str]) -> dict[str, Node]:
    """Nodes that follow only those that are there; the values of others stay."""
    return {
        n: _relinked(node, {p: led for p, led in node.follows.items() if end(led)[0] in there}) for n, node in nodes.items()
    }


def judged(network: Network, catalogue: Catalogue) -> tuple[Network, list[tuple[str, str]]]:
    """A network with its links made true, and (node, sentence) for each that was not; placeholders are left as they are."""
    said: list[tuple[str, str]] = []
    ends = [(n, p) for n, node in sorted(network.nodes.items()) for p in sorted(node.follows)]
    for node, parameter in sorted(ends, key=lambda e: len(chain(network.nodes, e))):
        led = leader(network[node], parameter) or ("", "")
        if any(n in network.nodes and catalogue.get(network[n].module) is None for n in (node, led[0])):
            continue
        before = network[node].parameters.get(parameter)
        alone = let_go(network, node, parameter)
        try:
            network = follow(alone, node, parameter, led, catalogue)
        except NetworkError as error:
            network = alone
            said.append((node, f"{node}.{parameter} no longer follows {'.'.join(led)}: {error}"))
            continue
        if not check.same(before, network[node].parameters[parameter]):
            said.append((node, f"{node}.{parameter} had another value than {'.'.join(led)}, which it follows; it takes that"))
    return network, said


def _given(network: Network, node: str, parameter: str, value: Any, catalogue: Catalogue) -> Network:
    old = network[node]
    coerced = check.value(node, check.known(old.module, node, catalogue), parameter, value)
    if parameter in old.parameters and check.same(old.parameters[parameter], coerced):
        return network
    changed = replace(old, parameters={**old.parameters, parameter: coerced})
    return passed_on(_with(network, changed), node, parameter, catalogue)


def _relinked(node: Node, follows: Mapping[str, str]) -> Node:
    return node if follows == node.follows else replace(node, follows=follows)


def _named(led: str, names: Mapping[str, str]) -> str:
    node, parameter = end(led)
    return f"{names.get(node, node)}.{parameter}"


def _with(network: Network, node: Node) -> Network:
    return replace(network, nodes={**network.nodes, node.id: node})
