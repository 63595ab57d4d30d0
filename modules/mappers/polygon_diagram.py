"""The polygons of one trilinear cell laid flat, as the diagrams of chapter 4 of the thesis are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Accuracy, Cells, Field, Geometry, Model, NamedTuple, Range, exactly, mapper
from modules.data.geometry import points_of
from modules.mappers._trilinear import CENTRE, CROSSING, cell_of, lattice, loops, told_apart

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WHY = "a diagram says which points are joined, not where they lie"
APART = 2.7
"""Between the middles of neighbouring diagrams, whose radius is 1."""


class Diagram(NamedTuple):
    """Edges and points of the diagrams by their colour."""

    edges_x: Geometry
    edges_y: Geometry
    edges_z: Geometry
    inside: Geometry
    marks_x: Geometry
    marks_y: Geometry
    marks_z: Geometry
    crossings: Geometry
    points_x: Geometry
    points_y: Geometry
    points_z: Geometry
    centres: Geometry
    names: Geometry


@mapper("Polygon diagram", aliases=("flat diagram", "cell laboratory", "triangulation", "extended polygon"))
def polygon_diagram(
    model: Model,
    *,
    level: Annotated[float, Range(of="model.range")] = 0.0,
    column: Annotated[int, Range(low=0)] = 0,
    row: Annotated[int, Range(low=0)] = 0,
    layer: Annotated[int, Range(low=0)] = 0,
) -> Diagram:
    """How each polygon of one trilinear cell is cut into triangles, flattened into a regular polygon.

    The boundary holds crossings and, between them, face shoulder points; its edges are of the axis across whose faces they
    lie. Inside are inflection points, of the axis whose slices they are of, or a bi-shoulder point. Small triangles stand at
    the shoulder points of loop-back faces, on which a polygon has four crossings. P 8/2 has eight crossings and two such
    faces; of opposite ones one is counted. Two polygons of a tunnel share their six inflection points.

    Parameters
    ----------
    model : linear, in space, with one value a sample
    level : of the surface
    column, row, layer : which cell of the model, along x, y and z

    Raises
    ------
    ValueError : a corner is a hole, the model has no such cell, or is not a linear one of space with one value a sample

    Accuracy: says which points are joined, exactly; it holds no places, so that the model's errors end here.
    Source: Lopes 1999, 4.2.2, figures 4.15 to 4.18, 4.25 and 4.30; points inside as the means of their neighbours, Tutte 1963.
    """
    f, _, _ = cell_of(model, (column, row, layer))
    f = f - level
    mesh = kernels.marching.surface(lattice(f), *[np.arange(2.0)] * 3, 0.0)
    kinds = told_apart(mesh.points, f)
    around = sorted(loops(mesh.triangles), key=lambda loop: (len(loop), loop))
    sheet = _Sheet(model, mesh.points, kinds)
    rim = {v for loop in around for v in loop}
    for n, loop in enumerate(around):
        sheet.add(loop[:-1], _part(mesh.triangles, loop, rim), APART * n)
    return sheet.drawn()


def _part(triangles: Ints, loop: list[int], rim: set[int]) -> Ints:
    """The triangles between a polygon's boundary and the points inside, up to where another polygon of a tunnel begins."""
    mine, others = set(loop), rim - set(loop)
    front, held = set(mine), np.zeros(len(triangles), bool)
    while True:
        touched = np.array([any(int(v) in front for v in t) and not any(int(v) in others for v in t) for t in triangles])
        if not (touched & ~held).any():
            return np.asarray(triangles[held])
        held |= touched
        front |= {int(v) for v in triangles[held].ravel()} - rim


