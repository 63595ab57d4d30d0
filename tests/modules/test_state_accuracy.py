"""What a person states of the errors of data: sizes, correlation, identity, and what is refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Accuracy, Frame, Gather, Missing, Model, Rectilinear, Samples, bound, stencil
from modules.data.fold import fold
from modules.modellers.state_accuracy import state_accuracy

SHAPE = (17, 23)


def field(values: Any = None, *, spacing: tuple[float, ...] = (2.0, 3.0), **more: Any) -> Samples:
    rng = np.random.default_rng(3)
    values = rng.normal(100, 20, SHAPE) if values is None else values
    return Samples.from_array(values, spacing=spacing[: values.ndim], unit="m", accuracy=more.pop("accuracy", EXACT), **more)


def uneven() -> Samples:
    x = np.cumsum(np.random.default_rng(1).uniform(0.5, 4, SHAPE[1]))
    y = np.cumsum(np.random.default_rng(2).uniform(0.5, 4, SHAPE[0]))
    return Samples.from_array(np.ones(SHAPE), axes=(x, y), unit="m", accuracy=EXACT)


CASES: list[dict[str, Any]] = [{"correlation": c} for c in ("independent", "common", "length")]


@pytest.mark.parametrize("source", ["", "the survey of 1980"])
@pytest.mark.parametrize("case", CASES, ids=lambda c: c["correlation"])
@pytest.mark.parametrize("form", ["constant", "percent", "field"])
@pytest.mark.parametrize("samples", [field(), uneven()], ids=["regular", "rectilinear"])
def test_each_sample_has_exactly_the_stated_deviation(samples: Samples, form: Any, case: dict[str, Any], source: str) -> None:
    sizes = np.random.default_rng(5).uniform(0, 3, SHAPE)
    other = Samples(grid=samples.grid, values=sizes, unit="m", accuracy=EXACT) if form == "field" else None
    got = state_accuracy(samples, other, amount=2.5, form=form, length=7.0, source=source, **case)
    wanted = {"constant": np.full(SHAPE, 2.5), "percent": 0.025 * np.abs(samples.values), "field": 2.5 * sizes}[form]
    np.testing.assert_allclose(got.accuracy.terms[-1].error(), wanted.ravel(), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("shape", [(40,), (9, 11), (5, 6, 7)])
@pytest.mark.parametrize("length", [0.3, 1.0, 6.0, 500.0])
def test_correlation_falls_as_the_rule_says(shape: tuple[int, ...], length: float) -> None:
    samples = field(np.zeros(shape), spacing=(1.0, 1.5, 0.7))
    term = state_accuracy(samples, amount=3.0, correlation="length", length=length).accuracy.terms[0]
    rows = np.asarray((term.operator.rows(np.arange(samples.grid.count)) * 3.0).todense())
    points = samples.grid.points()
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    np.testing.assert_allclose(rows @ rows.T, 9 * np.exp(-(distance**2) / (2 * length**2)), atol=9 * 2e-3)
    np.testing.assert_allclose(term.error(), 3.0, rtol=1e-12)


def test_drawn_errors_have_the_stated_deviation_and_correlation() -> None:
    samples = field(np.zeros((12, 20)), spacing=(1.0, 1.0))
    term = state_accuracy(samples, amount=2.0, correlation="length", length=3.0).accuracy.terms[0]
    rng = np.random.default_rng(11)
    draws = np.stack([2.0 * term.operator.apply(rng.standard_normal(term.operator.shape[1])) for _ in range(4000)])
    np.testing.assert_allclose(draws.std(axis=0), 2.0, rtol=0.06)
    lattice = draws.reshape(-1, 12, 20)
    for step in (1, 3, 6):
        got = (lattice[:, :, :-step] * lattice[:, :, step:]).mean() / 4
        assert got == pytest.approx(np.exp(-(step**2) / 18), abs=0.02)


def test_smoothing_leaves_a_correlated_error_and_shrinks_an_independent_one() -> None:
    samples = field()
    smooth = stencil(SHAPE, 1, (-1, 0, 1), (0.25, 0.5, 0.25))
    correlations: tuple[Any, ...] = ("independent", "common", "length")
    left = {
        c: state_accuracy(samples, amount=1.0, correlation=c, length=40.0).accuracy.push(smooth).terms[0].error()
        for c in correlations
    }
    assert np.median(left["independent"]) == pytest.approx(np.sqrt(0.375))
    assert left["common"] == pytest.approx(np.ones(17 * 23))
    assert 0.99 < left["length"].min() < 1.0


def test_a_common_error_vanishes_in_a_difference() -> None:
    term = state_accuracy(field(), correlation="common").accuracy.terms[0]
    difference = Gather(np.array([[0, 5]]), np.array([[1.0, -1.0]]), 17 * 23)
    assert term.push(difference).error()[0] == 0


def test_vectors_have_an_error_per_component() -> None:
    samples = Samples.from_array(np.ones((6, 7, 3)), vector=True, accuracy=EXACT)
    for case in CASES:
        got = state_accuracy(samples, amount=2.0, length=3.0, **case).accuracy.terms[0]
        assert got.components == 3
        np.testing.assert_allclose(got.error(), np.full((42, 3), 2.0), rtol=1e-12)
    common = state_accuracy(samples, amount=2.0, correlation="common").accuracy.terms[0]
    assert common.operator.shape[1] == 3


def test_a_bound_stays_a_bound() -> None:
    got = state_accuracy(field(), kind="bound", amount=0.4).accuracy.terms[0]
    assert got.kind == "bound" and got.source.rigour == "estimated"
    assert "a bound of 0.4 m" in got.source.rule


def test_holes_have_no_size_and_need_none() -> None:
    values = np.ones(SHAPE)
    values[3, 4] = np.nan
    sizes = np.ones(SHAPE)
    sizes[3, 4] = np.nan
    samples = field(values)
    other = Samples(grid=samples.grid, values=sizes, accuracy=EXACT)
    assert state_accuracy(samples, other, form="field").accuracy.terms[0].error().reshape(SHAPE)[3, 4] == 0
    assert state_accuracy(samples, amount=1.0, form="percent").accuracy.terms[0].error().reshape(SHAPE)[3, 4] == 0


def test_a_stated_error_answers_what_was_missing() -> None:
    samples = field(accuracy=Accuracy(missing=(Missing("Measurement error", "the file states none"), Missing("Another"))))
    assert [m.name for m in state_accuracy(samples).accuracy.missing] == ["Another"]
    assert [m.name for m in state_accuracy(samples, answers="").accuracy.missing] == ["Measurement error", "Another"]
    assert [m.name for m in state_accuracy(samples, answers="Another", error="Drift").accuracy.missing] == ["Measurement error"]


def test_terms_go_on_and_those_of_the_field_end_with_a_reason() -> None:
    samples = field(accuracy=Accuracy((bound("Quantisation", 0.5, 17 * 23, unit="m", id="file/z/quantisation"),)))
    own = bound("Rounding of the sizes", 0.1, 17 * 23, id="other")
    sizes = Samples(grid=samples.grid, values=np.ones(SHAPE), accuracy=Accuracy((own,)))
    got = state_accuracy(samples, sizes, form="field").accuracy
    assert got.terms[0].id == "file/z/quantisation" and len(got.terms) == 2
    assert "not carried" in got.ended["other"].why
    assert {"file/z/quantisation", "other"} <= got.accounted()


def test_equal_source_names_are_one_source() -> None:
    a, b = field(), field(np.ones(SHAPE))
    one = state_accuracy(a, amount=1.0, correlation="common", source="survey").accuracy
    two = state_accuracy(b, amount=3.0, correlation="common", source="survey").accuracy
    joined = Accuracy.join([(one, None), (two, None)])
    assert len(joined.terms) == 1
    np.testing.assert_allclose(joined.terms[0].error(), 4.0)
    with_place = [state_accuracy(s, source="survey").accuracy.terms[0].id for s in (a, b, field(spacing=(1.0, 1.0)))]
    assert with_place[0] == with_place[1] != with_place[2]
    unnamed = [state_accuracy(a).accuracy.terms[0].id for _ in range(2)]
    assert unnamed[0] != unnamed[1]


def test_the_assumption_is_printed() -> None:
    samples = field(frame=Frame(units=("km", "km", "km")))
    rule = state_accuracy(samples, correlation="length", length=2.0, who="USGS").accuracy.terms[0].source.rule
    assert rule.startswith("USGS states a standard deviation of 1 m; assumed to correlate")
    assert "L = 2 km" in rule
    assert "independent" in state_accuracy(samples).accuracy.terms[0].source.rule


def test_the_fast_path_through_stencils_agrees_with_the_rows() -> None:
    samples = field()
    model = Model.between(state_accuracy(samples, amount=1.5, correlation="length", length=9.0))
    points = np.column_stack([np.random.default_rng(0).uniform(0, 40, (50, 2)), np.zeros(50)])
    term = model.at(points)[1].terms[0]
    matrix = np.asarray(term.operator.rows(np.arange(50)).todense())
    np.testing.assert_allclose(fold("linear", term.value, term.operator), 1.5 * np.sqrt((matrix**2).sum(axis=1)), rtol=1e-9)
    assert (term.error() <= 1.5 + 1e-12).all() and term.error().min() > 1.4


GRID = field().grid


@pytest.mark.parametrize(("more", "sentence"), [
    ({"amount": -1.0}, "must be 0 or more"),
    ({"amount": float("inf")}, "must be 0 or more"),
    ({"form": "field"}, "no field is wired"),
    ({"correlation": "length", "length": 0.0}, "must be more than 0"),
    ({"correlation": "length", "kind": "bound"}, "a bound has no correlation length"),
    ({"other": Samples(grid=GRID, values=np.ones(SHAPE), accuracy=EXACT)}, "choose form 'field'"),
    ({"other": field(spacing=(1.0, 1.0)), "form": "field"}, "resample it first"),
    ({"other": Samples(grid=GRID, values=np.ones(SHAPE), unit="degC", accuracy=EXACT), "form": "field"}, "different things"),
    ({"other": Samples(grid=GRID, values=-np.ones(SHAPE), accuracy=EXACT), "form": "field"}, "negative or not known"),
    ({"other": Samples(grid=GRID, values=np.full(SHAPE, np.nan), accuracy=EXACT), "form": "field"}, "negative or not known"),
    ({"other": Samples(grid=GRID, values=np.ones((*SHAPE, 3)), accuracy=EXACT), "form": "field"}, "take as many"),
])  # fmt: skip
def test_nonsense_is_refused_with_a_sentence(more: dict[str, Any], sentence: str) -> None:
    other = more.pop("other", None)
    with pytest.raises(ValueError, match=sentence):
        state_accuracy(field(), other, **more)


def test_a_length_over_axes_of_different_units_is_refused() -> None:
    samples = field(frame=Frame(units=("degree", "m", "m")))
    with pytest.raises(ValueError, match="different units"):
        state_accuracy(samples, correlation="length")


def test_a_source_is_stated_once() -> None:
    once = state_accuracy(field(), source="survey")
    with pytest.raises(ValueError, match="already"):
        state_accuracy(once, source="survey")


def test_a_rectilinear_grid_is_what_it_says() -> None:
    assert isinstance(uneven().grid, Rectilinear)


def test_a_formula_of_place_and_value_gives_the_sizes() -> None:
    values = np.random.default_rng(3).normal(100, 20, SHAPE)
    values[0, 5] = np.nan
    samples = field(values)
    term = state_accuracy(samples, form="formula", formula="0.1 + 0.02 * x + 0.01 * abs(v)", amount=2.0).accuracy.terms[0]
    x = samples.grid.points()[:, 0]
    wanted = 2 * (0.1 + 0.02 * x + 0.01 * np.abs(samples.values.ravel()))
    np.testing.assert_allclose(term.error(), np.nan_to_num(wanted, nan=0.0))
    assert "0.1 + 0.02 * x + 0.01 * abs(v) times 2 m" in term.source.rule


def test_members_give_their_spread_in_the_unit_of_the_samples() -> None:
    rng = np.random.default_rng(8)
    samples = field()
    some = [replace(samples, values=(samples.values + rng.normal(0, 3, SHAPE)) * 100, unit="cm") for _ in range(5)]
    got = state_accuracy(samples, None, some, form="members", source="models")
    spread = np.std([m.values / 100 for m in some], axis=0, ddof=1)
    term = got.accuracy.terms[-1]
    np.testing.assert_allclose(term.error(), spread.ravel(), rtol=1e-9)
    assert term.source.rigour == "sampled" and term.kind == "members" and "5 realisations" in term.source.rule


def test_a_judgement_is_named_as_one() -> None:
    got = state_accuracy(field(), amount=3.0, basis="judged", who="A. Expert", error="Reading of the old map")
    assert got.accuracy.terms[0].name == "Reading of the old map, as judged by A. Expert"
    assert "A. Expert judges, and did not measure, a standard deviation of 3 m" in got.accuracy.terms[0].source.rule


def test_a_field_in_another_unit_is_converted() -> None:
    samples = field()
    sizes = replace(samples, values=np.full(SHAPE, 250.0), unit="cm", accuracy=EXACT)
    np.testing.assert_allclose(state_accuracy(samples, sizes, form="field").accuracy.terms[0].error(), 2.5)
    with pytest.raises(ValueError, match="different things"):
        state_accuracy(samples, replace(sizes, unit="s"), form="field")


@pytest.mark.parametrize(("members", "given", "words"), [
    (0, {"form": "members"}, "wire members"), (2, {}, "only then"), (1, {"form": "members"}, "no spread"),
    (0, {"form": "formula", "formula": "v - 1000"}, "no size at"), (0, {"form": "formula", "formula": "q + 1"}, "q"),
])  # fmt: skip
def test_statements_that_say_nothing_are_refused(members: int, given: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        state_accuracy(field(), None, [field()] * members, **given)


def test_members_that_lie_elsewhere_are_refused() -> None:
    with pytest.raises(ValueError, match="elsewhere"):
        state_accuracy(field(), None, [field(spacing=(1.0, 1.0))] * 2, form="members")
    with pytest.raises(ValueError, match="holes"):
        state_accuracy(field(), None, [field(), field(np.full(SHAPE, np.nan))], form="members")
