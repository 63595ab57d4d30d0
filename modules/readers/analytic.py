"""Fields by a formula: data that is known exactly, to try a network on."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from typing import Annotated

import numpy as np

from modules.api import (
    Accuracy,
    Curvilinear,
    Flag,
    Frame,
    Grid,
    Literal,
    Range,
    Rectilinear,
    Samples,
    Term,
    Unstructured,
    deviation,
    exactly,
    reader,
    regular,
)
from modules.data.formula import Formula, FormulaError
from modules.data.grid import Regular
from modules.data.operators import Floats
from modules.readers._files import memory

AXES = ("x", "y", "z")


@reader("Analytic field", output="samples", aliases=("formula", "function", "test field"))
def analytic(
    *,
    formula: str = "sin(3 * x) * cos(2 * y)",
    low: tuple[float, ...] = (-1.0, -1.0),
    high: tuple[float, ...] = (1.0, 1.0),
    samples: tuple[int, ...] = (65, 65),
    grid: Literal["regular", "rectilinear", "curvilinear", "triangles"] = "regular",
    unit: str = "",
    lengths: str = "",
    name: str = "field",
    time: float | None = None,
    noise: Annotated[float, Range(0, 1)] = 0.0,
    seed: int = 1,
) -> Samples:
    """A field by a formula in x, y, z and t, on a grid of any of the four kinds.

    Parameters
    ----------
    formula : of x, y, z and t; two or three of them with ';' between make a vector field
    low : smallest x, y[, z] of the box, in `lengths`
    high : largest x, y[, z] of the box, in `lengths`
    samples : number of samples along x, y[, z]; how many numbers there are decides whether it is a line, a map or a volume
    grid : regular; rectilinear, denser towards the ends of each axis; curvilinear, an arch that fills the box, of a map or a
        volume; triangles, between samples of a map that are moved a little
    unit : of the values
    lengths : unit of the coordinates
    name : of the field
    time : value of t; automatic takes 0 and says nothing of time
    noise : standard deviation of Gaussian noise added to each sample, in `unit`
    seed : of the noise

    Accuracy: the samples are exact up to the rounding of float64; added noise is a term with the standard deviation
    that it was made with.
    """
    box = _grid(low, high, samples, lengths)
    where = _bent(box, grid)
    parts = [Formula.parse(one) for one in formula.split(";")] if formula.strip() else [Formula.parse(formula)]
    if len(parts) > 3:
        raise FormulaError(f"there are {len(parts)} formulas; a vector field has two or three, with ';' between")
    values, flags = _values(parts, where, 0.0 if time is None else time)
    made_of = (formula, low, high, samples, time, noise, seed, *([] if grid == "regular" else [grid]))
    content = sha256(repr(made_of).encode()).hexdigest()[:32]
    rows = values.size
    rule = "computed from its formula, up to the rounding of float64 (formula/1)"
    terms = [replace(exactly("Formula", "data", rows, unit=unit, rule=rule), id=f"formula-{content}/formula")]
    if noise < 0 or not np.isfinite(noise):
        raise ValueError(f"noise = {noise} must be 0 or more: it is a standard deviation")
    if noise:
        generator = np.random.default_rng([seed & 0xFFFFFFFF, int(content[:15], 16)])
        values = values + noise * generator.standard_normal(values.shape)
        rule = f"Gaussian noise of standard deviation {noise:g} was added, seed {seed} (added noise/1)"
        terms.append(deviation("Added noise", noise, rows, unit=unit, rigour="exact", rule=rule, id=f"formula-{content}/noise"))
    accuracy = Accuracy(tuple(_vector(terms, 3 if len(parts) > 1 else 1)), flags=flags)
    return Samples(grid=where, values=values, unit=unit, name=name, accuracy=accuracy, time=time)


def _grid(low: tuple[float, ...], high: tuple[float, ...], samples: tuple[int, ...], lengths: str) -> Regular:
    n = len(samples)
    if not 1 <= n <= 3 or min(samples) < 2:
        raise ValueError(f"samples {samples} should be one to three numbers, of 2 or more each")
    if len(low) < n or len(high) < n:
        raise ValueError(f"low {low} and high {high} should have {n} numbers, as samples has")
    spans = [b - a for a, b in zip(low, high, strict=False)][:n]
    if not all(np.isfinite(s) and s > 0 for s in spans):
        raise ValueError(f"each number of high {high} should be larger than that of low {low}")
    if np.prod(samples, dtype=float) * 8 > memory() / 2:
        raise ValueError(f"{' x '.join(map(str, samples))} samples take more than half of the memory: use fewer")
    spacing = [s / (k - 1) for s, k in zip(spans, samples, strict=True)]
    return regular(tuple(reversed(samples)), spacing, low[:n], Frame(units=(lengths,) * 3))


def _bent(box: Regular, kind: str) -> Grid:
    """The grid of a kind that fills the box of a regular one, of as many samples."""
    if kind == "regular":
        return box
    if kind == "rectilinear":
        return Rectilinear(tuple(_graded(a) for a in box.axes), frame=box.frame)
    if box.dimensions < 2 or (kind == "triangles" and box.dimensions > 2):
        what = "two numbers of samples" if kind == "triangles" else "two or three numbers of samples"
        raise ValueError(f"a grid of kind {kind} needs {what}, not {len(box.shape)}")
    return _arch(box) if kind == "curvilinear" else _triangles(box)


def _graded(axis: Floats) -> Floats:
    """Coordinates with the same ends, denser towards these."""
    s = np.linspace(0, 1, len(axis))
    graded: Floats = axis[0] + (axis[-1] - axis[0]) * (s - 0.75 / (2 * np.pi) * np.sin(2 * np.pi * s))
    graded[-1] = axis[-1]
    return graded


def _arch(box: Regular) -> Curvilinear:
    """Half an elliptic ring over the lower side of the box; x runs along it, y outwards, z stays."""
    points = box.points().reshape(*box.shape, 3)
    (x0, x1, y0, y1), nodes = box.bounds[:4], points.copy()
    turn = np.pi * (x1 - points[..., 0]) / (x1 - x0)
    reach = 0.4 + 0.6 * (points[..., 1] - y0) / (y1 - y0)
    nodes[..., 0] = (x0 + x1) / 2 + (x1 - x0) / 2 * reach * np.cos(turn)
    nodes[..., 1] = y0 + (y1 - y0) * reach * np.sin(turn)
    return Curvilinear(nodes=nodes, frame=box.frame)


def _triangles(box: Regular) -> Unstructured:
    """The samples moved by up to 0.35 of a step within the box, always the same, and Delaunay's triangles between them."""
    from scipy.spatial import Delaunay

    points = box.points()
    step = np.array(box.spacing)
    moved = (points[:, :2] - box.origin) / step
    free = (moved > 0.5) & (moved < np.array(box.shape[::-1]) - 1.5)
    moved = moved + np.where(free, np.random.default_rng(1).uniform(-0.35, 0.35, moved.shape), 0.0)
    points[:, :2] = box.origin + moved * step
    cells = np.asarray(Delaunay(moved).simplices, np.int64)
    p, q, r = (moved[cells[:, k]] for k in range(3))
    area = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0]
    cells[area < 0] = cells[area < 0][:, ::-1]
    cells = cells[np.abs(area) > 1e-9]
    m = len(cells)
    return Unstructured(
        nodes=points,
        offsets=3 * np.arange(m + 1),
        connectivity=cells.ravel(),
        types=np.full(m, 5, np.int64),
        frame=box.frame,
    )


