"""How a trace answers to errors of the velocity: the variational equation along it.

An error e of the field displaces a particle by d with d' = J d + e(x). With Phi the derivative of the flow map, an error
of one sample, with trilinear weight w, moves the particle at time T by S = int Phi(T, s) w(x(s)) ds times that error, to
first order. Steps end on the faces of cells, so weights and derivatives are smooth within each.

Source: Alekseev 1961, Groebner 1960 (the integral); Lopes 1999, 5.4 asks for the error of interpolation along a trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit, lean_part
from modules.kernels.runge_kutta import PAIRS
from modules.kernels.trace import flow_of, rules_of, tableau_of
from modules.kernels.trace_cell import (
    CORNER,
    HIGH,
    LOW,
    NX,
    SLOPES,
    Flow,
    derivative,
    find,
    nowhere,
    onwards,
)  # fmt: skip
from modules.kernels.trace_march import Rules, stand
from modules.kernels.trace_step import END, SIZE, START, along, attempt, blank, first_exit, taylor, to_face

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

METHOD = next(iter(PAIRS))


class Sensitivity(NamedTuple):
    """Answers of n positions.

    Attributes
    ----------
    start : (n + 1,) the answers of position i are start[i]:start[i + 1]
    sample : of each answer, the sample in [z, y, x] order
    answer : (..., 3, 3) displacement by an error of that sample, component by component
    drift : (n, 3) displacement by the field's own error `second` tells of; zeros without
    growth : (n, 3, 3) derivative of the position by the seed
    """

    start: Integers
    sample: Integers
    answer: Floats
    drift: Floats
    growth: Floats


class Touched(NamedTuple):
    """Samples touched by a trace so far: their numbers, the slot of each sample (-1: none), answers, how many."""

    sample: Integers
    slot: Integers
    answer: Floats
    number: Integers


class Maps(NamedTuple):
    """Of one step: growth over its first and second half and over all, scratch (3, 3) twice; weights (3, 8) at its start,
    middle and end; errors of the field there (3, 3).
    """

    early: Floats
    late: Floats
    whole: Floats
    a: Floats
    b: Floats
    weight: Floats
    error: Floats


def answers(flow: Flow, seeds: Floats, times: Sequence[Floats], second: Floats | None = None) -> Sensitivity:
    """Follow particles, and how each position at the given times answers to errors of the samples.

    Parameters
    ----------
    flow : from `flow_of`
    seeds : (p, 3)
    times : for each particle, ascending from 0
    second : (nz, ny, nx, 3, 3) second derivative of each component (last) along each axis, for the drift

    Accuracy: to first order in the errors; products of growth by the midpoint rule and integrals by Simpson's rule over
        the crossing of each cell.
    """
    counts = np.array([len(t) for t in times], np.int64)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    at = np.concatenate([np.zeros(0), *times])
    curving = np.zeros((0, 0, 0, 3, 3)) if second is None else np.ascontiguousarray(second, np.float64).copy()
    start, sample, answer, drift, growth = _answers(
        flow, np.ascontiguousarray(seeds, np.float64).copy(), offsets, at, tableau_of(METHOD), rules_of(flow), curving
    )
    m = int(start[-1])
    return Sensitivity(start, sample[:m].copy(), answer[:m].copy(), drift, growth)


@jit
def _answers(
    flow: Flow, seeds: Floats, offsets: Integers, times: Floats, tableau: Floats, rules: Rules, second: Floats
) -> tuple[Integers, Integers, Floats, Floats, Floats]:
    n = times.size
    here, step, cell = nowhere(), blank(), np.zeros(4, np.int64)
    nodes = flow.whole[NX] * flow.whole[NX + 1] * flow.whole[NX + 2]
    touched = Touched(np.zeros(nodes, np.int64), np.full(nodes, -1, np.int64), np.zeros((nodes, 3, 3)), np.zeros(1, np.int64))
    maps = Maps(
        np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 8)),
        np.zeros((3, 3)),
    )  # fmt: skip
    start, drift, growth = np.zeros(n + 1, np.int64), np.zeros((n, 3)), np.zeros((n, 3, 3))
    sample, answer = np.zeros(1024, np.int64), np.zeros((1024, 3, 3))
    moved, phi = np.zeros((1, 3)), np.zeros((3, 3))
    for i in range(len(seeds)):
        find(flow, here, cell, seeds[i, 0], seeds[i, 1], seeds[i, 2])
        for c in range(3):
            step[START, c] = seeds[i, c]
            moved[0, c] = 0.0
            for d in range(3):
                phi[c, d] = 1.0 if c == d else 0.0
        t = 0.0
        for r in range(offsets[i], offsets[i + 1]):
            _carry(flow, here, cell, tableau, rules, times[r] - t, step, second, touched, maps, moved, phi)
            t = times[r]
            count = touched.number[0]
            sample, answer = _room(sample, answer, start[r], count)
            start[r + 1] = start[r] + count
            for c in range(3):
                drift[r, c] = moved[0, c]
                for d in range(3):
                    growth[r, c, d] = phi[c, d]
            for e in range(count):
                sample[start[r] + e] = touched.sample[e]
                for c in range(3):
                    for d in range(3):
                        answer[start[r] + e, c, d] = touched.answer[e, c, d]
        for e in range(touched.number[0]):
            touched.slot[touched.sample[e]] = -1
        touched.number[0] = 0
    return start, sample, answer, drift, growth


@jit
def _room(sample: Integers, answer: Floats, used: int, more: int) -> tuple[Integers, Floats]:
    """Room for more answers."""
    if used + more <= sample.size:
        return sample, answer
    size = 2 * (used + more)
    larger, wider = np.zeros(size, np.int64), np.zeros((size, 3, 3))
    for e in range(used):
        larger[e] = sample[e]
        for c in range(3):
            for d in range(3):
                wider[e, c, d] = answer[e, c, d]
    return larger, wider


@jit
def _carry(
    flow: Flow, here: Floats, cell: Integers, tableau: Floats, rules: Rules, left: float, step: Floats, second: Floats,
    touched: Touched, maps: Maps, moved: Floats, phi: Floats,
) -> None:  # fmt: skip
    """March by the time left, from face to face, and carry all answers along."""
    whole = left
    for _ in range(100_000):
        if not left > 1e-14 * whole:
            return
        time, face, code = stand(flow, here, cell, True, True, 0.0, step)
        closed, on, taken = code != 0, False, left
        if not closed and min(left, time) <= 1e-6 * whole:
            taken, on = min(left, time), time < left
            taylor(taken, step)
        else:
            h = min(left, 1.02 * time) if time > 0.0 and not closed else left
            attempt(flow.form, here, tableau, 0.0, h, step)
            theta, face = first_exit(flow.form, here, step)
            taken = h
            if theta <= 1.0 and not closed:
                taken, _used, face = to_face(flow, here, cell, here, tableau, True, 0.0, theta, face, step)
                taken = min(abs(taken), left)
                on = taken < left and face >= 0
        _grow(flow, here, cell, taken, step, second, touched, maps, moved, phi)
        for c in range(3):
            step[START, c] = step[END, c]
        left -= taken
        if on:
            onwards(flow, here, cell, face)


@jit
def _grow(
    flow: Flow, here: Floats, cell: Integers, h: float, step: Floats, second: Floats, touched: Touched, maps: Maps,
    moved: Floats, phi: Floats,
) -> None:  # fmt: skip
    """Carry all answers over a step within the cell, and add what its corners do during it."""
    at = np.zeros(3)
    share = h / step[SIZE, 0] if step[SIZE, 0] > 0.0 else 1.0
    for part in range(2):
        for c in range(3):
            at[c] = along(step, c, share * (0.25 + 0.5 * part))
        derivative(here, CORNER, at[0], at[1], at[2])
        maps.a[:] = here[SLOPES : SLOPES + 3].T
        _exponential(maps.a, 0.5 * h, maps.b, maps.early if part == 0 else maps.late)
    _times(maps.late, maps.early, maps.whole)
    for place in range(3):
        for c in range(3):
            at[c] = along(step, c, 0.5 * place * share)
        _weights(here, cell, at, second, maps.weight[place], maps.error[place])
    for e in range(touched.number[0]):
        _times(maps.whole, touched.answer[e], maps.b)
        for c in range(3):
            for d in range(3):
                touched.answer[e, c, d] = maps.b[c, d]
    _times(maps.whole, phi, maps.b)
    for c in range(3):
        maps.a[0, c] = moved[0, c]
        for d in range(3):
            phi[c, d] = maps.b[c, d]
    for c in range(3):
        total = 0.0
        for d in range(3):
            total += maps.whole[c, d] * (maps.a[0, d] + h / 6.0 * maps.error[0, d])
            total += 4.0 * h / 6.0 * maps.late[c, d] * maps.error[1, d]
        moved[0, c] = total + h / 6.0 * maps.error[2, c]
    _pushed(flow, cell, h, touched, maps)


@lean_part
def _pushed(flow: Flow, cell: Integers, h: float, touched: Touched, maps: Maps) -> None:
    """Add what the corners of the cell do during a step to their answers."""
    nx, ny = flow.whole[NX], flow.whole[NX + 1]
    for corner in range(8):
        i, j, k = cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)
        node = (k * ny + j) * nx + i
        slot = touched.slot[node]
        if slot < 0:
            slot = touched.number[0]
            touched.number[0] += 1
            touched.slot[node] = slot
            touched.sample[slot] = node
            for c in range(3):
                for d in range(3):
                    touched.answer[slot, c, d] = 0.0
        w = maps.weight
        for c in range(3):
            for d in range(3):
                touched.answer[slot, c, d] += h / 6.0 * (
                    w[0, corner] * maps.whole[c, d] + 4.0 * w[1, corner] * maps.late[c, d] + (w[2, corner] if c == d else 0.0)
                )


@lean_part
def _weights(here: Floats, cell: Integers, at: Floats, second: Floats, weight: Floats, error: Floats) -> None:
    """Trilinear weights at a position, and the error 1/2 sum_i u_i (1 - u_i) h_i^2 D2_i of the field there."""
    u = (
        (at[0] - here[LOW, 0]) / (here[HIGH, 0] - here[LOW, 0]), (at[1] - here[LOW, 1]) / (here[HIGH, 1] - here[LOW, 1]),
        (at[2] - here[LOW, 2]) / (here[HIGH, 2] - here[LOW, 2]),
    )  # fmt: skip
    for c in range(3):
        error[c] = 0.0
    for corner in range(8):
        x, y, z = corner & 1, corner >> 1 & 1, corner >> 2
        weight[corner] = (u[0] if x else 1.0 - u[0]) * (u[1] if y else 1.0 - u[1]) * (u[2] if z else 1.0 - u[2])
        if second.shape[0]:
            for axis in range(3):
                h = here[HIGH, axis] - here[LOW, axis]
                part = 0.5 * u[axis] * (1.0 - u[axis]) * h * h * weight[corner]
                for c in range(3):
                    error[c] += part * second[cell[2] + z, cell[1] + y, cell[0] + x, axis, c]


@lean_part
def _times(a: Floats, b: Floats, out: Floats) -> None:
    """The product of two (3, 3) matrices."""
    for c in range(3):
        for d in range(3):
            out[c, d] = a[c, 0] * b[0, d] + a[c, 1] * b[1, d] + a[c, 2] * b[2, d]


@jit
def _exponential(a: Floats, h: float, power: Floats, out: Floats) -> None:
    """e^(a h) by its series, for a h of the size of a cell's crossing."""
    term = np.zeros((3, 3))
    for c in range(3):
        for d in range(3):
            term[c, d] = out[c, d] = 1.0 if c == d else 0.0
    for n in range(1, 30):
        _times(a, term, power)
        size = 0.0
        for c in range(3):
            for d in range(3):
                term[c, d] = power[c, d] * h / n
                out[c, d] += term[c, d]
                size = max(size, abs(term[c, d]))
        if size < 1e-16:
            break


def warm() -> None:
    """Compile the kernels of the answers."""
    axis = np.linspace(-1.0, 1.0, 3)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    flow = flow_of(np.stack([-y, x, 0.1 + 0 * z], axis=-1), axis, axis, axis)
    answers(flow, np.array([[0.5, 0.0, -0.5]]), [np.array([0.0, 0.5, 1.0])])
