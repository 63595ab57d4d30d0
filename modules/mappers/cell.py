"""A laboratory of one bilinear cell: its hyperbola, and all that chapter 3 of the thesis constructs in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Frame,
    Geometry,
    Identity,
    Model,
    NamedTuple,
    Range,
    Rectilinear,
    Regular,
    Source,
    Table,
    Term,
    exactly,
    mapper,
    select,
)
from modules.data.geometry import points_of
from modules.mappers import _cell
from modules.mappers._cell import Arc

Floats = NDArray[np.float64]

CURVE = Source(
    "Chords of the drawn curve", "mapping", "proven", "farthest point of each piece of the arc from its chord [arc-sagitta/1]"
)
RULE = "closed form of the bilinear cell, without a division by c; Lopes 1999, 3.2 and 3.3 [cell-construction/1]"
WHY = "the construction is that of the cell as its corner values are given"


class CellParts(NamedTuple):
    """The cell and what is constructed in it, each to be drawn in a look of its own."""

    outline: Geometry
    hyperbola: Geometry
    beyond: Geometry
    asymptotes: Geometry
    chords: Geometry
    shoulders: Geometry
    tangents: Geometry
    parallels: Geometry
    medians: Geometry
    points: Geometry
    corners: Geometry
    table: Table


@mapper("Bilinear cell", aliases=("cell laboratory", "hyperbola", "shoulder point", "saddle", "asymptotes"))
def cell(
    model: Model | None = None,
    *,
    f00: float = 15.0,
    f10: float = 21.0,
    f01: float = 24.0,
    f11: float = 10.0,
    level: Annotated[float, Range(of="model.range")] = 17.6,
    row: Annotated[int, Range(low=0)] = 0,
    column: Annotated[int, Range(low=0)] = 0,
    around: Annotated[float, Range(0, 2)] = 0.25,
    at: tuple[float, ...] = (0.0, 0.0),
    named: str = "P Q R M T S",
) -> CellParts:
    """One bilinear cell: its contour as the exact hyperbola, and the points and lines that lead to the shoulder point.

    outline is the cell; hyperbola the contour within it, beyond the contour outside; asymptotes meet in the saddle S. For
    each arc, chords are P to Q, shoulders P to R to Q, tangents those at P and Q, parallels that at R, and medians run from
    the middle M of the chord through R to T, where the tangents meet, and on to S. points are these with their names,
    corners the corner values, and the table holds the numbers.

    Parameters
    ----------
    model : where the cell is taken from; without it the corner values make a cell of the size 1 by 1
    f00, f10, f01, f11 : corner values, the first digit along x, if no model is wired
    level : of the contour
    row, column : which cell of the model, from its lower left
    around : how much of the plane is drawn around the cell, in cells
    at : lower left corner of the cell, if no model is wired
    named : the points that are given, with spaces between: P, Q, R, M, T, S, and C for the centre

    Raises
    ------
    ValueError : a corner is a hole, the model has no such cell, or is not a linear one of the plane with one value a sample

    Accuracy: the construction is exact but for rounding, the drawn curve leaves the hyperbola by at most the sagitta of its
        pieces, which is proven. Errors of the model stay with the corner values, and end for all else.
    Source: Lopes 1999, 3.2 to 3.3 (figures 3.4, 3.5, 3.9); T as the shoulder point of an arc of twice the bend is ours.
    """
    known, frame, unit, here = _cell_of(model, (f00, f10, f01, f11), level, row, column, at)
    if not (np.isfinite(around) and around >= 0):
        raise ValueError(f"around must be 0 or more cells, not {around:g}")
    arcs = known.arcs()
    curves = [arc.curve() for arc in arcs]
    draw = _Drawing(frame, float(np.sqrt(known.size.prod())), _base(model, known))
    bent = [arc for arc in arcs if not arc.straight]
    box = np.array([known.place(u, v) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))])
    return CellParts(
        outline=draw.lines([box], "cell"),
        hyperbola=draw.lines([c for c, _ in curves], "contour", off=[s for _, s in curves]),
        beyond=draw.lines(known.beyond(around), "contour outside the cell"),
        asymptotes=draw.lines(_asymptotes(known, around), "asymptotes"),
        chords=draw.lines([np.stack([a.p, a.q]) for a in arcs], "chords"),
        shoulders=draw.lines([np.stack([a.p, a.shoulder, a.q]) for a in bent], "lines through the shoulder points"),
        tangents=draw.lines([np.stack([a.p, a.tangents_meet, a.q]) for a in bent], "tangents at P and Q"),
        parallels=draw.lines([_parallel(a) for a in bent], "tangents at R, parallel to the chords"),
        medians=draw.lines([_median(a, known, around) for a in bent], "from M through R and T to S"),
        points=_points(draw, _named(known, arcs, around), named),
        corners=_corners(draw, known, unit, here),
        table=_table(known, arcs, draw.accuracy),
    )


def _cell_of(
    model: Model | None, values: Sequence[float], level: float, row: int, column: int, at: Sequence[float]
) -> tuple[_cell.Cell, Frame, str, Accuracy]:
    """The cell, the frame it lies in, the unit of its values, and the accuracy of its corner values."""
    if model is None:
        if len(at) < 2:
            raise ValueError(f"at = {tuple(at)} should be x and y of the lower left corner")
        low = np.asarray(at[:2], float)
        return _cell.Cell(np.asarray(values, float), level, low, np.ones(2)), Frame(), "", Accuracy()
    grid = model.grid
    if grid.dimensions != 2 or not isinstance(grid, Regular | Rectilinear) or model.samples.components != 1:
        raise ValueError("a bilinear cell is one of a regular or rectilinear grid of the plane with one value a sample")
    if model.law.name != "linear":
        raise ValueError(f"the law between samples is {model.law.name}: choose law 'linear' in interpolate")
    rows, columns = (n - 1 for n in grid.shape)
    if not (0 <= row < rows and 0 <= column < columns):
        raise ValueError(f"no cell lies in row {row}, column {column}: the model has {rows} rows, {columns} columns")
    x, y = grid.axes
    corner = np.asarray(model.samples.values, float)[row : row + 2, column : column + 2].ravel()
    low, high = np.array([x[column], y[row]]), np.array([x[column + 1], y[row + 1]])
    first = row * (columns + 1) + column
    pick = select(np.array([first, first + 1, first + columns + 1, first + columns + 2]), grid.count)
    terms = tuple(t.push(pick) for t in model.accuracy.terms if t.place == "point")
    here = Accuracy(terms, model.accuracy.missing, (), model.accuracy.ended).end_from(model.accuracy, WHY)
    return _cell.Cell(corner, level, low, high - low), grid.frame, model.unit, here


def _base(model: Model | None, known: _cell.Cell) -> Accuracy:
    """What every part carries: the model's terms ended, and in words what is special about the cell."""
    base = Accuracy().flag(*[Flag(name, words) for name, words in remarks(known)])
    return base if model is None else base.end_from(model.accuracy, WHY).miss(*model.accuracy.missing)


