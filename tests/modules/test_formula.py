"""Formulas that a person types: what they compute, their derivatives, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from modules.data.formula import DEEPEST, FUNCTIONS, LONGEST, Formula, FormulaError

X, Y = 0.6, -0.35

SAFE = {
    name: getattr(math, name)
    for name in ("sqrt", "exp", "log", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh",
                 "tanh", "floor", "ceil", "hypot")
}  # fmt: skip
SAFE |= {"abs": abs, "min": min, "max": max, "sign": lambda v: (v > 0) - (v < 0), "where": lambda c, a, b: a if c else b}


def expressions(smooth: bool = False) -> st.SearchStrategy[str]:
    one = ["sin", "cos", "exp", "tanh", "atan", "sinh", "cosh"]
    one += [] if smooth else ["abs", "sqrt", "log", "floor", "sign", "tan"]
    two = ["hypot"] if smooth else ["min", "max", "atan2", "hypot"]
    leaf = st.sampled_from(["x", "y", "pi", "2", "0.5", "1e-3"])

    def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return st.one_of(
            st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
            st.tuples(inner, st.sampled_from(["2", "3"])).map(lambda t: f"({t[0]}) ** {t[1]}"),
            st.tuples(st.sampled_from(one), inner).map(lambda t: f"{t[0]}({t[1]})"),
            st.tuples(st.sampled_from(two), inner, inner).map(lambda t: f"{t[0]}({t[1]}, {t[2]})"),
            inner.map(lambda t: f"-({t})"),
        )

    return st.recursive(leaf, grown, max_leaves=8)


@given(expressions())
@settings(max_examples=300, deadline=None)
def test_a_formula_computes_what_python_does(text: str) -> None:
    try:
        # the text is made above, and Python is the judge
        wanted = eval(text, {"__builtins__": {}}, {**SAFE, "x": X, "y": Y, "pi": math.pi})
    except (ZeroDivisionError, ValueError, OverflowError):
        return
    assume(isinstance(wanted, int | float))
    got = float(Formula.parse(text).value({"x": X, "y": Y}))
    assert got == pytest.approx(wanted, rel=1e-11, abs=1e-11, nan_ok=True)


@given(expressions(smooth=True), st.sampled_from(["x", "y"]))
@settings(max_examples=300, deadline=None)
def test_a_derivative_agrees_with_complex_steps(text: str, name: str) -> None:
    """d/dx Re f = Im f(x + ih) / h, exact to rounding where f is analytic."""
    complexes = {n: getattr(np, {"atan": "arctan"}.get(n, n)) for n in ("sin", "cos", "exp", "tanh", "atan", "sinh", "cosh")}
    complexes["hypot"] = lambda a, b: np.sqrt(a * a + b * b + 0j)
    step = 1e-20j
    at = {"x": complex(X), "y": complex(Y)}
    at[name] += step
    with np.errstate(all="ignore"):
        try:
            wanted = np.imag(eval(text, {"__builtins__": {}}, {**complexes, **at, "pi": math.pi + 0j})) / 1e-20  # as above
        except (ZeroDivisionError, OverflowError):
            return
    formula = Formula.parse(text)
    got = float(formula.derivative(name).value({"x": X, "y": Y}))
    assume(np.isfinite(wanted) and np.isfinite(got) and abs(wanted) < 1e6)
    assume(abs(float(formula.value({"x": X, "y": Y}))) > 1e-12)
    assert got == pytest.approx(wanted, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("text", [
    "abs(x)", "sqrt(x)", "exp(x*y)", "log(x)", "log10(x)", "sin(x)", "cos(x)", "tan(x)", "asin(x)", "acos(x)", "atan(x)",
    "atan2(y, x)", "atan2(x, y)", "sinh(x)", "cosh(x)", "tanh(x)", "floor(x)", "ceil(x)", "sign(x)", "hypot(x, y)",
    "min(x, y, 3)", "max(x, y)", "where(x > y, x**2, y)", "x**3", "x**-2", "2**x", "x**(x*x)", "x/(y + x)", "-x", "x < y",
    "(x > 0 and y < 0) * x", "1 / x - y",
])  # fmt: skip
def test_each_function_has_the_slope_that_differences_see(text: str) -> None:
    formula, h = Formula.parse(text), 1e-6
    for i, name in enumerate(("x", "y")):
        up, down = {"x": X, "y": Y}, {"x": X, "y": Y}
        up[name] += h
        down[name] -= h
        slope = (float(formula.value(up)) - float(formula.value(down))) / (2 * h)
        assert float(formula.derivative(name).value({"x": X, "y": Y})) == pytest.approx(slope, abs=1e-7)
        assert float(formula.gradient({"x": X, "y": Y}, ("x", "y"))[i]) == pytest.approx(slope, abs=1e-7)


@given(expressions())
@settings(max_examples=100, deadline=None)
def test_the_text_of_a_formula_reads_as_the_same_formula(text: str) -> None:
    formula = Formula.parse(text)
    again = Formula.parse(str(formula))
    at = {"x": X, "y": Y}
    assert float(again.value(at)) == pytest.approx(float(formula.value(at)), rel=1e-12, nan_ok=True)


def test_arrays_broadcast_and_blocks_leave_no_seam() -> None:
    x, y = np.linspace(0, 1, 700), np.linspace(-1, 1, 300)[:, None]
    got = Formula.parse("sin(x) * y + x ** 2").value({"x": x, "y": y})
    assert got.shape == (300, 700)
    np.testing.assert_allclose(got, np.sin(x) * y + x**2, rtol=1e-14)
    assert Formula.parse("3").value({"x": x}).shape == x.shape


def test_a_product_of_many_factors_has_a_derivative_of_modest_size() -> None:
    formula = Formula.parse("*".join(f"sin({k} * x)" for k in range(1, 100)))
    second = formula.derivative("x").derivative("x")
    assert np.isfinite(second.value({"x": 0.3}))


def test_names_of_the_caller_come_before_constants() -> None:
    assert float(Formula.parse("e + pi", names=("e",)).value({"e": 1.0})) == pytest.approx(1 + math.pi)
    assert Formula.parse("x + t").used == {"x", "t"}


def test_a_division_by_zero_is_infinite_and_no_exception() -> None:
    assert np.isinf(Formula.parse("1 / x").value({"x": 0.0}))
    assert np.isnan(Formula.parse("log(x)").value({"x": -1.0}))
    assert Formula.parse("where(x > 0, 1 / x, 0)").value({"x": 0.0}) == 0


def test_towers_of_powers_end_at_infinity_at_once() -> None:
    assert np.isinf(Formula.parse("9**9**9**9**9").value({}))


@pytest.mark.parametrize(("text", "sentence"), [
    ("", "the formula is empty"),
    ("sinn(x)", "column 1: there is no function 'sinn'; did you mean 'sin'?"),
    ("2 + hight", "column 5: there is no 'hight'"),
    ("  2 + q", "column 7: there is no 'q'; names are x, y, z, t"),
    ("x^2", "write ** for a power"),
    ("2x", "write a * between a number and a name"),
    ("x +", "something is missing at the end"),
    ("(x", "a bracket has no partner"),
    ("x = 2", "write == to compare"),
    ("sin", "write sin(...)"),
    ("x(2)", "write x * (...)"),
    ("sin(x, y)", "sin takes 1 argument, not 2"),
    ("atan2(x)", "atan2 takes 2 arguments, not 1"),
    ("max(x)", "max takes 2 arguments or more, not 1"),
    ("x if y else 2", "write where("),
    ("x % 2", "floor"),
    ("x // 2", "floor"),
    ("~x", "write 'not'"),
    ("sin(x=1)", "plain arguments"),
    ("sin(*x)", "plain arguments"),
    ("1j", "is not a number"),
    ("True", "is not a number"),
    ("'x'", "is not a number"),
    ("1e999", "too large"),
    ("1" + "0" * 400, "too large"),
    ("9" * 4400, f"{LONGEST} are allowed"),
    ("x in y", "compare with"),
    ("(" * 300 + "x" + ")" * 300, f"{DEEPEST} levels"),
    ("-" * 3000 + "x", f"{DEEPEST} levels"),
    ("sin(" * 160 + "x" + ")" * 160, f"{DEEPEST} levels"),
])  # fmt: skip
def test_what_is_no_formula_is_refused_with_a_sentence(text: str, sentence: str) -> None:
    with pytest.raises(FormulaError) as caught:
        Formula.parse(text)
    assert sentence in str(caught.value)


@pytest.mark.parametrize("text", [
    "__import__('os').system('true')", "x.__class__", "(lambda: 1)()", "[x for x in (1,)]", "{1: 2}", "x[0]", "f'{x}'",
    "open('a')", "(x := 3)", "exec('1')", "x; y", "import os", "().__class__", "await x", "yield",
])  # fmt: skip
def test_nothing_is_run(text: str) -> None:
    with pytest.raises(FormulaError):
        Formula.parse(text)


def test_a_name_without_a_value_is_named() -> None:
    with pytest.raises(FormulaError, match="'y', which has no value"):
        Formula.parse("x + y").value({"x": 1.0})


def test_every_function_is_judged_here() -> None:
    assert set(FUNCTIONS) == set(SAFE)
