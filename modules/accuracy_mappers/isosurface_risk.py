"""Where errors of the data may make an isosurface join otherwise, and where it may pass at all."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from modules import kernels
from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Gather,
    Geometry,
    Identity,
    Literal,
    Model,
    NamedTuple,
    Range,
    Rectilinear,
    Regular,
    Shown,
    Source,
    Table,
    Term,
    accuracy_mapper,
    exactly,
)
from modules.data.laws import second_derivative

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Grid3 = Regular | Rectilinear

VALID = 0.4
"""Largest kappa = error |F_nn| / slope^2 for which a band about the surface covers what it says."""

NAME = "Probability that errors decide otherwise"
RULES = {
    "faces": "normal law of the decider f00 f11 - f10 f01 through its derivatives, to first order [face-flip/1]",
    "tunnels": "normal law of the value at the body saddle, where the slope is 0, to first order [tunnel-flip/1]",
    "crossing": "each corner above with its own normal probability, errors of corners independent [level-crossing/1]",
}
WHY = "it is what the probabilities are made of"


class Risk(NamedTuple):
    """Places at risk with their probability, and how many there are of each kind."""

    places: Geometry
    table: Table


class _Found(NamedTuple):
    """Points (n, 3), the probability of each, and the grid cell of each."""

    at: Floats
    chance: Floats
    cell: Ints


@accuracy_mapper("Isosurface risk", aliases=("topology at risk", "flip probability", "level crossing probability", "tunnel"))
def isosurface_risk(
    model: Model,
    *,
    level: Annotated[float | None, Range(of="model.range")] = None,
    show: Literal["faces", "tunnels", "crossing"] = "faces",
    least: Annotated[float, Range(0, 0.5)] = 0.05,
) -> Risk:
    """Where the random errors of a field may change how its isosurface joins: faces, tunnels, and cells of little slope.

    faces: ambiguous faces, at their saddles, with the probability that noise joins them the other way. tunnels: body
    saddles of cells with more than one polygon, with the probability that noise opens or closes a tunnel. crossing: middles
    of cells where the slope is too small for the error (kappa above 0.4), so that no band about the surface holds; their
    probability is that the level passes the cell at all.

    Parameters
    ----------
    level : in the unit of the field; automatic: the middle of its range
    show : which places are given as points
    least : smaller probabilities are left out

    Raises
    ------
    ValueError : the model has no random errors, or is not a linear one of single values on a regular or rectilinear grid of
        three dimensions

    Accuracy: probabilities are to first order in the errors; those of crossings take the corners as independent. Errors that
        are bounds have no probability and do not count.
    Source: Pöthkow and Hege 2011 (level crossing); the first-order law of the decider, held against draws.
    """
    grid, values, level = _asked(model, level)
    random = Accuracy(tuple(t for t in model.samples.accuracy.select("value", "point") if t.kind in ("linear", "members")))
    if not random.terms:
        raise ValueError("the field has no random errors to take a probability from: state them with 'state accuracy'")
    known = kernels.cell_types.cells(values, level)
    found = {
        "faces": _faces(grid, values, known, random, level),
        "tunnels": _tunnels(model, grid, known, random, level),
        "crossing": _crossings(model, grid, values, random, level),
    }
    found = {name: _likely(one, least) for name, one in found.items()}
    base = Accuracy().end_from(model.accuracy, WHY).miss(*model.accuracy.missing)
    return Risk(_places(grid, found[show], show, base), _table(found, base))


def _asked(model: Model, level: float | None) -> tuple[Grid3, Floats, float]:
    grid = model.grid
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions != 3 or min(grid.shape) < 2:
        raise ValueError(f"risks are found on a regular or rectilinear grid of 3 dimensions, not on this {grid.kind} one")
    if model.samples.components != 1 or model.law.name != "linear":
        raise ValueError("risks are found for a linear model of one value a sample: choose law 'linear' and a component")
    values = np.ascontiguousarray(model.samples.values, dtype=float)
    finite = values[np.isfinite(values)]
    if level is None:
        level = float(finite.min() / 2 + finite.max() / 2) if len(finite) else 0.0
    return grid, values, level


def _likely(found: _Found, least: float) -> _Found:
    keep = found.chance >= least
    return _Found(found.at[keep], found.chance[keep], found.cell[keep])


def _chance(number: Floats, sigma: Floats) -> Floats:
    """Probability that a normal law about a number has the other sign."""
    return np.where(sigma > 0, ndtr(-np.abs(number) / np.where(sigma > 0, sigma, 1.0)), 0.0)


def _faces(grid: Grid3, values: Floats, known: Any, random: Accuracy, level: float) -> _Found:
    """Every ambiguous face once, at its saddle."""
    cases = kernels.marching_cases
    rows, cells = [np.zeros((0, 4), np.int64)], [np.zeros(0, np.int64)]
    for face in range(6):
        corner = cases.FACE_CORNERS[face]
        side = (known.active.code[:, None] >> corner) & 1
        hit = (side[:, 0] == side[:, 2]) & (side[:, 1] == side[:, 3]) & (side[:, 0] != side[:, 1])
        rows.append(known.active.node[hit][:, corner])
        cells.append(known.active.cell[hit])
    node, first = np.unique(np.concatenate(rows), axis=0, return_index=True)
    f = values.ravel()[node] - level
    number = f[:, 0] * f[:, 2] - f[:, 1] * f[:, 3]
    derivative = Gather(node, f[:, [2, 3, 0, 1]] * np.array([1.0, -1, 1, -1]), grid.count)
    sigma = random.push(derivative).total(1.0, "value") if len(node) else np.zeros(0)
    twist = f[:, 0] + f[:, 2] - f[:, 1] - f[:, 3]
    u, v = (f[:, 0] - f[:, 3]) / twist, (f[:, 0] - f[:, 1]) / twist
    p = [kernels.straight.place(node[:, n], values.shape, grid.axes) for n in (0, 1, 3)]
    at = p[0] + u[:, None] * (p[1] - p[0]) + v[:, None] * (p[2] - p[0])
    return _Found(at, _chance(number, sigma), np.concatenate(cells)[first])


def _tunnels(model: Model, grid: Grid3, known: Any, random: Accuracy, level: float) -> _Found:
    """Body saddles within cells that have several polygons, so that a side falls into parts on the cell's border."""
    types, tri = kernels.cell_types, kernels.trilinear
    code, faces = known.active.code, known.faces
    kind, which = np.unique(code * 64 + faces, return_inverse=True)
    several = np.array([len(kernels.straight.loops(k // 64, k % 64)) > 1 for k in kind.tolist()], bool)
    rows = np.flatnonzero(several[which.ravel()]) if len(kind) else np.zeros(0, np.int64)
    f = known.active.value[rows] - level
    saddle = tri.body_saddles(f)
    value = tri.value(f, saddle)
    parts = np.array([types.parts(c, j) for c, j in zip(code[rows].tolist(), faces[rows].tolist(), strict=True)]).reshape(-1, 2)
    row, n = np.nonzero(tri.inside(saddle) & (parts.max(axis=1, initial=0) > 1)[:, None])
    cell = known.active.cell[rows[row]]
    low, high = (kernels.straight.place(known.active.node[rows[row], c], grid.shape, grid.axes) for c in (0, 7))
    at = low + saddle[row, n] * (high - low)
    sigma = random.push(model.law.weights(grid, at)).total(1.0, "value") if len(at) else np.zeros(0)
    return _Found(at, _chance(value[row, n], sigma), cell)


def _crossings(model: Model, grid: Grid3, values: Floats, random: Accuracy, level: float) -> _Found:
    """Middles of cells without a valid band, with the probability that the level passes them."""
    spread = random.total(1.0, "value").reshape(values.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        up = np.where(spread > 0, ndtr((values - level) / np.where(spread > 0, spread, 1.0)), (values >= level).astype(float))
    window = np.lib.stride_tricks.sliding_window_view
    above = window(up, (2, 2, 2)).prod(axis=(3, 4, 5))
    below = window(1 - up, (2, 2, 2)).prod(axis=(3, 4, 5))
    chance = np.clip(1 - above - below, 0.0, 1.0)
    chance = np.where(np.isfinite(window(values, (2, 2, 2))).all(axis=(3, 4, 5)), chance, 0.0)
    cell = np.flatnonzero(chance.ravel() > 1e-3)
    row, i = np.divmod(cell, values.shape[2] - 1)
    k, j = np.divmod(row, values.shape[1] - 1)
    middle = [0.5 * (axis[1:] + axis[:-1]) for axis in grid.axes]
    at = np.column_stack([middle[0][i], middle[1][j], middle[2][k]])
    if not len(at):
        return _Found(at, np.zeros(0), cell)
    weights = model.law.weights(grid, at)
    steep = np.linalg.norm(model.gradient(at)[0], axis=1)
    bend = np.max([np.abs(np.nan_to_num(weights.apply(second_derivative(grid, values, a).ravel()))) for a in range(3)], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = weights.apply(spread.ravel()) * bend / steep**2
    bad = ~(kappa <= VALID)
    return _Found(at[bad], chance.ravel()[cell[bad]], cell[bad])


def _places(grid: Grid3, found: _Found, kind: str, base: Accuracy) -> Geometry:
    n = len(found.at)
    source = Source(NAME if kind != "crossing" else "Probability that the level passes", "data", "estimated", RULES[kind])
    term = Term(source, "metric", "probability", "", found.chance, Identity(n))
    exact = exactly("Places", "mapping", n, quantity="position", rule="saddles and middles of cells in closed form [places/1]")
    return Geometry(
        points=found.at,
        vertices=Cells.of(np.arange(n)[:, None]),
        values={"probability": Field(found.chance, "point"), "grid cell": Field(found.cell, "point")},
        shows=(Shown(source.name, "probability", "at each place"),),
        cell=float(np.prod([np.median(np.diff(a)) for a in grid.axes]) ** (1 / 3)),
        frame=grid.frame,
        name=f"risk: {kind}",
        accuracy=base.add(term, exact),
    )


def _table(found: dict[str, _Found], base: Accuracy) -> Table:
    """Number of places, the number expected to go otherwise, and the largest probability, of each kind."""
    chance = [one.chance for one in found.values()]
    source = Source(NAME, "data", "estimated", "; ".join(RULES.values()))
    term = Term(source, "metric", "expected", "", np.zeros(len(chance)), Identity(len(chance)))
    return Table(
        columns={
            "kind": np.array(list(found), dtype=str),
            "places": np.array([len(c) for c in chance], np.int64),
            "expected": np.array([c.sum() for c in chance]),
            "largest": np.array([c.max(initial=0.0) for c in chance]),
        },
        name="isosurface risk",
        accuracy=base.add(term),
    )
