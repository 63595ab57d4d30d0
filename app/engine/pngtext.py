"""Text in the chunks of a PNG: written and read without decoding a pixel."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping

SIGNATURE = b"\x89PNG\r\n\x1a\n"
MOST = 64 << 20
"""Bytes that a text may unpack to; more is not a network of ours."""


class NotPNG(ValueError):
    """Bytes that are no PNG, or a broken one."""


def insert(png: bytes, texts: Mapping[str, str]) -> bytes:
    """The picture with texts as compressed iTXt chunks, before its end."""
    chunks = [(kind, body) for kind, body in _chunks(png) if not (kind == b"iTXt" and _key(body) in texts)]
    added = [
        (b"iTXt", key.encode("latin-1") + b"\0\1\0\0\0" + zlib.compress(text.encode(), 9)) for key, text in texts.items()
    ]
    return SIGNATURE + b"".join(_packed(kind, body) for kind, body in (*chunks[:-1], *added, chunks[-1]))


def texts(png: bytes) -> dict[str, str]:
    """The texts of a picture by key.

    Raises
    ------
    NotPNG : it is no picture, or a byte of it was changed
    """
    return {_key(body): _text(body) for kind, body in _chunks(png) if kind == b"iTXt"}


def _chunks(png: bytes) -> Iterator[tuple[bytes, bytes]]:
    if not png.startswith(SIGNATURE):
        raise NotPNG("it is no PNG")
    at = len(SIGNATURE)
    while at < len(png):
        if at + 12 > len(png):
            raise NotPNG("its end is missing")
        (size,) = struct.unpack_from(">I", png, at)
        kind, body = png[at + 4 : at + 8], png[at + 8 : at + 8 + size]
        check = png[at + 8 + size : at + 12 + size]
        if len(check) < 4 or struct.unpack(">I", check)[0] != zlib.crc32(kind + body):
            raise NotPNG(f"its part {kind.decode('latin-1')!r} is damaged")
        yield kind, body
        at += 12 + size


def _packed(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _key(body: bytes) -> str:
    return body.partition(b"\0")[0].decode("latin-1")


def _text(body: bytes) -> str:
    """The text of an iTXt chunk: key, whether packed, method, language, translated key, text."""
    _, _, rest = body.partition(b"\0")
    packed, fields = rest[:1] == b"\1", rest[2:].split(b"\0", 2)
    if len(fields) < 3:
        raise NotPNG("a text in it is damaged")
    if not packed:
        return fields[2].decode("utf-8", "replace")
    unpack = zlib.decompressobj()
    try:
        plain = unpack.decompress(fields[2], MOST)
    except zlib.error:
        raise NotPNG("a text in it is damaged") from None
    if unpack.unconsumed_tail:
        raise NotPNG("a text in it is too long")
    return plain.decode("utf-8", "replace")
