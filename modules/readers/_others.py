"""Volumes and meshes of other programs, by VTK's readers: NIfTI, MetaImage, DICOM, EnSight, CGNS, PLOT3D, collections."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from modules.data.accuracy import Flag
from modules.data.companions import is_companion
from modules.data.exchange import ExchangeError, from_pyvista
from modules.data.wires import Samples
from modules.readers import _numbers
from modules.readers._files import ReadError, digest, nearest, short

SUFFIXES = (".nii", ".gz", ".mha", ".mhd", ".dcm", ".case", ".cgns", ".p3d", ".vtm", ".pvd", ".pvti", ".pvtr", ".pvts", ".pvtu")

Blocks = dict[str, Any]


def samples(path: Path, name: str) -> Samples:
    """The samples in a file; of several blocks, of the one that holds the array.

    Parameters
    ----------
    name : "array", or "block/array"; "" for the first

    Raises
    ------
    ReadError : damaged, no such array, arrays on cells alone
    """
    reader, blocks = _read(path)
    there = _names(blocks)
    if not there:
        cells = {a for b in blocks.values() for a in b.cell_data}
        instead = f"; on cells lie {', '.join(sorted(cells))}: bring one to points" if cells else ""
        raise ReadError(f"no array of numbers lies on the points of {path.name!r}{instead}")
    if name and name not in there:
        raise ReadError(f"{path.name!r} has no array {name!r}{nearest(name, tuple(there))}; on points lie {', '.join(there)}")
    block, array = there[name or next(iter(there))]
    try:
        wire = from_pyvista(blocks[block], array, _identity(path))
    except ExchangeError as error:
        raise ReadError(f"{path.name!r}: {error}") from error
    if not isinstance(wire, Samples):
        raise ReadError(f"{path.name!r} holds shapes, not samples: read it with 'Read geometry'")
    if path.suffix.lower() == ".dcm":
        words = "a series is turned by half a turn about x, so that rows run upwards, and its origin is 0"
        return replace(wire, accuracy=wire.accuracy.flag(Flag("assumed", words)))
    return _medical(reader, wire) if path.name.lower().endswith((".nii", ".nii.gz")) else wire


def peek(path: Path) -> dict[str, Any]:
    """Names of the arrays, and the shape of the first; these files have to be read for it."""
    _, blocks = _read(path)
    there = _names(blocks)
    if not there:
        raise ReadError(f"no array of numbers lies on the points of {path.name!r}")
    first = blocks[next(iter(there.values()))[0]]
    size = getattr(first, "dimensions", None)
    return {"names": tuple(there), "shape": tuple(reversed(size)) if size else (first.n_points,)}


def companions(path: Path) -> list[Path]:
    """The files that a header or a collection names: all that lie in its folder and are read with it."""
    suffix = path.suffix.lower()
    if suffix == ".dcm":
        return sorted(p for p in path.parent.glob("*.dcm") if p != path)
    if suffix == ".mhd":
        return [p for ending in (".raw", ".zraw") if (p := path.with_suffix(ending)).is_file()]
    if suffix in (".case", ".p3d"):
        return sorted(p for p in path.parent.iterdir() if p.is_file() and p != path and p.stem.startswith(path.stem))
    if suffix in (".vtm", ".pvd", ".pvti", ".pvtr", ".pvts", ".pvtu"):
        return sorted(p for p in (path.parent / path.stem).rglob("*") if p.is_file())
    return []


def _identity(path: Path) -> str:
    from hashlib import sha256

    beside = companions(path)
    if not beside:
        return digest(path)
    return sha256(" ".join(digest(p) for p in (path, *beside)).encode()).hexdigest()


def _read(path: Path) -> tuple[Any, Blocks]:
    """The reader, and each data set with points by the name of its block."""
    import pyvista as pv

    if path.suffix.lower() in (".mha", ".mhd"):
        _whole(path)
    try:
        with pv.vtk_verbosity("off"):
            if path.suffix.lower() == ".dcm":
                reader = pv.DICOMReader(path.parent)
            else:
                reader = pv.get_reader(path)
            read = reader.read()
    except Exception as error:  # VTK's readers raise what they like
        raise ReadError(f"{path.name!r} cannot be read ({short(error)}): copy or download it again") from error
    blocks = dict(_leaves(read))
    if not any(b.n_points for b in blocks.values()):
        raise ReadError(f"{path.name!r} is damaged or is not what its name says (no point is in it): copy or download it again")
    return reader, blocks


def _whole(path: Path) -> None:
    """Whether a MetaImage has all its numbers: VTK's reader fills up what is missing without a word."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    head, mark, _ = start.partition(b"ElementDataFile")
    fields = {k.strip(): v.strip() for k, _, v in (line.partition("=") for line in head.decode("latin-1").splitlines())}
    kind = _numbers.META.get(fields.get("ElementType", ""))
    if not mark or kind is None or not fields.get("DimSize", "").replace(" ", "").isdecimal():
        raise ReadError(f"{path.name!r} is no MetaImage, or its header is cut off: copy or download it again")
    named = start[len(head) :].splitlines()[0].partition(b"=")[2].strip().decode("latin-1")
    if fields.get("CompressedData", "False").lower() == "true" or named == "LIST" or "%" in named:
        return
    place = path if named.upper() == "LOCAL" else path.parent / named
    if not place.is_file():
        raise ReadError(f"{path.name!r} names the numbers {named!r}, which are not there: copy them beside it")
    channels = int(fields.get("ElementNumberOfChannels", "1"))
    shape = (*reversed([int(n) for n in fields["DimSize"].split()]), *((channels,) if channels > 1 else ()))
    local = len(head) + len(start[len(head) :].splitlines(keepends=True)[0]) if place == path else 0
    size = place.stat().st_size
    if size < _numbers.wanted(shape, np.dtype(kind), local):
        raise ReadError(_numbers.words(place.name, size, shape, np.dtype(kind), local))


