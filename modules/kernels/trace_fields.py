"""Velocity fields for `trace.march`, from samples on grids of all kinds.

flow_of        boxes along the axes: linear, nearest or cubic between samples; a series in time
bent_flow      hexahedra of a bent lattice, and `locate` for coordinates in it
tetra_flow     tetrahedra, linear in each
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from modules.kernels import trace_cell as c
from modules.kernels.trace_cell import BENT, BOX, MOVING, SMOOTH, TETRA, Flow

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def flow_of(
    values: Floats,
    x: Floats,
    y: Floats,
    z: Floats | None = None,
    *,
    backwards: bool = False,
    times: Floats | None = None,
    between: str = "linear",
    spline: Callable[[Sequence[Floats], Floats], tuple[Floats, Integers, Floats]] | None = None,
) -> Flow:
    """A field on a regular or rectilinear grid.

    Parameters
    ----------
    values : (nz, ny, nx, 3), or (ny, nx, 3) with z None: a field of the plane, whose third component is not looked at; with
        times one more axis before these
    x, y, z : strictly ascending coordinates of the samples
    backwards : whether to take the opposite field, and the opposite times
    times : (nt,) strictly ascending, of a series
    between : the law between samples; cubic takes Hermite cubics with slopes from the parabola of three samples
    spline : in place of that law: from axes and values (nz, ny, nx, 3) to coefficients, first of the four of each cell, and
        their weights in powers of the place in the cell, as `_cubic` gives the last two for the samples themselves

    Raises
    ------
    ValueError
        Shapes do not fit, there is no cell, or a coordinate is not ascending.
    """
    values, clock = in_time(values, times, backwards)
    if z is None:
        reach = max(float(np.ptp(x)), float(np.ptp(y)))
        z = np.array([-reach, reach])
        flat = values.copy()
        flat[..., 2] = np.where(np.isfinite(flat[..., :2]).all(axis=-1), 0.0, np.nan)
        values = np.stack([flat, flat], axis=1)
    axes = [np.array(axis, np.float64) for axis in (x, y, z)]
    if values.shape[1:] != (axes[2].size, axes[1].size, axes[0].size, 3):
        sizes = " x ".join(str(a.size) for a in reversed(axes))
        raise ValueError(f"values of shape {values.shape[1:]} do not fit {sizes} samples")
    for name, axis in zip("xyz", axes, strict=True):
        if axis.size < 2 or not (np.diff(axis) > 0).all():
            raise ValueError(f"the {name} coordinates must ascend strictly, and there must be two")
    form, basis, whole = (MOVING if len(clock) > 1 else BOX), None, []
    if between == "nearest":
        axes = [np.concatenate([a[:1], 0.5 * (a[1:] + a[:-1]), a[-1:]]) for a in axes]
    if between == "cubic" or spline is not None:
        if len(clock) > 1:
            raise ValueError("a series in time is followed by the linear law between samples, not by a cubic one")
        form = SMOOTH
        if spline is None:
            base, basis = _cubic(axes)
        else:
            values, base, basis = spline(axes, values[0])
            values = values[None]
        whole = [base]
    return _flow(form, values, axes, clock, flat=between == "nearest", basis=basis, whole=whole)


def in_time(values: Floats, times: Floats | None, backwards: bool) -> tuple[Floats, Floats]:
    """Values with an axis of time first, and the times; both turned round for a march backwards.

    Raises
    ------
    ValueError
        Times do not ascend, or there are not as many as values.
    """
    values = np.asarray(values, np.float64)
    if times is None:
        values, clock = values[None], np.zeros(1)
    else:
        clock = np.asarray(times, np.float64)
        if clock.ndim != 1 or len(clock) < 2 or not (np.diff(clock) > 0).all() or len(values) != len(clock):
            raise ValueError("the times of a series must ascend strictly, two at least, and there must be values for each")
    if backwards:
        values, clock = -values[::-1], -clock[::-1]
    return np.array(values, np.float64, order="C"), np.ascontiguousarray(clock)


def _flow(
    form: int,
    values: Floats,
    axes: Sequence[Floats],
    clock: Floats,
    *,
    flat: bool = False,
    nodes: Floats | None = None,
    basis: Floats | None = None,
    whole: Sequence[Integers] = (),
) -> Flow:
    """All arrays of a field in one of numbers and one of whole numbers."""
    nz, ny, nx = values.shape[1:4]
    parts = [values, np.zeros(0) if nodes is None else nodes, *axes, clock, np.zeros(0) if basis is None else basis]
    at = np.cumsum([0, *(p.size for p in parts)])
    index = np.zeros(c.SIZE_OF_INDEX, np.int64)
    index[c.NX : c.NX + 3] = [a.size for a in axes]
    index[c.NT] = len(clock)
    index[c.STRIDE : c.STRIDE + 3] = 3, 3 * nx, 3 * nx * ny
    index[c.AXES : c.AXES + 3], index[c.TIMES], index[c.NODES], index[c.BASES] = at[2:5], at[5], 3 * nx * ny * nz, at[6]
    index[c.LONGEST] = 0 if basis is None else basis.shape[1]
    index[c.TETRAHEDRA] = len(whole[0]) if form == TETRA else 0
    numbers = np.concatenate([np.asarray(p, np.float64).ravel() for p in parts])
    return Flow(form, flat, numbers, np.concatenate([index, *(w.ravel() for w in whole)]).astype(np.int64))


def axes_of(flow: Flow) -> list[Floats]:
    """Ends of the cells along x, y and z, in coordinates of the march."""
    begin, count = flow.whole[c.AXES : c.AXES + 3], flow.whole[c.NX : c.NX + 3]
    return [flow.numbers[a : a + n] for a, n in zip(begin, count, strict=True)]


def measures(flow: Flow) -> tuple[Floats, float, bool, bool]:
    """What rules need to know of a field.

    Returns
    -------
    (4, 3) extent of the domain, the smaller |coordinate| of its ends, its low and its high end in coordinates of the march;
    the root mean square speed in these; whether all samples are numbers; whether cells are boxes
    """
    each = int(flow.whole[c.NODES])
    values = flow.numbers[: each * int(flow.whole[c.NT])].reshape(-1, 3)
    known = np.isfinite(values).all(axis=1)
    speed = float(np.sqrt((values[known] ** 2).sum(axis=1).mean())) if known.any() else 0.0
    boxes = flow.form not in (BENT, TETRA)
    if boxes:
        low, high = (np.array([a[end] for a in axes_of(flow)]) for end in (0, -1))
        least, most = low, high
    else:
        places = flow.numbers[values.size :][:each].reshape(-1, 3)
        least, most = places.min(axis=0), places.max(axis=0)
        low, high = least, most
    if flow.form == BENT:
        low, high = np.zeros(3), flow.whole[c.NX : c.NX + 3] - 1.0
        nx, ny, nz = (int(n) for n in flow.whole[c.NX : c.NX + 3])
        edges = [np.linalg.norm(np.diff(places.reshape(nz, ny, nx, 3), axis=a), axis=-1).mean() for a in range(3)]
        speed /= float(np.mean(edges))
    return np.stack([most - least, np.minimum(np.abs(least), np.abs(most)), low, high]), speed, bool(known.all()), boxes


def cells_across(flow: Flow) -> int:
    """About how many cells lie across the domain: along its axis of the most, of tetrahedra as if they made cubes of six."""
    if flow.form == TETRA:
        return max(1, round(float(np.cbrt(flow.whole[c.TETRAHEDRA] / 6))))
    return int(flow.whole[c.NX : c.NX + 3].max()) - 1


def _cubic(axes: list[Floats]) -> tuple[Integers, Floats]:
    """For each cell along each axis the first of its four samples, and each sample's weight in powers of the coordinate.

    A Hermite cubic between two samples whose slopes are those of the parabola through three, as the law of the house has it.
    """
    longest = max(a.size for a in axes) - 1
    base, basis = np.zeros((3, longest), np.int64), np.zeros((3, longest, 16))
    hermite = np.array([[1.0, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])  # p0, m0, p1, m1 in powers
    for n, x in enumerate(axes):
        wide = min(4, x.size)
        for i in range(x.size - 1):
            first = min(max(i - 1, 0), x.size - wide)
            base[n, i] = first
            weights = np.zeros((4, 4))
            for node, value, rate in ((i, hermite[0], hermite[1]), (i + 1, hermite[2], hermite[3])):
                weights[node - first] += value
                columns, slopes = _slope(x, node)
                for column, s in zip(columns, slopes, strict=True):
                    weights[column - first] += (x[i + 1] - x[i]) * s * rate
            basis[n, i] = weights.ravel()
    return base, basis


def _slope(x: Floats, node: int) -> tuple[list[int], Floats]:
    """The samples whose parabola gives the slope at a sample, and their weights in it."""
    if x.size == 2:
        return [0, 1], np.array([-1.0, 1.0]) / (x[1] - x[0])
    middle = min(max(node, 1), x.size - 2)
    columns = [middle - 1, middle, middle + 1]
    a, b, c = x[columns]
    t = x[node]
    first, second = (2 * t - b - c) / ((a - b) * (a - c)), (2 * t - a - c) / ((b - a) * (b - c))
    return columns, np.array([first, second, -first - second])


def bent_flow(values: Floats, nodes: Floats, *, backwards: bool = False, times: Floats | None = None) -> Flow:
    """A field on a bent lattice, whose march is in coordinates of the lattice.

    Parameters
    ----------
    values : (nz, ny, nx, 3) velocity in physical space, with times one more axis before; or (ny, nx, 3)
    nodes : (nz, ny, nx, 3) or (ny, nx, 3) positions

    Raises
    ------
    ValueError
        Shapes do not fit, or there is no cell.
    """
    values, clock = in_time(values, times, backwards)
    places = np.array(nodes, np.float64, order="C")
    if values.shape[1:] != places.shape or min(places.shape[:-1], default=0) < 2:
        raise ValueError(f"values of shape {values.shape[1:]} do not fit a lattice of shape {places.shape}")
    if places.ndim == 3:
        reach = float(np.ptp(places.reshape(-1, 3), axis=0).max())
        lift = np.array([0.0, 0.0, reach])
        places = np.stack([places - lift, places + lift])
        flat = values.copy()
        flat[..., 2] = np.where(np.isfinite(flat[..., :2]).all(axis=-1), 0.0, np.nan)
        values = np.stack([flat, flat], axis=1)
    nz, ny, nx = places.shape[:3]
    return _flow(BENT, values, [np.arange(n, dtype=float) for n in (nx, ny, nz)], clock, nodes=places)


def tetra_flow(
    values: Floats, nodes: Floats, tetrahedra: Integers, *, backwards: bool = False, times: Floats | None = None
) -> Flow:
    """A field that is linear in tetrahedra.

    Parameters
    ----------
    values : (n, 3), with times one more axis before
    nodes : (n, 3)
    tetrahedra : (t, 4) nodes, none of them flat

    Raises
    ------
    ValueError
        Shapes do not fit, or there is no tetrahedron.
    """
    values, clock = in_time(values, times, backwards)
    places = np.array(nodes, np.float64, order="C")
    cells = np.ascontiguousarray(tetrahedra, np.int64)
    if values.shape[1:] != places.shape or not len(cells):
        raise ValueError("a field in tetrahedra needs a tetrahedron, and a velocity for each node")
    none = [np.zeros(0)] * 3
    return _flow(TETRA, values[:, None, None], none, clock, nodes=places, whole=[cells, _beyond(cells)])


def _beyond(cells: Integers) -> Integers:
    """(t, 4) the tetrahedron beyond the face opposite to each node; -1 at the border."""
    faces = np.sort(np.stack([np.delete(cells, f, axis=1) for f in range(4)], axis=1).reshape(-1, 3), axis=1)
    order = np.lexsort(faces.T[::-1])
    same = (faces[order[1:]] == faces[order[:-1]]).all(axis=1)
    beyond = np.full(len(faces), -1, np.int64)
    beyond[order[:-1][same]] = order[1:][same] // 4
    beyond[order[1:][same]] = order[:-1][same] // 4
    return beyond.reshape(-1, 4)
