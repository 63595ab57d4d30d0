"""The dust cloud: every point lies between line and contour, as many as the area, and nothing else is shown."""

from __future__ import annotations

import numpy as np
import pytest

from modules.accuracy_mappers.dust import dust
from modules.api import EXACT, Geometry, Model, Progress, Samples, bound
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

CELL = np.array([[15.0, 21.0], [24.0, 10.0]])


def field(values: object = CELL) -> Model:
    values = np.asarray(values, float)
    return interpolate(Samples.from_array(values, accuracy=EXACT.add(bound("b", 0.5, values.size))))


def lines(method: str = "basic") -> Geometry:
    return contour(field(), Progress(), levels=(17.6,), method=method)  # type: ignore[arg-type]  # a word


def test_every_point_lies_between_chord_and_contour() -> None:
    drawn = lines()
    cloud = dust(drawn, points=20_000)
    values, _ = field().at(cloud.points)
    segments = drawn.segments()
    side = []
    for segment in (0, 1):
        p, q = drawn.points[segments[segment]]
        there = cloud.points[cloud.origin == segment]
        normal = np.array([-(q - p)[1], (q - p)[0]])
        side.append(np.sign((there[:, :2] - p[:2]) @ normal))
        middle = field().at([(p + q) / 2])[0][0]
        assert np.all(np.sign(values[cloud.origin == segment] - 17.6) == np.sign(middle - 17.6))
    assert all(len(set(s.tolist())) == 1 for s in side)


def test_points_are_as_many_as_the_area_and_evenly_spread() -> None:
    drawn = lines()
    cloud = dust(drawn, point_area=1e-5)
    counts = np.bincount(cloud.origin, minlength=2)  # type: ignore[arg-type]  # it has an origin
    (area,) = drawn.accuracy.select("area")
    assert np.allclose(counts, area.size() / 1e-5, atol=1)
    large = cloud.points[cloud.origin == int(np.argmax(counts))]
    grid, _, _ = np.histogram2d(large[:, 0], large[:, 1], bins=30)
    full = grid[grid > 0.8 * np.median(grid[grid > 0])]
    assert full.std() / full.mean() < 3 / np.sqrt(full.mean())  # no denser anywhere than chance makes it


def test_one_scale_for_compared_pictures() -> None:
    basic, shoulder = dust(lines("basic"), point_area=1e-4), dust(lines("shoulder"), point_area=1e-4)
    assert len(shoulder.points) / len(basic.points) == pytest.approx(0.136, abs=0.01)
    assert basic.shows[0].note == shoulder.shows[0].note == "1 point = 0.0001"


def test_the_same_seed_is_the_same_cloud() -> None:
    assert np.array_equal(dust(lines(), seed=3).points, dust(lines(), seed=3).points)
    assert not np.array_equal(dust(lines(), seed=3).points[:5], dust(lines(), seed=4).points[:5])


def test_exaggeration_moves_points_from_the_chord_and_is_told() -> None:
    near, far = dust(lines(), seed=1), dust(lines(), seed=1, exaggeration=10.0)
    assert far.shows[0].factor == 10.0
    drawn = lines()
    p, q = (drawn.points[drawn.segments()[near.origin]][:, i, :2] for i in (0, 1))
    normal = np.column_stack([-(q - p)[:, 1], (q - p)[:, 0]])
    distance = [((g.points[:, :2] - p) * normal).sum(axis=1) for g in (near, far)]
    assert np.allclose(distance[1], 10 * distance[0])


def test_the_area_goes_on_and_all_else_ends_with_a_reason() -> None:
    drawn = lines()
    cloud = dust(drawn)
    assert [t.quantity for t in cloud.accuracy.terms] == ["area"]
    assert cloud.accuracy.accounted() >= {t.id for t in drawn.accuracy.terms}
    assert cloud.accuracy.terms[0].size() == pytest.approx(drawn.accuracy.select("area")[0].size(cloud.origin))
    assert all(e.why for e in cloud.accuracy.ended.values())


def test_what_has_no_area_is_refused() -> None:
    with pytest.raises(ValueError, match="wire the lines of 'contour'"):
        dust(Geometry(points=np.zeros((2, 3)), accuracy=EXACT))
    with pytest.raises(ValueError, match="choose a larger point_area"):
        dust(lines(), point_area=1e-9)
    with pytest.raises(ValueError, match="must be positive"):
        dust(lines(), point_area=0.0)


def test_straight_lines_have_no_dust() -> None:
    straight = contour(field(np.add.outer(np.arange(4.0), np.arange(5.0))), Progress(), levels=(2.5,))
    cloud = dust(straight)
    assert len(cloud.points) == 0
    assert cloud.accuracy.terms[0].count == 0
