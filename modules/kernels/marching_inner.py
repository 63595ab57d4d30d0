"""The bi-shoulder point of a polygon: shoulder point of two slices through the cell at once.

The search goes from slice to slice as the thesis does, but by the secant method; each place it visits is a shoulder
point of a slice and so lies on the surface, wherever it stops.

Source: Lopes 1999, section 4.2.2.2.
"""

import math
from importlib import import_module

from modules.kernels._jit import lean_part
from modules.kernels.marching_cases import ACROSS, FACE_CORNERS, Cell, Floats, shoulder_faces
from modules.kernels.marching_points import crossing, is_inside, put, shoulder

CLOSE = 1e-10
"""Of the cell: when the two slices agree so far, the search ends."""

MOST_STEPS = 60


@lean_part
def slot_of(cell: Cell, face: int, at: Floats) -> int:
    """The slot of the arc of a face that holds a place of the face's contour; -1 if the face has none."""
    if cell.arc[face, 1, 0] < 0:
        return 0 if cell.arc[face, 0, 0] >= 0 else -1
    axis = face // 2
    p, q = ACROSS[axis, 0], ACROSS[axis, 1]
    f0, f1 = cell.value[FACE_CORNERS[face, 0]], cell.value[FACE_CORNERS[face, 1]]
    f2, f3 = cell.value[FACE_CORNERS[face, 2]], cell.value[FACE_CORNERS[face, 3]]
    twist = (f2 - f3) - (f1 - f0)
    saddle_p, saddle_q = (f0 - f3) / twist, (f0 - f1) / twist
    best, nearest = 0, math.inf
    for slot in range(2):
        first, second = cell.at[cell.arc[face, slot, 0]], cell.at[cell.arc[face, slot, 1]]
        mid_p, mid_q = 0.5 * (first[p] + second[p]), 0.5 * (first[q] + second[q])
        if (mid_p - saddle_p) * (at[p] - saddle_p) > 0 and (mid_q - saddle_q) * (at[q] - saddle_q) > 0:
            return slot
        away = max(
            max(min(first[p], second[p]) - at[p], at[p] - max(first[p], second[p])),
            max(min(first[q], second[q]) - at[q], at[q] - max(first[q], second[q])),
        )
        if away < nearest:
            best, nearest = slot, away
    return best


@lean_part
def _belongs(cell: Cell, polygon: int, axis: int, t: float, side: int, end: tuple[float, float]) -> bool:
    """Whether the point on a side of a slice lies on an arc of the polygon."""
    p, q = ACROSS[axis, 0], ACROSS[axis, 1]
    face = 2 * (q if side % 2 == 0 else p) + (1 if side == 1 or side == 2 else 0)
    at = cell.probe[2]
    at[axis], at[p], at[q] = t, end[0], end[1]
    slot = slot_of(cell, face, at)
    return slot >= 0 and cell.arc[face, slot, 2] == polygon


@lean_part
def slice_shoulder(cell: Cell, polygon: int, axis: int, t: float, near: Floats, at: Floats) -> bool:
    """The shoulder point, on the slice axis = t, of the arc of a polygon: the nearest one where there are two.

    Parameters
    ----------
    polygon : its number; -1 if the cell has no other
    near : a place; nan for none
    at : gets the point

    Returns
    -------
    bool
        Whether the slice has an arc of the polygon.
    """
    f, p, q = cell.value, ACROSS[axis, 0], ACROSS[axis, 1]
    step, along, up = 4 >> axis, 4 >> p, 4 >> q
    g0, g1 = (1 - t) * f[0] + t * f[step], (1 - t) * f[along] + t * f[along + step]
    g2, g3 = (1 - t) * f[along + up] + t * f[along + up + step], (1 - t) * f[up] + t * f[up + step]
    above = (g0 >= 0) + 2 * (g1 >= 0) + 4 * (g2 >= 0) + 8 * (g3 >= 0)
    if above == 0 or above == 15:
        return False
    first, second, arcs = 0, 0, 1
    if above == 5 or above == 10:
        arcs = 2
    else:
        cut = above ^ ((above >> 1) | ((above & 1) << 3))  # bit i: the slice's side i is cut
        while not (cut >> first) & 1:
            first += 1
        second = first + 1
        while not (cut >> second) & 1:
            second += 1
    best, found = math.inf, False
    for arc in range(arcs):
        if arcs == 2 and g0 * g2 - g1 * g3 > 0:
            first, second = 2 * arc, 2 * arc + 1
        elif arcs == 2:
            first, second = (3, 0) if arc == 0 else (1, 2)
        start, end = _on_side(g0, g1, g2, g3, first), _on_side(g0, g1, g2, g3, second)
        if polygon >= 0 and not (
            _belongs(cell, polygon, axis, t, first, start) and _belongs(cell, polygon, axis, t, second, end)
        ):
            continue
        u, v = shoulder((g0, g1, g2, g3), start, end)
        away = max(abs(u - near[p]), abs(v - near[q]))
        if not found or away < best:
            best, found = away, True
            at[axis], at[p], at[q] = t, u, v
    return found


