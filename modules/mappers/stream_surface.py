"""The surface that a rake of particles sweeps; closed, the tube that a ring of particles sweeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modules.api import Annotated, Cells, Field, Flag, Geometry, Missing, Range, mapper

Ints = NDArray[np.int64]

SAME = 1e-9
"""Of the longest time: times that differ by less are one."""


@mapper("Stream surface", aliases=("rake", "stream tube", "time surface", "streamlines"), output="surface")
def stream_surface(
    traces: Geometry,
    *,
    closed: bool = False,
    widest: Annotated[float | None, Range(low=0)] = None,
) -> Geometry:
    """A surface between neighbouring traces, from time to time, in the order of their seeds.

    Lines across the surface are timelines. Where one of two neighbours has ended, or they have come too far apart, the
    surface between them ends; no particles are added.

    Parameters
    ----------
    traces : lines with equal times: give 'trace' an interval, and 'seeds' a line or a sphere
    closed : whether the last trace is a neighbour of the first: a ring of seeds then sweeps a tube
    widest : distance of neighbours from which there is no surface between them; automatic: 10 times their first distance

    Raises
    ------
    ValueError : fewer than two lines, lines without times, or neighbours with different times

    Accuracy: errors of the points go on. Between two traces the surface is straight; how far that is from where particles
        between them go is not estimated. Where it was torn is flagged.
    Source: Lopes 1999, 2.5.3: stream surface and stream tube as what particles released along a curve sweep.
    """
    if len(traces.lines) < 2:
        raise ValueError(f"a surface lies between two traces at least, not {len(traces.lines)}")
    if "time" not in traces.values or traces.values["time"].place != "point":
        raise ValueError("the lines have no times: wire the traces of 'trace'")
    count = len(traces.lines)
    pairs = [(i, (i + 1) % count) for i in range(count if closed and count > 2 else count - 1)]
    strips, torn = zip(*(_strip(traces, a, b, widest) for a, b in pairs), strict=True)
    quads = np.concatenate(strips)
    owner = np.repeat(np.arange(len(pairs)), [len(s) for s in strips])
    accuracy = traces.accuracy.miss(
        Missing("Surface between traces", "straight from trace to trace; particles between them may bend it")
    )
    if any(torn):
        words = f"the surface is torn between {sum(torn)} of {len(pairs)} pairs of traces that came far apart: more seeds"
        accuracy = accuracy.flag(Flag("torn", words))
    points = {name: one for name, one in traces.values.items() if one.place == "point"}
    elsewhere = [t for t in accuracy.terms if t.place not in ("point", "own")]
    for term in elsewhere:
        accuracy = accuracy.end(term, "the surface has other cells than the traces")
    return replace(
        traces,
        vertices=Cells.of(np.zeros((0, 1), np.int64)),
        lines=Cells.of(np.zeros((0, 2), np.int64)),
        polygons=Cells.of(quads),
        values={**points, "trace": Field(owner, "cell")},
        origin=len(traces.vertices) + owner,
        accuracy=replace(accuracy, flags=tuple(f for f in accuracy.flags if f.place in ("point", "own") or f.items is None)),
    )


def _strip(traces: Geometry, a: int, b: int, widest: float | None) -> tuple[Ints, bool]:
    """(q, 4) faces between two lines up to where one ends or they part; and whether they parted.

    Raises
    ------
    ValueError : their times differ before that
    """
    o, c = traces.lines.offsets, traces.lines.connectivity
    first, second = c[o[a] : o[a + 1]], c[o[b] : o[b + 1]]
    n = min(len(first), len(second))
    time = np.asarray(traces.values["time"].values, float)
    s, t = time[first[:n]], time[second[:n]]
    unlike = np.flatnonzero(np.abs(s - t) > SAME * max(abs(time).max(initial=0.0), 1e-300))
    if len(unlike) and unlike[0] < n - 1:
        raise ValueError("neighbouring traces have different times: give 'trace' an interval")
    n = int(unlike[0]) if len(unlike) else n
    apart = np.linalg.norm(traces.points[first[:n]] - traces.points[second[:n]], axis=1)
    most = widest if widest is not None else 10 * apart[:1].max(initial=0.0)
    far = np.flatnonzero(apart > most)
    torn = bool(len(far))
    n = int(far[0]) if torn else n
    i = np.arange(max(0, n - 1))
    return np.stack([first[i], second[i], second[i + 1], first[i + 1]], axis=-1).reshape(-1, 4).astype(np.int64), torn
