"""A scene as a PNG that carries its network and claims, and the certificate beside it."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, is_dataclass
from pathlib import Path
from typing import Any

from app import paths
from app.commands.nets import Found
from app.commands.outbox import Outbox
from app.engine import certificate, pngtext
from app.engine.catalogue import Catalogue
from app.engine.scheduler import upstream
from modules.data.fold import Check

PIXEL = "drawing moves what is drawn by at most half the diagonal of a pixel"


@dataclass(frozen=True)
class Out:
    """An output of a node, and the file it goes to."""

    node: str
    output: str
    type: type
    path: Path


def write(
    scene: Any,
    out: Out,
    outbox: Outbox,
    found: Found,
    keys: Mapping[str, str],
    catalogue: Catalogue,
    check: Check | None = None,
) -> str:
    """Stage a picture and its certificate; returns the caption."""
    from app import picture

    network, path = found.network, out.path
    view = network.nodes[out.node].view
    given = {"camera": view["camera"]} if "camera" in view else {}
    drawn = picture.render(scene, k=network.k, **given)
    folder = path.parent.absolute()
    text = certificate.stored(network, folder, catalogue)
    mine = {name: keys[name] for name in sorted(upstream(network, [out.node]))}
    claims = {
        "accuracy": certificate.ACCURACY_FORMAT,
        "caption": drawn.caption,
        "view": {"node": out.node, "output": out.output},
        "k": network.k,
        "exaggeration": scene.look.exaggeration,
        "camera": plain(drawn.camera),
        "pixel": {"bound": plain(drawn.pixel_unit), "unit": drawn.unit, "sign": "≤", "rule": PIXEL},
        "layers": certificate.layers(scene, network.k, check),
        "tolerance": certificate.TOLERANCE,
        "data": certificate.data_files(network, catalogue),
        "network": {"sha256": certificate.digest(text.encode()), "edits": list(found.edits), **_source(found, folder)},
        "keys": mine,
        "versions": paths.versions(),
    }
    png = pngtext.insert(
        _png(drawn.image),
        {
            certificate.NETWORK: text,
            certificate.KEYS: json.dumps(mine, sort_keys=True),
            certificate.ACCURACY: json.dumps(claims, ensure_ascii=False, allow_nan=False),
        },
    )
    height, width = drawn.image.shape[:2]
    sealed = certificate.seal(
        {
            "certificate": certificate.FORMAT,
            "picture": {
                "file": path.name,
                "sha256": certificate.digest(png),
                "bytes": len(png),
                "size": [width, height],
                "pixels": certificate.digest(drawn.image.tobytes()),
            },
            **claims,
        }
    )
    outbox.put(path, png)
    outbox.put(certificate.beside(path), sealed)
    return drawn.caption


def _png(image: Any) -> bytes:
    from PIL import Image

    data = io.BytesIO()
    Image.fromarray(image).save(data, "PNG", optimize=False)
    return data.getvalue()


def pixels(png: bytes) -> tuple[str, list[int]]:
    """(digest of the pixels, [width, height]) of a stored picture.

    Raises
    ------
    ValueError : it cannot be decoded
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(png)) as image:
            return certificate.digest(image.convert("RGBA").tobytes()), list(image.size)
    except (OSError, SyntaxError) as error:
        raise ValueError(f"it cannot be decoded: {error}") from None


def _source(found: Found, folder: Path) -> dict[str, Any]:
    """Where the network came from, as seen from the picture."""
    if found.kind == "packaged":
        place = f"packaged:{found.name}"
    else:
        try:
            place = Path(os.path.relpath(found.path.absolute(), folder)).as_posix()
        except ValueError:  # another drive
            place = found.path.name
    return {"from": place, "from_sha256": certificate.digest(found.path.read_bytes())}


def plain(value: Any) -> Any:
    """A value of the renderer as JSON holds it."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return certificate.number(value) if isinstance(value, float) else value
