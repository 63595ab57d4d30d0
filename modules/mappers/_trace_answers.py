"""How a trace answers to errors of samples where the compiled way does not go: through cubic laws and on bent lattices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.sparse import bsr_array, csr_array

from modules.api import Curvilinear, Model, Progress, Rectilinear, Regular
from modules.data.grid import lattice_of
from modules.mappers._trace_field import Medium, located
from modules.mappers._trace_proof import Rows, with_steps
from modules.mappers._trace_run import MOST_ANSWERS, Answers, Run

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Pieces(NamedTuple):
    """Of s pieces of traces: growth over each and over its second half (s, 3, 3); samples and their weights at its begin,
    middle and end, (3, s, k); errors of the field there (3, s, e, 3), of e sources.
    """

    growth: Floats
    late: Floats
    sample: Ints
    weight: Floats
    error: Floats


def carries(model: Model, field: Medium) -> bool:
    """Whether errors can be brought along here: a cubic law in boxes, or a linear one on a bent lattice in physical space."""
    if isinstance(model.grid, Curvilinear):
        return model.law.name == "linear" and field.lattice is None
    return isinstance(model.grid, Regular | Rectilinear) and model.law.name == "cubic"


def answers_along(model: Model, run: Run, pair: str, rules: Mapping[str, Any], progress: Progress) -> Answers | None:
    """How each position answers to errors of samples, law and seed; None if there are too many answers to keep.

    Each piece between two ends of steps grows by e^(J h) with J in its middle, and the law's weights along it are
    integrated by Simpson's rule. On a bent lattice the error of the law is not known, and the drift None.
    """
    rows = with_steps(run, pair, rules, progress.part(0.0, 0.1))
    found = summed(rows, _pieces(model, run.sign, rows), model.grid.count, run.sign, progress.part(0.1, 1.0))
    if found is None:
        return None
    matrix, drift, growth = found
    return Answers(matrix, drift[:, 0] if drift.shape[1] else None, growth)


def summed(
    rows: Rows, pieces: Pieces, count: int, sign: int, progress: Progress
) -> tuple[csr_array, Floats, Floats] | None:
    """What the pieces of traces add up to, at the rows of the run; None if that is too much to keep.

    Returns
    -------
    (3 n, 3 count) answers to the samples; (n, e, 3) displacement by the errors of the field; (n, 3, 3) growth
    """
    begins = pieces_begin(rows)
    h, place = np.diff(rows.time)[begins], np.searchsorted(begins, np.arange(len(rows.time)))
    wanted = np.zeros(len(rows.time), bool)
    wanted[rows.mine] = True
    blocks: dict[int, tuple[Ints, Floats]] = {}
    growth, kept = np.zeros((len(rows.time), 3, 3)), 0
    drift = np.zeros((len(rows.time), pieces.error.shape[2], 3))
    for i, (a, b) in enumerate(pairwise(rows.offsets)):
        progress(i / len(rows.offsets))
        mine = place[a : max(b - 1, a)]
        touched, local = np.unique(pieces.sample[:, mine], return_inverse=True)
        local = local.reshape(pieces.sample[:, mine].shape)
        answer, phi, away = np.zeros((len(touched), 3, 3)), np.eye(3), np.zeros(drift.shape[1:])
        growth[a:b] = phi
        for k, piece in enumerate(mine):
            if wanted[a + k]:
                blocks[a + k] = touched, answer.copy()
            answer, phi, away = _over(pieces, piece, h[piece], local[:, k], answer, phi, away)
            growth[a + k + 1], drift[a + k + 1] = phi, away
        if b > a:
            blocks[b - 1] = touched, answer
        kept += len(touched) * int(wanted[a:b].sum())
        if kept > MOST_ANSWERS:
            return None
    parts = [blocks[r] for r in rows.mine.tolist()]
    indptr = np.cumsum([0, *(len(t) for t, _ in parts)])
    data = np.concatenate([np.zeros((0, 3, 3)), *(s for _, s in parts)]) * sign
    index = np.concatenate([np.zeros(0, np.int64), *(t for t, _ in parts)])
    matrix = csr_array(bsr_array((data, index, indptr), shape=(3 * len(parts), 3 * count)).tocsr())
    return matrix, sign * drift[rows.mine], growth[rows.mine]


def pieces_begin(rows: Rows) -> Ints:
    """The rows where a piece begins: all but the last of each trace."""
    return np.setdiff1d(np.arange(len(rows.time)), rows.offsets[1:] - 1)


def _over(
    pieces: Pieces, k: int, h: float, local: Ints, answer: Floats, phi: Floats, away: Floats
) -> tuple[Floats, Floats, Floats]:
    """Answers, growth and drift at the end of a piece, by those at its begin."""
    answer, phi, away = pieces.growth[k] @ answer, pieces.growth[k] @ phi, away @ pieces.growth[k].T
    carry = (h / 6 * pieces.growth[k], 4 * h / 6 * pieces.late[k], h / 6 * np.eye(3))
    for at in range(3):
        np.add.at(answer, local[at], pieces.weight[at, k][:, None, None] * carry[at])
        away = away + pieces.error[at, k] @ carry[at].T
    return answer, phi, away


def _pieces(model: Model, sign: int, rows: Rows) -> Pieces:
    """The pieces of a trace in a steady flow."""
    begins = pieces_begin(rows)
    h, bent = np.diff(rows.time)[begins], isinstance(model.grid, Curvilinear)
    grid: Any = lattice_of(model.grid) if bent else model.grid
    places = [_within(model, at) for at in along_pieces(rows, begins)]
    found = [model.law.weights(grid, at) for at in places]
    slope = sign * _slope(model, grid, places[1])
    error = np.zeros((3, len(h), 0, 3)) if bent else np.stack([law_error(model, at) for at in places])[:, :, None]
    return Pieces(
        expm(slope * h[:, None, None]), expm(slope * h[:, None, None] / 2), np.stack([f.index for f in found]),
        np.stack([np.broadcast_to(f.weight, f.index.shape) for f in found]), error,
    )  # fmt: skip


def along_pieces(rows: Rows, begins: Ints) -> tuple[Floats, Floats, Floats]:
    """Positions at the begin, the middle and the end of pieces."""
    p, q, v, w = rows.points[begins], rows.points[begins + 1], rows.velocity[begins], rows.velocity[begins + 1]
    return p, 0.5 * (p + q) + np.diff(rows.time)[begins, None] / 8 * (v - w), q


def _slope(model: Model, grid: Any, at: Floats) -> Floats:
    """(n, 3, 3) derivative of the velocity in physical space, at places as the law takes them."""
    flat, d = np.asarray(model.samples.values, float).reshape(model.grid.count, -1), grid.dimensions
    slopes = model.law.slopes(grid, at)
    along = np.stack([[s.apply(flat[:, c]) for c in range(d)] for s in slopes]).transpose(2, 1, 0)
    if isinstance(model.grid, Curvilinear):
        nodes = model.grid.nodes.reshape(-1, 3)
        bend = np.stack([[s.apply(nodes[:, c]) for c in range(d)] for s in slopes]).transpose(2, 1, 0)
        along = along @ np.linalg.inv(bend)
    slope = np.zeros((len(at), 3, 3))
    slope[:, :d, :d] = along
    return slope


def law_error(model: Model, at: Floats) -> Floats:
    """(n, 3) the law's own error at positions in boxes, 0 where it is not known."""
    values, error = np.asarray(model.samples.values, float), np.zeros((len(at), 3))
    for c in range(model.grid.dimensions):
        error[:, c] = np.nan_to_num(model.law.error(model.grid, values[..., c], at), nan=0.0)
    return error


