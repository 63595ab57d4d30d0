"""Lines through triangles: exact for the linear field, joined, and four triangles a cell against contourpy's rule."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from modules.kernels import contour, triangles


def mesh(seed: int, n: int = 60) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    nodes = np.random.default_rng(seed).uniform(0, 1, (n, 2))
    return nodes, Delaunay(nodes).simplices.astype(np.int64)


def ends(lines: contour.ContourLines) -> list[tuple[float, ...]]:
    open_lines = [(a, b - 1) for a, b in zip(lines.offsets[:-1], lines.offsets[1:], strict=True)]
    return [
        tuple(lines.points[i])
        for a, b in open_lines
        for i in (a, b)
        if not np.array_equal(lines.points[a], lines.points[b])
    ]


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(["real", "ties"]))
def test_every_crossed_triangle_has_one_segment_and_lines_end_at_the_border(seed: int, kind: str) -> None:
    nodes, faces = mesh(seed)
    random = np.random.default_rng(seed)
    values = random.normal(size=60) if kind == "real" else random.integers(-1, 2, 60).astype(float)
    lines = triangles.lines(nodes, faces, values, 0.0)
    above = values[faces] >= 0
    crossed = np.flatnonzero(above.any(axis=1) != above.all(axis=1))
    if kind == "real":
        assert sorted(lines.cell.tolist()) == crossed.tolist()
    hull = Counter(tuple(sorted(e)) for f in faces.tolist() for e in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0])))
    border = [e for e, n in hull.items() if n == 1]
    for x, y in ends(lines):
        gaps = [
            abs((nodes[b] - nodes[a])[0] * (y - nodes[a, 1]) - (nodes[b] - nodes[a])[1] * (x - nodes[a, 0])) for a, b in border
        ]
        assert min(gaps) < 1e-12


def test_the_lines_of_a_plane_are_straight_and_on_their_level() -> None:
    nodes, faces = mesh(3)
    values = 2 * nodes[:, 0] - nodes[:, 1] + 0.1
    lines = triangles.lines(nodes, faces, values, 0.4)
    assert np.abs(2 * lines.points[:, 0] - lines.points[:, 1] + 0.1 - 0.4).max() < 1e-14
    assert len(lines.offsets) == 2
    assert not lines.bend.any()


def test_the_high_side_is_on_the_left() -> None:
    nodes, faces = mesh(4)
    values = np.random.default_rng(4).normal(size=60)
    lines = triangles.lines(nodes, faces[:, ::-1], values, 0.2)
    start = np.delete(lines.points, lines.offsets[1:] - 1, axis=0)
    end = np.delete(lines.points, lines.offsets[:-1], axis=0)
    for p, q, t in zip(start, end, faces[lines.cell], strict=True):
        d = q - p
        side = [(d[0] * (nodes[i] - p)[1] - d[1] * (nodes[i] - p)[0]) for i in t]
        for i, s in zip(t, side, strict=True):
            if abs(s) > 1e-12:
                assert (s > 0) == (values[i] >= 0.2)


def test_holes_and_non_manifolds() -> None:
    nodes, faces = mesh(5)
    values = np.random.default_rng(5).normal(size=60)
    values[7] = np.nan
    lines = triangles.lines(nodes, faces, values, 0.0)
    assert not np.isin(lines.cell, np.flatnonzero((faces == 7).any(axis=1))).any()
    square = np.array([[0.0, 0], [1, 0], [0.5, 1], [0.5, -1], [0.6, 0.9]])
    with pytest.raises(ValueError, match="more than two triangles"):
        triangles.lines(square, np.array([[0, 1, 2], [0, 1, 4], [1, 0, 3]]), np.array([0.0, 2, 2, 2, 2]), 1.0)


def test_four_triangles_is_wrong_in_the_cell_of_the_thesis() -> None:
    """Figure 3.9: the middle is 17.5, the saddle 17.7; at 17.6 the corners 10 and 01 are joined."""
    axis = np.arange(2.0)
    values = np.array([[15.0, 21.0], [24.0, 10.0]])
    right = contour.lines(values, axis, axis, 17.6)
    wrong = triangles.four_triangles(values, axis, axis, 17.6)
    pairs = [
        sorted(tuple(np.round(one.points[i], 6)) for i in (one.offsets[0], one.offsets[1] - 1)) for one in (right, wrong)
    ]
    assert pairs[0] != pairs[1]
    assert len(wrong.offsets) == len(right.offsets) == 3
    assert set(wrong.cell.tolist()) == {0}


def test_four_triangles_equals_contourpy() -> None:
    contourpy = pytest.importorskip("contourpy")
    values = np.random.default_rng(2).normal(size=(20, 30))
    x, y = np.arange(30.0), np.arange(20.0)
    ours = triangles.four_triangles(values, x, y, 0.1)
    theirs = contourpy.contour_generator(x, y, values, quad_as_tri=True).lines(0.1)
    assert len(ours.offsets) - 1 == len(theirs)

    def length(lines: list[NDArray[np.float64]]) -> float:
        return float(sum(np.hypot(*np.diff(p, axis=0).T).sum() for p in lines))

    assert length(np.split(ours.points, ours.offsets[1:-1])) == pytest.approx(length(theirs), rel=1e-12)
