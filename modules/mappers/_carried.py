"""Values and accuracy of a geometry carried to shapes that stand for its points, cells and segments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Accuracy, Field, Geometry, Term, select

Ints = NDArray[np.int64]
NONE = np.zeros(0, np.int64)


@dataclass(frozen=True, eq=False)
class Carried:
    """Which items of a geometry the new ones stand for.

    Parameters
    ----------
    of : the geometry
    points : (n,) for each new point, a point of it
    cells : (m,) for each new cell, a cell of it; none if they stand for no cells
    segments : (m,) for each new cell, a segment of it; none if they stand for no segments
    """

    of: Geometry
    points: Ints
    cells: Ints = field(default_factory=lambda: NONE)
    segments: Ints = field(default_factory=lambda: NONE)

    def values(self) -> Mapping[str, Field]:
        """All values that have a place on the new shape."""
        rows = {"point": self.points, "cell": self.cells, "segment": self.segments}
        found = {}
        for name, one in self.of.values.items():
            if one.place in rows and (len(rows[one.place]) or one.place == "point"):
                place = "point" if one.place == "point" else "cell"
                found[name] = Field(np.asarray(one.values)[rows[one.place]], place, one.unit)  # type: ignore[arg-type]  # a place
        return found

    def accuracy(self, why: str) -> Accuracy:
        """All terms that have a place on the new shape; the others end for a reason."""
        known = self.of.accuracy
        found = [one for t in known.terms if (one := self._moved(t)) is not None]
        whole = tuple(f for f in known.flags if f.items is None)
        return Accuracy(tuple(found), known.missing, whole, known.ended).end_from(known, why)

    def _moved(self, term: Term) -> Term | None:
        rows = {"point": self.points, "cell": self.cells, "segment": self.segments}.get(term.place, NONE)
        if term.place not in ("point", "cell", "segment") or (not len(rows) and term.place != "point"):
            return None
        c = term.components
        index = rows if c == 1 else (rows[:, None] * c + np.arange(c)).ravel()
        return replace(term.push(select(index, c * term.count)), place="point" if term.place == "point" else "cell")


def size_of(geometry: Geometry, given: float | None, share: float, what: str) -> float:
    """The size that is given, else a share of the diagonal of all points.

    Raises
    ------
    ValueError : it is not above zero, though there is something to draw
    """
    bounds = geometry.bounds
    size = share * math.dist(bounds[::2], bounds[1::2]) if given is None and bounds else given or 0.0
    if not size > 0 and len(geometry.points):
        raise ValueError(f"{what} = {size:g} is not seen: give a length above zero")
    return size
