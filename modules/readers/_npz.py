"""Numpy's own files: .npy (one array) and .npz (several, by name). Nothing is unpickled."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from modules.data.companions import DEVIATIONS, DOUBTFUL, LIMITS, is_companion, largest, rounding
from modules.data.operators import Floats
from modules.readers._files import ReadError, fits, nearest, reading
from modules.readers._raw import Raw, Stated

LIKELY = ("elevation", "height", "heights", "altitude", "dem", "topo", "z", "data", "values", "field")
PAIRS = (("longitude", "latitude"), ("lon", "lat"), ("easting", "northing"), ("x", "y"))
BLOCK = 8 << 20
"""Bytes that are read at once."""


@dataclass(frozen=True)
class Header:
    """Shape, layout and type of a stored array."""

    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]


def load(path: Path, name: str, stride: int) -> Raw:
    """The map in a .npz or .npy file.

    Raises
    ------
    ReadError : damaged, no such array, not a map of numbers, or too large
    """
    headers = _headers(path)
    chosen = _choose(path, headers, name)
    header = headers[chosen]
    rows, columns = _map_shape(path, chosen, header)
    fits(path, (rows, columns), stride)
    values, size = _read(path, chosen, stride)
    half, words = rounding(header.dtype, size)
    beside = _beside(path, headers, chosen)
    assumed = () if name or len(_maps(headers)) < 2 else (f"of several arrays, {chosen!r} is the map",)
    x, y, lengths = _axes(beside, rows, columns)
    stated = _stated(path, headers, chosen, (rows, columns)) + _limits(path, headers, chosen, (rows, columns))
    return Raw(
        values=values, full=(rows, columns), half=np.asarray(half), stored=words, name=chosen,
        x=x, y=y, lengths=lengths, assumed=assumed, stated=stated,
    )  # fmt: skip


def peek(path: Path) -> dict[str, Any]:
    """Names of the maps in the file and their shape, from the headers alone."""
    headers = _headers(path)
    maps = _maps(headers)
    if not maps:
        return {"names": (), "shape": None}
    return {"names": maps, "shape": headers[_choose(path, headers, "")].shape}


@contextmanager
def _member(path: Path, name: str) -> Iterator[IO[bytes]]:
    """The stream of one array."""
    with reading(path):
        if path.suffix.lower() == ".npy":
            with path.open("rb") as file:
                yield file
        else:
            with zipfile.ZipFile(path) as archive, archive.open(f"{name}.npy") as file:
                yield file


def _names(path: Path) -> list[str]:
    if path.suffix.lower() == ".npy":
        return [path.stem]
    with reading(path), zipfile.ZipFile(path) as archive:
        return [n.removesuffix(".npy") for n in archive.namelist() if n.endswith(".npy")]


def _headers(path: Path) -> dict[str, Header]:
    found = {}
    for name in _names(path):
        with _member(path, name) as file:
            found[name] = _header(file)
    return found


def _header(file: IO[bytes]) -> Header:
    version = npy.read_magic(file)
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(version)
    if read is None:
        raise ValueError(f"numpy format {version[0]}.{version[1]} holds tables of records")
    return Header(*read(file))


def _maps(headers: Mapping[str, Header]) -> tuple[str, ...]:
    maps = [n for n, h in headers.items() if h.dtype.kind in "iufb" and len(_squeezed(h.shape)) == 2]
    return tuple(n for n in maps if not is_companion(n, maps))


def _squeezed(shape: tuple[int, ...]) -> tuple[int, ...]:
    while len(shape) > 2 and shape[0] == 1:
        shape = shape[1:]
    return shape


def _choose(path: Path, headers: Mapping[str, Header], name: str) -> str:
    if name and path.suffix.lower() == ".npz":
        if name not in headers:
            there = ", ".join(headers) or "nothing"
            raise ReadError(f"{path.name!r} has no array {name!r}{nearest(name, tuple(headers))}; it holds {there}")
        return name
    maps = _maps(headers)
    if not maps:
        if len(headers) == 1:
            return next(iter(headers))
        held = ", ".join(f"{n} {h.shape}" for n, h in headers.items()) or "nothing"
        raise ReadError(f"{path.name!r} holds no map, an array of rows and columns; it holds {held}")
    lower = {n.lower(): n for n in maps}
    return next((lower[n] for n in LIKELY if n in lower), max(maps, key=lambda n: np.prod(headers[n].shape, dtype=float)))


def _map_shape(path: Path, name: str, header: Header) -> tuple[int, int]:
    kind, which = header.dtype, f"{name!r} of {path.name!r}"
    if kind.hasobject:
        raise ReadError(f"{which} holds Python objects, which could run a program when read: save it as an array of numbers")
    if kind.kind == "c":
        raise ReadError(f"{which} holds complex numbers: save its real part, imaginary part or size")
    if kind.kind not in "iufb":
        raise ReadError(f"{which} holds {kind}, not numbers: save it as an array of numbers")
    shape = _squeezed(header.shape)
    if len(shape) != 2:
        what = f"has shape {header.shape}" if header.shape else "is a single number"
        raise ReadError(f"{which} {what}; an elevation map has two axes, rows and columns: save one layer of it")
    if not min(shape):
        raise ReadError(f"{which} has shape {header.shape}: there is no sample in it")
    return shape[0], shape[1]


def _read(path: Path, name: str, stride: int) -> tuple[NDArray[Any], float]:
    """Every stride-th row and column, read in blocks of rows, and the largest size of all numbers."""
    with _member(path, name) as file:
        header = _header(file)
        shape = _squeezed(header.shape)
        lines, across = (shape[::-1] if header.fortran else shape) if len(shape) == 2 else (1, int(np.prod(shape, dtype=int)))
        width = across * header.dtype.itemsize
        step = max(1, BLOCK // max(width, 1))
        parts, size = [], 0.0
        for start in range(0, lines, step):
            count = min(step, lines - start)
            data = file.read(count * width)
            if len(data) != count * width:
                there = start + len(data) // max(width, 1)
                ends = f"ends early, after {there} of the {lines} rows of {name!r}"
                raise ReadError(f"{path.name!r} {ends}: copy or download it again")
            block = np.frombuffer(data, header.dtype).reshape(count, across)
            size = max(size, largest(block))
            parts.append(block[-start % stride :: stride, ::stride] if len(shape) == 2 else block)
        file.read(1)  # the end of a zip member is where its checksum is compared
    whole = np.concatenate(parts)
    if len(shape) != 2:
        return whole.reshape(shape), size
    return (whole.T if header.fortran else whole), size


def _beside(path: Path, headers: Mapping[str, Header], chosen: str) -> dict[str, NDArray[Any]]:
    """The small numeric arrays of the file: axes and limits, by lower-case name."""
    small = {n for n, h in headers.items() if n != chosen and h.dtype.kind in "iuf" and len(h.shape) < 2}
    return {n.lower(): _read(path, n, 1)[0] for n in small if np.prod(headers[n].shape, dtype=float) < 1e7}


def _axes(beside: Mapping[str, NDArray[Any]], rows: int, columns: int) -> tuple[Any, Any, str]:
    """(x, y, unit of lengths) from arrays of coordinates, or from limits and steps."""
    for first, second in PAIRS:
        x, y = beside.get(first), beside.get(second)
        if x is not None and y is not None and x.shape == (columns,) and y.shape == (rows,):
            return x, y, "degree" if first.startswith("lon") else ""
    limits = [beside.get(n) for n in ("xmin", "xmax", "ymin", "ymax")]
    if any(v is None or v.shape != () for v in limits):
        return None, None, ""
    x0, x1, y0, y1 = (float(v) for v in limits if v is not None)
    x = _between(x0, x1, columns, beside.get("dx"))
    y = _between(y0, y1, rows, beside.get("dy"))
    near = max(abs(x0), abs(x1)) <= 360 and max(abs(y0), abs(y1)) <= 90
    fine = max(abs(x1 - x0) / columns, abs(y1 - y0) / rows) < 0.5
    return x, y, "degree?" if near and fine else ""


def _between(first: float, last: float, n: int, step: NDArray[Any] | None) -> Floats:
    """Coordinates of n samples; in the middle of cells if the step says that the limits are the cells' edges."""
    h = float(step) if step is not None and step.shape == () else 0.0
    if h and abs(abs(last - first) / abs(h) - n) < 0.25:
        width = (last - first) / n
        return np.asarray(first + width * (np.arange(n) + 0.5), dtype=np.float64)
    return np.asarray(np.linspace(first, last, n), dtype=np.float64)


