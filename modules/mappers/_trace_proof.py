"""The proven tube about traces: their rows and the ends of all steps between them, as the proof needs them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from modules import kernels
from modules.api import Progress
from modules.mappers._trace_run import Run, follow

Floats = NDArray[np.float64]

SAME = 1e-12
"""Times nearer than this part of the whole are one: the end of a step and a sample there."""

BLOCK = 256
"""Particles of one block of the proof."""


class Rows(NamedTuple):
    """Traces with all ends of steps: offsets, times, positions and velocities; and which of these rows are those of the run."""

    offsets: NDArray[np.int64]
    time: Floats
    points: Floats
    velocity: Floats
    mine: NDArray[np.int64]


def with_steps(
    run: Run, pair: str, rules: Mapping[str, Any], progress: Progress, release: float | None = None
) -> Rows:
    """The rows of a run and, between them, the ends of its steps: no piece between two of them leaves a cell."""
    steps = follow(run.medium, run.sign, pair, {**rules, "interval": 0.0, "assess": False}, progress, release)
    both = (run.traces, steps.traces)
    owner = np.concatenate([np.repeat(np.arange(len(t.offsets) - 1), np.diff(t.offsets)) for t in both])
    time, points, velocity = (np.concatenate([getattr(t, n) for t in both]) for n in ("time", "points", "velocity"))
    order = np.lexsort([np.repeat([0, 1], [len(t.time) for t in both]), time, owner])
    owner, time = owner[order], time[order]
    gap = SAME * time.max(initial=0.0)
    new = np.concatenate([[True], (np.diff(owner) > 0) | (np.diff(time) > gap)])[: len(time)]
    mine = np.empty(len(order), np.int64)
    mine[order] = np.cumsum(new) - 1
    offsets = np.searchsorted(owner[new], np.arange(len(run.traces.offsets))).astype(np.int64)
    return Rows(offsets, time[new], points[order][new], velocity[order][new], mine[: len(run.traces.time)])


def tube(run: Run, pair: str, rules: Mapping[str, Any], progress: Progress) -> Floats | None:
    """(n,) proven radius about each position of a run; None where nothing can be proven of such a flow or such steps."""
    if not kernels.trace_proof.provable(run.medium.flow) or not rules["faces"] or rules["subsidiary"]:
        return None
    rows = with_steps(run, pair, rules, progress.part(0.0, 0.2))
    parts = []
    for a in range(0, len(rows.offsets) - 1, BLOCK):
        some = rows.offsets[a : a + BLOCK + 1]
        span = slice(some[0], some[-1])
        part = progress.part(0.2 + 0.8 * a / len(rows.offsets), 1.0)
        parts.append(kernels.trace_proof.proven(run.medium.flow, some - some[0], rows.time[span], rows.points[span], part))
    return np.asarray(np.concatenate([np.zeros(0), *parts])[rows.mine])
