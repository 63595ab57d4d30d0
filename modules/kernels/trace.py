"""Particle traces through a velocity field that is smooth cell by cell, with what is known of their errors.

`march` follows a batch of particles through a field of `trace_fields`. With `faces` each step stays within one cell's
polynomial and ends on the face that it crosses; without, steps go over the faces, as the thesis's did, and lose their order
there. In an unsteady field steps end at the times of its values, between which it is linear.

Rules
-----
- The border of the domain is an exit only where the velocity points outwards: at a wall whose samples are at rest it does
  not, and steps that would overshoot are halved. A trace that creeps along a wall ends by its time or its steps.
- The position where a trace ends is always recorded.
- A sample that is not finite makes a hole of the cells around it; a trace ends where it would enter one. Without `faces`
  it ends with the step that no longer fits beside the hole.
- Backwards is a march through the opposite field; times are given as they are then, negative.

Source: Lopes 1999, 5.2.4; restarts at faces: order of Runge-Kutta methods needs a smooth field.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels import trace_march as m
from modules.kernels._jit import jit, lean_part
from modules.kernels.runge_kutta import PAIRS
from modules.kernels.trace_beside import assess, chord, shortened, write
from modules.kernels.trace_cell import HIGH, LOW, NT, TIMES, Flow, load, nowhere, onwards, place, time_of
from modules.kernels.trace_fields import cells_across, flow_of, measures
from modules.kernels.trace_march import HIGHEST, LOWEST, Rules, advance, begin
from modules.kernels.trace_step import APART, END, ERROR, SIZE, START, along, blank

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Control = Literal["extent", "nag", "fixed", "cell", "curvature"]

__all__ = ["CONTROLS", "REASONS", "Control", "Traces", "flow_of", "march", "rules_of", "tableau_of", "warm"]

CONTROLS = {"extent": m.EXTENT, "nag": m.NAG, "fixed": m.FIXED, "cell": m.CELL, "curvature": m.CURVATURE}
REASONS = (
    "end time", "left the domain", "at rest", "hole", "largest length", "most steps", "began outside", "steps too small",
    "no data for this time",
)  # fmt: skip
"""In words, by the number in `Traces.reason`."""

_TIME, _PLACE, _VELOCITY, _RESIDUAL, _ERROR, _LOCAL, _WIDTH = 0, 1, 4, 7, 10, 13, 16
_GO, _LEFT, _HOLE, _LONG, _SPENT, _STALLED, _NO_DATA = m.GO, m.LEFT, m.HOLE, m.LONG, m.SPENT, m.STALLED, m.NO_DATA
_INSIDE, _FACE = m.INSIDE, m.FACE
FINEST = 10 * float(np.finfo(float).eps)
"""No local error can be kept below this part of the domain."""

_TINY = 200  # steps below the smallest worth taking, one after the other, that end a trace


class Traces(NamedTuple):
    """Traces of p particles: n positions in all.

    Attributes
    ----------
    offsets : (p + 1,) positions of particle i are offsets[i]:offsets[i + 1]; none where it began outside or in a hole
    time : (n,) since the particle was released
    points, velocity : (n, 3) position, and velocity of the field there
    residual : (n, 3) velocity that the dense output infers less that of the field, thesis (5.8)
    error : (n, 3) estimate of primary position - exact, by parts of the steps; zeros if not asked for
    local : (n, 3) error estimate of the step that holds the position
    reason : (p,) index into `REASONS`
    steps, refused, evaluations : (p,) counts
    length : (p,) of the chords of the steps
    trusted : (p,) time from which on the assessment is not credible by RKSUITE's rule; inf if it is throughout
    """

    offsets: Integers
    time: Floats
    points: Floats
    velocity: Floats
    residual: Floats
    error: Floats
    local: Floats
    reason: Integers
    steps: Integers
    refused: Integers
    evaluations: Integers
    length: Floats
    trusted: Floats


def rules_of(
    flow: Flow,
    *,
    pair: str = "Dormand-Prince 5(4)",
    control: Control = "extent",
    tolerance: float = 1e-6,
    size: float = 0.0,
    end: float = math.inf,
    interval: float = 0.0,
    length: float = math.inf,
    steps: int = 100_000,
    faces: bool = True,
    halve: bool = False,
    assess: bool = False,
    subsidiary: bool = False,
) -> Rules:
    """The rules of a march through a field, checked.

    Under the control "extent" with `faces` a step, which takes at most one cell, gets its share of the tolerance: so many
    cells as lie across the domain make an error of about the tolerance together.

    Raises
    ------
    ValueError
        Unknown or ill-matched: a method without error estimate under error control, a tolerance out of range, no restarts
        where cells are no boxes.
    """
    if pair not in PAIRS:
        raise ValueError(f"there is no method {pair!r}: methods are {', '.join(PAIRS)}")
    method = PAIRS[pair]
    controlled = control in ("extent", "nag")
    if controlled and not method.estimate:
        raise ValueError(f"{pair} has no error estimate to control its steps by: take fixed steps, or by cell or curvature")
    highest = 0.01 if control == "nag" else 0.1
    if controlled and not FINEST <= tolerance <= highest:
        raise ValueError(f"the tolerance must be from ten times the machine precision to {highest}, not {tolerance:g}")
    if not controlled and not size > 0:
        raise ValueError(f"the size of the steps must be positive, not {size:g}")
    if not end >= 0 or not interval >= 0 or not length >= 0 or steps < 1:
        raise ValueError("end time, interval and length must not be negative, and there must be a step")
    box, speed, known, boxes = measures(flow)
    if not boxes and not faces:
        raise ValueError("steps over faces need cells that are boxes: keep the restarts on this grid")
    if not boxes and control == "nag":
        raise ValueError("the weights of NAG need a grid whose cells are boxes: let the extent control the steps")
    whole = float(np.linalg.norm(box[3] - box[2])) / speed if speed else 1.0
    parts = 3 if method.order == 3 else 2
    allowed = max(tolerance / cells_across(flow), FINEST) if faces and control == "extent" else tolerance
    return Rules(
        CONTROLS[control], float(allowed), float(size), 1.0 / (method.estimate + 1),
        0.18 ** (method.estimate + 1), 1.0 / (1.0 - float(parts) ** -method.order), box,
        0.01 * whole, 1e-14 * whole, float(end), float(interval), float(length), int(steps), 1e-12 * speed, speed, bool(faces),
        bool(halve), bool(assess), parts, bool(subsidiary), not known,
    )  # fmt: skip


def tableau_of(pair: str) -> Floats:
    """(s + 5, s + 1) a method's weights as the compiled code takes them: stages with their times in the last column, then
    the weights of the error and of the four powers of the dense output.
    """
    method = PAIRS[pair]
    weights = np.vstack([method.stages, method.error[None], method.dense.T])
    times = np.concatenate([method.stages.sum(axis=1), np.zeros(5)])
    return np.ascontiguousarray(np.column_stack([weights, times]))


def march(
    flow: Flow,
    seeds: Floats,
    rules: Rules,
    pair: str = "Dormand-Prince 5(4)",
    *,
    cells: Integers | None = None,
    release: Floats | None = None,
) -> Traces:
    """Follow particles through a field until each ends; the caller shares out many seeds as slabs.

    Parameters
    ----------
    flow : from `trace_fields`
    seeds : (p, 3) where they begin, in coordinates of the march
    rules : from `rules_of`
    pair : the method
    cells : (p,) tetrahedra in which they begin, -1: none; needed there
    release : (p,) times at which they begin; that of the first values if not given

    Accuracy: with `faces` the order of the method; the global error is estimated by n parts of each step,
        two or of order 3 three, times n^p / (n^p - 1).
    Source: Lopes 1999, 5.2.4; (5.3) to (5.7) with the control "nag".
    """
    at = np.ascontiguousarray(np.asarray(seeds, np.float64).reshape(-1, 3)).copy()
    first = np.zeros(len(at), np.int64) if cells is None else np.ascontiguousarray(cells, np.int64).copy()
    begins = np.full(len(at), flow.numbers[flow.whole[TIMES]]) if release is None else release
    since = np.ascontiguousarray(begins, np.float64).copy()
    rows, offsets, counts, sums = _march(flow, at, first, since, tableau_of(pair), rules)
    rows = rows[: offsets[-1]]
    points, velocity, residual, error, local = (
        np.ascontiguousarray(rows[:, a : a + 3]) for a in (_PLACE, _VELOCITY, _RESIDUAL, _ERROR, _LOCAL)
    )
    reason, steps, refused, evaluations = (np.ascontiguousarray(counts[:, c]) for c in range(4))
    return Traces(
        offsets=offsets, time=np.ascontiguousarray(rows[:, _TIME]), points=points, velocity=velocity, residual=residual,
        error=error, local=local, reason=reason, steps=steps, refused=refused, evaluations=evaluations,
        length=sums[:, 0].copy(), trusted=sums[:, 1].copy(),
    )  # fmt: skip


@jit
def _march(
    flow: Flow, seeds: Floats, first: Integers, since: Floats, tableau: Floats, rules: Rules
) -> tuple[Floats, Integers, Integers, Floats]:
    here, beside, step, half = nowhere(), nowhere(), blank(), blank()
    walls = here
    if not rules.faces:
        walls = nowhere()
        for c in range(3):
            walls[LOW, c], walls[HIGH, c] = rules.box[LOWEST, c], rules.box[HIGHEST, c]
    rows = np.zeros((64 + 16 * len(seeds), _WIDTH))
    offsets = np.zeros(len(seeds) + 1, np.int64)
    counts = np.zeros((len(seeds), 4), np.int64)
    sums = np.zeros((len(seeds), 2))
    n = 0
    for i in range(len(seeds)):
        rows, n = _one(
            flow, here, beside, walls, tableau, rules, step, half, seeds[i], first[i], since[i], rows, n, counts[i], sums[i]
        )
        offsets[i + 1] = n
    return rows, offsets, counts, sums


@jit
def _room(rows: Floats, n: int) -> Floats:
    """Rows with room for one more and the end."""
    if n + 2 < len(rows):
        return rows
    larger = np.zeros((2 * len(rows), _WIDTH))
    larger[:n] = rows[:n]
    return larger


@lean_part
def _in_time(limit: float, step: Floats, how: int, taken: float) -> tuple[int, float]:
    """How a step ends and its time, cut at the time left: a step to a face may go a little beyond."""
    if taken <= limit or not step[SIZE, 0] > 0.0:
        return how, taken
    theta = min(limit / step[SIZE, 0], 1.0)
    for c in range(3):
        step[END, c] = along(step, c, theta)
    return _INSIDE, limit


@lean_part
def _beyond(flow: Flow, here: Floats, cell: Integers, rules: Rules, face: int) -> int:
    """Go on into the cell beyond the face that a step ended on; GO, or why there is none."""
    code = onwards(flow, here, cell, face) if rules.faces else 1
    return _GO if code == 0 else (_LEFT if code == 1 else _HOLE)


@lean_part
def _spent(flow: Flow, here: Floats, cell: Integers, rules: Rules, steps: int, tiny: int, now: float) -> int:
    """GO, or why no more steps may be taken; stands in the time step of `now` if they may."""
    if tiny > _TINY:
        return _STALLED
    if steps >= rules.steps:
        return _SPENT
    return _GO if _next_slab(flow, here, cell, now) else _NO_DATA


@lean_part
def _stand_at(p: Floats, step: Floats) -> None:
    """Begin a step at a position."""
    step[SIZE, 0] = 0.0
    for c in range(3):
        step[START, c] = step[END, c] = p[c]
        step[ERROR, c] = 0.0


@lean_part
def _next_slab(flow: Flow, here: Floats, cell: Integers, now: float) -> bool:
    """Go to the time step that a time belongs to; whether there is one."""
    last = flow.whole[NT] - 1
    if last == 0:
        return True
    slack = 1e-14 * abs(time_of(flow, last))
    if now >= time_of(flow, last) - slack:
        return False
    while cell[3] < last - 1 and now >= time_of(flow, cell[3] + 1) - slack:
        cell[3] += 1
        load(flow, here, cell)
    return True


@jit
def _sampled(
    flow: Flow, here: Floats, cell: Integers, rules: Rules, clock: float, begin: float, end: float, step: Floats, rows: Floats,
    n: int, sampled: int,
) -> tuple[Floats, int, int]:  # fmt: skip
    """Write the rows of the sampling times in a step; returns them, how many there are, and the number of the next time."""
    while rules.interval > 0.0 and sampled * rules.interval <= end * (1.0 + 1e-14):
        rows = _room(rows, n)
        theta = min((sampled * rules.interval - begin) / step[SIZE, 0], 1.0) if step[SIZE, 0] > 0.0 else 1.0
        write(flow, here, cell, rules, clock, sampled * rules.interval, theta, step, rows[n])
        n += 1
        sampled += 1
    return rows, n, sampled


@jit
def _one(
    flow: Flow, here: Floats, beside: Floats, walls: Floats, tableau: Floats, rules: Rules, step: Floats, half: Floats,
    seed: Floats, first: int, clock: float, rows: Floats, n: int, counts: Integers, sums: Floats,
) -> tuple[Floats, int]:  # fmt: skip
    """Follow one particle; returns the rows, and how many there are now."""
    cell, other, tally, trust = np.zeros(4, np.int64), np.zeros(4, np.int64), np.zeros(2, np.int64), np.zeros(2)
    counts[0] = begin(flow, here, cell, rules, seed, first, clock)
    sums[1] = np.inf
    if counts[0] != _GO:
        return rows, n
    _stand_at(seed, step)
    _stand_at(seed, half)
    step[APART, :] = 0.0
    begin(flow, beside, other, rules, seed, first, clock)
    rows = _room(rows, n)
    write(flow, here, cell, rules, clock, 0.0, 2.0, step, rows[n])
    n += 1
    t, h, taken, tiny, sampled, how = 0.0, rules.first, 0.0, 0, 1, _FACE
    while t < rules.end * (1.0 - 1e-14):
        counts[0] = _spent(flow, here, cell, rules, counts[1], tiny, clock + t)
        if counts[0] != _GO:
            break
        limit = _time_left(flow, rules, cell, clock, t)
        how, taken, h, face = advance(
            flow, here, cell, walls, tableau, rules, clock + t, h, limit, how == _FACE, step, tally
        )
        if how >= 0:
            counts[0], step[SIZE, 0] = how, 0.0
            step[END] = step[START]
            break
        counts[1] += 1
        how, taken = _in_time(limit, step, how, taken)
        tiny = tiny + 1 if taken < rules.smallest else 0
        counts[0], taken = _measured(flow, here, rules, step, taken, sums)
        begun = n
        rows, n, sampled = _sampled(flow, here, cell, rules, clock, t, min(t + taken, rules.end), step, rows, n, sampled)
        if rules.assess:
            _next_slab(flow, beside, other, clock + t)
            assess(flow, here, beside, other, tableau, rules, clock, t, taken, step, half, rows, begun, n, trust, sums)
        t += taken
        if rules.interval == 0.0:
            rows = _room(rows, n)
            _last(flow, here, cell, beside, rules, clock, t, step, half, rows[n])
            n += 1
        if counts[0] == _GO and how == _FACE:
            counts[0] = _beyond(flow, here, cell, rules, face)
        if counts[0] != _GO:
            break
        _stand_at(step[END], step)
    if t - rows[n - 1, _TIME] > 1e-12 * t:
        _last(flow, here, cell, beside, rules, clock, t, step, half, rows[n])
        n += 1
    counts[2], counts[3] = tally[0], tally[1] + counts[1]
    return rows, n


@lean_part
def _time_left(flow: Flow, rules: Rules, cell: Integers, clock: float, t: float) -> float:
    """Until the end, or the next time of the values."""
    if flow.whole[NT] == 1:
        return rules.end - t
    return min(rules.end - t, time_of(flow, cell[3] + 1) - (clock + t))


@lean_part
def _measured(flow: Flow, here: Floats, rules: Rules, step: Floats, taken: float, sums: Floats) -> tuple[int, float]:
    """Add a step to the length of its trace: GO or LONG, and the time that it takes, less if it is cut."""
    why = _GO
    if rules.length < np.inf:
        short = shortened(flow.form, here, rules, step, taken, sums[0])
        if short < taken or sums[0] >= rules.length:
            why, taken = _LONG, short
    sums[0] += chord(flow.form, here, step, 2.0)
    return why, taken


@lean_part
def _last(
    flow: Flow, here: Floats, cell: Integers, beside: Floats, rules: Rules, clock: float, t: float, step: Floats, half: Floats,
    row: Floats,
) -> None:  # fmt: skip
    """Write the end of a step, of the march that is reported."""
    write(flow, here, cell, rules, clock, t, 2.0, step, row)
    if rules.assess and rules.subsidiary:
        at = place(flow.form, beside, half[START, 0], half[START, 1], half[START, 2])
        for c in range(3):
            row[_PLACE + c] = at[c]


def warm() -> None:
    """Compile the kernels of a march."""
    axis = np.linspace(-1.0, 1.0, 3)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    flow = flow_of(np.stack([-y, x, 0.1 + 0 * z], axis=-1), axis, axis, axis)
    march(flow, np.array([[0.5, 0.0, -0.5]]), rules_of(flow, end=1.0, interval=0.3, assess=True))