def remarks(known: _cell.Cell) -> list[tuple[str, str]]:
    """What is special about a cell: name and sentence."""
    found = []
    on = [name for name, f in zip(("00", "10", "01", "11"), known.f, strict=True) if f == known.level]
    if len(on) == 4:
        found.append(("flat cell on the level", "all corners are on the level: the whole cell is contour, no line is drawn"))
    elif known.twist == 0:
        found.append(("linear cell", "c = 0: the contour is straight, there is no saddle and no shoulder point"))
    elif known.determinant == 0:
        found.append(("saddle on the level", "the contour is two lines that cross in S; they are joined as just below it"))
    if 0 < len(on) < 4:
        plural = "s" if len(on) > 1 else ""
        found.append((f"corner{plural} on the level", f"corner{plural} {', '.join(on)} on the level: counted as above it"))
    return found


class _Drawing:
    """Makes the parts of one cell, all with the same frame and the same accuracy."""

    def __init__(self, frame: Frame, size: float, accuracy: Accuracy) -> None:
        self.frame, self.size, self.accuracy = frame, size, accuracy
        self.id = exactly("Construction", "mapping", 0).id
        try:
            self.unit, self.known = frame.length_unit(2), True
        except ValueError:
            self.unit, self.known = "", False

    def lines(self, lines: Sequence[Floats], name: str, off: Sequence[float] = ()) -> Geometry:
        """Lines of a name; `off` is how far each may leave what it stands for."""
        sizes = [len(line) for line in lines]
        offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        points = points_of(np.concatenate([*lines, np.zeros((0, 2))]))
        accuracy = self.exact(len(points))
        if off and not self.known:
            accuracy = accuracy.flag(Flag("not measured", "the axes have different units: no distance is told"))
        elif off:
            far = np.repeat(np.asarray(off, float), sizes)
            accuracy = accuracy.add(Term(CURVE, "bound", "position", self.unit, far, Identity(len(far))))
        return Geometry(
            points=points,
            lines=Cells(offsets, np.arange(len(points))),
            cell=self.size,
            frame=self.frame,
            name=name,
            accuracy=accuracy,
        )

    def exact(self, n: int) -> Accuracy:
        """The accuracy of n constructed points."""
        term = exactly("Construction", "mapping", n, quantity="position", unit=self.unit, rule=RULE)
        return self.accuracy.add(replace(term, id=self.id))


