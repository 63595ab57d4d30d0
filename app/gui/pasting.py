"""A part of a network from the clipboard: its wires from nodes that were not copied are named, not held."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from app.engine import document
from app.engine.catalogue import Catalogue
from app.engine.errors import DocumentError
from app.engine.network import Network, Origin, Socket
from app.engine.reading import WIRE


def part(text: str, catalogue: Catalogue) -> Network:
    """The part; `Network.paste` keeps the wires whose sources are there.

    Raises
    ------
    NoniusError : the text is no network
    """
    record = _record(text)
    nodes, lines = record.get("nodes"), record.get("wires")
    if not isinstance(nodes, list) or not isinstance(lines, list):
        return document.loads(text, catalogue, name="the clipboard").network
    names = {n.get("id") for n in nodes if isinstance(n, dict)}
    outside = {line: found for line in lines if (found := _wire(line)) and found["source"] not in names}
    record["wires"] = [line for line in lines if not isinstance(line, str) or line not in outside]
    network = document.loads(json.dumps(record), catalogue, name="the clipboard").network
    wires: dict[Socket, Origin] = dict(network.wires)
    for found in outside.values():
        end = (found["target"], found["port"], int(found["slot"] or 0))
        if found["target"] in names and end not in wires:
            wires[end] = (found["source"], found["output"])
    return replace(network, wires=wires)


def _wire(line: Any) -> Any:
    return WIRE.fullmatch(line) if isinstance(line, str) else None


def _record(text: str) -> dict[str, Any]:
    try:
        record = json.loads(text)
    except ValueError:
        raise DocumentError("the clipboard holds no network: copy nodes first") from None
    if not isinstance(record, dict):
        raise DocumentError("the clipboard holds no network: copy nodes first")
    return record
