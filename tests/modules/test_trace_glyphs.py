"""Cuboids, strips, ellipse tubes, members, the end of an assessment, and the graph: where they lie and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

from modules.accuracy_mappers.assessment_end import assessment_end
from modules.accuracy_mappers.cuboid import cuboid
from modules.accuracy_mappers.ellipse_tube import ellipse_tube
from modules.accuracy_mappers.error_graph import error_graph
from modules.accuracy_mappers.members import members
from modules.accuracy_mappers.spike import spike
from modules.accuracy_mappers.strip import strip
from modules.accuracy_mappers.tube import tube
from modules.api import EXACT, Accuracy, Cells, Field, Flag, Geometry, Identity, Matrix, Source, Term

SOURCE = Source("Integration", "mapping", "estimated", "a rule")
NOISE = Source("Noise", "data", "estimated", "a rule")
N = 6


def signed(error: Any, quantity: str = "position", unit: str = "m", name: str = "Integration") -> Term:
    flat = np.asarray(error, float).ravel()
    source = Source(name, "mapping", "estimated", "made up [two half steps/1]")
    return Term(source, "signed", quantity, unit, flat, Identity(len(flat)), "point", 3)


def noise(seed: int = 0, primitives: int = 4) -> Term:
    """A spread whose points have primitives in common."""
    random = np.random.default_rng(seed)
    matrix = Matrix(csr_array(random.standard_normal((3 * N, primitives))))
    return Term(NOISE, "linear", "position", "m", 0.1 + random.random(primitives), matrix, "point", 3)


def line(*terms: Term, flags: tuple[Flag, ...] = (), lines: Any = None) -> Geometry:
    points = np.column_stack([np.arange(float(N)), np.zeros(N), np.zeros(N)])
    return Geometry(
        points=points,
        lines=Cells.of(lines or [range(N)]),
        values={"time": Field(np.arange(N) * 0.5, "point", "s")},
        accuracy=Accuracy(terms, flags=flags),
    )


ERROR = np.arange(3.0 * N).reshape(N, 3) / 10


def test_a_cuboid_has_its_corner_where_the_estimate_puts_the_particle() -> None:
    drawn = cuboid(line(signed(ERROR)), every=2)
    boxes = drawn.points.reshape(3, 8, 3)
    assert boxes[:, 0] == pytest.approx(np.array([[0, 0, 0], [2, 0, 0], [4, 0, 0.0]]))
    assert boxes[:, 7] == pytest.approx(boxes[:, 0] - ERROR[::2])
    assert np.ptp(boxes, axis=1) == pytest.approx(ERROR[::2])
    assert len(drawn.polygons) == 18 and drawn.accuracy.terms[0].count == 24
    around = cuboid(line(noise()), k=1.5).points.reshape(N, 8, 3)
    assert np.ptp(around, axis=1) == pytest.approx(3.0 * noise().error())
    assert around.mean(axis=1) == pytest.approx(line(noise()).points)


def test_what_is_exaggerated_says_that_volumes_mislead() -> None:
    """Thesis figure 5.9."""
    (shown,) = cuboid(line(signed(ERROR)), exaggeration=30).shows
    assert shown.factor == 30 and "not the volumes" in shown.note
    assert "volumes" not in cuboid(line(signed(ERROR))).shows[0].note


def test_a_velocity_is_drawn_as_a_way_and_not_exaggerated() -> None:
    residual = signed(ERROR, "velocity", "m/s", "Velocity residual")
    traces = line(signed(ERROR), residual)
    assert spike(traces).shows[0].quantity == "position"
    drawn = spike(traces, source="Velocity residual", exaggeration=30)
    (shown,) = drawn.shows
    assert shown.quantity == "velocity" and shown.factor == 1.0 and "30 s" in shown.note
    assert drawn.points.reshape(-1, 2, 3)[:, 1] == pytest.approx(traces.points - 30 * ERROR)


def test_a_strip_lies_between_the_two_lines() -> None:
    traces = line(signed(ERROR))
    drawn = strip(traces, exaggeration=2.0, steps=2)
    sides = drawn.points.reshape(2, N, 2, 3)
    assert sides[:, :, 0] == pytest.approx(np.stack([traces.points] * 2))
    assert sides[0, :, 1] == pytest.approx(traces.points - 2 * ERROR)
    assert sides[1, :, 1] == pytest.approx(traces.points - ERROR)
    assert len(drawn.polygons) == 2 * (N - 1)


def test_a_strip_of_a_spread_lies_along_its_longest_axis_and_does_not_flip() -> None:
    traces = line(noise())
    sides = strip(traces, k=1.0).points.reshape(N, 2, 3)
    rows = noise().operator.rows(np.arange(3 * N)).toarray() * noise().value
    for i in range(N):
        across = rows[3 * i + 1 : 3 * i + 3]
        half = (sides[i, 1] - sides[i, 0]) / 2
        assert np.linalg.norm(half) == pytest.approx(np.linalg.svd(across, compute_uv=False)[0])
        assert half[0] == pytest.approx(0.0, abs=1e-12)
    halves = sides[:, 1] - sides[:, 0]
    assert ((halves[1:] * halves[:-1]).sum(axis=1) >= 0).all()


def test_ellipses_hold_what_they_claim() -> None:
    """Monte Carlo: two normal components are within k = 2 with probability 1 - exp(-2)."""
    term = noise(3)
    drawn = ellipse_tube(line(term), k=2.0, steps=1, sides=64)
    ring = drawn.points.reshape(N, 64, 3)
    random = np.random.default_rng(1)
    rows = term.operator.rows(np.arange(3 * N)).toarray() * term.value
    draws = (rows @ random.standard_normal((rows.shape[1], 20_000))).reshape(N, 3, -1)
    for i in range(N):
        a, b = ring[i, 0, 1:], ring[i, 16, 1:]
        inside = (np.linalg.solve(np.column_stack([a, b]), draws[i, 1:]) ** 2).sum(axis=0) <= 1
        assert inside.mean() == pytest.approx(1 - np.exp(-2), abs=0.01)


def test_spreads_of_independent_sources_go_into_one_ellipse() -> None:
    two = (noise(1), noise(2))
    both = ellipse_tube(line(*two, signed(ERROR)), k=1.0, steps=1)
    assert {s.name for s in both.shows} == {"Noise"} and len(both.shows) == 2
    widths = [ellipse_tube(line(t), k=1.0, steps=1).points.reshape(N, -1, 3).var(axis=1)[:, 1:].sum(axis=1) for t in two]
    assert both.points.reshape(N, -1, 3).var(axis=1)[:, 1:].sum(axis=1) == pytest.approx(widths[0] + widths[1])


def test_members_spread_as_the_term_says_and_each_is_one_draw() -> None:
    term = noise()
    drawn = members(line(term), count=2000)
    away = drawn.points.reshape(2000, N, 3) - line(term).points
    assert away.std(axis=0) == pytest.approx(term.error(), rel=0.08)
    rank = np.linalg.matrix_rank(away.reshape(2000, -1), tol=1e-8)
    assert rank == 4, "points that have primitives in common move together"
    assert np.array_equal(members(line(term)).points, members(line(term)).points)
    assert not np.array_equal(members(line(term)).points, members(line(term), seed=2).points)
    ensemble = Term(NOISE, "members", "position", "m", np.random.default_rng(0).random((5, 3 * N)), Identity(3 * N), "point", 3)
    assert len(members(line(ensemble)).lines) == 5
    assert members(line(signed(ERROR))).points == pytest.approx(line().points - ERROR)


ENDED = (Flag("no assessment", "from here on", "point", np.array([2, 3, 4, 5])),)


def test_where_the_estimate_is_not_credible_nothing_is_drawn_and_words_say_so() -> None:
    """Thesis figure 5.10 a."""
    traces = line(signed(ERROR), noise(), flags=ENDED)
    for draw in (tube, spike, cuboid, strip):
        drawn: Geometry = draw(traces, source="Integration")
        assert drawn.points[:, 0].max() <= 1.0
        assert "not credible" in drawn.shows[0].note
        assert draw(traces, source="Noise").points[:, 0].max() > 4
    subsidiary = line(signed(ERROR, name="Integration, of the primary trace"), flags=ENDED)
    assert tube(subsidiary).points[:, 0].max() <= 1.0
    ends = assessment_end(traces)
    assert ends.points.tolist() == [[2, 0, 0]]
    assert ends.values["name"].values.tolist() == ["no assessment from here on"]
    assert not len(assessment_end(line(signed(ERROR))).points)
    two = line(signed(ERROR), flags=ENDED, lines=[[0, 1, 2], [3, 4], [5]])
    assert assessment_end(two).origin is not None and assessment_end(two).origin.tolist() == [0, 1, 2]  # type: ignore[union-attr]  # seen


def test_a_graph_over_time() -> None:
    term = noise()
    table = error_graph(line(signed(ERROR), term), k=2.0)
    assert list(table.columns)[:2] == ["time", "total error"] and table.units["time"] == "s"
    assert table.columns["time"].tolist() == [0, 0.5, 1, 1.5, 2, 2.5]
    assert table.columns["Noise"] == pytest.approx(2 * term.size())
    assert table.columns["total error"] == pytest.approx(np.linalg.norm(ERROR, axis=1) + 2 * term.size())
    ended = error_graph(line(signed(ERROR), term, flags=ENDED))
    assert np.isnan(ended.columns["Integration"]).tolist() == [False, False, True, True, True, True]
    assert np.isnan(ended.columns["total error"][2:]).all() and np.isfinite(ended.columns["Noise"]).all()
    with pytest.raises(ValueError, match="no trace 1"):
        error_graph(line(term), trace=1)


def test_what_does_not_fit_is_refused() -> None:
    bare = Geometry(points=np.zeros((2, 3)), lines=Cells.of([[0, 1]]), accuracy=EXACT)
    draws: tuple[Any, ...] = (cuboid, strip, members)
    for draw in draws:
        with pytest.raises(ValueError, match="as a vector"):
            draw(bare)
        with pytest.raises(ValueError, match="no picture"):
            draw(line(signed(ERROR)), exaggeration=0)
    bound = Term(SOURCE, "bound", "position", "m", np.ones(3 * N), Identity(3 * N), "point", 3)
    with pytest.raises(ValueError, match="without a direction"):
        strip(line(bound))
    with pytest.raises(ValueError, match="nothing of what is likely"):
        members(line(bound))
    with pytest.raises(ValueError, match="no spread"):
        ellipse_tube(line(signed(ERROR)))
    with pytest.raises(ValueError, match="no ellipse"):
        ellipse_tube(line(signed(ERROR)), source="Integration")
    with pytest.raises(ValueError, match="one step or more"):
        tube(line(signed(ERROR)), steps=0)
