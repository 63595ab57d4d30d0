"""The chunks of a PNG, without decoding a pixel: text written and read, pictures joined to an animated one (APNG)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence

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


def animated(pictures: Sequence[bytes], fps: int) -> bytes:
    """Pictures of one size and kind as an animated PNG that runs for ever; viewers that know no APNG show the first.

    The film carries no text: each of its pictures has its own network and claims.

    Raises
    ------
    NotPNG : there are none, or they are not of one size and kind
    """
    if not pictures:
        raise NotPNG("a film has one picture at least")
    head, parts, serial = b"", [], 0
    for i, png in enumerate(pictures):
        chunks = list(_chunks(png))
        header = next(body for kind, body in chunks if kind == b"IHDR")
        if i and header != head:
            raise NotPNG(f"picture {i + 1} of a film has another size than the first")
        head = header
        width, height = struct.unpack(">II", header[:8])
        control = struct.pack(">IIIIIHHBB", serial, width, height, 0, 0, 1, fps, 0, 0)
        parts.append(_packed(b"fcTL", control))
        serial += 1
        for body in (body for kind, body in chunks if kind == b"IDAT"):
            if i == 0:
                parts.append(_packed(b"IDAT", body))
                continue
            parts.append(_packed(b"fdAT", struct.pack(">I", serial) + body))
            serial += 1
    begin = _packed(b"IHDR", head) + _packed(b"acTL", struct.pack(">II", len(pictures), 0))
    return SIGNATURE + begin + b"".join(parts) + _packed(b"IEND", b"")


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
