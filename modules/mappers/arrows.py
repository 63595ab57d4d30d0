"""Vectors as lines, arrows or cones at their samples (thesis 2.5.1 and figure 2.10)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    EXACT,
    Accuracy,
    Annotated,
    Cells,
    Curvilinear,
    Field,
    Geometry,
    Literal,
    Range,
    Rectilinear,
    Regular,
    Samples,
    mapper,
    select,
)
from modules.data import sweep
from modules.data.operators import Floats

Ints = NDArray[np.int64]

MOST = 500_000
"""More glyphs are refused: no picture shows them."""
LONG = 1.4
"""Automatic scale: the longest glyph, as a multiple of the distance between those that are drawn."""
BARB = 0.28
"""Length of the barbs of an arrow, as a part of it."""
THICK = 0.16
"""Radius of a cone at its foot, as a part of the distance between cones. It is the same for all: length alone tells."""


@mapper("Arrows", aliases=("hedgehog", "vectors", "glyphs", "quiver", "cones", "icons"), output="arrows")
def arrows(
    samples: Samples,
    *,
    shape: Literal["line", "arrow", "cone"] = "arrow",
    stride: Annotated[int, Range(1, 32)] = 1,
    scale: Annotated[float | None, Range(low=0)] = None,
    least: Annotated[float, Range(0, 1)] = 0.0,
    sides: Annotated[int, Range(3, 32)] = 10,
) -> Geometry:
    """A line from every sample along its vector, bare, with a barbed tip, or as a cone; true to scale in length alone.

    Parameters
    ----------
    samples : vectors on any grid
    shape : line (hedgehog) and arrow give lines, cone gives polygons of one thickness
    stride : at every so-many-th sample along each axis; on an unstructured grid of all
    scale : length that stands for one unit of the vectors; automatic: the longest is 1.4 times the distance between glyphs
    least : glyphs shorter than this part of the longest are left out
    sides : of each cone

    Raises
    ------
    ValueError : the samples are no vectors, a scale that is not above zero, or too many glyphs

    Accuracy: errors of the vectors go on, a row a point of the glyph; they move its tip by scale times their size. Size is
        shown by length only: what is drawn as an area or a volume reads as its square or cube.
    Source: Lopes 1999, 2.5.1.
    """
    if samples.components != 3:
        raise ValueError("arrows show vectors: wire samples of two or three components")
    if stride < 1:
        raise ValueError(f"stride must be at least 1, not {stride}")
    kept, apart = _kept(samples, stride)
    vectors = np.asarray(samples.values, float).reshape(-1, 3)[kept]
    speed = np.linalg.norm(vectors, axis=1)
    longest = float(np.nanmax(speed, initial=0.0))
    drawn = np.isfinite(speed) & (speed > 0) & (speed >= least * longest)
    kept, vectors, speed = kept[drawn], vectors[drawn], speed[drawn]
    if len(kept) > MOST:
        raise ValueError(f"{len(kept)} arrows are too many: at most {MOST}; a larger 'stride' draws fewer")
    factor = scale if scale is not None else _round(LONG * apart / longest if longest > 0 else 1.0)
    if not (factor > 0 and math.isfinite(factor)):
        raise ValueError(f"scale = {factor:g} draws nothing: give a length above zero")
    at = samples.grid.points()[kept]
    glyphs = _cones(at, factor * vectors, THICK * apart, sides) if shape == "cone" else _lines(at, factor * vectors, shape)
    rows = np.repeat(kept, len(glyphs.points) // max(1, len(kept)))
    cells = glyphs.counts["cell"] // max(1, len(kept))
    three = (rows[:, None] * 3 + np.arange(3)).ravel()
    points = samples.accuracy.select(place="point")
    accuracy = Accuracy(
        tuple(t.push(select(three, 3 * t.count)) for t in points), samples.accuracy.missing, (), samples.accuracy.ended
    )
    return Geometry(
        points=glyphs.points,
        lines=glyphs.lines,
        polygons=glyphs.polygons,
        values={"size": Field(np.repeat(speed, cells), "cell", samples.unit)},
        origin=np.repeat(kept, cells),
        cell=apart / stride,
        frame=samples.grid.frame,
        name=_name(samples, factor),
        time=samples.time,
        accuracy=accuracy.end_from(samples.accuracy, "arrows stand for samples; this speaks of cells"),
    )


def _kept(samples: Samples, stride: int) -> tuple[Ints, float]:
    """(n,) the samples that get a glyph, and a typical distance between them."""
    grid = samples.grid
    index = np.arange(grid.count, dtype=np.int64)
    if isinstance(grid, Regular | Rectilinear | Curvilinear):
        index = index.reshape(grid.shape)[(slice(None, None, stride),) * len(grid.shape)]
    else:
        index = index[::stride]
    bounds = np.asarray(grid.bounds).reshape(3, 2)
    sides = bounds[:, 1] - bounds[:, 0]
    sides = sides[sides > 0]
    return index.ravel(), float((np.prod(sides) / max(1, index.size)) ** (1 / max(1, len(sides)))) if len(sides) else 1.0


def _round(value: float) -> float:
    """The nearest below of 1, 2 and 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(m for m in (1.0, 2.0, 5.0) if m * power <= value * (1 + 1e-12)) * power


def _name(samples: Samples, factor: float) -> str:
    """What the arrows are, with their scale, for the legend."""
    length = samples.grid.frame.units[0]
    words = " drawn as ".join(f"{n}\u00a0{unit}".strip() for n, unit in (("1", samples.unit), (f"{factor:g}", length)))
    return f"{samples.name or 'vectors'}, {words}"


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _lines(at: Floats, away: Floats, shape: str) -> Geometry:
    """Lines from foot to tip; with two barbs, in the plane if all lies there."""
    tip = at + away
    if shape == "line":
        points = np.stack([at, tip], axis=1).reshape(-1, 3)
        return Geometry(points=points, lines=Cells.of(np.arange(len(points)).reshape(-1, 2)), accuracy=EXACT)
    flat = bool((away[:, 2] == 0).all())
    normal = np.broadcast_to([0.0, 0.0, 1.0], away.shape) if flat else sweep.across(_unit(away), np.arange(len(at) + 1))
    side = np.cross(normal, away)
    barbs = [tip - BARB * (away + sign * 0.4 * side) for sign in (1.0, -1.0)]
    points = np.stack([at, tip, *barbs], axis=1).reshape(-1, 3)
    lists = np.array([[0, 1], [2, 1], [1, 3]])
    lines = (4 * np.arange(len(at))[:, None, None] + lists).reshape(-1, 2)
    return Geometry(points=points, lines=Cells.of(lines), accuracy=EXACT)


def _cones(at: Floats, away: Floats, radius: float, sides: int) -> Geometry:
    """Cones from a round foot to a tip."""
    across = sweep.across(_unit(away), np.arange(len(at) + 1))
    foot = sweep.rings(at, radius * across, radius * np.cross(_unit(away), across), sides).reshape(-1, sides, 3)
    points = np.concatenate([foot, (at + away)[:, None]], axis=1).reshape(-1, 3)
    j = np.arange(sides)
    faces = np.stack([j, (j + 1) % sides, np.full(sides, sides)], axis=-1)
    sizes = np.tile(np.append(np.full(sides, 3), sides), len(at))
    each = np.concatenate([faces.ravel(), j[::-1]])
    connectivity = ((sides + 1) * np.arange(len(at))[:, None] + each).ravel()
    cells = Cells(np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), connectivity.astype(np.int64))
    return Geometry(points=points, polygons=cells, accuracy=EXACT)
