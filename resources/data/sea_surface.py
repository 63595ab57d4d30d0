"""Height of the sea surface as an altimeter maps it: a made-up current with eddies, and errors that the file states.

    python resources/data/sea_surface.py          writes networks/data/sea-surface.nc

The truth is a formula, so what the file states of its errors can be held against what they are. To it are added one draw
of the instrument's noise, larger between the tracks of the satellite than on them, and one calibration error that is the
same everywhere. Both are stated as the CF conventions want it: as `ancillary_variables` whose standard name ends in
`standard_error`. The numbers are packed in 16 bits, latitude runs from north to south, land is a fill value.

The file is NetCDF 3, which needs no further package to be written or read.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import netcdf_file

Floats = NDArray[np.float64]

STEP = 0.1
"""Degrees between samples."""
WEST, EAST, SOUTH, NORTH = -70.0, -61.0, 36.0, 42.0
PACKED = 5e-4
"""Metres of one unit of the stored heights."""
ERROR_PACKED = 1e-4
"""Metres of one unit of the stored errors."""
FILL = -32768
CALIBRATION = 0.005
"""Metres, standard deviation of the error that all samples share."""
SEED = 1999

EDDIES = ((-67.6, 40.2, 0.9, 0.34), (-64.9, 40.5, 0.7, 0.27), (-66.4, 37.3, 0.8, -0.36), (-62.9, 37.6, 0.75, -0.30))
"""(longitude, latitude, radius in degrees, height in metres)."""


def truth(longitude: Floats, latitude: Floats) -> Floats:
    """Height in metres: a meandering front with eddies to both sides."""
    front = 38.9 + 0.45 * np.sin(2 * np.pi * (longitude + 70) / 4.3) + 0.06 * (longitude + 65.5)
    height = 0.5 * np.tanh((front - latitude) / 0.8)
    for x, y, radius, top in EDDIES:
        height = height + top * np.exp(-(((longitude - x) * np.cos(np.deg2rad(39))) ** 2 + (latitude - y) ** 2) / radius**2)
    return np.asarray(height)


def noise(longitude: Floats, latitude: Floats) -> Floats:
    """Standard deviation in metres of the instrument's own error: 4 mm on a track, 16 mm between two."""
    across = (longitude * np.cos(np.deg2rad(24)) + latitude * np.sin(np.deg2rad(24))) / 1.9
    return np.asarray(0.010 - 0.006 * np.cos(2 * np.pi * across))


def land(longitude: Floats, latitude: Floats) -> NDArray[np.bool_]:
    """A coast in the north-west corner."""
    return np.asarray(latitude > 41.3 + 0.9 * (longitude + 68.2) + 0.12 * np.sin(9 * longitude))


def axes() -> tuple[Floats, Floats]:
    """Longitudes, and latitudes from north to south."""
    x = WEST + STEP * np.arange(round((EAST - WEST) / STEP) + 1)
    y = NORTH - STEP * np.arange(round((NORTH - SOUTH) / STEP) + 1)
    return np.round(x, 6), np.round(y, 6)


def write(path: Path) -> None:
    """The file."""
    x, y = axes()
    longitude, latitude = np.meshgrid(x, y)
    draw = np.random.default_rng(SEED)
    sigma = np.round(noise(longitude, latitude) / ERROR_PACKED) * ERROR_PACKED
    height = truth(longitude, latitude) + sigma * draw.normal(size=sigma.shape) + CALIBRATION * draw.normal()
    dry = land(longitude, latitude)
    with netcdf_file(path, "w") as file:
        file.Conventions = b"CF-1.11"
        file.title = b"Height of the sea surface, made up, with the errors of an altimeter"
        _axis(file, "latitude", y, b"degrees_north")
        _axis(file, "longitude", x, b"degrees_east")
        name = "sea_surface_height_above_geoid"
        _packed(file, "ssh", height, PACKED, dry, name, "Height of the sea surface")
        _packed(file, "ssh_noise", sigma, ERROR_PACKED, dry, f"{name} standard_error", "Altimeter, random noise")
        file.variables["ssh"].ancillary_variables = b"ssh_noise ssh_calibration"
        bias = file.createVariable("ssh_calibration", "d", ())
        bias.data[...] = CALIBRATION * 100
        bias.units, bias.standard_name = b"cm", f"{name} standard_error".encode()
        bias.long_name = b"Altimeter, systematic error of calibration"


def _axis(file: Any, name: str, values: Floats, units: bytes) -> None:
    file.createDimension(name, len(values))
    made = file.createVariable(name, "d", (name,))
    made[:] = values
    made.units, made.standard_name = units, name.encode()


def _packed(
    file: Any, name: str, values: Floats, scale: float, holes: NDArray[np.bool_], standard: str, words: str
) -> None:
    made = file.createVariable(name, "h", ("latitude", "longitude"))
    made[:] = np.where(holes, FILL, np.round(values / scale)).astype(np.int16)
    made.units, made.standard_name, made.long_name = b"m", standard.encode(), words.encode()
    made.scale_factor, made._FillValue = np.float64(scale), np.int16(FILL)


if __name__ == "__main__":
    root = Path(__file__).resolve().parent.parent.parent
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else root / "networks" / "data" / "sea-surface.nc")
