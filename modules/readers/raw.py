"""Numbers without a header, of which the user knows the shape."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from modules.api import Choice, Frame, Range, Samples, reader, regular
from modules.readers import _numbers
from modules.readers._files import NotReadHere, ReadError, digest, existing, fits, problem

SUFFIXES = (".raw", ".bin", ".dat", ".img", ".vol", ".data")


def peek(path: Path) -> Mapping[str, Any]:
    """Size of the file, and shapes that it could have; whatever it holds, it says nothing of its shape."""
    try:
        found = existing(path)
        if found.suffix.lower() not in SUFFIXES:
            raise NotReadHere(f"{found.name!r} is no file of plain numbers by its name")
        size = found.stat().st_size
        guesses = candidates(size)
        shown = ", ".join(f"{' x '.join(map(str, s))} of {k}" for s, k in guesses[:3])
        words = f"{found.name!r} says nothing of its shape: add 'Read raw numbers' and set 'size' and 'type'"
        return {
            "names": tuple(f"{' '.join(map(str, s))} {k}" for s, k in guesses), "bytes": size, "problem": words,
            "words": f"{size} bytes" + (f"; that would be {shown}" if shown else ""),
        }  # fmt: skip
    except ReadError as error:
        return problem(error)


def candidates(size: int) -> list[tuple[tuple[int, ...], str]]:
    """Cubes, squares and stacks of usual slices, of a usual type, that have exactly so many bytes."""
    found: list[tuple[tuple[int, ...], str]] = []
    for kind in ("uint8", "uint16", "float32", "float64"):
        count, rest = divmod(size, np.dtype(kind).itemsize)
        for n, edge in ((3, round(count ** (1 / 3))), (2, round(count**0.5))):
            if not rest and edge > 1 and edge**n == count:
                found.append(((edge,) * n, kind))
    for kind in ("uint8", "uint16", "float32", "float64"):
        for edge in (512, 256, 128, 64):
            layers, rest = divmod(size, edge * edge * np.dtype(kind).itemsize)
            if not rest and 1 < layers <= 1024 and layers != edge:
                found.append(((edge, edge, layers), kind))
    return found


@reader("Read raw numbers", output="samples", peek=peek, aliases=("raw", "binary", "bin", "volume", "datascribe"))
def raw(
    *,
    path: Path | None = None,
    size: tuple[int, ...] = (),
    type: Literal[
        "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"
    ] = "float32",
    order: Literal["little", "big"] = "little",
    header: Annotated[int, Range(0)] = 0,
    components: Literal["1", "3"] = "1",
    spacing: tuple[float, ...] = (),
    unit: str = "",
    lengths: str = "",
    no_data: float | None = None,
    guess: Annotated[str, Choice(of="path.names")] = "",
) -> Samples:
    """Numbers as they lie in memory: the user says how many along each axis, of which type, after how many bytes.

    Parameters
    ----------
    path : the file
    size : samples along x, y, z; x is fastest in the file
    type, order : of each number; the order of its bytes
    header : bytes before the first number
    components : numbers a sample; 3 make a vector, fastest in the file
    spacing : distance of samples along x, y, z; empty for 1
    unit, lengths : of the values and of the coordinates
    no_data : the number that stands for "no value here"
    guess : a shape that fits the bytes of the file, instead of `size` and `type`

    Accuracy: adds the rounding of the stored numbers as a proven bound; an error of measurement is listed as missing.
    """
    found = existing(path)
    if guess:
        *edges, kind = guess.split()
        if kind not in _numbers.TYPES or not all(e.isdecimal() for e in edges):
            raise ReadError(f"guess = {guess!r} is no shape: leave it empty, and set 'size' and 'type'")
        size = tuple(int(e) for e in edges)
    else:
        kind = type
    if not 1 <= len(size) <= 3 or min(size) < 1:
        has = f"{found.name!r} has {found.stat().st_size} bytes"
        raise ReadError(f"{has} and says nothing of its shape: set 'size', as 64, 64, 32")
    if spacing and (len(spacing) != len(size) or not all(np.isfinite(h) and h > 0 for h in spacing)):
        raise ReadError(f"spacing = {spacing} does not fit: give {len(size)} positive numbers, or none")
    stored = _numbers.dtype(kind, order)
    shape = (*reversed(size), *((3,) if components == "3" else ()))
    fits(found, shape)
    bytes_ = found.stat().st_size
    if bytes_ != _numbers.wanted(shape, stored, header):
        raise ReadError(_numbers.words(found.name, bytes_, shape, stored, header))
    values = _numbers.read(found, shape, stored, header)
    accuracy = _numbers.stated_none(values, unit, f"{digest(found)}/{found.stem}", 3 if components == "3" else 1)
    if no_data is not None:
        values = np.where(values == no_data, np.nan, values.astype(float))
    if values.dtype.kind == "f" and np.isinf(values).any():
        raise ReadError(f"{found.name!r} read so holds infinite numbers: check 'type', 'order' and 'header'")
    grid = regular(tuple(reversed(size)), list(spacing) or None, None, Frame(units=(lengths, lengths, lengths)))
    return Samples(grid=grid, values=values, unit=unit, name=found.stem, accuracy=accuracy)
