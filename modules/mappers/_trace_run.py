"""Particles followed slab by slab, in one direction or both, and put together as lines that run forward in time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array, vstack

from modules import kernels
from modules.api import Model, Progress
from modules.data.laws import second_derivative
from modules.mappers._trace_field import Medium, in_space

if TYPE_CHECKING:
    from modules.kernels.trace import Traces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLABS = 64
"""About so many slabs, of at least `SLAB` particles."""

SLAB = 64
"""Particles a slab: some milliseconds between two looks at whether the work is still wanted."""

MOST_ANSWERS = 4_000_000
"""More answers of a position to a sample, 72 bytes each, are not kept."""

RKSUITE = "no assessment"


@dataclass(frozen=True, eq=False)
class Answers:
    """How positions answer to errors: of the samples (sparse), of the law (drift, None if not known), of the seeds (growth)."""

    samples: csr_array
    drift: Floats | None
    growth: Floats


@dataclass(frozen=True, eq=False)
class Run:
    """Particles followed in one direction: their rows, with times and velocities as they are in the field.

    Parameters
    ----------
    sign : 1 forward, -1 backward
    medium : the field in the direction of the march, and the seeds
    traces : of all seeds
    error : (n, 3) estimated error of each position, where it is not the one of the march itself
    found : how positions answer to other errors, where that is known
    tube : (n,) proven radius about each position, where there is one
    """

    sign: int
    medium: Medium
    traces: Traces
    error: Floats | None = None
    found: Answers | None = None
    tube: Floats | None = None

    @property
    def estimate(self) -> Floats:
        """(n, 3) estimated error of each position."""
        return self.traces.error if self.error is None else self.error


def follow(
    medium: Medium, sign: int, pair: str, rules: Mapping[str, Any], progress: Progress, release: float | None = None
) -> Run:
    """Follow all particles in one direction, from a time of release in an unsteady flow."""
    checked = kernels.trace.rules_of(medium.flow, pair=pair, **rules)
    size = max(SLAB, -(-len(medium.seeds) // SLABS))

    def march(first: int) -> Any:
        some = slice(first, first + size)
        seeds, cells = medium.seeds[some], None if medium.cells is None else medium.cells[some]
        since = None if release is None else np.full(len(seeds), sign * release)
        return kernels.trace.march(medium.flow, seeds, checked, pair, cells=cells, release=since)

    traces = joined(progress.map(march, range(0, max(len(medium.seeds), 1), size)))
    return Run(sign, medium, traces if medium.lattice is None else in_space(medium.lattice, traces))


def joined(parts: list[Traces]) -> Traces:
    """Traces of all slabs as one."""
    if len(parts) == 1:
        return parts[0]
    counts = np.concatenate([np.diff(p.offsets) for p in parts])
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return kernels.trace.Traces(offsets, *(np.concatenate(columns) for columns in list(zip(*parts, strict=True))[1:]))


def against(main: Traces, other: Traces) -> Floats:
    """(n, 3) how far the positions of a trace lie from those of another march at the same times, thesis (5.9) to (5.12)."""
    away = np.zeros_like(main.points)
    for i in range(len(main.offsets) - 1):
        a, b = slice(*main.offsets[i : i + 2]), slice(*other.offsets[i : i + 2])
        away[a] = main.points[a] - at_times(main.time[a], other.time[b], other.points[b], other.velocity[b])
    return away


def at_times(wanted: Floats, time: Floats, points: Floats, velocity: Floats) -> Floats:
    """(n, 3) positions of a trace at the times of another one, which goes on until the later ends.

    Between two of its rows by the Hermite cubic of positions and velocities; a time that it has is taken as it is; beyond
    its end, since it ended before or took another exit, by its last velocity. Without rows it is nowhere: NaN.
    """
    if not len(time):
        return np.full((len(wanted), 3), np.nan)
    right = np.clip(np.searchsorted(time, wanted), min(1, len(time) - 1), len(time) - 1)
    left = np.maximum(right - 1, 0)
    h = (time[right] - time[left])[:, None]
    u = np.divide((wanted - time[left])[:, None], h, out=np.zeros((len(wanted), 1)), where=h > 0)
    u = np.clip(u, 0.0, 1.0)
    between = (
        (1 + 2 * u) * (1 - u) ** 2 * points[left] + u**2 * (3 - 2 * u) * points[right]
        + h * u * (1 - u) * ((1 - u) * velocity[left] - u * velocity[right])
    )  # fmt: skip
    beyond = np.clip(wanted - time[-1], 0.0, None) + np.clip(wanted - time[0], None, 0.0)
    end = np.where(wanted > time[-1], len(time) - 1, 0)
    return np.asarray(between + beyond[:, None] * velocity[end])


def judged(traces: Traces, better: Model, sign: int) -> Traces:
    """Traces whose residual is against the velocity of another model, infinite beyond that."""
    bounds = np.asarray(better.grid.bounds).reshape(-1, 2)[: better.grid.dimensions]
    at = traces.points[:, : len(bounds)]
    inside = ((at >= bounds[:, 0]) & (at <= bounds[:, 1])).all(axis=1)
    residual = np.full_like(traces.residual, np.inf)
    found = sign * better.at(traces.points[inside])[0]
    found[:, better.grid.dimensions :] = 0.0
    residual[inside] = traces.residual[inside] + traces.velocity[inside] - found
    return traces._replace(residual=residual)


def answers(model: Model, run: Run, progress: Progress) -> Answers | None:
    """How each position answers to errors of samples, law and seed; None if there are too many answers to keep."""
    traces, at = run.traces, run.medium.seeds
    times = [traces.time[a:b] for a, b in zip(traces.offsets[:-1], traces.offsets[1:], strict=True)]
    second = _second(model) * run.sign
    kept = 0

    def slab(first: int) -> Any:
        nonlocal kept
        if kept > MOST_ANSWERS:
            return None
        some = slice(first, first + SLAB // 8)
        found = kernels.trace_flow.answers(run.medium.flow, at[some], times[some], second)
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
    drift, growth = ([getattr(p, name) for p in parts] for name in ("drift", "growth"))
    return Answers(matrix, np.concatenate([np.zeros((0, 3)), *drift]), np.concatenate([np.zeros((0, 3, 3)), *growth]))


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
    if len(runs) == 1 and runs[0].sign > 0:
        offsets = runs[0].traces.offsets
        return np.arange(offsets[-1]), offsets, np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
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


def time_unit(velocity: str, length: str) -> str:
    """The unit of times, where that of velocities tells it."""
    return velocity[len(length) + 1 :] if length and velocity.startswith(f"{length}/") else ""
