"""Geometry: points, polylines and polygons, parametric primitives, and what is known of where they may lie."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modules.data.accuracy import Accuracy, Place
from modules.data.grid import Bounds, Frame
from modules.data.operators import Floats

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Cells:
    """Lists of points: cell i is connectivity[offsets[i]:offsets[i + 1]]."""

    offsets: Indices
    connectivity: Indices

    def __len__(self) -> int:
        return max(0, len(self.offsets) - 1)

    def sizes(self) -> Indices:
        """Number of points of each cell."""
        return np.diff(self.offsets)

    @classmethod
    def of(cls, lists: Sequence[Sequence[int]] | NDArray[Any]) -> Cells:
        """From a list of lists, or an (m, k) array."""
        if isinstance(lists, np.ndarray) and lists.ndim == 2:
            m, k = lists.shape
            return cls(np.arange(m + 1, dtype=np.int64) * k, np.ascontiguousarray(lists, np.int64).ravel())
        sizes = [len(one) for one in lists]
        flat = [int(i) for one in lists for i in one]
        return cls(np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), np.asarray(flat, np.int64))


NONE = Cells(np.zeros(1, np.int64), np.zeros(0, np.int64))


@dataclass(frozen=True, eq=False)
class Field:
    """Values on the items of a geometry.

    Parameters
    ----------
    values : (n,) or (n, 3)
    place : point, cell or segment
    unit : of the values
    """

    values: NDArray[Any]
    place: Place = "point"
    unit: str = ""


@dataclass(frozen=True)
class Shown:
    """An error that this geometry shows, for the legend.

    Parameters
    ----------
    name, quantity : of the term
    note : "1 point = 34 m²", "per cell"
    factor : exaggeration; 1 is true to scale
    """

    name: str
    quantity: str
    note: str = ""
    factor: float = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Primitive:
    """A shape by its parameters, each with its own terms (thesis 2.3.1: a sphere, d centre and d radius).

    Parameters
    ----------
    kind : sphere, plane, line or box
    values : name -> parameter values, e.g. {"centre": (3,), "radius": (1,)}
    accuracy : terms whose quantity is a parameter's name, one row of as many components, place "point"
    """

    kind: str
    values: Mapping[str, Floats]
    accuracy: Accuracy

    def __post_init__(self) -> None:
        for term in self.accuracy.terms:
            if term.quantity not in self.values:
                raise ValueError(f"a {self.kind} has {', '.join(self.values)}; term {term.name!r} is of {term.quantity!r}")
        object.__setattr__(self, "accuracy", self.accuracy.carried(self.kind, {"point": 1}))


@dataclass(frozen=True, eq=False, kw_only=True)
class Geometry:
    """Shapes in space, and where they may lie.

    Parameters
    ----------
    points : (n, 3) float, in x, y, z
    vertices, lines, polygons : cells; they count in this order
    values : name -> field on points, cells or segments (two consecutive points of a line)
    primitives : parametric shapes
    texture, texture_at : (h, w, 3 or 4) uint8 image, and (n, 2) coordinates in it
    origin : (cells,) int, the item of the input that each cell stands for
    shows : errors that this geometry shows
    cell : edge of the grid cells it was drawn from, for lengths "in cells"
    accuracy : terms on points, cells or segments
    """

    FACTS: ClassVar[tuple[str, ...]] = ("bounds", "names", "points", "cells", "times", "ranges", "vectors")

    points: Floats
    vertices: Cells = NONE
    lines: Cells = NONE
    polygons: Cells = NONE
    values: Mapping[str, Field] = field(default_factory=dict)
    primitives: tuple[Primitive, ...] = ()
    texture: NDArray[np.uint8] | None = None
    texture_at: Floats | None = None
    origin: Indices | None = None
    shows: tuple[Shown, ...] = ()
    cell: float | None = None
    frame: Frame = field(default=Frame())
    name: str = ""
    time: float | None = None
    accuracy: Accuracy

    def __post_init__(self) -> None:
        points = np.asarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points are (n, 3) in x, y, z, not {points.shape}")
        object.__setattr__(self, "points", points)
        for cells in (self.vertices, self.lines, self.polygons):
            c = cells.connectivity
            if len(c) and not 0 <= c.min() <= c.max() < len(points):
                raise ValueError(f"a cell names point {c.max()}; there are {len(points)}")
        counts = self.counts
        for name, one in self.values.items():
            if len(one.values) != counts[one.place]:
                raise ValueError(f"{name!r} has {len(one.values)} values for {counts[one.place]} {one.place}s")
        if self.origin is not None and len(self.origin) != counts["cell"]:
            raise ValueError(f"origin names {len(self.origin)} items for {counts['cell']} cells")
        object.__setattr__(self, "accuracy", self.accuracy.carried("Geometry", counts))

    @property
    def counts(self) -> dict[str, int]:
        """Number of points, cells and segments."""
        cells = len(self.vertices) + len(self.lines) + len(self.polygons)
        return {"point": len(self.points), "cell": cells, "segment": len(self.lines.connectivity) - len(self.lines)}

    @property
    def bounds(self) -> Bounds | None:
        """(xmin, xmax, ymin, ymax, zmin, zmax); None without points."""
        if not len(self.points):
            return None
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return (float(low[0]), float(high[0]), float(low[1]), float(high[1]), float(low[2]), float(high[2]))

    def polylines(self) -> list[Floats]:
        """Each line as its (k, 3) points; a closed one repeats its first point at its end."""
        o, c = self.lines.offsets, self.lines.connectivity
        return [self.points[c[a:b]] for a, b in pairwise(o)]

    @property
    def triangles(self) -> Indices:
        """(m, 3) int: polygons as fans of triangles."""
        sizes = self.polygons.sizes()
        starts = np.repeat(self.polygons.offsets[:-1], np.maximum(sizes - 2, 0))
        within = np.concatenate([np.arange(1, max(1, s - 1)) for s in sizes]) if len(sizes) and (sizes != 3).any() else 1
        c = self.polygons.connectivity
        if not len(starts):
            return np.zeros((0, 3), np.int64)
        return np.column_stack([c[starts], c[starts + within], c[starts + within + 1]])

    def segments(self) -> Indices:
        """(s, 2) int: consecutive points of the lines, line after line."""
        c = self.lines.connectivity
        if not len(c):
            return np.zeros((0, 2), np.int64)
        keep = np.ones(len(c) - 1, bool)
        keep[self.lines.offsets[1:-1] - 1] = False
        return np.column_stack([c[:-1][keep], c[1:][keep]])

    def accept(self, accuracy: Accuracy | None) -> Accuracy:
        """The accuracy to show: that from elsewhere if it speaks of as many items, else this geometry's own.

        Raises
        ------
        ValueError : the accuracy belongs to something with other items
        """
        if accuracy is None:
            return self.accuracy
        counts = accuracy.of.counts if accuracy.of else {}
        for term in accuracy.terms:
            if counts.get(term.place) != self.counts[term.place]:
                raise ValueError(
                    f"the accuracy belongs to a {accuracy.of.kind if accuracy.of else 'thing'} of "
                    f"{counts.get(term.place, 0)} {term.place}s; this geometry has {self.counts[term.place]}: "
                    "wire the accuracy of the same geometry"
                )
        return accuracy

    def facts(self) -> dict[str, Any]:
        """Cheap facts for panels: bounds, names and ranges of the values, counts, times, sources whose errors are vectors."""
        counts = self.counts
        ranges = {
            name: (float(np.nanmin(f.values)), float(np.nanmax(f.values)))
            for name, f in self.values.items()
            if len(f.values) and np.issubdtype(f.values.dtype, np.number) and np.isfinite(f.values).any()
        }
        return {
            "bounds": self.bounds,
            "names": tuple(self.values),
            "points": counts["point"],
            "cells": counts["cell"],
            "times": () if self.time is None else (self.time,),
            "ranges": ranges,
            "vectors": tuple(dict.fromkeys(t.name for t in self.accuracy.terms if t.components == 3)),
        }


def points_of(points: ArrayLike) -> Floats:
    """(n, 2) or (n, 3) positions as (n, 3), z = 0 where it is not given."""
    array = np.asarray(points, float)
    return np.column_stack([array, np.zeros(len(array))]) if array.shape[1] == 2 else array
