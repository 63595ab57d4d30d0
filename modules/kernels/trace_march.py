"""The march of one particle: controlled steps, samples on the way, a second march in half steps beside it, and its end."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit
from modules.kernels.trace_cell import Flow, Here, crossing_time, find, jacobian, load, onwards, velocity
from modules.kernels.trace_step import LOOKS, Step, Tableau, along, attempt, bend, first_exit, sample, slope, to_face

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

END, LEFT, REST, HOLE, LENGTH, STEPS, OUTSIDE, STALLED = range(8)
"""Why a trace ends: end time, left the domain, at rest, hole, largest length, steps; began outside; steps too small."""

INSIDE, FACE = -1, -2
"""How a step ends if the trace goes on: within a cell, on a face."""

EXTENT, NAG, FIXED, CELL, CURVATURE = range(5)
"""What a step is controlled by."""

TIME, PLACE, VELOCITY, RESIDUAL, ERROR, LOCAL, WIDTH = 0, 1, 4, 7, 10, 13, 16
"""First columns of a row."""

SLACK = 1e-4
"""Part of a step that a Taylor step of second order makes up to end on a face."""

GRAZES = 6
"""How often a step that grazes a face is halved before its dense output decides."""

WALL = 1e-9
"""A normal velocity below this part of the field's is none: what seems to leave there only overshoots."""


class Rules(NamedTuple):
    """How to march; times are positive in the direction of the march.

    Attributes
    ----------
    control : EXTENT, NAG, FIXED, CELL or CURVATURE
    tolerance : relative, of EXTENT and NAG
    size : time step of FIXED, part of a cell of CELL, angle of CURVATURE
    power : 1 / (order of the error estimate + 1)
    factor : error of a step over its difference from two half steps, 2^p / (2^p - 1)
    extent, near : (3,) of the domain, and the smaller |coordinate| of its two ends
    low, high : (3,) of the domain
    first, smallest : sizes of the first step and of the smallest that is worth taking
    end, interval, length, steps : end time, time between samples (0: each step), largest length, most steps
    rest : speed that is none
    faces : whether steps end on faces
    halve : whether a crossing of a cell takes at least two steps
    assess : whether to march in half steps beside
    holes : whether there are samples that are no numbers
    """

    control: int
    tolerance: float
    size: float
    power: float
    factor: float
    extent: Floats
    near: Floats
    low: Floats
    high: Floats
    first: float
    smallest: float
    end: float
    interval: float
    length: float
    steps: int
    rest: float
    faces: bool
    halve: bool
    assess: bool
    holes: bool


@jit
def ratio(rules: Rules, step: Step, error: Floats) -> float:
    """The largest component of an error over its weight, thesis (5.3) and (5.4) with NAG; `rules.extent` otherwise."""
    worst = 0.0
    for m in range(3):
        weight = rules.extent[m]
        if rules.control == NAG:
            threshold = max(rules.tolerance * rules.near[m], 1.5e-154)
            weight = max(0.5 * (abs(step.start[m]) + abs(step.end[m])), threshold)
        part = abs(error[m]) / weight
        if not part <= worst:
            worst = part
    return float(worst)


@jit
def stand(flow: Flow, here: Here, step: Step, faces: bool, where: Integers) -> float:
    """Velocity at the start of a step, in the cell that it goes into; returns the time to the face, -1 where there is none.

    `where` holds that face's axis and side, and then 0, or why there is no cell: 1 the border, 2 a hole.
    """
    sample(flow, here, step.start, faces, step.k[0])
    where[2] = 0
    if not faces:
        return np.inf
    for _ in range(4):
        turning(here, step)
        time = crossing_time(here, step.start, step.k[0], step.turn, where)
        if time > 0.0:
            return time
        where[2] = onwards(flow, here, where[0], where[1])
        if where[2]:
            return -1.0
        velocity(here, step.start, step.k[0])
    return 0.0


@jit
def turning(here: Here, step: Step) -> None:
    """The acceleration J V at the start of a step, into `step.turn`."""
    jacobian(here, step.start, step.scratch)
    for m in range(3):
        step.turn[m] = 0.0
        for i in range(3):
            step.turn[m] += step.scratch[m, i] * step.k[0, i]


@jit
def smallest_edge(here: Here) -> float:
    """Of the cell."""
    return float(min(here.high[0] - here.low[0], here.high[1] - here.low[1], here.high[2] - here.low[2]))


