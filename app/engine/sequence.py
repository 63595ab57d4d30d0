"""A parameter that runs through values: an isovalue that sweeps, a step of time, a ladder of tolerances, a seed that moves.

A sequence is a setting of the document, so it is saved and undone like any other; running one edits nothing, each frame is
the network with one other value. It is in no key: frames that were there before are not computed again.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

from app.engine import check
from app.engine.catalogue import Catalogue
from app.engine.errors import ValueRefused
from app.engine.network import Network

SETTING: Final = "sequence"
MOST: Final = 10_000
NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
SPAN: Final = re.compile(rf"\s*({NUMBER})\s*\.\.\s*({NUMBER})\s*(?:/\s*(\d+))?\s*(log)?\s*")
COUNT: Final = 11
"""Frames of a span that does not say how many."""


@dataclass(frozen=True)
class Sequence:
    """A parameter and the values that it takes.

    Parameters
    ----------
    node, parameter : whose values they are
    values : as they are written: "0..1/11" are eleven even ones, "1e-2..1e-8/7 log" seven of equal ratios, "a, b, c" these
    """

    node: str
    parameter: str
    values: str

    @classmethod
    def of(cls, text: str) -> Sequence:
        """From "contour-1.interval=10..50/5", as the command line has it.

        Raises
        ------
        ValueRefused : it is written in another way
        """
        name, equals, values = text.partition("=")
        node, dot, parameter = name.strip().partition(".")
        if not (equals and dot and node and parameter and values.strip()):
            example = "such as isosurface-1.level=0..1/11; or =a, b, c"
            raise ValueRefused(f"{text!r}: write it as NODE.PARAM=FROM..TO/FRAMES, {example}")
        return cls(node, parameter, values.strip())

    def __str__(self) -> str:
        return f"{self.node}.{self.parameter}={self.values}"

    def frames(self, network: Network, catalogue: Catalogue) -> tuple[Any, ...]:
        """The values in their order, each as the parameter takes it.

        Raises
        ------
        UnknownName : no such node or parameter
        ValueRefused : a value that it does not take, or too many
        """
        record = check.known(network[self.node].module, self.node, catalogue)
        return tuple(check.value(self.node, record, self.parameter, v) for v in self._written())

    def _written(self) -> list[str]:
        span = SPAN.fullmatch(self.values)
        if span is None:
            parts = [p.strip() for p in self.values.split(";" if ";" in self.values else ",")]
            if not all(parts) or len(parts) > MOST:
                raise ValueRefused(f"{self.values!r}: write values as FROM..TO/FRAMES, or one after the other with commas")
            return parts
        first, last, log = float(span[1]), float(span[2]), bool(span[4])
        whole = all(re.fullmatch(r"[-+]?\d+", t) for t in (span[1], span[2])) and not log
        count = int(span[3]) if span[3] else int(abs(last - first)) + 1 if whole else COUNT
        if not 1 <= count <= MOST:
            raise ValueRefused(f"{self.values!r} makes {count} frames: give from 1 to {MOST}")
        if log and not (first > 0 and last > 0):
            raise ValueRefused(f"{self.values!r}: equal ratios are of numbers above zero")
        return [_between(first, last, i / (count - 1) if count > 1 else 0.0, log) for i in range(count)]


def _between(first: float, last: float, part: float, log: bool) -> str:
    """The number at a part of the way, in as many digits as tell it: it is read, and is a key."""
    if part in (0.0, 1.0):
        found = last if part else first
    elif log:
        found = math.exp((1 - part) * math.log(first) + part * math.log(last))
    else:
        found = first + part * (last - first)
    return f"{found:.12g}"


def each(sequences: Iterable[Sequence], network: Network, catalogue: Catalogue) -> list[tuple[dict[str, Any], Network]]:
    """Each frame: what it sets, and the network with it. Of several sequences every combination, the last runs fastest.

    Raises
    ------
    UnknownName, ValueRefused : a parameter that is not there, a value that it does not take, or too many frames
    """
    ways = [[(one, value) for value in one.frames(network, catalogue)] for one in sequences]
    if (count := math.prod(map(len, ways))) > MOST:
        raise ValueRefused(f"these sequences make {count} frames together: at most {MOST}")
    found = []
    for frame in product(*ways):
        other = network
        for one, value in frame:
            other = other.set(one.node, one.parameter, value, catalogue)
        found.append(({f"{one.node}.{one.parameter}": value for one, value in frame}, other))
    return found


def kept(settings: Mapping[str, Any]) -> Sequence | None:
    """The sequence that a document has; None without one, or if it cannot be read."""
    try:
        return Sequence.of(str(settings[SETTING])) if settings.get(SETTING) else None
    except ValueRefused:
        return None
