"""Other units and another origin, of coordinates and of values."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from modules.api import (
    Curvilinear,
    Frame,
    Grid,
    Identity,
    Operator,
    Rectilinear,
    Regular,
    Samples,
    Stencil,
    Unstructured,
    modeller,
    uniform,
)
from modules.data.grid import Axial
from modules.data.units import linear
from modules.modellers._linear import carried, dimension, extra_of, lattice_of


@modeller("Transform", output="samples", aliases=("units", "scale", "shift", "flip", "convert", "georeference"))
def transform(
    samples: Samples,
    *,
    scale: tuple[float, ...] = (1.0,),
    shift: tuple[float, ...] = (0.0,),
    lengths: str = "",
    factor: float = 1.0,
    offset: float = 0.0,
    unit: str = "",
) -> Samples:
    """The same data in other units or at another place: coordinates x scale + shift, values x factor + offset.

    A new unit converts: m to km, degC to K. What had no unit only gets its name. A negative scale turns an axis round; the
    components of vectors along it change their sign. Otherwise vectors keep their numbers: a wind in m/s over a map in km
    stays in m/s.

    Parameters
    ----------
    samples : of any grid
    scale : of the coordinates x, y, z; one number serves all axes; negative turns an axis round
    shift : added to the coordinates x, y, z after scaling; one number serves all axes
    lengths : new unit of the coordinates; empty keeps it. `scale` and `shift` come after the conversion
    factor : of the values
    offset : added to the values after the factor
    unit : new unit of the values; empty keeps it. `factor` and `offset` come after the conversion

    Raises
    ------
    ValueError : a unit that is not known or measures something else, a scale of 0, or one that turns an
        axis of a bent or unstructured grid round

    Accuracy: errors of the values are multiplied by the factor; coordinates are taken as exact.
    Source: a change of units.
    """
    if not (math.isfinite(factor) and factor != 0 and math.isfinite(offset)):
        raise ValueError(f"factor {factor} and offset {offset} should be finite, and the factor not 0")
    scales, shifts = _three(scale, "scale"), _three(shift, "shift")
    if not all(math.isfinite(s) and s != 0 for s in scales) or not all(map(math.isfinite, shifts)):
        raise ValueError(f"scale {scale} and shift {shift} should be finite, and no scale 0")
    grid, n = samples.grid, len(samples.grid.shape)
    if lengths:
        scales = tuple(s * converted(u, lengths)[0] for s, u in zip(scales, grid.frame.units, strict=True))
    turned = [a for a in range(3) if scales[a] < 0]
    operator: Operator = Identity(samples.values.size)
    if turned:
        operator = _turned(samples, [a for a in turned if a < n])
    times, plus = converted(samples.unit, unit or samples.unit)
    if factor * times != 1.0:
        operator = uniform(lattice_of(samples), factor * times).after(operator)
    frame = replace(grid.frame, units=(lengths,) * 3) if lengths else grid.frame
    result = carried(samples, operator, _moved(grid, scales, shifts, frame), unit=unit or samples.unit)
    added = offset + factor * plus
    return result if added == 0 else replace(result, values=result.values + added)


def converted(old: str, new: str) -> tuple[float, float]:
    """Factor and offset from one unit to another; what had none takes the new one as it is."""
    return linear(old, new) if old.strip() else (1.0, 0.0)


def _three(numbers: tuple[float, ...], what: str) -> tuple[float, ...]:
    if not 1 <= len(numbers) <= 3:
        raise ValueError(f"{what} {numbers} should be one to three numbers, for x, y and z")
    return numbers * 3 if len(numbers) == 1 else (*numbers, *((1.0 if what == "scale" else 0.0,) * (3 - len(numbers))))


def _turned(samples: Samples, axes: list[int]) -> Operator:
    """The samples in the other order along some axes; vector components along these with the other sign."""
    if not isinstance(samples.grid, Regular | Rectilinear):
        raise ValueError(f"an axis of a {samples.grid.kind} grid cannot be turned round: take positive scales")
    lattice = lattice_of(samples)
    whole: Operator = Identity(samples.values.size)
    for axis in axes:
        size = len(samples.grid.axes[axis])
        whole = Stencil(lattice, dimension(samples.grid, axis), np.arange(size)[::-1, None], np.ones((size, 1))).after(whole)
    extra = extra_of(samples)
    if extra:
        sign = np.where(np.isin(np.arange(3), axes), -1.0, 1.0)
        signs = sign if len(extra) == 1 else np.outer(sign, sign).ravel()
        c = len(signs)
        whole = Stencil(lattice, len(lattice) - 1, np.arange(c)[:, None], signs[:, None].copy()).after(whole)
    return whole


def _moved(grid: Grid, scales: tuple[float, ...], shifts: tuple[float, ...], frame: Frame) -> Grid:
    if isinstance(grid, Curvilinear | Unstructured):
        if min(scales) < 0:
            raise ValueError(f"an axis of a {grid.kind} grid cannot be turned round: take positive scales")
        return replace(grid, nodes=grid.nodes * np.array(scales) + np.array(shifts), frame=frame)
    assert isinstance(grid, Regular | Rectilinear)
    return _along_axes(grid, scales, shifts, frame)


def _along_axes(grid: Axial, scales: tuple[float, ...], shifts: tuple[float, ...], frame: Frame) -> Grid:
    moved = [np.sort(x * s + t) for x, s, t in zip(grid.axes, scales, shifts, strict=False)]
    if isinstance(grid, Regular):
        spacing = tuple(h * abs(s) for h, s in zip(grid.spacing, scales, strict=False))
        return replace(grid, spacing=spacing, origin=tuple(float(m[0]) for m in moved), frame=frame)
    return replace(grid, axes=tuple(moved), frame=frame)
