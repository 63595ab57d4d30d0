"""Names of results by their content: what the same firing gets anywhere, on any machine.

A parameter enters as `canonical` bytes of its effective value in its declared type; a file enters as the digest of its
content, a wire as the key of the firing it comes from and the output's name.
"""

from __future__ import annotations

import enum
import math
import struct
import unicodedata
from functools import lru_cache
from hashlib import blake2b
from pathlib import PurePath
from typing import Any

import numpy as np

FORMAT = 1
"""Raised when the engine itself gives other results for the same network."""

LARGEST = 64 * 1024
"""Bytes that the canonical form of one parameter may have."""


def canonical(value: Any) -> bytes:
    """Bytes that are equal exactly if the values are: -0.0 = 0.0, [1] = (1,), True /= 1 /= 1.0.

    Raises
    ------
    ValueError : NaN
    TypeError : a path (its file's identity enters instead), or what cannot be a parameter
    """
    kind = type(value)
    if kind is str:
        return _text(value)
    if kind is float and value == value:
        return b"d" + struct.pack("<d", value + 0.0)
    return _canonical_one(value)


def _canonical_one(value: Any) -> bytes:
    match value:
        case None:
            return b"N"
        case bool():
            return b"T" if value else b"F"
        case enum.Enum():
            return tag(b"e", value.name.encode())
        case int():
            return tag(b"i", str(value).encode())
        case float():
            if math.isnan(value):
                raise ValueError("a parameter cannot be NaN; leave it empty for 'automatic'")
            return b"d" + struct.pack("<d", value + 0.0)
        case str():
            return _text(str(value))
        case bytes():
            return tag(b"b", value)
        case PurePath():
            raise TypeError("a path enters a key as the identity of its file, not as text")
        case np.generic():
            return canonical(value.item())
    return _canonical_many(value)


@lru_cache(4096)
def _text(value: str) -> bytes:
    return tag(b"s", unicodedata.normalize("NFC", value).encode("utf-8", "surrogatepass"))


def _canonical_many(value: Any) -> bytes:
    match value:
        case np.ndarray() if not value.dtype.hasobject:
            array = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
            array = array + 0 if array.dtype.kind in "fc" else array  # -0.0 becomes 0.0
            shape = repr(value.shape).encode()
            return tag(b"a", array.dtype.str.encode()) + tag(b"", shape) + blake2b(array.tobytes(), digest_size=16).digest()
        case tuple() | list():
            return tag(b"l", b"".join(map(canonical, value)))
        case set() | frozenset():
            return tag(b"z", b"".join(sorted(map(canonical, value))))
        case dict():
            pairs = sorted((canonical(k), canonical(v)) for k, v in value.items())
            return tag(b"m", b"".join(k + v for k, v in pairs))
    raise TypeError(f"a {type(value).__name__} cannot be a parameter")


def tag(kind: bytes, body: bytes) -> bytes:
    """A body that says how long it is, so that ("a", "bc") is not ("ab", "c")."""
    return kind + str(len(body)).encode() + b":" + body


def digest(data: bytes) -> str:
    """blake2b of 128 bits, as text."""
    return blake2b(data, digest_size=16).hexdigest()


def too_large(data: bytes) -> str:
    """Why a parameter's canonical bytes are refused; "" if they are not."""
    if len(data) <= LARGEST:
        return ""
    return f"has {len(data) // 1024} KiB; a parameter has at most {LARGEST // 1024}: make it a data file and read it"
