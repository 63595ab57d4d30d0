"""Names beside points: every place that may be taken, in the order of choice."""

from __future__ import annotations

import numpy as np
import pytest

from modules.api import Field, Geometry, Text, bound
from modules.data.accuracy import Accuracy
from modules.mappers.cell import cell
from modules.renderers.names import AROUND, names


def shape(**values: Field) -> Geometry:
    points = np.array([[0.0, 0, 0], [10, 4, 2]])
    accuracy = Accuracy((bound("b", 1.0, 2, quantity="position"),))
    return Geometry(points=points, values=values, name="two points", accuracy=accuracy)


def text(geometry: Geometry, **words: object) -> Text:
    layer = names(geometry, **words)  # type: ignore[arg-type]  # any words
    assert isinstance(layer.shape, Text)
    assert layer.accuracy is geometry.accuracy
    assert not layer.shows
    return layer.shape


def test_each_name_has_places_all_round_its_point() -> None:
    got = text(shape(name=Field(np.array(["A", "Bé"]), "point")), apart=0.1)
    n = len(AROUND)
    assert got.words == ("A",) * n + ("Bé",) * n
    away = np.array(got.at)[n:] - [10, 4, 2]
    assert np.allclose(away[:, 2], 0)
    assert np.hypot(*away[:, :2].T) == pytest.approx(1.0, rel=0.2)  # a tenth of the width
    assert len({(round(x, 9), round(y, 9)) for x, y, _ in got.at[:n]}) == n


def test_the_side_that_has_room_comes_first() -> None:
    aside = Field(np.array([[-1.0, 0, 0], [0, -1.0, 0]]), "point")
    got = text(shape(name=Field(np.array(["A", "B"]), "point"), aside=aside))
    n = len(AROUND)
    assert got.at[0][0] < 0
    assert got.at[0][1] == 0
    assert got.at[n][1] < 4
    assert got.at[n][0] == 10


def test_numbers_are_written_with_a_real_minus() -> None:
    assert set(text(shape(height=Field(np.array([-2.5, 1e6]), "point")), by="height").words) == {"−2.5", "1e+06"}


def test_the_name_of_the_shape_stands_above_it() -> None:
    got = text(shape(), by="", apart=0.05)
    assert got.words == ("two points",)
    assert got.at[0] == pytest.approx((5, 4 + 1, 2))


def test_points_close_together_are_measured_by_their_cell() -> None:
    got = text(cell(named="S C").points, apart=0.03)
    at = np.array(got.at)[: len(AROUND), :2]
    assert np.hypot(*(at - at.mean(axis=0)).T).min() > 0.02


def test_values_that_are_not_there_are_told() -> None:
    with pytest.raises(ValueError, match="no values 'name' to write; there are none"):
        names(shape())
