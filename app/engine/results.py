"""What firings gave, by key: the least recently used leave when the bytes exceed a bound; failures stay until cleared."""

from __future__ import annotations

import enum
import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from types import FunctionType, ModuleType, UnionType
from typing import Any

import numpy as np

from app.engine.errors import ModuleFailed
from app.engine.machine import memory
from modules.data.accuracy import Carrier, Ended, Missing, Source

_LEAVES = frozenset(
    {int, float, complex, bool, str, bytes, type(None), type, FunctionType, ModuleType, np.float64, np.int64, np.bool_}
    | {Source, Missing, Ended, Carrier}
)
"""What holds no array."""


@dataclass(frozen=True, eq=False)
class Entry:
    """What one firing gave. Making one makes its arrays read-only, since what is published is shared.

    Parameters
    ----------
    outputs : name -> wire value
    facts : output -> cheap facts, computed beside it
    warnings : raised while it ran
    seconds : it took

    Attributes
    ----------
    buffers : bytes of each owning buffer, by its id
    """

    outputs: Mapping[str, Any]
    facts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0
    buffers: Mapping[int, int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "buffers", {id(owner): owner.nbytes for owner in map(_frozen, arrays(self.outputs))})

    def __reduce__(self) -> tuple[type[Entry], tuple[Any, ...]]:
        return Entry, (self.outputs, self.facts, self.warnings, self.seconds)

    @property
    def bytes(self) -> int:
        """Bytes of its buffers, shared ones too."""
        return sum(self.buffers.values())


class Results:
    """A store of entries bounded in bytes; buffers shared by several entries count once. Safe from any thread.

    Parameters
    ----------
    bound : bytes; by default a quarter of the memory that the process may use
    """

    def __init__(self, bound: int | None = None) -> None:
        self.bound = memory() // 4 if bound is None else bound
        self._entries: OrderedDict[str, Entry] = OrderedDict()
        self._holders: dict[int, int] = {}
        self._failures: dict[str, ModuleFailed] = {}
        self._bytes = 0
        self._lock = threading.RLock()

    def __contains__(self, key: object) -> bool:
        with self._lock:
            return key in self._entries

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def bytes(self) -> int:
        """Bytes held."""
        return self._bytes

    def get(self, key: str) -> Entry | None:
        """The entry of a key, now the most recently used; None if there is none."""
        with self._lock:
            entry = self._entries.get(key)
            if entry is not None:
                self._entries.move_to_end(key)
            return entry

    def put(self, key: str, entry: Entry) -> None:
        """Keep an entry; those used longest ago leave until the bound holds."""
        with self._lock:
            self.drop(key)
            self._entries[key] = entry
            for buffer, size in entry.buffers.items():
                held = self._holders.get(buffer, 0)
                self._holders[buffer] = held + 1
                self._bytes += 0 if held else size
            while self._entries and self._bytes > self.bound:
                self.drop(next(iter(self._entries)))
            if self.bound <= 0:
                self.drop(key)

    def drop(self, key: str) -> None:
        """Forget a result."""
        with self._lock:
            entry = self._entries.pop(key, None)
            for buffer, size in entry.buffers.items() if entry else ():
                self._holders[buffer] -= 1
                if not self._holders[buffer]:
                    del self._holders[buffer]
                    self._bytes -= size

    def clear(self) -> None:
        """Forget all results; failures stay."""
        with self._lock:
            self._entries.clear()
            self._holders.clear()
            self._bytes = 0

    # --- failures

    @property
    def failures(self) -> Mapping[str, ModuleFailed]:
        """Why keys failed."""
        with self._lock:
            return dict(self._failures)

    def failure(self, key: str) -> ModuleFailed | None:
        """Why a key failed before, if it did."""
        return self._failures.get(key)

    def fail(self, key: str, error: ModuleFailed) -> None:
        """Keep a failure, so that it is not tried again."""
        with self._lock:
            self._failures[key] = error

    def forgive(self, key: str | None = None) -> None:
        """Let a failed key, or all, be tried again."""
        with self._lock:
            if key is None:
                self._failures.clear()
            else:
                self._failures.pop(key, None)


def arrays(value: Any) -> list[np.ndarray[Any, Any]]:
    """Every array inside a value: in tuples, lists, mappings, and the attributes of objects (sparse matrices too)."""
    found: list[np.ndarray[Any, Any]] = []
    seen, stack = set[int](), [value]
    while stack:
        one = stack.pop()
        kind = type(one)
        if kind in _LEAVES or id(one) in seen:
            continue
        seen.add(id(one))
        parts = (_PARTS.get(kind) or _parts(kind))(one)
        if parts is None:
            found.append(one)
        else:
            stack += [part for part in parts if type(part) not in _LEAVES]
    return found


Parts = Callable[[Any], Collection[Any] | None]

_PARTS: dict[type, Parts] = {}


def _parts(kind: type) -> Parts:
    """How to find what a value of a type is made of; None for an array."""
    ways: tuple[tuple[type | UnionType, Parts], ...] = (
        (np.ndarray, lambda one: None),
        (Mapping, lambda one: one.values()),
        (tuple | list | set | frozenset, lambda one: one),
        (type | str | bytes | int | float | enum.Enum, lambda one: ()),
        (object, _attributes),
    )
    way = _PARTS[kind] = next(way for kinds, way in ways if issubclass(kind, kinds))
    return way


def _attributes(one: Any) -> Collection[Any]:
    slots = getattr(type(one), "__slots__", ())
    named = getattr(one, "__dict__", {}).values()
    return [*(getattr(one, name, None) for name in slots), *named] if slots else named


def _frozen(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The owner of an array's buffer; all on the way to it made read-only."""
    array.flags.writeable = False
    while isinstance(array.base, np.ndarray):
        array = array.base
        array.flags.writeable = False
    return array
