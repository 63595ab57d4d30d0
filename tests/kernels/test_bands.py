"""Filled bands: areas against integration by columns, tiling edge by edge, topology against the field itself."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest

from modules.kernels import arcs, bands, bilinear, contour

Floats = npt.NDArray[np.float64]
CELL = np.array([[15.0, 21.0], [24.0, 10.0]])
UNIT = np.array([0.0, 1.0])


def nodes(n: int) -> Floats:
    return np.arange(n, dtype=np.float64)


def rings(b: bands.Bands) -> list[Floats]:
    return [b.points[b.connectivity[p:q]] for p, q in itertools.pairwise(b.offsets)]


def shoelace(p: Floats) -> float:
    q, o = np.roll(p, -1, axis=0), p[0]
    return float(0.5 * np.sum((p - o)[:, 0] * (q - o)[:, 1] - (q - o)[:, 0] * (p - o)[:, 1]))


def by_columns(cell: Floats, low: float, high: float, n: int = 20_000) -> float:
    """The area of a band in the unit cell: along a column F is linear, so the part in the band is known; midpoint rule."""
    u = (np.arange(n) + 0.5) / n
    bottom, top = cell[0, 0] + u * (cell[0, 1] - cell[0, 0]), cell[1, 0] + u * (cell[1, 1] - cell[1, 0])
    least, most = np.minimum(bottom, top), np.maximum(bottom, top)
    inside = np.clip(np.minimum(most, high) - np.maximum(least, low), 0, None)
    return float(np.mean(inside / np.maximum(most - least, 1e-300)))


def edges(b: bands.Bands) -> npt.NDArray[np.int64]:
    """(n, 2) directed sides of all polygons."""
    sides = []
    for p, q in itertools.pairwise(b.offsets):
        ring = b.connectivity[p:q]
        sides.append(np.column_stack([ring, np.roll(ring, -1)]))
    return np.concatenate(sides)


def assert_tiles(b: bands.Bands, outer: float) -> None:
    """Each side inside the domain is walked once each way; what is left over is its border, walked once.

    Where a contour follows a grid edge the neighbour may walk it in pieces: grid lines are compared by length.
    """
    sides = edges(b)
    n = len(b.points)
    there, back = sides[:, 0] * n + sides[:, 1], sides[:, 1] * n + sides[:, 0]
    assert len(np.unique(there)) == len(there)
    alone = b.points[sides[~np.isin(there, back)]]  # (sides, 2 ends, x and y)
    total = 0.0
    for axis in (0, 1):
        along = alone[(alone[:, 0, axis] == alone[:, 1, axis])]
        for line in np.unique(along[:, 0, axis]):
            ends = along[along[:, 0, axis] == line][:, :, 1 - axis]
            marks = np.unique(ends)
            middle = (marks[1:] + marks[:-1]) / 2
            up = ((ends[:, 0, None] < middle) & (middle < ends[:, 1, None])).sum(axis=0)
            down = ((ends[:, 1, None] < middle) & (middle < ends[:, 0, None])).sum(axis=0)
            assert (np.maximum(up, down) <= 1).all()
            total += float((np.diff(marks) * np.abs(up - down)).sum())
    assert (alone[:, 0] == alone[:, 1]).any(axis=1).all()
    assert total == pytest.approx(outer, rel=1e-12)


def fields() -> dict[str, Floats]:
    random = np.random.default_rng(3)
    holes = random.normal(size=(12, 15))
    holes[3:5, 6], holes[0, 0] = np.nan, np.inf
    y, x = np.mgrid[0:20, 0:25] / 20
    return {
        "noise": random.normal(size=(12, 15)),
        "holes": holes,
        "whole numbers": random.integers(-2, 3, size=(14, 14)).astype(float),  # nodes, edges and saddles on levels
        "hills": np.sin(6 * x + 0.1) * np.cos(5 * y),
        "plane": x + 2 * y,
        "flat": np.zeros((4, 5)),
    }


FIELDS = fields()
LEVELS = (-np.inf, -1.0, -0.5, 0.0, 1.0, np.inf)


@pytest.mark.parametrize("seed", range(60))
def test_the_area_of_a_cell_is_that_of_an_integration(seed: int) -> None:
    random = np.random.default_rng(seed)
    cell = random.normal(size=(2, 2)) if seed % 3 else random.integers(0, 4, size=(2, 2)).astype(float)
    low = float(random.choice(cell.ravel())) if seed % 4 == 0 else float(random.normal())
    high = low + float(random.exponential())
    b = bands.fill(cell, UNIT, UNIT, [low, high], 1e-4)
    flat = len(np.unique(cell)) < 4  # the integral of a column on a level counts or not; here it counts never
    if not flat:
        assert b.area.sum() == pytest.approx(by_columns(cell, low, high), abs=3e-7)
    polygons = np.array([shoelace(p) for p in rings(b)])
    assert (np.abs(polygons - b.area) <= b.left + 1e-14).all()
    assert (b.left <= 4 * 1e-4).all()


@pytest.mark.parametrize("tolerance", [1.0, 1e-2, 1e-3, 1e-5])
def test_what_is_left_is_within_the_tolerance_of_each_arc(tolerance: float) -> None:
    b = bands.fill(CELL, UNIT, UNIT, [-np.inf, 17.6, np.inf], tolerance)
    exact = by_columns(CELL, 17.6, np.inf)
    assert b.area[b.band == 1].sum() == pytest.approx(exact, abs=1e-7)
    assert b.left[b.band == 1].sum() <= 2 * tolerance
    if tolerance == 1.0:  # one chord a branch: the areas of thesis figure 3.9
        assert b.left[b.band == 1].sum() == pytest.approx(0.050928223 + 0.170748505, rel=1e-8)
    else:
        assert b.left[b.band == 1].sum() > tolerance / 16


@pytest.mark.parametrize("name", FIELDS)
def test_bands_tile_the_domain_exactly(name: str) -> None:
    values = FIELDS[name]
    ny, nx = values.shape
    x = np.cumsum(np.random.default_rng(1).uniform(0.5, 2, nx))
    y: Floats = 0.7 * nodes(ny)
    b = bands.fill(values, x, y, LEVELS, 1e-3)
    finite = np.isfinite(values)
    solid = finite[:-1, :-1] & finite[1:, :-1] & finite[:-1, 1:] & finite[1:, 1:]
    sizes = np.outer(np.diff(y), np.diff(x))
    border = sum(
        float((np.diff(np.pad(solid, 1).astype(int), axis=a) != 0)[s].sum(axis=a) @ w)
        for a, s, w in ((0, np.s_[:, 1:-1], np.diff(x)), (1, np.s_[1:-1], np.diff(y)))
    )
    assert_tiles(b, border)
    assert b.area.sum() == pytest.approx(sizes[solid].sum(), rel=1e-13)
    polygons = np.array([shoelace(p) for p in rings(b)])
    assert polygons.sum() == pytest.approx(sizes[solid].sum(), rel=1e-13)
    assert (polygons > 0).all()
    assert solid.ravel()[b.cell].all()


@pytest.mark.parametrize("name", ["noise", "holes", "whole numbers", "hills"])
def test_the_field_inside_a_polygon_is_in_its_band(name: str) -> None:
    """At the middle of a triangle fan's pieces, but for what lies nearer to a border than its chords may."""
    values = FIELDS[name]
    b = bands.fill(values, nodes(values.shape[1]), nodes(values.shape[0]), LEVELS, 1e-6)
    row, column = np.divmod(b.cell, values.shape[1] - 1)
    random = np.random.default_rng(0)
    for i, ring in enumerate(rings(b)):
        f = values[row[i] : row[i] + 2, column[i] : column[i] + 2]
        at = random.uniform(size=(200, 2))
        value = bilinear.value(f[0, 0], f[0, 1], f[1, 0], f[1, 1], at[:, 0], at[:, 1])
        low, high = LEVELS[b.band[i]], LEVELS[b.band[i] + 1]
        clear = np.minimum(np.abs(value - low), np.abs(value - high)) > 1e-2
        inside = contains(ring, at + np.array([column[i], row[i]]))
        assert ((value >= low) & (value < high))[clear & inside].all()


