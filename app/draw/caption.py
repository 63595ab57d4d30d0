"""A picture in words: one to three sentences for the certificate and for whoever cannot see it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from app.draw.parts import Entry, Legend

HOW = {"exact": "exactly", "proven": "at most", "estimated": "about", "sampled": "about", "unknown": "an unknown amount"}


def write(legend: Legend, title: str = "") -> str:
    """What is drawn and shown; what is not drawn and how large it is; what is not known."""
    names = [b.title for b in legend.drawn if b.title]
    first = f"{title}: {_and(names)}" if title and names else title or _and(names)
    shown = [_amount(e) for b in legend.drawn for e in b.entries]
    boxes = [box for b in legend.drawn for box in b.boxes]
    if shown:
        drawn = f"drawn is {_and(shown)}" + (f", {_and(boxes)}" if boxes else "")
        first = f"{first}; {drawn}" if first else _upper(drawn)
    elif boxes:
        first = f"{first}, {_and(boxes)}"
    sentences = [first] if first else []
    silent = [_amount(e) for e in legend.not_drawn if e.rigour != "unknown"]
    if silent:
        of_k = f" (k = {legend.k:g})" if any(e.spread for e in legend.not_drawn) else ""
        sentences.append(f"Not drawn: {_and(silent)}{of_k}")
    unknown = [e.words for e in legend.not_drawn if e.rigour == "unknown"]
    if unknown:
        sentences.append(f"Not known: {_and(unknown)}, so the true error may be larger")
    return " ".join(f"{s}." for s in sentences)


def _amount(entry: Entry) -> str:
    if not entry.number:
        return entry.words
    how = HOW[entry.rigour]
    where = {"in all": " in all", "95 %": " on 95 %", "largest": "", "": ""}[entry.statistic]
    return f"{entry.words}, {how} {entry.number}{where}"


def _and(words: Sequence[str]) -> str:
    if len(words) < 2:
        return "".join(words)
    between = "; " if any(", " in w for w in words) else ", "
    return f"{between.join(words[:-1])} and {words[-1]}"


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
