"""Particles followed slab by slab, in one direction or both, and put together as lines that run forward in time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array, vstack

from modules import kernels
from modules.api import Model, Progress, Rectilinear, Regular
from modules.data.laws import second_derivative

if TYPE_CHECKING:
    from modules.kernels.trace import Traces
    from modules.kernels.trace_cell import Flow

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLAB = 64
"""Particles a slab: some milliseconds between two looks at whether the work is still wanted."""

MOST_ANSWERS = 4_000_000
"""More answers of a position to a sample, 72 bytes each, are not kept."""

RKSUITE = "no assessment"


@dataclass(frozen=True, eq=False)
class Run:
    """Particles followed in one direction: their rows, with times and velocities as they are in the field.

    Parameters
    ----------
    sign : 1 forward, -1 backward
    flow : the field in the direction of the march
    traces : of all seeds
    """

    sign: int
    flow: Flow
    traces: Traces


@dataclass(frozen=True, eq=False)
class Answers:
    """How positions answer to errors: of the samples (sparse), of the law (drift), and of the seeds (growth)."""

    samples: csr_array
    drift: Floats
    growth: Floats


def flow(model: Model, sign: int) -> Flow:
    """The field of a model for the kernel.

    Raises
    ------
    ValueError : not a vector field, not a map or volume of a regular or rectilinear grid, or another law than linear
    """
    grid = model.grid
    if model.samples.components != 3:
        raise ValueError("particles follow a velocity: wire a model of vectors, two or three components a sample")
    if not isinstance(grid, Regular | Rectilinear) or grid.dimensions < 2:
        raise ValueError(f"particles are followed on regular and rectilinear grids of 2 or 3 axes, not on a {grid.kind} one")
    if model.law.name != "linear":
        raise ValueError(f"particles are followed through a linear model, not through a {model.law.name} one")
    values = np.asarray(model.samples.values, float)
    return kernels.trace.flow_of(values, *grid.axes, backwards=sign < 0)


def follow(field: Flow, sign: int, at: Floats, pair: str, rules: Mapping[str, Any], progress: Progress) -> Run:
    """Follow all particles in one direction."""
    checked = kernels.trace.rules_of(field, pair=pair, **rules)
    slabs = [at[i : i + SLAB] for i in range(0, len(at), SLAB)]
    parts = progress.map(lambda slab: kernels.trace.march(field, slab, checked, pair), slabs)
    return Run(sign, field, joined(parts))


def joined(parts: list[Traces]) -> Traces:
    """Traces of all slabs as one."""
    if len(parts) == 1:
        return parts[0]
    counts = np.concatenate([np.diff(p.offsets) for p in parts])
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return kernels.trace.Traces(offsets, *(np.concatenate(columns) for columns in list(zip(*parts, strict=True))[1:]))


def against(main: Traces, other: Traces) -> Floats:
    """(n, 3) how far the positions of a trace lie from those of another march at the same times.

    A time that the other march has not, since it ended before or took another exit, is reached from its nearest row by
    its velocity there.
    """
    away = np.zeros_like(main.points)
    for i in range(len(main.offsets) - 1):
        a, b = slice(*main.offsets[i : i + 2]), slice(*other.offsets[i : i + 2])
        t, s = main.time[a], other.time[b]
        if not len(t):
            continue
        right = np.clip(np.searchsorted(s, t), 0, len(s) - 1)
        left = np.maximum(right - 1, 0)
        near = np.where(np.abs(s[left] - t) < np.abs(s[right] - t), left, right)
        away[a] = main.points[a] - other.points[b][near] - other.velocity[b][near] * (t - s[near])[:, None]
    return away


def answers(model: Model, run: Run, at: Floats, progress: Progress) -> Answers | None:
    """How each position answers to errors of samples, law and seed; None if there are too many answers to keep."""
    traces = run.traces
    times = [traces.time[a:b] for a, b in zip(traces.offsets[:-1], traces.offsets[1:], strict=True)]
    second = _second(model) * run.sign
    kept = 0

    def slab(first: int) -> Any:
        nonlocal kept
        if kept > MOST_ANSWERS:
            return None
        some = slice(first, first + SLAB // 8)
        found = kernels.trace_flow.answers(run.flow, at[some], times[some], second)
        kept += len(found.sample)
        return found

    parts = progress.map(slab, range(0, len(at), SLAB // 8))
    if kept > MOST_ANSWERS:
        return None
    count = model.grid.count
    blocks = [
        csr_array(bsr_array((p.answer * run.sign, p.sample % count, p.start), shape=(3 * len(p.drift), 3 * count)).tocsr())
        for p in parts
    ]
    matrix = csr_array(vstack(blocks, format="csr")) if blocks else csr_array((0, 3 * count))
    matrix.sum_duplicates()
    return Answers(matrix, np.concatenate([p.drift for p in parts]), np.concatenate([p.growth for p in parts]))


def _second(model: Model) -> Floats:
    """(nz, ny, nx, 3, 3) second derivative of each component along each axis, 0 where it is not known."""
    grid = model.grid
    values = np.asarray(model.samples.values, float)
    second = np.zeros((*grid.shape, 3, 3))
    for axis in range(grid.dimensions):
        for c in range(grid.dimensions):
            second[..., axis, c] = np.nan_to_num(second_derivative(grid, values[..., c], axis), nan=0.0)
    return second if grid.dimensions == 3 else np.stack([second, second])


def order(runs: list[Run]) -> tuple[Ints, Ints, Ints]:
    """Rows of all runs, one run after the other, so that each line runs forward in time through its seed.

    Returns
    -------
    (n,) row of each point; (p + 1,) offsets of the lines; (n,) seed of each point
    """
    starts = np.cumsum([0, *(len(r.traces.time) for r in runs)])
    rows: list[Ints] = []
    for i in range(len(runs[0].traces.offsets) - 1):
        mine = []
        for run, start in zip(runs, starts, strict=False):
            a, b = run.traces.offsets[i : i + 2]
            found = start + np.arange(a, b)
            mine.append(found if run.sign > 0 else found[::-1])
        if len(mine) == 2 and len(mine[0]) and len(mine[1]):
            mine[0] = mine[0][:-1]  # the seed comes once
        rows.append(np.concatenate(mine))
    sizes = np.array([len(r) for r in rows], np.int64)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    flat = np.concatenate(rows) if rows else np.zeros(0, np.int64)
    return flat.astype(np.int64), offsets, np.repeat(np.arange(len(rows)), sizes)
