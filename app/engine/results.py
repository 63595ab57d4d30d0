"""What firings gave, by key: the least recently used leave when the bytes exceed a bound; failures stay until cleared."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from app.engine.errors import ModuleFailed
from app.engine.machine import memory

_PLAIN = (int, float, complex, bool, type(None), type, FunctionType, ModuleType)


@dataclass(frozen=True, eq=False)
class Entry:
    """What one firing gave.

    Parameters
    ----------
    outputs : name -> wire value, arrays read-only
    facts : output -> cheap facts, computed beside it
    warnings : raised while it ran
    seconds : it took
    """

    outputs: Mapping[str, Any]
    facts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0

    @cached_property
    def buffers(self) -> Mapping[int, int]:
        """Bytes of each owning buffer, by its id."""
        return {id(owner): size for owner, size in buffers(self.outputs)}

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


def arrays(value: Any, seen: set[int] | None = None) -> Iterator[np.ndarray[Any, Any]]:
    """Every array inside a value: in tuples, lists, mappings, and the attributes of objects (sparse matrices too)."""
    seen = set() if seen is None else seen
    if isinstance(value, _PLAIN) or isinstance(value, str | bytes | np.generic) or id(value) in seen:
        return
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from arrays(inner, seen)
    elif isinstance(value, list | tuple | set | frozenset):
        for inner in value:
            yield from arrays(inner, seen)
    else:
        for name in getattr(type(value), "__slots__", ()):
            yield from arrays(getattr(value, name, None), seen)
        yield from arrays(getattr(value, "__dict__", None), seen)


def buffers(value: Any) -> Iterator[tuple[Any, int]]:
    """(owning array, bytes) of every array inside a value; an owner may come twice."""
    for array in arrays(value):
        owner = array
        while isinstance(owner.base, np.ndarray):
            owner = owner.base
        yield owner, owner.nbytes


def freeze(value: Any) -> None:
    """Make every array inside a value read-only: what is published is shared."""
    for array in arrays(value):
        view: Any = array
        while isinstance(view, np.ndarray):
            view.flags.writeable = False
            view = view.base