def _asymptotes(known: _cell.Cell, around: float) -> list[Floats]:
    """The two lines on which F_x or F_y is 0, where they pass the window."""
    if known.saddle is None:
        return []
    low, high = known.low - around * known.size, known.high + around * known.size
    (x, y), _ = known.saddle
    found = []
    if low[0] <= x <= high[0]:
        found.append(np.array([[x, low[1]], [x, high[1]]]))
    if low[1] <= y <= high[1]:
        found.append(np.array([[low[0], y], [high[0], y]]))
    return found


def _parallel(arc: Arc) -> Floats:
    """Through R parallel to the chord, as long as it."""
    return np.stack([arc.p, arc.q]) + (arc.shoulder - arc.middle)


def _median(arc: Arc, known: _cell.Cell, around: float) -> Floats:
    """M, R, T, and S if the window shows it: they lie on one line (proposition 3.3.1.3)."""
    line = [arc.middle, arc.shoulder, arc.tangents_meet]
    saddle = known.saddle
    if saddle is not None and known.shows(saddle[0], around):
        line.append(saddle[0])
    return np.stack(line)


def _named(known: _cell.Cell, arcs: Sequence[Arc], around: float) -> list[tuple[str, str, Floats, Floats]]:
    """(name, role, place, direction in which there is room for the name)."""
    found: list[tuple[str, str, Floats, Floats]] = []
    for i, arc in enumerate(arcs):
        tail = _cell.SUBSCRIPTS[i + 1 if len(arcs) > 1 else 0]
        middle = known.place(0.5, 0.5)
        found += [(f"{name}{tail}", "crossing", at, at - middle) for name, at in (("P", arc.p), ("Q", arc.q))]
        if not arc.straight:
            inward = arc.middle - arc.tangents_meet
            found.append((f"R{tail}", "shoulder", arc.shoulder, inward + 0.8 * np.array([-inward[1], inward[0]])))
            found.append((f"M{tail}", "middle", arc.middle, inward))
            found.append((f"T{tail}", "tangents", arc.tangents_meet, -inward))
    saddle = known.saddle
    if saddle is not None and known.shows(saddle[0], around):
        found.append(("S", "saddle", saddle[0], np.array([1.0, -1.0])))
    return [*found, ("C", "centre", known.place(0.5, 0.5), np.array([1.0, 1.0]))]


ROLES = ("crossing", "shoulder", "middle", "tangents", "saddle", "centre")


