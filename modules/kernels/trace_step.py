"""One Runge-Kutta step within a cell, its dense output, and its end on the face that it crosses.

The velocity is only continuous across the faces of cells; a step over a face loses its order. A step that would leave its
cell is taken anew to the first face that its dense output crosses. What is left then, a small part `CLOSE` of the step, is
made up by the dense output, whose error vanishes with the square of the distance to the end of the step.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_inlined, lean_part
from modules.kernels.trace_cell import HIGH, LOW, OFFSET, PLANE, TETRA, Flow, Vector, velocity, velocity_across

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

LOOKS = 8
"""Places on the dense output where a step is looked at for a crossing; between them its curve is followed by a parabola."""

RETAKES = 6
"""Most often a step is taken anew to end on a face; one is enough nearly always."""

CLOSE = 0.02
"""Part of a step that its dense output makes up to end on a face."""

START, END, ERROR, CURVE, SIZE, SPEED, TURN, APART, LENGTH = 7, 8, 9, 10, 15, 16, 17, 18, 19
"""Rows of a step, after the velocities of its stages: ends, local error, five coefficients of the dense output, the time that
it spans; velocity and acceleration at its start; the error against the march beside."""


@jit
def blank() -> Floats:
    """Room for a step."""
    return np.zeros((LENGTH, 3))


@lean_inlined
def _stage(tableau: Floats, stage: int, h: float, step: Floats) -> Vector:
    """Where a stage is looked at."""
    x = y = z = 0.0
    for i in range(stage):
        a = tableau[stage, i]
        x += a * step[i, 0]
        y += a * step[i, 1]
        z += a * step[i, 2]
    return step[START, 0] + h * x, step[START, 1] + h * y, step[START, 2] + h * z


@lean_inlined
def _combined(tableau: Floats, h: float, step: Floats) -> None:
    """The local error and the dense output, once all stages are there."""
    s = tableau.shape[1] - 1
    step[SIZE, 0] = h
    for m in range(3):
        e = b = c = d = f = 0.0
        for i in range(s):
            k = step[i, m]
            e += tableau[s, i] * k
            b += tableau[s + 1, i] * k
            c += tableau[s + 2, i] * k
            d += tableau[s + 3, i] * k
            f += tableau[s + 4, i] * k
        step[ERROR, m] = h * e
        step[CURVE, m] = step[START, m]
        step[CURVE + 1, m], step[CURVE + 2, m] = h * b, h * c
        step[CURVE + 3, m], step[CURVE + 4, m] = h * d, h * f


@lean_part
def attempt(form: int, here: Floats, tableau: Floats, t: float, h: float, step: Floats) -> None:
    """Take the step of size h from `step[START]` at time t within the polynomial of the cell; the velocity there is known."""
    s = tableau.shape[1] - 1
    for stage in range(1, s):
        x, y, z = _stage(tableau, stage, h, step)
        step[stage, 0], step[stage, 1], step[stage, 2] = velocity(form, here, x, y, z, t + h * tableau[stage, s])
        step[END, 0], step[END, 1], step[END, 2] = x, y, z
    _combined(tableau, h, step)


@lean_part
def attempt_across(flow: Flow, here: Floats, cell: Integers, tableau: Floats, t: float, h: float, step: Floats) -> None:
    """As `attempt`, each stage in the cell where it lies."""
    s = tableau.shape[1] - 1
    for stage in range(1, s):
        x, y, z = _stage(tableau, stage, h, step)
        v = velocity_across(flow, here, cell, x, y, z, t + h * tableau[stage, s])
        step[stage, 0], step[stage, 1], step[stage, 2] = v
        step[END, 0], step[END, 1], step[END, 2] = x, y, z
    _combined(tableau, h, step)


@lean_part
def taylor(h: float, step: Floats) -> None:
    """A step of second order by the velocity and acceleration at its start, for what is left of a larger one."""
    step[SIZE, 0] = h
    for m in range(3):
        step[CURVE, m], step[CURVE + 1, m] = step[START, m], h * step[SPEED, m]
        step[CURVE + 2, m] = 0.5 * h * h * step[TURN, m]
        step[CURVE + 3, m] = step[CURVE + 4, m] = step[ERROR, m] = 0.0
        step[END, m] = step[CURVE, m] + step[CURVE + 1, m] + step[CURVE + 2, m]


@lean_part
def along(step: Floats, m: int, theta: float) -> float:
    """Coordinate m of the dense output."""
    high = step[CURVE + 2, m] + theta * (step[CURVE + 3, m] + theta * step[CURVE + 4, m])
    return float(step[CURVE, m] + theta * (step[CURVE + 1, m] + theta * high))


@lean_part
def slope(step: Floats, m: int, theta: float) -> float:
    """Its derivative by theta: the step size times the velocity that the dense output infers."""
    return float(
        step[CURVE + 1, m]
        + theta * (2.0 * step[CURVE + 2, m] + theta * (3.0 * step[CURVE + 3, m] + theta * 4.0 * step[CURVE + 4, m]))
    )


@lean_inlined
def inwards(form: int, walls: Floats, face: int, row: int, step: Floats) -> float:
    """How far inside a face the vector at a row of the step points, less where the face is."""
    if form == TETRA:
        p = PLANE + face
        return float(walls[p, 0] * step[row, 0] + walls[p, 1] * step[row, 1] + walls[p, 2] * step[row, 2])
    return -float(step[row, face >> 1]) if face & 1 else float(step[row, face >> 1])


@lean_part
def face_place(form: int, walls: Floats, face: int) -> float:
    """The constant that makes `inwards` of a position its depth inside the face."""
    if form == TETRA:
        return float(walls[OFFSET + face // 3, face % 3])
    return float(walls[HIGH, face >> 1]) if face & 1 else -float(walls[LOW, face >> 1])


@lean_part
def facing(form: int, walls: Floats, face: int, step: Floats) -> tuple[float, float, float, float, float]:
    """The depth inside a face along the dense output, as a polynomial of theta."""
    return (
        face_place(form, walls, face) + inwards(form, walls, face, CURVE, step),
        inwards(form, walls, face, CURVE + 1, step), inwards(form, walls, face, CURVE + 2, step),
        inwards(form, walls, face, CURVE + 3, step), inwards(form, walls, face, CURVE + 4, step),
    )  # fmt: skip


@lean_inlined
def _at(c: tuple[float, float, float, float, float], theta: float) -> float:
    return c[0] + theta * (c[1] + theta * (c[2] + theta * (c[3] + theta * c[4])))


@lean_part
def leaving(c: tuple[float, float, float, float, float]) -> float:
    """The theta in [0, 1] where a depth first becomes negative; 2 if it does not."""
    if (
        c[0] > 0.0 and c[0] + 0.25 * c[1] > 0.0 and c[0] + 0.5 * c[1] + c[2] / 6.0 > 0.0
        and c[0] + 0.75 * c[1] + 0.5 * c[2] + 0.25 * c[3] > 0.0 and c[0] + c[1] + c[2] + c[3] + c[4] > 0.0
    ):  # fmt: skip
        return 2.0  # all Bernstein coefficients are positive, so the depth is
    before, middle, now, last = c[0], c[0], c[0], 0.0
    for look in range(1, LOOKS + 1):
        last = look / LOOKS
        now = _at(c, last)
        if now < 0.0:
            break
        second = before - 2.0 * middle + now
        if look > 1 and middle < before and middle < now and middle - (before - now) ** 2 / (8.0 * second) < 0.0:
            last = (look - 1 + 0.5 * (before - now) / second) / LOOKS
            now = _at(c, last)
            if now < 0.0:
                break
            now = _at(c, look / LOOKS)
        before, middle = middle, now
    return _root(c, max(0.0, last - 1.0 / LOOKS), last) if now < 0.0 else 2.0


@lean_part
def _root(c: tuple[float, float, float, float, float], inner: float, outer: float) -> float:
    """Where a depth falls to 0 between a theta inside and one outside: Newton's method, halving where it strays."""
    theta = outer
    for _ in range(60):
        value = _at(c, theta)
        rate = c[1] + theta * (2.0 * c[2] + theta * (3.0 * c[3] + theta * 4.0 * c[4]))
        if value < 0.0:
            outer = theta
        else:
            inner = theta
        following = theta - value / rate if rate != 0.0 else inner
        if not inner < following < outer:
            following = 0.5 * (inner + outer)
        if abs(following - theta) < 1e-13:
            return following
        theta = following
    return theta


