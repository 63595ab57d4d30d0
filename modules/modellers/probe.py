"""A model looked at: at a point, along a line, over a plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Gather,
    Geometry,
    Literal,
    Model,
    NamedTuple,
    Position,
    Range,
    Table,
    Term,
    modeller,
)
from modules.data.operators import Floats, Operator
from modules.data.sampling import at_places

Corner = tuple[float, ...] | None

MOST = 4_000_000
INSET = 0.05
"""Part of the model that automatic ends of a line leave at each side."""
CELLS = "it speaks of cells, not of places"
WORDS = {"point": "at a point", "line": "along a line", "plane": "over a plane"}
NAMES = {1: [""], 3: ["x", "y", "z"], 9: [i + j for i in "xyz" for j in "xyz"]}


class Probe(NamedTuple):
    """What stands there, and the places with their values."""

    table: Table
    places: Geometry


@modeller("Probe", aliases=("sample at", "profile", "value at", "line plot", "cross section", "query", "pick", "transect"))
def probe(
    model: Model,
    *,
    shape: Literal["line", "point", "plane"] = "line",
    first: Annotated[tuple[float, ...] | None, Position(of="model")] = None,
    last: Annotated[tuple[float, ...] | None, Position(of="model")] = None,
    third: Annotated[tuple[float, ...] | None, Position(of="model")] = None,
    count: Annotated[int, Range(2, 2000, log=True)] = 200,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
) -> Probe:
    """Values of a model at a point, along a line or over a plane: a table with the error of each, and the places in space.

    The table has the way along the line (or the number of the place), coordinates, the value, its total error, the value less
    and more that error, and a column for each source. A view sets the places by a pick.

    Parameters
    ----------
    model : on a regular or rectilinear grid
    shape : point takes `first`; line goes from `first` to `last`; plane is the parallelogram of `first`, `last`, `third`
    first : x, y[, z]; automatic: near the lower corner of the model, its middle for a point
    last : x, y[, z]; automatic: near the upper corner of a line; for a plane along x from `first`
    third : x, y[, z] of the plane's third corner; automatic: along y, or along z of a plane that holds y
    count : places of a line, or along each side of a plane
    k : standard deviations that spreads count with in the columns of the total

    Raises
    ------
    ValueError : no place lies in the model, corners of the wrong length, or too many places

    Accuracy: errors of the samples go through the law's weights, what neighbours have in common is known, and the law adds its
    own with its sign. All terms go on in table and places, a row a place. Places outside have no value and are flagged.
    Source: Lopes 1999, 2.3.1; JCGM 101.
    """
    points, sides = _places(model, shape, first, last, third, count)
    values, known, inside = at_places(model, points)
    c = model.samples.components
    values = values.reshape(len(points), c)
    called = model.samples.name or "value"
    ended = Accuracy().end_from(replace(model.accuracy, of=None), CELLS)
    columns = _where(model, points, shape)
    units = {name: unit for name, unit in columns.units.items() if unit}
    terms: list[Term] = []
    table = dict(columns.values)
    for i, part in enumerate(NAMES[c]):
        name = _free(f"{called} {part}".strip(), table)
        own = Accuracy(tuple(_component(t, i, c) for t in known.terms))
        table[name] = values[:, i]
        table |= _sizes(own, name, values[:, i], inside, k)
        units |= {n: model.unit for n in table if n not in units and n not in columns.values and model.unit}
        terms += [replace(t, quantity=name) for t in own.terms]
    accuracy = Accuracy(tuple(terms), known.missing, known.flags, {**ended.ended, **known.ended})
    return Probe(
        Table(columns=table, units=units, name=f"{called} {WORDS[shape]}", accuracy=accuracy),
        _geometry(model, points, values, known, sides, called, ended),
    )


class Columns(NamedTuple):
    """Where the places are, as columns."""

    values: dict[str, Floats]
    units: dict[str, str]


def _where(model: Model, points: Floats, shape: str) -> Columns:
    frame, d = model.grid.frame, model.grid.dimensions
    first: dict[str, Floats] = {"place": np.arange(1.0, len(points) + 1)}
    units: dict[str, str] = {}
    if shape == "line" and len(set(frame.units[:d])) == 1:
        first = {"distance": np.linalg.norm(points - points[0], axis=1)}
        units = {"distance": frame.units[0]}
    names = {frame.axes[i]: points[:, i] for i in range(d)}
    return Columns(first | names, units | {frame.axes[i]: frame.units[i] for i in range(d)})


def _component(term: Term, i: int, c: int) -> Term:
    """The errors of one component."""
    if c == 1:
        return term
    n = term.operator.shape[0] // c
    operator: Operator = Gather(np.arange(n)[:, None] * c + i, np.asarray(1.0), n * c)
    return term.push(operator, components=1)


def _sizes(known: Accuracy, name: str, values: Floats, inside: NDArray[np.bool_], k: float) -> dict[str, Floats]:
    """The total, the band, and each source; sources of signed estimates keep their sign."""
    hole = ~inside | ~np.isfinite(values)
    total = np.where(hole, np.nan, known.total(k, "value"))
    if not known.terms:
        total = np.where(hole, np.nan, 0.0)
    found = {f"total error of {name}": total, f"{name} less error": values - total, f"{name} and error": values + total}
    for term in known.terms:
        size = np.where(hole, np.nan, term.error())
        found[_free(f"{term.name} of {name}" if name != "value" else term.name, found)] = size
    return found


def _free(name: str, taken: dict[str, Floats]) -> str:
    found, n = name, 2
    while found in taken:
        found, n = f"{name} ({n})", n + 1
    return found


def _geometry(
    model: Model, points: Floats, values: Floats, known: Accuracy, sides: tuple[int, ...], called: str, ended: Accuracy
) -> Geometry:
    n = len(points)
    nothing = Cells(np.zeros(1, np.int64), np.zeros(0, np.int64))
    vertices, lines, polygons = nothing, nothing, nothing
    if len(sides) == 0:
        vertices = Cells.of(np.arange(n)[:, None])
    elif len(sides) == 1:
        lines = Cells.of(np.arange(n)[None])
    else:
        at = np.arange(n).reshape(sides)
        polygons = Cells.of(np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]], axis=-1).reshape(-1, 4))
    fields = {called: Field(values[:, 0] if values.shape[1] == 1 else values[:, :3], "point", model.unit)}
    if values.shape[1] == 9:
        fields = {f"{called} {p}": Field(values[:, i], "point", model.unit) for i, p in enumerate(NAMES[9])}
    return Geometry(
        points=points, vertices=vertices, lines=lines, polygons=polygons, values=fields, frame=model.grid.frame,
        name=f"{called} probed", time=model.samples.time,
        accuracy=Accuracy(known.terms, known.missing, known.flags, {**ended.ended, **known.ended}),
    )  # fmt: skip


def _places(
    model: Model, shape: str, first: Corner, last: Corner, third: Corner, count: int
) -> tuple[Floats, tuple[int, ...]]:
    """(n, 3) places, and how many along each side."""
    bounds = np.reshape(model.grid.bounds, (3, 2))
    span = bounds[:, 1] - bounds[:, 0]
    if shape == "point":
        return _corner(model, "first", first, bounds.mean(axis=1))[None], ()
    if count < 2 or count ** (2 if shape == "plane" else 1) > MOST:
        raise ValueError(f"count = {count} should be from 2 to {MOST if shape == 'line' else int(MOST**0.5)}")
    a = _corner(model, "first", first, bounds[:, 0] + INSET * span)
    t = np.linspace(0, 1, count)
    if shape == "line":
        b = _corner(model, "last", last, bounds[:, 1] - INSET * span)
        if np.array_equal(a, b):
            raise ValueError("first and last are one place: a line needs two; shape 'point' looks at one")
        return a + t[:, None] * (b - a), (count,)
    far = bounds[:, 1] - INSET * span
    if first is None and model.grid.dimensions == 3:
        a[2] = bounds[2].mean()
    b = _corner(model, "last", last, np.array([far[0], a[1], a[2]]))
    c = _corner(model, "third", third, np.array([a[0], far[1], a[2]]))
    if np.linalg.norm(np.cross(b - a, c - a)) <= 1e-12 * np.linalg.norm(span) ** 2:
        raise ValueError("first, last and third lie on one line: a plane needs three corners that do not")
    return (a + t[None, :, None] * (b - a) + t[:, None, None] * (c - a)).reshape(-1, 3), (count, count)


def _corner(model: Model, name: str, given: Corner, automatic: Floats) -> Floats:
    if given is None:
        return np.array(automatic, float)
    d = model.grid.dimensions
    if len(given) not in (d, 3) or not np.isfinite(given).all():
        raise ValueError(f"{name} = {given} should be {d} finite coordinates")
    return np.array([*given[:3], *[0.0] * (3 - len(given))])
