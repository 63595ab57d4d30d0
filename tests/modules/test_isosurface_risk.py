"""Risks of an isosurface: probabilities to first order against draws."""

from typing import Any

import numpy as np
import pytest

from modules.accuracy_mappers.isosurface_risk import isosurface_risk
from modules.api import EXACT, Model, Samples, deviation
from modules.data.accuracy import Accuracy
from modules.kernels import cell_types
from modules.readers.corner_cell import CELLS

NOISE = 0.05


def model_of(values: Any, noise: float = NOISE) -> Any:
    accuracy = Accuracy((deviation("Noise", noise, np.size(values)),))
    return Model.between(Samples.from_array(values, accuracy=accuracy))


def cell(corners: Any) -> Any:
    return np.ascontiguousarray(np.array(corners, float).reshape(2, 2, 2).transpose(2, 1, 0))


def draws(values: Any, count: int, noise: float = NOISE) -> Any:
    random = np.random.default_rng(5)
    for _ in range(count):
        yield values + noise * random.normal(size=values.shape)


def test_faces_flip_as_often_as_draws_say() -> None:
    values = np.random.default_rng(2).normal(size=(5, 5, 5))
    found = isosurface_risk(model_of(values), level=0.0, least=0.0).places
    faces = cell_types.cells(values, 0.0)
    chance = dict(zip(found.values["grid cell"].values.tolist(), found.values["probability"].values.tolist(), strict=False))
    single = np.flatnonzero(faces.ambiguous == 1)
    wrong = {int(faces.active.cell[n]): 0 for n in single}
    for drawn in draws(values, 400):
        other = cell_types.cells(drawn, 0.0)
        known = dict(zip(other.active.cell.tolist(), zip(other.active.code, other.faces, strict=True), strict=True))
        for n in single:
            code, joins = known.get(int(faces.active.cell[n]), (0, 0))
            wrong[int(faces.active.cell[n])] += code == faces.active.code[n] and joins != faces.faces[n]
    told = [(chance[c], w / 400) for c, w in wrong.items() if c in chance]
    assert len(told) > 10
    assert np.abs(np.subtract(*np.array(told).T)).mean() < 0.03


def test_a_tunnel_that_may_close() -> None:
    low, high = np.array(CELLS["4.29 a"]), np.array(CELLS["4.29 b"])  # corner 111 from 5 to 15 opens it
    ends = [0.0, 1.0]
    for _ in range(40):
        middle = sum(ends) / 2
        open_here = cell_types.cells(cell((1 - middle) * low + middle * high), 0.0).tunnel.any()
        ends[1 if open_here else 0] = middle
    values = cell((1 - ends[1]) * low + ends[1] * high + np.array([0, 0, 0, 0, 0, 0, 0, 0.2]))
    found = isosurface_risk(model_of(values), level=0.0, show="tunnels", least=0.0).places
    (chance,) = found.values["probability"].values
    closed = np.mean([not cell_types.cells(drawn, 0.0).tunnel.any() for drawn in draws(values, 2000)])
    assert 0.02 < chance < 0.5
    assert chance == pytest.approx(closed, abs=0.03)


def test_the_probability_that_the_level_passes_a_flat_cell() -> None:
    values = np.full((4, 4, 4), 0.06)
    found = isosurface_risk(model_of(values), level=0.0, show="crossing", least=0.0).places
    assert len(found.points) == 27
    passed = np.mean([(d < 0).any() and (d >= 0).any() for d in (drawn[:2, :2, :2] for drawn in draws(values, 2000))])
    assert found.values["probability"].values[0] == pytest.approx(passed, abs=0.03)


def test_a_steep_cell_has_a_band_and_is_left_out() -> None:
    x = np.arange(5.0)
    values = np.broadcast_to(x - 1.5, (5, 5, 5)).copy()
    assert not len(isosurface_risk(model_of(values), level=0.0, show="crossing", least=0.01).places.points)


def test_table_and_budget() -> None:
    model = model_of(np.random.default_rng(2).normal(size=(5, 5, 5)))
    found = isosurface_risk(model, level=0.0, least=0.01)
    assert found.table.columns["kind"].tolist() == ["faces", "tunnels", "crossing"]
    assert found.table.columns["places"][0] == len(found.places.points) > 0
    assert (found.table.columns["expected"] <= found.table.columns["places"]).all()
    for one in (found.places, found.table):
        assert model.accuracy.accounted() <= one.accuracy.accounted()


def test_without_random_errors_there_is_no_probability() -> None:
    with pytest.raises(ValueError, match="random errors"):
        isosurface_risk(Model.between(Samples.from_array(np.zeros((3, 3, 3)), accuracy=EXACT)))
    with pytest.raises(ValueError, match="3 dimensions"):
        isosurface_risk(model_of(np.zeros((3, 3))))


def test_a_level_beside_the_field() -> None:
    found = isosurface_risk(model_of(np.random.default_rng(2).normal(size=(4, 4, 4))), level=99.0)
    assert found.table.columns["places"].tolist() == [0, 0, 0]
