"""The elevation surface: heights, faces, holes, and the bound of its two triangles a cell."""

from __future__ import annotations

import numpy as np
import pytest

from modules.api import EXACT, Frame, Missing, Model, Samples, bound, deviation
from modules.mappers.elevation import elevation
from modules.modellers.interpolate import interpolate

VALUES = np.random.default_rng(0).normal(size=(5, 6))


def test_heights_and_faces() -> None:
    shape = elevation(interpolate(Samples.from_array(VALUES, spacing=(1, 3), name="h", accuracy=EXACT)), scale=2.0)
    assert np.allclose(shape.points[:, 2].reshape(5, 6), 2 * VALUES)
    assert shape.points[6].tolist()[:2] == [0, 3]
    assert shape.counts["cell"] == 20
    p = shape.points[shape.triangles]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (normal[:, 2] > 0).all()
    assert normal[:, 2].sum() / 2 == pytest.approx(5 * 12)
    assert shape.values["h"].values.shape == (30,)


def test_an_error_lifts_by_the_scale_and_missing_stays() -> None:
    model = interpolate(Samples.from_array(VALUES, accuracy=EXACT.add(bound("b", 0.5, 30)).miss(Missing("survey"))))
    shape = elevation(model, scale=2.0)
    sizes = {t.name: t.size() for t in shape.accuracy.terms}
    assert np.allclose(sizes["b"], 1.0)
    assert model.own is not None
    assert np.allclose(sizes["Interpolation between samples"], 2 * model.own.size())
    assert shape.accuracy.missing == (Missing("survey"),)
    assert shape.accuracy.accounted() >= {t.id for t in model.accuracy.terms}


def test_two_triangles_never_leave_the_bilinear_surface_by_more_than_the_bound() -> None:
    model = interpolate(Samples.from_array(VALUES, accuracy=EXACT))
    shape = elevation(model, scale=1.0)
    (twist,) = [t for t in shape.accuracy.terms if t.name == "Two triangles a cell"]
    random = np.random.default_rng(1)
    triangles = shape.triangles
    weights = random.dirichlet([1, 1, 1], (len(triangles), 200))
    inside = np.einsum("tsc,tcd->tsd", weights, shape.points[triangles])
    truth = model.at(inside.reshape(-1, 3) * [1, 1, 0])[0].reshape(inside.shape[:2])
    reach = np.abs(inside[:, :, 2] - truth).max(axis=1).reshape(-1, 2).max(axis=1)
    assert (reach <= twist.size() + 1e-12).all()
    assert (reach > 0.8 * twist.size()).mean() > 0.9


def test_holes_leave_holes() -> None:
    values = VALUES.copy()
    values[2, 2] = np.nan
    shape = elevation(interpolate(Samples.from_array(values, accuracy=EXACT)))
    assert shape.counts["point"] == 29
    assert shape.counts["cell"] == 16
    assert np.isfinite(shape.points).all()


def test_volumes_are_refused() -> None:
    with pytest.raises(ValueError, match="two-dimensional"):
        elevation(interpolate(Samples.from_array(np.zeros((3, 3, 3)), accuracy=EXACT)))


def other(**words: object) -> Model:
    """A field of another grid over the same plane."""
    y, x = np.mgrid[0:9, 0:11] * 1.0
    words = {"name": "slope", "unit": "deg", "accuracy": EXACT.add(deviation("angle", 0.2, 99, unit="deg")), **words}
    return interpolate(Samples.from_array(x + 10 * y, spacing=(0.5, 0.5), **words))  # type: ignore[arg-type]  # any words


def test_another_field_gives_values_by_its_name_and_its_errors() -> None:
    accuracy = EXACT.add(bound("b", 0.5, 30))
    model = interpolate(Samples.from_array(VALUES, name="h", unit="m", accuracy=accuracy))
    colour = other()
    shape = elevation(model, colour, scale=3.0)
    assert set(shape.values) == {"h", "slope"}
    assert shape.values["slope"].unit == "deg"
    x, y = shape.points[:, 0], shape.points[:, 1]
    assert np.allclose(shape.values["slope"].values, 2 * x + 20 * y)
    kinds = {(t.name, t.quantity): t for t in shape.accuracy.terms}
    assert np.allclose(kinds["angle", "value"].size(), 0.2)  # at a sample of its own grid
    assert np.allclose(kinds["b", "position"].size(), 1.5)
    assert kinds["angle", "value"].unit == "deg"
    assert {t.id for t in (*model.accuracy.terms, *colour.accuracy.terms)} <= shape.accuracy.accounted()
    assert np.array_equal(shape.points, elevation(model, scale=3.0).points)


def test_a_field_of_the_same_data_is_known_as_the_same_source() -> None:
    model = interpolate(Samples.from_array(VALUES, name="h", accuracy=EXACT.add(bound("b", 0.5, 30)).miss(Missing("survey"))))
    shape = elevation(model, model)
    assert set(shape.values) == {"h", "h (colour)"}
    assert np.array_equal(shape.values["h"].values, shape.values["h (colour)"].values)
    assert [t.quantity for t in shape.accuracy.terms if t.name == "b"] == ["position", "value"]
    assert len({t.id for t in shape.accuracy.terms if t.name == "b"}) == 1
    assert shape.accuracy.missing == (Missing("survey"),)


def test_another_field_must_cover_the_plane() -> None:
    model = interpolate(Samples.from_array(VALUES, spacing=(2, 2), accuracy=EXACT))
    with pytest.raises(ValueError, match="outside the grid"):
        elevation(model, other())
    with pytest.raises(ValueError, match="another frame"):
        elevation(model, other(frame=Frame(units=("m", "m", "m"))))
    with pytest.raises(ValueError, match="take a slice"):
        elevation(model, interpolate(Samples.from_array(np.zeros((2, 20, 20)), accuracy=EXACT)))
