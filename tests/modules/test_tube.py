"""The accuracy mappers of traces, tube and spikes: where they lie, their scale, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from modules.accuracy_mappers.spike import spike
from modules.accuracy_mappers.tube import circles, tube
from modules.api import EXACT, Accuracy, Cells, Geometry, Identity, Source, Term

SOURCE = Source("Somebody", "mapping", "estimated", "a rule")


def line(error: object, kind: str = "signed") -> Geometry:
    """Along x, with an error of its positions."""
    e = np.asarray(error, float)
    n = len(e)
    points = np.column_stack([np.arange(float(n)), np.zeros(n), np.zeros(n)])
    term = Term(SOURCE, kind, "position", "m", e.ravel(), Identity(3 * n), "point", 3)  # type: ignore[arg-type]  # a kind
    return Geometry(points=points, lines=Cells.of([range(n)]), accuracy=Accuracy((term,)))


def test_the_circle_runs_through_the_point_and_the_projected_other_one() -> None:
    """Figure 5.5."""
    random = np.random.default_rng(0)
    p, q = random.standard_normal((2, 50, 3))
    u = random.standard_normal((50, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    centre, radius = circles(p, u, p - q, True)
    middle = (p + q) / 2
    assert centre == pytest.approx(middle - ((middle - p) * u).sum(axis=1, keepdims=True) * u)
    across = q - ((q - p) * u).sum(axis=1, keepdims=True) * u
    for on_it in (p, across):
        assert np.linalg.norm(on_it - centre, axis=1) == pytest.approx(radius)


def test_a_tube_is_true_to_scale_and_says_so() -> None:
    traces = line([[0, 0, 0], [0.5, 0.2, 0.0], [0.0, 0.0, 0.4]])
    drawn = tube(traces, sides=16)
    ring = drawn.points.reshape(3, 16, 3)
    centre = ring.mean(axis=1)
    assert np.linalg.norm(ring - centre[:, None], axis=2).max(axis=1) == pytest.approx([0.0, 0.1, 0.2])
    assert centre[1] == pytest.approx([1.0, -0.1, 0.0]) and centre[2] == pytest.approx([2.0, 0.0, -0.2])
    assert len(drawn.polygons) == 2 * 16
    (shown,) = drawn.shows
    assert shown.factor == 1.0 and shown.name == "Somebody"
    assert tube(traces, exaggeration=7).shows[0].factor == 7
    assert drawn.accuracy.terms[0].count == len(drawn.points)


def test_an_error_without_a_sign_gives_a_tube_around_the_trace() -> None:
    drawn = tube(line([[1, 0.3, 0.4], [1, 0.3, 0.4]], "linear"), k=1)
    ring = drawn.points.reshape(2, -1, 3)
    assert ring.mean(axis=1)[:, 1:] == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(ring[0, :, 1:], axis=1) == pytest.approx(0.5)
    assert "k = 1" in drawn.shows[0].note
    wide = tube(line([[1, 0.3, 0.4], [1, 0.3, 0.4]], "linear")).points.reshape(2, -1, 3)
    assert np.linalg.norm(wide[0, :, 1:], axis=1) == pytest.approx(1.0)


def test_nested_tubes_fade_by_equal_steps_of_the_density() -> None:
    drawn = tube(line([[1, 0.3, 0.4], [1, 0.3, 0.4]], "linear"), k=2, steps=5, sides=12)
    radius = np.linalg.norm(drawn.points.reshape(5, 2, 12, 3)[:, 0, :, 1:], axis=2)
    density = np.exp(-((radius[:, 0] / 0.5) ** 2) / 2)
    assert np.diff(density) == pytest.approx((1 - np.exp(-2)) / 5)
    assert drawn.values["share"].values.max() == 1.0 and len(drawn.polygons) == 5 * 12
    assert drawn.accuracy.terms[0].count == len(drawn.points)


def test_spikes_end_where_the_estimate_puts_the_particle() -> None:
    drawn = spike(line([[0, 0, 0], [0.5, 0.2, 0.0], [0.0, 0.0, 0.4]]), exaggeration=2.0)
    assert [tuple(p[1]) for p in drawn.polylines()] == [(0, 0, 0), (0, -0.4, 0), (2, 0, -0.8)]
    assert len(spike(line(np.zeros((5, 3))), every=2).lines) == 3


def test_what_does_not_fit_is_refused() -> None:
    bare = Geometry(points=np.zeros((2, 3)), lines=Cells.of([[0, 1]]), accuracy=EXACT)
    for draw in (tube, spike):
        with pytest.raises(ValueError, match="as a vector"):
            draw(bare)
        with pytest.raises(ValueError, match="no source 'nobody'"):
            draw(line(np.zeros((2, 3))), source="nobody")
        with pytest.raises(ValueError, match="no picture"):
            draw(line(np.zeros((2, 3))), exaggeration=0)
