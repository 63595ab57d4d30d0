"""Each modeller by itself, judged by something else: closed forms, scipy, numpy, counting; and chains of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from modules.api import EXACT, Accuracy, Curvilinear, Frame, Model, Progress, Rectilinear, Regular, Samples, bound, deviation
from modules.modellers.add_noise import add_noise
from modules.modellers.crop import crop
from modules.modellers.curl import curl
from modules.modellers.divergence import divergence
from modules.modellers.gradient import gradient
from modules.modellers.interpolate import interpolate
from modules.modellers.invariants import invariants
from modules.modellers.median import median
from modules.modellers.moving_average import moving_average
from modules.modellers.quantise import quantise
from modules.modellers.resample import resample
from modules.modellers.slice import slice as plane_of
from modules.modellers.slope import slope
from modules.modellers.smooth import smooth
from modules.modellers.subsample import subsample
from modules.modellers.threshold import threshold
from modules.modellers.transform import transform
from modules.progress import Cancelled, Stop
from tests.modules.manufactured import fields

Floats = NDArray[np.float64]
QUIET = Progress()
MAP, VOLUME, VECTORS, TENSORS = (
    next(f for f in fields() if f.name == name)
    for name in ("uneven map", "uneven volume", "vectors in a volume", "tensors in a volume")
)


def noisy(samples: Samples, sigma: float = 0.1) -> Samples:
    n, c = samples.values.size, samples.components
    sizes = sigma * np.linspace(0.5, 1.5, n)
    term = replace(deviation("noise", sizes, n, unit=samples.unit, id="noise"), components=c)
    return replace(samples, accuracy=Accuracy((term,)))


# --- chains ------------------------------------------------------------------------------------------------------

Step = Callable[[Samples], Samples]


def onto_fewer(samples: Samples) -> Samples:
    axes = samples.grid.axes  # type: ignore[attr-defined]  # chains are of regular and rectilinear grids
    low, high = (tuple(float(a[0] * (1 - t) + a[-1] * t) for a in axes) for t in (0.07, 0.93))
    return resample(interpolate(samples), QUIET, low=low, high=high, samples=tuple(max(2, len(a) - 1) for a in axes))


def a_plane(samples: Samples) -> Samples:
    axis = samples.grid.axes[0]  # type: ignore[attr-defined]
    return plane_of(samples, QUIET, axis="x", position=float(axis[1] * 0.7 + axis[2] * 0.3))


def inner(samples: Samples) -> Samples:
    axes = samples.grid.axes  # type: ignore[attr-defined]
    return crop(samples, low=tuple(float(a[min(1, len(a) - 1)]) for a in axes))


STEPS: dict[str, Step] = {
    "smooth": lambda s: smooth(s, QUIET),
    "gaussian": lambda s: smooth(s, QUIET, kernel="gaussian", axis="x"),
    "average": lambda s: moving_average(s, QUIET, size=3),
    "gradient": gradient,
    "divergence": divergence,
    "curl": curl,
    "resample": onto_fewer,
    "slice": a_plane,
    "crop": inner,
    "means": lambda s: subsample(s, stride=(2,), method="mean"),
    "transform": lambda s: transform(s, scale=(-2.0, 1.0, 3.0), factor=-0.5, offset=3.0),
}


def chained(samples: Samples, names: list[str]) -> Samples | None:
    for name in names:
        try:
            samples = STEPS[name](samples)
        except ValueError:
            return None
    return samples


@settings(max_examples=30, derandomize=True, deadline=None)
@given(st.lists(st.sampled_from(sorted(STEPS)), min_size=3, max_size=3), st.booleans())
def test_any_chain_of_three_linear_modellers_has_the_very_errors_that_it_states(names: list[str], vectors: bool) -> None:
    before = noisy((VECTORS if vectors else VOLUME).samples)
    after = chained(before, names)
    if after is None:
        return
    term = next(t for t in after.accuracy.terms if t.id == "noise")
    made = np.random.default_rng(5).normal(size=before.values.size) * before.accuracy.terms[0].value
    moved = chained(replace(before, values=before.values + made.reshape(before.values.shape), accuracy=EXACT), names)
    assert moved is not None
    out = (moved.values - after.values).ravel()
    said = term.operator.apply(made)
    np.testing.assert_allclose(said, out, atol=1e-11 * max(1.0, float(np.abs(said).max())))
    rows = np.unique(np.random.default_rng(1).integers(0, len(said), 50))
    weights = term.operator.rows(rows).toarray()
    size = term.error().ravel()[rows]
    np.testing.assert_allclose(size, np.sqrt(weights**2 @ before.accuracy.terms[0].value ** 2), rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("names", [["smooth", "gradient", "slice"], ["means", "gradient", "divergence"]], ids="-".join)
def test_a_chain_of_three_is_within_the_sampling_error_of_monte_carlo(names: list[str]) -> None:
    before = noisy(VOLUME.samples)
    after, draws = chained(before, names), 120
    assert after is not None
    random = np.random.default_rng(6)
    total = np.zeros(after.values.shape)
    for _ in range(draws):
        made = random.normal(size=before.values.size) * before.accuracy.terms[0].value
        out = chained(replace(before, values=before.values + made.reshape(before.values.shape), accuracy=EXACT), names)
        assert out is not None
        total += (out.values - after.values) ** 2
    ratio = np.sqrt(total / draws).ravel() / next(t for t in after.accuracy.terms if t.id == "noise").error().ravel()
    ratio = ratio[np.isfinite(ratio)]
    assert abs(np.mean(ratio**2) - 1) < 0.06
    assert np.quantile(np.abs(ratio - 1), 0.999) < 4 / np.sqrt(2 * draws)


def test_a_difference_of_a_field_and_itself_has_no_error() -> None:
    before = noisy(MAP.samples)
    one, two = smooth(before, QUIET, axis="x"), smooth(before, QUIET, axis="x")
    joined = Accuracy.join([(one.accuracy, None), (transform(two, factor=-1.0).accuracy, None)])
    assert next(t for t in joined.terms if t.id == "noise").error().max() == 0


# --- the error between samples -----------------------------------------------------------------------------------


def waves(samples_a_period: float, noise: float = 0.0) -> tuple[Samples, Callable[[Floats], Floats]]:
    numbers = 2 * np.pi / samples_a_period * np.array([[1, 0.3, 0.2], [-0.2, 1, 0.4], [0.3, -0.4, 1]]) / 1.1

    def truth(points: Floats) -> Floats:
        return np.asarray(np.sin(points @ numbers.T + [0.3, 1.1, 2.0]).sum(axis=1))

    shape = (17, 18, 19)
    empty = Samples.from_array(np.zeros(shape), accuracy=EXACT)
    values = truth(empty.grid.points()).reshape(shape)
    accuracy = EXACT
    if noise:
        values = values + noise * np.random.default_rng(3).normal(size=shape)
        accuracy = Accuracy((deviation("noise", noise, values.size),))
    return replace(empty, values=values, accuracy=accuracy), truth


@pytest.mark.parametrize("a_period", [6, 8, 12, 24])
def test_the_signed_estimate_leaves_a_quarter_of_the_trilinear_error(a_period: float) -> None:
    samples, truth = waves(a_period)
    points = np.random.default_rng(4).uniform(0, 1, (4000, 3)) * (np.array([19, 18, 17]) - 1)
    values, accuracy = interpolate(samples).at(points)
    error = values - truth(points)
    left = error - accuracy.terms[-1].error()
    assert np.sqrt(np.mean(left**2)) <= 0.25 * np.sqrt(np.mean(error**2))


def test_the_largest_of_a_cell_covers_the_error_between_samples() -> None:
    samples, truth = waves(8)
    model = interpolate(samples)
    points = np.random.default_rng(4).uniform(0, 1, (4000, 3)) * (np.array([19, 18, 17]) - 1)
    values, _ = model.at(points)
    cell = points.astype(int)
    assert model.own is not None
    said = model.own.size()[np.ravel_multi_index(tuple(cell.T[::-1]), (16, 17, 18))]
    assert np.mean(np.abs(values - truth(points)) <= said) > 0.98


@pytest.mark.parametrize(("noise", "least", "most"), [(1e-6, 0.0, 0.01), (1.0, 0.95, 1.0)])
def test_in_noise_the_estimate_declines_to_answer(noise: float, least: float, most: float) -> None:
    model = interpolate(waves(12, noise)[0])
    flagged = sum(f.count for f in model.accuracy.flags if f.name == "not resolvable")
    assert least <= flagged / model.grid.cells <= most
    again = resample(model, QUIET, samples=(9, 9, 9))
    flagged = sum(f.count for f in again.accuracy.flags if f.name == "not resolvable")
    assert least <= flagged / again.grid.count <= most


@pytest.mark.parametrize("step", ["smooth", "average", "gradient", "means"])
def test_steps_decline_as_well(step: str) -> None:
    for noise, low, high in ((1e-9, 0.0, 0.02), (1.0, 0.8, 1.0)):
        after = STEPS[step](waves(12, noise)[0])
        flagged = sum(f.count for f in after.accuracy.flags if f.name == "not resolvable")
        assert low <= flagged / after.grid.count <= high


# --- one by one --------------------------------------------------------------------------------------------------


def test_smoothing_keeps_planes_and_is_scipys_inside() -> None:
    x, y = np.cumsum(np.linspace(0.3, 1, 14)), np.cumsum(np.linspace(1, 0.2, 11))
    plane = Samples.from_array(2 * x - 3 * y[:, None] + 1, axes=(x, y), accuracy=EXACT)
    for after in (
        smooth(plane, QUIET, passes=3),
        smooth(plane, QUIET, kernel="gaussian", width=1.1),
        moving_average(plane, QUIET, size=7),
    ):
        np.testing.assert_allclose(after.values, plane.values, atol=1e-12)
        assert np.abs(after.accuracy.terms[-1].error()).max() < 1e-12
    rough = Samples.from_array(np.random.default_rng(0).normal(size=(30, 40)), accuracy=EXACT)
    inside = (slice(5, -5), slice(5, -5))
    theirs = ndimage.gaussian_filter(rough.values, 1.0, truncate=4.0)
    np.testing.assert_allclose(smooth(rough, QUIET, kernel="gaussian").values[inside], theirs[inside], atol=1e-12)
    theirs = ndimage.uniform_filter(rough.values, 5)
    np.testing.assert_allclose(moving_average(rough, QUIET, size=5).values[inside], theirs[inside], atol=1e-12)


def test_a_hole_makes_its_neighbours_holes() -> None:
    values = np.ones((9, 9))
    values[4, 4] = np.nan
    samples = Samples.from_array(values, accuracy=EXACT)
    for after in (smooth(samples, QUIET), median(samples, QUIET), gradient(samples)):
        lost = np.asarray(np.isnan(after.values).reshape(9, 9, -1).any(axis=2))
        assert lost[3:6, 3:6].sum() >= 5 and not lost[:2].any() and not lost[-2:].any()


def test_gradient_is_that_of_numpy_inside_and_in_the_right_unit() -> None:
    frame = Frame(units=("km",) * 3)
    samples = Samples.from_array(MAP.samples.values, axes=MAP.samples.grid.axes, unit="m", accuracy=EXACT, frame=frame)  # type: ignore[attr-defined]
    x, y = samples.grid.axes  # type: ignore[attr-defined]
    theirs = np.gradient(samples.values, y, x)
    np.testing.assert_allclose(gradient(samples).values[1:-1, 1:-1, 0], theirs[1][1:-1, 1:-1], rtol=1e-12)
    np.testing.assert_allclose(gradient(samples).values[1:-1, 1:-1, 1], theirs[0][1:-1, 1:-1], rtol=1e-12)
    assert gradient(samples).unit == "m/km"
    speed = replace(VECTORS.samples, unit="m/s", grid=replace(VECTORS.samples.grid, frame=Frame(units=("m",) * 3)))
    assert (curl(speed).unit, divergence(speed).unit) == ("1/s", "1/s")


def test_identities_of_vector_calculus_hold_to_rounding() -> None:
    assert np.abs(curl(gradient(VOLUME.samples)).values).max() < 1e-12
    assert np.abs(divergence(curl(VECTORS.samples)).values).max() < 1e-12
    trace = invariants(gradient(VECTORS.samples), measure="trace")
    np.testing.assert_allclose(trace.values, divergence(VECTORS.samples).values, atol=1e-13)


def test_a_common_error_has_no_part_in_a_derivative() -> None:
    from modules.modellers.state_accuracy import state_accuracy

    offset = state_accuracy(replace(MAP.samples, accuracy=EXACT), amount=3.0, correlation="common")
    assert gradient(offset).accuracy.terms[0].error().max() < 1e-12
    assert slope(offset).accuracy.terms[0].error().max() < 1e-10


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_slice_at_a_sample_is_those_samples(axis: Any) -> None:
    grid = TENSORS.samples.grid
    assert isinstance(grid, Regular)
    held = "xyz".index(axis)
    position = float(grid.axes[held][3])
    got = plane_of(TENSORS.samples, QUIET, axis=axis, position=position)
    order = [a for a in range(3) if a != held] + [held]
    wanted = np.take(TENSORS.samples.values, [3], 2 - held).squeeze(2 - held)[..., order, :][..., order]
    np.testing.assert_array_equal(got.values, wanted)
    assert not got.accuracy.terms and isinstance(got.grid, Regular)
    assert got.grid.spacing == tuple(grid.spacing[a] for a in order[:2])
    assert got.grid.frame.axes == tuple("xyz"[a] for a in order)
    assert got.grid.frame.handed == ("left" if axis == "y" else "right")


def test_a_slice_of_a_map_is_a_line() -> None:
    line = plane_of(MAP.samples, QUIET, axis="y", position=1.0)
    points = np.column_stack([line.grid.points()[:, 0], np.ones(line.grid.count), np.zeros(line.grid.count)])
    model = interpolate(MAP.samples)
    values, accuracy = model.at(points)
    np.testing.assert_allclose(line.values, values, atol=1e-13)
    np.testing.assert_allclose(line.accuracy.terms[-1].error(), accuracy.terms[-1].error(), atol=1e-13)


def test_resampling_is_the_model_at_the_samples() -> None:
    for law in ("linear", "nearest", "cubic"):
        model = interpolate(noisy(VECTORS.samples), law=law)
        got = resample(model, QUIET, samples=(5, 6, 7))
        values, accuracy = model.at(got.grid.points())
        np.testing.assert_allclose(got.values.reshape(-1, 3), values, atol=1e-13)
        for mine, theirs in zip(got.accuracy.terms, accuracy.terms, strict=True):
            assert mine.id == theirs.id
            np.testing.assert_allclose(mine.error(), theirs.error(), atol=1e-12)


def test_resampling_onto_other_data_takes_its_grid_only() -> None:
    nodes = np.stack(np.meshgrid([0.5, 1.0, 2.0], [0.4, 1.1], indexing="xy"), axis=-1)
    nodes = np.concatenate([nodes, np.zeros((2, 3, 1))], axis=-1)
    other = Samples(grid=Curvilinear(nodes), values=np.zeros((2, 3)), accuracy=EXACT)
    got = resample(interpolate(MAP.samples), QUIET, other)
    np.testing.assert_allclose(got.values.ravel(), interpolate(MAP.samples).at(nodes.reshape(-1, 3))[0], atol=1e-14)
    with pytest.raises(ValueError, match="crop it first"):
        resample(interpolate(MAP.samples), QUIET, Samples.from_array(np.zeros((30, 40)), accuracy=EXACT))


def test_crop_and_subsample_keep_places_and_values() -> None:
    samples = Samples.from_array(np.arange(63.0).reshape(7, 9), spacing=(0.5, 2.0), origin=(1.0, -3.0), accuracy=EXACT)
    box = crop(samples, low=(1.5, -1.0), high=(3.0, 6.0))
    np.testing.assert_array_equal(box.values, samples.values[1:5, 1:5])
    assert isinstance(box.grid, Regular) and box.grid.origin == (1.5, -1.0) and box.grid.spacing == (0.5, 2.0)
    few = subsample(samples, stride=(4, 3))
    np.testing.assert_array_equal(few.values, samples.values[::3, ::4])
    assert few.grid.bounds[:4] == (1.0, 5.0, -3.0, 9.0)
    means = subsample(samples, stride=(2, 3), method="mean")
    np.testing.assert_allclose(means.values, samples.values[:6, :8].reshape(2, 3, 4, 2).mean(axis=(1, 3)))
    assert means.grid.bounds[:4] == (1.25, 4.25, -1.0, 5.0)


def test_transform_brings_units_and_turns_axes() -> None:
    frame = Frame(units=("m",) * 3)
    samples = Samples.from_array(np.arange(12.0).reshape(3, 4), spacing=500, unit="ft", accuracy=EXACT, frame=frame)
    got = transform(noisy(samples), lengths="km", unit="m", offset=1.0)
    assert got.grid.bounds[:4] == (0.0, 1.5, 0.0, 1.0) and got.grid.frame.units == ("km",) * 3
    np.testing.assert_allclose(got.values, samples.values * 0.3048 + 1)
    np.testing.assert_allclose(got.accuracy.terms[0].error(), 0.3048 * noisy(samples).accuracy.terms[0].error())
    vectors = Samples.from_array(np.random.default_rng(0).normal(size=(3, 4, 3)), vector=True, accuracy=EXACT)
    turned = transform(vectors, scale=(-2.0, 1.0))
    np.testing.assert_array_equal(turned.values, vectors.values[:, ::-1] * [-1, 1, 1])
    assert turned.grid.bounds[:2] == (-6.0, 0.0)
    warm = transform(Samples.from_array(np.array([25.0, 0.0]), unit="degC", accuracy=EXACT), unit="K")
    np.testing.assert_allclose(warm.values, [298.15, 273.15])


def test_invariants_are_numpys() -> None:
    tensors = TENSORS.samples.values
    symmetric = (tensors + tensors.swapaxes(-1, -2)) / 2
    eigen = np.linalg.eigvalsh(symmetric)
    a, b, c = eigen[..., 0], eigen[..., 1], eigen[..., 2]
    turning = (tensors - tensors.swapaxes(-1, -2)) / 2
    wanted = {
        "trace": np.trace(tensors, axis1=-2, axis2=-1),
        "determinant": np.linalg.det(tensors),
        "norm": np.linalg.norm(tensors, axis=(-2, -1)),
        "largest shear": (c - a) / 2,
        "von Mises": np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) / 2),
        "smallest eigenvalue": a,
        "middle eigenvalue": b,
        "largest eigenvalue": c,
        "second invariant": (np.trace(tensors, axis1=-2, axis2=-1) ** 2 - np.trace(tensors @ tensors, axis1=-2, axis2=-1)) / 2,
    }
    for measure, values in wanted.items():
        np.testing.assert_allclose(invariants(TENSORS.samples, measure=measure).values, values, rtol=1e-9)  # type: ignore[arg-type]
    free = TENSORS.samples.values - np.trace(tensors, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)
    sym, anti = (free + free.swapaxes(-1, -2)) / 2, turning
    q = 0.5 * ((anti**2).sum(axis=(-2, -1)) - (sym**2).sum(axis=(-2, -1)))
    got = invariants(replace(TENSORS.samples, values=free), measure="Q criterion")
    np.testing.assert_allclose(got.values, q, atol=1e-9)
    assert got.unit == "m²"


def test_where_a_length_bends_it_is_flagged_and_elsewhere_counted_right() -> None:
    random = np.random.default_rng(2)
    vectors = Samples.from_array(random.normal(size=(12, 13, 3)), vector=True, accuracy=EXACT)
    sigma = 0.15
    term = replace(deviation("noise", sigma, vectors.values.size), components=3)
    after = invariants(replace(vectors, accuracy=Accuracy((term,))))
    flagged = np.zeros(after.grid.count, bool)
    for flag in after.accuracy.flags:
        flagged[flag.items] = True
    assert 0.02 < flagged.mean() < 0.5
    draws = vectors.values[None] + sigma * random.normal(size=(2000, *vectors.values.shape))
    counted = np.linalg.norm(draws, axis=-1).std(axis=0).ravel()
    said = after.accuracy.terms[0].error()
    np.testing.assert_allclose(counted[~flagged], said[~flagged], rtol=0.1)
    assert np.abs(counted - said)[flagged].max() > 2 * np.abs(counted - said)[~flagged].max()


def test_slope_of_a_plane_is_known() -> None:
    x, y = np.arange(8) * 10.0, np.cumsum(np.linspace(5, 12, 7))
    plane = Samples.from_array(0.3 * x - 0.4 * y[:, None], axes=(x, y), accuracy=EXACT)
    for method in ("differences", "horn"):
        np.testing.assert_allclose(slope(plane, method=method).values, np.degrees(np.arctan(0.5)), rtol=1e-9)
        np.testing.assert_allclose(slope(plane, measure="aspect", method=method).values, 323.13010235, rtol=1e-9)
    assert slope(plane, measure="grade", scale=2.0).values == pytest.approx(np.full((7, 8), 1.0))
    level = slope(Samples.from_array(np.zeros((5, 6)), accuracy=EXACT), measure="aspect")
    assert np.isnan(level.values).all()


def test_aspect_of_nearly_level_ground_is_flagged() -> None:
    x = np.arange(9.0)
    ground = Samples.from_array(0.01 * x + np.zeros((7, 1)), accuracy=Accuracy((deviation("noise", 0.1, 63),)))
    assert sum(f.count for f in slope(ground, measure="aspect").accuracy.flags if f.name == "not linear") == 63


def test_a_median_takes_out_what_stands_alone_and_keeps_edges() -> None:
    step = np.where(np.arange(40) < 20, 0.0, 5.0) * np.ones((30, 1))
    spoilt = step.copy()
    spoilt[7, 9], spoilt[20, 30] = 99, -99
    got = median(Samples.from_array(spoilt, accuracy=EXACT), QUIET)
    np.testing.assert_array_equal(got.values, step)
    np.testing.assert_array_equal(got.values, ndimage.median_filter(spoilt, 3, mode="nearest"))
    assert got.accuracy.missing


def test_a_median_of_noise_is_flagged_and_never_worse_than_stated() -> None:
    random = np.random.default_rng(4)
    flat = Samples.from_array(random.normal(size=(15, 16)), accuracy=Accuracy((deviation("noise", 1.0, 240),)))
    got = median(flat, QUIET)
    assert sum(f.count for f in got.accuracy.flags if f.name == "not linear") == 240
    counted = np.std([ndimage.median_filter(random.normal(size=(15, 16)), 3) for _ in range(300)], axis=0)
    assert (counted.ravel() < got.accuracy.terms[0].error()).all()


def test_a_threshold_says_which_decisions_are_at_risk() -> None:
    x = np.linspace(0, 1, 101)
    samples = Samples.from_array(x, accuracy=Accuracy((deviation("noise", 0.0201, 101),)))
    got = threshold(samples, low=0.5)
    assert np.isnan(got.values[:50]).all() and not np.isnan(got.values[50:]).any()
    (flag,) = got.accuracy.flags
    np.testing.assert_array_equal(flag.items, np.arange(46, 55))
    masked = threshold(Samples.from_array(x + 7, accuracy=EXACT), samples, high=0.5, keep="outside")
    np.testing.assert_array_equal(np.isnan(masked.values), x <= 0.5)
    assert samples.accuracy.terms[0].id in masked.accuracy.ended
    kept = threshold(samples, Samples.from_array((x > 0.3).astype(float), accuracy=EXACT))
    np.testing.assert_array_equal(np.isnan(kept.values), x <= 0.3)


def test_added_noise_is_of_the_size_that_it_states() -> None:
    vectors = replace(VECTORS.samples, accuracy=EXACT)
    for correlation in ("independent", "common"):
        runs = [add_noise(vectors, amount=0.3, correlation=correlation, seed=s) for s in range(200)]
        counted = np.std([r.values - vectors.values for r in runs], axis=0)
        np.testing.assert_allclose(counted.ravel(), runs[0].accuracy.terms[0].error().ravel(), rtol=0.25)
        assert abs(counted.mean() - 0.3) < 0.03
    even = add_noise(vectors, amount=0.3, kind="even")
    assert np.abs(even.values - vectors.values).max() <= even.accuracy.terms[0].error().max() == 0.3
    np.testing.assert_array_equal(even.values, add_noise(vectors, amount=0.3, kind="even").values)


def test_rounding_is_within_its_bound_whatever_the_step() -> None:
    for more in ({"step": 0.3}, {"bits": 3}, {"bits": 16}):
        got = quantise(VOLUME.samples, **more)
        assert (np.abs(got.values - VOLUME.samples.values) <= got.accuracy.terms[-1].error().max()).all()
    assert len(np.unique(quantise(VOLUME.samples, bits=3).values)) <= 8
    constant = quantise(Samples.from_array(np.full((3, 4), 7.7), accuracy=EXACT))
    np.testing.assert_array_equal(constant.values, 7.7)


# --- refused, cancelled ------------------------------------------------------------------------------------------

BENT = Samples(grid=Curvilinear(np.random.default_rng(0).normal(size=(4, 5, 3))), values=np.zeros((4, 5)), accuracy=EXACT)
ONE_LAYER = Samples.from_array(np.zeros((1, 5, 6)), accuracy=EXACT)
DEGREES = Samples.from_array(np.zeros((5, 6)), accuracy=EXACT, frame=Frame(units=("degree", "m", "m")))


@pytest.mark.parametrize(("call", "sentence"), [
    (lambda: smooth(BENT, QUIET), "needs a regular or rectilinear grid"),
    (lambda: smooth(MAP.samples, QUIET, axis="z"), "no axis z"),
    (lambda: smooth(MAP.samples, QUIET, kernel="gaussian", width=0.0), "more than 0"),
    (lambda: moving_average(MAP.samples, QUIET, size=4), "odd number"),
    (lambda: gradient(ONE_LAYER), "single sample"),
    (lambda: gradient(DEGREES), "different units"),
    (lambda: gradient(TENSORS.samples), "27 numbers"),
    (lambda: divergence(MAP.samples), "that of a vector"),
    (lambda: curl(MAP.samples), "that of a vector"),
    (lambda: curl(plane_of(VECTORS.samples, QUIET, axis="y")), "left-handed"),
    (lambda: plane_of(MAP.samples, QUIET, axis="z"), "no slice across z"),
    (lambda: plane_of(VOLUME.samples, QUIET, position=99.0), "outside the data"),
    (lambda: crop(MAP.samples, low=(1.0,)), "2 numbers each"),
    (lambda: crop(MAP.samples, low=(1.0, 1.01), high=(2.0, 1.02)), "no sample lies between"),
    (lambda: subsample(MAP.samples, stride=(0,)), "should be 1 to"),
    (lambda: subsample(MAP.samples, stride=(2, 2, 2)), "one number, or 2"),
    (lambda: resample(interpolate(MAP.samples), QUIET, samples=(4,)), "2 numbers each"),
    (lambda: resample(interpolate(MAP.samples), QUIET, high=(99.0, 2.0)), "the data from"),
    (lambda: transform(MAP.samples, scale=(0.0,)), "no scale 0"),
    (lambda: transform(MAP.samples, unit="s"), "measure different things"),
    (lambda: transform(BENT, scale=(-1.0,)), "cannot be turned round"),
    (lambda: invariants(MAP.samples), "vectors and tensors"),
    (lambda: invariants(VECTORS.samples, measure="trace"), "a vector has a length only"),
    (lambda: invariants(TENSORS.samples, measure="length"), "take the norm"),
    (lambda: slope(VOLUME.samples), "heights on a map"),
    (lambda: median(VECTORS.samples, QUIET), "no order"),
    (lambda: threshold(VECTORS.samples, low=1.0), "no order"),
    (lambda: threshold(MAP.samples, low=2.0, high=1.0), "is above"),
    (lambda: threshold(MAP.samples, VOLUME.samples), "resample it"),
    (lambda: add_noise(MAP.samples, amount=-1.0), "0 or more"),
    (lambda: quantise(MAP.samples, step=-1.0), "more than 0"),
    (lambda: quantise(MAP.samples, bits=40), "1 to 32"),
])  # fmt: skip
def test_what_cannot_be_done_is_refused_with_a_sentence(call: Callable[[], object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        call()


def test_a_step_that_nobody_waits_for_ends() -> None:
    stop = Stop()
    stop.set()
    for step in (smooth, moving_average, median):
        with pytest.raises(Cancelled):
            step(MAP.samples, Progress(stop=stop))


def test_nothing_of_the_size_of_the_grid_squared_is_made() -> None:
    big = Samples.from_array(np.zeros((64, 64, 64), np.float32), accuracy=Accuracy((bound("rounding", 0.5, 64**3),)))
    after = gradient(smooth(big, QUIET, passes=4))
    assert isinstance(after.accuracy.terms[0].operator.shape[1], int)
    assert after.accuracy.terms[0].error(np.arange(5)).shape == (5, 3)
    assert isinstance(interpolate(after), Model) and isinstance(MAP.samples.grid, Rectilinear)


def test_the_error_of_horns_slope_is_stated_with_its_sign() -> None:
    """On a field whose slopes bend across, both parts count: the differences, and what 1 2 1 across takes."""
    field = next(f for f in fields() if f.name == "map")
    made = slope(field.samples, measure="grade", method="horn")
    p, q = (field.value(field.samples.grid.points(), a)[:, 0] for a in (0, 1))
    error = made.values.ravel() - np.hypot(p, q)
    own = next(t for t in made.accuracy.terms if t.kind == "signed")
    inside = np.zeros(field.samples.grid.shape, bool)
    inside[2:-2, 2:-2] = True
    left = np.abs(error - own.error())[inside.ravel()]
    assert np.sqrt(np.mean(left**2)) < 0.5 * np.sqrt(np.mean(error[inside.ravel()] ** 2))
