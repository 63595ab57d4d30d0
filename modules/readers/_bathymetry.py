"""Soundings of the sea floor with their uncertainty: BAG and S-102, which are HDF5 of a fixed layout.

Both are handed on as variables with the attributes that climate files use, so that one set of rules reads them all.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from modules.readers._files import ReadError
from modules.readers._store import Store, Variable, text

NOTHING = 1e6
"""What both formats store where nothing was sounded."""

TAKEN = "stated sizes of uncertainty are one standard deviation (set 'multiple' if the survey says otherwise)"


def of(path: Path, file: Any) -> Store | None:
    """The store of a BAG or S-102 file; None for any other."""
    if "BAG_root/elevation" in file:
        return _bag(path, file["BAG_root"])
    if "BathymetryCoverage" in file:
        return _s102(path, file)
    return None


# --- BAG ---------------------------------------------------------------------------------------------------------


def _bag(path: Path, root: Any) -> Store:
    elevation = root["elevation"]
    rows, columns = elevation.shape
    (west, south, east, north), crs, kind = _described(path, root)
    x = np.linspace(west, east, columns)
    y = np.linspace(south, north, rows)
    variables = _both(elevation, root.get("uncertainty"), "elevation", "height_above_reference_ellipsoid")
    variables |= _axes(x, y, crs)
    notes: tuple[str, ...] = (TAKEN + (f"; the file calls them {kind}" if kind else ""),) if "uncertainty" in root else ()
    if "varres_refinements" in root:
        notes += ("the coarse grid is enough: the file also holds finer ones, which are not read",)
    return Store(path, variables, {"crs": crs}, notes)


def _described(path: Path, root: Any) -> tuple[tuple[float, float, float, float], str, str]:
    """Corners (west, south, east, north) of the outer samples, reference system, and kind of uncertainty, from the XML."""
    if "metadata" not in root:
        raise ReadError(f"{path.name!r} has no metadata, so its place is not known: ask for the file anew")
    stored = np.asarray(root["metadata"][()])
    words = b"".join(stored.ravel().tolist()) if stored.dtype.kind in "SO" else stored.tobytes()
    try:
        tree = ElementTree.fromstring(words.rstrip(b"\0").decode("utf-8", "replace"))
    except ElementTree.ParseError as error:
        raise ReadError(f"the metadata of {path.name!r} is no XML ({error}): ask for the file anew") from None
    corners = next((e.text or "" for e in tree.iter() if _tag(e) == "coordinates"), "")
    numbers = [float(v) for v in re.findall(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?", corners)]
    if len(numbers) < 4:
        raise ReadError(f"the metadata of {path.name!r} names no corners, so its place is not known: ask for the file anew")
    crs = next((t for e in tree.iter() if (t := (e.text or "").strip()).startswith(("PROJCS", "GEOGCS", "COMPD_CS"))), "")
    kind = next((e.get("codeListValue") or e.text or "" for e in tree.iter() if _tag(e) == "BAG_VertUncertCode"), "")
    return (numbers[0], numbers[1], numbers[2], numbers[3]), crs, kind.strip()


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rsplit("}", 1)[-1]


# --- S-102 -------------------------------------------------------------------------------------------------------


def _s102(path: Path, file: Any) -> Store:
    coverages = file["BathymetryCoverage"]
    first = next((c for name, c in coverages.items() if name.startswith("BathymetryCoverage.")), None)
    group = next((g for name, g in (first or {}).items() if name.startswith("Group_")), None)
    values = group["values"] if group is not None and "values" in group else None
    if first is None or values is None or "depth" not in (values.dtype.names or ()):
        raise ReadError(f"{path.name!r} holds no coverage of depths: ask for the file anew")
    place = first.attrs
    rows, columns = values.shape
    x = float(place["gridOriginLongitude"]) + float(place["gridSpacingLongitudinal"]) * np.arange(columns)
    y = float(place["gridOriginLatitude"]) + float(place["gridSpacingLatitudinal"]) * np.arange(rows)
    code = text(file.attrs.get("horizontalCRS", file.attrs.get("horizontalDatumValue")))
    crs = f"EPSG:{code}" if code else ""
    variables = _both(_Member(values, "depth"), _Member(values, "uncertainty"), "depth", "depth")
    variables |= _axes(x, y, crs)
    count = sum(name.startswith("BathymetryCoverage.") for name in coverages)
    several = (f"of {count} coverages the first is meant",) if count > 1 else ()
    return Store(path, variables, {"crs": crs}, (TAKEN, *several))


class _Member:
    """One member of an array of records, with the little of an array that is asked for."""

    def __init__(self, values: Any, name: str) -> None:
        self.shape, self.dtype, self.attrs = values.shape, values.dtype[name], values.attrs
        self._values, self._name = values, name

    def __getitem__(self, cut: Any) -> NDArray[Any]:
        return np.asarray(self._values[cut][self._name])


# --- both --------------------------------------------------------------------------------------------------------


def _both(values: Any, uncertainty: Any, name: str, standard: str) -> dict[str, Variable]:
    common = {"units": "m", "_FillValue": NOTHING}
    attributes = {**common, "standard_name": standard, "ancillary_variables": "uncertainty"}
    dims = ("y", "x")
    found = {name: Variable(name, dims, values.shape, values.dtype, attributes, _reader(values))}
    if uncertainty is not None and uncertainty.shape == values.shape:
        said = {**common, "standard_name": f"{standard} standard_error"}
        found["uncertainty"] = Variable("uncertainty", dims, values.shape, uncertainty.dtype, said, _reader(uncertainty))
    return found


def _reader(values: Any) -> Any:
    return lambda cut: np.asarray(values[cut])


def _axes(x: NDArray[Any], y: NDArray[Any], crs: str) -> dict[str, Variable]:
    degrees = crs.startswith("GEOGCS") or crs in ("EPSG:4326", "EPSG:4269")
    units = ("degrees_east", "degrees_north") if degrees else ("m", "m")
    axes = {"x": (x, "X", units[0]), "y": (y, "Y", units[1])}
    return {
        name: Variable(name, (name,), axis.shape, axis.dtype, {"axis": role, "units": unit}, _reader(axis))
        for name, (axis, role, unit) in axes.items()
    }
