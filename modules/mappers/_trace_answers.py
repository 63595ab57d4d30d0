"""How a trace answers to errors of samples where the compiled way does not go: through cubic laws and on bent lattices."""

from __future__ import annotations

from collections.abc import Mapping
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
    middle and end, (3, s, k); error of the law there (3, s, 3), or none known.
    """

    growth: Floats
    late: Floats
    sample: Ints
    weight: Floats
    error: Floats | None


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
    begins = np.setdiff1d(np.arange(len(rows.time)), rows.offsets[1:] - 1)
    h = np.diff(rows.time)[begins]
    pieces = _pieces(model, run.sign, rows, begins, h)
    place = np.searchsorted(begins, np.arange(len(rows.time)))
    wanted = np.zeros(len(rows.time), bool)
    wanted[rows.mine] = True
    blocks: dict[int, tuple[Ints, Floats]] = {}
    growth, drift, kept = np.zeros((len(rows.time), 3, 3)), np.zeros((len(rows.time), 3)), 0
    for i, (a, b) in enumerate(pairwise(rows.offsets)):
        progress(0.1 + 0.9 * i / len(rows.offsets))
        mine = place[a : max(b - 1, a)]
        touched, local = np.unique(pieces.sample[:, mine], return_inverse=True)
        local = local.reshape(pieces.sample[:, mine].shape)
        answer, phi, away = np.zeros((len(touched), 3, 3)), np.eye(3), np.zeros(3)
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
    data = np.concatenate([np.zeros((0, 3, 3)), *(s for _, s in parts)]) * run.sign
    index = np.concatenate([np.zeros(0, np.int64), *(t for t, _ in parts)])
    matrix = csr_array(bsr_array((data, index, indptr), shape=(3 * len(parts), 3 * model.grid.count)).tocsr())
    return Answers(matrix, None if pieces.error is None else run.sign * drift[rows.mine], growth[rows.mine])


def _over(
    pieces: Pieces, k: int, h: float, local: Ints, answer: Floats, phi: Floats, away: Floats
) -> tuple[Floats, Floats, Floats]:
    """Answers, growth and drift at the end of a piece, by those at its begin."""
    answer, phi, away = pieces.growth[k] @ answer, pieces.growth[k] @ phi, pieces.growth[k] @ away
    carry = (h / 6 * pieces.growth[k], 4 * h / 6 * pieces.late[k], h / 6 * np.eye(3))
    for at in range(3):
        answer[local[at]] += pieces.weight[at, k][:, None, None] * carry[at]
        if pieces.error is not None:
            away = away + carry[at] @ pieces.error[at, k]
    return answer, phi, away


def _pieces(model: Model, sign: int, rows: Rows, begins: Ints, h: Floats) -> Pieces:
    p, q, v, w = rows.points[begins], rows.points[begins + 1], rows.velocity[begins], rows.velocity[begins + 1]
    middle = 0.5 * (p + q) + h[:, None] / 8 * (v - w)
    bent = isinstance(model.grid, Curvilinear)
    grid: Any = lattice_of(model.grid) if bent else model.grid
    places = [_within(model, at) for at in (p, middle, q)]
    flat = np.asarray(model.samples.values, float).reshape(model.grid.count, -1)
    found = [model.law.weights(grid, at) for at in places]
    d = grid.dimensions
    slope = np.zeros((len(h), 3, 3))
    along = np.stack([[s.apply(flat[:, c]) for c in range(d)] for s in model.law.slopes(grid, places[1])]).transpose(2, 1, 0)
    if isinstance(model.grid, Curvilinear):
        nodes = model.grid.nodes.reshape(-1, 3)
        bend = [[s.apply(nodes[:, c]) for c in range(d)] for s in model.law.slopes(grid, places[1])]
        along = along @ np.linalg.inv(np.stack(bend).transpose(2, 1, 0))
    slope[:, :d, :d] = sign * along
    error = None
    if not bent:
        error = np.zeros((3, len(h), 3))
        for at, place in enumerate(places):
            for c in range(d):
                told = model.law.error(grid, flat[:, c].reshape(grid.shape), place)
                error[at, :, c] = np.nan_to_num(told, nan=0.0)
    return Pieces(
        expm(slope * h[:, None, None]), expm(slope * h[:, None, None] / 2), np.stack([f.index for f in found]),
        np.stack([np.broadcast_to(f.weight, f.index.shape) for f in found]), error,
    )  # fmt: skip


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
