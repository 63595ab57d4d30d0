"""Refined lines: points on the hyperbola, areas within the tolerance, the same topology."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.kernels import arcs, contour, refine


def field(seed: int, n: int = 12) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(size=(n, n))


def step(lines: contour.ContourLines) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    cut = np.ones(len(lines.points) - 1, bool)
    cut[lines.offsets[1:-1] - 1] = False
    d = np.diff(lines.points, axis=0)[cut]
    return d[:, 0], d[:, 1]


@pytest.mark.parametrize("shoulder", [True, False])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_every_arc_leaves_at_most_the_tolerance(shoulder: bool, tolerance: float) -> None:
    axis = np.arange(12.0)
    values = field(1)
    drawn = contour.lines(values, axis, axis, 0.1, shoulder)
    fine = refine.refined(drawn, tolerance)
    before, after = (arcs.area(*step(lines), lines.bend) for lines in (drawn, fine))
    pieces = np.bincount(fine.cell, minlength=121)
    assert after.max() <= tolerance * (1 + 1e-9)
    assert after.sum() < before.sum()
    assert len(fine.offsets) == len(drawn.offsets)
    assert np.array_equal(fine.points[fine.offsets[:-1]], drawn.points[drawn.offsets[:-1]])
    assert np.array_equal(fine.points[fine.offsets[1:] - 1], drawn.points[drawn.offsets[1:] - 1])
    assert (pieces[np.unique(drawn.cell)] >= 1).all()
    kept = {tuple(p) for p in fine.points.tolist()}
    assert all(tuple(p) in kept for p in drawn.points.tolist())
    column, row = (np.minimum(np.floor(v).astype(int), 10) for v in (fine.points[:, 0], fine.points[:, 1]))
    u, v = fine.points[:, 0] - column, fine.points[:, 1] - row
    f = (
        values[row, column] * (1 - u) * (1 - v)
        + values[row, column + 1] * u * (1 - v)
        + values[row + 1, column] * (1 - u) * v
        + values[row + 1, column + 1] * u * v
    )
    assert np.abs(f - 0.1).max() < 1e-12


def test_the_number_of_pieces_is_no_larger_than_the_closed_form_asks() -> None:
    axis = np.arange(2.0)
    drawn = contour.lines(np.array([[15.0, 21.0], [24.0, 10.0]]), axis, axis, 17.6, False)
    area = arcs.area(*step(drawn), drawn.bend)
    fine = refine.refined(drawn, 1e-4)
    expected = sum(2 ** int(np.ceil(np.log(a / 1e-4) / np.log(4))) for a in area)
    assert len(fine.bend) == expected
    halved = refine.refined(drawn, area.max() / 2)
    shouldered = contour.lines(np.array([[15.0, 21.0], [24.0, 10.0]]), axis, axis, 17.6, True)
    largest = halved.points[np.isin(np.round(halved.points[:, 0], 7), np.round(shouldered.points[:, 0], 7))]
    assert len(largest) >= 3


def test_straight_lines_and_right_angles_get_no_more_than_they_need() -> None:
    axis = np.arange(4.0)
    plane = contour.lines(np.add.outer(axis, 2 * axis), axis, axis, 3.5, True)
    assert refine.refined(plane, 1e-9) is plane
    saddle = contour.lines(np.array([[1.0, -1.0], [-1.0, 1.0]]), axis[:2], axis[:2], 0.0, False)
    fine = refine.refined(saddle, 1e-9)
    assert len(fine.bend) == 4
    assert [0.5, 0.5] in fine.points.tolist()


def test_no_lines_stay_no_lines() -> None:
    axis = np.arange(3.0)
    none = contour.lines(np.zeros((3, 3)), axis, axis, 1.0)
    assert len(refine.refined(none, 1e-3).points) == 0


def test_a_tolerance_must_be_positive() -> None:
    axis = np.arange(12.0)
    with pytest.raises(ValueError, match="positive"):
        refine.refined(contour.lines(field(1), axis, axis, 0.1), 0.0)
