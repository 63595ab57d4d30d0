"""The conventions of climate and forecast files (CF): which axis is which, what a stored number means, what states its error.

Source: CF conventions 1.11: 3.4 ancillary data, 4 coordinates, 8.1 packed data; appendix C, standard_error.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.companions import DEVIATIONS, LIMITS, is_companion, largest, rounding
from modules.data.operators import Floats
from modules.data.units import UnitError, factor, known
from modules.readers._files import ReadError, nearest
from modules.readers._store import Cut, Store, Variable

ROLES: Mapping[str, tuple[str, ...]] = {
    role: tuple(names.split())
    for role, names in {
        "x": "x lon longitude easting east rlon nav_lon projection_x_coordinate grid_longitude xc i",
        "y": "y lat latitude northing north rlat nav_lat projection_y_coordinate grid_latitude yc j",
        "z": "z lev level depth height altitude plev pressure pressure_level isobaricinhpa deptht k",
        "time": "t time valid_time time_counter forecast_reference_time step",
        "member": "number member members realization realisation ensemble ens ensemble_member perturbation_number",
    }.items()
}
"""Role of an axis -> names that it goes by."""

SPACE = ("z", "y", "x")

ERROR = re.compile(r"uncert|standard.?(error|dev)|_(std|sigma|stderr|unc|err)\b|\bstd\b|sigma", re.IGNORECASE)
"""What an ancillary variable is called that is an error."""

STATED = (
    (re.compile(r"systematic|\bbias|common|correlated_large|large_scale", re.IGNORECASE), "common"),
    (re.compile(r"uncorrelated|random|precision|noise", re.IGNORECASE), "independent"),
    (re.compile(r"synoptic|locally_correlated|locally correlated", re.IGNORECASE), "length"),
)
"""Words in the name of an uncertainty that say how it hangs together."""

SECONDS = re.compile(r"^\s*(\w+)\s+since\s+(.+)$", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a variable.

    Parameters
    ----------
    role : x, y, z, time, member, or "" where nothing says
    coordinates : (n,) as stored; None where the file gives none
    """

    name: str
    size: int
    role: str
    coordinates: Floats | None = None
    unit: str = ""
    stored: np.dtype[np.generic] | None = None


@dataclass(frozen=True, eq=False)
class Decoded:
    """A part of a variable in its unit.

    Parameters
    ----------
    values : float64, NaN where there is no value
    half : largest rounding of a stored number, in the unit: 0-d or as `values`
    stored : how it was rounded, in words
    """

    values: Floats
    half: Floats
    stored: str


# --- variables and axes ------------------------------------------------------------------------------------------


def fields(store: Store) -> dict[str, Variable]:
    """The variables that hold data over two axes or more (over one, if there are no others), and no errors or coordinates."""
    beside = _named_beside(store)
    names = set(store.variables)
    found = {
        name: v for name, v in store.variables.items()
        if v.dtype.kind in "iuf" and v.dims != (name,) and name not in beside and not is_companion(name, names)
        and not v.text("standard_name").endswith(" standard_error") and sum(n > 1 for n in v.shape) >= 1
    }  # fmt: skip
    wide = {name: v for name, v in found.items() if sum(n > 1 for n in v.shape) >= 2}
    return wide or found


def _named_beside(store: Store) -> set[str]:
    """Names that other variables call their coordinates, bounds, ancillary data or mapping."""
    found: set[str] = set()
    for name, v in store.variables.items():
        for what in ("coordinates", "bounds", "ancillary_variables", "grid_mapping", "cell_measures", "climatology"):
            found |= {r.name for w in v.text(what).split() if (r := beside(store, name, w)) is not None}
    return found


def beside(store: Store, name: str, other: str) -> Variable | None:
    """A variable that another one names: in its own group, or in a group above."""
    parts = name.split("/")[:-1]
    for n in range(len(parts), -1, -1):
        found = store.variables.get("/".join([*parts[:n], other.strip("/")]))
        if found is not None:
            return found
    return None


def chosen(store: Store, name: str) -> Variable:
    """The variable of a name; the first field for "".

    Raises
    ------
    ReadError : with what is there
    """
    there = fields(store)
    if name in store.variables:
        return store.variables[name]
    if not name and there:
        likely = store.attributes.get("default_variable", "")
        return there.get(str(likely)) or max(there.values(), key=lambda v: sum(n > 1 for n in v.shape) in (2, 3, 4))
    held = ", ".join(there) or "no array of numbers over two axes"
    if name:
        raise ReadError(f"{store.path.name!r} has no variable {name!r}{nearest(name, tuple(there))}; it holds {held}")
    raise ReadError(f"{store.path.name!r} holds no array of numbers over two axes: choose another file")


