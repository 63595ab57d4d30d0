"""Which module is meant by a few letters: prefix before start of a word before letters in order; what is used often first."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from app.gui.glyphs import ROOMS
from modules.declare import Module


@dataclass(frozen=True)
class Match:
    """A module that is meant, and why.

    Parameters
    ----------
    letters : places in the title that were typed
    also : the alias or tag that was typed, "" if it was the title
    """

    module: Module
    score: float
    letters: tuple[int, ...] = ()
    also: str = ""


@functools.lru_cache(maxsize=2048)
def _words(module: Module) -> tuple[tuple[str, float], ...]:
    """What a module is called, each with how much that counts."""
    room = ROOMS.get(module.room, module.room)
    ids = module.id.replace("_", " ").split(".")
    return (
        (module.title.casefold(), 0.0),
        *((alias.casefold(), 30.0) for alias in module.aliases),
        (ids[-1].casefold(), 32.0),
        (room.casefold(), 60.0),
    )


def letters(text: str, typed: str) -> tuple[float, tuple[int, ...]] | None:
    """(how far off, places) of what was typed in a text; None if it is not in it."""
    if text.startswith(typed):
        return 0.0, tuple(range(len(typed)))
    at = text.find(f" {typed}")
    if at >= 0:
        return 10.0, tuple(range(at + 1, at + 1 + len(typed)))
    at = text.find(typed)
    if at >= 0 and len(typed) > 2:
        return 15.0, tuple(range(at, at + len(typed)))
    places: list[int] = []
    start = 0
    for letter in typed:
        if letter == " ":
            continue
        found = text.find(letter, start)
        if found < 0:
            return None
        places.append(found)
        start = found + 1
    spread = places[-1] - places[0] + 1 - len(places)
    return (20.0 + spread, tuple(places)) if spread <= 2 * len(typed) else None


def match(module: Module, typed: str) -> Match | None:
    """How a module is meant by what was typed; None if it is not."""
    best: Match | None = None
    for i, (text, cost) in enumerate(_words(module)):
        found = letters(text, typed)
        if found is None or (i and found[0] >= 20.0 and len(typed) < 3):
            continue
        score = found[0] + cost
        if best is None or score < best.score:
            alias = "" if i == 0 else (module.aliases[i - 1] if i <= len(module.aliases) else text)
            best = Match(module, score, found[1] if i == 0 else (), alias)
    return best


def rank(
    modules: Iterable[Module],
    typed: str,
    used: Mapping[str, int] | None = None,
    fits: Callable[[Module], bool] | None = None,
) -> list[Match]:
    """Modules that are meant, the likeliest first; all if nothing was typed.

    Parameters
    ----------
    used : module -> how often the user took it
    fits : leaves out the others
    """
    counts = used or {}
    typed = " ".join(typed.casefold().split())
    rooms = list(ROOMS)
    candidates = [m for m in modules if fits is None or fits(m)]
    if not typed:
        found = [Match(m, 0.0) for m in candidates]
    else:
        found = [f for m in candidates if (f := match(m, typed))]

    def order(one: Match) -> tuple[float, int, int, str]:
        room = rooms.index(one.module.room) if one.module.room in rooms else len(rooms)
        return one.score, -counts.get(one.module.id, 0), room, one.module.title

    return sorted(found, key=order)
