"""The algebra of accuracy: identity of terms, totals, budgets, joining; Monte Carlo is the judge of the random parts."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from modules.api import (
    EXACT,
    Accuracy,
    Flag,
    Gather,
    Geometry,
    Identity,
    Layer,
    LineLook,
    Missing,
    Model,
    Samples,
    Scene,
    SceneLook,
    Source,
    Spread,
    Table,
    Term,
    Value,
    bound,
    deviation,
    exactly,
    scaling,
    stencil,
    uniform,
    unknown,
)
from modules.data.accuracy import accuracies, replace_accuracies
from modules.data.operators import Operator

Floats = NDArray[np.float64]
SHAPE = (9, 10, 11)
DIFFERENCE = (-0.5, 0.0, 0.5)


def smooth(field: Floats) -> Floats:
    for axis in range(3):
        field = correlate1d(field, np.array([0.25, 0.5, 0.25]), axis=axis - 3, mode="nearest")
    return field


def smoothing() -> Operator:
    operator: Operator = Identity(int(np.prod(SHAPE)))
    for axis in range(3):
        operator = stencil(SHAPE, axis, (-1, 0, 1), (0.25, 0.5, 0.25)).after(operator)
    return operator


def test_smooth_gradient_probe_agrees_with_monte_carlo_where_a_deviation_array_does_not() -> None:
    """A plain array of standard deviations, squared through each stage, gives 0.72 of the truth."""
    random = np.random.default_rng(5)
    sigma, draws = 0.3, 4000
    points = random.uniform([2, 2, 2], [8, 7, 6], (40, 3))
    samples = Samples.from_array(np.zeros(SHAPE), accuracy=EXACT)
    weights = Model.between(samples).law.weights(samples.grid, points)
    gradient = stencil(SHAPE, 2, (-1, 0, 1), DIFFERENCE)
    accuracy = EXACT.add(deviation("sensor", sigma, samples.grid.count)).push(smoothing()).push(gradient).push(weights)
    stated = accuracy.total(1.0, "value")

    noise = random.normal(0, sigma, (draws, *SHAPE))
    fields = correlate1d(smooth(noise), np.array(DIFFERENCE), axis=-1, mode="nearest").reshape(draws, -1)
    probed = np.stack([weights.apply(f) for f in fields])
    truth = probed.std(axis=0, ddof=1)
    assert np.median(stated / truth) == pytest.approx(1.0, abs=0.01)
    assert np.all(np.abs(stated / truth - 1) < 4 / np.sqrt(2 * draws))

    array = np.full(SHAPE, sigma**2)
    for axis in range(3):
        array = correlate1d(array, np.array([0.25, 0.5, 0.25]) ** 2, axis=axis, mode="nearest")
    array = correlate1d(array, np.array(DIFFERENCE) ** 2, axis=2, mode="nearest")
    naive = np.sqrt(Gather(weights.index, weights.weight**2, weights.n_in).apply(array.ravel()))
    assert 0.5 < np.median(naive / truth) < 0.85


def test_x_minus_x_has_no_error() -> None:
    x = EXACT.add(deviation("sensor", 1.0, 5), bound("rounding", 0.5, 5))
    difference = Accuracy.join([(x, None), (x, scaling(np.full(5, -1.0)))])
    assert np.array_equal(difference.total(2.0, "value"), np.zeros(5))
    assert len(difference.terms) == 2


def test_two_sources_made_by_hand_stay_independent() -> None:
    both = Accuracy.join([(EXACT.add(deviation("a", 3.0, 1)), None), (EXACT.add(deviation("a", 4.0, 1)), None)])
    assert both.total(1.0, "value") == pytest.approx(5.0)
    assert both.total(2.0, "value") == pytest.approx(10.0)


def test_bounds_add_deviations_add_in_squares_signed_terms_count_by_their_size() -> None:
    signed = Term(Source("law", "model", "estimated"), "signed", "value", "", np.array([-2.0]), Identity(1))
    accuracy = EXACT.add(bound("b", 1.0, 1), bound("c", 0.5, 1), deviation("s", 3.0, 1), deviation("t", 4.0, 1), signed)
    assert accuracy.total(2.0, "value") == pytest.approx(1.5 + 2.0 + 2 * 5.0)


def test_only_like_quantities_add() -> None:
    accuracy = EXACT.add(bound("a", 1.0, 3, quantity="position", unit="m"), bound("b", 2.0, 3))
    assert np.array_equal(accuracy.total(2, "position"), np.ones(3))
    metres = EXACT.add(bound("a", 1.0, 3, unit="m"), bound("b", 2.0, 3, unit="s"))
    with pytest.raises(ValueError, match="m, s: convert first"):
        metres.total(2, "value")


def test_a_common_error_does_not_average_out() -> None:
    n = 100
    mean = Gather(np.arange(n)[None, :], np.full((1, n), 1 / n), n)
    independent = EXACT.add(deviation("noise", 1.0, n)).push(mean)
    common = EXACT.add(Term(Source("bias", "data", "estimated"), "linear", "value", "", np.asarray(1.0), Spread(n))).push(mean)
    assert independent.total(1, "value") == pytest.approx(0.1)
    assert common.total(1, "value") == pytest.approx(1.0)


def test_a_bound_pushed_lazily_is_tighter_than_stage_by_stage() -> None:
    n = 9
    up = stencil((n,), 0, (0, 1), (1.0, -1.0))
    back = stencil((n,), 0, (-1, 0), (0.5, 0.5))
    lazy = EXACT.add(bound("b", 1.0, n)).push(up).push(back).total(1, "value")
    assert lazy[4] == pytest.approx(1.0)
    assert lazy[4] < 2.0  # |back| |up| b


def test_rigour_is_the_weakest_word_and_missing_is_never_zero() -> None:
    accuracy = EXACT.add(bound("proven", 1.0, 1))
    assert EXACT.rigour() == "exact"
    assert accuracy.rigour() == "proven"
    assert accuracy.add(deviation("guess", 1.0, 1)).rigour() == "estimated"
    assert accuracy.miss(Missing("survey")).rigour() == "unknown"
    assert accuracy.miss(Missing("survey")).word() == "proven"
    assert unknown("nobody asked").rigour() == "unknown"
    assert exactly("join", "mapping", 1).source.sign == "="


def test_the_budget_is_sorted_and_a_glance_says_so() -> None:
    accuracy = EXACT.add(bound("small", 0.1, 5000), bound("large", np.linspace(0, 9, 5000), 5000))
    lines = accuracy.budget()
    assert [one.name for one in lines] == ["large", "small"]
    assert (lines[0].max, lines[0].looked, lines[0].count) == (9.0, 5000, 5000)
    assert lines[0].median == pytest.approx(4.5)
    assert lines[0].sum == pytest.approx(4.5 * 5000)
    glance = accuracy.budget(items=2000)
    assert glance[0].looked == 2000
    assert glance[0].sum == pytest.approx(4.5 * 5000, rel=0.05)


def test_ended_terms_are_told_and_a_term_alive_elsewhere_stays_alive() -> None:
    term = deviation("sensor", 1.0, 3)
    alive, ended = EXACT.add(term), EXACT.add(term).end(term, "cut away")
    assert ended.ended[term.id].why == "cut away"
    assert ended.accounted() == {term.id}
    joined = Accuracy.join([(alive, None), (ended, None)])
    assert [t.id for t in joined.terms] == [term.id]
    assert joined.ended[term.id].why == "cut away"
    assert EXACT.end_from(alive, "not selected").accounted() == {term.id}
    with pytest.raises(ValueError, match="no term 'nothing'"):
        alive.end("nothing", "why")


def test_the_same_source_twice_on_one_quantity_is_refused() -> None:
    term = deviation("sensor", 1.0, 3)
    with pytest.raises(ValueError, match=r"Accuracy\.join"):
        Accuracy((term, term))
    area = replace(term, quantity="area")
    assert len(Accuracy((term, area)).terms) == 2


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: deviation("s", -1.0, 3), "never negative"),
        (lambda: bound("s", np.nan, 3), "NaN"),
        (lambda: bound("s", np.ones(4), 3), "4 primitives; its operator takes 3"),
        (lambda: Term(Source("s", "data", "sampled"), "members", "value", "", np.ones(3), Identity(3)), "members are"),
        (lambda: Samples.from_array(np.ones((2, 2)), accuracy=EXACT.add(bound("s", 1.0, 5))), "5 points; this Samples has 4"),
    ],
)
def test_terms_that_mean_nothing_are_refused(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]  # a function of no arguments


def test_vector_errors_have_three_rows_an_item() -> None:
    term = Term(Source("trace", "mapping", "estimated"), "linear", "position", "m", np.asarray(2.0), Identity(12), "point", 3)
    assert term.count == 4
    assert term.error().shape == (4, 3)
    assert term.size(np.array([1])) == pytest.approx(2 * np.sqrt(3))


def test_members_are_pushed_and_spread() -> None:
    draws = np.random.default_rng(0).normal(size=(30, 6))
    term = Term(Source("ensemble", "data", "sampled"), "members", "value", "", draws, Identity(6))
    pushed = EXACT.add(term).push(scaling(np.full(6, 2.0)))
    assert np.allclose(pushed.total(1, "value"), 2 * draws.std(axis=0, ddof=1))
    assert pushed.word() == "sampled"


def test_one_sigma_for_all_costs_no_memory() -> None:
    accuracy = EXACT.add(deviation("sensor", 0.1, 256**3))
    pushed = accuracy.push(stencil((256, 256, 256), 0, (-1, 0, 1), (0.25, 0.5, 0.25)))
    assert len(pickle.dumps(pushed)) < 20_000


def test_identity_survives_pickling() -> None:
    accuracy = EXACT.add(deviation("sensor", 0.1, 4)).flag(Flag("kappa", "too flat", items=np.array([1])))
    back = pickle.loads(pickle.dumps(accuracy))
    assert back.terms[0].id == accuracy.terms[0].id
    assert np.array_equal(back.flags[0].items, [1])
    same = Accuracy.join([(accuracy, None), (back, scaling(np.full(4, -1.0)))])
    assert not same.total(1, "value").any()


def test_an_error_that_first_order_cannot_tell_is_infinite() -> None:
    steep = EXACT.add(bound("b", 1.0, 2)).push(scaling(np.array([1.0, 1e150])))
    assert np.array_equal(steep.total(1, "value"), [1.0, np.inf])
    assert steep.budget()[0].max == np.inf


def test_accuracies_are_found_and_replaced_however_deep() -> None:
    a, b = deviation("a", 1.0, 2), deviation("b", 1.0, 2)
    line = Geometry(points=np.zeros((2, 3)), accuracy=EXACT.add(a))
    layers = (
        Layer(shape=line, look=LineLook(), accuracy=line.accuracy),
        Layer(shape=line, look=LineLook(), accuracy=EXACT.add(b).carried("Layer", {"point": 2})),
    )
    scene = Scene(layers=layers, look=SceneLook(), accuracy=EXACT)
    assert {t.name for x in accuracies([scene, (scene,)]) for t in x.terms} == {"a", "b"}
    renamed = replace_accuracies(scene, lambda x: x.signed({a.id: "new"}, ""))
    assert {t.id for x in accuracies(renamed) for t in x.terms} == {"new", b.id}
    assert renamed.layers[0].shape.accuracy.terms[0].id == "new"
    assert replace_accuracies(3, lambda x: x) == 3


def test_accuracy_has_no_default() -> None:
    for make in (
        lambda: Samples.from_array(np.ones((2, 2))),  # type: ignore[call-arg]  # that is the point
        lambda: Value(value=1),  # type: ignore[call-arg]  # that is the point
        lambda: Table(columns={}),  # type: ignore[call-arg]  # that is the point
        lambda: Geometry(points=np.zeros((1, 3))),  # type: ignore[call-arg]  # that is the point
    ):
        with pytest.raises(TypeError, match="accuracy"):
            make()


def test_errors_in_units_of_one_kind_are_brought_together() -> None:
    both = Accuracy((bound("a", 1.0, 3, unit="m"), bound("b", 0.002, 3, unit="km")))
    assert both.total(2.0, "value") == pytest.approx([3.0] * 3)
    with pytest.raises(ValueError, match="convert first"):
        Accuracy((bound("a", 1.0, 3, unit="m"), bound("b", 0.002, 3, unit="s"))).total(2.0, "value")
    one = bound("a", 1.0, 3, unit="m")
    less = replace(one.push(uniform((3,), -1e-3)), unit="km")
    assert not Accuracy.join([(Accuracy((one,)), None), (Accuracy((less,)), None)]).total(2.0, "value").any()


def test_one_source_with_other_numbers_on_another_way_adds_its_effects() -> None:
    said = Source("s", "data", "estimated", "made up [test/1]")
    draws = np.random.default_rng(0).normal(size=(9, 4))
    members = [Term(said, "members", "value", "", v, Identity(4), id="s") for v in (draws, -(draws**2))]
    merged = Accuracy.join([(Accuracy((m,)), None) for m in members]).terms[0]
    assert merged.error() == pytest.approx((draws - draws**2).std(axis=0, ddof=1))
    sizes = [Term(said, "linear", "value", "", np.full(4, v), Identity(4), id="s") for v in (2.0, 3.0)]
    assert Accuracy.join([(Accuracy((m,)), None) for m in sizes]).terms[0].error() == pytest.approx([5.0] * 4)
    signs = [Term(said, "signed", "value", "", np.full(4, v), Identity(4), id="s") for v in (2.0, -3.0)]
    assert Accuracy.join([(Accuracy((m,)), None) for m in signs]).terms[0].error() == pytest.approx([-1.0] * 4)
