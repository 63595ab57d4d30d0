"""The strip between a trace and a second run, at equal times: a picture of how far the two part (thesis figure 5.8)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from modules.api import Accuracy, Cells, Field, Geometry, Literal, Matrix, Term, mapper
from modules.data import sweep
from modules.data.operators import Floats
from modules.mappers._trace_run import at_times

Ints = NDArray[np.int64]


@mapper("Strip between runs", aliases=("backward run", "reversibility", "difference of traces"), output="strip")
def between_runs(traces: Geometry, second: Geometry, *, meet: Literal["end", "start", "times"] = "end") -> Geometry:
    """A surface from each point of a trace to where a second run was at the same time.

    A run back from the ends of the traces has the times of its own clock, which begins there: it is set so that the two runs
    meet. The distance tells whether a run can be undone. It is no error: near a stable orbit both runs may be far from the
    particle and close to each other, and none of it is added to what is known of the traces.

    Parameters
    ----------
    traces : lines with times, of which line i is run again
    second : traces of which seed i begins where line i ends, as 'Ends of traces' gives them; or where it begins
    meet : where the clocks of the two runs agree: at the end of the first (a run back), at its start, or as they are

    Raises
    ------
    ValueError : lines without times and velocities, or a second run that begins elsewhere

    Values: `distance` of the two runs and `time` at each point.

    Accuracy: each edge lies where its run lies: errors of the positions of both go on, each on its edge. The other terms end
        here. True to scale.
    Source: Lopes 1999, 5.2.4 (re-integration) and figure 5.8.
    """
    pairs = _pairs(traces, second, meet)
    where = np.concatenate([np.zeros(0, np.int64), *(rows for rows, _, _ in pairs)])
    offsets = np.cumsum([0, *(len(rows) for rows, _, _ in pairs)]).astype(np.int64)
    there = np.concatenate([np.zeros((0, 3)), *(at for _, at, _ in pairs)])
    p, n = traces.points[where], len(where)
    nearest = np.concatenate([np.zeros(0, np.int64), *(near for _, _, near in pairs)])
    apart = np.linalg.norm(there - p, axis=1)
    unit = traces.frame.length_unit(3)
    even = np.arange(n)
    accuracy = Accuracy.join([
        (_edge(traces, where, 2 * even, 2 * n), None), (_edge(second, nearest, 2 * even + 1, 2 * n), None)
    ])  # fmt: skip
    why = "the strip shows where two runs lie, not this"
    return Geometry(
        points=np.stack([p, there], axis=1).reshape(-1, 3),
        polygons=Cells.of(sweep.quads(offsets, 2, closed=False)),
        values={
            "distance": Field(np.repeat(apart, 2), "point", unit),
            "time": Field(np.repeat(traces.values["time"].values[where], 2), "point", traces.values["time"].unit),
        },
        cell=traces.cell,
        frame=traces.frame,
        name=traces.name,
        time=traces.time,
        accuracy=accuracy.end_from(traces.accuracy, why).end_from(second.accuracy, why),
    )


def _pairs(traces: Geometry, second: Geometry, meet: str) -> list[tuple[Ints, Floats, Ints]]:
    """For each line that has a second run: its points, where the second run was then, and its row nearest in time.

    Raises
    ------
    ValueError : no runs, or they do not meet
    """
    for one in (traces, second):
        lost = {"time", "velocity", "seed"} - set(one.values)
        if lost:
            raise ValueError(f"these are no particle traces: {', '.join(sorted(lost))} of their points is not there")
    time, other = (np.asarray(g.values["time"].values, float) for g in (traces, second))
    velocity = np.asarray(second.values["velocity"].values, float)
    runs = dict(zip(np.asarray(second.values["seed"].values).tolist(), pairwise(second.lines.offsets), strict=True))
    found = []
    for i, (a, b) in enumerate(pairwise(traces.lines.offsets)):
        if i not in runs or b - a < 2:
            continue
        rows, again = traces.lines.connectivity[a:b], second.lines.connectivity[slice(*runs[i])]
        clock = other[again]
        if meet != "times":
            last, begins = (-1 if meet == "end" else 0), int(np.argmin(np.abs(clock)))
            gap = float(np.linalg.norm(traces.points[rows[last]] - second.points[again[begins]]))
            if gap > 1e-6 * float(np.ptp(traces.points, axis=0).max()):
                raise ValueError(f"the second run begins {gap:.3g} from the {meet} of trace {i}: give it 'Ends of traces'")
            clock = clock - clock[begins] + time[rows[last]]
        shared = (time[rows] >= clock[0] - 1e-9) & (time[rows] <= clock[-1] + 1e-9)
        rows = rows[shared]
        at = at_times(time[rows], clock, second.points[again], velocity[again])
        near = again[np.abs(time[rows][:, None] - clock).argmin(axis=1)]
        found.append((rows, at, near))
    if not found:
        raise ValueError("no trace has a second run: wire 'Ends of traces' to the seeds of a trace back")
    return found


def _edge(run: Geometry, rows: Ints, to: Ints, count: int) -> Accuracy:
    """Errors of the positions of one run, on the points of the strip that lie on it; the other edge has none of them."""
    kept: list[Term] = []
    for term in run.accuracy.select("position", place="point"):
        if term.components == 3:
            shape = (3 * count, 3 * term.count)
            across = np.arange(3)
            row, column = (to[:, None] * 3 + across).ravel(), (rows[:, None] * 3 + across).ravel()
            kept.append(term.push(Matrix(coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()), place="point"))
    return Accuracy(tuple(kept), run.accuracy.missing, (), run.accuracy.ended)
