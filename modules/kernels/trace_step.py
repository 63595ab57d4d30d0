"""One Runge-Kutta step within a cell's polynomial, and its end on the face that it crosses.

The velocity of a trilinear field is only continuous across the faces of cells; a step over a face loses its order. A
step of `to_face` ends on the first face crossed: the face is searched on the dense output, the step is taken anew to
there, and what is left, a small part `slack` of the step, is made up by a Taylor step of second order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit
from modules.kernels.trace_cell import Flow, Here, find, holds, jacobian, velocity

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

LOOKS = 8
"""Places on the dense output where a step is looked at for a crossing; between them its curve is followed by a parabola."""

RETAKES = 6
"""Most often a step is taken anew to end on a face; two are enough nearly always."""


class Tableau(NamedTuple):
    """`runge_kutta.Pair` as the compiled code takes it."""

    stages: Floats
    result: Floats
    error: Floats
    dense: Floats


class Step(NamedTuple):
    """A step.

    Attributes
    ----------
    k : (s, 3) velocities of its stages
    start, end, error : (3,) error is the local one
    curve, size : (5, 3), (1,) dense output, and the step size that it spans
    turn : (3,) acceleration at the start
    scratch : (3, 3)
    """

    k: Floats
    start: Floats
    end: Floats
    error: Floats
    curve: Floats
    size: Floats
    turn: Floats
    scratch: Floats


@jit
def blank(tableau: Tableau) -> Step:
    """Room for a step."""
    s = tableau.result.size
    return Step(
        np.zeros((s, 3)), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((5, 3)), np.zeros(1), np.zeros(3), np.zeros((3, 3))
    )


@jit
def sample(flow: Flow, here: Here, p: Floats, faces: bool, out: Floats) -> None:
    """The velocity at a position: of the present cell with `faces`, else of the cell that holds the position."""
    if not faces and not holds(here, p):
        find(flow, here, p)
    velocity(here, p, out)


@jit
def attempt(flow: Flow, here: Here, tableau: Tableau, faces: bool, h: float, step: Step) -> None:
    """Take the step of size h from `step.start`, whose velocity is `step.k[0]` already."""
    s = tableau.result.size
    at = step.scratch[0]
    for stage in range(1, s):
        for m in range(3):
            total = 0.0
            for i in range(stage):
                total += tableau.stages[stage, i] * step.k[i, m]
            at[m] = step.start[m] + h * total
        sample(flow, here, at, faces, step.k[stage])
    for m in range(3):
        step.end[m] = at[m]
        total = 0.0
        for i in range(s):
            total += tableau.error[i] * step.k[i, m]
        step.error[m] = h * total


@jit
def bend(tableau: Tableau, h: float, step: Step) -> None:
    """The coefficients of the dense output, theta^0 to theta^4."""
    step.size[0] = h
    for m in range(3):
        step.curve[0, m] = step.start[m]
        for power in range(4):
            total = 0.0
            for i in range(tableau.result.size):
                total += tableau.dense[i, power] * step.k[i, m]
            step.curve[power + 1, m] = h * total


@jit
def along(step: Step, m: int, theta: float) -> float:
    """Coordinate m of the dense output."""
    c = step.curve
    return float(c[0, m] + theta * (c[1, m] + theta * (c[2, m] + theta * (c[3, m] + theta * c[4, m]))))


@jit
def slope(step: Step, m: int, theta: float) -> float:
    """Its derivative by theta: the step size times the velocity that the dense output infers."""
    c = step.curve
    return float(c[1, m] + theta * (2.0 * c[2, m] + theta * (3.0 * c[3, m] + theta * 4.0 * c[4, m])))


@jit
def depth(step: Step, m: int, side: int, low: Floats, high: Floats, theta: float) -> float:
    """How far inside a face the dense output is; negative outside."""
    return float(high[m] - along(step, m, theta) if side else along(step, m, theta) - low[m])


@jit
def halved(step: Step, m: int, side: int, low: Floats, high: Floats, last: float) -> float:
    """The theta, at most a look before `last`, where the dense output goes out through a face."""
    inner = max(0.0, last - 1.0 / LOOKS)
    for _ in range(20):
        half = 0.5 * (inner + last)
        if depth(step, m, side, low, high, half) < 0.0:
            last = half
        else:
            inner = half
    return last


@jit
def first_exit(step: Step, low: Floats, high: Floats, where: Integers) -> float:
    """The theta where the dense output first leaves a box, the axis and side in `where`; 2 if it stays inside."""
    first = 2.0
    for m in range(3):
        reach = 0.0
        for power in range(1, 5):
            reach += abs(step.curve[power, m])
        for side in range(2):
            inside = depth(step, m, side, low, high, 0.0)
            if reach < inside:
                continue
            before, middle, last = inside, inside, 0.0
            for look in range(1, LOOKS + 1):
                last = look / LOOKS
                now = depth(step, m, side, low, high, last)
                if now < 0.0:
                    break
                second = before - 2.0 * middle + now
                if look > 1 and middle < before and middle < now and middle - (before - now) ** 2 / (8.0 * second) < 0.0:
                    last = (look - 1 + 0.5 * (before - now) / second) / LOOKS
                    now = depth(step, m, side, low, high, last)
                    if now < 0.0:
                        break
                    now = depth(step, m, side, low, high, look / LOOKS)
                before, middle = middle, now
            if now < 0.0 and last - 1.0 / LOOKS < first:
                last = halved(step, m, side, low, high, last)
                if last < first:
                    first = last
                    where[0], where[1] = m, side
    return first


@jit
def to_face(
    flow: Flow, here: Here, tableau: Tableau, faces: bool, h: float, guess: float, slack: float, low: Floats, high: Floats,
    where: Integers, step: Step,
) -> float:  # fmt: skip
    """Take the step anew so that it ends on the face `where` of the box, at a time near the guess.

    The step of size h has been taken already. Where the face is only grazed, Newton's method leaves the neighbourhood of
    the guess; then the guess is good, since the place hardly depends on it.

    Returns
    -------
    The time from start to face; `step.end` lies on it exactly. Negative if the face is only grazed, so that the place is
    no better known than the dense output is.
    """
    m, side = where[0], where[1]
    face = high[m] if side else low[m]
    last = tableau.result.size - 1
    dt, near, sure = 0.0, 0.1 * guess + 1e-3 * h, True
    if abs(h - guess) > near:
        h = guess
        attempt(flow, here, tableau, faces, h, step)
    for _ in range(RETAKES):
        v = step.k[last, m]
        dt = (face - step.end[m]) / v if v != 0.0 else 2.0 * near
        if abs(dt) <= slack * h:
            break
        if not abs(h + dt - guess) <= near:
            h, dt = guess, 0.0
            attempt(flow, here, tableau, faces, h, step)
            v = step.k[last, m]
            dt = (face - step.end[m]) / v if v != 0.0 else 0.0
            if not abs(dt) <= slack * h:
                dt, sure = 0.0, False
            break
        h += dt
        dt = 0.0
        attempt(flow, here, tableau, faces, h, step)
    bend(tableau, h, step)
    jacobian(here, step.end, step.scratch)
    for c in range(3):
        turn = 0.0
        for i in range(3):
            turn += step.scratch[c, i] * step.k[last, i]
        step.end[c] += dt * (step.k[last, c] + 0.5 * dt * turn)
    step.end[m] = face
    return h + dt if sure else -(h + dt)