def _values(parts: list[Formula], grid: Grid, time: float) -> tuple[Floats, tuple[Flag, ...]]:
    """(grid.shape) or (grid.shape, 3) values, and a flag where a formula has no number."""
    mesh: list[Floats] = [np.zeros(()), np.zeros(()), np.zeros(())]
    if isinstance(grid, Regular | Rectilinear):
        for axis, coordinates in enumerate(grid.axes):
            mesh[axis] = coordinates.reshape([-1 if axis == k else 1 for k in reversed(range(len(grid.axes)))])
    else:
        mesh = [c.reshape(grid.shape) for c in grid.points().T]
    given = {**dict(zip(AXES, mesh, strict=True)), "t": np.asarray(time)}
    fields = [np.broadcast_to(part.value(given), grid.shape) for part in parts]
    if len(fields) > 1:
        fields += [np.zeros(grid.shape)] * (3 - len(fields))
        values = np.stack(fields, axis=-1)
    else:
        values = fields[0].copy()
    wrong = ~np.isfinite(values) if len(parts) == 1 else ~np.isfinite(values).all(axis=-1)
    if not wrong.any():
        return values, ()
    where = np.flatnonzero(wrong)
    first = ", ".join(f"{a} = {v:g}" for a, v in zip(AXES, grid.points()[where[0]], strict=True))
    sentence = f"the formula has no finite number at {len(where)} of {grid.count} samples, first at {first}"
    if len(where) == grid.count:
        raise FormulaError(f"{sentence}: look for a division by 0, or a root or logarithm of a negative number")
    values[wrong] = np.nan
    return values, (Flag("no number", f"{sentence}; they are holes", "point", where),)


def _vector(terms: list[Term], components: int) -> list[Term]:
    return [replace(term, components=components) for term in terms]