def _points(draw: _Drawing, there: Sequence[tuple[str, str, Floats, Floats]], wanted: str) -> Geometry:
    letters = wanted.split()
    odd = [w for w in letters if w not in "PQRMTSC"]
    if odd:
        raise ValueError(f"there is no point {odd[0]!r} in a cell: points are P, Q, R, M, T, S and C, with spaces between")
    named = [one for one in there if one[0][0] in letters]
    at = points_of(np.array([p for _, _, p, _ in named]).reshape(-1, 2))
    return Geometry(
        points=at,
        vertices=Cells.of(np.arange(len(at))[:, None]),
        values={
            "name": Field(np.array([name for name, _, _, _ in named], dtype=str), "point"),
            "role": Field(np.array([ROLES.index(role) for _, role, _, _ in named], np.int64), "point"),
            "aside": Field(points_of(np.array([d for _, _, _, d in named]).reshape(-1, 2)), "point"),
        },
        cell=draw.size,
        frame=draw.frame,
        name="points of the construction",
        accuracy=draw.exact(len(at)),
    )


def _corners(draw: _Drawing, known: _cell.Cell, unit: str, here: Accuracy) -> Geometry:
    places = np.array([known.place(u, v) for v in (0, 1) for u in (0, 1)])
    side = ["above" if f >= known.level else "below" for f in known.f]
    words = [f"{f:.6g}, {which}".replace("-", "−") for f, which in zip(known.f, side, strict=True)]
    middle = known.place(0.5, 0.5)
    return Geometry(
        points=points_of(places),
        vertices=Cells.of(np.arange(4)[:, None]),
        values={
            "value": Field(known.corner, "point", unit),
            "above": Field((known.corner >= known.level).astype(np.int64), "point"),
            "name": Field(np.array(words, dtype=str), "point"),
            "aside": Field(points_of(places - middle), "point"),
        },
        cell=draw.size,
        frame=draw.frame,
        name="corner values",
        accuracy=here.flag(*draw.accuracy.flags),
    )


def _table(known: _cell.Cell, arcs: Sequence[Arc], accuracy: Accuracy) -> Table:
    """The numbers of the cell: name, x, y, number, and in words what it is."""
    none = np.full(2, np.nan)
    f00, f10, f01, _ = known.f
    rows = [
        ("a", none, f10 - f00, "coefficient of x on the unit square"),
        ("b", none, f01 - f00, "coefficient of y"),
        ("c", none, known.twist, "coefficient of xy"),
        ("d", none, f00 - known.level, "at the corner 00, less the level"),
        ("determinant", none, known.determinant, "c (F(S) − level); above 0 it joins 00 and 11 where four lines end"),
    ]
    if known.saddle is not None:
        rows.append(("S", known.saddle[0], known.saddle[1] - known.level, "saddle; value less the level"))
    for i, arc in enumerate(arcs):
        tail = _cell.SUBSCRIPTS[i + 1 if len(arcs) > 1 else 0]
        one, two = arc.areas()
        ends = "first end; number: bend of the arc", "last end; number: area that one chord leaves"
        rows += [(f"P{tail}", arc.p, arc.bend, ends[0]), (f"Q{tail}", arc.q, one, ends[1])]
        if not arc.straight:
            rows.append((f"R{tail}", arc.shoulder, two, "shoulder point; number: area that two chords leave"))
            rows.append((f"M{tail}", arc.middle, np.nan, "middle of the chord"))
            rows.append((f"T{tail}", arc.tangents_meet, np.nan, "where the tangents at P and Q meet"))
    rows += [("remark", none, np.nan, words) for _, words in remarks(known)]
    return Table(
        columns={
            "name": np.array([r[0] for r in rows], dtype=str),
            "x": np.array([r[1][0] for r in rows], float),
            "y": np.array([r[1][1] for r in rows], float),
            "number": np.array([r[2] for r in rows], float),
            "words": np.array([r[3] for r in rows], dtype=str),
        },
        name="bilinear cell",
        accuracy=accuracy.add(exactly("Construction", "mapping", len(rows), quantity="number", rule=RULE)),
    )
