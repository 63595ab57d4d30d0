"""Spheres, pipes, ribbons and surfaces of traces, arrows of vectors: against closed forms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Accuracy, Cells, Field, Flag, Geometry, Identity, Model, Progress, Samples, Source, Term
from modules.mappers.arrows import arrows
from modules.mappers.pipes import pipes
from modules.mappers.ribbons import ribbons
from modules.mappers.seeds import seeds
from modules.mappers.spheres import ball, spheres
from modules.mappers.stream_surface import stream_surface
from modules.mappers.trace import trace
from modules.modellers.interpolate import interpolate
from modules.readers.analytic import analytic

SOURCE = Source("Somebody", "mapping", "estimated", "a rule")


def term(n: int, place: Any = "point", components: int = 3) -> Term:
    value = np.arange(float(n * components))
    return Term(SOURCE, "signed", "position", "m", value, Identity(n * components), place, components)


def two_lines() -> Geometry:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 2, 0]])
    segments = Term(SOURCE, "metric", "area", "m²", np.array([1.0, 2, 3]), Identity(3), "segment")
    return Geometry(
        points=points,
        lines=Cells.of([[0, 1, 2], [3, 4]]),
        values={
            "time": Field(np.array([0.0, 1, 2, 0, 1]), "point", "s"),
            "line": Field(np.array([10, 20]), "cell"),
            "piece": Field(np.array([1, 2, 3]), "segment"),
        },
        accuracy=Accuracy((term(5), segments), flags=(Flag("some", "here", "point", np.array([1])), Flag("all", "of it"))),
    )


def flow(formula: str, **box: Any) -> Model:
    return interpolate(analytic(formula=formula, unit="m/s", lengths="m", samples=(21, 21, 21), **box))


def test_a_ball_is_round_and_closed() -> None:
    points, quads = ball(16)
    assert np.linalg.norm(points, axis=1) == pytest.approx(1.0)
    corners = points[quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert ((normal * corners.mean(axis=1)).sum(axis=1) > 0).all(), "faces look outwards"
    volume = sum(np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, j], corners[:, j + 1])).sum() / 6 for j in (1, 2))
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.07)


def test_spheres_stand_at_points_with_their_values_and_errors() -> None:
    drawn = spheres(two_lines(), radius=0.1, every=2)
    balls = drawn.points.reshape(3, -1, 3)
    assert balls.mean(axis=1) == pytest.approx(np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0.0]]), abs=1e-12)
    assert drawn.values["time"].values.reshape(3, -1)[:, 0].tolist() == [0, 2, 0]
    assert drawn.values["line"].values.reshape(3, -1)[:, 0].tolist() == [10, 10, 20]
    (found,) = drawn.accuracy.terms
    assert found.error().reshape(3, -1, 3)[1, 5].tolist() == [6, 7, 8]
    assert len(drawn.accuracy.ended) == 1 and [f.name for f in drawn.accuracy.flags] == ["all"]
    start = spheres(seeds(flow("1;0;0", low=(0, 0, 0), high=(1, 1, 1)), count=4), radius=0.01)
    assert len(start.points) == 4 * len(ball(16)[0])


def test_pipes_keep_their_distance_and_carry_what_lies_on_lines() -> None:
    drawn = pipes(two_lines(), radius=0.2, sides=8)
    ring = drawn.points.reshape(5, 8, 3)
    assert np.linalg.norm(ring - two_lines().points[:, None], axis=2) == pytest.approx(0.2)
    assert len(drawn.polygons) == 3 * 8
    assert drawn.values["piece"].values.reshape(3, 8)[:, 0].tolist() == [1, 2, 3]
    assert drawn.values["line"].values.reshape(3, 8)[:, 0].tolist() == [10, 10, 20]
    places = {t.place: t.error() for t in drawn.accuracy.terms}
    assert places["cell"].reshape(3, 8)[:, 3].tolist() == [1, 2, 3] and places["point"].shape == (40, 3)


def test_a_ribbon_turns_with_half_the_vorticity() -> None:
    """Rigid rotation about the particle's straight way: the fluid, and the ribbon, turn by omega t."""
    model = flow("0.5; -0.8*z; 0.8*y", low=(-1, -1, -1), high=(1, 1, 1))
    start = Geometry(points=np.array([[-0.9, 0, 0]]), accuracy=EXACT)
    traces = trace(model, start, Progress(), interval=0.1, end_time=3.0).traces
    drawn = ribbons(traces, model, width=0.2)
    assert np.unwrap(np.radians(drawn.values["twist"].values[::2])) == pytest.approx(0.8 * traces.values["time"].values)
    side = drawn.points.reshape(-1, 2, 3)
    half = (side[:, 1] - side[:, 0]) / 2
    assert np.linalg.norm(half, axis=1) == pytest.approx(0.1)
    angle = np.unwrap(np.arctan2(half[:, 2], half[:, 1]))
    assert angle - angle[0] == pytest.approx(0.8 * traces.values["time"].values)
    assert any(m.name.startswith("Twist") for m in drawn.accuracy.missing)


