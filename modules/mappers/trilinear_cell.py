"""A laboratory of one trilinear cell: all that chapter 4 of the thesis constructs in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Geometry,
    Identity,
    Literal,
    Model,
    NamedTuple,
    Range,
    Source,
    Table,
    Term,
    exactly,
    mapper,
)
from modules.mappers import _cell
from modules.mappers._trilinear import cell_of, lattice, loops, told_apart

Floats = NDArray[np.float64]

RULE = "closed forms of the trilinear cell; Lopes 1999, 4.2.1 [trilinear-construction/1]"
WHY = "the construction is that of the cell as its corner values are given"
BETWEEN = Source(
    "Chords of the drawn curve", "mapping", "estimated", "an eighth of the second difference of its points [curve-by-points/1]"
)
SLOPES = 24
"""Pieces along each axis of the surfaces on which a derivative is 0."""

STEPS = 96
"""Slices on which shoulder points are sought for a locus."""

AXES = ("x", "y", "z")


class SolidParts(NamedTuple):
    """The cell and what is constructed in it, each to be drawn in a look of its own."""

    outline: Geometry
    polygons: Geometry
    slices: Geometry
    hexagon: Geometry
    lines: Geometry
    slope_x: Geometry
    slope_y: Geometry
    slope_z: Geometry
    locus_x: Geometry
    locus_y: Geometry
    locus_z: Geometry
    crossings: Geometry
    points_x: Geometry
    points_y: Geometry
    points_z: Geometry
    centres: Geometry
    saddles: Geometry
    corners: Geometry
    table: Table


@mapper("Trilinear cell", aliases=("cell laboratory", "body saddle", "inflection points", "bi-shoulder", "slices", "tunnel"))
def trilinear_cell(
    model: Model,
    *,
    level: Annotated[float, Range(of="model.range")] = 0.0,
    column: Annotated[int, Range(low=0)] = 0,
    row: Annotated[int, Range(low=0)] = 0,
    layer: Annotated[int, Range(low=0)] = 0,
    across: Literal["x", "y", "z"] = "z",
    slices: Annotated[int, Range(0, 40)] = 9,
) -> SolidParts:
    """One trilinear cell: its surface's polygons, the points that the accurate method adds, and what leads to them.

    outline is the cell; polygons run through crossings and face shoulder points; slices are contours across an axis;
    hexagon joins the six inflection points and lies on the surface, as do the straight lines through it. On slope x the
    derivative along x is 0. Locus x holds the shoulder points of all slices across x. crossings lie on edges, points x are
    face shoulders on the faces across x and inflection points Ix, centres are bi-shoulder points, saddles body saddles
    within the cell, corners the corner values; the table holds the numbers.

    Parameters
    ----------
    level : of the surface
    column, row, layer : which cell of the model, along x, y and z
    across : the axis of the slices
    slices : how many, evenly spaced

    Raises
    ------
    ValueError : a corner is a hole, the model has no such cell, or is not a linear one of space with one value a sample

    Accuracy: points are exact but for rounding; of curves and of surfaces of no slope the distance between their points is
        estimated. Errors of the model end here.
    Source: Lopes 1999, 4.2.1 and 4.2.2 (figures 4.5 to 4.34), misprints put right.
    """
    f, low, size = cell_of(model, (column, row, layer))
    f = f - level
    draw = _Drawing(model, low, size)
    mesh = kernels.marching.surface(lattice(f), *[np.arange(2.0)] * 3, 0.0)
    kinds = told_apart(mesh.points, f)
    corner = np.array([[c >> 2, c >> 1 & 1, c & 1] for c in range(8)], float)
    saddle = kernels.trilinear.body_saddles(f[None])[0]
    saddle = saddle[kernels.trilinear.inside(saddle)]
    six = kernels.trilinear.hexagon(f[None])[0] if kernels.trilinear.inner_inflections(f[None]).all() else np.zeros((0, 3))
    slopes = [draw.surface(_slope(f, axis), f"where the derivative along {AXES[axis]} is 0") for axis in range(3)]
    loci = [draw.lines(_locus(f, axis), f"shoulder points of slices across {AXES[axis]}", True) for axis in range(3)]
    told = [draw.points(mesh.points[kinds == 1 + axis], f"points of {AXES[axis]}") for axis in range(3)]
    cuts = (np.arange(slices) + 0.5) / max(slices, 1)
    return SolidParts(
        outline=draw.lines([corner[list(pair)] for pair in kernels.marching_cases.EDGE_ENDS.tolist()], "cell"),
        polygons=draw.lines([mesh.points[loop] for loop in loops(mesh.triangles)], "topological polygons"),
        slices=draw.lines(_slices(f, AXES.index(across), cuts), f"contours of slices across {across}", True),
        hexagon=draw.lines([np.vstack([six, six[:1]])] if len(six) else [], "inflection points in cyclic order"),
        lines=draw.lines(_straight(six), "straight lines of the surface"),
        slope_x=slopes[0],
        slope_y=slopes[1],
        slope_z=slopes[2],
        locus_x=loci[0],
        locus_y=loci[1],
        locus_z=loci[2],
        crossings=draw.points(mesh.points[kinds == 0], "crossings"),
        points_x=told[0],
        points_y=told[1],
        points_z=told[2],
        centres=draw.points(mesh.points[kinds == 4], "bi-shoulder points"),
        saddles=draw.points(saddle, "body saddles"),
        corners=draw.named(corner, f + level, level),
        table=_table(draw, f, mesh.points, kinds),
    )


def _face(f: Floats, axis: int, t: float) -> Floats:
    """(4,) F00, F10, F01, F11 of a slice across an axis, in the order of the two others."""
    g = np.moveaxis(f.reshape(2, 2, 2), axis, 0)
    h = (1 - t) * g[0] + t * g[1]
    return np.array([h[0, 0], h[1, 0], h[0, 1], h[1, 1]])


def _arcs(f: Floats, axis: int, t: float) -> list[_cell.Arc]:
    return _cell.Cell(_face(f, axis, t), 0.0, np.zeros(2), np.ones(2)).arcs()


def _put(flat: Floats, axis: int, t: float) -> Floats:
    """(k, 2) places of a slice as (k, 3) places of the cell."""
    return np.insert(flat, axis, t, axis=1)


def _slices(f: Floats, axis: int, cuts: Floats) -> list[Floats]:
    return [_put(arc.curve()[0][::4], axis, t) for t in cuts.tolist() for arc in _arcs(f, axis, t)]


def _locus(f: Floats, axis: int) -> list[Floats]:
    """The shoulder points of the slices across an axis, joined while they follow on each other."""
    lines: list[list[Floats]] = []
    open_ends: list[int] = []
    for t in np.linspace(1e-6, 1 - 1e-6, STEPS).tolist():
        here = [_put(arc.shoulder[None], axis, t)[0] for arc in _arcs(f, axis, t)]
        still: list[int] = []
        for point in here:
            near = min(open_ends, key=lambda n: float(np.linalg.norm(lines[n][-1] - point)), default=-1)
            if near >= 0 and np.linalg.norm(lines[near][-1] - point) < 0.15:
                open_ends.remove(near)
                lines[near].append(point)
                still.append(near)
            else:
                lines.append([point])
                still.append(len(lines) - 1)
        open_ends = still
    return [np.array(line) for line in lines if len(line) > 1]


def _straight(six: Floats) -> list[Floats]:
    """The six lines of the surface through the hexagon, from face to face."""
    found = []
    for one, two in zip(six, np.roll(six, -1, axis=0), strict=True):
        axis = int(np.argmax(np.abs(two - one)))
        line = np.stack([one, one])
        line[:, axis] = [0.0, 1.0]
        found.append(line)
    return found


def _slope(f: Floats, axis: int) -> Floats:
    """The corner values of the derivative along an axis: it is the same at both ends of that axis."""
    g = np.moveaxis(f.reshape(2, 2, 2), axis, 0)
    return np.moveaxis(np.stack([g[1] - g[0]] * 2), 0, axis).ravel()


class _Drawing:
    """Makes the parts of one cell, in the place of the cell and with the same accuracy."""

    def __init__(self, model: Model, low: Floats, size: Floats) -> None:
        self.model, self.low, self.size = model, low, size
        self.base = Accuracy().end_from(model.accuracy, WHY).miss(*model.accuracy.missing)
        self.unit = model.grid.frame.length_unit(3)
        self.id = exactly("Construction", "mapping", 0).id

    def exact(self, n: int) -> Accuracy:
        """The accuracy of n constructed points."""
        term = exactly("Construction", "mapping", n, quantity="position", unit=self.unit, rule=RULE)
        return self.base.add(term.called(self.id))

    def points(self, at: Floats, name: str) -> Geometry:
        """Points of a name, given in the unit cell."""
        return self._made(at, name, vertices=Cells.of(np.arange(len(at))[:, None]))

    def lines(self, lines: Sequence[Floats], name: str, curved: bool = False) -> Geometry:
        """Lines of a name, given in the unit cell."""
        at = np.concatenate([*lines, np.zeros((0, 3))])
        offsets = np.concatenate([[0], np.cumsum([len(line) for line in lines])]).astype(np.int64)
        off = np.concatenate([_sagitta(line * self.size) for line in lines] or [np.zeros(0)]) if curved else None
        return self._made(at, name, off, lines=Cells(offsets, np.arange(len(at))))

    def surface(self, f: Floats, name: str) -> Geometry:
        """The surface on which a trilinear polynomial is 0, in many pieces."""
        axis = np.arange(2.0)
        points, triangles, _ = kernels.cubes.subdivided(lattice(f), axis, axis, axis, 0.0, SLOPES)
        off = np.full(len(points), float(np.linalg.norm(self.size)) / SLOPES**2)
        return self._made(points, name, off, polygons=Cells.of(triangles))

    def named(self, at: Floats, values: Floats, level: float) -> Geometry:
        """The corners with their values."""
        side = ["above" if value >= level else "below" for value in values]
        words = [f"{v:.6g}, {which}".replace("-", "−") for v, which in zip(values, side, strict=True)]
        made = {
            "value": Field(values, "point", self.model.unit),
            "above": Field((values >= level).astype(np.int64), "point"),
            "name": Field(np.array(words, dtype=str), "point"),
        }
        return self._made(at, "corner values", vertices=Cells.of(np.arange(8)[:, None]), values=made)

    def _made(
        self, at: Floats, name: str, off: Floats | None = None, *, vertices: Cells | None = None, lines: Cells | None = None,
        polygons: Cells | None = None, values: dict[str, Field] | None = None,
    ) -> Geometry:
        none = Cells.of([])
        accuracy = self.exact(len(at))
        if off is not None:
            accuracy = accuracy.add(Term(BETWEEN, "bound", "position", self.unit, off, Identity(len(off))))
        return Geometry(
            points=self.low + at * self.size,
            vertices=vertices or none,
            lines=lines or none,
            polygons=polygons or none,
            values=values or {},
            cell=float(np.cbrt(self.size.prod())),
            frame=self.model.grid.frame,
            name=name,
            accuracy=accuracy,
        )


def _sagitta(line: Floats) -> Floats:
    """(k,) an eighth of the second difference at each point of a curve, that of its neighbour at the ends."""
    if len(line) < 3:
        return np.zeros(len(line))
    inner = np.linalg.norm(line[2:] - 2 * line[1:-1] + line[:-2], axis=1) / 8
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _table(draw: _Drawing, f: Floats, points: Floats, kinds: NDArray[np.int64]) -> Table:
    """The numbers of the cell: name, x, y, z, number, and in words what it is."""
    tri, none = kernels.trilinear, np.full(3, np.nan)
    words = ("constant", "of x", "of y", "of z", "of xy", "of xz", "of yz", "of xyz")
    names = ("a", "e", "c", "b", "g", "f", "d", "h")
    number = dict(zip("abcdefgh", tri.coefficients(f[None])[0].tolist(), strict=True))
    rows = [(name, none, number[name], f"coefficient, {which}") for name, which in zip(names, words, strict=True)]
    rows.append(("discriminant", none, float(tri.discriminant(f[None])[0]), "below 0 there are no inflection points"))
    bend = tri.inflections(f[None])[0]
    for axis, n in ((a, n) for a in range(3) for n in range(2)):
        if np.isfinite(bend[axis, n]).all():
            where = "within the cell" if tri.inside(bend[axis, n]) else "outside the cell"
            rows.append((f"I{AXES[axis]}{n + 1}", bend[axis, n], 0.0, f"inflection point, {where}"))
    saddle = tri.body_saddles(f[None])[0]
    at = tri.value(f[None], saddle[None])[0]
    for m in np.flatnonzero(np.isfinite(saddle).all(axis=1)).tolist():
        where = "within the cell" if tri.inside(saddle[m]) else "outside the cell"
        rows.append((f"B{m + 1}", saddle[m], float(at[m]), f"body saddle, {where}; value less the level"))
    for kind, name in ((0, "crossing"), (1, "of x"), (2, "of y"), (3, "of z"), (4, "bi-shoulder point")):
        title = name if kind in (0, 4) else f"face shoulder or inflection point {name}"
        rows += [(f"V{v}", points[v], 0.0, title) for v in np.flatnonzero(kinds == kind).tolist()]
    place = draw.low + np.array([r[1] for r in rows]) * draw.size
    columns = {
        "name": np.array([r[0] for r in rows], dtype=str),
        **{axis: place[:, n] for n, axis in enumerate(AXES)},
        "number": np.array([r[2] for r in rows], float),
        "words": np.array([r[3] for r in rows], dtype=str),
    }
    exact = exactly("Construction", "mapping", len(rows), quantity="number", rule=RULE)
    return Table(columns=columns, name="trilinear cell", accuracy=draw.base.add(exact))
