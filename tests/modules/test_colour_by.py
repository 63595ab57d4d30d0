"""A geometry coloured by a model: values, their errors, and what errors of the places make of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modules.api import (
    Accuracy,
    Cells,
    Frame,
    Gather,
    Geometry,
    Identity,
    Model,
    Progress,
    Samples,
    Source,
    Spread,
    Term,
    bound,
    deviation,
)
from modules.mappers.colour_by import colour_by
from modules.mappers.contour import contour
from modules.mappers.isosurface import isosurface
from modules.modellers.interpolate import interpolate

RANDOM = np.random.default_rng(5)
VALUES = RANDOM.normal(size=(6, 7, 8))


def model(values: object = VALUES, *terms: Term, **words: object) -> Model:
    return interpolate(Samples.from_array(np.asarray(values, float), unit="K", accuracy=Accuracy(terms), **words))  # type: ignore[arg-type]  # any words


def cloud(points: object, *terms: Term) -> Geometry:
    p = np.asarray(points, float)
    return Geometry(points=p, vertices=Cells.of(np.arange(len(p))[:, None]), accuracy=Accuracy(terms))


PLACES = RANDOM.uniform(0.2, 4.8, (30, 3))


def placed(sigma: float, id: str = "places") -> Term:
    source = Source("Places", "data", "estimated", "made up [test/1]")
    return Term(source, "linear", "position", "", np.full(90, sigma), Identity(90), "point", 3, id=id)


def test_values_are_the_models_and_so_are_their_errors() -> None:
    field = model(VALUES, deviation("noise", 0.1, VALUES.size, unit="K"), bound("rounding", 0.2, VALUES.size, unit="K"))
    made = colour_by(cloud(PLACES), field, name="temperature")
    values, known = field.at(PLACES)
    assert np.array_equal(made.values["temperature"].values, values)
    assert made.values["temperature"].unit == "K"
    assert np.allclose(made.accuracy.total(2.0, "value"), known.total(2.0, "value"))


def test_errors_of_places_go_through_the_slope() -> None:
    sigma, draws = 1e-5, 1000
    field = model(VALUES, law := deviation("noise", 1e-5, VALUES.size, unit="K"))
    made = colour_by(cloud(PLACES, placed(sigma)), field)
    random = np.random.default_rng(1)
    found = np.empty((draws, 30))
    for k in range(draws):
        weights = field.law.weights(field.grid, PLACES + sigma * random.standard_normal((30, 3)))
        found[k] = weights.apply(VALUES.ravel() + 1e-5 * random.standard_normal(VALUES.size))
    linear = [t for t in made.accuracy.select("value") if t.kind == "linear"]
    said = np.sqrt(sum(t.size() ** 2 for t in linear))
    assert {t.id for t in linear} == {law.id, "places"}
    assert said == pytest.approx(found.std(axis=0), rel=5 / np.sqrt(2 * draws))


def test_what_places_and_values_share_is_one_error() -> None:
    """The heights of a ramp z = x that moves with its places: nothing changes."""
    size, source = np.asarray(0.1), placed(1).source
    heights = np.broadcast_to(np.arange(8.0), (6, 7, 8))
    ramp = model(heights, Term(source, "linear", "value", "K", size, Spread(336), id="common"))
    back = Gather(np.zeros((90, 1), np.int64), np.tile([-1.0, 0.0, 0.0], 30)[:, None], 1)
    made = colour_by(cloud(PLACES, Term(source, "linear", "position", "", size, back, "point", 3, id="common")), ramp)
    term = next(t for t in made.accuracy.select("value") if t.id == "common")
    assert term.size().max() < 1e-12


def test_a_distance_counts_with_the_steepest_slope() -> None:
    steep = model(np.broadcast_to(3 * np.arange(8.0), (6, 7, 8)))
    away = bound("off", 0.1, 30, quantity="position", id="off")
    made = colour_by(cloud(PLACES, away), steep)
    term = next(t for t in made.accuracy.select("value") if t.name.startswith("off"))
    assert term.size() == pytest.approx(np.full(30, 0.3))
    assert "off" in made.accuracy.accounted()


def test_an_isosurface_and_contour_lines_are_coloured() -> None:
    field = model(VALUES, deviation("noise", 0.01, VALUES.size, unit="K"))
    other = model(VALUES[::-1].copy() * 2, deviation("other", 0.02, VALUES.size, unit="K"))
    made = colour_by(isosurface(field, Progress(), level=0.1), other, name="other")
    straight = next(t for t in made.accuracy.terms if t.name == "Colours straight between points")
    assert straight.place == "cell" and straight.count == made.counts["cell"]
    at = made.points[made.triangles].mean(axis=1)
    assert straight.error() == pytest.approx(made.values["other"].values[made.triangles].mean(axis=1) - other.at(at)[0])
    flat = model(VALUES[0], deviation("noise", 0.01, 56, unit="K"))
    lines = colour_by(contour(flat, Progress(), levels=(0.2,)), flat)
    assert np.allclose(lines.values["value"].values, 0.2)
    assert any(f.name == "common source" for f in lines.accuracy.flags)


def test_a_second_colour_ends_the_errors_of_the_first() -> None:
    one, two = model(VALUES, deviation("one", 0.1, 336, unit="K")), model(VALUES, deviation("two", 0.1, 336, unit="K"))
    made = colour_by(colour_by(cloud(PLACES), one, name="one"), two, name="two")
    assert set(made.values) == {"one", "two"}
    assert next(t for t in one.accuracy.terms if t.name == "one").id in made.accuracy.ended


def test_vectors_give_their_length_and_places_outside_nothing() -> None:
    vectors = interpolate(Samples.from_array(RANDOM.normal(size=(4, 5, 6, 3)), unit="m/s", accuracy=Accuracy()))
    made = colour_by(cloud([[1.0, 1.0, 1.0], [9.0, 1.0, 1.0]]), vectors)
    values = made.values["value"].values
    assert values[0] == pytest.approx(np.linalg.norm(vectors.at([[1.0, 1.0, 1.0]])[0]))
    assert np.isnan(values[1])
    flag = next(f for f in made.accuracy.flags if f.name == "outside")
    assert list(np.asarray(flag.items)) == [1]


def test_what_cannot_be_coloured_is_refused() -> None:
    with pytest.raises(ValueError, match="none of the 1 places lies in the model"):
        colour_by(cloud([[99.0, 0, 0]]), model())
    tensors = interpolate(Samples.from_array(np.zeros((4, 4, 4, 3, 3)), accuracy=Accuracy()))
    with pytest.raises(ValueError, match="invariants"):
        colour_by(cloud(PLACES[:1]), tensors)
    with pytest.raises(ValueError, match="frames"):
        colour_by(replace(cloud(PLACES[:1]), frame=Frame(units=("m", "m", "m"))), model())
