"""The march of one particle, step by step: how large a step is, how it ends, and where the march does."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import lean_part
from modules.kernels.trace_cell import (
    BENT,
    HIGH,
    LOW,
    NT,
    NX,
    PLANE,
    SIZE_OF_INDEX,
    TETRA,
    TETRAHEDRA,
    Flow,
    Vector,
    carried,
    edge,
    find,
    load,
    onwards,
    time_of,
    velocity_across,
    velocity_in,
)
from modules.kernels.trace_step import (
    END,
    ERROR,
    LOOKS,
    SIZE,
    SPEED,
    START,
    TURN,
    along,
    attempt,
    attempt_across,
    beyond_end,
    face_place,
    first_exit,
    to_face,
)

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

GO, LEFT, REST, HOLE, LONG, SPENT, OUTSIDE, STALLED, NO_DATA = range(9)
"""Why a trace ends: it does not yet (or end time), left the domain, at rest, hole, largest length, most steps; began outside,
steps too small, beyond the last of the time steps."""

INSIDE, FACE = -1, -2
"""How a step ends if the trace goes on: within a cell, on a face."""

EXTENT, NAG, FIXED, CELL, CURVATURE = range(5)
"""What a step is controlled by."""

GRAZES = 6
"""How often a step that grazes a face is halved before its dense output decides."""

WALL = 1e-9
"""A normal velocity below this part of the field's is none: what seems to leave there only overshoots."""

SIDES, NEAREST, LOWEST, HIGHEST = 0, 1, 2, 3
"""Rows of `Rules.box`: extent of the domain, smaller |coordinate| of its ends; ends in coordinates of the march."""


class Rules(NamedTuple):
    """How to march; times are positive in the direction of the march.

    Attributes
    ----------
    control : EXTENT, NAG, FIXED, CELL or CURVATURE
    tolerance : relative, of EXTENT and NAG
    size : time step of FIXED, part of a cell of CELL, angle of CURVATURE
    power, quick : 1 / (order of the error estimate + 1), and the part of the allowed error below which steps grow fivefold
    factor : error of a step over its difference from n parts, n^p / (n^p - 1)
    box : (4, 3) see SIDES
    first, smallest : sizes of the first step and of the smallest that is worth taking
    end, interval, length, steps : end time, time between samples (0: each step), largest length, most steps
    rest, mean : speed that is none, and the field's mean speed, in coordinates of the march
    faces : whether steps end on faces
    halve : whether a crossing of a cell takes at least two steps
    assess : whether to march in parts of the steps beside
    parts : how many; RKSUITE takes three of a method of order 3, so that their error is much smaller, else two
    subsidiary : whether the march in parts is what is reported
    holes : whether there are samples that are no numbers
    """

    control: int
    tolerance: float
    size: float
    power: float
    quick: float
    factor: float
    box: Floats
    first: float
    smallest: float
    end: float
    interval: float
    length: float
    steps: int
    rest: float
    mean: float
    faces: bool
    halve: bool
    assess: bool
    parts: int
    subsidiary: bool
    holes: bool


@lean_part
def ratio(form: int, here: Floats, rules: Rules, step: Floats) -> float:
    """The largest component of the local error over its weight, thesis (5.3) and (5.4) with NAG; `SIDES` otherwise."""
    e = (step[ERROR, 0], step[ERROR, 1], step[ERROR, 2])
    if form == BENT:
        e = carried(form, here, step[END, 0], step[END, 1], step[END, 2], e)
    worst = 0.0
    for m in range(3):
        weight = rules.box[SIDES, m]
        if rules.control == NAG:
            threshold = max(rules.tolerance * rules.box[NEAREST, m], 1.5e-154)
            weight = max(0.5 * (abs(step[START, m]) + abs(step[END, m])), threshold)
        part = abs(e[m]) / weight
        if not part <= worst:
            worst = part
    return worst


@lean_part
def sample(flow: Flow, here: Floats, cell: Integers, faces: bool, x: float, y: float, z: float, t: float) -> Vector:
    """The velocity at a position: of the present cell with `faces`, else of the cell that holds the position."""
    if faces:
        return velocity_in(flow.form, here, x, y, z, t)
    return velocity_across(flow, here, cell, x, y, z, t)


