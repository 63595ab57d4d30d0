"""Gridded data as the sciences store them, with the errors that they state."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from modules.api import Choice, Range, Samples, reader
from modules.readers import _cf, _vtk
from modules.readers._budget import Wish
from modules.readers._containers import SUFFIXES, ZARR, is_zarr, opened, there
from modules.readers._fields import samples, with_unit
from modules.readers._files import ReadError, digest, problem, unreadable
from modules.readers._store import Store

VECTORS = (("u", "v", "w"), ("uo", "vo", "wo"), ("ua", "va", "wa"), ("u10", "v10"), ("uas", "vas"), ("vx", "vy", "vz"))
"""Names of variables that are the components of one vector."""


def peek(path: Path) -> Mapping[str, Any]:
    """Names of the variables, shape of the first, and how many times and members there are."""
    try:
        found = _file_of(path)
        with opened(found) as store:
            return _facts(store)
    except ReadError as error:
        return problem(error)


def _facts(store: Store) -> dict[str, Any]:
    fields = _cf.fields(store)
    if not fields:
        raise ReadError(f"{store.path.name!r} holds no array of numbers over two axes: choose another file")
    v = _cf.chosen(store, "")
    axes = _cf.axes(store, v)
    count = {role: next((a.size for a in axes if a.role == role), 1) for role in ("time", "member")}
    vectors = (", ".join(n for n in names if n in fields) for names in VECTORS if {names[0], names[1]} <= fields.keys())
    return {
        "names": (*fields, *vectors),
        "shape": tuple(a.size for a in axes if a.role in _cf.SPACE),
        "axes": tuple(f"{a.name} ({a.size})" for a in axes),
        "steps": (0, max(0, count["time"] - 1)),
        "members": count["member"],
        "errors": tuple(b.variable.name for b in _cf.stated(store, v, None)),
    }


def _file_of(path: Path | None) -> Path:
    found = there(path)
    if found.suffix.lower() not in (*SUFFIXES, *ZARR) and not (found.is_dir() and is_zarr(found)):
        raise unreadable(found, SUFFIXES)
    return found


@reader(
    "Read gridded data", output="samples", peek=peek,
    aliases=("netcdf", "hdf5", "zarr", "bag", "s-102", "climate", "ocean", "nc", "bathymetry", "ensemble"),
)  # fmt: skip
def gridded(
    *,
    path: Path | None = None,
    name: Annotated[str | None, Choice(of="path.names")] = None,
    step: Annotated[int, Range(of="path.steps")] = 0,
    at: str = "",
    unit: str | None = None,
    plane: Literal["automatic", "metres", "degrees"] = "automatic",
    correlation: Literal["independent", "common", "length"] = "independent",
    length: Annotated[float, Range(0)] = 1.0,
    multiple: Annotated[float | None, Range(0)] = None,
    stride: Annotated[int, Range(1, 32)] = 1,
) -> Samples:
    """One variable of a NetCDF, HDF5, Zarr, BAG or S-102 file, on its grid, with the errors that the file states.

    Axes may come in any order and direction; which is which follows the CF conventions. Packed numbers are unpacked,
    fill values and what lies outside the valid range become holes. Members of an ensemble become their mean and its spread.

    Parameters
    ----------
    path : the file, or the folder of a Zarr store
    name : which variable; two or three, "u, v", are components of a vector; automatic takes the first
    step : which time, from 0
    at : where other axes are cut, by index: "depth=0, band=2"
    unit : the values are brought to this unit; automatic takes the file's
    plane : whether longitude and latitude become metres on a local plane; automatic up to 10 degrees of latitude
    correlation : of stated errors whose name does not say whether they are random or systematic
    length : distance at which errors correlate by exp(-1/2), in the unit of the coordinates
    multiple : stated sizes are so many standard deviations; automatic takes what the file says, else 1
    stride : keep every n-th sample along each axis

    Accuracy: adds the rounding of stored numbers, packed or shortened, as a proven bound; CF standard errors, companion
    variables (_std, _sigma, _unc, _lo, _hi ...) and members as they are stated, random and systematic ones apart. What
    is assumed of them is flagged; an error of measurement that is not stated is listed as missing.

    Source: CF conventions 1.11, 3.4, 4, 8.1 and appendix C.
    """
    found = _file_of(path)
    if stride < 1:
        raise ReadError(f"stride = {stride} keeps nothing: use 1 for all samples, 2 for every second")
    if multiple is not None and not (np.isfinite(multiple) and multiple > 0):
        raise ReadError(f"multiple = {multiple} must be positive: 1 if the sizes are standard deviations, 2 or 1.96 for 95 %")
    wish = Wish(
        step=step, at=_cuts(at), correlation=correlation, length=length, multiple=multiple,
        plane={"automatic": None, "metres": True, "degrees": False}[plane],
    )  # fmt: skip
    names = [n.strip() for n in (name or "").split(",") if n.strip()]
    if len(names) > 3:
        raise ReadError(f"name = {name!r} has {len(names)} components: a vector has two or three")
    with opened(found) as store:
        wire = samples(store, names, _identity(found), wish)
    wire = with_unit(wire, unit) if unit else wire
    return _vtk.changed(wire, stride=stride)


def _cuts(at: str) -> tuple[tuple[str, int], ...]:
    found = []
    for part in at.split(","):
        axis, sign, index = part.partition("=")
        if not part.strip():
            continue
        if not sign or not index.strip().isdecimal():
            raise ReadError(f"at = {at!r}: write an axis and the number of a place on it, 'depth=0'; several with commas")
        found.append((axis.strip(), int(index)))
    return tuple(found)


def _identity(path: Path) -> str:
    """Digest of a file, or of all files of a folder with their names."""
    if path.is_file():
        return digest(path)
    from hashlib import sha256

    total = sha256()
    for file in sorted(p for p in path.rglob("*") if p.is_file()):
        total.update(file.relative_to(path).as_posix().encode() + digest(file).encode())
    return total.hexdigest()