def contains(ring: Floats, at: Floats) -> npt.NDArray[np.bool_]:
    """Even-odd."""
    p, q = ring, np.roll(ring, -1, axis=0)
    crosses = (p[:, 1] > at[:, 1, None]) != (q[:, 1] > at[:, 1, None])
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        x = p[:, 0] + (at[:, 1, None] - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0])
    inside: npt.NDArray[np.bool_] = (crosses & (at[:, 0, None] < x)).sum(axis=1) % 2 == 1
    return inside


def test_pieces_are_joined_as_the_saddle_decides() -> None:
    """The saddle of the cell is 17.7: below it two pieces above the level, from there on one between the branches."""
    def pieces(low: float, high: float) -> int:
        return len(bands.fill(CELL, UNIT, UNIT, [low, high], 1e-3).band)

    assert pieces(17.6, np.inf) == 1  # 10 and 01 are high and joined
    assert pieces(17.8, np.inf) == 2
    assert pieces(-np.inf, 17.6) == 2
    assert pieces(-np.inf, 17.8) == 1
    assert pieces(17.6, 17.8) == 1  # the saddle with four arcs around it
    assert pieces(17.0, 17.6) == pieces(17.8, 18.0) == 2
    assert len(bands.fill(CELL, UNIT, UNIT, [17.6, 17.8], 1.0).connectivity) == 8


