"""Contour lines against exact rational arithmetic, on random, integer, tied, constant and holed grids."""

import math
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from modules.kernels import arcs, bilinear, contour, crossings

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]
Edge = tuple[str, int, int]

JUST_BELOW = Fraction(1, 10**40)  # the tie rule: the lines of a level are the limit of those just below it


# --- the oracle: which corners of a cell belong together, by (3.4) in rational numbers, with a division


def parts(mask: Flags, joined: list[tuple[int, int]]) -> int:
    """The number of connected parts of the marked nodes, through grid edges and the given pairs of nodes."""
    index = np.arange(mask.size).reshape(mask.shape)
    pairs = [
        np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], 1),
        np.stack([index[:-1].ravel(), index[1:].ravel()], 1),
        np.array(joined, int).reshape(-1, 2),
    ]
    flat = mask.ravel()
    both = np.concatenate(pairs)
    both = both[flat[both].all(1)]
    graph = coo_array((np.ones(len(both)), both.T), shape=(mask.size, mask.size))
    labels = connected_components(graph, directed=False)[1]
    return len(np.unique(labels[flat]))


def truth(values: Floats, at: float) -> tuple[int, int, dict[int, bool], Flags]:
    """Parts above and below the level, and for each ambiguous cell whether the saddle is above."""
    level = Fraction(at) - JUST_BELOW
    high = np.array([[Fraction(v) > level for v in row] for row in values.tolist()])
    nx, joined, saddles = values.shape[1], [], {}
    for j in range(values.shape[0] - 1):
        for i in range(nx - 1):
            h = high[j, i], high[j, i + 1], high[j + 1, i], high[j + 1, i + 1]
            if h[0] == h[3] != h[1] == h[2]:
                f00, f10, f01, f11 = (Fraction(float(v)) for v in values[j : j + 2, i : i + 2].ravel())
                above = (f00 * f11 - f10 * f01) / (f00 + f11 - f10 - f01) > level
                saddles[j * (nx - 1) + i] = above
                n = j * nx + i
                joined.append((n, n + nx + 1) if h[0] == above else (n + 1, n + nx))
    return parts(high, joined), parts(~high, joined), saddles, high


def single_nodes_on_level(values: Floats, level: float) -> int:
    """Nodes on the level, alone among lower ones: the line around each shrinks to a point and is dropped."""
    framed = np.pad(values, 1, constant_values=-np.inf)
    ring = [framed[1:-1, :-2], framed[1:-1, 2:], framed[:-2, 1:-1], framed[2:, 1:-1]]
    return int(((values == level) & np.all([r < level for r in ring], axis=0)).sum())


def each_line(result: contour.ContourLines) -> list[Floats]:
    return [result.points[a:b] for a, b in zip(result.offsets[:-1], result.offsets[1:], strict=True)]


def segments(result: contour.ContourLines) -> tuple[Floats, Floats]:
    """The two ends of each segment."""
    n, last = len(result.points), np.zeros(len(result.points), bool)
    last[result.offsets[1:] - 1] = True
    start = np.flatnonzero(~last) if n else np.zeros(0, int)
    return result.points[start], result.points[start + 1]


def border_edges(values: Floats) -> set[Edge]:
    """Grid edges of exactly one cell whose corners are all finite, as (axis, fixed index, running index)."""
    ok = np.isfinite(values)
    cell = ok[1:, 1:] & ok[:-1, 1:] & ok[1:, :-1] & ok[:-1, :-1]
    across_y = np.pad(cell, ((1, 1), (0, 0)))
    across_x = np.pad(cell, ((0, 0), (1, 1)))
    return {("y", *k) for k in np.argwhere(across_y[1:] ^ across_y[:-1])} | {
        ("x", *k) for k in np.argwhere(across_x[:, 1:] ^ across_x[:, :-1])
    }


