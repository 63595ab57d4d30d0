"""The cell in which a particle is: its smooth velocity, its faces, and the way into the next cell.

A field is a patchwork of cells, each with a velocity that is smooth within it. Where a particle is, and how fast it moves,
is said in the coordinates of the march:

    BOX, MOVING   boxes along the axes, linear in each; steady, or linear in time between two steps. Coordinates are positions
    SMOOTH        boxes, cubic in each axis from four samples; steady
    BENT          hexahedra of a bent lattice; coordinates are those of the lattice, dq/dt = J(q)^-1 V(q) with the very
                  derivative J of the cell's trilinear map, so this is the motion in physical space and no approximation of it
    TETRA         tetrahedra, linear in each; coordinates are positions

What is known of the present cell lies in one array `here`, by rows that are named below; numbers of the cell in `cell`.
A weight near a face is measured from that face, so on a wall whose samples are at rest the velocity is exactly zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_inlined, lean_part

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Vector = tuple[float, float, float]

BOX, MOVING, SMOOTH, BENT, TETRA = range(5)
"""Forms of a field."""

CORNER, RATE, NODE, LOW, HIGH, SCALE, CLOCK = 0, 8, 16, 24, 25, 26, 27
"""Rows of `here`: velocities of the corners, their rates, positions; ends of the cell, one over its edges; begin of the
present time step and whether there is one. A tetrahedron has the matrix and constant of its velocity at CORNER, RATE."""

PLANE, OFFSET, STENCIL, BASIS, SLOPES, ROWS = 28, 32, 34, 98, 114, 117
"""Further rows: inward normals of a tetrahedron and how far its origin is inside; samples of a cubic cell, and the powers of
its weights along each axis (column); derivatives along x, y, z."""


class Flow(NamedTuple):
    """A velocity field as compiled code takes it: few arrays, since each one costs at every call.

    Attributes
    ----------
    form, flat : BOX ...; whether each cell has the one velocity of its sample
    numbers : (n,) all numbers of the field, one array after the other
    whole : (m,) sizes and where in `numbers` each array begins, by the names below; then whole numbers

    The arrays: values (nt, nz, ny, nx, 3), of tetrahedra (nt, n, 3); ends of the cells along x, y, z; times (nt,); nodes, as
    one time of values; basis (3, cells, 16) powers of the four weights of a cubic cell along each axis. Whole numbers: base
    (3, cells) first sample of a cubic cell; or tetrahedra (t, 4) nodes, and beyond (t, 4) the tetrahedron beyond the face
    opposite to each node, -1 at the border.
    """

    form: int
    flat: bool
    numbers: Floats
    whole: Integers


NX, NT, STRIDE, AXES, TIMES, NODES, BASES, LONGEST, TETRAHEDRA, SIZE_OF_INDEX = 0, 3, 4, 7, 10, 11, 12, 13, 14, 15
"""In `Flow.whole`: numbers of ends of cells along x, y, z; number of times; steps from sample to sample along x, y, z, in
numbers; places of the axes, times, nodes, bases; cells of the longest axis; number of tetrahedra."""


@jit
def nowhere() -> Floats:
    """Room for a cell, to be filled by `load`."""
    return np.zeros((ROWS, 3))


@lean_part
def time_of(flow: Flow, slab: int) -> float:
    """A time of the values."""
    return float(flow.numbers[flow.whole[TIMES] + slab])


@lean_part
def _cell_of(flow: Flow, axis: int, x: float, hint: int) -> int:
    """The cell of a coordinate, walked to from a hint; the outermost one beyond the ends, on a face the one above it."""
    at, last = int(flow.whole[AXES + axis]), int(flow.whole[NX + axis]) - 2
    i = min(max(hint, 0), last)
    while i < last and x >= flow.numbers[at + i + 1]:
        i += 1
    while i > 0 and x < flow.numbers[at + i]:
        i -= 1
    return i


@lean_part
def find(flow: Flow, here: Floats, cell: Integers, x: float, y: float, z: float) -> bool:
    """Go to the box of a position, at the border the nearest; returns whether all that it needs are numbers."""
    cell[0] = _cell_of(flow, 0, x, cell[0])
    cell[1] = _cell_of(flow, 1, y, cell[1])
    cell[2] = _cell_of(flow, 2, z, cell[2])
    return load(flow, here, cell)


@lean_part
def load(flow: Flow, here: Floats, cell: Integers) -> bool:
    """Fetch what is needed of the cell `cell`, at its time step; returns whether all are numbers."""
    numbers, index = flow.numbers, flow.whole
    if flow.form == TETRA:
        return _tetrahedron(flow, here, cell)
    first = 0
    for m in range(3):
        at = index[AXES + m] + cell[m]
        here[LOW, m], here[HIGH, m] = numbers[at], numbers[at + 1]
        here[SCALE, m] = 1.0 / (numbers[at + 1] - numbers[at])
        first += index[STRIDE + m] * cell[m]
    dx, dy, dz = (0, 0, 0) if flow.flat else (index[STRIDE], index[STRIDE + 1], index[STRIDE + 2])
    at = first + cell[3] * index[NODES]
    total = 0.0
    for corner in range(8):
        o = at + (corner & 1) * dx + (corner >> 1 & 1) * dy + (corner >> 2) * dz
        a, b, c = numbers[o], numbers[o + 1], numbers[o + 2]
        here[CORNER + corner, 0], here[CORNER + corner, 1], here[CORNER + corner, 2] = a, b, c
        total += a + b + c
    if flow.form != BOX:
        total += _more(flow, here, cell, first, (dx, dy, dz))
    return total - total == 0.0


@lean_part
def _more(flow: Flow, here: Floats, cell: Integers, first: int, step: tuple[int, int, int]) -> float:
    """Fetch rates, positions and weights of a cell whose form has them; the sum of what may be no number."""
    numbers, index, total = flow.numbers, flow.whole, 0.0
    here[CLOCK, 0] = time_of(flow, cell[3])
    here[CLOCK, 1] = 1.0 if index[NT] > 1 else 0.0
    for corner in range(8):
        o = first + (corner & 1) * step[0] + (corner >> 1 & 1) * step[1] + (corner >> 2) * step[2]
        for m in range(3):
            if index[NT] > 1:
                change = numbers[o + (cell[3] + 1) * index[NODES] + m] - here[CORNER + corner, m]
                here[RATE + corner, m] = change / (time_of(flow, cell[3] + 1) - here[CLOCK, 0])
                total += change
            if flow.form == BENT:
                here[NODE + corner, m] = numbers[o + index[NODES] * index[NT] + m]
    if flow.form == SMOOTH:
        total += _stencil(flow, here, cell)
    return total


@lean_part
def _stencil(flow: Flow, here: Floats, cell: Integers) -> float:
    """Fetch the samples and weights of a cubic cell; their sum, to tell whether all are numbers."""
    numbers, index, longest = flow.numbers, flow.whole, flow.whole[LONGEST]
    total, row = 0.0, STENCIL
    for axis in range(3):
        for p in range(16):
            here[BASIS + p, axis] = numbers[index[BASES] + (axis * longest + cell[axis]) * 16 + p]
    for c in range(4):
        k = min(index[SIZE_OF_INDEX + 2 * longest + cell[2]] + c, index[NX + 2] - 1) * index[STRIDE + 2]
        for b in range(4):
            j = min(index[SIZE_OF_INDEX + longest + cell[1]] + b, index[NX + 1] - 1) * index[STRIDE + 1]
            for a in range(4):
                i = min(index[SIZE_OF_INDEX + cell[0]] + a, index[NX] - 1) * index[STRIDE]
                for m in range(3):
                    here[row, m] = numbers[i + j + k + m]
                    total += numbers[i + j + k + m]
                row += 1
    return total


@lean_part
def _tetrahedron(flow: Flow, here: Floats, cell: Integers) -> bool:
    """Fetch the planes of a tetrahedron, and its velocity as a matrix and a constant."""
    numbers, index, total = flow.numbers, flow.whole, 0.0
    here[CLOCK, 0] = time_of(flow, cell[3])
    here[CLOCK, 1] = 1.0 if index[NT] > 1 else 0.0
    nodes, at = index[NODES] * index[NT], SIZE_OF_INDEX + 4 * cell[0]
    for f in range(4):
        o, a = nodes + 3 * index[at + f], nodes + 3 * index[at + ((f + 1) & 3)]
        b, c = nodes + 3 * index[at + ((f + 2) & 3)], nodes + 3 * index[at + ((f + 3) & 3)]
        for m in range(3):
            p, q = (m + 1) % 3, (m + 2) % 3
            here[PLANE + f, m] = (
                (numbers[b + p] - numbers[a + p]) * (numbers[c + q] - numbers[a + q])
                - (numbers[b + q] - numbers[a + q]) * (numbers[c + p] - numbers[a + p])
            )  # fmt: skip
        height, offset = 0.0, 0.0
        for m in range(3):
            height += here[PLANE + f, m] * (numbers[o + m] - numbers[a + m])
        for m in range(3):
            here[PLANE + f, m] /= height
            offset -= here[PLANE + f, m] * numbers[a + m]
        here[OFFSET + f // 3, f % 3] = offset
    here[CORNER : CORNER + 4] = 0.0
    here[RATE : RATE + 4] = 0.0
    for m in range(3):
        for f in range(4):
            o = 3 * index[at + f] + m + cell[3] * index[NODES]
            value, rate = numbers[o], 0.0
            if index[NT] > 1:
                rate = (numbers[o + index[NODES]] - value) / (time_of(flow, cell[3] + 1) - here[CLOCK, 0])
            total += value + rate
            for d in range(3):
                here[CORNER + m, d] += value * here[PLANE + f, d]
                here[RATE + m, d] += rate * here[PLANE + f, d]
            here[CORNER + 3, m] += value * here[OFFSET + f // 3, f % 3]
            here[RATE + 3, m] += rate * here[OFFSET + f // 3, f % 3]
    return total - total == 0.0


@lean_inlined
def holds(here: Floats, x: float, y: float, z: float) -> bool:
    """Whether a position lies in the box, its faces included."""
    return bool(
        here[LOW, 0] <= x <= here[HIGH, 0] and here[LOW, 1] <= y <= here[HIGH, 1] and here[LOW, 2] <= z <= here[HIGH, 2]
    )


@lean_inlined
def _mixed(here: Floats, r: int, m: int, u: tuple[float, float], a: float, b: float, c: float, d: float) -> float:
    low = a * here[r, m] + b * here[r + 2, m] + c * here[r + 4, m] + d * here[r + 6, m]
    high = a * here[r + 1, m] + b * here[r + 3, m] + c * here[r + 5, m] + d * here[r + 7, m]
    return float(u[0] * low + u[1] * high)


@lean_inlined
def _trilinear(here: Floats, r: int, x: float, y: float, z: float) -> Vector:
    """What the corners at row r tell at a position, continued beyond the faces."""
    u = ((here[HIGH, 0] - x) * here[SCALE, 0], (x - here[LOW, 0]) * here[SCALE, 0])
    v0, v1 = (here[HIGH, 1] - y) * here[SCALE, 1], (y - here[LOW, 1]) * here[SCALE, 1]
    w0, w1 = (here[HIGH, 2] - z) * here[SCALE, 2], (z - here[LOW, 2]) * here[SCALE, 2]
    a, b, c, d = v0 * w0, v1 * w0, v0 * w1, v1 * w1
    return _mixed(here, r, 0, u, a, b, c, d), _mixed(here, r, 1, u, a, b, c, d), _mixed(here, r, 2, u, a, b, c, d)


@lean_inlined
def velocity(form: int, here: Floats, x: float, y: float, z: float, t: float) -> Vector:
    """The velocity of the cell, in coordinates of the march, continued beyond its faces."""
    if form == BOX:
        return _trilinear(here, CORNER, x, y, z)
    return _other(form, here, x, y, z, t)


@lean_part
def trilinear(here: Floats, r: int, x: float, y: float, z: float) -> Vector:
    """As `_trilinear`, where speed matters less than the size of the code."""
    return _trilinear(here, r, x, y, z)


@lean_part
def velocity_in(form: int, here: Floats, x: float, y: float, z: float, t: float) -> Vector:
    """As `velocity`, where speed matters less than the size of the code."""
    return velocity(form, here, x, y, z, t)


@lean_part
def velocity_across(flow: Flow, here: Floats, cell: Integers, x: float, y: float, z: float, t: float) -> Vector:
    """The velocity at a position in whatever cell it lies; of linear boxes another cell may stay loaded."""
    if holds(here, x, y, z):
        return velocity_in(flow.form, here, x, y, z, t)
    if flow.form != BOX or flow.flat:
        find(flow, here, cell, x, y, z)
        return velocity_in(flow.form, here, x, y, z, t)
    n, index = flow.numbers, flow.whole
    cell[0] = i = _cell_of(flow, 0, x, cell[0])
    cell[1] = j = _cell_of(flow, 1, y, cell[1])
    cell[2] = k = _cell_of(flow, 2, z, cell[2])
    dx, dy, dz = index[STRIDE], index[STRIDE + 1], index[STRIDE + 2]
    a, b, c = index[AXES] + i, index[AXES + 1] + j, index[AXES + 2] + k
    u1, v1 = (x - n[a]) / (n[a + 1] - n[a]), (y - n[b]) / (n[b + 1] - n[b])
    w1 = (z - n[c]) / (n[c + 1] - n[c])
    o = i * dx + j * dy + k * dz
    p, q, r = _row(n, o, dx, 1.0 - u1, u1), _row(n, o + dy, dx, 1.0 - u1, u1), _row(n, o + dz, dx, 1.0 - u1, u1)
    s = _row(n, o + dy + dz, dx, 1.0 - u1, u1)
    f, g, h, e = (1.0 - v1) * (1.0 - w1), v1 * (1.0 - w1), (1.0 - v1) * w1, v1 * w1
    return (
        f * p[0] + g * q[0] + h * r[0] + e * s[0], f * p[1] + g * q[1] + h * r[1] + e * s[1],
        f * p[2] + g * q[2] + h * r[2] + e * s[2],
    )  # fmt: skip


@lean_inlined
def _row(n: Floats, o: int, dx: int, u0: float, u1: float) -> Vector:
    """Between a sample and the next one along x."""
    p = o + dx
    return u0 * n[o] + u1 * n[p], u0 * n[o + 1] + u1 * n[p + 1], u0 * n[o + 2] + u1 * n[p + 2]


@lean_part
def _other(form: int, here: Floats, x: float, y: float, z: float, t: float) -> Vector:
    if form == SMOOTH:
        return _cubic(here, x, y, z)
    v = physical(form, here, x, y, z, t)
    return _lattice(here, x, y, z, v) if form == BENT else v


@lean_part
def physical(form: int, here: Floats, x: float, y: float, z: float, t: float) -> Vector:
    """The velocity in physical space at coordinates of the march."""
    s = t - here[CLOCK, 0]
    if form == TETRA:
        v, r = _affine(here, CORNER, x, y, z), (0.0, 0.0, 0.0)
        if here[CLOCK, 1] > 0.0:
            r = _affine(here, RATE, x, y, z)
    elif form == SMOOTH:
        return _cubic(here, x, y, z)
    else:
        v, r = trilinear(here, CORNER, x, y, z), (0.0, 0.0, 0.0)
        if here[CLOCK, 1] > 0.0:
            r = trilinear(here, RATE, x, y, z)
    return v[0] + s * r[0], v[1] + s * r[1], v[2] + s * r[2]


@lean_part
def _affine(here: Floats, r: int, x: float, y: float, z: float) -> Vector:
    return (
        here[r + 3, 0] + here[r, 0] * x + here[r, 1] * y + here[r, 2] * z,
        here[r + 3, 1] + here[r + 1, 0] * x + here[r + 1, 1] * y + here[r + 1, 2] * z,
        here[r + 3, 2] + here[r + 2, 0] * x + here[r + 2, 1] * y + here[r + 2, 2] * z,
    )


@lean_part
def _cubic(here: Floats, x: float, y: float, z: float) -> Vector:
    u = (
        (x - here[LOW, 0]) * here[SCALE, 0], (y - here[LOW, 1]) * here[SCALE, 1], (z - here[LOW, 2]) * here[SCALE, 2],
    )  # fmt: skip
    w = here[BASIS : BASIS + 16]
    total0, total1, total2 = 0.0, 0.0, 0.0
    row = STENCIL
    for c in range(4):
        wz = w[4 * c, 2] + u[2] * (w[4 * c + 1, 2] + u[2] * (w[4 * c + 2, 2] + u[2] * w[4 * c + 3, 2]))
        for b in range(4):
            wy = wz * (w[4 * b, 1] + u[1] * (w[4 * b + 1, 1] + u[1] * (w[4 * b + 2, 1] + u[1] * w[4 * b + 3, 1])))
            for a in range(4):
                wx = wy * (w[4 * a, 0] + u[0] * (w[4 * a + 1, 0] + u[0] * (w[4 * a + 2, 0] + u[0] * w[4 * a + 3, 0])))
                total0 += wx * here[row, 0]
                total1 += wx * here[row, 1]
                total2 += wx * here[row, 2]
                row += 1
    return total0, total1, total2


@lean_part
def _lattice(here: Floats, x: float, y: float, z: float, v: Vector) -> Vector:
    """A velocity of physical space in coordinates of a bent lattice: J^-1 v, by Cramer's rule."""
    derivative(here, NODE, x, y, z)
    a, b, c = here[SLOPES], here[SLOPES + 1], here[SLOPES + 2]
    n = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
    o = (c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0])
    p = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    volume = a[0] * n[0] + a[1] * n[1] + a[2] * n[2]
    if volume == 0.0:
        return math.nan, math.nan, math.nan
    return (
        (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]) / volume,
        (v[0] * o[0] + v[1] * o[1] + v[2] * o[2]) / volume,
        (v[0] * p[0] + v[1] * p[1] + v[2] * p[2]) / volume,
    )


