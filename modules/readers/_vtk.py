"""Volumes and meshes as samples: VTK's own files with what was stored of their accuracy, and those of other programs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from modules.data.accuracy import Accuracy
from modules.data.exchange import READ, ExchangeError, load
from modules.data.grid import Grid, Rectilinear, Regular
from modules.data.operators import Gather, Operator, select
from modules.data.wires import Samples
from modules.readers import _lat, _nrrd, _others
from modules.readers._files import ReadError, existing, fits, memory, nearest, short, unreadable

OWN = tuple(s for s in READ if s != ".vtp")
NRRD = (".nrrd", ".nhdr")
SUFFIXES = (*OWN, *NRRD, *_lat.SUFFIXES, *_others.SUFFIXES)


def samples(path: Path, name: str) -> Samples:
    """The samples in a VTK file.

    Raises
    ------
    ReadError : damaged, no such array, or shapes without samples
    """
    if path.stat().st_size > memory() / 2:
        size = f"{path.stat().st_size / 2**30:.3g} GiB, more than half of the memory here"
        raise ReadError(f"{path.name!r} has {size}: cut a part out of it with another program")
    if path.suffix.lower() in NRRD:
        return _nrrd.samples(path, name)
    if path.suffix.lower() in _lat.SUFFIXES:
        return _lat.samples(path, name)
    if path.suffix.lower() not in OWN:
        return _others.samples(path, name)
    known = peek(path)
    if "shape" in known:
        fits(path, known["shape"])
    names = known["names"]
    if name and names and name not in names:
        raise ReadError(f"{path.name!r} has no array {name!r}{nearest(name, names)}; on points lie {', '.join(names)}")
    try:
        wire = load(path, name or None)
    except ExchangeError as error:
        raise ReadError(str(error)) from error
    if not isinstance(wire, Samples):
        raise ReadError(f"{path.name!r} holds shapes, not samples: read it with 'Read geometry'")
    return wire


def peek(path: Path) -> dict[str, Any]:
    """Names and shape from the header of an XML file; nothing of an old one, which has no header to look at alone."""
    if path.suffix.lower() in NRRD:
        return _nrrd.peek(path)
    if path.suffix.lower() in _lat.SUFFIXES:
        return _lat.peek(path)
    if path.suffix.lower() not in OWN:
        return _others.peek(path)
    if path.suffix.lower() == ".vtk":
        return {"names": ()}
    import pyvista as pv

    from modules.data.companions import is_companion

    try:
        reader = pv.get_reader(path)
        names = list(reader.point_array_names) if hasattr(reader, "point_array_names") else []
        facts: dict[str, Any] = {"names": tuple(n for n in names if not is_companion(n, names))}
        if path.suffix.lower() in (".vti", ".vtr", ".vts"):
            extent = reader.reader.GetOutputInformation(0).Get(_whole_extent())
            if extent:
                size = [extent[i + 1] - extent[i] + 1 for i in (4, 2, 0)]
                facts["shape"] = tuple(size[next((i for i, n in enumerate(size) if n > 1), 2) :])
        return facts
    except Exception as error:  # VTK's readers raise what they like
        raise ReadError(f"{path.name!r} cannot be read ({short(error)}): copy or download it again") from error


def beside(path: Path) -> list[Path]:
    """Files that are read with it."""
    return _nrrd.companions(path) if path.suffix.lower() in NRRD else _others.companions(path)


def _whole_extent() -> Any:
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    return vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT()


def file_of(path: Path | None) -> Path:
    """The path, if it is a VTK file of samples."""
    found = existing(path)
    if found.suffix.lower() not in SUFFIXES:
        raise unreadable(found, SUFFIXES)
    return found


def changed(
    wire: Samples, *, scale: float = 1.0, offset: float = 0.0, stride: int = 1, unit: str = "", lengths: str = "",
    no_data: float | None = None,
) -> Samples:  # fmt: skip
    """The samples thinned, scaled and named otherwise, and their budget with them."""
    grid, values = wire.grid, wire.values
    plain = scale == 1 and offset == 0 and no_data is None
    if not plain:
        values = values.astype(float)
        values = np.where(values == no_data, np.nan, values) * scale + offset
    operator: Operator | None = None
    rows = values.size
    if stride > 1:
        cut = tuple(slice(None, None, stride) for _ in grid.shape)
        kept = np.arange(rows).reshape(values.shape)[cut]
        grid, values = thinned(grid, stride), values[cut]
        operator = select(kept.ravel(), rows)
    if scale != 1:
        n = values.size
        scaled = Gather(np.arange(n)[:, None], np.asarray(scale), n)
        operator = scaled if operator is None else scaled.after(operator)
    accuracy = wire.accuracy if operator is None else _pushed(wire.accuracy, operator)
    if unit:
        accuracy = replace(accuracy, terms=tuple(replace(t, unit=unit) if not t.unit else t for t in accuracy.terms))
    if lengths:
        grid = replace(grid, frame=replace(grid.frame, units=(lengths,) * 3))
    return replace(wire, grid=grid, values=values, accuracy=accuracy, unit=unit or wire.unit)


def _pushed(accuracy: Accuracy, operator: Operator) -> Accuracy:
    points = replace(accuracy, terms=accuracy.select(place="point"))
    pushed = replace(points.push(operator), flags=tuple(f for f in accuracy.flags if f.items is None))
    return pushed.end_from(accuracy, "it speaks of cells, and the samples were thinned")


def thinned(grid: Grid, stride: int) -> Grid:
    """Every n-th sample along each axis."""
    if isinstance(grid, Regular):
        size = tuple(-(-n // stride) for n in grid.size)
        return replace(grid, size=size, spacing=tuple(h * stride for h in grid.spacing))
    if isinstance(grid, Rectilinear):
        return replace(grid, axes=tuple(a[::stride] for a in grid.axes))
    raise ReadError(f"a {grid.kind} grid is not thinned: leave stride at 1")


