"""What a file of many named arrays holds: variables with dimensions and attributes, as stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Cut = tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Variable:
    """An array as it is stored.

    Parameters
    ----------
    dims : a name for each axis; "" where the file gives none
    read : the part of it that slices and indices tell
    """

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: Mapping[str, Any]
    read: Callable[[Cut], NDArray[Any]]

    def text(self, name: str) -> str:
        """An attribute as text; "" if there is none."""
        return text(self.attributes.get(name))

    def number(self, name: str) -> float | None:
        """An attribute as a number; None if there is none."""
        value = self.attributes.get(name)
        if value is None:
            return None
        array = np.asarray(value).ravel()
        if not array.size or array.dtype.kind not in "iuf":
            return None
        return float(array[0])


@dataclass(frozen=True, eq=False)
class Store:
    """What a file holds.

    Parameters
    ----------
    attributes : of the whole file
    notes : what was taken for granted when it was opened
    """

    path: Path
    variables: Mapping[str, Variable]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def text(value: Any) -> str:
    """An attribute as text, whatever it is stored as."""
    if value is None:
        return ""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace").strip("\0 ")
    if isinstance(value, np.ndarray):
        parts = [text(v) for v in value.ravel()[:64]]
        return " ".join(p for p in parts if p)
    return str(value).strip()


def attributes_of(item: Any) -> dict[str, Any]:
    """Attributes of an HDF5 object that are plain numbers or text."""
    found = {}
    for name in item.attrs:
        if name in ("DIMENSION_LIST", "REFERENCE_LIST"):
            continue
        try:
            found[name] = item.attrs[name]
        except (OSError, TypeError):  # a type that numpy has no word for
            continue
    return found