def judge(values: Floats, level: float, x: Floats | None = None, y: Floats | None = None) -> contour.ContourLines:
    """All that must hold of the lines of any grid; returns those with shoulder points."""
    ny, nx = values.shape
    x = np.arange(nx, dtype=float) if x is None else x
    y = np.arange(ny, dtype=float) if y is None else y
    results = [contour.lines(values, x, y, level, shoulder) for shoulder in (False, True)]
    border = border_edges(values)
    for result in results:
        n, k = len(result.points), len(result.offsets) - 1
        assert len(result.bend) == len(result.cell) == n - k
        assert result.offsets[0] == 0 and result.offsets[-1] == n
        p, q = segments(result)
        assert (p != q).any(1).all(), "a point is repeated"
        j, i = np.divmod(result.cell, nx - 1)
        for end in (p, q):  # every point within its cell
            assert ((x[i] <= end[:, 0]) & (end[:, 0] <= x[i + 1]) & (y[j] <= end[:, 1]) & (end[:, 1] <= y[j + 1])).all()
        assert (result.bend[(p == q).any(1)] == 0).all(), "an arc along an axis is straight"
        on_level(values, level, x, y, result.cell, p)
        on_level(values, level, x, y, result.cell, q)
        high_on_the_left(values, x, y, result, p, q)
        for line in each_line(result):
            assert len(line) > 1
            if not (line[0] == line[-1]).all():
                assert at_border(line[0], x, y, border) and at_border(line[-1], x, y, border), "a dangling end"
    assert len(results[0].offsets) == len(results[1].offsets)
    if np.isfinite(values).all():
        above, below, saddles, _ = truth(values, level)
        assert sorted(saddles) == results[1].saddle_cell.tolist()
        expected = max(above + below - 1, 0) - single_nodes_on_level(values, level)
        assert len(results[1].offsets) - 1 == expected, "pieces of the contour"
    return results[1]


def on_level(values: Floats, level: float, x: Floats, y: Floats, cell: Integers, points: Floats) -> None:
    j, i = np.divmod(cell, len(x) - 1)
    f = values[j, i], values[j, i + 1], values[j + 1, i], values[j + 1, i + 1]
    u, v = (points[:, 0] - x[i]) / (x[i + 1] - x[i]), (points[:, 1] - y[j]) / (y[j + 1] - y[j])
    rough = np.max(np.abs(f), axis=0) if len(cell) else np.zeros(0)
    slope = np.max([np.abs(f[1] - f[0]), np.abs(f[3] - f[2]), np.abs(f[2] - f[0]), np.abs(f[3] - f[1])], axis=0)
    blur = 1 + np.abs(points[:, 0]) / (x[i + 1] - x[i]) + np.abs(points[:, 1]) / (y[j + 1] - y[j])
    assert (np.abs(bilinear.value(*f, u, v) - level) <= 2e-15 * (rough + abs(level) + slope * blur)).all()


def high_on_the_left(values: Floats, x: Floats, y: Floats, result: contour.ContourLines, p: Floats, q: Floats) -> None:
    """The gradient in the middle of the exact arc points to the left of the chord."""
    j, i = np.divmod(result.cell, len(x) - 1)
    f = values[j, i], values[j, i + 1], values[j + 1, i], values[j + 1, i + 1]
    w, h = x[i + 1] - x[i], y[j + 1] - y[j]
    middle = arcs.point(p, q, result.bend, 0.5)
    gx, gy = bilinear.gradient(*f, (middle[:, 0] - x[i]) / w, (middle[:, 1] - y[j]) / h)
    d = q - p
    left = d[:, 0] * gy / h - d[:, 1] * gx / w
    size = np.hypot(d[:, 0], d[:, 1]) * np.hypot(gx / w, gy / h)
    clear = size > 1e-7 * np.max(np.abs(f), axis=0, initial=1.0)
    assert (left[clear] > 0).all()


def at_border(point: Floats, x: Floats, y: Floats, border: set[Edge]) -> bool:
    """Whether a point lies on an edge of the border."""
    found: list[Edge] = []
    for j in np.flatnonzero(y == point[1]).tolist():
        i = int(np.searchsorted(x, point[0], "right")) - 1
        found += [("y", j, i), ("y", j, i - 1)] if x[i] == point[0] else [("y", j, i)]
    for i in np.flatnonzero(x == point[0]).tolist():
        j = int(np.searchsorted(y, point[1], "right")) - 1
        found += [("x", j, i), ("x", j - 1, i)] if y[j] == point[1] else [("x", j, i)]
    return any(edge in border for edge in found)


# --- the grids

shapes = st.tuples(st.integers(2, 9), st.integers(2, 21))


