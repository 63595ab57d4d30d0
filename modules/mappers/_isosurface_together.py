"""Several isosurfaces as one geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modules.api import Accuracy, Cells, Field, Flag, Gather, Geometry, Operator


def together(sheets: Sequence[Geometry]) -> Geometry:
    """Sheets with the same values, one after the other; each sheet's errors stay its own, and so do its flags."""
    if len(sheets) == 1:
        return sheets[0]
    first = np.cumsum([0, *(len(s.points) for s in sheets)])
    polygons = [s.triangles + n for s, n in zip(sheets, first[:-1], strict=True)]
    dots = [s.vertices.connectivity + n for s, n in zip(sheets, first[:-1], strict=True)]
    values = {
        name: Field(np.concatenate([s.values[name].values for s in sheets]), field.place, field.unit)
        for name, field in sheets[0].values.items()
    }
    every = np.concatenate(dots)
    return replace(
        sheets[0],
        points=np.concatenate([s.points for s in sheets]),
        polygons=Cells.of(np.concatenate(polygons)) if sum(map(len, polygons)) else sheets[0].polygons,
        vertices=Cells.of(every[:, None]) if len(every) else sheets[0].vertices,
        values=values,
        accuracy=known_together(sheets, int(first[-1])).flag(*_flags(sheets)),
    )


def known_together(sheets: Sequence[Geometry], n: int) -> Accuracy:
    """What is known of the points of all sheets; further points, up to n, are exact. Flags are left out."""
    parts: list[tuple[Accuracy, Operator | None]] = []
    start = 0
    for sheet in sheets:
        m = len(sheet.points)
        if m:
            index, weight = np.zeros((n, 1), np.int64), np.zeros((n, 1))
            index[start : start + m, 0], weight[start : start + m] = np.arange(m), 1.0
            plain = Accuracy(sheet.accuracy.terms, sheet.accuracy.missing, (), sheet.accuracy.ended)
            parts.append((plain, Gather(index, weight, m)))
        else:
            parts.append((Accuracy(missing=sheet.accuracy.missing).end_from(sheet.accuracy, "no surface"), None))
        start += m
    return Accuracy.join(parts)


def _flags(sheets: Sequence[Geometry]) -> list[Flag]:
    """The flags of all sheets, their items numbered anew."""
    found: list[Flag] = []
    points = cells = 0
    for sheet in sheets:
        shift = {"point": points, "cell": cells}
        for flag in sheet.accuracy.flags:
            items = None if flag.items is None else flag.items + shift[flag.place]
            found.append(replace(flag, items=items))
        points, cells = points + len(sheet.points), cells + sheet.counts["cell"]
    return found
