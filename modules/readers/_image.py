"""Grey pictures as maps: png, tif, jpg, with a world file or GeoTIFF tags that say where they lie."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Missing
from modules.data.companions import largest, rounding
from modules.readers._files import ReadError, fits, reading
from modules.readers._raw import Raw

WORLD = {".png": ".pgw", ".tif": ".tfw", ".tiff": ".tfw", ".jpg": ".jgw", ".jpeg": ".jgw"}
PIXEL_SCALE, TIE_POINT, GEO_KEYS, GDAL_NODATA = 33550, 33922, 34735, 42113
UNITS = {9001: "m", 9002: "ft", 9003: "US survey ft"}


def load(path: Path, name: str, stride: int) -> Raw:
    """The brightness of a grey picture.

    Raises
    ------
    ReadError : a colour picture, damaged, too large, or a world file that turns it
    """
    from PIL import Image

    with reading(path), Image.open(path) as picture:
        columns, rows = picture.size
        fits(path, (rows, columns), stride)
        tags = dict(getattr(picture, "tag_v2", {}))
        pages = getattr(picture, "n_frames", 1)
        mode = picture.mode
        plain = mode in ("1", "L", "I", "F") or mode.startswith("I;16")
        pixels = np.asarray(picture if plain else picture.convert("RGBA"))[::stride, ::stride]
    holes: NDArray[np.bool_] | None = None
    if not plain:
        pixels, holes = _grey(path, pixels)
    half, words = rounding(pixels.dtype, largest(pixels))
    geo = _geotiff(path, tags, rows, columns)
    world = _world(path)
    if world is not None:
        geo = {**geo, "x": world[0] + world[1] * np.arange(columns), "y": world[2] + world[3] * np.arange(rows)}
    no_data = geo.pop("no_data", None)
    if no_data is not None:
        holes = (pixels == no_data) if holes is None else holes | (pixels == no_data)
    assumed = (f"page 1 of {pages} is the map",) if pages > 1 else ()
    lossy = path.suffix.lower() in (".jpg", ".jpeg")
    missing = (Missing("Compression error", "jpg changes the numbers and does not state by how much"),) if lossy else ()
    return Raw(
        values=pixels, full=(rows, columns), half=np.asarray(half), stored=words, name="grey", north_first=True, holes=holes,
        assumed=assumed, missing=missing, **geo,
    )  # fmt: skip


def peek(path: Path) -> dict[str, Any]:
    """Shape, from the header alone."""
    from PIL import Image

    with reading(path), Image.open(path) as picture:
        return {"names": ("grey",), "shape": picture.size[::-1], "mode": picture.mode}


def companions(path: Path) -> list[Path]:
    """World files that lie beside a picture."""
    endings = (WORLD.get(path.suffix.lower(), ""), path.suffix + "w", ".wld")
    names = [path.with_suffix(e) for e in endings if e]
    return [p for p in dict.fromkeys(names + [p.with_suffix(p.suffix.upper()) for p in names]) if p.is_file()]


def _grey(path: Path, pixels: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.bool_] | None]:
    red, green, blue, alpha = np.moveaxis(pixels, -1, 0)
    if not ((red == green) & (green == blue) | (alpha == 0)).all():
        raise ReadError(f"{path.name!r} is a colour picture, and colours are no heights: save the heights as a grey picture")
    return red, (alpha == 0) if (alpha == 0).any() else None


def _world(path: Path) -> tuple[float, float, float, float] | None:
    """(x of the first column, step, y of the first row, step) of a world file."""
    found = companions(path)
    if not found:
        return None
    try:
        a, d, b, e, c, f = (float(word) for word in found[0].read_text(encoding="latin-1").replace(",", ".").split()[:6])
    except ValueError:
        raise ReadError(f"{found[0].name!r} should hold six numbers, one a line: correct it, or move it away") from None
    if d or b:
        raise ReadError(f"{found[0].name!r} turns the picture: turn the picture with a GIS so that its rows run east")
    if not a or not e or not np.isfinite([a, e, c, f]).all():
        raise ReadError(f"{found[0].name!r} states a pixel of no size: correct it, or move it away")
    return c, a, f, e


def _geotiff(path: Path, tags: dict[int, Any], rows: int, columns: int) -> dict[str, Any]:
    """Axes, units and the number for no data, from GeoTIFF tags, if there are any."""
    found: dict[str, Any] = {}
    if GDAL_NODATA in tags:
        try:
            found["no_data"] = float(str(tags[GDAL_NODATA]).strip("\x00 "))
        except ValueError:
            raise ReadError(f"{path.name!r} states {tags[GDAL_NODATA]!r} for no data: set 'no_data' in a copy") from None
    if PIXEL_SCALE not in tags or TIE_POINT not in tags:
        return found
    keys = list(tags.get(GEO_KEYS, ()))
    geo = {keys[i]: keys[i + 3] for i in range(4, len(keys) - 3, 4) if keys[i + 1] == 0}
    (hx, hy, *_), (i, j, _, x, y, *_) = tags[PIXEL_SCALE], tags[TIE_POINT]
    shift = 0.0 if geo.get(1025) == 2 else 0.5
    found["x"] = x + hx * (np.arange(columns) + shift - i)
    found["y"] = y - hy * (np.arange(rows) + shift - j)
    found["lengths"] = "degree" if geo.get(1024) == 2 else UNITS.get(geo.get(3076, 0), "")
    found["unit"] = UNITS.get(geo.get(4099, 0), "")
    if 3072 in geo:
        found["crs"] = f"EPSG:{geo[3072]}"
    return found