@settings(derandomize=True, max_examples=150, deadline=None)
@given(shapes, st.integers(0, 2**32 - 1))
def test_random_grids(shape: tuple[int, int], seed: int) -> None:
    random = np.random.default_rng(seed)
    x, y = (np.cumsum(random.uniform(0.1, 2.0, n)) - 3 for n in shape[::-1])
    judge(random.standard_normal(shape), 0.1, x, y)


@settings(derandomize=True, max_examples=300, deadline=None)
@given(shapes, st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3, 10]), st.sampled_from([1.0, 0.1, 1e8]))
def test_integer_grids_with_nodes_and_saddles_on_the_level(shape: tuple[int, int], seed: int, most: int, unit: float) -> None:
    values = unit * np.random.default_rng(seed).integers(-most, most + 1, shape).astype(np.float64)
    random = np.random.default_rng(seed + 1)
    x, y = (np.cumsum(random.uniform(0.1, 2.0, n)) - 3 for n in shape[::-1])  # where x0 + (x1 - x0) is not x1
    judge(values, 0.0, x, y)
    judge(values + 3 * unit, 3 * unit)


@settings(derandomize=True, max_examples=150, deadline=None)
@given(shapes, st.integers(0, 2**32 - 1), st.sampled_from([np.nan, np.inf, -np.inf]), st.booleans())
def test_grids_with_holes(shape: tuple[int, int], seed: int, hole: float, tied: bool) -> None:
    random = np.random.default_rng(seed)
    values = random.integers(-1, 2, shape).astype(np.float64) if tied else random.standard_normal(shape)
    values[random.random(shape) < 0.15] = hole
    judge(values, 0.0)


@pytest.mark.parametrize("shape", [(40, 150), (150, 41), (3, 600)])
@pytest.mark.parametrize("level", [-0.7, 0.05, 0.6])
def test_smooth_grids_wider_than_what_is_skipped_at_a_time(shape: tuple[int, int], level: float) -> None:
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]] / 30.0
    result = judge(np.sin(2 * x + 0.3) * np.cos(1.7 * y) + 0.3 * np.sin(x * y), level)
    assert len(result.points) > 50


def test_a_hole_is_a_border() -> None:
    values = np.tile(np.arange(30.0), (20, 1))
    values[5:9, 10:14] = np.nan
    result = judge(values, 12.5)
    assert len(result.offsets) - 1 == 2
    free = contour.lines(np.where(np.isnan(values), 0, values), np.arange(30.0), np.arange(20.0), 40.0)
    assert free.points.shape == (0, 2) and free.offsets.tolist() == [0] and free.bend.size == free.cell.size == 0


@pytest.mark.parametrize("value", [1.0, 2.0, 3.0, np.nan])
def test_constant_grids_have_no_contour(value: float) -> None:
    assert len(judge(np.full((5, 12), value), 2.0).points) == 0


def test_a_plateau_on_the_level_counts_as_above() -> None:
    values = np.zeros((5, 6))
    values[1:4, 1:5] = 1.0
    assert len(judge(values, 1.0).offsets) == 2  # the plateau's outline, through its outer nodes
    assert set(map(tuple, judge(values, 1.0).points)) <= set(map(tuple, np.argwhere(values.T == 1.0)))
    assert len(judge(-values, -1.0).offsets) == 1  # all of it is above


def test_a_node_on_the_level_alone_is_dropped_and_two_stay_closed() -> None:
    values = np.zeros((4, 5))
    values[1, 1] = 1.0
    assert len(judge(values, 1.0).points) == 0
    values[1, 2] = 1.0
    assert judge(values, 1.0).points.tolist() == [[1.0, 1.0], [2.0, 1.0], [1.0, 1.0]]


def test_a_saddle_on_the_level_joins_the_high_corners_and_turns_at_the_saddle() -> None:
    values = np.array([[1.0, -2.0], [-3.0, 6.0]])  # det = 0, S = (1/3, 1/4)
    result = judge(values, 0.0)
    assert result.saddle_margin.tolist() == [0.0]
    for line in each_line(result):
        assert line[1] == pytest.approx([1 / 3, 1 / 4], abs=1e-16)
        assert (line[0] == line[1]).sum() == (line[1] == line[2]).sum() == 1  # along the asymptotes, exactly
    assert (result.bend == 0).all()
    chords = contour.lines(values, np.arange(2.0), np.arange(2.0), 0.0, shoulder=False)
    p, q = segments(chords)
    assert np.abs(chords.bend).tolist() == [arcs.TURN] * 2
    corner = arcs.point(p, q, chords.bend, 0.5)
    assert corner == pytest.approx(np.array([[1 / 3, 1 / 4]] * 2), abs=1e-16)


