"""Where the samples of a map lie: axes in ascending order, and degrees brought to metres on a local plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Flag
from modules.data.grid import Frame, Rectilinear, Regular
from modules.data.operators import Floats
from modules.readers._raw import Raw

DEGREES = ("degree", "degree?", "degrees", "deg", "°")


@dataclass(frozen=True)
class Placed:
    """A grid, which axes were turned round, and what was done."""

    grid: Regular | Rectilinear
    flips: tuple[bool, bool]
    flags: tuple[Flag, ...]


def place(raw: Raw, spacing: tuple[float, float] | None, lengths: str, north_first: bool | None, stride: int) -> Placed:
    """The grid of a map.

    Parameters
    ----------
    spacing : (hx, hy) between samples of the file, instead of what it states
    lengths : unit of the coordinates; "" for the file's own
    north_first : whether row 0 is the north edge; None for what the file says

    Returns
    -------
    Placed; `flips` are whether rows and columns run against the axes (y, x)
    """
    rows, columns = raw.full
    hx, hy = spacing or (1.0, 1.0)
    x: NDArray[Any] = hx * np.arange(columns) if spacing or raw.x is None else raw.x
    y: NDArray[Any] = hy * np.arange(rows) if spacing or raw.y is None else raw.y
    north = raw.north_first if raw.y is None else bool(raw.y[0] > raw.y[-1])
    north = north if north_first is None else north_first
    y = y[::-1] if rows > 1 and bool(north) != bool(y[0] > y[-1]) else y
    tolerances = (_rounding(x), _rounding(y))
    x, y = x.astype(np.float64), y.astype(np.float64)
    unit = lengths or raw.lengths
    crs, flags, scales = raw.crs, [], (1.0, 1.0)
    if unit in DEGREES:
        x, y, crs, flag, scales = local_plane(x, y)
        flags.append(flag)
        unit = "m"
    flips = (len(y) > 1 and bool(y[0] > y[-1]), len(x) > 1 and bool(x[0] > x[-1]))
    axes = [a[::-1] if turned else a for a, turned in ((x[::stride], flips[1]), (y[::stride], flips[0]))]
    frame = Frame(units=(unit, unit, unit), crs=crs, handed=raw.handed)
    rounding = tuple(t * s for t, s in zip(tolerances, scales, strict=True))
    return Placed(grid_of(axes, rounding, frame), flips, tuple(flags))


def grid_of(axes: list[Floats], rounding: tuple[float, ...], frame: Frame) -> Regular | Rectilinear:
    """Regular if each axis is evenly spaced within the rounding of its coordinates, else Rectilinear."""
    steps = [(a[-1] - a[0]) / (len(a) - 1) if len(a) > 1 else 1.0 for a in axes]
    even = all(
        np.abs(a - (a[0] + h * np.arange(len(a)))).max() <= max(r, 1e-9 * abs(h))
        for a, h, r in zip(axes, steps, rounding, strict=True)
    )
    if not even:
        return Rectilinear(tuple(axes), frame=frame)
    size = tuple(len(a) for a in reversed(axes))
    return Regular(size, tuple(float(h) for h in steps), tuple(float(a[0]) for a in axes), frame=frame)


def local_plane(longitude: Floats, latitude: Floats) -> tuple[Floats, Floats, str, Flag, tuple[float, float]]:
    """Metres east and north of the south-west corner, on a plane that is true to scale at the middle latitude.

    Returns
    -------
    x, y : in metres
    crs, flag : what was done, and the largest relative error of a length
    scales : metres per degree (east, north)

    Source: series of the meridian and the parallel of the WGS 84 ellipsoid.
    """
    west, south, north = float(longitude.min()), float(latitude.min()), float(latitude.max())
    middle = (south + north) / 2
    east_scale, north_scale = metres_per_degree(middle)
    ends = [metres_per_degree(v) for v in (south, north)]
    along = max(abs(e / east_scale - 1) for e, _ in ends)
    upwards = max(abs(n / north_scale - 1) for _, n in ends)
    crs = (
        f"local plane at latitude {middle:.5f} of WGS 84: {east_scale:.1f} m a degree east, {north_scale:.1f} m north; "
        f"x and y from longitude {west:.5f}, latitude {south:.5f}"
    )
    words = (
        f"on a local plane lengths are off by up to {max(along, upwards):.2%}; degrees were brought to metres by the scale "
        f"of the middle latitude: lengths east are off by up to {along:.2%} at the edges, north by up to {upwards:.3%}"
    )
    flag = Flag("local plane", words, "point", None, np.array([max(along, upwards)]))
    return (longitude - west) * east_scale, (latitude - south) * north_scale, crs, flag, (east_scale, north_scale)


def metres_per_degree(latitude: float) -> tuple[float, float]:
    """Metres a degree east and north at a latitude in degrees, on WGS 84."""
    p = np.deg2rad(latitude)
    east = 111412.84 * np.cos(p) - 93.5 * np.cos(3 * p) + 0.118 * np.cos(5 * p)
    north = 111132.92 - 559.82 * np.cos(2 * p) + 1.175 * np.cos(4 * p) - 0.0023 * np.cos(6 * p)
    return float(east), float(north)


def _rounding(axis: NDArray[Any]) -> float:
    """How far stored coordinates may lie from evenly spaced ones by their own rounding."""
    if axis.dtype.kind != "f":
        return 0.0
    return float(4 * np.spacing(np.abs(axis).max()))
