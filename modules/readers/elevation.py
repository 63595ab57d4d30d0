"""Elevation maps and other fields of two axes, from the files that people have."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Choice,
    Flag,
    Gather,
    Identity,
    Literal,
    Missing,
    Operator,
    Range,
    Rectilinear,
    Regular,
    Samples,
    Source,
    Spread,
    Term,
    reader,
)  # fmt: skip
from modules.data.accuracy import Rigour
from modules.data.operators import Floats, Ints
from modules.readers import _dem, _image, _npz, _text, _vtk
from modules.readers._files import ReadError, digest, existing, problem, unreadable
from modules.readers._place import DEGREES, place
from modules.readers._raw import Raw, Stated

Loader = Callable[[Path, str, int], Raw]
Peeker = Callable[[Path], dict[str, Any]]

FORMATS: Mapping[str, tuple[Loader, Peeker]] = {
    ".npz": (_npz.load, _npz.peek),
    ".npy": (_npz.load, _npz.peek),
    ".dem": (_dem.load, _dem.peek),
    ".png": (_image.load, _image.peek),
    ".tif": (_image.load, _image.peek),
    ".tiff": (_image.load, _image.peek),
    ".jpg": (_image.load, _image.peek),
    ".jpeg": (_image.load, _image.peek),
    ".csv": (_text.load, _text.peek),
    ".tsv": (_text.load, _text.peek),
    ".txt": (_text.load, _text.peek),
    ".xyz": (_text.load, _text.peek),
    ".asc": (_text.load, _text.peek),
}
VTK = (".vti", ".vtr", ".vtk")
"""Suffix -> how it is read, how it is looked at."""


def peek(path: Path) -> Mapping[str, Any]:
    """Names, shape and, where it is cheap, range of what is in the file."""
    try:
        found = existing(path)
        return _vtk.peek(found) if found.suffix.lower() in VTK else _format(found)[1](found)
    except ReadError as error:
        return problem(error)


def companions(path: Path) -> Sequence[Path]:
    """Files that are read with it: the world file of a picture."""
    return _image.companions(path) if path.suffix.lower() in _image.WORLD else ()


@reader("Read elevation", output="samples", peek=peek, companions=companions)
def elevation(
    *,
    path: Path | None = None,
    name: Annotated[str | None, Choice(of="path.names")] = None,
    spacing: tuple[float, float] | None = None,
    lengths: str | None = None,
    unit: str | None = None,
    scale: float = 1.0,
    offset: float = 0.0,
    rows: Literal["automatic", "north first", "south first"] = "automatic",
    no_data: float | None = None,
    stride: Annotated[int, Range(1, 32)] = 1,
) -> Samples:
    """A map of heights, or of any quantity over two axes, from a file.

    Reads .npz, .npy, USGS .dem, grey .png, .tif, .jpg with their world files, .csv, .txt, .asc, .vti and .vtr.
    Longitude and latitude are brought to metres on a plane that is true to scale at the middle latitude.

    Parameters
    ----------
    path : the file
    name : which array of the file; automatic takes the one that looks like a map
    spacing : distance of samples along x and y, in `lengths`; automatic takes what the file states, else 1
    lengths : unit of the coordinates, m, ft, degree; automatic takes what the file states
    unit : unit of the heights; automatic takes what the file states
    scale, offset : a height is scale * stored number + offset
    rows : whether the first row is the north or the south edge; automatic takes what the file states
    no_data : the number that stands for "no value here"; automatic takes what the file states
    stride : keep every n-th row and column

    Accuracy: adds the rounding of the stored numbers as a proven bound, and what the file states of its errors; an
    error of measurement that it does not state is listed as missing.
    """
    found = existing(path)
    if stride < 1:
        raise ReadError(f"stride = {stride} keeps nothing: use 1 for all samples, 2 for every second")
    if not (np.isfinite(scale) and scale and np.isfinite(offset)):
        raise ReadError(f"scale {scale} and offset {offset} for {found.name!r} must be finite, and the scale not 0")
    if found.suffix.lower() in VTK:
        placed = spacing is None and rows == "automatic"
        return _from_vtk(found, name or "", placed, stride, (scale, offset), unit, lengths, no_data)
    raw = _format(found)[0](found, name or "", stride)
    raw = replace(raw, unit=_unit(found, "unit", unit, raw.unit), lengths=_unit(found, "lengths", lengths, raw.lengths))
    return _samples(found, raw, spacing, (scale, offset), rows, no_data, stride)


def _samples(
    found: Path, raw: Raw, spacing: tuple[float, float] | None, linear: tuple[float, float], rows: str, no_data: float | None,
    stride: int,
) -> Samples:  # fmt: skip
    scale, offset = linear
    values = _values(found, raw, no_data) * scale + offset
    north = {"automatic": None, "north first": True, "south first": False}[rows]
    placed = place(raw, _spacing(found, spacing), "", north, stride)
    natural = placed if north is None else place(raw, spacing, "", None, stride)
    values = _turned(values, placed.flips)
    sampling = Sampling(raw.full, natural.flips, placed.flips, stride, scale)
    accuracy = _accuracy(raw, sampling, f"{digest(found)}/{raw.name}")
    accuracy = accuracy.flag(*placed.flags, *_flags(raw, values, spacing is not None, north is not None))
    return Samples(grid=placed.grid, values=values, unit=raw.unit, name=raw.name, accuracy=accuracy)


def _from_vtk(
    path: Path, name: str, placed: bool, stride: int, linear: tuple[float, float], unit: str | None, lengths: str | None,
    no_data: float | None,
) -> Samples:  # fmt: skip
    """A map from a VTK file, which states where its samples lie, and may bring its budget."""
    wire = _vtk.samples(path, name)
    if wire.grid.dimensions != 2 or wire.components != 1 or not isinstance(wire.grid, Regular | Rectilinear):
        kind = f"{wire.grid.dimensions} axes, {wire.grid.kind}, {wire.components} numbers a sample"
        raise ReadError(f"{path.name!r} is no map of heights ({kind}): read it with 'Read data set'")
    if not placed:
        raise ReadError(f"{path.name!r} states where its samples lie: leave 'spacing' and 'rows' automatic")
    return _vtk.changed(
        wire, scale=linear[0], offset=linear[1], stride=stride, no_data=no_data,
        unit=_unit(path, "unit", unit, wire.unit), lengths=_unit(path, "lengths", lengths, wire.grid.frame.units[0]),
    )  # fmt: skip


def _format(path: Path) -> tuple[Loader, Peeker]:
    known = FORMATS.get(path.suffix.lower())
    if known is None:
        raise unreadable(path, (*FORMATS, *VTK))
    return known


def _unit(path: Path, what: str, given: str | None, stated: str) -> str:
    if given is None or not given:
        return stated
    if stated and stated != "degree?" and given != stated and not (given in DEGREES and stated in DEGREES):
        raise ReadError(f"{path.name!r} states {what} in {stated!r}: leave {what!r} automatic, not {given!r}")
    return given


def _spacing(path: Path, given: tuple[float, float] | None) -> tuple[float, float] | None:
    if given is not None and not all(np.isfinite(h) and h > 0 for h in given):
        raise ReadError(f"spacing {given} for {path.name!r} must be positive: use 'rows' to turn a map round")
    return given


def _values(path: Path, raw: Raw, no_data: float | None) -> NDArray[np.float64]:
    """Heights as float64, NaN where there is no value."""
    holes = np.zeros(raw.values.shape, bool) if raw.holes is None else raw.holes.copy()
    if no_data is not None:
        holes |= raw.values == no_data
    with np.errstate(over="ignore"):
        values = raw.values.astype(np.float64)
    if np.isinf(values).any():
        raise ReadError(f"{path.name!r} holds infinite numbers: name the number that stands for no value with 'no_data'")
    values = values * raw.scale + raw.offset
    values[holes] = np.nan
    if np.isnan(values).all():
        raise ReadError(f"{path.name!r} holds no value at all, only holes: look at 'no_data', or choose another file")
    return values


def _turned(values: NDArray[np.float64], flips: tuple[bool, bool]) -> NDArray[np.float64]:
    turned = values[:: -1 if flips[0] else 1, :: -1 if flips[1] else 1]
    return np.ascontiguousarray(turned)


@dataclass(frozen=True)
class Sampling:
    """Which of the file's samples each sample is.

    Parameters
    ----------
    full : (ny, nx) of the file's array
    natural : whether its rows and columns run against ascending axes, as far as the file says
    flips : whether they were turned round for the grid
    stride, scale : as the user set them
    """

    full: tuple[int, int]
    natural: tuple[bool, bool]
    flips: tuple[bool, bool]
    stride: int
    scale: float

    @property
    def plain(self) -> bool:
        """Whether each sample is the file's sample at its place, as it is."""
        return self.stride == 1 and self.natural == self.flips and self.scale == 1

    def primitives(self, array: Floats) -> Floats:
        """(ny, nx, ...) numbers in the order of the file, in the order of the primitives: along ascending axes."""
        return array[:: -1 if self.natural[0] else 1, :: -1 if self.natural[1] else 1]

    def index(self) -> Ints:
        """(n,) the primitive of each sample."""
        rows, columns = (self._along(axis) for axis in (0, 1))
        index = np.asarray(rows[:, None] * self.full[1] + columns).ravel()
        return index.astype(np.int32) if self.full[0] * self.full[1] < 2**31 else index

    def _along(self, axis: int) -> NDArray[np.int64]:
        n = self.full[axis]
        kept = np.arange(0, n, self.stride)[:: -1 if self.flips[axis] else 1]
        return n - 1 - kept if self.natural[axis] else kept


