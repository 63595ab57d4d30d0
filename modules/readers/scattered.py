"""Values at scattered points, from a table as text: a survey, soundings, stations, boreholes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from modules.api import Choice, Flag, Frame, Samples, Unstructured, reader
from modules.data.companions import is_companion
from modules.data.operators import Floats
from modules.readers import _columns
from modules.readers._columns import Columns
from modules.readers._files import ReadError, digest, problem, reading
from modules.readers._place import DEGREES, local_plane

ACROSS = ("x", "easting", "east", "lon", "longitude", "long", "lng")
UPWARDS = ("y", "northing", "north", "lat", "latitude")
ANGLES = ("lon", "longitude", "long", "lng")


def peek(path: Path) -> Mapping[str, Any]:
    """Names of the columns, and whether one of them states errors."""
    try:
        names = _columns.peek(_columns.file_of(path))["names"]
        return {"names": names, "scattered": True, "errors": any(is_companion(n, names) for n in names)}
    except ReadError as error:
        return problem(error)


@reader("Read points", output="samples", peek=peek, aliases=("scattered data", "csv", "xyz", "survey", "soundings", "stations"))
def scattered(
    *,
    path: Path | None = None,
    name: Annotated[str | None, Choice(of="path.names")] = None,
    x: Annotated[str | None, Choice(of="path.names")] = None,
    y: Annotated[str | None, Choice(of="path.names")] = None,
    z: Annotated[str | None, Choice(of="path.names")] = None,
    unit: str | None = None,
    lengths: str | None = None,
) -> Samples:
    """Values at points that lie anywhere, from the columns of a text file (.csv, .tsv, .txt, .xyz, .dat).

    The points have no cells between them: bring them to a grid with 'Grid points', or join them with 'Triangulate'.
    Longitude and latitude are brought to metres on a plane that is true to scale at the middle latitude.

    Parameters
    ----------
    path : the file; names of columns stand in its first line, units in brackets behind them
    name : column of the values; automatic takes the first that is no coordinate and no error
    x, y : columns of the coordinates; automatic finds x, easting, lon; y, northing, lat; else takes the first two
    z : column of the third coordinate, for points in space; automatic: they lie in a plane
    unit : of the values; automatic takes what stands in brackets
    lengths : unit of the coordinates, m, ft, degree; automatic takes what stands in brackets

    Raises
    ------
    ReadError : no such column, a word that is no number, a line without coordinates

    Accuracy: adds the rounding of the printed digits as a proven bound, and what columns beside the values state (name_std,
    name_lo with name_hi, ...); an error of measurement that the file does not state is listed as missing. Coordinates
    are taken as they are; a flag says where they are printed more coarsely than a tenth of the distance of the points.
    """
    found = _columns.file_of(path)
    with reading(found):
        table = _columns.read(found)
    across = table.chosen("x", x, ACROSS) or _next(table, [])
    upwards = table.chosen("y", y, UPWARDS) or _next(table, [across])
    above = table.chosen("z", z, ())
    places = [c for c in (across, upwards, above) if c]
    column = table.chosen("the values", name, ()) or _next(table, places)
    at = np.column_stack([table.values[c] for c in places])
    rows = np.flatnonzero(np.isfinite(table.values[column]))
    if not len(rows):
        raise ReadError(f"{found.name!r} has no value in its column {column!r}: choose another")
    bad = rows[~np.isfinite(at[rows]).all(axis=1)]
    if len(bad):
        raise ReadError(f"{found.name!r}, line {table.lines[bad[0]]}: a point has no {' or no '.join(places)}")
    nodes, frame, flags = _placed(table, at[rows], across, places, lengths)
    stated = unit or table.units[column]
    accuracy = table.accuracy(column, rows, digest(found), unit=stated)
    accuracy = accuracy.flag(*flags, *_coarse(table, at[rows], rows, places))
    empty = np.zeros(0, np.int64)
    grid = Unstructured(nodes, np.zeros(1, np.int64), empty, empty, frame=frame)
    return Samples(grid=grid, values=table.values[column][rows], unit=stated, name=column, accuracy=accuracy)


def _coarse(table: Columns, at: Floats, rows: Any, places: list[str]) -> tuple[Flag, ...]:
    """That coordinates are rounded to more than a tenth of the distance of neighbours."""
    from scipy.spatial import cKDTree

    step = 2 * max(float(table.halves[c][rows].max()) for c in places)
    apart = float(np.median(cKDTree(at).query(at, k=2)[0][:, 1])) if len(at) > 1 else np.inf
    if step <= 0.1 * apart:
        return ()
    words = f"coordinates are printed to {step:g}, and points lie {apart:g} apart: what their rounding does is not carried"
    return (Flag("coarse coordinates", words),)


def _next(table: Columns, taken: list[str]) -> str:
    """The first column that is not taken and states no error of another."""
    left = [c for c in table.values if c not in taken and not is_companion(c, table.values)]
    if not left:
        many = f"{table.path.name!r} has {len(table.values)} columns of numbers"
        raise ReadError(f"{many}: coordinates x, y and a value are needed")
    return left[0]


def _placed(
    table: Columns, at: Floats, across: str, places: list[str], lengths: str | None
) -> tuple[Floats, Frame, tuple[Flag, ...]]:
    """Positions in x, y, z, what the axes are, and what was taken for granted."""
    nodes = np.zeros((len(at), 3))
    nodes[:, : at.shape[1]] = at
    unit = lengths or table.units[across] or ("degree" if across.lower() in ANGLES else "")
    if unit not in DEGREES:
        return nodes, Frame(units=(unit, unit, unit)), ()
    nodes[:, 0], nodes[:, 1], crs, flag, _ = local_plane(at[:, 0], at[:, 1])
    upwards = table.units[places[2]] if len(places) == 3 else ""
    return nodes, Frame(units=("m", "m", upwards or "m"), crs=crs), (flag,)
