"""Plain binary numbers: how many a file should hold, how many it does, and their rounding."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Accuracy, Missing, Source, Term
from modules.data.companions import largest, rounding
from modules.data.operators import Identity
from modules.readers._files import ReadError

TYPES: Mapping[str, str] = {
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float32": "f4", "float64": "f8",
}  # fmt: skip

META: Mapping[str, str] = {
    "MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4", "MET_UINT": "u4",
    "MET_LONG_LONG": "i8", "MET_ULONG_LONG": "u8", "MET_FLOAT": "f4", "MET_DOUBLE": "f8",
}  # fmt: skip
"""Types of a MetaImage; its long has no size of its own."""


def dtype(kind: str, order: str) -> np.dtype[Any]:
    """A type by its name and the order of its bytes."""
    return np.dtype(("<" if order == "little" else ">") + TYPES[kind])


def wanted(shape: tuple[int, ...], kind: np.dtype[Any], header: int = 0) -> int:
    """Bytes that a file of this shape has."""
    return header + math.prod(shape) * kind.itemsize


def words(name: str, size: int, shape: tuple[int, ...], kind: np.dtype[Any], header: int) -> str:
    """The two sizes beside each other, and what would fit."""
    need = wanted(shape, kind, header)
    shown = " x ".join(str(n) for n in reversed(shape))
    head = f" after {header} bytes of header" if header else ""
    said = f"{name!r} has {size} bytes; {shown} numbers of {kind.name}{head} need {need}"
    if size == need:
        return said
    left = size - math.prod(shape) * kind.itemsize
    if left > 0:
        return f"{said}: a header of {left} bytes would fit"
    other = next((k for k, code in TYPES.items() if header + math.prod(shape) * np.dtype(code).itemsize == size), "")
    return f"{said}: {f'type {other} would fit' if other else 'check the dimensions, or copy the file again'}"


def read(path: Path, shape: tuple[int, ...], kind: np.dtype[Any], header: int) -> NDArray[Any]:
    """The array, C-ordered.

    Raises
    ------
    ReadError : the file is too short
    """
    size = path.stat().st_size
    if size < wanted(shape, kind, header):
        raise ReadError(words(path.name, size, shape, kind, header))
    return np.fromfile(path, kind, math.prod(shape), offset=header).reshape(shape)


def stated_none(values: NDArray[Any], unit: str, name: str, components: int = 1) -> Accuracy:
    """The budget of numbers of which nothing is said: their rounding, and that the rest is missing.

    Parameters
    ----------
    name : digest of the file and name of the variable
    """
    half, how = rounding(values.dtype, largest(values))
    source = Source("Quantisation", "data", "proven", f"{how} (rounding of stored numbers/1)")
    here = Identity(values.size)
    term = Term(source, "bound", "value", unit, np.asarray(half), here, components=components, id=f"{name}/quantisation")
    return Accuracy((term,), (Missing("Measurement error", "the file states none"),))
