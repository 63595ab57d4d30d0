"""One field less another: of one source there is no error, from another grid the law's own is known; units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modules.api import Accuracy, Frame, Model, Progress, Samples, Term, bound, deviation
from modules.modellers.difference import difference
from modules.modellers.interpolate import interpolate
from tests.modules.manufactured import fields

QUIET = Progress()
MAP = next(f for f in fields() if f.name == "map")


def samples(values: object, *terms: Term, unit: str = "m", **words: object) -> Samples:
    return Samples.from_array(np.asarray(values, float), unit=unit, accuracy=Accuracy(terms), **words)  # type: ignore[arg-type]


VALUES = np.random.default_rng(1).normal(size=(6, 7))


def test_a_field_less_itself_is_nothing_without_error() -> None:
    field = samples(VALUES, deviation("noise", 0.1, 42, unit="m"), bound("rounding", 0.2, 42, unit="m"))
    made = difference(field, Model.between(field), QUIET)
    assert not made.samples.values.any()
    assert made.samples.accuracy.total(2.0, "value").max() < 1e-15
    assert made.metrics.columns["value"][:5].tolist() == [0, 0, 0, 0, 0]


def test_two_sources_add_in_squares_and_metrics_are_numpys() -> None:
    other = np.random.default_rng(2).normal(size=(6, 7))
    one = samples(VALUES, deviation("a", 0.3, 42, unit="m", id="a"))
    two = samples(other, deviation("b", 0.4, 42, unit="m", id="b"))
    made = difference(one, interpolate(two), QUIET, k=1.0)
    assert np.allclose(made.samples.values, VALUES - other)
    assert made.samples.accuracy.total(1.0, "value") == pytest.approx(np.full(42, 0.5))
    off = VALUES - other
    wanted = [off.mean(), np.abs(off).mean(), np.sqrt((off**2).mean()), np.abs(off).max(), (np.abs(off) > 0.5).mean(), 42]
    assert made.metrics.columns["value"] == pytest.approx(wanted)
    assert made.metrics.columns["error"][0] == pytest.approx(0.5 / np.sqrt(42))
    assert made.metrics.columns["error"][2] == pytest.approx(0.5 / np.sqrt(42), rel=1e-9)
    j, i = np.unravel_index(np.abs(off).argmax(), off.shape)
    assert (made.metrics.columns["x"][3], made.metrics.columns["y"][3]) == (i, j)


def test_metrics_have_the_errors_of_draws() -> None:
    rough, random = MAP.samples, np.random.default_rng(4)
    n = rough.values.size
    noisy = replace(rough, accuracy=Accuracy((deviation("a", 0.02, n, unit="m"),)))
    other = Model.between(replace(rough, values=rough.values * 0.7 + 1))
    said = difference(noisy, other, QUIET, k=1.0).metrics.columns["error"]
    found = [
        difference(replace(rough, values=rough.values + 0.02 * random.standard_normal(rough.values.shape)), other, QUIET)
        .metrics.columns["value"]
        for _ in range(200)
    ]  # fmt: skip
    assert said[:3] == pytest.approx(np.std(found, axis=0)[:3], rel=5 / np.sqrt(400))


def test_from_another_grid_the_laws_error_comes_along() -> None:
    """The same field at twice as many places: what differs is the law's own error, and it is known with its sign."""
    fine_axes = [np.linspace(a[0] + 0.1, a[-1] - 0.1, 31) for a in MAP.samples.grid.axes]  # type: ignore[attr-defined]
    empty = samples(np.zeros((31, 31)), axes=fine_axes)
    fine = replace(empty, values=MAP.value(empty.grid.points()).reshape(31, 31))
    made = difference(fine, Model.between(MAP.samples), QUIET)
    own = next(t for t in made.samples.accuracy.terms if t.kind == "signed")
    error = made.samples.values.ravel()
    left = np.sqrt(np.mean((error - own.error()) ** 2)) / np.sqrt(np.mean(error**2))
    assert left < 0.5
    assert np.abs(error).max() > 1e-3


def test_beyond_the_second_there_is_a_hole_that_is_told() -> None:
    wide = samples(np.zeros((6, 20)))
    made = difference(wide, Model.between(samples(VALUES)), QUIET)
    assert np.isfinite(made.samples.values).sum() == 42
    assert any(f.name == "outside" for f in made.samples.accuracy.flags)
    assert made.metrics.columns["value"][-1] == 42


def test_units_are_brought_together() -> None:
    made = difference(samples([[2.0, 3.0]] * 2), Model.between(samples([[1.0, 1.0]] * 2, unit="km")), QUIET)
    assert made.samples.values[0, 0] == -998 and made.samples.unit == "m"
    warm = difference(samples([[2.0, 3.0]] * 2, unit="degC"), Model.between(samples([[270.0, 1.0]] * 2, unit="K")), QUIET)
    assert warm.samples.values[0, 0] == pytest.approx(5.15) and warm.samples.unit == "K"
    with pytest.raises(ValueError, match="these have no difference"):
        difference(samples([[2.0, 3.0]] * 2), Model.between(samples([[1.0, 1.0]] * 2, unit="s")), QUIET)


def test_what_does_not_fit_is_refused() -> None:
    vectors = Samples.from_array(np.zeros((6, 7, 3)), vector=True, accuracy=Accuracy())
    with pytest.raises(ValueError, match="3 numbers a sample"):
        difference(vectors, Model.between(samples(VALUES)), QUIET)
    elsewhere = samples(VALUES, frame=Frame(units=("m", "m", "m")))
    with pytest.raises(ValueError, match="frames"):
        difference(elsewhere, Model.between(samples(VALUES)), QUIET)
