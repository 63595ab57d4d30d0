"""Where the errors of a geometry are largest, as a table and as points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from modules.api import (
    Accuracy,
    Annotated,
    Cells,
    Field,
    Flag,
    Geometry,
    NamedTuple,
    Progress,
    Range,
    Table,
    Term,
    accuracy_mapper,
)
from modules.data.places import where

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ORDER = ("position", "area", "value", "velocity", "length")
"""Which quantity is meant if none is named: the first of these that there is."""
UNBOUNDED = -1.0
"""Where an error without a bound stands in the order of sizes: after all that have one."""
WHY = "the largest sizes are listed as plain numbers; the errors themselves stay with the geometry"


class Worst(NamedTuple):
    """The largest errors as a table, and where they are."""

    table: Table
    places: Geometry


@accuracy_mapper("Worst places", aliases=("largest errors", "maximum error", "outliers", "top"), version=2)
def worst(
    geometry: Geometry,
    progress: Progress,
    accuracy: Accuracy | None = None,
    *,
    count: Annotated[int, Range(1, 1000, log=True)] = 10,
    quantity: str = "",
    reach: float | None = None,
) -> Worst:
    """The largest errors of a geometry: which source, where, how large; one row an error, the largest first.

    Errors that have no bound, or one beyond `reach`, say only that nothing is known there: they come after all others, and a
    flag tells how many there are. Errors of size 0 are no worst places and are left out. Of errors of one size the source that
    stands first in the budget comes first, then the item of the lower number.

    Parameters
    ----------
    geometry : lines, points or polygons
    accuracy : of the same geometry; its own by default
    count : number of rows
    quantity : position, area, value ...; automatic: the first of position, area, value that there is
    reach : an error larger than this is taken as one without a bound; automatic: the size of the geometry for errors of
        position, no such limit for others

    Raises
    ------
    ValueError : no error of that quantity is known, its sources have different units, no row is wanted, or a reach of 0 or less

    Accuracy: sizes are those of the budget, standard deviations as they are (k = 1); the terms end here, for the table
        holds their largest values as plain numbers.
    Source: Lopes 1999, 3.5 (the error of each place is a number); the order of ties is ours.
    """
    if count < 1:
        raise ValueError(f"count must be at least 1, not {count}")
    if reach is not None and not reach > 0:
        raise ValueError(f"no error lies within a reach of {reach:g}: give a number above zero")
    shown = geometry.accept(accuracy)
    terms = _terms(shown, quantity)
    sizes = [t.size(None, progress.part(i / len(terms), (i + 1) / len(terms))) for i, t in enumerate(terms)]
    limit = (_extent(geometry) if terms[0].quantity == "position" else math.inf) if reach is None else reach
    which, item = _largest(sizes, count, limit)
    at = _positions(geometry, terms, which, item)
    table = _table(terms, sizes, which, item, at)
    ended = Accuracy().end_from(shown, WHY).end_from(geometry.accuracy, WHY).miss(*shown.missing)
    ended = ended.flag(*_unbounded(sizes, limit, terms[0]))
    return Worst(
        Table(columns=table, units=_units(geometry, terms), name=f"worst {terms[0].quantity}", accuracy=ended),
        Geometry(
            points=at,
            vertices=Cells.of(np.arange(len(at))[:, None]),
            values={
                "size": Field(table["size"], "point", terms[0].unit),
                "rank": Field(table["rank"], "point"),
                "name": Field(np.array([str(r) for r in table["rank"]], dtype=str), "point"),
            },
            cell=geometry.cell,
            frame=geometry.frame,
            name="worst places",
            time=geometry.time,
            accuracy=ended,
        ),
    )


def _terms(shown: Accuracy, quantity: str) -> tuple[Term, ...]:
    """The terms of the quantity that is meant, all in one unit."""
    there = list(dict.fromkeys(t.quantity for t in shown.terms))
    if not there:
        raise ValueError("no error of the geometry is known: there is nothing to rank")
    wanted = quantity or next((q for q in ORDER if q in there), there[0])
    if wanted not in there:
        raise ValueError(f"no error of {wanted!r} is known: there are errors of {', '.join(there)}")
    terms = shown.select(wanted)
    if len({t.unit for t in terms}) > 1:
        units = ", ".join(sorted({t.unit or "plain numbers" for t in terms}))
        raise ValueError(f"errors of {wanted} come in {units}: what is larger cannot be said")
    return terms


def _extent(geometry: Geometry) -> float:
    """From corner to corner; infinite for a geometry that is one point or none."""
    points = geometry.points[np.isfinite(geometry.points).all(axis=1)]
    return (float(np.linalg.norm(np.ptp(points, axis=0))) or math.inf) if len(points) else math.inf


def _unbounded(sizes: list[Floats], limit: float, term: Term) -> tuple[Flag, ...]:
    """That some errors are not known to stay within the limit."""
    beyond, of = sum(int(np.sum(_beyond(s, limit))) for s in sizes), sum(map(len, sizes))
    far = "" if math.isinf(limit) else f" or one beyond {f'{limit:.3g} {term.unit}'.strip()}"
    words = f"{beyond:,} of {of:,} errors of {term.quantity} have no bound{far}: they are listed after all others"
    return (Flag("unbounded", words),) if beyond else ()


def _beyond(size: Floats, limit: float) -> NDArray[np.bool_]:
    return np.isinf(size) | (size > limit)


def _largest(sizes: list[Floats], count: int, limit: float = math.inf) -> tuple[Ints, Ints]:
    """(term, item) of the largest sizes above 0, those within the limit first; of equal ones the first term and lowest item."""
    found: list[tuple[Floats, Ints, Ints]] = []
    for i, told in enumerate(sizes):
        size = np.where(_beyond(told, limit), UNBOUNDED, told)
        item = np.flatnonzero((size != 0) & ~np.isnan(size))
        if len(item) > count:  # all that reach the smallest of the largest, so that ties are decided below
            least = np.partition(size[item], len(item) - count)[len(item) - count]
            above, ties = item[size[item] > least], item[size[item] == least]
            item = np.concatenate([above, ties[: count - len(above)]])
        found.append((size[item], np.full(len(item), i, np.int64), item.astype(np.int64)))
    size, which, item = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.lexsort((item, which, -size))[:count]
    return which[order], item[order]


def _positions(geometry: Geometry, terms: tuple[Term, ...], which: Ints, item: Ints) -> Floats:
    """(n, 3) where the items are: points, middles of segments, means of the points of cells."""
    at = np.full((len(which), 3), np.nan)
    for i, term in enumerate(terms):
        rows = np.flatnonzero(which == i)
        if len(rows):
            at[rows] = _places(geometry, term, item[rows])
    return at


def _places(geometry: Geometry, term: Term, item: Ints) -> Floats:
    if term.place == "own":
        if term.points is None:
            raise ValueError(f"the errors {term.name!r} do not say where they are")
        return np.asarray(term.points[item])
    found = where(geometry, term.place, item)
    assert found is not None
    return found


def _table(
    terms: tuple[Term, ...], sizes: list[Floats], which: Ints, item: Ints, at: Floats
) -> dict[str, NDArray[np.generic]]:
    size = np.array([sizes[t][i] for t, i in zip(which, item, strict=True)], float)

    def words(say: list[str]) -> NDArray[np.generic]:
        return np.array([say[t] for t in which], dtype=str)

    return {
        "rank": np.arange(1, len(which) + 1),
        "x": at[:, 0],
        "y": at[:, 1],
        "z": at[:, 2],
        "sign": words([t.source.sign for t in terms]),
        "size": size,
        "unit": words([t.unit for t in terms]),
        "term": words([t.name for t in terms]),
        "quantity": words([t.quantity for t in terms]),
        "kind": words([t.kind for t in terms]),
        "place": words([t.place for t in terms]),
        "item": item,
    }


def _units(geometry: Geometry, terms: tuple[Term, ...]) -> dict[str, str]:
    units = {**dict(zip("xyz", geometry.frame.units, strict=True)), "size": terms[0].unit}
    return {name: unit for name, unit in units.items() if unit}