def test_a_saddle_on_the_level_counts_as_above() -> None:
    cell = np.array([[0.0, 2.0], [2.0, 0.0]])  # F(S) = 1 at the middle, its contours the lines through it
    b = bands.fill(cell, UNIT, UNIT, [-np.inf, 1.0, np.inf], 1e-3)
    assert sorted(b.band.tolist()) == [0, 0, 1]
    assert np.allclose(np.sort(b.area), [0.25, 0.25, 0.5])
    assert np.allclose([shoelace(p) for p in rings(b)], b.area)
    assert [0.5, 0.5] in b.points.tolist()


def test_nodes_on_the_level_count_as_above() -> None:
    values = np.array([[0.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
    x, y = np.arange(3.0), UNIT
    low, high = (bands.fill(values, x, y, ends, 1e-9) for ends in ([0.5, 1.0], [1.0, 2.0]))
    assert low.cell.tolist() == [0]  # all of it below but the corner
    assert high.cell.tolist() == [1]
    assert high.area.sum() == 1.0
    assert bands.fill(np.ones((3, 3)), x, x, [0.0, 1.0], 1.0).area.size == 0
    assert bands.fill(np.ones((3, 3)), x, x, [1.0, 2.0], 1.0).area.sum() == 4.0


@pytest.mark.parametrize("name", ["noise", "hills", "holes", "whole numbers"])
def test_borders_are_the_contour_lines(name: str) -> None:
    values = FIELDS[name]
    x, y = nodes(values.shape[1]), nodes(values.shape[0])
    b = bands.fill(values, x, y, LEVELS, 1e-7)
    for index, level in ((2, -0.5), (3, 0.0)):
        lines = contour.lines(values, x, y, level)
        mine = {tuple(p) for p in b.points[b.on == index].tolist()}
        ends = contour.lines(values, x, y, level, shoulder=False).points
        assert {tuple(p) for p in ends.tolist()} <= mine
        if name == "whole numbers":  # lines along grid edges
            continue
        start, end = b.points[(e := edges(b))[:, 0]], b.points[e[:, 1]]
        inner = ((start != end) | (start != np.round(start))).all(axis=1)
        border = inner & (b.on[e] == index).all(axis=1)
        step = np.diff(lines.points, axis=0)[np.isin(np.arange(len(lines.points) - 1), lines.offsets[1:-1] - 1, invert=True)]
        exact = arcs.length(step[:, 0], step[:, 1], lines.bend).sum()
        assert np.linalg.norm(end - start, axis=1)[border].sum() / 2 == pytest.approx(exact, rel=1e-5)


def test_runs_of_whole_cells_may_be_one_rectangle() -> None:
    values = FIELDS["holes"]
    x, y = nodes(15), nodes(12)
    single, merged = (bands.fill(values, x, y, [-np.inf, 0.5, np.inf], 1e-3, merged=m) for m in (False, True))
    assert len(merged.band) < len(single.band)
    for i in (0, 1):
        assert merged.area[merged.band == i].sum() == pytest.approx(single.area[single.band == i].sum(), rel=1e-13)
        assert sum(shoelace(p) for p in rings(merged)) == pytest.approx(single.area.sum(), rel=1e-13)


def test_blocks_are_grids_of_their_own() -> None:
    blocks = np.stack([CELL, CELL.T, CELL[::-1]])
    x = np.array([[0.0, 1.0], [5.0, 7.0], [0.0, 1.0]])
    together = bands.fill(blocks, x, x, [17.0, 18.0], 1e-3)
    apart = [bands.fill(f, a, a, [17.0, 18.0], 1e-3) for f, a in zip(blocks, x, strict=True)]
    assert np.array_equal(together.area, np.concatenate([b.area for b in apart]))
    assert together.cell.tolist() == [i for i, b in enumerate(apart) for _ in b.cell]
    assert len(together.points) == sum(len(b.points) for b in apart)


@pytest.mark.parametrize("seed", range(12))
def test_between_two_fields_lies_what_is_above_one_and_below_the_other(seed: int) -> None:
    """Counted at fine places of each cell, and the two borders by themselves."""
    random = np.random.default_rng(seed)
    lower = random.normal(size=(6, 7)) if seed % 3 else random.integers(-2, 3, size=(6, 7)).astype(float)
    upper = lower - random.exponential(0.4, size=(6, 7)) * (random.random((6, 7)) > 0.2)
    x, y = nodes(7), nodes(6)
    b = bands.between(lower, upper, x, y, 1e-4)
    n = 200
    at = np.stack(np.meshgrid(*[(np.arange(n) + 0.5) / n] * 2), axis=-1).reshape(-1, 2)
    for row in range(5):
        for column in range(6):
            f = []
            for g in (lower, upper):
                (f00, f10), (f01, f11) = g[row : row + 2, column : column + 2]
                f.append(bilinear.value(f00, f10, f01, f11, at[:, 0], at[:, 1]))
            counted = float(np.mean((f[0] >= 0) & (f[1] < 0)))
            assert b.area[b.cell == row * 6 + column].sum() == pytest.approx(counted, abs=6e-3)
    whole = [bands.fill(g, x, y, [0.0, np.inf], 1e-4).area.sum() for g in (lower, upper)]
    assert b.area.sum() == pytest.approx(whole[0] - whole[1], rel=1e-12, abs=1e-12)
    polygons = np.array([shoelace(p) for p in rings(b)])
    assert (np.abs(polygons - b.area) <= b.left + 1e-14).all()
    assert (polygons > -1e-15).all()


def test_between_is_a_band_of_one_field() -> None:
    values = FIELDS["holes"]
    x, y = nodes(15), nodes(12)
    one, two = bands.fill(values, x, y, [-0.5, 0.5], 1e-3), bands.between(values + 0.5, values - 0.5, x, y, 1e-3)
    assert two.area.sum() == pytest.approx(one.area.sum(), rel=1e-12)
    assert np.array_equal(two.cell, one.cell)
    with pytest.raises(ValueError, match="nowhere above"):
        bands.between(values - 0.5, values + 0.5, x, y, 1e-3)
    with pytest.raises(ValueError, match="as large as"):
        bands.between(values, values[1:], x, y, 1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"levels": [1.0]}, "two levels"),
        ({"levels": [1.0, 1.0]}, "ascend strictly"),
        ({"levels": [0.0, np.nan]}, "ascend strictly"),
        ({"tolerance": 0.0}, "must be positive"),
        ({"x": np.arange(3.0)}, "do not fit"),
        ({"x": np.array([1.0, 0.0])}, "ascend"),
        ({"values": np.zeros((1, 2)), "y": np.zeros(1)}, "no cell"),
    ],
)
def test_what_makes_no_sense_is_refused(change: dict[str, object], words: str) -> None:
    given: dict[str, object] = {"values": CELL, "x": UNIT, "y": UNIT, "levels": [0.0, 1.0], "tolerance": 1e-3, **change}
    with pytest.raises(ValueError, match=words):
        bands.fill(**given)  # type: ignore[arg-type]  # one of them wrong


def test_what_check_raises_ends_the_work() -> None:
    seen: list[float] = []

    def check(fraction: float) -> None:
        seen.append(fraction)
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bands.fill(np.random.default_rng(0).normal(size=(600, 600)), nodes(600), nodes(600), [0, 1], 1e-3, check=check)
    assert seen == sorted(seen)