@lean_part
def turning(form: int, here: Floats, t: float, step: Floats) -> None:
    """The velocity at the start of a step and its change along it, by the difference over 1e-5 of a cell."""
    x, y, z = step[START, 0], step[START, 1], step[START, 2]
    a, b, c = velocity_in(form, here, x, y, z, t)
    speed = max(abs(a), abs(b), abs(c))
    h = 1e-5 * edge(form, here) / speed if speed > 0.0 else 1.0
    p, q, r = velocity_in(form, here, x + h * a, y + h * b, z + h * c, t + h)
    step[0, 0], step[0, 1], step[0, 2] = step[SPEED, 0], step[SPEED, 1], step[SPEED, 2] = a, b, c
    step[TURN, 0], step[TURN, 1], step[TURN, 2] = (p - a) / h, (q - b) / h, (r - c) / h


@lean_part
def crossing(form: int, here: Floats, step: Floats) -> tuple[float, int]:
    """When the parabola of velocity and acceleration first leaves the cell, and through which face; inf if never."""
    first, through = np.inf, -1
    for face in range(4 if form == TETRA else 6):
        if form == TETRA:
            n = PLANE + face
            g = here[n, 0] * step[START, 0] + here[n, 1] * step[START, 1] + here[n, 2] * step[START, 2]
            g += face_place(form, here, face)
            r = here[n, 0] * step[SPEED, 0] + here[n, 1] * step[SPEED, 1] + here[n, 2] * step[SPEED, 2]
            s = 0.5 * (here[n, 0] * step[TURN, 0] + here[n, 1] * step[TURN, 1] + here[n, 2] * step[TURN, 2])
        elif face & 1:
            m = face >> 1
            g, r, s = here[HIGH, m] - step[START, m], -step[SPEED, m], -0.5 * step[TURN, m]
        else:
            m = face >> 1
            g, r, s = step[START, m] - here[LOW, m], step[SPEED, m], 0.5 * step[TURN, m]
        if r >= 0.0 and s >= 0.0:
            continue
        g = max(g, 0.0)
        t = np.inf
        root = r * r - 4.0 * s * g
        if root >= 0.0:
            root = math.sqrt(root)
            t = 2.0 * g / (root - r) if r < 0.0 else (r + root) / (-2.0 * s)  # the nearer root, without cancellation
        if t < first:
            first, through = t, face
    return first, through


@lean_part
def stand(
    flow: Flow, here: Floats, cell: Integers, faces: bool, turn: bool, t: float, step: Floats
) -> tuple[float, int, int]:
    """Velocity at the start of a step, in the cell that it goes into; time to the face and which, and 0.

    Without `faces` there is no face, and the acceleration is known only if `turn` asks for it.
    Where the face leads nowhere the last number says why: 1 the border, 2 a hole; the particle then stands before it.
    """
    if not faces:
        x, y, z = step[START, 0], step[START, 1], step[START, 2]
        if turn:
            find(flow, here, cell, x, y, z)
            turning(flow.form, here, t, step)
        else:
            step[0, 0], step[0, 1], step[0, 2] = velocity_across(flow, here, cell, x, y, z, t)
        return np.inf, -1, 0
    for _ in range(6):
        turning(flow.form, here, t, step)
        time, face = crossing(flow.form, here, step)
        if time > 0.0:
            return time, face, 0
        code = onwards(flow, here, cell, face)
        if code:
            return -1.0, face, code
    return 0.0, -1, 0


@lean_part
def wanted(rules: Rules, form: int, here: Floats, step: Floats, speed: float, h: float) -> float:
    """The size of a step that no error controls."""
    if rules.control == FIXED:
        return rules.size
    if rules.control == CELL:
        return rules.size * edge(form, here) / speed
    if rules.control == CURVATURE:
        v, a = step[SPEED], step[TURN]
        x, y, z = v[1] * a[2] - v[2] * a[1], v[2] * a[0] - v[0] * a[2], v[0] * a[1] - v[1] * a[0]
        bent = math.sqrt(x * x + y * y + z * z) / speed**2
        cell = edge(form, here) / speed
        return min(rules.size / bent, cell) if bent > 0.0 else cell
    return h