def test_straight_arcs_get_no_extra_point() -> None:
    y, x = np.mgrid[0:6, 0:9] * 1.0
    plane = 2 * x + 3 * y
    result = judge(plane, 7.5)
    assert (result.bend == 0).all()
    chords = contour.lines(plane, np.arange(9.0), np.arange(6.0), 7.5, shoulder=False)
    assert (chords.points == result.points).all()
    barely = judge(np.array([[0.0, 1.0], [2.0, np.nextafter(3.0, 4.0)]]), 1.2)  # c is one unit in the last place
    assert barely.bend.tolist() == [0.0]
    twisted = judge(x * y, 0.0)  # both asymptotes, along grid lines
    assert (twisted.bend == 0).all()
    along = judge(np.array([[0.0, 0.0], [-1.0, -3.0]]), 0.0)  # F = -y (1 + 2 x): the contour is the lower edge
    assert along.points.tolist() == [[1.0, 0.0], [0.0, 0.0]] and along.bend.tolist() == [0.0]


def test_a_crossing_lies_on_its_edge_and_at_a_node_on_the_level_exactly() -> None:
    random, rounded = np.random.default_rng(2), 0
    for _ in range(2000):
        p0, p1 = np.sort(random.uniform(-3, 3, 2) * 10.0 ** random.integers(-8, 8, 2)).tolist()
        f0, f1 = random.standard_normal(2).tolist()
        assert crossings.between(f0, f1, f0, p0, p1) == p0 and crossings.between(f0, f1, f1, p0, p1) == p1
        level = f0 + (f1 - f0) * random.random()
        assert p0 <= crossings.between(f0, f1, level, p0, p1) <= p1
        assert crossings.between(f0, f1, level, p0, p1) == pytest.approx(
            float(p0 + (Fraction(level) - Fraction(f0)) / (Fraction(f1) - Fraction(f0)) * (Fraction(p1) - Fraction(p0))),
            rel=0,
            abs=1e-15 * max(abs(p0), abs(p1)),
        )
        rounded += p0 + (p1 - p0) != p1
    assert rounded > 100  # the plain form would miss


def test_near_degenerate_saddles_are_decided_exactly() -> None:
    random = np.random.default_rng(8)
    wrong_in_floats = 0
    for _ in range(4000):
        f = random.integers(1, 2**20, 4) * 1.0
        f[1] *= -1
        f[2] = -f[0] * f[3] / -f[1]
        f = np.nextafter(f, random.choice([-1, 1], 4) * np.inf) + 5e5
        exact = (Fraction(f[0]) - 500000) * (Fraction(f[3]) - 500000) - (Fraction(f[1]) - 500000) * (Fraction(f[2]) - 500000)
        f00, f10, f01, f11 = f.tolist()
        det = bilinear.determinant(f00, f10, f01, f11, 500000.0)
        assert np.sign(det) == np.sign(float(exact)) and det == pytest.approx(float(exact), rel=5e-13, abs=0)
        g = f - 500000.0
        wrong_in_floats += np.sign(g[0] * g[3] - g[1] * g[2]) != np.sign(float(exact))
    assert wrong_in_floats > 10  # the trial was hard enough
    for scale in (1e-150, 1e150, 1e300):
        assert bilinear.determinant(3.0 * scale, -scale, -3.0 * scale, (1.0 + 2**-52) * scale, 0.0) > 0


def test_bends_against_rational_arithmetic() -> None:
    random = np.random.default_rng(9)
    for _ in range(300):
        values = random.standard_normal((2, 2)) * [[1, 1], [1, 10.0 ** random.integers(-6, 2)]]
        level = float(random.normal(0, 0.3))
        result = contour.lines(values, np.arange(2.0), np.arange(2.0), level, shoulder=False)
        f00, f10, f01, f11 = (Fraction(v) for v in values.ravel().tolist())
        b, c = f01 - f00, f00 + f11 - f10 - f01
        p, q = segments(result)
        for start, end, bend in zip(p, q, result.bend, strict=True):
            ratio = [b + c * x_exact(values.ravel().tolist(), Fraction(level), point.tolist()) for point in (start, end)]
            expected = float(ratio[1] / ratio[0] - 1)
            assert bend == pytest.approx(math.log1p(expected), rel=1e-12, abs=1e-15)


