"""A scene as a PNG that carries its network and claims, and the certificate beside it."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
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


@dataclass(frozen=True)
class Sheet:
    """What a picture is drawn on.

    Parameters
    ----------
    size : width and height in pixels
    scale : of text and lines; 1 suits the size
    theme : light or dark; "" for that of the view
    """

    size: tuple[int, int] = (1600, 1000)
    scale: float = 1.0
    theme: str = ""


PAGE = Sheet()


def write(
    scene: Any,
    out: Out,
    outbox: Outbox,
    found: Found,
    keys: Mapping[str, str],
    catalogue: Catalogue,
    check: Check | None = None,
    sheet: Sheet = PAGE,
) -> str:
    """Stage a picture and its certificate; returns the caption."""
    from app import picture
    from app.draw.styles import drawn_as

    view = found.network.nodes[out.node].view
    given = {"camera": view["camera"]} if "camera" in view else {}
    scene = drawn_as(scene, view.get("drawing"))
    if sheet.theme:
        scene = replace(scene, look=replace(scene.look, theme=sheet.theme))
    drawn = picture.render(scene, k=found.network.k, size=sheet.size, scale=sheet.scale, **given)
    text = certificate.stored(found.network, out.path.parent.absolute(), catalogue)
    mine = {name: keys[name] for name in sorted(upstream(found.network, [out.node]))}
    claims = _claims(scene, drawn, out, found, text, catalogue, check) | {"keys": mine, "versions": paths.versions()}
    carried = {
        certificate.NETWORK: text,
        certificate.KEYS: json.dumps(mine, sort_keys=True),
        certificate.ACCURACY: json.dumps(claims, ensure_ascii=False, allow_nan=False),
    }
    png = pngtext.insert(_png(drawn.image), carried)
    height, width = drawn.image.shape[:2]
    stored = {
        "file": out.path.name,
        "sha256": certificate.digest(png),
        "bytes": len(png),
        "size": [width, height],
        "pixels": certificate.digest(drawn.image.tobytes()),
    }
    outbox.put(out.path, png)
    content = {"certificate": certificate.FORMAT, "picture": stored, **claims}
    outbox.put(certificate.beside(out.path), certificate.seal(content))
    return str(drawn.caption)


def _claims(
    scene: Any, drawn: Any, out: Out, found: Found, text: str, catalogue: Catalogue, check: Check | None
) -> dict[str, Any]:
    """What is claimed of a picture, but for keys and versions."""
    network = found.network
    source = {"edits": list(found.edits), **_source(found, out.path.parent.absolute())}
    return {
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
        "network": {"sha256": certificate.digest(text.encode()), **source},
    }


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
