"""Writes the packaged soundings of a lake: depths at 240 scattered points of a known bottom, with noise of stated size.

    python resources/data/soundings.py          writes networks/data/soundings.csv
    python resources/data/soundings.py FILE     writes FILE

The lake is made up. Points lie along the crooked tracks of a boat; every depth has a deviation of 0.15 m, which the file
states, and is printed to a centimetre.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NOISE = 0.15
TRACKS, ALONG = 12, 20


def truth(x: Floats, y: Floats) -> Floats:
    """Depth in metres at places in metres: two basins and a sill between them."""
    basin = 14 * np.exp(-(((x - 320) / 170) ** 2) - ((y - 260) / 140) ** 2)
    other = 9 * np.exp(-(((x - 690) / 150) ** 2) - ((y - 330) / 120) ** 2)
    return np.asarray(3 + basin + other + 0.8 * np.sin(x / 70) * np.cos(y / 55))


def places() -> tuple[Floats, Floats]:
    """Where the boat sounded."""
    random = np.random.default_rng(1999)
    x = np.linspace(30, 970, ALONG)[None, :] + random.normal(0, 14, (TRACKS, ALONG))
    y = np.linspace(30, 570, TRACKS)[:, None] + np.cumsum(random.normal(0, 5, (TRACKS, ALONG)), axis=1)
    return np.round(x.ravel(), 1), np.round(y.ravel(), 1)


def write(path: Path) -> None:
    """The table, as text."""
    x, y = places()
    depth = truth(x, y) + np.random.default_rng(2000).normal(0, NOISE, len(x))
    lines = ["easting [m],northing [m],depth [m],depth_std"]
    lines += [f"{a:.1f},{b:.1f},{d:.2f},{NOISE}" for a, b, d in zip(x, y, depth, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


if __name__ == "__main__":
    root = Path(__file__).resolve().parents[2]
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else root / "networks" / "data" / "soundings.csv")
