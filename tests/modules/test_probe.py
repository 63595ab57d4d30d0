"""A model looked at along lines, at points and over planes: values, errors, and places."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.api import Accuracy, Curvilinear, Identity, Model, Samples, Table, Term, bound, deviation
from modules.declare import record_of
from modules.modellers.interpolate import interpolate
from modules.modellers.probe import probe
from modules.modellers.smooth import smooth
from modules.progress import Progress

Floats = NDArray[np.float64]
RANDOM = np.random.default_rng(5)
VALUES = RANDOM.normal(size=(6, 7, 8))
N = VALUES.size


def model(*terms: Term, values: object = VALUES, law: str = "linear") -> Model:
    samples = Samples.from_array(np.asarray(values, float), unit="K", name="T", accuracy=Accuracy(terms))
    return interpolate(samples, law=law)  # type: ignore[arg-type]  # a word


def test_a_line_has_the_models_values_and_errors() -> None:
    field = model(deviation("noise", 0.1, N, unit="K"), bound("rounding", 0.02, N, unit="K"))
    made = probe(field, first=(0.5, 1.0, 2.0), last=(6.5, 5.0, 4.0), count=25, k=1.5)
    table = made.table
    assert list(table.columns)[:5] == ["distance", "x", "y", "z", "T"]
    at = np.column_stack([table.columns[a] for a in "xyz"])
    values, known = field.at(at)
    assert np.allclose(table.columns["T"], values)
    assert np.allclose(table.columns["total error of T"], known.total(1.5, "value"))
    assert np.allclose(table.columns["T and error"] - table.columns["T less error"], 2 * known.total(1.5, "value"))
    assert np.allclose(table.columns["noise of T"], known.terms[0].size())
    assert table.columns["distance"][-1] == pytest.approx(np.sqrt(36 + 16 + 4))
    assert table.units["T"] == table.units["noise of T"] == "K"
    assert {t.id for t in made.places.accuracy.terms} == {t.id for t in known.terms} == {t.id for t in table.accuracy.terms}
    assert len(made.places.lines) == 1
    assert np.allclose(made.places.values["T"].values, values)


def test_the_stated_error_is_that_of_draws_after_a_smoothing() -> None:
    noise = deviation("noise", 0.1, N, unit="K")
    smoothed = smooth(Samples.from_array(VALUES, unit="K", accuracy=Accuracy((noise,))), Progress())
    told = probe(interpolate(smoothed), count=12, k=1.0).table
    random, found = np.random.default_rng(2), []
    for _ in range(150):
        rough = Samples.from_array(VALUES + 0.1 * random.standard_normal(VALUES.shape), unit="K", accuracy=Accuracy())
        field = Model.between(smooth(rough, Progress()))
        found.append(field.law.weights(field.grid, probe_places(told)).apply(field.samples.values.ravel()))
    assert told.columns["noise"] == pytest.approx(np.std(found, axis=0), rel=5 / np.sqrt(300))


def probe_places(table: Table) -> Floats:
    return np.column_stack([table.columns[a] for a in "xyz"])


def test_a_point_and_a_plane() -> None:
    field = model(deviation("noise", 0.1, N, unit="K"))
    point = probe(field, shape="point", first=(1.0, 2.0, 3.0))
    assert point.table.rows == 1 and point.table.columns["T"][0] == VALUES[3, 2, 1]
    assert len(point.places.vertices) == 1
    plane = probe(field, shape="plane", first=(0.0, 0.0, 1.0), last=(7.0, 0.0, 1.0), third=(0.0, 6.0, 5.0), count=8)
    assert plane.table.rows == 64 and len(plane.places.polygons) == 49
    assert np.allclose(plane.places.points[-1], [7, 6, 5])
    assert probe(field, shape="plane").places.points[:, 2] == pytest.approx(2.5)


def test_automatic_places_lie_in_a_map_too() -> None:
    field = model(values=VALUES[0])
    made = probe(field)
    assert list(made.table.columns)[:4] == ["distance", "x", "y", "T"]
    assert np.isfinite(made.table.columns["T"]).all()


def test_vectors_have_a_column_a_component() -> None:
    n = 6 * 7 * 8 * 3
    vectors = RANDOM.normal(size=(6, 7, 8, 3))
    noise = Term(deviation("n", 1, 1).source, "linear", "value", "m/s", np.linspace(0.1, 0.2, n), Identity(n), components=3)
    field = interpolate(Samples.from_array(vectors, unit="m/s", name="u", accuracy=Accuracy((noise,))))
    made = probe(field, count=5)
    values, known = field.at(probe_places(made.table))
    for i, part in enumerate("xyz"):
        assert np.allclose(made.table.columns[f"u {part}"], values[:, i])
        assert np.allclose(made.table.columns[f"n of u {part}"], known.terms[0].error()[:, i])


def test_places_outside_have_no_value_and_are_told() -> None:
    made = probe(model(deviation("noise", 0.1, N, unit="K")), first=(-7.0, 1.0, 1.0), last=(7.0, 1.0, 1.0), count=15)
    assert np.isnan(made.table.columns["T"][:7]).all() and np.isfinite(made.table.columns["T"][7:]).all()
    assert np.isnan(made.table.columns["total error of T"][:7]).all()
    assert [len(np.asarray(f.items)) for f in made.table.accuracy.flags if f.name == "outside"] == [7]


def test_places_are_set_in_a_view() -> None:
    positions = {p.name: p.position.of for p in record_of(probe).parameters if p.position}
    assert positions == dict.fromkeys(("first", "last", "third"), "model")


def test_what_cannot_be_probed_is_refused() -> None:
    for words, sentence in (
        ({"first": (1.0,)}, "3 finite coordinates"),
        ({"first": (1.0, 1.0, 1.0), "last": (1.0, 1.0, 1.0)}, "one place"),
        ({"first": (90.0, 1.0, 1.0), "last": (91.0, 1.0, 1.0)}, "none of the 200 places"),
        ({"shape": "plane", "first": (0.0, 0, 0), "last": (1.0, 1, 1), "third": (2.0, 2, 2)}, "lie on one line"),
        ({"count": 1}, "from 2"),
    ):
        with pytest.raises(ValueError, match=sentence):
            probe(model(), **words)
    bent = Samples(grid=Curvilinear(np.random.default_rng(0).random((3, 3, 3))), values=np.zeros((3, 3)), accuracy=Accuracy())
    with pytest.raises(ValueError, match="cannot be sampled"):
        probe(Model.between(bent))
