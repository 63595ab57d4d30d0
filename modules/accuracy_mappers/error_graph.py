"""The error of a particle over time, source by source: a table for 'chart'."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modules.accuracy_mappers import _vector as vector
from modules.api import Accuracy, Annotated, Geometry, Range, Table, accuracy_mapper
from modules.data.operators import Floats


@accuracy_mapper("Error graph", aliases=("error over time", "growth of the error", "chart"), output="table")
def error_graph(
    traces: Geometry,
    accuracy: Accuracy | None = None,
    *,
    trace: Annotated[int, Range(0, 100)] = 0,
    k: Annotated[float, Range(0.5, 4)] = 2.0,
) -> Table:
    """How far each source of error may have put a particle at each time of its trace, and all of them together.

    Parameters
    ----------
    traces : lines with errors of their positions
    accuracy : of the same traces; their own by default
    trace : which line, from 0
    k : standard deviations that spreads count with

    Raises
    ------
    ValueError : no such line, or no error of the position is known

    Accuracy: the table states sizes: of spreads k standard deviations, of signed errors and bounds as they are; together as
        in any total. There is no number where the estimate is not credible. Terms of the position go on, a row a time.
    Source: Lopes 1999, 5.2.4; sums after JCGM 101.
    """
    vector.checked(1.0, k)
    known = traces.accept(accuracy)
    if not 0 <= trace < len(traces.lines):
        raise ValueError(f"there is no trace {trace}: there are {len(traces.lines)}, the first is 0")
    terms = [t for t in known.select("position", "point") if t.components == 3]
    if not terms:
        raise ValueError("the lines know no error of their positions as a vector: wire the traces of 'trace'")
    a, b = traces.lines.offsets[trace : trace + 2]
    where = traces.lines.connectivity[a:b]
    columns: dict[str, NDArray[np.float64]] = {}
    units = dict.fromkeys(("total error",), terms[0].unit)
    name, columns[name], units[name] = _clock(traces, where)
    total = known.total(k, "position", "point", where)
    columns["total error"] = total
    sizes = [(t, t.size()) for t in terms]
    for term, size in sorted(sizes, key=lambda pair: -float(np.nan_to_num(pair[1][where], posinf=0.0).max(initial=0.0))):
        doubtful = ~vector.credible(known, term, size)[where]
        column = size[where] * (k if vector.spread(term) else 1.0)
        column[doubtful] = total[doubtful] = np.nan
        columns[_free(term.name, columns)] = column
        units[term.name] = term.unit
    return Table(
        columns=columns, units=units, name=f"errors of trace {trace}",
        accuracy=vector.at_points(terms, where, known, traces, "graph"),
    )  # fmt: skip


def _clock(traces: Geometry, where: NDArray[np.int64]) -> tuple[str, Floats, str]:
    """Name, values and unit of what the graph runs over: the time if it is known, else the length along the line."""
    time = traces.values.get("time")
    if time is not None and time.place == "point":
        return "time", np.asarray(time.values, float)[where], time.unit
    steps = np.linalg.norm(np.diff(traces.points[where], axis=0), axis=1)
    return "length", np.concatenate([[0.0], np.cumsum(steps)]), traces.frame.length_unit(3)


def _free(name: str, taken: dict[str, Floats]) -> str:
    """The name, with a number where it is taken."""
    found, n = name, 2
    while found in taken:
        found, n = f"{name} ({n})", n + 1
    return found
