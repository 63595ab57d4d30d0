"""Formulas over fields: numbers, units, what inputs have in common, and bounds that hold beyond first order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from modules.api import Accuracy, Identity, Samples, Source, Term, bound, deviation
from modules.data.dimensions import measured
from modules.data.expression import FormulaError
from modules.data.formula import Formula
from modules.data.intervals import enclosed
from modules.data.units import UnitError, product, root, same
from modules.modellers.calculator import calculator

Floats = NDArray[np.float64]


def samples(values: object, *terms: Term, unit: str = "m", vector: bool = False) -> Samples:
    return Samples.from_array(np.asarray(values, float), unit=unit, accuracy=Accuracy(terms), vector=vector)


def noise(n: int, sigma: float = 0.1, name: str = "noise") -> Term:
    return deviation(name, sigma, n, unit="m", id=name)


# --- numbers and what is in common -------------------------------------------------------------------------------


def test_a_thing_less_itself_is_nothing_without_error() -> None:
    a = samples(np.random.default_rng(1).normal(size=(5, 6)), noise(30), bound("rounding", 0.2, 30, unit="m", id="r"))
    for formula in ("a - b", "a - a", "2 * a - b - a", "a * a - b * a", "sin(a / b - 1)"):
        made = calculator(a, a, formula=formula)
        assert np.abs(made.values).max() < 1e-14
        assert [t.id for t in made.accuracy.terms[:2]] == ["noise", "r"]
        assert max(float(t.size().max()) for t in made.accuracy.terms if t.kind == "linear") < 1e-15
    assert made.unit == ""


def test_of_one_source_errors_add_and_of_two_their_squares() -> None:
    a, other = samples([1.0, 2.0], noise(2)), samples([3.0, 4.0], noise(2, name="other"))
    one = calculator(a, a, formula="a + b").accuracy.total(1.0, "value")
    two = calculator(a, other, formula="a + b").accuracy.total(1.0, "value")
    assert one == pytest.approx([0.2, 0.2])
    assert two == pytest.approx([0.1 * 2**0.5] * 2)


def test_vectors_go_component_by_component_and_single_components_have_names() -> None:
    v = samples(np.arange(12.0).reshape(2, 2, 3), vector=True)
    s = samples([[1.0, 2.0], [3.0, 4.0]], unit="")
    assert np.array_equal(calculator(v, s, formula="a * b").values, v.values * s.values[..., None])
    assert np.array_equal(calculator(v, formula="a_z - a_x").values, v.values[..., 2] - v.values[..., 0])
    turned = calculator(v, formula="a_y; -a_x; 0")
    assert turned.values.shape == (2, 2, 3)
    assert np.array_equal(turned.values[..., 1], -v.values[..., 0])


def test_coordinates_and_time_are_names() -> None:
    s = replace(samples(np.zeros((3, 4))), time=7.0)
    assert calculator(s, formula="x + 10 * y + 100 * t", units="ignored").values[2, 3] == 723
    with pytest.raises(FormulaError, match="has none"):
        calculator(samples([1.0]), formula="a * t")


def test_members_go_through_the_formula_itself() -> None:
    draws = np.random.default_rng(3).normal(size=(40, 4))
    made = Term(Source("ensemble", "data", "sampled", "made up"), "members", "value", "m", draws, Identity(4), id="e")
    a = samples([0.0, 0.5, 1.0, 2.0], made)
    squared = calculator(a, formula="a**2")
    assert squared.accuracy.terms[0].error() == pytest.approx(((a.values + draws) ** 2).std(axis=0, ddof=1))
    less = calculator(squared, a, formula="a - b", units="ignored")
    assert less.accuracy.terms[0].error() == pytest.approx(
        ((a.values + draws) ** 2 - (a.values + draws)).std(axis=0, ddof=1)
    )


def test_where_there_is_no_number_is_a_hole_that_is_told() -> None:
    made = calculator(samples([-1.0, 0.0, 4.0, np.nan], unit=""), formula="log(a)")
    assert np.isnan(made.values[[0, 1, 3]]).all() and made.values[2] == pytest.approx(np.log(4))
    flag = next(f for f in made.accuracy.flags if f.name == "no value")
    assert list(np.asarray(flag.items)) == [0, 1]
    assert "2 of 4" in flag.words


def test_what_is_not_linear_is_flagged() -> None:
    made = calculator(samples([0.05, 5.0], noise(2, 0.1)), formula="a**2")
    flag = next(f for f in made.accuracy.flags if f.name == "not linear")
    assert list(np.asarray(flag.items)) == [0]
    assert not calculator(samples([0.05, 5.0], noise(2, 0.1)), formula="3 * a + 1").accuracy.flags


def test_what_is_not_used_ends_with_a_reason() -> None:
    a, b = samples([1.0, 2.0], noise(2)), samples([1.0, 2.0], noise(2, name="other"))
    assert calculator(a, b, formula="2 * a").accuracy.ended["other"].why == "the formula does not use it"


# --- bounds ------------------------------------------------------------------------------------------------------

FORMULAS = (
    "a * b", "a / b", "a**2 - b**2", "sqrt(abs(a))", "exp(a - b)", "abs(a) - max(a, b)", "where(a > b, a, 2 * b)",
    "floor(a) + b",
    "atan2(a, b)", "hypot(a, b)", "sin(3 * a) * cos(b)", "tan(a)", "a ** b", "b ** -2", "log(b) / a", "acos(a / 4)",
    "sign(a) * b",
    "min(a * b, a + b)", "not (a > 0)", "cosh(a) - tanh(b)",
)  # fmt: skip


@pytest.mark.parametrize("formula", FORMULAS)
def test_bounds_hold_beyond_first_order(formula: str) -> None:
    random = np.random.default_rng(len(formula))
    n = 400
    values = random.uniform(-2, 3, (2, n))
    limits = random.choice([0.0, 0.01, 0.3], (2, n))
    a, b = (
        samples(values[i], bound(f"limit {i}", limits[i], n, id=f"limit {i}"), unit="") for i in (0, 1)
    )
    made = calculator(a, b, formula=formula)
    most = made.accuracy.total(0.0, "value")
    looked = np.ones(n, bool)
    for flag in made.accuracy.flags:
        looked[flag.items] = flag.name not in ("unproven", "no value")
    assert looked.sum() > 0.2 * n
    program = Formula.parse(formula, ("a", "b"))
    for corner in range(60):
        share = random.uniform(-1, 1, (2, n)) if corner > 3 else np.array([[corner % 2], [corner // 2]]) * 2.0 - 1
        moved = values + share * limits
        off = np.abs(program.value({"a": moved[0], "b": moved[1]}) - made.values)
        assert np.isfinite(off[looked]).all()
        assert (off[looked] <= most[looked] * (1 + 1e-12) + 1e-12).all()


def test_the_rest_beyond_first_order_is_of_second_order_and_nothing_for_linear_formulas() -> None:
    rests = []
    for size in (0.1, 0.05):
        made = calculator(samples([1.0], bound("w", size, 1)), formula="a**2", units="ignored")
        rests.append(float(made.accuracy.terms[-1].size()[0]))
    assert rests == pytest.approx([2 * 0.1**2, 2 * 0.05**2])
    assert len(calculator(samples([1.0], bound("w", 0.1, 1)), formula="3 * a - 2").accuracy.terms) == 1


def test_a_pole_within_the_bounds_is_not_proven() -> None:
    made = calculator(samples([0.05, 1.0], bound("w", 0.1, 2), unit=""), formula="1 / a")
    flag = next(f for f in made.accuracy.flags if f.name == "unproven")
    assert list(np.asarray(flag.items)) == [0]
    assert made.accuracy.rigour() == "unknown"


NAMES = ("sin", "cos", "tan", "exp", "tanh", "abs", "sqrt", "log", "floor", "sign", "atan", "cosh")
LEAVES = st.sampled_from(["a", "b", "2", "0.5"])
TREES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "<"]), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(st.sampled_from(NAMES), inner).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(st.sampled_from(["min", "max", "hypot", "atan2"]), inner, inner).map(lambda t: f"{t[0]}({t[1]}, {t[2]})"),
        st.tuples(inner, st.sampled_from(["2", "3", "-1"])).map(lambda t: f"({t[0]}) ** ({t[1]})"),
    ),
    max_leaves=6,
)


@given(TREES, st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 1), st.floats(0, 1))
@settings(max_examples=150, deadline=None)
def test_an_interval_holds_all_values(text: str, a: float, b: float, wide: float, high: float) -> None:
    formula = Formula.parse(text, ("a", "b"))
    ends = {"a": (np.array(a), np.array(a + wide)), "b": (np.array(b), np.array(b + high))}
    low, top = (float(end) for end in enclosed([formula.root], ends)[0])
    share = np.linspace(0, 1, 9)
    found = formula.value({"a": a + share[:, None] * wide, "b": b + share * high})
    told = found[np.isfinite(found)]
    assert (told >= low).all() and (told <= top).all()


# --- units -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("formula", "a", "b", "unit", "value"), [
    ("a + b", "m", "km", "m", 3002.0),
    ("a * b", "m", "s", "m s", 6.0),
    ("a / b", "m", "s", "m/s", 2 / 3),
    ("a / b", "m", "m", "", 2 / 3),
    ("sqrt(a**2 + b**2)", "m", "m", "m", 13**0.5),
    ("a - b", "degC", "degC", "K", -1.0),
    ("a - b", "degC", "K", "degC", -1.0),
    ("(a + b) / 2", "degC", "degC", "K", 275.65),
    ("a + 1", "degC", "", "degC", 3.0),
    ("sin(a)", "degree", "", "", np.sin(np.radians(2))),
    ("atan2(a, b)", "m", "m", "rad", np.arctan2(2, 3)),
    ("exp(a)", "%", "", "", np.exp(0.02)),
    ("where(a > 1, a, b)", "m", "cm", "m", 2.0),
    ("max(a, b)", "m", "cm", "m", 2.0),
    ("a ** -1", "s", "", "1/s", 0.5),
    ("a > b", "km", "m", "", 1.0),
    ("-abs(a)", "m/s", "", "m/s", -2.0),
])  # fmt: skip
def test_units_are_reckoned(formula: str, a: str, b: str, unit: str, value: float) -> None:
    made = calculator(samples([2.0], unit=a), samples([3.0], unit=b), formula=formula)
    assert made.unit == unit
    assert made.values[0] == pytest.approx(value)


@pytest.mark.parametrize(("formula", "a", "b", "sentence"), [
    ("a + b", "m", "s", "a is in m, b is in s: these do not add or compare"),
    ("a < b", "m", "kg", "a is in m, b is in kg"),
    ("a + b", "m", "", "b is in plain numbers"),
    ("exp(a)", "m", "", "exp takes plain numbers and a is in m"),
    ("sin(a)", "m", "", "measure different things"),
    ("sqrt(a)", "m", "", "square root of m has no unit"),
    ("a ** b", "", "s", "an exponent takes plain numbers"),
    ("where(a > 0, a, b)", "m", "s", "these do not add or compare"),
])  # fmt: skip
def test_units_that_do_not_fit_are_refused(formula: str, a: str, b: str, sentence: str) -> None:
    one, other = samples([2.0], unit=a), samples([3.0], unit=b)
    with pytest.raises(FormulaError, match=sentence):
        calculator(one, other, formula=formula)
    assert calculator(one, other, formula=formula, units="ignored", unit="K").unit == "K"


def test_the_outcome_is_brought_to_the_unit_asked_for() -> None:
    made = calculator(samples([2.0], noise(1)), formula="3 * a", unit="km")
    assert made.values[0] == pytest.approx(0.006) and made.unit == "km"
    assert made.accuracy.total(1.0, "value")[0] == pytest.approx(3e-4)
    with pytest.raises(FormulaError, match="outcome is in m, not in s"):
        calculator(samples([2.0]), formula="3 * a", unit="s")


@pytest.mark.parametrize(("one", "other", "power", "wanted"), [
    ("m", "s", -1, "m/s"), ("m/s", "m", -1, "1/s"), ("", "m", 2, "m²"), ("counts", "s", -1, "counts/s"),
    ("m2 s-2", "kg", 1, "kg m2 s-2"),
    ("hPa", "hPa", -1, ""), ("0.01 m", "m", 1, "0.01 m2"), ("W m-2", "m", 2, "W"),
])  # fmt: skip
def test_products_of_units(one: str, other: str, power: int, wanted: str) -> None:
    assert same(product(one, other, power), wanted)


def test_roots_of_units() -> None:
    assert root("m²/s²") == "m/s"
    with pytest.raises(UnitError):
        root("m/s²")


def test_a_unit_computed_is_that_of_the_values() -> None:
    node, unit = measured(Formula.parse("a * b / a", ("a", "b")).root, {"a": "km", "b": "s"})
    assert unit == "s"
    assert node.what == "/"


# --- refusals ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("formula", "sentence"), [
    ("a + b", "nothing is wired to b"), ("a; a", "2 formulas"), ("", "empty"), ("a +", "missing at the end"), 
    ("q", "there is no 'q'"), ("__import__('os')", "there is no function"),
])  # fmt: skip
def test_what_cannot_be_computed_is_refused(formula: str, sentence: str) -> None:
    with pytest.raises(FormulaError, match=sentence):
        calculator(samples([1.0, 2.0]), formula=formula)


def test_other_grids_and_vectors_beside_tensors_are_refused() -> None:
    with pytest.raises(ValueError, match="resample"):
        calculator(samples([1.0, 2.0]), samples([1.0, 2.0, 3.0]), formula="a + b")
    v = samples(np.zeros((2, 2, 3)), vector=True)
    with pytest.raises(ValueError, match="component by component"):
        calculator(v, replace(v, values=np.zeros((2, 2, 3, 3))), formula="a + b")