@lean_part
def derivative(here: Floats, r: int, x: float, y: float, z: float) -> None:
    """Derivatives of what the corners at row r tell, along x, y and z, into the rows from `SLOPES`."""
    f, g, h = here[SCALE, 0], here[SCALE, 1], here[SCALE, 2]
    u, v, w = (x - here[LOW, 0]) * f, (y - here[LOW, 1]) * g, (z - here[LOW, 2]) * h
    a, b, c, d = (1.0 - v) * (1.0 - w), v * (1.0 - w), (1.0 - v) * w, v * w
    p, q, s, t = (1.0 - u) * (1.0 - w), u * (1.0 - w), (1.0 - u) * w, u * w
    i, j, k, n = (1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v
    for m in range(3):
        f0, f1, f2, f3 = here[r, m], here[r + 1, m], here[r + 2, m], here[r + 3, m]
        f4, f5, f6, f7 = here[r + 4, m], here[r + 5, m], here[r + 6, m], here[r + 7, m]
        here[SLOPES, m] = f * (a * (f1 - f0) + b * (f3 - f2) + c * (f5 - f4) + d * (f7 - f6))
        here[SLOPES + 1, m] = g * (p * (f2 - f0) + q * (f3 - f1) + s * (f6 - f4) + t * (f7 - f5))
        here[SLOPES + 2, m] = h * (i * (f4 - f0) + j * (f5 - f1) + k * (f6 - f2) + n * (f7 - f3))


@lean_part
def place(form: int, here: Floats, x: float, y: float, z: float) -> Vector:
    """The position of coordinates of the march."""
    return trilinear(here, NODE, x, y, z) if form == BENT else (x, y, z)


@lean_part
def carried(form: int, here: Floats, x: float, y: float, z: float, d: Vector) -> Vector:
    """A small displacement, or a velocity, in coordinates of the march as one of positions."""
    if form != BENT:
        return d
    derivative(here, NODE, x, y, z)
    a, b, c = here[SLOPES], here[SLOPES + 1], here[SLOPES + 2]
    return (
        a[0] * d[0] + b[0] * d[1] + c[0] * d[2], a[1] * d[0] + b[1] * d[1] + c[1] * d[2],
        a[2] * d[0] + b[2] * d[1] + c[2] * d[2],
    )  # fmt: skip


@lean_part
def onwards(flow: Flow, here: Floats, cell: Integers, face: int) -> int:
    """Into the neighbour beyond a face: 0 done; 1 there is none (the border of the domain), 2 it is a hole, and it stays."""
    axis = 0
    if flow.form == TETRA:
        there = flow.whole[SIZE_OF_INDEX + 4 * (flow.whole[TETRAHEDRA] + cell[0]) + face]
        if there < 0:
            return 1
    else:
        axis = face >> 1
        there = cell[axis] + (1 if face & 1 else -1)
        if there < 0 or there > flow.whole[NX + axis] - 2:
            return 1
    before = cell[axis]
    cell[axis] = there
    if load(flow, here, cell):
        return 0
    cell[axis] = before
    load(flow, here, cell)
    return 2


@lean_part
def edge(form: int, here: Floats) -> float:
    """The smallest edge of a box, or height of a tetrahedron."""
    if form != TETRA:
        return float(1.0 / max(here[SCALE, 0], here[SCALE, 1], here[SCALE, 2]))
    steepest = 0.0
    for f in range(4):
        steepest = max(steepest, here[PLANE + f, 0] ** 2 + here[PLANE + f, 1] ** 2 + here[PLANE + f, 2] ** 2)
    return 1.0 / math.sqrt(steepest)