def axes(store: Store, v: Variable) -> tuple[Axis, ...]:
    """What each axis of a variable is. Axes that nothing tells of become z, y, x from the last one backwards."""
    found = [_axis(store, v, i) for i in range(len(v.shape))]
    taken = {a.role for a in found if a.role}
    free = [r for r in reversed(SPACE) if r not in taken]
    for i in reversed(range(len(found))):
        if not found[i].role and found[i].size > 1 and free:
            one = found[i]
            found[i] = Axis(one.name, one.size, free.pop(0), one.coordinates, one.unit, one.stored)
    return tuple(found)


def _axis(store: Store, v: Variable, i: int) -> Axis:
    name, size = v.dims[i], v.shape[i]
    along = beside(store, v.name, name) if name else None
    short = name.rsplit("/", 1)[-1]
    if along is None or along.shape != (size,) or along.dtype.kind not in "iuf":
        return Axis(short or f"axis {i + 1}", size, _role_of_name(short))
    values = decoded(store, along, ()).values
    unit = along.text("units")
    return Axis(short, size, _role(along, short), values, unit, along.dtype)


def _role(v: Variable, short: str) -> str:
    unit, axis, standard = v.text("units").lower(), v.text("axis").lower(), v.text("standard_name").lower()
    if axis in ("x", "y", "z"):
        return axis
    if axis == "t" or SECONDS.match(unit):
        return "time"
    for role, names in ROLES.items():
        if standard in names:
            return role
    if unit.replace("degrees", "degree") in ("degree_east", "degree_e"):
        return "x"
    if unit.replace("degrees", "degree") in ("degree_north", "degree_n"):
        return "y"
    return "z" if v.text("positive") else _role_of_name(short)


def _role_of_name(name: str) -> str:
    return next((role for role, names in ROLES.items() if name.lower() in names), "")


def bent(store: Store, v: Variable, space: Sequence[Axis]) -> tuple[Variable, Variable] | None:
    """(x, y) coordinates of each sample, where the file gives such for a grid whose axes have none."""
    if len(space) != 2 or any(a.coordinates is not None and a.unit for a in space):
        return None
    found: dict[str, Variable] = {}
    for word in v.text("coordinates").split():
        one = beside(store, v.name, word)
        if one is not None and one.shape == tuple(a.size for a in space):
            found[_role(one, word)] = one
    return (found["x"], found["y"]) if {"x", "y"} <= found.keys() else None


# --- numbers -----------------------------------------------------------------------------------------------------


def decoded(store: Store, v: Variable, cut: Cut) -> Decoded:
    """What stored numbers mean: unpacked, NaN where there is none, and how far they may be rounded."""
    raw = np.asarray(v.read(cut if cut else (slice(None),) * len(v.shape)))
    if v.text("_Unsigned").lower() == "true" and raw.dtype.kind == "i":
        raw = raw.view(raw.dtype.str.replace("i", "u"))
    scale, offset = v.number("scale_factor"), v.number("add_offset")
    holes = _holes(v, raw)
    values = raw.astype(np.float64)
    values[holes] = np.nan
    if raw.dtype.kind == "f" and np.isinf(values).any():
        raise ReadError(f"{v.name!r} of {store.path.name!r} holds infinite numbers where there is no fill value")
    half, words = rounding(raw.dtype, largest(values))
    by = abs(1.0 if scale is None else scale)
    if by != 1.0:
        half, words = half * by, f"{words}, times the scale factor {by:g}"
    values = values * (1.0 if scale is None else scale) + (0.0 if offset is None else offset)
    return _rounded_before(v, values, np.asarray(half), words)


def _holes(v: Variable, raw: NDArray[Any]) -> NDArray[np.bool_]:
    """Fill values, missing values, and what lies outside the valid range; as stored, before unpacking."""
    holes = np.isnan(raw) if raw.dtype.kind == "f" else np.zeros(raw.shape, bool)
    for name in ("_FillValue", "missing_value", "FillValue", "no_data"):
        for value in np.asarray(v.attributes.get(name, [])).ravel():
            if np.asarray(value).dtype.kind in "iuf" and not np.isnan(value):
                holes |= raw == _as_stored(value, raw.dtype)
    low, high = v.number("valid_min"), v.number("valid_max")
    limits = np.asarray(v.attributes.get("valid_range", [])).ravel()
    if limits.size == 2 and limits.dtype.kind in "iuf":
        low, high = float(limits[0]), float(limits[1])
    if low is not None:
        holes |= raw < low
    if high is not None:
        holes |= raw > high
    return holes


