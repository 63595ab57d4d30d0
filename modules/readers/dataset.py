"""Samples on any grid, from VTK files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from modules.api import Choice, Range, Samples, reader
from modules.readers import _vtk
from modules.readers._files import ReadError, existing, problem


def peek(path: Path) -> Mapping[str, Any]:
    """Names of the arrays on points, and the shape of the grid."""
    try:
        return _vtk.peek(_vtk.file_of(existing(path)))
    except ReadError as error:
        return problem(error)


def companions(path: Path) -> Sequence[Path]:
    """Files that are read with it: what a header or a collection names."""
    return _vtk.beside(path)


@reader(
    "Read data set", output="samples", peek=peek, companions=companions,
    aliases=("vtk", "volume", "vti", "vtu", "nrrd", "nifti", "metaimage", "dicom", "plot3d", "ensight", "cgns",
             "lat", "iris explorer"),
)  # fmt: skip
def dataset(
    *,
    path: Path | None = None,
    name: Annotated[str | None, Choice(of="path.names")] = None,
    unit: str | None = None,
    lengths: str | None = None,
    scale: float = 1.0,
    offset: float = 0.0,
    no_data: float | None = None,
    stride: Annotated[int, Range(1, 32)] = 1,
) -> Samples:
    """Scalars, vectors or tensors on a regular, rectilinear, curvilinear or unstructured grid.

    Reads VTK's .vti, .vtr, .vts, .vtu, .vtk and collections of them; NRRD, NIfTI, MetaImage, DICOM series, EnSight, CGNS,
    PLOT3D (by its .p3d) and IRIS Explorer's plain .lat. Of several blocks one is read: "block/array".

    Parameters
    ----------
    path : the file
    name : which array on points; automatic takes the active one, else the first
    unit : unit of the values, if the file states none
    lengths : unit of the coordinates, if the file states none
    scale, offset : a value is scale * stored number + offset
    no_data : the number that stands for "no value here"
    stride : keep every n-th sample along each axis

    Accuracy: a file that this program saved brings its whole budget; of others, X_std, X_lo and X_hi, X_members beside
    an array X are picked up, and the rounding of the stored numbers is added as a proven bound.
    """
    found = _vtk.file_of(path)
    if stride < 1:
        raise ReadError(f"stride = {stride} keeps nothing: use 1 for all samples, 2 for every second")
    wire = _vtk.samples(found, name or "")
    for what, given, stated in (("unit", unit, wire.unit), ("lengths", lengths, wire.grid.frame.units[0])):
        if given and stated and given != stated:
            raise ReadError(f"{found.name!r} states {what} in {stated!r}: leave {what!r} automatic, not {given!r}")
    return _vtk.changed(
        wire, scale=scale, offset=offset, stride=stride, unit=unit or "", lengths=lengths or "", no_data=no_data
    )  # fmt: skip