def test_circles_do_not_twist_and_a_jet_widens_as_it_slows() -> None:
    turning = flow("-y; x; 0", low=(-1, -1, -1), high=(1, 1, 1))
    start = Geometry(points=np.array([[0.5, 0, 0]]), accuracy=EXACT)
    traces = trace(turning, start, Progress(), interval=0.1, end_time=3.0).traces
    assert ribbons(traces, turning).values["twist"].values == pytest.approx(0.0, abs=1e-9)
    slowing = flow("-x; 0.5*y; 0.5*z", low=(-1, -1, -1), high=(1, 1, 1))
    start = Geometry(points=np.array([[0.9, 0, 0]]), accuracy=EXACT)
    traces = trace(slowing, start, Progress(), interval=0.1, end_time=1.0).traces
    side = ribbons(traces, slowing, width=0.1, widen=True).points.reshape(-1, 2, 3)
    width = np.linalg.norm(side[:, 1] - side[:, 0], axis=1)
    assert width == pytest.approx(0.1 * np.exp(0.5 * traces.values["time"].values), rel=1e-6)


def test_a_stream_surface_of_a_steady_stream_is_a_plane_of_timelines() -> None:
    model = flow("1; 0; 0", high=(2, 1, 1), low=(0, 0, 0))
    start = seeds(model, arrangement="line", first=(0.1, 0.2, 0.5), last=(0.1, 0.8, 0.5), count=4)
    traces = trace(model, start, Progress(), interval=0.25, end_time=1.0).traces
    surface = stream_surface(traces)
    assert len(surface.polygons) == 3 * 4 and surface.points[:, 2] == pytest.approx(0.5)
    corners = surface.points[surface.polygons.connectivity.reshape(-1, 4)]
    area = np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1) / 2
    assert area.sum() == pytest.approx(0.6)
    assert {t.name for t in surface.accuracy.terms} == {t.name for t in traces.accuracy.terms}
    assert len(stream_surface(traces, closed=True).polygons) == 4 * 4


def test_a_surface_is_torn_where_neighbours_part_and_says_so() -> None:
    model = flow("0.5; 2*(y-0.5); 0", high=(2, 1, 1), low=(0, 0, 0))
    start = seeds(model, arrangement="line", first=(0.1, 0.48, 0.5), last=(0.1, 0.52, 0.5), count=2)
    traces = trace(model, start, Progress(), interval=0.1, end_time=1.4).traces
    whole, torn = stream_surface(traces), stream_surface(traces, widest=0.2)
    assert len(torn.polygons) < len(whole.polygons)
    assert "torn between 1 of 1" in torn.accuracy.flags[-1].words
    late = Field(traces.values["time"].values * np.repeat([1.0, 1.1], len(traces.points) // 2), "point", "s")
    with pytest.raises(ValueError, match="give 'trace' an interval"):
        stream_surface(replace(traces, values={"time": late}))


def test_arrows_are_as_long_as_the_vectors_and_carry_their_errors() -> None:
    values = np.zeros((3, 4, 5, 3))
    values[..., 0], values[..., 1] = 1.0, np.arange(5.0)
    noise = Term(SOURCE, "linear", "value", "m/s", np.asarray(0.1), Identity(values.size), "point", 3)
    samples = Samples.from_array(values, unit="m/s", name="wind", accuracy=Accuracy((noise,)))
    bare = arrows(samples, shape="line", scale=0.5)
    pair = bare.points.reshape(60, 2, 3)
    assert pair[:, 1] - pair[:, 0] == pytest.approx(0.5 * values.reshape(-1, 3))
    assert bare.accuracy.terms[0].count == 120 and bare.accuracy.terms[0].size() == pytest.approx(0.1 * np.sqrt(3))
    assert "1\u00a0m/s drawn as 0.5" in bare.name
    barbed = arrows(samples, shape="arrow", scale=0.5, stride=2)
    assert len(barbed.lines) == 3 * 2 * 2 * 3
    cone = arrows(samples, shape="cone", scale=0.5, sides=6)
    tip = cone.points.reshape(60, 7, 3)
    assert tip[:, 6] == pytest.approx(pair[:, 1]) and tip[:, :6].mean(axis=1) == pytest.approx(pair[:, 0])
    assert np.ptp(np.linalg.norm(tip[:, 0] - pair[:, 0], axis=1)) == pytest.approx(0.0, abs=1e-12), "length alone tells"
    assert len(cone.polygons) == 60 * 7


def test_an_automatic_scale_keeps_arrows_apart_and_what_is_nothing_is_left_out() -> None:
    values = np.zeros((4, 4, 3))
    values[0, 0], values[1, 1], values[2, 2] = (3, 0, 0), (np.nan, 0, 0), (1e-3, 0, 0)
    samples = Samples.from_array(values, vector=True, spacing=(2, 2), accuracy=EXACT)
    drawn = arrows(samples, shape="line")
    assert drawn.origin is not None and drawn.origin.tolist() == [0, 10]
    length = np.linalg.norm(np.diff(drawn.points.reshape(-1, 2, 3), axis=1), axis=2).max()
    assert 0.5 < length / 1.5 <= 1.4
    assert len(arrows(samples, shape="line", least=0.1).lines) == 1


def test_what_does_not_fit_is_refused() -> None:
    bare = Geometry(points=np.zeros((3, 3)), vertices=Cells.of([[0], [1], [2]]), accuracy=EXACT)
    for draw in (pipes, ribbons):
        with pytest.raises(ValueError, match="no lines"):
            draw(bare)
    with pytest.raises(ValueError, match="not seen"):
        pipes(two_lines(), radius=0.0)
    with pytest.raises(ValueError, match="not seen"):
        spheres(bare)
    with pytest.raises(ValueError, match="two traces at least"):
        stream_surface(bare)
    with pytest.raises(ValueError, match="the model of vectors"):
        ribbons(two_lines(), interpolate(analytic(samples=(5, 5))))
    with pytest.raises(ValueError, match="vectors"):
        arrows(analytic(samples=(5, 5)))
