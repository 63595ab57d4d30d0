"""What a node says of itself in two lines: what it does here, and how it went."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from app.draw import numbers
from modules.parameters import Parameter

if TYPE_CHECKING:
    from app.engine.network import Node
    from app.gui.session import NodeState, Session
    from modules.declare import Module

WAITS = {"dirty": "waits for a run", "queued": "in line", "blocked": "waits for an input", "held": "held until Fire",
         "disabled": "gives nothing", "bypassed": "bypassed", "missing": "not installed", "cached": "cached"}  # fmt: skip
FIRST = ("levels", "level", "interval", "count", "law", "method", "show", "title", "expression", "formula", "field")
"""Parameters that say most about a node, the best first."""

QUIET = ("opacity", "seed", "major", "every")
"""Numbers that say little."""


def title(node: Node, record: Module | None) -> str:
    """The name on a node: the user's, or the module's."""
    given = node.view.get("title")
    if isinstance(given, str) and given:
        return given
    return record.title if record else node.module.split(".")[-1].replace("_", " ").capitalize()


def does(node: Node, record: Module | None) -> str:
    """What it does here: file, law, level."""
    if record is None:
        return node.module
    values = {p.name: node.parameters.get(p.name, p.default) for p in record.parameters}
    said: list[str] = []
    for parameter in _telling(record):
        text = _said(parameter, values[parameter.name])
        if text and text not in said:
            said.append(text)
        if len(said) == 2:
            break
    return ", ".join(said or _rest(record, values)) or record.summary.split(".")[0].lower()


def _rest(record: Module, values: Mapping[str, Any]) -> list[str]:
    """The first two numbers with their names, for modules that have nothing more telling."""
    numbers_of = [p for p in record.parameters if p.name not in QUIET and not isinstance(values[p.name], bool)]
    given = [p for p in numbers_of if isinstance(values[p.name], int | float)]
    return [_number(p, values[p.name]) for p in given[:2]]


@functools.lru_cache(maxsize=512)
def _telling(record: Module) -> tuple[Parameter, ...]:
    """Parameters that say most first; those that say nothing are left out."""
    return tuple(p for p in sorted(record.parameters, key=_rank) if _rank(p) < 99)


def _rank(parameter: Parameter) -> int:
    if parameter.is_path:
        return -1
    if parameter.name in FIRST:
        return FIRST.index(parameter.name)
    return 50 if parameter.options and parameter.name not in ("theme", "legend", "scale", "map", "rows") else 99


def _said(parameter: Parameter, value: Any) -> str:
    if value in (None, "", ()):
        return ""
    if parameter.is_path:
        name = PurePath(str(value)).name
        return "" if name in ("", ".") else name
    if parameter.options:
        if _rank(parameter) > 50:
            return ""
        return str(getattr(value, "name", value)).replace("_", " ") + (" point" if value == "shoulder" else "")
    if isinstance(value, str):
        return value if _rank(parameter) < 50 else ""
    if _rank(parameter) >= 50 or isinstance(value, bool):
        return ""
    return _number(parameter, value)


def _number(parameter: Parameter, value: Any) -> str:
    unit = parameter.range.unit if parameter.range else ""
    if isinstance(value, tuple):
        if len(value) != 1:
            return f"{len(value)} {parameter.name}"
        return f"{parameter.name.removesuffix('s')} {numbers.with_unit(f'{value[0]:g}', unit)}"
    word = {"interval": "every", "count": ""}.get(parameter.name, parameter.name)
    tail = " levels" if parameter.name == "count" else ""
    return f"{word} {numbers.with_unit(f'{value:g}', unit)}{tail}".strip()


def went(state: NodeState, facts: Mapping[str, Any]) -> str:
    """How it went: time and size, or what it waits for."""
    if state.kind == "running":
        return "running" if state.progress is None else f"{round(100 * state.progress)} %"
    if state.kind in ("blocked", "held", "queued") and state.sentence and len(state.sentence) < 30:
        return state.sentence
    if state.kind in ("clean", "cached"):
        parts = [WAITS["cached"] if state.kind == "cached" else elapsed(state.seconds), size(facts)]
        return " · ".join(p for p in parts if p)
    return WAITS.get(state.kind, "")


def inputs(session: Session, node: str) -> list[str]:
    """What goes into a node, a line each: the wires with what comes over them, then the values that are not defaults."""
    network = session.network
    found = []
    for port, origins in network.incoming.get(node, {}).items():
        for source, output in origins:
            value = (session.outputs(source) or {}).get(output.partition(":")[0])
            known = session.facts(source).get(output.partition(":")[0], {})
            late = " of before the last edit" if value is not None and session.stale(source) else ""
            what = ", ".join(part for part in (type(value).__name__, size({output: known})) if part)
            found.append(f"{port} ← {source}.{output}: {what + late if value is not None else 'no result'}")
    given = network[node].parameters
    record = session.catalogue.get(network[node].module)
    for parameter in record.parameters if record else ():
        if parameter.name in given and given[parameter.name] != parameter.default:
            found.append(f"{parameter.name} = {parameter.plain(given[parameter.name])}")
    return found


def elapsed(seconds: float | None) -> str:
    """A time in words, two digits."""
    if seconds is None:
        return ""
    if seconds < 0.9995:
        return f"{max(1, round(1000 * seconds))}{numbers.SPACE}ms"
    return f"{seconds:.1f}{numbers.SPACE}s" if seconds < 60 else f"{int(seconds // 60)} min {int(seconds % 60)} s"


def size(facts: Mapping[str, Any]) -> str:
    """The size of the first output, from its facts."""
    for known in facts.values():
        if not isinstance(known, Mapping):
            continue
        if shape := known.get("shape"):
            return " × ".join(str(n) for n in reversed(tuple(shape)))
        for name in ("points", "triangles", "items", "rows", "layers"):
            if isinstance(known.get(name), int):
                return f"{numbers.count(known[name])} {name}"
        return ""
    return ""
