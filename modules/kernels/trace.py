"""Particle traces through a trilinear velocity field on a rectilinear grid, with what is known of their errors.

`march` follows a batch of particles. With `faces` each step stays within one cell's polynomial and ends on the face that
it crosses; without, steps go over the faces, as the thesis's did, and lose their order there.

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
from modules.kernels._jit import jit
from modules.kernels.runge_kutta import PAIRS
from modules.kernels.trace_cell import Flow, Here, load, nowhere, onwards
from modules.kernels.trace_march import Rules, advance, begin, distance, follow, shortened, write
from modules.kernels.trace_step import Step, Tableau, along, blank

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Control = Literal["extent", "nag", "fixed", "cell", "curvature"]

CONTROLS = {"extent": m.EXTENT, "nag": m.NAG, "fixed": m.FIXED, "cell": m.CELL, "curvature": m.CURVATURE}
REASONS = (
    "end time", "left the domain", "at rest", "hole", "largest length", "most steps", "began outside", "steps too small",
)  # fmt: skip
"""In words, by the number in `Traces.reason`."""

_TIME, _PLACE, _VELOCITY, _RESIDUAL, _ERROR, _LOCAL, _WIDTH = 0, 1, 4, 7, 10, 13, 16
_END, _LEFT, _HOLE, _LENGTH, _STEPS, _STALLED = m.END, m.LEFT, m.HOLE, m.LENGTH, m.STEPS, m.STALLED
_INSIDE, _FACE = m.INSIDE, m.FACE
_TINY = 200  # steps below the smallest worth taking, one after the other, that end a trace


class Traces(NamedTuple):
    """Traces of p particles: n positions in all.

    Attributes
    ----------
    offsets : (p + 1,) positions of particle i are offsets[i]:offsets[i + 1]; none where it began outside or in a hole
    time : (n,)
    points, velocity : (n, 3) position, and velocity of the field there
    residual : (n, 3) velocity that the dense output infers less that of the field, thesis (5.8)
    error : (n, 3) estimate of position - exact, by two half steps; zeros if not asked for
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
) -> Rules:
    """The rules of a march through a field, checked.

    Raises
    ------
    ValueError
        Unknown or ill-matched: a method without error estimate under error control, a tolerance out of range.
    """
    if pair not in PAIRS:
        raise ValueError(f"there is no method {pair!r}: methods are {', '.join(PAIRS)}")
    method = PAIRS[pair]
    controlled = control in ("extent", "nag")
    if controlled and not method.estimate:
        raise ValueError(f"{pair} has no error estimate to control its steps by: take fixed steps, or by cell or curvature")
    highest = 0.01 if control == "nag" else 0.1
    if controlled and not 10 * np.finfo(float).eps <= tolerance <= highest:
        raise ValueError(f"the tolerance must be from ten times the machine precision to {highest}, not {tolerance:g}")
    if not controlled and not size > 0:
        raise ValueError(f"the size of the steps must be positive, not {size:g}")
    if not end >= 0 or not interval >= 0 or not length >= 0 or steps < 1:
        raise ValueError("end time, interval and length must not be negative, and there must be a step")
    low = np.array([axis[0] for axis in flow[1:]])
    high = np.array([axis[-1] for axis in flow[1:]])
    known = flow.values[np.isfinite(flow.values).all(axis=-1)]
    speed = float(np.sqrt((known**2).sum(axis=-1).mean())) if known.size else 0.0
    whole = float(np.linalg.norm(high - low)) / speed if speed else 1.0
    return Rules(
        CONTROLS[control], float(tolerance), float(size), 1.0 / (method.estimate + 1), 1.0 / (1.0 - 0.5**method.order),
        high - low, np.minimum(np.abs(low), np.abs(high)), low, high, 0.01 * whole, 1e-14 * whole, float(end), float(interval),
        float(length), int(steps), 1e-12 * speed, bool(faces), bool(halve), bool(assess),
        known.shape[0] < flow.values.size // 3,
    )  # fmt: skip


def tableau_of(pair: str) -> Tableau:
    """A method's weights as the compiled code takes them."""
    method = PAIRS[pair]
    return Tableau(*(np.ascontiguousarray(a) for a in (method.stages, method.result, method.error, method.dense)))


