"""How much of space lies at or above a level: the volume of a trilinear solid, between two proven bounds.

A cell that the surface passes is cut in boxes. In a box F is its plane through the middle and a rest, which the mixed
coefficients bound; the part of a box on one side of a plane has a closed form, so the plane moved by the rest to either
side gives a lower and an upper bound of the box's part.

Source: volume of a cube cut by a plane (Polya 1913; inclusion and exclusion); trilinear remainders are multi-affine.
"""

import itertools
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels.straight import Active, active

Floats = npt.NDArray[np.float64]

FLAT = 1e-4
"""Of the steepest slope: a smaller one is counted with the rest, for the closed form would lose its digits."""

ROUNDING = 1e-7
"""Of a box: more than rounding can add to the closed form."""

BLOCK = 1 << 18
"""Boxes that are looked at once."""


class Part(NamedTuple):
    """A volume that lies between two bounds, and the volume of all cells that are known."""

    low: float
    high: float
    whole: float


def volume(values: Floats, x: Floats, y: Floats, z: Floats, level: float, cuts: int = 4) -> Part:
    """The volume in which F is at or above a level.

    Parameters
    ----------
    values : (nz, ny, nx)
        At the nodes. A cell with a corner that is not finite does not count.
    cuts
        Boxes along each axis of a cell; the bounds come together with its square.

    Accuracy: proven for the trilinear field, rounding included.
    """
    size = np.diff(z)[:, None, None] * np.diff(y)[:, None] * np.diff(x)
    corner = np.lib.stride_tricks.sliding_window_view(values, (2, 2, 2))
    known = np.isfinite(corner).all(axis=(3, 4, 5))
    full = known & (corner >= level).all(axis=(3, 4, 5))
    base, whole = float(size[full].sum()), float(size[known].sum())
    found = active(values, level)
    low, high = _parts(found, level, cuts)
    weight = size.ravel()[found.cell]
    slack = 2.0**-40 * whole
    return Part(base + float(low @ weight) - slack, min(base + float(high @ weight) + slack, whole), whole)


def _parts(found: Active, level: float, cuts: int) -> tuple[Floats, Floats]:
    """(c,) the least and the largest part of each cell at or above the level."""
    low, high = np.zeros(len(found.cell)), np.zeros(len(found.cell))
    block = max(1, BLOCK // cuts**3)
    for start in range(0, len(found.cell), block):
        some = slice(start, start + block)
        f = (found.value[some] - level).reshape(-1, 2, 2, 2)
        t = np.arange(cuts + 1) / cuts
        for axis in (1, 2, 3):
            w = t.reshape([-1 if a == axis else 1 for a in range(4)])
            f = (1 - w) * np.take(f, [0], axis) + w * np.take(f, [1], axis)
        box = np.lib.stride_tricks.sliding_window_view(f, (2, 2, 2), axis=(1, 2, 3)).reshape(-1, 8)
        least, most = _of_boxes(box)
        low[some] = least.reshape(len(f), -1).mean(axis=1)
        high[some] = most.reshape(len(f), -1).mean(axis=1)
    return low, high


def _of_boxes(box: Floats) -> tuple[Floats, Floats]:
    """(b,) the least and largest part of boxes where F >= 0, from its values at their corners 000, 001, ... 111."""
    sign = np.array([[1 if c >> (2 - axis) & 1 else -1 for c in range(8)] for axis in range(3)])
    middle = box.mean(axis=1)
    slope = np.stack([box @ s / 4 for s in sign], axis=1)
    mixed = sum(np.abs(box @ (sign[p] * sign[q])) / 2 for p, q in ((0, 1), (0, 2), (1, 2)))
    rest = mixed / 4 + np.abs(box @ (sign[0] * sign[1] * sign[2])) / 8
    inside, outside = (box >= 0).all(axis=1), (box < 0).all(axis=1)
    low, high = inside.astype(float), inside.astype(float)
    cut = ~(inside | outside)
    a = np.sort(np.abs(slope[cut]), axis=1)
    small = a < FLAT * a[:, 2:]
    spare = rest[cut] + np.where(small, a, 0.0).sum(axis=1) / 2
    a = np.where(small, 0.0, a)
    low[cut] = np.clip(_below_plane(a, middle[cut] - spare) - ROUNDING, 0.0, 1.0)
    high[cut] = np.clip(_below_plane(a, middle[cut] + spare) + ROUNDING, 0.0, 1.0)
    return low, high


def _below_plane(a: Floats, middle: Floats) -> Floats:
    """(b,) the part of the unit cube about 0 in which middle + a . s >= 0; a ascends along its rows, and may begin with 0."""
    part = np.where(middle >= 0, 1.0, 0.0)
    for n in (1, 2, 3):
        mine = np.flatnonzero((a > 0).sum(axis=1) == n)
        some = a[mine, 3 - n :]
        reach = middle[mine] + some.sum(axis=1) / 2
        total = np.zeros(len(mine))
        for corner in itertools.product((0, 1), repeat=n):
            total += (-1) ** sum(corner) * np.maximum(reach - some @ np.array(corner, float), 0.0) ** n
        part[mine] = np.clip(total / (np.prod(some, axis=1) * (1, 1, 2, 6)[n]), 0.0, 1.0)
    return part
