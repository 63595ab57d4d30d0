"""Sulphur dioxide from two stacks, carried by the wind and spread by turbulence: a stand-in for the thesis's plume.

    python resources/data/plume.py          writes networks/data/plume.vti, and prints how much finer steps change it
    python resources/data/plume.py FILE     writes FILE

Solved is the steady transport of a gas by a wind along x that grows with height, without spreading along it,

    u(z) dc/dx = Ky d2c/dy2 + Kz d2c/dz2,

nothing passes the ground or the top, and to the sides the air is clean. Central differences across the wind; along it steps of
Crank and Nicolson, the first ones implicit. Each stack is a Gaussian of 40 m at its height that carries its emission.
Checked against the Gaussian plume with its mirror image at the ground, in a wind that is the same at all heights
(F. Pasquill, Atmospheric Diffusion, 1974).

The file holds 21 x 31 x 41 samples [z, y, x] of concentration in ug/m^3 as float32. Beside them, as `so2_std`, lies what
half the steps across the wind change, divided by 3 as of second order.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags_array, eye_array, kron
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]

SAMPLES = (41, 31, 21)
SPACING = (150.0, 60.0, 30.0)
"""Metres, along x, y, z."""
KY, KZ = 30.0, 9.0
"""Eddy diffusivities, m^2/s."""
WIDTH = 40.0
"""Of a plume where it leaves its stack, metres."""


@dataclass(frozen=True)
class Stack:
    """Where it stands, how high its plume rises (m), and how much it gives off (g/s)."""

    x: float
    y: float
    height: float
    emission: float


STACKS = (Stack(150.0, -240.0, 150.0, 260.0), Stack(750.0, 210.0, 210.0, 200.0))


def wind(z: Floats) -> Floats:
    """Speed in m/s by height in metres."""
    return np.asarray(5.0 * (np.maximum(z, 5.0) / 10.0) ** 0.2)


def solve(stacks: tuple[Stack, ...], speed: Floats, finer: int = 2, steps: int = 6) -> Floats:
    """Concentration in ug/m^3 at the samples, [z, y, x].

    Parameters
    ----------
    speed : of the wind, at the heights of the finer lattice
    finer : cells between two samples across the wind
    steps : along the wind, between two samples
    """
    nx, ny, nz = SAMPLES
    ys = (np.arange((ny - 1) * finer + 1) / finer - (ny - 1) / 2) * SPACING[1]
    zs = np.arange((nz - 1) * finer + 1) / finer * SPACING[2]
    across = KY * _second(len(ys), SPACING[1] / finer, closed=False)
    upwards = KZ * _second(len(zs), SPACING[2] / finer, closed=True)
    spread = kron(upwards, eye_array(len(ys))) + kron(eye_array(len(zs)), across)
    spread = diags_array(1 / np.repeat(speed, len(ys))) @ spread
    h, one = SPACING[0] / steps, eye_array(len(ys) * len(zs))
    implicit = splu((one - h / 2 * spread).tocsc())
    plume = np.zeros(len(ys) * len(zs))
    cut = np.ix_(range(0, len(zs), finer), range(0, len(ys), finer))
    found, rough = np.zeros((nz, ny, nx)), 0
    for i in range(nx):
        for stack in stacks:
            if stack.x == i * SPACING[0]:
                plume += _leaving(stack, ys, zs, speed)
                rough = 4  # what is sharp is smoothed by two implicit half steps instead of one of Crank and Nicolson
        found[:, :, i] = plume.reshape(len(zs), len(ys))[cut]
        for _ in range(steps):
            plume = implicit.solve(implicit.solve(plume) if rough else plume + h / 2 * (spread @ plume))
            rough = max(rough - 1, 0)
    return found


def _second(n: int, h: float, closed: bool) -> Any:
    """Second differences; nothing passes closed ends, beyond open ones there is nothing."""
    middle = np.full(n, -2.0)
    beside = np.ones(n - 1)
    lower, upper = beside.copy(), beside.copy()
    if closed:
        upper[0] = lower[-1] = 2.0
    return diags_array([lower, middle, upper], offsets=[-1, 0, 1]) / h**2


def _leaving(stack: Stack, ys: Floats, zs: Floats, speed: Floats) -> Floats:
    """A Gaussian with its mirror image at the ground, scaled so that the wind carries the emission away."""
    shape = gaussian(ys[None, :] - stack.y, WIDTH) * (
        gaussian(zs[:, None] - stack.height, WIDTH) + gaussian(zs[:, None] + stack.height, WIDTH)
    )
    weight = np.ones(len(zs))
    weight[[0, -1]] = 0.5
    carried = float((shape * (speed * weight)[:, None]).sum() * (ys[1] - ys[0]) * (zs[1] - zs[0]))
    return np.asarray(shape * (1e6 * stack.emission / carried)).ravel()


def gaussian(x: Floats, width: float | Floats) -> Floats:
    """Normal density."""
    return np.asarray(np.exp(-0.5 * (x / width) ** 2) / (np.sqrt(2 * np.pi) * width))


def plume() -> tuple[Floats, Floats]:
    """Concentration, and what finer steps across the wind leave of it."""
    coarse, fine = (solve(STACKS, wind(np.arange((SAMPLES[2] - 1) * f + 1) / f * SPACING[2]), f) for f in (2, 4))
    return fine, np.abs(fine - coarse) / 3


def write(path: Path) -> tuple[Floats, Floats]:
    """Store both as float32 in a VTK image, with units."""
    import pyvista

    values, left = plume()
    data: Any = pyvista.ImageData(dimensions=SAMPLES, spacing=SPACING, origin=(0.0, -SPACING[1] * (SAMPLES[1] - 1) / 2, 0.0))
    data.point_data["so2"] = values.astype(np.float32).ravel()
    data.point_data["so2_std"] = left.astype(np.float32).ravel()
    data.save(path, binary=True)
    return values, left


if __name__ == "__main__":
    root = Path(__file__).resolve().parents[2]
    made, off = write(Path(sys.argv[1]) if len(sys.argv) > 1 else root / "networks" / "data" / "plume.vti")
    print(f"{made.max():.4g} ug/m3 at most, {made[0].max():.4g} at the ground; steps leave {off.max():.3g}")