def flow_of(values: Floats, x: Floats, y: Floats, z: Floats | None = None, *, backwards: bool = False) -> Flow:
    """A field for `march`.

    Parameters
    ----------
    values : (nz, ny, nx, 3), or (ny, nx, 3) with z None: a field of the plane, whose third component is not looked at
    x, y, z : strictly ascending coordinates of the samples
    backwards : whether to take the opposite field

    Raises
    ------
    ValueError
        Shapes do not fit, there is no cell, or a coordinate is not ascending.
    """
    values = np.asarray(values, np.float64)
    if z is None:
        reach = max(float(np.ptp(x)), float(np.ptp(y)))
        z = np.array([-reach, reach])
        flat = values.copy()
        flat[..., 2] = np.where(np.isfinite(flat[..., :2]).all(axis=-1), 0.0, np.nan)
        values = np.stack([flat, flat])
    axes = [np.array(axis, np.float64) for axis in (x, y, z)]
    if values.shape != (axes[2].size, axes[1].size, axes[0].size, 3):
        raise ValueError(f"values of shape {values.shape} do not fit {axes[2].size} x {axes[1].size} x {axes[0].size} samples")
    for name, axis in zip("xyz", axes, strict=True):
        if axis.size < 2 or not (np.diff(axis) > 0).all():
            raise ValueError(f"the {name} coordinates must ascend strictly, and there must be two")
    return Flow(np.ascontiguousarray(-values if backwards else values, np.float64).copy(), *axes)


def march(flow: Flow, seeds: Floats, rules: Rules, pair: str = "Dormand-Prince 5(4)") -> Traces:
    """Follow particles through a field until each ends; the caller shares out many seeds as slabs.

    Parameters
    ----------
    flow : from `flow_of`
    seeds : (p, 3) where they begin
    rules : from `rules_of`
    pair : the method

    Accuracy: with `faces` the order of the method; the global error is estimated by two half steps, times 2^p / (2^p - 1).
    Source: Lopes 1999, 5.2.4; (5.3) to (5.7) with the control "nag".
    """
    at = np.ascontiguousarray(np.asarray(seeds, np.float64).reshape(-1, 3)).copy()
    rows, offsets, counts, sums = _march(flow, at, tableau_of(pair), rules)
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
def _march(flow: Flow, seeds: Floats, tableau: Tableau, rules: Rules) -> tuple[Floats, Integers, Integers, Floats]:
    here, beside, step, half = nowhere(), nowhere(), blank(tableau), blank(tableau)
    rows = np.zeros((64 + 16 * len(seeds), _WIDTH))
    offsets = np.zeros(len(seeds) + 1, np.int64)
    counts = np.zeros((len(seeds), 4), np.int64)
    sums = np.zeros((len(seeds), 2))
    n = 0
    for i in range(len(seeds)):
        rows, n = _one(flow, here, beside, tableau, rules, step, half, seeds[i], rows, n, counts[i], sums[i])
        offsets[i + 1] = n
    return rows, offsets, counts, sums


@jit
def _copy(row: Floats, to: Floats) -> None:
    for c in range(_WIDTH):
        to[c] = row[c]


@jit
def _room(rows: Floats, n: int) -> Floats:
    """Rows with room for one more and the end."""
    if n + 2 < len(rows):
        return rows
    larger = np.zeros((2 * len(rows), _WIDTH))
    for r in range(n):
        _copy(rows[r], larger[r])
    return larger


@jit
def _in_time(rules: Rules, step: Step, t: float, how: int, taken: float) -> tuple[int, float]:
    """How a step ends and its time, cut at the end time: a step to a face may go a little beyond."""
    if t + taken <= rules.end or not step.size[0] > 0.0:
        return how, taken
    theta = min((rules.end - t) / step.size[0], 1.0)
    for c in range(3):
        step.end[c] = along(step, c, theta)
    return _INSIDE, rules.end - t


@jit
def _beyond(flow: Flow, here: Here, rules: Rules, how: int, where: Integers) -> int:
    """Go on into the cell beyond the face that a step ended on; END, or why there is none."""
    if how != _FACE:
        return _END
    code = onwards(flow, here, where[0], where[1]) if rules.faces else 1
    return _END if code == 0 else (_LEFT if code == 1 else _HOLE)


@jit
def _spent(rules: Rules, steps: int, tiny: int) -> int:
    """Whether no more steps may be taken."""
    if tiny > _TINY:
        return _STALLED
    return _STEPS if steps >= rules.steps else _END


@jit
def _stand_at(p: Floats, step: Step, half: Step) -> None:
    """Begin a step, and that of the march beside it, at a position."""
    step.size[0] = 0.0
    for c in range(3):
        step.start[c] = step.end[c] = half.start[c] = p[c]
        step.error[c] = 0.0


