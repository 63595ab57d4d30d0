"""NRRD volumes. VTK's reader takes the first axis of a file without `kinds` for components, so the header is read here.

Source: Nearly Raw Raster Data, definition of the format, teem.sourceforge.net/nrrd/format.html.
"""

from __future__ import annotations

import bz2
import gzip
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Flag
from modules.data.grid import Frame, regular
from modules.data.wires import Samples
from modules.readers import _numbers
from modules.readers._files import ReadError, digest, fits, reading

KINDS: Mapping[str, str] = {
    name: code
    for code, names in {
        "i1": "signed char,int8,int8_t", "u1": "uchar,unsigned char,uint8,uint8_t",
        "i2": "short,short int,signed short,int16,int16_t",
        "u2": "ushort,unsigned short,uint16,uint16_t", "i4": "int,signed int,int32,int32_t",
        "u4": "uint,unsigned int,uint32,uint32_t", "i8": "longlong,long long,int64,int64_t", "u8": "ulonglong,uint64,uint64_t",
        "f4": "float", "f8": "double",
    }.items()
    for name in names.split(",")
}  # fmt: skip
SPACE = ("domain", "space", "none", "???")


@dataclass(frozen=True)
class Header:
    """Fields of the header, and where the numbers begin.

    Parameters
    ----------
    sizes : the fastest axis first
    """

    fields: Mapping[str, str]
    sizes: tuple[int, ...]
    dtype: np.dtype[Any]
    start: int

    def numbers(self, name: str) -> list[float]:
        """A field of numbers; NaN where it says none."""
        return [float(w) if w.lower() not in ("none", "???") else np.nan for w in self.fields.get(name, "").split()]


def samples(path: Path, name: str) -> Samples:
    """The volume, or a vector field whose first axis is no axis of space.

    Raises
    ------
    ReadError : damaged, or of an encoding that is not read
    """
    with reading(path):
        header = _header(path)
        fits(path, header.sizes)
        raw = _data(path, header)
    if name and name != path.stem:
        raise ReadError(f"{path.name!r} is one array without a name: leave 'name' automatic, not {name!r}")
    axes = _axes(header)
    vector = len(axes) < len(header.sizes)
    values = raw.reshape(tuple(reversed(header.sizes)))
    if vector and header.sizes[0] != 3:
        raise ReadError(f"{path.name!r} has {header.sizes[0]} numbers a sample; a scalar has 1, a vector 3")
    if not 1 <= len(axes) <= 3:
        raise ReadError(f"{path.name!r} has {len(axes)} axes of space; 1 to 3 are read")
    spacing, origin, flags = _place(header, axes)
    units = [u.strip('"') for u in header.fields.get("space units", header.fields.get("units", "")).split()]
    unit = units[0] if units else ""
    shape = values.shape[:-1] if vector else values.shape
    grid = regular(shape, spacing, origin, Frame(units=(unit, unit, unit), crs=header.fields.get("space", "")))
    quantity = header.fields.get("sample units", "").strip('"')
    accuracy = _numbers.stated_none(values, quantity, f"{digest(path)}/{path.stem}", 3 if vector else 1)
    return Samples(
        grid=grid, values=values, unit=quantity, name=path.stem, accuracy=accuracy.flag(*flags),
    )  # fmt: skip


def peek(path: Path) -> dict[str, Any]:
    """Name and shape, from the header."""
    with reading(path):
        header = _header(path)
    return {"names": (path.stem,), "shape": tuple(reversed([header.sizes[i] for i in _axes(header)]))}


def companions(path: Path) -> list[Path]:
    """The file of the numbers of a detached header."""
    try:
        named = _header(path).fields.get("data file", "")
    except (OSError, ValueError):
        return []
    return [path.parent / named] if named and (path.parent / named).is_file() else []


