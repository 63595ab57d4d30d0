"""USGS digital elevation models in the old ASCII format: records A, B (profiles, south to north) and C (accuracy).

Source: U.S. Geological Survey, Standards for Digital Elevation Models, part 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.operators import Floats
from modules.readers._files import ReadError, fits, reading
from modules.readers._raw import Raw, Stated

RECORD = 1024
HEAD = 144
VOID = (-32767, -32766)
PLANE = {0: "radian", 1: "ft", 2: "m", 3: "arc-second"}
HEIGHT = {1: "ft", 2: "m"}
SYSTEM = {0: "geographic", 1: "UTM", 2: "State Plane"}


@dataclass(frozen=True)
class Head:
    """Record A: what is in the file."""

    title: str
    plane: str
    height: str
    crs: str
    range: tuple[float, float]
    steps: tuple[float, float, float]
    columns: int
    accuracy: bool


@dataclass(frozen=True)
class Profile:
    """Record B: heights along a meridian of the grid, from the south."""

    x: float
    y: float
    heights: NDArray[np.int64]
    datum: float


def load(path: Path, name: str, stride: int) -> Raw:
    """The elevations of a .dem file, with the errors that its record C states.

    Raises
    ------
    ReadError : not such a file, cut off, rotated, or too large
    """
    with reading(path):
        text = _text(path)
    head = _head(path, text[:RECORD])
    profiles, end = _profiles(path, text, head)
    heights, x, y = _lattice(path, profiles, head)
    stated = _record_c(path, text[end : end + RECORD] if head.accuracy else "", head, heights)
    angular = {"arc-second": 1 / 3600, "radian": float(np.rad2deg(1.0))}.get(head.plane)
    holes = np.isnan(heights)
    return Raw(
        values=heights[::stride, ::stride], full=(heights.shape[0], heights.shape[1]), half=np.asarray(head.steps[2] / 2),
        stored=f"half the height step of {head.steps[2]:g} {head.height} that record A states", name="elevation",
        x=x * (angular or 1.0), y=y * (angular or 1.0), unit=head.height, lengths="degree" if angular else head.plane,
        crs=head.crs, holes=holes[::stride, ::stride], stated=stated,
    )  # fmt: skip


def peek(path: Path) -> dict[str, Any]:
    """Title, range and number of columns, from record A alone."""
    with reading(path), path.open("rb") as file:
        start = file.read(RECORD)
    head = _head(path, start.decode("latin-1"))
    return {"names": ("elevation",), "range": head.range, "unit": head.height, "title": head.title, "columns": head.columns}


def _text(path: Path) -> str:
    """The records without line ends; those were added by some programs."""
    text = path.read_bytes().decode("latin-1")
    return text.replace("\r", "").replace("\n", "") if "\n" in text[: RECORD + 2] else text


def _head(path: Path, text: str) -> Head:
    try:
        system, zone, plane, height = (int(text[i : i + 6]) for i in (156, 162, 528, 534))
        steps = tuple(_number(text[i : i + 12]) for i in (816, 828, 840))
        low, high = (_number(text[i : i + 24]) for i in (738, 762))
        angle = _number(text[786:810] or "0")
        columns, accuracy = int(text[858:864]), text[810:816].strip() == "1"
        named = PLANE[plane], HEIGHT[height]
        if len(text) < RECORD - 200 or min(steps) <= 0 or columns < 1:
            raise ValueError("steps")
    except (ValueError, KeyError):
        raise ReadError(f"{path.name!r} does not begin as an elevation model of the USGS in ASCII format does") from None
    if angle:
        raise ReadError(f"{path.name!r} is turned by {angle:g} radians: turn it back with a GIS before reading it")
    crs = f"{SYSTEM.get(system, 'system ' + str(system))}{f' zone {zone}' if system else ''}, USGS elevation model"
    return Head(" ".join(text[:81].split()), *named, crs, (low, high), (steps[0], steps[1], steps[2]), columns, accuracy)


def _number(text: str) -> float:
    return float(text.strip().upper().replace("D", "E"))


def _profiles(path: Path, text: str, head: Head) -> tuple[list[Profile], int]:
    profiles, at = [], RECORD
    for i in range(head.columns):
        top = text[at : at + HEAD]
        try:
            count = int(top[12:18])
            x, y, datum = (_number(top[k : k + 24]) for k in (24, 48, 72))
            pieces, left, start = [], count, HEAD
            while left > 0:
                take = min(left, 146 if start else 170)
                piece = text[at + start : at + start + 6 * take]
                if len(piece) < 6 * take:
                    raise ValueError("short")
                pieces.append(piece)
                left, start, at = left - take, 0, at + RECORD
            heights = np.frombuffer("".join(pieces).encode("latin-1"), "S6").astype(np.int64)
        except ValueError:
            raise ReadError(
                f"{path.name!r} ends early or is damaged in profile {i + 1} of {head.columns}: copy or download it again"
            ) from None
        profiles.append(Profile(x, y, heights, datum))
    return profiles, at


def _lattice(path: Path, profiles: Sequence[Profile], head: Head) -> tuple[Floats, Floats, Floats]:
    """(ny, nx) heights, NaN outside the profiles, and the coordinates of columns and rows."""
    _, hy, hz = head.steps
    south = min(p.y for p in profiles)
    first = [(p.y - south) / hy for p in profiles]
    if np.abs(np.array(first) - np.round(first)).max() > 0.01:
        raise ReadError(f"the profiles of {path.name!r} do not lie on one lattice of step {hy:g}: its record A or B is wrong")
    starts = [round(f) for f in first]
    rows = max(s + len(p.heights) for s, p in zip(starts, profiles, strict=True))
    fits(path, (rows, len(profiles)))
    heights = np.full((rows, len(profiles)), np.nan)
    for j, (start, p) in enumerate(zip(starts, profiles, strict=True)):
        column = p.heights * hz + p.datum
        heights[start : start + len(column), j] = np.where(np.isin(p.heights, VOID), np.nan, column)
    x = np.array([p.x for p in profiles])
    if (np.diff(x) <= 0).any():
        raise ReadError(f"the profiles of {path.name!r} do not run from west to east: its record B is wrong")
    y: Floats = south + hy * np.arange(rows, dtype=np.float64)
    return heights, x, y


def _record_c(path: Path, text: str, head: Head, heights: Floats) -> tuple[Stated, ...]:
    """The errors that record C states: of the datum, common to all heights; of the model, one for each."""
    if not text.strip():
        return ()
    try:
        numbers = [_number(text[i : i + 6].strip() or "0") for i in range(0, 60, 6)]
        if not all(0 <= v < np.inf for v in numbers):
            raise ValueError("negative")
    except ValueError:
        raise ReadError(f"record C of {path.name!r}, which states its accuracy, is damaged: get it again") from None
    found: list[Stated] = []
    slopes = np.stack([_slope(heights, axis) / head.steps[1 - axis] for axis in (1, 0)], axis=-1)
    for who, what, part, common in (("datum", "datum", numbers[:5], True), ("elevation model", "model", numbers[5:], False)):
        flag, x, y, z, points = part
        if flag != 1:
            continue
        tested = f"from {points:g} points" if points else "number of test points not stated"
        said = f"RMSE of the {who} in x, y, z: {x:g}, {y:g} {head.plane}, {z:g} {head.height}, {tested}"
        as_ = "taken as one error common to all heights" if common else "taken as independent from height to height"
        rule = f"{said}; {as_} (USGS record C/1)"
        tilt = f"{said}; carried to heights by the slope, {as_} (USGS record C, horizontal/1)"
        height = Stated(
            name=f"Height of the {who}", what=f"{what}-z", kind="linear", rule=rule, common=common,
            value=np.array([z]) if common else np.asarray(z),
        )  # fmt: skip
        place = Stated(
            name=f"Place of the {who}", what=f"{what}-xy", kind="linear", rule=tilt, common=common,
            value=np.array([x, y]) if common else np.hypot(x * slopes[..., 0], y * slopes[..., 1]),
            weights=slopes if common else None,
        )  # fmt: skip
        found += [height, place]
    return tuple(found)


def _slope(heights: Floats, axis: int) -> Floats:
    """Difference from sample to sample: central, one-sided beside holes and borders, 0 where there is no neighbour."""
    step = np.diff(heights, axis=axis)
    pad = [(1, 1) if k == axis else (0, 0) for k in range(2)]
    both = np.pad(step, pad, constant_values=np.nan)
    before = np.take(both, np.arange(heights.shape[axis]), axis)
    after = np.take(both, np.arange(1, heights.shape[axis] + 1), axis)
    count = np.isfinite(before).astype(int) + np.isfinite(after)
    return np.asarray((np.nan_to_num(before) + np.nan_to_num(after)) / np.maximum(count, 1))