@jit
def _sampled(
    flow: Flow, here: Here, rules: Rules, begin: float, end: float, step: Step, rows: Floats, n: int, sampled: int
) -> tuple[Floats, int, int]:
    """Write the rows of the sampling times in a step; returns them, how many there are, and the number of the next time."""
    if rules.interval > 0.0:
        while sampled * rules.interval <= end * (1.0 + 1e-14):
            rows = _room(rows, n)
            theta = min((sampled * rules.interval - begin) / step.size[0], 1.0) if step.size[0] > 0.0 else 1.0
            write(flow, here, rules, sampled * rules.interval, theta, step, rows[n])
            n += 1
            sampled += 1
    return rows, n, sampled


@jit
def _one(
    flow: Flow, here: Here, beside: Here, tableau: Tableau, rules: Rules, step: Step, half: Step, seed: Floats, rows: Floats,
    n: int, counts: Integers, sums: Floats,
) -> tuple[Floats, int]:  # fmt: skip
    """Follow one particle; returns the rows, and how many there are now."""
    where, tally, trust = np.zeros(3, np.int64), np.zeros(2, np.int64), np.zeros(2)
    counts[0] = begin(flow, here, rules, seed)
    sums[1] = np.inf
    if counts[0] != _END:
        return rows, n
    _stand_at(seed, step, half)
    begin(flow, beside, rules, seed)
    rows = _room(rows, n)
    write(flow, here, rules, 0.0, 2.0, step, rows[n])
    n += 1
    tail = np.zeros((1, _WIDTH))
    t, h, taken, tiny, sampled, how = 0.0, rules.first, 0.0, 0, 1, _FACE
    while True:
        if t >= rules.end * (1.0 - 1e-14):
            break
        counts[0] = _spent(rules, counts[1], tiny)
        if counts[0] != _END:
            break
        how, taken, h = advance(flow, here, tableau, rules, h, rules.end - t, how == _FACE, step, where, tally)
        if how >= 0:
            counts[0] = how
            break
        counts[1] += 1
        how, taken = _in_time(rules, step, t, how, taken)
        tiny = tiny + 1 if taken < rules.smallest else 0
        short = shortened(rules, step, taken, sums[0])
        if short < taken or sums[0] >= rules.length:
            counts[0], taken = _LENGTH, short
        sums[0] += distance(step.start, step.end)
        first = n
        rows, n, sampled = _sampled(flow, here, rules, t, min(t + taken, rules.end), step, rows, n, sampled)
        write(flow, here, rules, t + taken, 2.0, step, tail[0])
        if rules.assess:
            _assess(flow, beside, tableau, rules, t, taken, step, half, rows, first, n, tail[0], trust, sums)
        t += taken
        if rules.interval == 0.0:
            rows = _room(rows, n)
            _copy(tail[0], rows[n])
            n += 1
        if counts[0] != _END:
            break
        counts[0] = _beyond(flow, here, rules, how, where)
        if counts[0] != _END:
            break
        _stand_at(step.end, step, step)
    if t - rows[n - 1, _TIME] > 1e-12 * t:
        _copy(tail[0], rows[n])
        n += 1
    counts[2], counts[3] = tally[0], tally[1] + counts[1]
    return rows, n


@jit
def _assess(
    flow: Flow, beside: Here, tableau: Tableau, rules: Rules, t: float, taken: float, step: Step, half: Step, rows: Floats,
    first: int, last: int, tail: Floats, trust: Floats, sums: Floats,
) -> None:  # fmt: skip
    """Follow the step in two halves, and enter what the two marches differ by; judge whether that is credible."""
    where = np.zeros(3, np.int64)
    worst = 0.0
    if taken > 0.0:
        worst = follow(flow, beside, tableau, rules, t, 0.5 * taken, half, where, rows, first, last)
        again = follow(flow, beside, tableau, rules, t + 0.5 * taken, 0.5 * taken, half, where, rows, first, last)
        worst = max(worst, again)
    for c in range(3):
        tail[_ERROR + c] = rules.factor * (step.end[c] - half.start[c])
    if rules.control > 1:
        return
    apart = 0.0
    for c in range(3):
        apart = max(apart, abs(step.end[c] - half.start[c]) / rules.extent[c])
    if worst >= 0.5 * rules.tolerance:
        trust[0] += 2.0
    elif worst >= 0.1 * rules.tolerance:
        trust[0] += 1.0
    if (trust[0] >= 2.0 or apart > 0.1) and t < sums[1]:
        sums[1] = t


def warm() -> None:
    """Compile the kernels of a march."""
    axis = np.linspace(-1.0, 1.0, 3)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    flow = flow_of(np.stack([-y, x, 0.1 + 0 * z], axis=-1), axis, axis, axis)
    march(flow, np.array([[0.5, 0.0, -0.5]]), rules_of(flow, end=1.0, interval=0.3, assess=True))
    load(flow, nowhere())
