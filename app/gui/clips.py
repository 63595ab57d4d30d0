"""A part of a network as text for the clipboard; wires from outside are remembered beside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.engine import document
from app.engine.catalogue import Catalogue
from app.engine.network import Network

OUTSIDE = "from outside"


def text(part: Network, catalogue: Catalogue) -> str:
    """The text of a part."""
    inside = {end: origin for end, origin in part.wires.items() if origin[0] in part.nodes}
    outside = [[*end, *origin] for end, origin in sorted(part.wires.items()) if origin[0] not in part.nodes]
    whole = replace(part, wires=inside, extras={OUTSIDE: outside} if outside else {})
    return document.clipboard(whole, catalogue)


def part(text: str, catalogue: Catalogue) -> Network:
    """The part in a text, with its wires from outside.

    Raises
    ------
    NetworkError : the text is no network
    """
    found = document.loads(text, catalogue, name="the clipboard").network
    held: Any = found.extras.get(OUTSIDE, [])
    wires = dict(found.wires)
    for one in held if isinstance(held, list) else []:
        if isinstance(one, list) and len(one) == 5 and one[0] in found.nodes:
            target, port, slot, source, output = one
            wires[str(target), str(port), int(slot)] = (str(source), str(output))
    extras = {name: value for name, value in found.extras.items() if name != OUTSIDE}
    return replace(found, wires=wires, extras=extras)