@lean_part
def proposed(
    rules: Rules, form: int, here: Floats, step: Floats, speed: float, h: float, time: float, limit: float, fresh: bool
) -> tuple[float, float, bool]:
    """The size to try, the one that control would take, and whether it aims at the face that `time` tells."""
    keep = h = wanted(rules, form, here, step, speed, h)
    half = rules.halve and fresh
    if half:
        time *= 0.5
    aimed = rules.faces and time <= h and not half
    h = min(h, time, limit)
    if rules.holes and not rules.faces:
        h = min(h, 4.0 * edge(form, here) / speed)
    if h < limit and not aimed:
        h = min(h, max(limit - h, 0.5 * limit))  # the last two steps share what is left
    return h, keep, aimed


@lean_part
def into_hole(flow: Flow, here: Floats, cell: Integers, t: float, step: Floats) -> bool:
    """Whether the dense output of a step goes through a hole."""
    for look in range(1, LOOKS + 1):
        theta = look / LOOKS
        v = sample(flow, here, cell, False, along(step, 0, theta), along(step, 1, theta), along(step, 2, theta), t)
        if not v[0] - v[0] == 0.0:
            return True
    return False


@lean_part
def measured(flow: Flow, here: Floats, cell: Integers, rules: Rules, t: float, step: Floats) -> float:
    """The local error over what is allowed, 0 where no error controls the step; NaN through a hole."""
    over = ratio(flow.form, here, rules, step) / rules.tolerance if rules.control <= NAG else 0.0
    for m in range(3):
        if not step[END, m] - step[END, m] == 0.0:
            return np.nan
    if rules.holes and not rules.faces and over < 1.0 and into_hole(flow, here, cell, t, step):
        return np.nan
    return over


@lean_part
def advance(
    flow: Flow, here: Floats, cell: Integers, walls: Floats, tableau: Floats, rules: Rules, t: float, h: float, limit: float,
    fresh: bool, step: Floats, tally: Integers,
) -> tuple[int, float, float, int]:  # fmt: skip
    """One accepted step from `step[START]` at time t: how it ends (or why none is taken), its time, the size for the next,
    and the face.

    Counted in `tally`: steps refused, and evaluations of the velocity.
    """
    time, aim, code = stand(flow, here, cell, rules.faces, rules.control > FIXED or rules.holes, t, step)
    speed = math.sqrt(step[0, 0] ** 2 + step[0, 1] ** 2 + step[0, 2] ** 2)
    if code:
        return (LEFT if code == 1 else HOLE), 0.0, h, aim
    if not speed > rules.rest:
        if not speed == speed or flow.whole[NT] == 1:
            return (REST if speed == speed else HOLE), 0.0, h, aim
        speed = max(rules.rest, 1e-300)  # in an unsteady flow it may move the next moment
    h, keep, aimed = proposed(rules, flow.form, here, step, speed, h, time, limit, fresh)
    before = tally[0]
    for _ in range(200):
        if rules.faces:
            attempt(flow.form, here, tableau, t, h, step)
        else:
            attempt_across(flow, here, cell, tableau, t, h, step)
        tally[1] += tableau.shape[1] - 2
        over = measured(flow, here, cell, rules, t, step)
        if not over < 1.0:
            tally[0] += 1
            h *= max(0.2, 0.9 * over**-rules.power) if over < 1e30 else 0.5
            aimed = False
            if h < (rules.smallest if over == over else 1e6 * rules.smallest):
                return (STALLED if over == over else HOLE), 0.0, h, aim
            continue
        if rules.control <= NAG:
            grown = 5.0 if over < rules.quick else 0.9 * over**-rules.power
            keep = max(keep if keep > h else 0.0, h * grown)
        how, taken, face = ended(flow, here, cell, walls, tableau, rules, t, aimed, aim, step, tally)
        if how == REST or (taken < 0.0 and tally[0] - before < GRAZES):  # a wall, or a face, that only seems to be crossed
            tally[0] += 1
            h, aimed = 0.5 * h, False
            if h < rules.smallest:
                return REST, 0.0, h, face
            continue
        return how, abs(taken), keep, face
    return STALLED, 0.0, h, aim


