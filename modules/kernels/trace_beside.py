"""Beside a march: a second one in parts of its steps that tells the error of the first, and the rows that are kept of both."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import lean_part
from modules.kernels.trace_cell import TETRA, Flow, carried, find, holds, onwards, physical, place
from modules.kernels.trace_march import HIGHEST, LOWEST, NAG, SIDES, Rules, ratio, sample, stand
from modules.kernels.trace_step import (
    APART,
    END,
    ERROR,
    SIZE,
    SPEED,
    START,
    along,
    attempt,
    attempt_across,
    face_place,
    first_exit,
    inwards,
    slope,
    taylor,
    to_face,
)  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

TIME, PLACE, VELOCITY, RESIDUAL, DIFFERENCE, LOCAL, WIDTH = 0, 1, 4, 7, 10, 13, 16
"""First columns of a row."""

SLIVER = 1e-4
"""What is left of a half step below this part of it is taken by a Taylor step."""


@lean_part
def compare(
    form: int, here: Floats, rules: Rules, begin: float, end: float, until: float, step: Floats, rows: Floats, first: int,
    last: int,
) -> None:  # fmt: skip
    """In the rows of a time span, the difference of their position from the dense output of this step, which replaces it if
    it is what is reported. What rounding puts behind the end, up to `until`, belongs to the span.
    """
    for r in range(first, last):
        time = rows[r, TIME]
        if begin < time <= max(end, until):
            theta = min((time - begin) / step[SIZE, 0], 1.0) if step[SIZE, 0] > 0.0 else 1.0
            at = place(form, here, along(step, 0, theta), along(step, 1, theta), along(step, 2, theta))
            for m in range(3):
                rows[r, DIFFERENCE + m] = rules.factor * (rows[r, PLACE + m] - at[m])
                if rules.subsidiary:
                    rows[r, PLACE + m] = at[m]


@lean_part
def follow(
    flow: Flow, here: Floats, cell: Integers, tableau: Floats, rules: Rules, clock: float, start: float, h: float, until: float,
    step: Floats, rows: Floats, first: int, last: int,
) -> float:  # fmt: skip
    """March by h from `step[START]` at time `start` in one step, or in several that end on faces; leaves the end in START.

    The rows from `first` to `last` that fall in this time are compared. Beyond the border of the domain, or of a hole, it
    goes on in its last cell. Returns the largest local error over its weight.
    """
    left, t, worst, closed, form = h, start, 0.0, not rules.faces, flow.form
    for _ in range(64):
        taken, on, face = left, False, -1
        a, b, c = sample(flow, here, cell, rules.faces, step[START, 0], step[START, 1], step[START, 2], clock + t)
        step[0, 0], step[0, 1], step[0, 2] = step[SPEED, 0], step[SPEED, 1], step[SPEED, 2] = a, b, c
        time = np.inf if closed else soonest(form, here, step)
        if min(left, time) <= SLIVER * h and not closed:
            time, face, code = stand(flow, here, cell, True, True, clock + t, step)
            closed = code != 0
            taken = min(left, max(time, 0.0)) if min(left, time) <= SLIVER * h and not closed else -1.0
        if 0.0 <= taken <= SLIVER * h and not closed:
            on = time < left
            taylor(taken, step)
        else:
            taken = left
            if rules.faces:
                attempt(form, here, tableau, clock + t, left, step)
            else:
                attempt_across(flow, here, cell, tableau, clock + t, left, step)
            worst = max(worst, ratio(form, here, rules, step))
            if not closed:
                theta, face = first_exit(form, here, step)
                if theta <= 1.0:
                    taken, _used, face = to_face(flow, here, cell, here, tableau, True, clock + t, theta, face, step)
                    taken = min(abs(taken), left)
                    on = taken < left and face >= 0
        compare(form, here, rules, t, t + taken, until if taken >= left else t, step, rows, first, last)
        for m in range(3):
            step[START, m] = step[END, m]
        t += taken
        left -= taken
        if not left > 1e-14 * h:
            break
        if on:
            closed = onwards(flow, here, cell, face) != 0
    return worst


@lean_part
def soonest(form: int, here: Floats, step: Floats) -> float:
    """When the straight line along the velocity would leave the cell; inf if never."""
    first = np.inf
    for face in range(4 if form == TETRA else 6):
        rate = inwards(form, here, face, SPEED, step)
        if rate < 0.0:
            first = min(first, max(0.0, face_place(form, here, face) + inwards(form, here, face, START, step)) / -rate)
    return first


@lean_part
def write(flow: Flow, here: Floats, cell: Integers, rules: Rules, clock: float, time: float, theta: float, step: Floats,
          row: Floats) -> None:  # fmt: skip
    """Fill a row of the present step: position and residual of its dense output, velocity of the field, local error."""
    form = flow.form
    row[TIME] = time
    x, y, z = step[END, 0], step[END, 1], step[END, 2]
    if theta <= 1.0:
        x, y, z = along(step, 0, theta), along(step, 1, theta), along(step, 2, theta)
        if form != TETRA:
            x = min(max(x, rules.box[LOWEST, 0]), rules.box[HIGHEST, 0])
            y = min(max(y, rules.box[LOWEST, 1]), rules.box[HIGHEST, 1])
            z = min(max(z, rules.box[LOWEST, 2]), rules.box[HIGHEST, 2])
    if not rules.faces and not holds(here, x, y, z):
        find(flow, here, cell, x, y, z)
    at, v = place(form, here, x, y, z), physical(form, here, x, y, z, clock + time)
    e = carried(form, here, x, y, z, (step[ERROR, 0], step[ERROR, 1], step[ERROR, 2]))
    h, part = step[SIZE, 0], min(theta, 1.0)
    inferred = v
    if h > 0.0:
        d = (slope(step, 0, part) / h, slope(step, 1, part) / h, slope(step, 2, part) / h)
        inferred = carried(form, here, x, y, z, d)
    for m in range(3):
        row[PLACE + m], row[VELOCITY + m], row[LOCAL + m] = at[m], v[m], e[m]
        row[RESIDUAL + m] = inferred[m] - v[m]
        row[DIFFERENCE + m] = step[APART, m] if theta > 1.0 else 0.0


@lean_part
def chord(form: int, here: Floats, step: Floats, theta: float) -> float:
    """Length of the chord from the start of a step to theta of its dense output, or to its end (2)."""
    p = place(form, here, step[START, 0], step[START, 1], step[START, 2])
    x, y, z = step[END, 0], step[END, 1], step[END, 2]
    if theta <= 1.0:
        x, y, z = along(step, 0, theta), along(step, 1, theta), along(step, 2, theta)
    q = place(form, here, x, y, z)
    return math.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2)


@lean_part
def shortened(form: int, here: Floats, rules: Rules, step: Floats, taken: float, length: float) -> float:
    """The time after which the chords of a trace have the largest length; `taken` if they are shorter."""
    if length + chord(form, here, step, 2.0) < rules.length:
        return taken
    theta, size = 0.0, 1.0
    for _ in range(50):
        size *= 0.5
        if length + chord(form, here, step, theta + size) <= rules.length:
            theta += size
    for m in range(3):
        step[END, m] = along(step, m, theta)
    return float(theta * step[SIZE, 0])


@lean_part
def assess(
    flow: Flow, here: Floats, beside: Floats, other: Integers, tableau: Floats, rules: Rules, clock: float, t: float,
    taken: float, step: Floats, half: Floats, rows: Floats, first: int, last: int, trust: Floats, sums: Floats,
) -> None:  # fmt: skip
    """Follow the step in its parts, and enter what the two marches differ by; judge whether that is credible."""
    worst, h = 0.0, taken / rules.parts
    for part in range(rules.parts if taken > 0.0 else 0):
        begun, until = t + part * h, (np.inf if part == rules.parts - 1 else t + (part + 1) * h)
        found = follow(flow, beside, other, tableau, rules, clock, begun, h, until, half, rows, first, last)
        worst = max(worst, found)
    p = place(flow.form, here, step[END, 0], step[END, 1], step[END, 2])
    q = place(flow.form, beside, half[START, 0], half[START, 1], half[START, 2])
    apart = 0.0
    for c in range(3):
        step[APART, c] = rules.factor * (p[c] - q[c])
        apart = max(apart, abs(p[c] - q[c]) / rules.box[SIDES, c])
    if rules.control > NAG:
        return
    if worst >= rules.tolerance / rules.parts:
        trust[0] += 2.0
    elif worst >= 0.1 * rules.tolerance:
        trust[0] += 1.0
    if (trust[0] >= 2.0 or apart > 0.1) and t < sums[1]:
        sums[1] = t
