"""Maps as text: a matrix of numbers, columns x, y, z that fill a lattice, and ESRI grids (.asc)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.operators import Floats
from modules.readers._files import ReadError, fits, nearest
from modules.readers._raw import Raw

NOTHING = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--"})
ESRI = ("ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value")
ACROSS = ("x", "lon", "longitude", "easting", "long")
UPWARDS = ("y", "lat", "latitude", "northing")


@dataclass(frozen=True)
class Words:
    """The words of a text, row by row.

    Parameters
    ----------
    rows : words of each line that holds numbers
    lines : number of that line in the file
    names : words of the line above, if these are no numbers
    settings : of an ESRI header
    """

    rows: list[list[str]]
    lines: list[int]
    names: tuple[str, ...]
    settings: dict[str, float]


def load(path: Path, name: str, stride: int) -> Raw:
    """The map in a text file.

    Raises
    ------
    ReadError : with line and column, what is no number, or which row is too long
    """
    words = split(path, path.read_bytes())
    if not words.rows:
        raise ReadError(f"{path.name!r} holds no line of numbers: is it the right file?")
    _equal(path, words)
    values, halves = _numbers(path, words)
    columns = _triples(words, values)
    if columns is not None:
        return _lattice(path, words, values, halves, columns, name, stride)
    if name and name != "values":
        raise ReadError(f"{path.name!r} is one map without names: leave 'name' automatic, not {name!r}")
    fits(path, (values.shape[0], values.shape[1]), stride)
    return _raw(path, values, halves, stride, "values", **_esri(path, words, values))


def peek(path: Path) -> dict[str, Any]:
    """Names of the columns, and whether the first lines are points that lie on no lattice."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    cut = start.rfind(b"\n")
    words = split(path, start[:cut] if cut > 0 else start)
    named = _roles(words.names)
    names = tuple(n for i, n in enumerate(words.names) if i not in named) if named else ("values",)
    return {"names": names, "lattice": not _scattered(words, named)}


def _scattered(words: Words, named: tuple[int, int] | None) -> bool:
    at = named or ((0, 1) if not words.settings and words.rows and len(words.rows[0]) == 3 else None)
    if at is None or len(words.rows) < 4 or any(len(row) <= max(at) for row in words.rows):
        return False
    x, y = (len({row[i] for row in words.rows}) for i in at)
    return x > 2 and y > 2 and len(words.rows) < 0.5 * x * y


def split(path: Path, data: bytes) -> Words:
    """The lines of a text as words, by whatever stands between them; comments and an ESRI header taken off.

    Raises
    ------
    ReadError : no text, or a setting of the header that is no number
    """
    text = _decoded(path, data)
    lines = [(i, line.strip()) for i, line in enumerate(text.splitlines(), 1)]
    lines = [(i, line) for i, line in lines if line and not line.startswith(("#", "%", "//"))]
    settings: dict[str, float] = {}
    while lines and (pair := re.match(r"([A-Za-z_]+)\s+(\S+)$", lines[0][1])) and pair.group(1).lower() in ESRI:
        settings[pair.group(1).lower()] = _setting(path, *lines[0], pair.group(2))
        del lines[0]
    cut = _delimiter([line for _, line in lines[:50]])
    rows = [[w.strip().strip('"') for w in (line.split(cut) if cut else line.split())] for _, line in lines]
    rows = [row[:-1] if cut and len(row) > 1 and not row[-1] else row for row in rows] if _trailing(rows, cut) else rows
    signs = {c for row in rows[:50] for w in row for c in w}
    if cut != "," and "," in signs and "." not in signs:
        rows = [[w.replace(",", ".") for w in row] for row in rows]
    names: tuple[str, ...] = ()
    if rows and not any(is_number(w) for w in rows[0] if w):
        names = tuple(rows.pop(0))
        lines = lines[1:]
    return Words(rows, [i for i, _ in lines], names, settings)


def _decoded(path: Path, data: bytes) -> str:
    try:
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeError:
        if b"\0" in data:
            raise ReadError(f"{path.name!r} is no text: choose a file of numbers as text") from None
        return data.decode("latin-1")


def _setting(path: Path, line: int, text: str, word: str) -> float:
    if not is_number(word):
        raise ReadError(f"{path.name!r}, line {line}: {text!r} should end in a number")
    return float(word)


def _delimiter(lines: Sequence[str]) -> str:
    """The sign between numbers; "" for blanks."""
    return next((sign for sign in (";", "\t", ",") if any(sign in line for line in lines)), "")


def _trailing(rows: list[list[str]], cut: str) -> bool:
    return bool(cut) and bool(rows) and all(not row[-1] for row in rows)