def _as_stored(value: Any, dtype: np.dtype[Any]) -> Any:
    """A fill value in the type of the data: of unsigned data it may be written with a sign, of float32 with more digits."""
    if dtype.kind == "f":
        with np.errstate(over="ignore"):
            return np.asarray(value).astype(dtype)[()]
    number = float(value)
    return number % 2.0 ** (8 * dtype.itemsize) if dtype.kind == "u" and number < 0 else number


def _rounded_before(v: Variable, values: Floats, half: Floats, words: str) -> Decoded:
    """The rounding of lossy compression, which says in attributes how many digits or bits it kept."""
    sizes = np.abs(np.nan_to_num(values, nan=0.0))
    digits = v.number("least_significant_digit")
    if digits is not None:
        step = 2.0 ** -np.ceil(np.log2(10.0) * digits)
        return Decoded(values, half + step / 2, f"{words}, and half of {step:g}, for {digits:g} decimal places were kept")
    bits = v.number("_QuantizeBitRoundNumberOfSignificantBits")
    if bits is not None:
        limit = sizes * 2.0 ** -(bits + 1)
        return Decoded(values, half + limit, f"{words}, and half of the last of {bits:g} bits that were kept")
    for name in ("_QuantizeBitGroomNumberOfSignificantDigits", "_QuantizeGranularBitRoundNumberOfSignificantDigits"):
        digits = v.number(name)
        if digits is not None:
            largest_now = np.maximum(sizes * (1 + 10.0 ** (1 - digits)), 1e-300)  # it may have been rounded down
            limit = np.where(sizes > 0, 0.5 * 10.0 ** (np.floor(np.log10(largest_now)) + 1 - digits), 0.0)
            return Decoded(values, half + limit, f"{words}, and half of the last of {digits:g} digits that were kept")
    return Decoded(values, half, words)


# --- what states an error ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Beside:
    """A variable that states the error of another one.

    Parameters
    ----------
    kind : linear for standard deviations, low and high for limits
    correlation : as its name says; "" where it says nothing
    factor : brings its numbers to one standard deviation in the unit of the data
    why : how it was recognized
    """

    variable: Variable
    kind: str
    correlation: str
    factor: float
    why: str


def stated(store: Store, v: Variable, multiple: float | None) -> tuple[Beside, ...]:
    """All that lies beside a variable and states its error: ancillary data, and companions by their name.

    Raises
    ------
    ReadError : in a unit that does not fit
    """
    found: dict[str, Beside] = {}
    ancillary = [one for w in v.text("ancillary_variables").split() if (one := beside(store, v.name, w)) is not None]
    for one in ancillary:
        why = _standard_error(v, one)
        if why:
            found[one.name] = _beside(store, v, one, "linear", why, multiple)
    for ending in DEVIATIONS:
        match = store.variables.get(v.name + ending)
        if match is not None and match.name not in found:
            found[match.name] = _beside(store, v, match, "linear", "companion array", multiple)
    named = v.text("uncertainties")  # NeXus
    if named and (match := beside(store, v.name, named)) is not None and match.name not in found:
        found[match.name] = _beside(store, v, match, "linear", "NeXus uncertainties", multiple)
    for low, high in LIMITS:
        pair = [(store.variables.get(v.name + e), k) for e, k in ((low, "low"), (high, "high"))]
        ends = [(p, k) for p, k in pair if p is not None and p.name not in found]
        if len(ends) == 2:
            found |= {p.name: _beside(store, v, p, k, "companion array", 1.0) for p, k in ends}
    return tuple(found.values())


def _standard_error(v: Variable, one: Variable) -> str:
    """How an ancillary variable says that it is an error; "" if it does not."""
    standard = one.text("standard_name")
    if standard.endswith("standard_error") and standard.split()[0] in (v.text("standard_name"), "standard_error"):
        return "CF standard_error"
    words = f"{one.name} {one.text('long_name')}"
    if "flag" not in words and ERROR.search(words):
        return "ancillary variable"
    return ""


def _beside(store: Store, v: Variable, one: Variable, kind: str, why: str, multiple: float | None) -> Beside:
    said = one.number("standard_error_multiplier") or one.number("coverage_factor")
    by = 1.0 / (multiple or said or 1.0)
    mine, its = v.text("units"), one.text("units")
    if its and mine and its != mine and known(its) and known(mine):
        try:
            by *= factor(its, mine)
        except UnitError as error:
            raise ReadError(f"{one.name!r} of {store.path.name!r} should state errors of {v.name!r}: {error}") from None
    words = f"{one.name} {one.text('long_name')} {one.text('comment')}"
    correlation = next((c for pattern, c in STATED if pattern.search(words)), "")
    if "uncorrelated" in words.lower():
        correlation = "independent"
    return Beside(one, kind, correlation, by, why)