@lean_part
def first_exit(form: int, walls: Floats, step: Floats) -> tuple[float, int]:
    """The theta in [0, 1] where the dense output first goes out through a face, and the face; 2 and -1 if it stays inside."""
    first, through = 2.0, -1
    for face in range(4 if form == TETRA else 6):
        theta = leaving(facing(form, walls, face, step))
        if theta < first:
            first, through = theta, face
    return first, through


@lean_part
def beyond_end(form: int, walls: Floats, face: int, step: Floats, reach: float) -> float:
    """The theta near 1 where the dense output passes a face, at most `reach` off; 2 if there is none."""
    c = facing(form, walls, face, step)
    theta = 1.0
    for _ in range(8):
        rate = c[1] + theta * (2.0 * c[2] + theta * (3.0 * c[3] + theta * 4.0 * c[4]))
        if not rate < 0.0:
            return 2.0
        change = _at(c, theta) / rate
        theta -= change
        if not abs(theta - 1.0) <= reach:
            return 2.0
        if abs(change) < 1e-14:
            break
    return theta


@lean_part
def settle(form: int, walls: Floats, face: int, theta: float, step: Floats) -> None:
    """End the step on a face, at theta of its dense output."""
    for m in range(3):
        step[END, m] = along(step, m, theta)
    if form != TETRA:
        step[END, face >> 1] = walls[HIGH, face >> 1] if face & 1 else walls[LOW, face >> 1]