def _header(path: Path) -> Header:
    with path.open("rb") as file:
        start = file.read(1 << 20)
    if not start.startswith(b"NRRD"):
        raise ReadError(f"{path.name!r} is no NRRD file, whatever its name says: choose another file")
    blank = next((mark for mark in (b"\n\n", b"\r\n\r\n") if mark in start), b"")
    text = start.partition(blank)[0] if blank else start
    fields: dict[str, str] = {}
    for line in text.decode("latin-1").splitlines()[1:]:
        key, sign, value = line.partition(":")
        if sign and not line.startswith("#"):
            fields[key.strip().lower().replace("datafile", "data file")] = value.strip("= ")
    if "sizes" not in fields or fields.get("type", "").lower() not in KINDS:
        raise ReadError(f"the header of {path.name!r} names no sizes, or no type of numbers: copy or download it again")
    order = ">" if fields.get("endian", "little") == "big" else "<"
    sizes = tuple(int(n) for n in fields["sizes"].split())
    return Header(fields, sizes, np.dtype(order + KINDS[fields["type"].lower()]), len(text) + len(blank))


def _data(path: Path, header: Header) -> NDArray[Any]:
    named = header.fields.get("data file", "")
    place = path.parent / named if named else path
    if named and not place.is_file():
        raise ReadError(f"{path.name!r} names the numbers {named!r}, which are not there: copy them beside it")
    data = place.read_bytes()[0 if named else header.start :]
    encoding = header.fields.get("encoding", "raw").lower()
    count = int(np.prod(header.sizes))
    if encoding in ("gzip", "gz"):
        data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else zlib.decompress(data)
    elif encoding in ("bzip2", "bz2"):
        data = bz2.decompress(data)
    elif encoding in ("ascii", "text", "txt"):
        return np.array(data.split(), dtype=header.dtype)[:count]
    elif encoding != "raw":
        raise ReadError(f"{path.name!r} is packed as {encoding!r}; raw, gzip, bzip2 and ascii are read: convert it")
    skip = int(header.fields.get("byte skip", "0"))
    data = data[-count * header.dtype.itemsize :] if skip < 0 else data[skip:]
    if len(data) < count * header.dtype.itemsize:
        raise ReadError(_numbers.words(place.name, len(data), tuple(reversed(header.sizes)), header.dtype, 0))
    return np.frombuffer(data, header.dtype, count)


def _axes(header: Header) -> list[int]:
    """Which axes are of space: all but a first one whose kind says that it is not."""
    kinds = header.fields.get("kinds", "").lower().split()
    directions = header.fields.get("space directions", "").lower().split()
    first = (kinds and not kinds[0].startswith(SPACE)) or (directions and directions[0] == "none")
    return list(range(1 if first and len(header.sizes) > 1 else 0, len(header.sizes)))


def _place(header: Header, axes: list[int]) -> tuple[list[float], list[float], tuple[Flag, ...]]:
    """Spacing and origin along the axes, and a flag where the file turns them."""
    directions = header.fields.get("space directions", "")
    origin = [float(v) for v in header.fields.get("space origin", "").strip("()").split(",") if v]
    if directions:
        vectors = [np.array([float(v) for v in w.strip("()").split(",")]) for w in directions.split() if w.lower() != "none"]
        spacing = [float(np.linalg.norm(v)) for v in vectors]
        straight = all(v[i] > 0 and np.allclose(np.delete(v, i), 0, atol=1e-9 * spacing[i]) for i, v in enumerate(vectors))
        if not straight:
            words = "the file turns the volume in space; here its axes are those of the array, x y z"
            return spacing, [0.0] * len(axes), (Flag("assumed", words),)
        return spacing, (origin or [0.0] * len(axes))[: len(axes)], ()
    given = header.numbers("spacings") or [1.0] * len(header.sizes)
    least = header.numbers("axis mins") or [0.0] * len(header.sizes)
    return [abs(given[i]) if np.isfinite(given[i]) else 1.0 for i in axes], [np.nan_to_num(least[i]) for i in axes], ()