class _Sheet:
    """Diagrams side by side."""

    def __init__(self, model: Model, points: Floats, kinds: Ints) -> None:
        self.model, self.points, self.kinds = model, points, kinds
        self.lines: dict[str, list[Floats]] = {name: [] for name in ("x", "y", "z", "inside")}
        self.marks: dict[str, list[Floats]] = {name: [] for name in "xyz"}
        self.dots: dict[int, list[Floats]] = {kind: [] for kind in range(5)}
        self.titles: list[tuple[Floats, str]] = []
        self.id = exactly("Construction", "mapping", 0).id

    def add(self, loop: list[int], triangles: Ints, middle: float) -> None:
        """The diagram of one polygon."""
        shift = np.array([middle, 0.0])
        at = {v: place + shift for v, place in _flat(loop, triangles).items()}
        faces = [self._face(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
        for (a, b), face in zip(zip(loop, loop[1:] + loop[:1], strict=True), faces, strict=True):
            self.lines["xyz"[face >> 1]].append(np.stack([at[a], at[b]]))
        rim = {frozenset(pair) for pair in zip(loop, loop[1:] + loop[:1], strict=True)}
        for pair in {frozenset((int(t[i]), int(t[i - 1]))) for t in triangles for i in range(3)} - rim:
            self.lines["inside"].append(np.stack([at[v] for v in sorted(pair)]))
        back = _loop_back(loop, faces, self.kinds)
        for n, v in enumerate(loop):
            if faces[n] in back and faces[n - 1] == faces[n] and self.kinds[v] != CROSSING:
                self.marks["xyz"[faces[n] >> 1]].append(_mark(at[v], shift))
        for v, place in at.items():
            self.dots[int(self.kinds[v])].append(place)
        crossings = sum(self.kinds[v] == CROSSING for v in loop)
        self.titles.append((np.array([middle - 0.74, 0.9]), f"P {crossings}/{len({face >> 1 for face in back})}"))

    def _face(self, a: int, b: int) -> int:
        """The face of the cell that an edge of the boundary lies on: 2 axis + side."""
        p, q = self.points[a], self.points[b]
        for axis in range(3):
            for side in (0, 1):
                if p[axis] == side == q[axis]:
                    return 2 * axis + side
        raise AssertionError("an edge of a polygon lies on no face of its cell")

    def drawn(self) -> Diagram:
        """All of it, colour by colour."""
        where, words = [t[0] for t in self.titles], np.array([t[1] for t in self.titles], dtype=str)
        edges = [self._lines(self.lines[name], f"edges on faces across {name}") for name in "xyz"]
        marks = [self._polygons(self.marks[name], f"loop-back faces across {name}") for name in "xyz"]
        points = [self._dots(self.dots[1 + axis], f"points of {name}") for axis, name in enumerate("xyz")]
        return Diagram(
            edges_x=edges[0],
            edges_y=edges[1],
            edges_z=edges[2],
            inside=self._lines(self.lines["inside"], "edges inside"),
            marks_x=marks[0],
            marks_y=marks[1],
            marks_z=marks[2],
            crossings=self._dots(self.dots[CROSSING], "crossings"),
            points_x=points[0],
            points_y=points[1],
            points_z=points[2],
            centres=self._dots(self.dots[CENTRE], "bi-shoulder points"),
            names=self._dots(where, "what the polygons are", {"name": Field(words, "point")}),
        )

    def _lines(self, lines: list[Floats], name: str) -> Geometry:
        return self._made(lines, name, lines=Cells.of(np.arange(2 * len(lines)).reshape(-1, 2)))

    def _polygons(self, corners: list[Floats], name: str) -> Geometry:
        return self._made(corners, name, polygons=Cells.of(np.arange(3 * len(corners)).reshape(-1, 3)))

    def _dots(self, places: list[Floats], name: str, values: dict[str, Field] | None = None) -> Geometry:
        each = Cells.of(np.arange(len(places))[:, None])
        return self._made([p[None] for p in places], name, vertices=each, values=values or {})

    def _made(self, parts: Iterable[Floats], name: str, **shape: object) -> Geometry:
        at = points_of(np.concatenate([*parts, np.zeros((0, 2))]))
        joined = exactly("Construction", "mapping", len(at), quantity="position", rule="which points are joined [diagram/1]")
        accuracy = Accuracy((joined.called(self.id),)).end_from(self.model.accuracy, WHY).miss(*self.model.accuracy.missing)
        return Geometry(points=at, name=name, accuracy=accuracy, **shape)  # type: ignore[arg-type]  # cells and values


def _flat(loop: list[int], triangles: Ints) -> dict[int, Floats]:
    """Boundary points evenly on a circle, crossings first at the top; each point inside is the mean of its neighbours."""
    turn = 2 * np.pi * np.arange(len(loop)) / len(loop)
    at: dict[int, Floats] = {v: np.array([np.sin(t), np.cos(t)]) for v, t in zip(loop, turn.tolist(), strict=True)}
    free = sorted({int(v) for v in triangles.ravel()} - set(loop))
    if not free:
        return at
    near: dict[int, set[int]] = {v: set() for v in free}
    for t in triangles.tolist():
        for i in range(3):
            if t[i] in near:
                near[t[i]] |= {t[i - 1], t[i - 2]}
    left, right = np.eye(len(free)), np.zeros((len(free), 2))
    for i, v in enumerate(free):
        for other in near[v]:
            if other in near:
                left[i, free.index(other)] -= 1 / len(near[v])
            else:
                right[i] += at[other] / len(near[v])
    at.update(zip(free, np.linalg.solve(left, right), strict=True))
    return at


def _loop_back(loop: list[int], faces: list[int], kinds: Ints) -> set[int]:
    """Faces on which the polygon runs twice: it has four crossings there."""
    runs = [face for n, face in enumerate(faces) if face != faces[n - 1] or kinds[loop[n]] == CROSSING]
    return {face for face in runs if runs.count(face) > 1}


def _mark(place: Floats, middle: Floats) -> Floats:
    """A small triangle outside the boundary that points at one of its points."""
    out = (place - middle) / np.linalg.norm(place - middle)
    side = np.array([-out[1], out[0]])
    return np.stack([place + 0.09 * out, place + 0.25 * out + 0.09 * side, place + 0.25 * out - 0.09 * side])