def _stated(path: Path, headers: Mapping[str, Header], chosen: str, full: tuple[int, int]) -> tuple[Stated, ...]:
    """Standard deviations that lie beside the map under its name."""
    found = []
    for ending in DEVIATIONS:
        name = chosen + ending
        if name not in headers or headers[name].dtype.kind not in "iuf" or _squeezed(headers[name].shape) not in (full, ()):
            continue
        value = np.asarray(_read(path, name, 1)[0], dtype=float)
        value = value.reshape(full) if value.ndim else value
        if not np.isfinite(value).all() or (value < 0).any():
            holds = "it holds negative sizes, NaN or infinity"
            raise ReadError(f"{name!r} of {path.name!r} should hold standard deviations; {holds}")
        rule = f"{name!r} in the file, taken as independent standard deviations (companion array/1)"
        found.append(Stated(name=f"Stated by {name}", what=name, kind="linear", value=value, rule=rule))
    return tuple(found)


def _limits(path: Path, headers: Mapping[str, Header], chosen: str, full: tuple[int, int]) -> tuple[Stated, ...]:
    """Limits that lie beside the map under its name."""
    for low, high in LIMITS:
        names = (chosen + low, chosen + high)
        if any(n not in headers or headers[n].dtype.kind not in "iuf" or _squeezed(headers[n].shape) != full for n in names):
            continue
        below, values, above = (np.asarray(_read(path, n, 1)[0], float).reshape(full) for n in (names[0], chosen, names[1]))
        holes = np.isnan(values)
        if not (holes | ((below <= values) & (values <= above) & np.isfinite(above - below))).all():
            if low in DOUBTFUL:
                continue
            which = f"{names[0]!r} and {names[1]!r} of {path.name!r}"
            raise ReadError(f"{which} do not enclose {chosen!r}: rename them if they are no limits")
        sizes = np.where(holes, 0.0, np.maximum(values - below, above - values))
        rule = f"{names[0]!r} and {names[1]!r} in the file, taken as limits (companion array/1)"
        return (Stated(name=f"Stated by {names[0]}, {names[1]}", what="limits", kind="bound", value=sizes, rule=rule),)
    return ()
