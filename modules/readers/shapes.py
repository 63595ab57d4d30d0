"""Points, lines and polygons, from VTK files."""

from __future__ import annotations

from pathlib import Path

from modules.api import Geometry, reader
from modules.data.exchange import ExchangeError, load
from modules.readers._files import ReadError, existing, unreadable


@reader("Read geometry", output="shapes", aliases=("vtp", "polydata"))
def shapes(*, path: Path | None = None) -> Geometry:
    """Points, lines and polygons with their values.

    Reads .vtp, and .vtk files that hold shapes.

    Parameters
    ----------
    path : the file

    Accuracy: a file that this program saved brings its whole budget; of others, nothing is known of where their shapes
    may lie, and it says so.
    """
    found = existing(path)
    if found.suffix.lower() not in (".vtp", ".vtk"):
        raise unreadable(found, (".vtp", ".vtk"))
    try:
        wire = load(found)
    except ExchangeError as error:
        raise ReadError(str(error)) from error
    if not isinstance(wire, Geometry):
        raise ReadError(f"{found.name!r} holds samples, not shapes: read it with 'Read data set'")
    return wire
