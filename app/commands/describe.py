"""`nonius describe MODULE`: help made from the module's own signature and docstring; nothing is written twice."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Iterator
from typing import Any

from app import paths
from app.commands.console import Console, columns
from app.engine.catalogue import Catalogue
from modules.declare import Module, Port
from modules.parameters import Parameter, plain

WIDTH = 100


def run(options: argparse.Namespace, console: Console) -> int:
    """Describe one module."""
    record = Catalogue.load().find(options.module)
    console.write("\n".join(description(record)))
    return 0


def description(record: Module) -> Iterator[str]:
    """The help of a module, line by line."""
    yield f"{record.title}  ({record.id}, version {record.version}, {record.room.replace('_', ' ')})"
    yield ""
    yield from textwrap.wrap(record.summary, WIDTH)
    if record.ports:
        yield "\nports"
        yield from columns([(f"  {p.name}", _port(p), p.words) for p in record.ports])
    if record.parameters:
        yield "\nparameters"
        yield from columns([(f"  {p.name}", _default(p), _takes(p)) for p in record.parameters])
    yield "\noutputs"
    yield from columns([(f"  {o.name}", o.type.__name__) for o in record.outputs])
    for title, words in (("accuracy", record.accuracy), ("source", record.source)):
        if words:
            yield f"\n{title}"
            yield from textwrap.wrap(" ".join(words.split()), WIDTH, initial_indent="  ", subsequent_indent="  ")
    if found := examples(record):
        yield "\nused in"
        yield from textwrap.wrap(", ".join(found), WIDTH, initial_indent="  ", subsequent_indent="  ")


def examples(record: Module) -> list[str]:
    """Names of the packaged networks in which a module stands."""
    ids = {record.id, *record.was}
    return [name for name, path in paths.networks().items() if ids & set(_modules(path.read_text("utf-8")))]


def _modules(text: str) -> Iterator[str]:
    """Every text under a key "module" of a network file, wherever it lies."""

    def walk(value: Any) -> Iterator[str]:
        if isinstance(value, dict):
            if isinstance(value.get("module"), str):
                yield value["module"]
            value = list(value.values())
        for inner in value if isinstance(value, list) else ():
            yield from walk(inner)

    try:
        yield from walk(json.loads(text))
    except ValueError:
        return


def _port(port: Port) -> str:
    return f"{port.type.__name__}{', several' if port.many else ''}{', may be left unwired' if port.optional else ''}"


def _default(parameter: Parameter) -> str:
    value = plain(parameter.default)
    unit = f" {parameter.range.unit}" if parameter.range and parameter.range.unit else ""
    return "= automatic" if value is None else f"= {json.dumps(value, ensure_ascii=False)}{unit}"


def _takes(parameter: Parameter) -> str:
    ends = parameter.range
    span = ""
    if ends and (ends.low is not None or ends.high is not None):
        low, high = ("…" if e is None else f"{e:g}" for e in (ends.low, ends.high))
        span = f", {low} to {high}" + ("" if ends.strict else " on a slider")
    return f"{parameter.words}{' ' if parameter.words else ''}({parameter.takes()}{span})"
