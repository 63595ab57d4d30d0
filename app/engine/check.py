"""What is legal in a network: names, values, wires. Each refusal is a sentence that says where and what to do."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import networkx

from app.engine.catalogue import Catalogue
from app.engine.errors import CycleError, NetworkError, PortTaken, TypeMismatch, UnknownName, ValueRefused, hint
from app.engine.keys import canonical, too_large
from modules.data.accuracy import Accuracy
from modules.data.wires import Value
from modules.declare import Module, Output, Port, article
from modules.parameters import Parameter, ParameterError

if TYPE_CHECKING:
    from app.engine.network import Node, Origin, Socket


def known(module: str, node: str, catalogue: Catalogue) -> Module:
    """The record of a node's module; UnknownName if nobody has it."""
    record = catalogue.get(module)
    if record is None:
        near = catalogue.nearest(module)
        raise UnknownName(f"{node} is of a module {module!r} that is not here{near}; it is kept as it is", node=node)
    return record


def value(node: str, record: Module, name: str, given: Any) -> Any:
    """A parameter's value in its declared type.

    Raises
    ------
    UnknownName : the module has no such parameter
    ValueRefused : the value does not fit
    """
    parameter = record.parameter(name)
    if parameter is None:
        raise UnknownName(_no_parameter(node, record, name), node=node, port=name)
    try:
        coerced = parameter.coerce(given)
        if not finite(parameter, coerced):
            raise ParameterError(f"{name} takes {parameter.takes()}, which is not infinite here")
        size = too_large(canonical(coerced)) if isinstance(coerced, str | tuple) else ""
    except (ParameterError, TypeError, ValueError) as error:
        raise ValueRefused(f"{node}: {error}", node=node, port=name) from None
    if size:
        raise ValueRefused(f"{node}.{name} {size}", node=node, port=name)
    return coerced


def _no_parameter(node: str, record: Module, name: str) -> str:
    if record.port(name):
        return f"{node}.{name} is a port of {record.title!r}, not a parameter: wire it"
    return f"{node} ({record.title}) has no parameter {name!r}{hint(name, [p.name for p in record.parameters])}"


def finite(parameter: Parameter, given: Any) -> bool:
    """Whether no number is infinite, but where the Range says so."""
    if isinstance(given, tuple):
        return all(finite(parameter, v) for v in given)
    if not isinstance(given, float) or math.isfinite(given):
        return True
    ends = parameter.range
    return ends is not None and given in (ends.low, ends.high)


def same(one: Any, other: Any) -> bool:
    """Whether two values of a parameter are one, 1 and True apart."""
    return type(one) is type(other) and bool(one == other)


def offered(node: str, record: Module, output: str) -> Output:
    """An output of a module, or its twin socket."""
    found = record.output(output)
    if found is None:
        names = [o.name for o in record.outputs]
        plain = output.partition(":")[0]
        if plain in names:
            raise UnknownName(f"{node}.{plain} has the twin socket '{plain}:accuracy', no {output!r}", node=node, port=output)
        raise UnknownName(f"{node} ({record.title}) has no output {output!r}{hint(plain, names)}", node=node, port=output)
    return found


def fit(source: str, start: Module, output: str, target: str, end: Module, port: str) -> None:
    """Whether an output may be wired to a port or parameter; UnknownName or TypeMismatch if not."""
    out = offered(source, start, output)
    wire = f"{source}.{output} -> {target}.{port}"
    if declared := end.port(port):
        why = declared.refuses(out.type)
        if why and declared.type is Accuracy:
            why = f"needs Accuracy, got {article(out.type)}: take the twin socket '{output}:accuracy'"
        elif why and out.type is Accuracy:
            why = f"{why}: take {output.partition(':')[0]!r}; its twin says only what is known about the accuracy"
    elif parameter := end.parameter(port):
        takes = f"is a setting ({parameter.takes()}): only a Value can be wired to it, not {article(out.type)}"
        why = "" if out.type is Value else takes
    else:
        names = [p.name for p in end.ports] + [p.name for p in end.parameters]
        raise UnknownName(f"{target} ({end.title}) has no port {port!r}{hint(port, names)}", node=target, port=port)
    if why:
        raise TypeMismatch(f"{wire}: {port!r} {why}", node=target, port=port)


def network(
    nodes: Mapping[str, Node],
    wires: Mapping[Socket, Origin],
    catalogue: Catalogue,
    *,
    only: Iterable[str] | None = None,
) -> None:
    """Check all wires, or those that end at some nodes, and that there is no circle; raise what is wrong first."""
    wanted = None if only is None else set(only)
    for end, origin in sorted(wires.items()):
        if wanted is None or end[0] in wanted:
            wire(nodes, end, origin, catalogue)
    circle(wires)


def wire(nodes: Mapping[str, Node], end: Socket, origin: Origin, catalogue: Catalogue) -> None:
    """Check one wire. A module that is not here is asked nothing."""
    (target, port, slot), (source, output) = end, origin
    for name in (source, target):
        if name not in nodes:
            text = f"{source}.{output} -> {target}.{port}"
            raise UnknownName(f"wire '{text}': there is no node {name!r}{hint(name, nodes)}", node=name)
    start, record = catalogue.get(nodes[source].module), catalogue.get(nodes[target].module)
    if record is not None:
        declared = record.port(port)
        if slot > 0 and not (declared and declared.many):
            raise PortTaken(f"{target}.{port} takes one wire, not a list: leave out [{slot}]", node=target, port=port)
    if start is not None and record is not None:
        fit(source, start, output, target, record, port)
    elif start is not None:
        offered(source, start, output)


def circle(wires: Mapping[Socket, Origin]) -> None:
    """Raise CycleError if the wires close a circle."""
    graph = networkx.DiGraph(sorted({(source, target) for (target, _, _), (source, _) in wires.items()}))
    if networkx.is_directed_acyclic_graph(graph):
        return
    way = [a for a, _ in networkx.find_cycle(graph)]
    raise CycleError(f"the wires close a circle: {' -> '.join([*way, way[0]])}; data runs one way", node=way[0])


def problems(nodes: Mapping[str, Node], wires: Mapping[Socket, Origin], catalogue: Catalogue) -> list[NetworkError]:
    """Why nodes could not run as they are: modules that are not here, required ports without a wire."""
    wired = {end[:2] for end in wires}
    found: list[NetworkError] = []
    for name, node in sorted(nodes.items()):
        try:
            record = known(node.module, name, catalogue)
        except UnknownName as error:
            found.append(error)
            continue
        for port in record.ports:
            if not port.optional and (name, port.name) not in wired:
                found.append(NetworkError(f"{name} ({record.title}) {unwired(record, port)}", node=name, port=port.name))
    return found


def through(record: Module, wired: Collection[str]) -> dict[str, str]:
    """Output -> port that goes on in its place when the module is bypassed; none for outputs without a port of their type."""
    found = {}
    for output in record.outputs:
        fitting = sorted((p.name not in wired, i, p.name) for i, p in enumerate(record.ports) if p.type is output.type)
        if fitting:
            found[output.name] = fitting[0][2]
    return found


def unwired(record: Module, port: Port) -> str:
    """The sentence for a required port without a wire."""
    return f"needs {article(port.type)}{', or several,' if port.many else ''} at {port.name!r}: wire one"