def _leaves(data: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    if data is None:
        return
    if hasattr(data, "keys") and not hasattr(data, "point_data"):
        for i, name in enumerate(data.keys()):
            yield from _leaves(data[i], f"{prefix}{name}/")
    elif data.n_points:
        yield prefix.rstrip("/"), data


def _names(blocks: Blocks) -> dict[str, tuple[str, str]]:
    """What the user reads -> (block, array); the block is left out where there is one alone."""
    found = {}
    for block, data in blocks.items():
        names = list(data.point_data.keys())
        for name in names:
            if np.asarray(data.point_data[name]).dtype.kind in "fiub" and not is_companion(name, names):
                found[f"{block}/{name}" if len(blocks) > 1 else name] = (block, name)
    return found


def _medical(reader: Any, wire: Samples) -> Samples:
    """NIfTI: numbers are scaled, and a matrix says where the volume lies; a turned one is left as it is and flagged."""
    from modules.readers._vtk import changed

    vtk = reader.reader
    slope, offset = float(vtk.GetRescaleSlope()), float(vtk.GetRescaleIntercept())
    wire = changed(wire, scale=slope or 1.0, offset=offset if slope else 0.0, lengths="mm")
    matrix = vtk.GetSFormMatrix() or vtk.GetQFormMatrix()
    if matrix is None:
        return wire
    placed = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    turned = placed[:3, :3]
    if np.allclose(turned, np.diag(np.diag(turned)), atol=1e-6 * np.abs(turned).max()) and (np.diag(turned) > 0).all():
        n = wire.grid.dimensions
        grid = replace(wire.grid, origin=tuple(float(v) for v in placed[:n, 3]))  # type: ignore[call-arg]  # a regular grid
        return replace(wire, grid=grid)
    words = "the file turns the volume in space; here its axes are those of the array, x y z"
    return replace(wire, accuracy=wire.accuracy.flag(Flag("assumed", words)))