@lean_part
def _sooner(form: int, walls: Floats, face: int, theta: float, step: Floats) -> tuple[float, int]:
    """The face that a dense output goes out through first between its end and theta, where it passes a face."""
    first, through = theta, face
    for other in range(4 if form == TETRA else 6):
        if other != face:
            there = beyond_end(form, walls, other, step, 0.2)
            if 1.0 < there < first:
                first, through = there, other
    return first, through


@lean_part
def to_face(
    flow: Flow, here: Floats, cell: Integers, walls: Floats, tableau: Floats, inside: bool, t: float, theta: float, face: int,
    step: Floats,
) -> tuple[float, int, int]:  # fmt: skip
    """End a step, which has been taken, on the face that its dense output crosses at theta; anew if that is not near its end.

    Returns
    -------
    The time of the step, negative where a face is only grazed and the step ends near it; evaluations of the velocity; and
    the face, -1 where the step ends before it.
    """
    form, used = flow.form, 0
    h = step[SIZE, 0]
    for _ in range(RETAKES):
        if abs(theta - 1.0) <= CLOSE:
            if theta > 1.0:
                theta, face = _sooner(form, walls, face, theta, step)
            settle(form, walls, face, theta, step)
            return theta * h, used, face
        if theta > 1.5:
            break
        h *= theta
        if inside:
            attempt(form, here, tableau, t, h, step)
        else:
            attempt_across(flow, here, cell, tableau, t, h, step)
        used += tableau.shape[1] - 2
        theta = beyond_end(form, walls, face, step, 0.5)
    return -h, used, (face if _at(facing(form, walls, face, step), 1.0) < 0.0 else -1)
