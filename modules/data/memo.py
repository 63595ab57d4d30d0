"""What can be computed again from a wire value, kept beside it: second differences, min/max blocks."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")

_kept: weakref.WeakKeyDictionary[Any, dict[str, Any]] = weakref.WeakKeyDictionary()
_lock = threading.RLock()


def memo(owner: Any, name: str, compute: Callable[[], T]) -> T:
    """`compute()` the first time, its result afterwards, for as long as `owner` lives. Threads share it."""
    with _lock:
        mine = _kept.setdefault(owner, {})
        lock = mine.setdefault(f"lock:{name}", threading.Lock())
    with lock:
        if name not in mine:
            mine[name] = compute()
        return mine[name]  # type: ignore[no-any-return]  # what compute gave