def x_exact(f: list[float], level: Fraction, point: list[float]) -> Fraction:
    """The exact x of a crossing of the unit cell."""
    f00, f10, f01, f11 = map(Fraction, f)
    if point[0] in (0.0, 1.0):
        return Fraction(point[0])
    return (level - f00) / (f10 - f00) if point[1] == 0 else (level - f01) / (f11 - f01)


def test_the_oracle_agrees_with_fine_sampling() -> None:
    t = (np.arange(60) + 0.5) / 60
    done = 0
    for seed in range(12):
        values = np.random.default_rng(seed).integers(-9, 10, (5, 6)).astype(np.float64)
        f = [values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]]
        f00, f10, f01, f11 = (g[:, None, :, None] for g in f)
        fine = bilinear.value(f00, f10, f01, f11, t[None, None, None, :], t[None, :, None, None])
        fine = fine.reshape(4 * 60, 5 * 60)
        above, below, saddles, _ = truth(values, 0.45)
        result = judge(values, 0.45)
        if np.all(result.saddle_margin > 0.05):
            assert ndimage.label(fine > 0.45)[1] == above and ndimage.label(fine < 0.45)[1] == below
            done += len(saddles)
    assert done > 20


# --- the machinery


def noise(n: int = 300) -> Floats:
    return np.random.default_rng(4).standard_normal((n, n))


def test_same_result_in_threads_and_for_read_only_or_strided_input() -> None:
    values, x = noise(), np.arange(300.0)
    levels = np.linspace(-1, 1, 8).tolist()
    one = [contour.lines(values, x, x, level) for level in levels]
    frozen, strided = values.copy(), np.repeat(values, 2, axis=1)[:, ::2]
    frozen.flags.writeable = False
    with ThreadPoolExecutor(4) as pool:
        many = list(pool.map(lambda level: contour.lines(frozen if level < 0 else strided, x, x, level), levels))
    for a, b in zip(one, many, strict=True):
        assert all((left == right).all() for left, right in zip(a, b, strict=True))
    assert len(vars(crossings.sweep)["overloads"]) == 1  # compiled once for all of these


@pytest.mark.parametrize("slab", [1, 700, 1 << 18])
def test_slabs_do_not_show(monkeypatch: pytest.MonkeyPatch, slab: int) -> None:
    values, x = noise(60), np.arange(60.0)
    whole = contour.lines(values, x, x, 0.3)
    monkeypatch.setattr(contour, "CELLS_A_SLAB", slab)
    heard: list[float] = []
    cut = contour.lines(values, x, x, 0.3, check=heard.append)
    assert all((left == right).all() for left, right in zip(whole, cut, strict=True))
    assert heard == sorted(heard) and 0 <= heard[0] and heard[-1] <= 1
    assert len(heard) >= (59 if slab == 1 else 2)


def test_check_can_stop_it() -> None:
    class StoppedError(Exception):
        pass

    def stop(fraction: float) -> None:
        if fraction > 0.5:
            raise StoppedError

    values = np.zeros((1000, 1000))
    with pytest.raises(StoppedError):
        contour.lines(values, np.arange(1000.0), np.arange(1000.0), 0.5, check=stop)


def test_the_results_own_arrays_of_their_size() -> None:
    result = contour.lines(noise(), np.arange(300.0), np.arange(300.0), 0.0)
    assert all(array.base is None and array.flags.c_contiguous for array in result)


def test_what_is_no_grid_is_refused() -> None:
    values, x, y = np.zeros((3, 4)), np.arange(4.0), np.arange(3.0)
    for bad, words in [
        ((values.T, x, y, 0.0), "do not fit"),
        ((values[:1], x, y[:1], 0.0), "no cell"),
        ((values, x[::-1], y, 0.0), "x coordinates must ascend"),
        ((values, x, y * np.nan, 0.0), "y coordinates must ascend"),
        ((values, x, y, np.nan), "finite"),
    ]:
        with pytest.raises(ValueError, match=words):
            contour.lines(*bad)