@jit
def distance(p: Floats, q: Floats) -> float:
    """Between two positions."""
    return math.sqrt((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2)


@jit
def wanted(rules: Rules, here: Here, step: Step, speed: float, h: float) -> float:
    """The size of a step that no error controls."""
    if rules.control == FIXED:
        return rules.size
    if rules.control == CELL:
        return rules.size * smallest_edge(here) / speed
    if rules.control == CURVATURE:
        turning(here, step)
        v, a = step.k[0], step.turn
        x, y, z = v[1] * a[2] - v[2] * a[1], v[2] * a[0] - v[0] * a[2], v[0] * a[1] - v[1] * a[0]
        bent = math.sqrt(x * x + y * y + z * z) / speed**2
        cell = smallest_edge(here) / speed
        return min(rules.size / bent, cell) if bent > 0.0 else cell
    return h


@jit
def proposed(
    rules: Rules, here: Here, step: Step, speed: float, h: float, time: float, limit: float, fresh: bool
) -> tuple[float, float, bool]:
    """The size to try, the one that control would take, and whether it aims at the face that `time` tells."""
    keep = h = wanted(rules, here, step, speed, h)
    half = rules.halve and fresh
    if half:
        time *= 0.5
    aimed = rules.faces and time <= h and not half
    h = min(h, time, limit)
    if rules.holes and not rules.faces:
        h = min(h, 4.0 * smallest_edge(here) / speed)
    if h < limit and not aimed:
        h = min(h, max(limit - h, 0.5 * limit))  # the last two steps share what is left
    return h, keep, aimed


@jit
def into_hole(flow: Flow, here: Here, step: Step) -> bool:
    """Whether the dense output of a step goes through a hole."""
    for look in range(1, LOOKS + 1):
        for m in range(3):
            step.scratch[1, m] = along(step, m, look / LOOKS)
        sample(flow, here, step.scratch[1], False, step.scratch[0])
        if not step.scratch[0, 0] - step.scratch[0, 0] == 0.0:
            return True
    return False


@jit
def measured(flow: Flow, here: Here, rules: Rules, tableau: Tableau, h: float, step: Step) -> float:
    """The local error over what is allowed, 0 where no error controls the step; NaN through a hole."""
    over = ratio(rules, step, step.error) / rules.tolerance if rules.control <= NAG else 0.0
    if rules.holes and not rules.faces and over < 1.0:
        bend(tableau, h, step)
        if into_hole(flow, here, step):
            return np.nan
    return over


@jit
def advance(
    flow: Flow, here: Here, tableau: Tableau, rules: Rules, h: float, limit: float, fresh: bool, step: Step, where: Integers,
    tally: Integers,
) -> tuple[int, float, float]:  # fmt: skip
    """One accepted step from `step.start`: how it ends (or why none is taken), its time, and the size for the next.

    Counted in `tally`: steps refused, and evaluations of the velocity.
    """
    time = stand(flow, here, step, rules.faces, where)
    speed = math.sqrt(step.k[0, 0] ** 2 + step.k[0, 1] ** 2 + step.k[0, 2] ** 2)
    if where[2]:
        return (LEFT if where[2] == 1 else HOLE), 0.0, h
    if not speed > rules.rest:
        return (REST if speed == speed else HOLE), 0.0, h
    h, keep, aimed = proposed(rules, here, step, speed, h, time, limit, fresh)
    axis, side, before = where[0], where[1], tally[0]
    for _ in range(200):
        attempt(flow, here, tableau, rules.faces, h, step)
        tally[1] += tableau.result.size - 1
        over = measured(flow, here, rules, tableau, h, step)
        if not over < 1.0:
            tally[0] += 1
            h *= max(0.2, 0.9 * over**-rules.power) if over < 1e30 else 0.5
            aimed = False
            if h < (rules.smallest if over == over else 1e6 * rules.smallest):
                return (STALLED if over == over else HOLE), 0.0, h
            continue
        if rules.control <= NAG:
            keep = max(keep if keep > h else 0.0, h * min(5.0, 0.9 * max(over, 1e-12) ** -rules.power))
        graze = tally[0] - before < GRAZES
        how, taken = ended(flow, here, tableau, rules, h, aimed, axis, side, step, where, tally)
        if how == REST or (taken < 0.0 and graze):  # a wall, or a face, that only seems to be crossed: a smaller step tells
            tally[0] += 1
            h, aimed = 0.5 * h, False
            if h < rules.smallest:
                return REST, 0.0, h
            continue
        return how, abs(taken), keep
    return STALLED, 0.0, h


@jit
def ended(
    flow: Flow, here: Here, tableau: Tableau, rules: Rules, h: float, aimed: bool, axis: int, side: int, step: Step,
    where: Integers, tally: Integers,
) -> tuple[int, float]:  # fmt: skip
    """How a step of size h ends: INSIDE, on a FACE, or REST where it would cross a wall; and the time that it takes."""
    low, high = (here.low, here.high) if rules.faces else (rules.low, rules.high)
    bend(tableau, h, step)
    theta = first_exit(step, low, high, where)
    taken, guess = h, h
    if theta > 1.0:
        if not aimed:
            return INSIDE, h
        where[0], where[1] = axis, side
        away = high[axis] - step.end[axis] if side else step.end[axis] - low[axis]
        out = step.k[tableau.result.size - 1, axis] * (1.0 if side else -1.0)
        if not (out > 0.0 and away <= 0.2 * h * out):
            return INSIDE, h
        guess = h + away / out
    else:
        guess = theta * h
    for _ in range(3):
        taken = to_face(flow, here, tableau, rules.faces, h, guess, SLACK, low, high, where, step)
        tally[1] += 2 * (tableau.result.size - 1)
        axis, side = where[0], where[1]
        theta = first_exit(step, low, high, where)
        if theta > 1.0 - 1e-6 or (where[0] == axis and where[1] == side):
            where[0], where[1] = axis, side
            break
        h, guess = step.size[0], theta * step.size[0]
    for m in range(3):
        step.end[m] = min(max(step.end[m], low[m]), high[m])
    sample(flow, here, step.end, rules.faces, step.scratch[0])
    out = step.scratch[0, where[0]] * (1.0 if where[1] else -1.0)
    if border(flow, here, rules, where) and not out > WALL * rules.rest * 1e12:
        return REST, 0.0
    return FACE, taken


@jit
def border(flow: Flow, here: Here, rules: Rules, where: Integers) -> bool:
    """Whether the face `where` lies on the border of the domain."""
    m = where[0]
    return bool(here.high[m] >= rules.high[m]) if where[1] else bool(here.low[m] <= rules.low[m])


@jit
def compare(
    rules: Rules, begin: float, end: float, final: bool, step: Step, rows: Floats, first: int, last: int
) -> None:
    """In the rows of a time span, the error of their position against the dense output of this step."""
    for r in range(first, last):
        time = rows[r, TIME]
        if begin < time and (time <= end or final):
            theta = min((time - begin) / step.size[0], 1.0) if step.size[0] > 0.0 else 1.0
            for m in range(3):
                rows[r, ERROR + m] = rules.factor * (rows[r, PLACE + m] - along(step, m, theta))


@jit
def back(flow: Flow, here: Here, where: Integers) -> None:
    """Back from the hole beyond a face."""
    here.cell[where[0]] += -1 if where[1] else 1
    load(flow, here)


@jit
def follow(
    flow: Flow, here: Here, tableau: Tableau, rules: Rules, start: float, h: float, step: Step, where: Integers, rows: Floats,
    first: int, last: int,
) -> float:  # fmt: skip
    """March by h from `step.start` in one step, or in several that end on faces; leaves the end in `step.start`.

    In the rows from `first` to `last` that fall in this time the position becomes the error against this march. Beyond
    the border of the domain, or of a hole, it goes on in its last cell. Returns the largest local error over its weight.
    """
    left, t, worst = h, start, 0.0
    closed = False
    for _ in range(64):
        time = np.inf
        if not closed:
            time = stand(flow, here, step, rules.faces, where)
            closed = where[2] != 0
            if where[2] == 2:
                back(flow, here, where)
        if closed:
            velocity(here, step.start, step.k[0])
        attempt(flow, here, tableau, rules.faces or closed, left, step)
        bend(tableau, left, step)
        taken, on = left, False
        if rules.faces and not closed and time < 4.0 * left:
            theta = first_exit(step, here.low, here.high, where)
            if theta <= 1.0:
                taken = to_face(flow, here, tableau, True, left, theta * left, SLACK, here.low, here.high, where, step)
                taken = abs(taken)
                on = taken < left
                taken = min(taken, left)
        worst = max(worst, ratio(rules, step, step.error))
        compare(rules, t, t + taken, taken >= left, step, rows, first, last)
        for m in range(3):
            step.start[m] = step.end[m]
        t += taken
        left -= taken
        if not left > 1e-14 * h:
            break
        if on:
            code = onwards(flow, here, where[0], where[1])
            if code == 2:
                back(flow, here, where)
            closed = code != 0
    return worst


@jit
def write(flow: Flow, here: Here, rules: Rules, time: float, theta: float, step: Step, row: Floats) -> None:
    """Fill a row of the present step: position and residual of its dense output, velocity of the field, local error."""
    row[TIME] = time
    at = step.scratch[1]
    for m in range(3):
        at[m] = along(step, m, theta) if theta <= 1.0 else step.end[m]
        at[m] = min(max(at[m], rules.low[m]), rules.high[m])
    sample(flow, here, at, rules.faces, step.scratch[0])
    for m in range(3):
        row[PLACE + m] = at[m]
        row[VELOCITY + m] = step.scratch[0, m]
        inferred = slope(step, m, min(theta, 1.0)) / step.size[0] if step.size[0] > 0.0 else step.scratch[0, m]
        row[RESIDUAL + m] = inferred - step.scratch[0, m]
        row[LOCAL + m] = step.error[m]
        row[ERROR + m] = 0.0


@jit
def shortened(rules: Rules, step: Step, taken: float, length: float) -> float:
    """The time after which the chords of a trace have the largest length; `taken` if they are shorter."""
    chord = distance(step.start, step.end)
    if length + chord < rules.length:
        return taken
    theta, size = 0.0, 1.0
    for _ in range(50):
        size *= 0.5
        for m in range(3):
            step.end[m] = along(step, m, theta + size)
        if length + distance(step.start, step.end) <= rules.length:
            theta += size
    for m in range(3):
        step.end[m] = along(step, m, theta)
    return float(theta * step.size[0])


@jit
def begin(flow: Flow, here: Here, rules: Rules, seed: Floats) -> int:
    """Stand at a seed: END if there is a velocity, OUTSIDE or HOLE if not."""
    for m in range(3):
        if not rules.low[m] <= seed[m] <= rules.high[m]:
            return OUTSIDE
    return END if find(flow, here, seed) else HOLE
