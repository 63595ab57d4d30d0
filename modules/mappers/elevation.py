"""The field as a surface over the plane (thesis 2.4.3, surface displacement)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Gather,
    Geometry,
    Identity,
    Model,
    Range,
    Rectilinear,
    Regular,
    Source,
    Term,
    mapper,
    select,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@mapper("Elevation surface", aliases=("displacement", "terrain", "relief", "height field", "mesh"), output="surface")
def elevation(model: Model, colour: Model | None = None, *, scale: Annotated[float, Range(0, 10)] = 1.0) -> Geometry:
    """The field as a surface z = scale * F over its plane.

    Parameters
    ----------
    colour : another field over the same plane, whose values the points of the surface get by its name
    scale : height of one unit of the field, in units of the plane

    Raises
    ------
    ValueError : the model is not two-dimensional or not scalar, or the other field does not cover its plane

    Accuracy: an error of the model lifts the surface by scale times it; a cell drawn as two triangles leaves the bilinear
        surface by at most a quarter of its twist, which is proven. Errors of the other field go on as errors of its values.
    Source: Lopes 1999, 2.4.3.
    """
    grid = model.grid
    if grid.dimensions != 2 or not isinstance(grid, Regular | Rectilinear) or model.samples.components != 1:
        raise ValueError("an elevation surface needs one value a sample on a two-dimensional regular or rectilinear grid")
    values = np.asarray(model.samples.values, float)
    unit = grid.frame.units[2] or model.unit
    solid, quads = _quads(values)
    node = np.flatnonzero(np.isfinite(values).ravel())
    renumber = np.zeros(values.size, np.int64)
    renumber[node] = np.arange(len(node))
    points = grid.points()[node]
    points[:, 2] = scale * values.ravel()[node]
    cells = np.flatnonzero(solid.ravel())
    values_there = {model.samples.name or "height": Field(values.ravel()[node], "point", model.unit)}
    accuracy = _accuracy(model, node, cells, scale, unit).add(_twist(values, solid, scale, unit))
    if colour is not None:
        field, known = _coloured(model, colour, node)
        values_there[_other_name(model, colour)] = field
        accuracy = Accuracy.join([(accuracy, None), (known, None)])
    return Geometry(
        points=points,
        polygons=Cells.of(renumber[quads]),
        values=values_there,
        origin=cells,
        cell=float(np.sqrt(np.median(np.diff(grid.axes[0])) * np.median(np.diff(grid.axes[1])))),
        frame=grid.frame,
        name=model.samples.name,
        time=model.samples.time,
        accuracy=accuracy,
    )


def _quads(values: Floats) -> tuple[NDArray[np.bool_], Ints]:
    """Which cells have four finite corners, and the nodes of those, in order round the cell."""
    finite = np.isfinite(values)
    solid = finite[:-1, :-1] & finite[:-1, 1:] & finite[1:, 1:] & finite[1:, :-1]
    index = np.arange(values.size).reshape(values.shape)
    corners = (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1])
    return solid, np.column_stack([c[solid] for c in corners])


def _accuracy(model: Model, node: Ints, cells: Ints, scale: float, unit: str) -> Accuracy:
    """The model's terms on the points and cells that are drawn, as heights."""
    at_nodes, at_cells = select(node, model.grid.count), select(cells, model.grid.cells)
    factor = np.asarray(float(scale))
    terms = tuple(
        t.push(Gather(s.index, factor, s.n_in), quantity="position", unit=unit)
        for t in model.accuracy.terms
        for s in ((at_nodes if t.place == "point" else at_cells),)
    )
    return Accuracy(terms, model.accuracy.missing, (), model.accuracy.ended)


def _coloured(model: Model, colour: Model, node: Ints) -> tuple[Field, Accuracy]:
    """The other field at the nodes that are drawn, and what is known of it there."""
    if colour.grid.dimensions != 2:
        raise ValueError(f"the field for the colour has {colour.grid.dimensions} dimensions: take a slice")
    if colour.grid.frame != model.grid.frame:
        raise ValueError("the field for the colour lies in another frame than the surface: bring both to one")
    found, known = colour.at(model.grid.points()[node])
    return Field(found, "point", colour.unit), known


def _other_name(model: Model, colour: Model) -> str:
    """The name of the other field's values; with a word more where the heights have it already."""
    name = colour.samples.name or "colour"
    return f"{name} (colour)" if name == (model.samples.name or "height") else name


def _twist(values: Floats, solid: NDArray[np.bool_], scale: float, unit: str) -> Term:
    twist = np.abs(values[:-1, :-1] + values[1:, 1:] - values[:-1, 1:] - values[1:, :-1])[solid]
    rule = "a quarter of |f00 + f11 - f01 - f10| [quad-twist/1]"
    source = Source("Two triangles a cell", "mapping", "proven", rule)
    return Term(source, "bound", "position", unit, abs(scale) / 4 * twist, Identity(len(twist)), "cell")
