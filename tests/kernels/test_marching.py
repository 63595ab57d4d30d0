"""Accurate marching cubes, judged by subdivision into tetrahedra: nothing of the method's tables is used."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from scipy.ndimage import gaussian_filter, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from modules.kernels import marching, marching_distance

STEPS = [np.array(s) for s in itertools.product((0, 1), repeat=3) if any(s)]
FREUDENTHAL = np.zeros((3, 3, 3), bool)
FREUDENTHAL[1, 1, 1] = True
for step in STEPS:
    FREUDENTHAL[tuple(1 + step)] = FREUDENTHAL[tuple(1 - step)] = True


def surface(values: Any, level: Any = 0.0, **more: Any) -> Any:
    x, y, z = (np.arange(float(n)) for n in reversed(values.shape))
    return marching.surface(np.asarray(values, float), x, y, z, level, **more)


def refined(values: Any, k: Any) -> Any:
    """The trilinear interpolant at k points a cell along each axis."""
    for axis in range(3):
        n = values.shape[axis]
        t = np.arange((n - 1) * k + 1) / k
        i = np.minimum(t.astype(int), n - 2)
        shape = [1, 1, 1]
        shape[axis] = -1
        w = (t - i).reshape(shape)
        values = (1 - w) * np.take(values, i, axis) + w * np.take(values, i + 1, axis)
    return values


def crossed(above: Any, steps: Any) -> Any:
    """How many simplices from a node along the sums of some steps have ends on both sides."""
    corners = [np.zeros(3, int), *np.cumsum(steps, axis=0)]
    size = np.array(above.shape) - corners[-1]
    parts = [above[tuple(slice(c, c + n) for c, n in zip(corner, size, strict=True))] for corner in corners]
    return int((np.logical_or.reduce(parts) & ~np.logical_and.reduce(parts)).sum())


def truth(values: Any, k: Any) -> Any:
    """Euler characteristic of the surface, and number of regions above and below, of a subdivision by tetrahedra."""
    above = refined(values, k) >= 0
    unit = np.eye(3, dtype=int)
    edges = sum(crossed(above, [s]) for s in STEPS)
    faces = sum(crossed(above, [p, q]) for p in STEPS for q in STEPS if (p + q).max() == 1)
    cells = sum(crossed(above, list(unit[list(order)])) for order in itertools.permutations(range(3)))
    return edges - faces + cells, label(above, FREUDENTHAL)[1] + label(~above, FREUDENTHAL)[1]


def euler(s: Any) -> Any:
    edges = np.unique(np.sort(s.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    assert len(np.unique(s.triangles)) == len(s.points)
    return len(s.points) - len(edges) + len(s.triangles)


def components(s: Any) -> Any:
    i, j = s.triangles[:, [0, 1]].ravel(), s.triangles[:, [1, 2]].ravel()
    n = len(s.points)
    return connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(n, n)), directed=False)[0]


def judge(s: Any, shape: Any) -> Any:
    """Oriented, manifold, closed up to the border, no triangle without area or in a face of a cell, none twice."""
    n = len(s.points)
    e = s.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    there, back = e[:, 0] * n + e[:, 1], e[:, 1] * n + e[:, 0]
    assert len(np.unique(there)) == len(there), "an edge has two triangles of one direction"
    single = e[~np.isin(there, back)]
    p, q = s.points[single[:, 0]], s.points[single[:, 1]]
    last = np.array(shape[::-1]) - 1.0
    assert (((p == 0) & (q == 0)) | ((p == last) & (q == last))).any(axis=1).all(), "an open edge inside"
    corner = s.points[s.triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    assert (area > 0).all()
    flat = (corner == corner[:, :1]).all(axis=1) & (corner[:, 0] % 1 == 0)
    assert not flat.any(), "a triangle in a face"
    assert len(np.unique(np.sort(s.triangles, axis=1), axis=0)) == len(s.triangles)
    links = np.zeros(n, int)  # one fan of triangles about each vertex: as many as its edges, or one less on the border
    np.add.at(links, s.triangles.ravel(), 1)
    ends = np.bincount(single.ravel(), minlength=n)
    assert set(ends) <= {0, 2}


def fields(kind: Any, count: Any, seed: Any) -> Any:
    random = np.random.default_rng(seed)
    for _ in range(count):
        values = random.normal(size=random.integers(3, 5, 3))
        if kind == "log-normal":
            values = np.sign(values) * np.exp(random.normal(size=values.shape))
        yield np.pad(values, 1, constant_values=-1.0) if kind == "padded" else values


@pytest.mark.parametrize(("kind", "count"), [("normal", 30), ("log-normal", 15), ("padded", 25)])
def test_topology_is_that_of_a_subdivision(kind: Any, count: Any) -> None:
    for values in fields(kind, count, 4):
        s = surface(values)
        judge(s, values.shape)
        for k in (8, 16, 32):  # finer where thin parts need it
            characteristic, regions = truth(values, k)
            if euler(s) == characteristic and (kind != "padded" or components(s) == regions - 1):
                break
        else:
            pytest.fail(f"{euler(s)} against {characteristic}, {components(s)} pieces, {regions} regions")


def test_ties_leave_a_closed_surface_of_triangles_with_an_area() -> None:
    random = np.random.default_rng(2)
    for n in range(150):
        values = random.integers(-2, 3, random.integers(3, 6, 3)).astype(float)
        values = np.pad(values, 1, constant_values=-1.0) if n % 2 else values
        judge(surface(values), values.shape)


def test_the_high_side_is_behind_the_triangles() -> None:
    values = 2.0 - np.linalg.norm(np.indices((7, 7, 7)) - 3.0, axis=0)
    s = surface(values)
    p, q, r = (s.points[s.triangles[:, k]] - 3 for k in range(3))
    assert np.isclose(np.einsum("ij,ij->", p, np.cross(q, r)) / 6, 4 / 3 * np.pi * 8, rtol=0.15)
    assert euler(s) == 2


def test_every_vertex_lies_on_the_trilinear_surface() -> None:
    random = np.random.default_rng(3)
    for _ in range(20):
        values = random.normal(size=(4, 4, 4))
        s = surface(values)
        x, y, z = s.points.T
        i, j, k = (np.minimum(c.astype(int), 2) for c in (x, y, z))
        u, v, w = x - i, y - j, z - k
        at = sum(
            values[k + c, j + b, i + a] * (u if a else 1 - u) * (v if b else 1 - v) * (w if c else 1 - w)
            for a, b, c in itertools.product((0, 1), repeat=3)
        )
        assert np.abs(at).max() < 1e-6


def test_slabs_do_not_show(monkeypatch: Any) -> None:
    values = np.random.default_rng(5).normal(size=(9, 6, 7))
    values[4, 2:4, 3] = np.nan
    whole = surface(values)
    for layers in (1, 2, 3):
        monkeypatch.setattr(marching, "LAYERS_A_SLAB", layers)
        cut = surface(values)
        assert np.array_equal(cut.points, whole.points)
        assert np.array_equal(cut.triangles, whole.triangles)
        assert np.array_equal(cut.cell, whole.cell)


def test_an_index_of_blocks_changes_nothing() -> None:
    random = np.random.default_rng(6)
    for shape in ((20, 19, 18), (9, 9, 9), (2, 30, 17), (17, 8, 25)):
        values = gaussian_filter(random.normal(size=shape), 2.0)
        index = marching.blocks(values)
        for level in (values.mean(), values.max() - 1e-3, values.max(), values.min(), values[0, 0, 0], values.max() + 1):
            s, t = surface(values, level), surface(values, level, index=index)
            assert np.array_equal(s.points, t.points)
            assert np.array_equal(s.triangles, t.triangles)
    values[0, 0, 0] = np.nan
    assert marching.blocks(values) is None


def test_no_sample_of_a_triangle_is_farther_than_its_proven_distance() -> None:
    values = gaussian_filter(np.random.default_rng(7).normal(size=(12, 12, 12)), 1.0)
    s = surface(values)
    x = np.arange(12.0)
    reach, slope = marching_distance.distances(values, x, x, x, 0.0, s.points, s.triangles, s.cell)
    known = np.isfinite(reach)
    assert known.mean() > 0.9
    assert (slope > 0).all()
    corner = s.points[s.triangles][known]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 1] - corner[:, 0])
    step = normal / np.linalg.norm(normal, axis=1)[:, None] * reach[known][:, None]
    field = RegularGridInterpolator((x, x, x), values.transpose(2, 1, 0), bounds_error=False)
    for a, b in itertools.product(np.linspace(0, 1, 9), repeat=2):
        if a + b <= 1:
            at = corner[:, 0] + a * (corner[:, 1] - corner[:, 0]) + b * (corner[:, 2] - corner[:, 0])
            low, high = field(at - step), field(at + step)
            assert not (low > 1e-12).any()  # beyond the border it is nan
            assert not (high < -1e-12).any()


def test_a_sample_that_is_not_known_leaves_a_hole() -> None:
    values = np.broadcast_to(np.arange(5.0) - 1.7, (5, 5, 5)).copy()
    values[2, 2, 2] = np.nan
    s = surface(values)
    assert len(np.unique(s.cell)) == 16 - 4
    assert np.isfinite(s.points).all()
    assert euler(s) == 0  # a sheet with one hole


@pytest.mark.parametrize(
    ("values", "axes", "level", "words"),
    [
        (np.zeros((2, 2, 2)), (2, 2, 3), 0.0, "do not fit"),
        (np.zeros((1, 2, 2)), (2, 2, 1), 0.0, "no cell"),
        (np.zeros((2, 2, 2)), (2, 2, 2), np.nan, "finite"),
    ],
)
def test_what_cannot_be_drawn_is_refused(values: Any, axes: Any, level: Any, words: Any) -> None:
    x, y, z = (np.arange(float(n)) for n in axes)
    with pytest.raises(ValueError, match=words):
        marching.surface(values, x, y, z, level)