@lean_part
def ended(
    flow: Flow, here: Floats, cell: Integers, walls: Floats, tableau: Floats, rules: Rules, t: float, aimed: bool, aim: int,
    step: Floats, tally: Integers,
) -> tuple[int, float, int]:  # fmt: skip
    """How a step ends: INSIDE, on a FACE, or REST where it would cross a wall; the time that it takes, negative where it
    grazes the face; and the face.
    """
    form = flow.form
    theta, face = first_exit(form, walls, step)
    if theta > 1.0:
        if not aimed:
            return INSIDE, step[SIZE, 0], -1
        theta, face = beyond_end(form, walls, aim, step, 0.2), aim
        if theta > 1.5:
            return INSIDE, step[SIZE, 0], -1
    taken, used, face = to_face(flow, here, cell, walls, tableau, rules.faces, t, theta, face, step)
    tally[1] += used
    if used:
        other, sooner = first_exit(form, walls, step)
        if other < 1.0 - 1e-6 and sooner != face:  # taken anew it leaves through another face before
            taken, used, face = to_face(flow, here, cell, walls, tableau, rules.faces, t, other, sooner, step)
            tally[1] += used
    if face < 0:
        return INSIDE, abs(taken), -1
    if border(flow, cell, rules, face):
        if form != TETRA:
            for m in range(3):
                step[END, m] = min(max(step[END, m], walls[LOW, m]), walls[HIGH, m])
        if not outwards(flow, here, cell, rules, t + abs(taken), face, step) > WALL * rules.mean:
            return REST, 0.0, face
    return FACE, taken, face


@lean_part
def border(flow: Flow, cell: Integers, rules: Rules, face: int) -> bool:
    """Whether a face lies on the border of the domain."""
    if not rules.faces:
        return True
    if flow.form == TETRA:
        return bool(flow.whole[SIZE_OF_INDEX + 4 * (flow.whole[TETRAHEDRA] + cell[0]) + face] < 0)
    axis = face >> 1
    return bool(cell[axis] == (flow.whole[NX + axis] - 2 if face & 1 else 0))


@lean_part
def outwards(flow: Flow, here: Floats, cell: Integers, rules: Rules, t: float, face: int, step: Floats) -> float:
    """The speed at which a step goes out through a face, at its end."""
    v = sample(flow, here, cell, rules.faces, step[END, 0], step[END, 1], step[END, 2], t)
    if flow.form != TETRA:
        return v[face >> 1] if face & 1 else -v[face >> 1]
    n = PLANE + face
    across = here[n, 0] * v[0] + here[n, 1] * v[1] + here[n, 2] * v[2]
    return float(-across / math.sqrt(here[n, 0] ** 2 + here[n, 1] ** 2 + here[n, 2] ** 2))


@lean_part
def begin(flow: Flow, here: Floats, cell: Integers, rules: Rules, seed: Floats, first: int, clock: float) -> int:
    """Stand at a seed: GO if there is a velocity, OUTSIDE, HOLE or NO_DATA if not."""
    slab, last = 0, flow.whole[NT] - 1
    while slab < last - 1 and clock >= time_of(flow, slab + 1):
        slab += 1
    cell[3] = slab
    if last > 0 and not time_of(flow, 0) <= clock <= time_of(flow, last):
        return NO_DATA
    if flow.form == TETRA:
        cell[0] = first
        return OUTSIDE if first < 0 else (GO if load(flow, here, cell) else HOLE)
    for m in range(3):
        if not rules.box[LOWEST, m] <= seed[m] <= rules.box[HIGHEST, m]:
            return OUTSIDE
    return GO if find(flow, here, cell, seed[0], seed[1], seed[2]) else HOLE