def _accuracy(raw: Raw, sampling: Sampling, name: str) -> Accuracy:
    """Rounding, what the file states, and what it does not; ids are `<content>/<variable>/<what>`."""
    rule = f"{raw.stored} (rounding of stored numbers/1)"
    rounding = Stated(name="Quantisation", what="quantisation", kind="bound", value=raw.half, rule=rule)
    terms = [_term(rounding, raw, sampling, name, "proven")]
    terms += [_term(one, raw, sampling, name, "estimated") for one in raw.stated]
    missing = () if raw.stated else (Missing("Measurement error", "the file states none"),)
    return Accuracy(tuple(terms), (*missing, *raw.missing))


def _term(one: Stated, raw: Raw, sampling: Sampling, name: str, rigour: Rigour) -> Term:
    value = np.asarray(one.value, float)
    operator: Operator
    if one.common:
        operator = _common(one, raw, sampling)
    else:
        count = raw.full[0] * raw.full[1]
        value = sampling.primitives(value).ravel() if value.ndim else value
        operator = Identity(count)
        if not sampling.plain:
            operator = Gather(sampling.index()[:, None], np.asarray(sampling.scale), count)
    source = Source(one.name, "data", rigour, one.rule)
    return Term(source, one.kind, "value", raw.unit, value, operator, id=f"{name}/{one.what}")