def is_number(word: str) -> bool:
    """Whether a word is a number as people print it; Python's 1_000 is none."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


def _equal(path: Path, words: Words) -> None:
    width = len(words.names) or len(words.rows[0])
    for row, line in zip(words.rows, words.lines, strict=True):
        if len(row) != width:
            raise ReadError(f"{path.name!r}, line {line}: there are {len(row)} numbers; the lines before have {width}")


def _numbers(path: Path, words: Words) -> tuple[Floats, Floats]:
    """(rows, columns) values, and half a unit of the last digit that is printed of each."""
    values, halves = np.empty((2, len(words.rows), len(words.rows[0])))
    for i, row in enumerate(words.rows):
        try:
            values[i] = [float(w) for w in row]
        except ValueError:
            values[i] = [_number(path, words.lines[i], j, w) for j, w in enumerate(row, 1)]
        halves[i] = [half_digit(w) for w in row]
    halves = np.maximum(halves, np.spacing(np.abs(np.where(np.isfinite(values), values, 0))) / 2)
    return values, halves


def _number(path: Path, line: int, column: int, word: str) -> float:
    if word.lower() in NOTHING:
        return float("nan")
    if not is_number(word):
        raise ReadError(f"{path.name!r}, line {line}, column {column}: {word[:20]!r} is not a number")
    return float(word)


def half_digit(word: str) -> float:
    """Half a unit of the last printed digit: 0.05 for "1.5", 50 for "1.5e3"."""
    mantissa, _, exponent = word.lower().partition("e")
    _, _, decimals = mantissa.partition(".")
    if not (mantissa[-1:].isdigit() or mantissa.endswith(".")):
        return 0.0
    return 0.5 * 10.0 ** ((int(exponent) if exponent.lstrip("+-").isdigit() else 0) - len(decimals))


def _roles(names: Sequence[str]) -> tuple[int, int] | None:
    """Columns of x and y by their names."""
    lower = [re.split(r"[\s(\[]", n.lower())[0] for n in names]
    x = next((i for i, n in enumerate(lower) if n in ACROSS), None)
    y = next((i for i, n in enumerate(lower) if n in UPWARDS), None)
    return None if x is None or y is None or len(names) < 3 else (x, y)


def _triples(words: Words, values: Floats) -> tuple[int, int] | None:
    """Columns of x and y if the rows are points, None if they are rows of a map."""
    if words.settings:
        return None
    named = _roles(words.names)
    if named or values.shape[1] != 3 or len(values) < 4:
        return named
    nx, ny = len(np.unique(values[:, 0])), len(np.unique(values[:, 1]))
    return (0, 1) if nx > 1 and ny > 1 and nx * ny == len(values) else None


def _lattice(
    path: Path, words: Words, values: Floats, halves: Floats, at: tuple[int, int], name: str, stride: int
) -> Raw:
    others = [i for i in range(values.shape[1]) if i not in at]
    names = list(words.names) or [f"column {i + 1}" for i in range(values.shape[1])]
    if name and name not in [names[i] for i in others]:
        there = ", ".join(names[i] for i in others)
        raise ReadError(f"{path.name!r} has no column {name!r}{nearest(name, names)}; its columns are {there}")
    column = names.index(name) if name else others[0]
    if not np.isfinite(values[:, at]).all():
        bad = words.lines[int(np.flatnonzero(~np.isfinite(values[:, at]).all(axis=1))[0])]
        raise ReadError(f"{path.name!r}, line {bad}: a point has no x or y")
    x, column_of = np.unique(values[:, at[0]], return_inverse=True)
    y, row_of = np.unique(values[:, at[1]], return_inverse=True)
    shape = (len(y), len(x))
    place = row_of * len(x) + column_of
    if len(np.unique(place)) < len(place):
        double = words.lines[int(np.flatnonzero(np.bincount(place)[place] > 1)[1])]
        raise ReadError(f"{path.name!r}, line {double}: this point occurs twice")
    if len(place) < 0.5 * shape[0] * shape[1]:
        raise ReadError(
            f"the {len(place)} points of {path.name!r} do not fill a lattice ({shape[1]} different x, {shape[0]} different y): "
            "they are scattered: read them with 'Read points', then 'Grid points'"
        )
    fits(path, shape, stride)
    grid, half = np.full(shape, np.nan), np.zeros(shape)
    grid.ravel()[place], half.ravel()[place] = values[:, column], halves[:, column]
    degrees = words.names and words.names[at[0]].lower().startswith("lon")
    return _raw(path, grid, half, stride, names[column], x=x, y=y, lengths="degree" if degrees else "")


def _raw(path: Path, values: Floats, halves: Floats, stride: int, name: str, **known: Any) -> Raw:
    holes = np.isnan(values)
    holes |= known.pop("holes", False)
    used = halves[~holes]
    same = used.size and used.max() == used.min()
    rounding = np.asarray(used.max(initial=0.0)) if same or not used.size else np.where(holes, 0.0, halves)
    return Raw(
        values=values[::stride, ::stride], full=(values.shape[0], values.shape[1]), half=rounding, name=name,
        stored="half a unit of the last printed digit", holes=holes[::stride, ::stride] if holes.any() else None, **known,
    )  # fmt: skip


def _esri(path: Path, words: Words, values: NDArray[Any]) -> dict[str, Any]:
    """Axes and holes of an ESRI header."""
    s = words.settings
    if not s:
        return {}
    rows, columns = values.shape
    if (s.get("nrows", rows), s.get("ncols", columns)) != (rows, columns):
        raise ReadError(
            f"{path.name!r} says it has {s.get('nrows', rows):g} rows and {s.get('ncols', columns):g} columns; "
            f"it has {rows} and {columns}: copy or download it again"
        )
    hx, hy = s.get("dx", s.get("cellsize", 1.0)), s.get("dy", s.get("cellsize", 1.0))
    if hx <= 0 or hy <= 0:
        raise ReadError(f"{path.name!r} states a cell of no size: correct its header")
    x0 = s["xllcenter"] if "xllcenter" in s else s.get("xllcorner", 0.0) + hx / 2
    y0 = s["yllcenter"] if "yllcenter" in s else s.get("yllcorner", 0.0) + hy / 2
    return {
        "x": x0 + hx * np.arange(columns),
        "y": (y0 + hy * np.arange(rows))[::-1],
        "holes": values == s.get("nodata_value", -9999.0),
    }
