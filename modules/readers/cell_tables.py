"""Tables 4.1 to 4.4 of the thesis: the kinds of trilinear cells, from enumeration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from modules import kernels
from modules.api import Accuracy, Literal, Source, Table, Term, reader
from modules.data.operators import Identity

SEEN = Source(
    "Kinds of cells", "mapping", "sampled",
    "every pattern of corners; faces and tunnels as 2000 random cells of each configuration have them [cell-kinds/1]",
)  # fmt: skip

Rows = Sequence[tuple[Any, ...]]


@reader("Cell tables", output="table", aliases=("configurations", "topological polygons", "table 4.1", "marching cubes cases"))
def cell_tables(*, table: Literal["4.1", "4.2", "4.3", "4.4"] = "4.1") -> Table:
    """The kinds of cells that a surface can pass: configurations, polygons with and without loop-back faces, tunnels.

    Parameters
    ----------
    table : 4.1 configurations and their subcases; 4.2 polygons with loop-back faces; 4.3 polygons without; 4.4 pairs of
        polygons that a tunnel joins, with configuration 13, which the thesis thought to have none

    Accuracy: the patterns of corners are all there are; which of a configuration's faces and tunnels occur is as random cells
        have them.
    Source: Lopes 1999, tables 4.1 to 4.4, put right.
    """
    kinds = kernels.cell_types.kinds()
    names, rows = {"4.1": _configurations, "4.2": _loop_back, "4.3": _plain, "4.4": _tunnels}[table](kinds)
    columns = {name: np.array([row[n] for row in rows]) for n, name in enumerate(names)}
    term = Term(SEEN, "bound", "patterns", "", np.asarray(0.0), Identity(len(rows)))
    return Table(columns=columns, name=f"table {table}", accuracy=Accuracy((term,)))


def _configurations(kinds: Sequence[kernels.cell_types.Kind]) -> tuple[Sequence[str], Rows]:
    rows = [
        (k.configuration, " ".join(k.polygons), k.ambiguous, "yes" if k.tunnel else "no", 1 if k.tunnel else 0, k.patterns)
        for k in kinds
    ]
    return ("configuration", "polygons", "ambiguous faces", "tunnel", "pieces less with a tunnel", "patterns"), rows


def _polygons(kinds: Sequence[kernels.cell_types.Kind], loop_back: bool) -> Rows:
    types, rows = kernels.cell_types, []
    for name in types.KNOWN:
        if (not name.endswith("/0")) == loop_back:
            where = sorted({k.configuration for k in kinds if name in k.polygons})
            rows.append((name, " ".join(map(str, where)), types.INNER.get(name, 1), types.triangles_of(name)))
    return rows


def _loop_back(kinds: Sequence[kernels.cell_types.Kind]) -> tuple[Sequence[str], Rows]:
    return ("polygon", "configurations", "inflection points", "triangles"), _polygons(kinds, True)


def _plain(kinds: Sequence[kernels.cell_types.Kind]) -> tuple[Sequence[str], Rows]:
    return ("polygon", "configurations", "bi-shoulder points", "triangles"), _polygons(kinds, False)


def _tunnels(kinds: Sequence[kernels.cell_types.Kind]) -> tuple[Sequence[str], Rows]:
    types, rows = kernels.cell_types, []
    for pair in types.PAIRS:
        where = sorted({k.configuration for k in kinds if k.tunnel and (k.polygons[0], k.polygons[-1]) == pair})
        rows.append((pair[0], pair[1], " ".join(map(str, where)), types.triangles_of_tunnel(pair)))
    return ("polygon", "with polygon", "configurations", "triangles"), rows