def _common(one: Stated, raw: Raw, sampling: Sampling) -> Operator:
    """How k errors of the whole file reach each sample."""
    n = len(sampling.index())
    if one.weights is None:
        return Spread(n) if sampling.scale == 1 else Gather(np.zeros((n, 1), np.int32), np.asarray(sampling.scale), 1)
    k = one.weights.shape[-1]
    weights = sampling.primitives(one.weights).reshape(-1, k)[sampling.index()]
    return Gather(np.broadcast_to(np.arange(k), weights.shape).copy(), weights * sampling.scale, k)


def _flags(raw: Raw, values: NDArray[np.float64], spaced: bool, turned: bool) -> list[Flag]:
    """What was taken for granted, and what is odd about the values."""
    assumed = list(raw.assumed)
    if raw.lengths == "degree?":
        assumed.append("coordinates are longitude and latitude in degrees (set 'lengths' if they are not)")
    if raw.y is None and not turned:
        edge = "north" if raw.north_first else "south"
        assumed.append(f"the first row is the {edge} edge (set 'rows' if it is not)")
    if raw.x is None and not spaced:
        assumed.append("samples lie 1 apart (set 'spacing' if they do not)")
    flags = [Flag("assumed", "the file does not say it, so it was assumed that " + "; that ".join(assumed))] if assumed else []
    finite = values[np.isfinite(values)]
    if finite.size > 1 and finite.min() == finite.max():
        flags.append(Flag("constant", f"all values are {finite[0]:g}: there is nothing to see in this file"))
    elif raw.values.dtype.kind == "f" and (step := _step(raw.values)) > 3 * raw.half.max():
        words = f"the file stores floating numbers, yet all are multiples of {step:g}: they were probably rounded to it before"
        flags.append(Flag("rounded before", words))
    return flags


def _step(values: NDArray[Any]) -> float:
    """1, 0.1 or 0.01 if all values are multiples of it; 0 if they are not."""
    finite = values[np.isfinite(values)].astype(float)
    if np.abs(finite).max(initial=0.0) > 1e9:
        return 0.0
    for step in (1.0, 0.1, 0.01):
        nearest = np.round(finite / step) * step
        if (np.abs(finite - nearest) <= np.abs(finite) * np.finfo(values.dtype).eps).all():
            return step
    return 0.0