def unsteady_pieces(models: Sequence[Model], rows: Rows, begin: float) -> Pieces:
    """The pieces of traces in a series of models of boxes, linear in time: samples of model m are m times their count on.

    Errors of the field are two: that of the laws, and that of the line between two times, by half of
    u (1 - u) times the square of its length times the second difference in time.
    """
    begins = pieces_begin(rows)
    h, times = np.diff(rows.time)[begins], np.array([m.samples.time for m in models], float)
    clock = begin + rows.time
    when = (clock[begins], clock[begins] + 0.5 * h, clock[begins + 1])
    slab = np.clip(np.searchsorted(times, when[1], side="right") - 1, 0, len(times) - 2)
    places = [_within(models[0], at) for at in along_pieces(rows, begins)]
    u = [np.clip((t - times[slab]) / (times[slab + 1] - times[slab]), 0.0, 1.0) for t in when]
    found = [models[0].law.weights(models[0].grid, at) for at in places]
    count, error, slope = models[0].grid.count, np.zeros((3, len(h), 2, 3)), np.zeros((len(h), 3, 3))
    for m in np.unique([slab, slab + 1]):
        share = [np.where(slab == m, 1 - v, np.where(slab + 1 == m, v, 0.0)) for v in u]
        slope += share[1][:, None, None] * _slope(models[m], models[m].grid, places[1])
        for at, place in enumerate(places):
            error[at, :, 0] += share[at][:, None] * law_error(models[m], place)
    for at in range(3):
        error[at, :, 1] = _time_error(models, times, slab, u[at], found[at])
    early, late = count * slab[:, None], count * (slab + 1)[:, None]
    index = np.stack([np.concatenate([f.index + early, f.index + late], 1) for f in found])
    weights = [np.broadcast_to(f.weight, f.index.shape) for f in found]
    weight = np.stack([np.concatenate([w * (1 - v)[:, None], w * v[:, None]], 1) for w, v in zip(weights, u, strict=True)])
    return Pieces(expm(slope * h[:, None, None]), expm(slope * h[:, None, None] / 2), index, weight, error)


def _time_error(models: Sequence[Model], times: Floats, slab: Ints, u: Floats, weights: Any) -> Floats:
    """(n, 3) error of the line between two times: by the mean of the second differences at its ends, of one at a border."""
    error = np.zeros((len(u), 3))
    if len(times) < 3:
        return error
    values = [np.asarray(m.samples.values, float).reshape(m.grid.count, -1) for m in models]
    bends = []
    for m in range(1, len(times) - 1):
        early, late = times[m] - times[m - 1], times[m + 1] - times[m]
        bends.append(2 * ((values[m + 1] - values[m]) / late - (values[m] - values[m - 1]) / early) / (early + late))
    for s in np.unique(slab):
        ends = [bends[m - 1] for m in (s, s + 1) if 1 <= m <= len(bends)]
        some, size = slab == s, times[s + 1] - times[s]
        for c in range(models[0].grid.dimensions):
            told = weights.apply(np.mean([e[:, c] for e in ends], axis=0))[some]
            error[some, c] = 0.5 * u[some] * (1 - u[some]) * size**2 * told
    return error


def _within(model: Model, at: Floats) -> Floats:
    """Positions as the law takes them: within the domain, on a bent grid in coordinates of its lattice."""
    grid = model.grid
    if not isinstance(grid, Curvilinear):
        ends = np.asarray(grid.bounds).reshape(-1, 2)[: grid.dimensions]
        inside = at.copy()
        inside[:, : grid.dimensions] = np.clip(at[:, : grid.dimensions], ends[:, 0], ends[:, 1])
        return inside
    found = located(grid, at)
    known = np.where(np.isfinite(found).all(axis=1), np.arange(len(found)), 0)
    return np.asarray(found[np.maximum.accumulate(known)])  # by rounding outside: where it was before