@lean_part
def _on_side(g0: float, g1: float, g2: float, g3: float, side: int) -> tuple[float, float]:
    if side == 0:
        return crossing(g0, g1), 0.0
    if side == 1:
        return 1.0, crossing(g1, g2)
    if side == 2:
        return crossing(g3, g2), 1.0
    return 0.0, crossing(g0, g3)


@lean_part
def bi_shoulder(cell: Cell, polygon: int, first: int, second: int, start: float, at: Floats) -> bool:
    """The point that is a shoulder point of the slices across the axes of two faces; whether one was found inside.

    Parameters
    ----------
    polygon : its number; -1 if the cell has no other
    first, second : the two faces
    start : of the search, along the first face's axis

    Accuracy: on the surface to rounding; both slices agree to `CLOSE`.
    """
    a, b = first // 2, second // 2
    here, there = cell.probe[0], cell.probe[1]
    there[0] = there[1] = there[2] = math.nan
    t, t_before, gap_before, found = start, math.nan, math.nan, False
    for _ in range(MOST_STEPS):
        if not slice_shoulder(cell, polygon, a, t, there, here):
            break
        put(at, here)
        found = True
        if not slice_shoulder(cell, polygon, b, here[b], here, there):
            break
        gap = there[a] - t
        if abs(gap) < CLOSE:
            break
        following = 0.5 * (t + there[a])
        if abs(gap) < 0.9 * abs(gap_before):
            secant = t - gap * (t - t_before) / (gap - gap_before)
            if 0.0 < secant < 1.0:
                following = secant
        t_before, gap_before, t = t, gap, following
    return found and is_inside(at)


@lean_part
def inner_point(cell: Cell, polygon: int, size: int, at: Floats) -> None:
    """A point inside the cell for a fan over a polygon: the bi-shoulder point, or else one of some slice.

    A polygon that shrinks to a corner has neither: then it is the mean of its vertices, which are all at the corner.
    """
    first, second = shoulder_faces(cell, polygon)
    slot = 0 if cell.arc[second, 0, 2] == polygon else 1
    start = cell.at[12 + 2 * second + slot, first // 2]
    if bi_shoulder(cell, polygon, first, second, start, at):
        return
    low, high, mean = cell.box[0], cell.box[1], cell.box[2]
    for axis in range(3):
        low[axis], high[axis], mean[axis] = 1.0, 0.0, 0.0
    begin = cell.start[polygon]
    for i in range(begin, begin + size):
        for axis in range(3):
            place = cell.at[cell.loop[i], axis]
            low[axis], high[axis] = min(low[axis], place), max(high[axis], place)
            mean[axis] += place / size
    for part in (0.5, 0.25, 0.75):
        for axis in range(3):
            t = low[axis] + part * (high[axis] - low[axis])
            if slice_shoulder(cell, polygon, axis, t, mean, at) and is_inside(at):
                return
    put(at, mean)


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
