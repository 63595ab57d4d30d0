"""What lies between two contourings of one field: polygons, arc by arc (thesis, figure 3.7)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules.accuracy_mappers import _between
from modules.api import (
    Accuracy,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    Matrix,
    NamedTuple,
    Progress,
    Shown,
    Source,
    Table,
    Term,
    accuracy_mapper,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

RULE = "area of the polygons between matched arcs; Lopes 1999, figure 3.7 [difference-area/1]"
WHY = "what lies between two drawings says how they differ, not how far either may be trusted"


class Difference(NamedTuple):
    """What lies between two contourings, and its area cell by cell."""

    between: Geometry
    table: Table


class Piece(NamedTuple):
    """A polygon between the two contourings."""

    ring: _between.Ring
    area: float
    level: float
    cell: int
    joined: bool


@accuracy_mapper("Difference of contours", aliases=("compare contours", "between lines", "method difference"))
def difference(
    first: Geometry, second: Geometry, progress: Progress, *, called: str = "Difference of two contourings"
) -> Difference:
    """Filled polygons between two contourings of one field at the same levels, arc by arc.

    Arcs are matched by level, grid cell and end points. Where the two join the ends of a cell in another way, what lies
    between them is filled, and the cell is flagged.

    Parameters
    ----------
    first, second : contour lines of one model at the same levels, by two methods
    called : what legends call it; two differences in one picture need two names

    Raises
    ------
    ValueError : no contour lines, other levels, or not of one field

    Accuracy: the area is that of the drawn polygons, exact. All terms of the lines end here: a difference of two drawings is
        no error of either.
    Source: Lopes 1999, 3.4 and figure 3.7.
    """
    one, two = _between.arcs_of(first), _between.arcs_of(second)
    _same_levels(one, two)
    unit, factor = _unit(first)
    groups = sorted(set(one) | set(two))
    pieces: list[Piece] = []
    lost: list[int] = []
    for i, key in enumerate(groups):
        if i % 1024 == 0:
            progress(i / len(groups))
        matched = _between.matched(one.get(key, []), two.get(key, []))
        if matched is None:
            lost.append(key[1])
            continue
        pieces += _filled(*matched, *key, factor)
    if len(lost) > len(groups) / 2:
        raise ValueError(f"in {len(lost)} of {len(groups)} cells the arcs have other ends: wire two contourings of one model")
    own = _accuracy(pieces, unit, called).flag(*_flags(pieces, lost))
    ended = own.end_from(first.accuracy, WHY).end_from(second.accuracy, WHY)
    ended = ended.miss(*first.accuracy.missing, *second.accuracy.missing)
    return Difference(_shape(first, pieces, unit, ended), _table(pieces, unit, ended))


def _same_levels(one: _between.Groups, two: _between.Groups) -> None:
    levels = [{level for level, _ in groups} for groups in (one, two)]
    if levels[0] != levels[1]:
        odd = sorted(levels[0] ^ levels[1])
        shown = ", ".join(f"{v:g}" for v in odd[:5])
        raise ValueError(f"only one of the two has lines at {shown}: draw both at the same levels")


def _unit(lines: Geometry) -> tuple[str, float]:
    """Unit of an area, and what one square of the coordinates is in it: cells where the axes have different units."""
    try:
        length = lines.frame.length_unit(2)
    except ValueError:
        return "cell²", 1 / (lines.cell or 1.0) ** 2
    return (f"{length}²" if length else ""), 1.0


def _filled(same: list[_between.Ring], other: list[_between.Ring], level: float, cell: int, factor: float) -> Iterator[Piece]:
    """The polygons of one cell: of loops whose ends are joined alike, and of those joined in another way."""
    for loops, joined in ((same, True), (other, False)):
        for loop in loops:
            for ring in _between.simple(loop):
                for part in _between.convex_parts(ring):
                    area = factor * abs(_between.shoelace(part))
                    if area > 0:
                        yield Piece(part, area, level, cell, joined)


def _accuracy(pieces: list[Piece], unit: str, called: str) -> Accuracy:
    source = Source(called, "mapping", "exact", RULE)
    area = np.array([p.area for p in pieces])
    return Accuracy((Term(source, "metric", "area", unit, area, Identity(len(area)), "cell"),))


def _flags(pieces: list[Piece], lost: list[int]) -> list[Flag]:
    other = np.array([i for i, p in enumerate(pieces) if not p.joined], np.int64)
    flags = []
    if len(other):
        cells = len({(pieces[i].level, pieces[i].cell) for i in other})
        words = f"the two join the lines in another way in {cells} cell{'s' if cells > 1 else ''}"
        flags.append(Flag("joined in another way", words, "cell", other))
    if lost:
        words = f"in {len(lost)} cells the arcs have other ends: their difference is not drawn"
        flags.append(Flag("not compared", words, "cell"))
    return flags


def _shape(first: Geometry, pieces: list[Piece], unit: str, accuracy: Accuracy) -> Geometry:
    offsets = np.concatenate([[0], np.cumsum([len(p.ring) for p in pieces])]).astype(np.int64)
    points = np.zeros((int(offsets[-1]), 3))
    points[:, :2] = np.array([at for p in pieces for at in p.ring], float).reshape(-1, 2)
    return Geometry(
        points=points,
        polygons=Cells(offsets, np.arange(offsets[-1])),
        values={
            "area": Field(np.array([p.area for p in pieces], float), "cell", unit),
            "grid cell": Field(np.array([p.cell for p in pieces], np.int64), "cell"),
            "level": Field(np.array([p.level for p in pieces], float), "cell", first.values["level"].unit),
            "joined in another way": Field(np.array([not p.joined for p in pieces], np.int64), "cell"),
        },
        shows=(Shown(accuracy.terms[0].name, "area"),),
        cell=first.cell,
        frame=first.frame,
        name=first.name,
        time=first.time,
        accuracy=accuracy,
    )


def _table(pieces: list[Piece], unit: str, accuracy: Accuracy) -> Table:
    """One row a grid cell and level that has something between."""
    keys = sorted({(p.level, p.cell) for p in pieces})
    row = {key: i for i, key in enumerate(keys)}
    where = np.array([row[p.level, p.cell] for p in pieces], np.int64)
    sums = csr_array((np.ones(len(pieces)), (where, np.arange(len(pieces)))), shape=(len(keys), len(pieces)))
    (term,) = accuracy.terms
    other = {(p.level, p.cell) for p in pieces if not p.joined}
    columns = {
        "grid cell": np.array([c for _, c in keys], np.int64),
        "level": np.array([v for v, _ in keys], float),
        "area": np.asarray(sums @ np.array([p.area for p in pieces], float)),
        "joined in another way": np.array([key in other for key in keys], np.int64),
    }
    own = Accuracy((term.push(Matrix(sums), place="point"),), accuracy.missing, (), accuracy.ended)
    return Table(columns=columns, units={"area": unit} if unit else {}, name="difference of contours", accuracy=own)
