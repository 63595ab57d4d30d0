"""Lines swept to surfaces: frames and faces, against what a torsion-free walk and closed forms give."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from modules.data import sweep


def helix(n: int) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0, 4 * np.pi, n)
    return np.column_stack([np.cos(t), np.sin(t), 0.5 * t]), np.array([0, n])


def test_frames_stay_across_and_unit() -> None:
    points, offsets = helix(500)
    u = sweep.directions(points, offsets)
    side = sweep.across(u, offsets)
    assert (side * u).sum(axis=1) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(side, axis=1) == pytest.approx(1.0)


def test_a_frame_without_twist_turns_against_the_torsion() -> None:
    """The angle to the principal normal grows by minus the torsion times the length: the closed form of a helix."""
    points, offsets = helix(4001)
    u = sweep.directions(points, offsets)
    side = sweep.across(u, offsets)
    t = np.linspace(0, 4 * np.pi, 4001)
    normal = np.column_stack([-np.cos(t), -np.sin(t), 0 * t])
    angle = np.unwrap(np.arctan2((np.cross(normal, side) * u).sum(axis=1), (normal * side).sum(axis=1)))
    torsion = 0.5 / (1 + 0.25)
    length = 4 * np.pi * np.sqrt(1.25)
    assert angle[-1] - angle[0] == pytest.approx(-torsion * length, rel=1e-3)


def test_many_lines_at_once_are_as_one_by_one() -> None:
    random = np.random.default_rng(0)
    sizes = [1, 7, 2, 0, 30]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    points = random.standard_normal((offsets[-1], 3)).cumsum(axis=0)
    u = sweep.directions(points, offsets)
    together = sweep.across(u, offsets)
    for a, b in pairwise(offsets):
        alone = np.array([0, b - a])
        assert sweep.directions(points[a:b], alone) == pytest.approx(u[a:b])
        assert sweep.across(u[a:b], alone) == pytest.approx(together[a:b])


def test_a_particle_at_rest_keeps_its_direction() -> None:
    points = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 0]])
    u = sweep.directions(points, np.array([0, 6]))
    assert u.tolist() == [[1, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [0, 1, 0]]
    assert sweep.directions(np.zeros((2, 3)), np.array([0, 2])).tolist() == [[1, 0, 0], [1, 0, 0]]


def test_faces_close_a_tube_and_leave_a_strip_open() -> None:
    offsets = np.array([0, 3, 3, 5])
    assert sweep.chunks(offsets).tolist() == [0, 1, 3]
    tube = sweep.quads(offsets, 8)
    assert len(tube) == 3 * 8 and tube.max() == 39
    edges = np.sort(np.stack([tube, np.roll(tube, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    shared = np.unique(edges, axis=0, return_counts=True)[1]
    assert (shared == 1).sum() == 4 * 8, "only the two ends of each tube are open"
    assert len(sweep.quads(offsets, 2, closed=False)) == 3


def test_rings_are_ellipses() -> None:
    ring = sweep.rings(np.zeros((1, 3)), np.array([[2.0, 0, 0]]), np.array([[0, 0.5, 0]]), 16)
    assert (ring[:, 0] / 2) ** 2 + (ring[:, 1] / 0.5) ** 2 == pytest.approx(1.0)
