"""Columns of numbers in a text table, and what its other columns say of their errors."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from modules.api import Accuracy, Identity, Source, Term
from modules.data import companions
from modules.data.operators import Floats
from modules.readers._files import ReadError, existing, nearest, unreadable
from modules.readers._text import NOTHING, half_digit, is_number, split

SUFFIXES = (".csv", ".tsv", ".txt", ".xyz", ".dat")
UNIT = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]+?)\s*[\])]$")


@dataclass(frozen=True)
class Columns:
    """A table of a file.

    Parameters
    ----------
    path : the file
    values : name -> (n,) numbers, NaN where there is none; columns of words are left out
    halves : name -> (n,) half a unit of the last printed digit
    units : name -> unit that stands behind the name in brackets
    lines : number of each row's line in the file
    """

    path: Path
    values: dict[str, Floats]
    halves: dict[str, Floats]
    lines: Sequence[int]
    units: dict[str, str] = field(default_factory=dict)

    def chosen(self, what: str, name: str | None, automatic: Sequence[str]) -> str:
        """The column of that name, or the first whose name is one of `automatic`; "" if there is none.

        Raises
        ------
        ReadError : a name that no column has
        """
        if name:
            if name not in self.values:
                there = ", ".join(self.values)
                close = nearest(name, list(self.values))
                raise ReadError(f"{self.path.name!r} has no column {name!r} for {what}{close}; it has {there}")
            return name
        lower = {n.lower(): n for n in reversed(self.values)}
        return next((lower[one] for one in automatic if one in lower), "")

    def accuracy(self, name: str, rows: Any, content: str, quantity: str = "value", unit: str = "") -> Accuracy:
        """What is known of a column's errors: printed digits, and the columns beside it.

        Raises
        ------
        ReadError : a column beside it that is no size of an error
        """
        values = self.values[name][rows]
        try:
            beside = companions.found(
                name, values, unit, self.values, lambda other: self.values[other][rows], quantity, content
            )
        except ValueError as error:
            raise ReadError(f"{self.path.name!r}: {error}") from None
        rule = "half a unit of the last printed digit (rounding of stored numbers/1)"
        half = np.where(np.isnan(values), 0.0, self.halves[name][rows])
        digits = Term(
            Source("Quantisation", "data", "proven", rule), "bound", quantity, unit, half, Identity(len(half)),
            id=f"{content}/{name}/quantisation",
        )  # fmt: skip
        return Accuracy((digits, *beside.terms[1:]), beside.missing)


def read(path: Path, data: bytes | None = None) -> Columns:
    """The table in a text file.

    Raises
    ------
    ReadError : no line of numbers, or a line of another length
    """
    words = split(path, path.read_bytes() if data is None else data)
    if not words.rows:
        raise ReadError(f"{path.name!r} holds no line of numbers: is it the right file?")
    width = len(words.names) or len(words.rows[0])
    for row, line in zip(words.rows, words.lines, strict=True):
        if len(row) != width:
            raise ReadError(f"{path.name!r}, line {line}: there are {len(row)} words; the lines before have {width}")
    values, halves, units = {}, {}, {}
    for i, name in enumerate(_named(words.names, width)):
        column = [row[i] for row in words.rows]
        if sum(is_number(w) for w in column) * 2 < sum(w.lower() not in NOTHING for w in column):
            continue
        values[name[0]], halves[name[0]] = _numbers(path, column, words.lines, i + 1)
        units[name[0]] = name[1]
    if not values:
        raise ReadError(f"{path.name!r} holds columns of words only, no numbers: is it the right file?")
    return Columns(path, values, halves, words.lines, units)


def file_of(path: Path | None) -> Path:
    """The path, if it is a table by its name.

    Raises
    ------
    ReadError : it is not there, or ends otherwise
    """
    found = existing(path)
    if found.suffix.lower() not in SUFFIXES:
        raise unreadable(found, SUFFIXES)
    return found


def peek(path: Path) -> dict[str, Any]:
    """Names of the columns, from the first lines."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    cut = start.rfind(b"\n")
    found = read(path, start[:cut] if cut > 0 else start)
    return {"names": tuple(found.values)}


def _named(names: Sequence[str], width: int) -> list[tuple[str, str]]:
    """Name and unit of each column; a name that occurs again gets its number."""
    found: list[tuple[str, str]] = []
    for i in range(width):
        whole = names[i] if i < len(names) and names[i] else f"column {i + 1}"
        match = UNIT.match(whole)
        name, unit = match.groups() if match and match.group(1) else (whole, "")
        found.append((name if name not in [n for n, _ in found] else f"{name} {i + 1}", unit))
    return found


def _numbers(path: Path, column: list[str], lines: Sequence[int], place: int) -> tuple[Floats, Floats]:
    values, halves = np.empty((2, len(column)))
    for i, word in enumerate(column):
        if not is_number(word) and word.lower() not in NOTHING:
            raise ReadError(f"{path.name!r}, line {lines[i]}, column {place}: {word[:20]!r} is not a number")
        values[i] = float(word) if is_number(word) else np.nan
        halves[i] = half_digit(word)
    size = np.abs(np.where(np.isfinite(values), values, 0))
    return values, np.maximum(halves, np.spacing(size) / 2)
