"""What a legend consists of, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from modules.data.accuracy import Rigour

Statistic = Literal["largest", "in all", "95 %", ""]


@dataclass(frozen=True, kw_only=True)
class Swatch:
    """A sample of how something is drawn."""

    kind: Literal["line", "dust", "points", "surface"]
    colour: str
    size: float = 1.2
    dashed: bool = False


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A colour bar.

    Parameters
    ----------
    colours : (r, g, b) in [0, 1], low to high
    low, high : its ends
    under, over : whether values lie beyond the ends
    """

    title: str
    unit: str
    colours: tuple[tuple[float, ...], ...]
    low: float
    high: float
    scale: Literal["linear", "logarithmic"] = "linear"
    steps: int = 0
    under: bool = False
    over: bool = False


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One source of error.

    Parameters
    ----------
    sign, rigour : how it is known
    number : two digits and the unit; "" if there is none
    words : the source
    notes : further lines, such as "0.031 m on 95 %" or "1 point = 34 m²"
    statistic : what the number is: largest, in all (a sum), 95 %
    value, p95, total : the numbers themselves, standard deviations times k; None where there is no finite one
    beyond, count : items whose error has no bound within the picture, and all items
    """

    sign: str
    rigour: Rigour
    number: str
    words: str
    notes: tuple[str, ...] = ()
    statistic: Statistic = "largest"
    value: float | None = None
    p95: float | None = None
    total: float | None = None
    beyond: int = 0
    count: int = 0
    spread: bool = False
    id: str = ""
    quantity: str = ""
    unit: str = ""
    stage: str = ""
    rule: str = ""
    swatch: Swatch | None = None


@dataclass(frozen=True, kw_only=True)
class Block:
    """One layer: its title, colours, the errors that it shows, and what is exaggerated."""

    title: str
    swatch: Swatch | None = None
    bar: Bar | None = None
    entries: tuple[Entry, ...] = ()
    boxes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Legend:
    """All that a picture says in words and numbers."""

    drawn: tuple[Block, ...]
    not_drawn: tuple[Entry, ...]
    flags: tuple[str, ...]
    k: float
    footer: str
    caption: str

    def plain(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)

    def lines(self) -> list[str]:
        """As lines of text, for a terminal or a reader of screens."""
        out: list[str] = []
        for block in self.drawn:
            out += [block.title] if block.title else []
            for entry in block.entries:
                out += [_line(entry), *(f"    {note}" for note in entry.notes)]
            out += [f"[{box}]" for box in block.boxes]
        if self.not_drawn:
            out.append("Not drawn")
            for entry in self.not_drawn:
                out += [_line(entry), *(f"    {note}" for note in entry.notes)]
        return [*out, *self.flags, *([self.footer] if self.footer else [])]


def _line(entry: Entry) -> str:
    return " ".join(part for part in (entry.sign, entry.number, entry.words) if part)
