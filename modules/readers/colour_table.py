"""Colour maps: by name, or from a small file of colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from modules.api import ColourMap, Literal, Range, reader
from modules.data import colours as named
from modules.readers._files import ReadError, existing

HEX = re.compile(r"#?([0-9A-Fa-f]{6})$")
MOST = 4096
"""More colours are refused: that is an image, not a table."""


@reader("Colour table", output="colours", aliases=("colour map", "palette", "lookup table", "legend colours"))
def colour_table(
    *,
    table: Literal["values", "errors", "greys", "diverging", "file"] = "values",
    path: Path | None = None,
    scale: Literal["linear", "logarithmic"] = "linear",
    steps: Annotated[int, Range(0, 30)] = 0,
    reverse: bool = False,
) -> ColourMap:
    """A colour map by name, or from a text file with one colour a line.

    A line of the file is three numbers, red, green and blue, in 0 to 1 or 0 to 255, or #rrggbb.

    Parameters
    ----------
    table : values (cividis), errors (clay to ember), greys, diverging (blue over grey to brown), or file
    path : the file, if the table is one
    scale : linear or logarithmic; a logarithmic one takes values above zero only, and where it meets others it says so
    steps : number of single colours over equal steps of the values, 0 for a continuous map; on colour bands their borders
        lie on the levels
    reverse : from the last colour to the first

    Raises
    ------
    ReadError : the file is no table of colours; with the line
    ValueError : a single step

    Accuracy: a colour map carries none; it says how values are shown.
    """
    if steps < 0 or steps == 1:
        raise ValueError("a discrete colour map has at least 2 steps; 0 is a continuous one")
    if table == "file":
        found = existing(path)
        name, rows = found.stem, _rows(found)
    else:
        name, rows = table, named.rgb(named.TABLES[table])
    return ColourMap(name, np.ascontiguousarray(rows[::-1] if reverse else rows), scale, steps)


def _rows(path: Path) -> NDArray[np.float64]:
    """(n, 3) colours of a file in [0, 1]."""
    if path.stat().st_size > 1 << 20:
        raise ReadError(f"{path.name!r} is too large for a table of colours: choose a file with one colour a line")
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise ReadError(f"{path.name!r} is no text: choose a file with one colour a line") from None
    rows: list[list[float]] = []
    whole = False  # whether numbers go to 255
    for number, line in enumerate(text.splitlines(), 1):
        words = line.strip()
        if code := HEX.match(words):
            rows.append([int(code[1][i : i + 2], 16) / 255 for i in (0, 2, 4)])
            continue
        if not words or words.startswith(("#", "%", "//")):
            continue
        colour = _numbers(path, number, words, first=not rows)
        if colour:
            whole = whole or max(colour) > 1
            rows.append([-1 - v for v in colour])  # below zero until it is known what they go to
    if len(rows) < 2:
        raise ReadError(f"{path.name!r} holds {len(rows)} colours: a table has at least two, one a line")
    if len(rows) > MOST:
        raise ReadError(f"{path.name!r} holds {len(rows)} colours: at most {MOST} make a table")
    array = np.array(rows)
    return np.where(array < 0, (-1 - array) / (255 if whole else 1), array)


def _numbers(path: Path, number: int, words: str, first: bool) -> list[float]:
    """Red, green and blue of a line; nothing for a line of names above the first colour."""
    parts = [p for p in re.split(r"[,;\s]+", words) if p]
    try:
        colour = [float(p) for p in parts]
    except ValueError:
        if first and not any(re.match(r"[-+.\d]", p) for p in parts):
            return []
        raise ReadError(f"{path.name!r}, line {number}: {words[:40]!r} is no colour: write three numbers, or #rrggbb") from None
    if len(colour) != 3:
        raise ReadError(f"{path.name!r}, line {number}: there are {len(colour)} numbers; a colour has red, green and blue")
    if not all(0 <= v <= 255 for v in colour):
        raise ReadError(f"{path.name!r}, line {number}: {words[:40]!r} leaves 0 to 255")
    return colour
