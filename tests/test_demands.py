"""Demands on accuracy: the grammar, the numbers, and when they are about nothing."""

import math
from typing import Any

import numpy as np
import pytest

from app.engine.demands import Demand, DemandRefused, Verdict, named, statistics
from app.engine.errors import NetworkError, UnknownName
from modules.data.accuracy import Accuracy, Missing, Term, bound, deviation, exactly
from modules.data.geometry import Geometry


def lines(*terms: Term, missing: tuple[Missing, ...] = (), n: int = 4, cell: float | None = 2.0) -> Geometry:
    points = np.zeros((n, 3))
    return Geometry(points=points, cell=cell, accuracy=Accuracy(terms, missing))


def position(sizes: list[float], name: str = "Quantisation, half a metre", unit: str = "m") -> Term:
    return bound(name, np.asarray(sizes, float), len(sizes), quantity="position", unit=unit)


def judge(text: str, value: Any, k: float = 2.0) -> Verdict:
    return Demand.of(text).judge(value, k)


SIZES = [0.01, 0.02, 0.03, 0.06]


@pytest.mark.parametrize(
    ("statistic", "number"), [("max", 0.06), ("mean", 0.03), ("median", 0.025), ("p95", 0.03), ("sum", 0.12)]
)
def test_each_statistic_is_compared(statistic: str, number: float) -> None:
    shape = lines(position(SIZES))
    assert judge(f"c.lines.position.{statistic} <= {number:.17g} m", shape).found == pytest.approx(number)
    assert judge(f"c.lines.position.{statistic} < {number * 1.001} m", shape).met
    assert not judge(f"c.lines.position.{statistic} < {number * 0.999} m", shape).met


@pytest.mark.parametrize(
    ("limit", "met"),
    [("0.031 cell", True), ("0.03 cell", False), ("61 mm", True), ("59 mm", False), ("0.061", True), ("0.2 ft", True),
     ("5.9e-5 km", False), ("2.4 inch", True)],
)
def test_units(limit: str, met: bool) -> None:
    assert judge(f"c.lines.position.max < {limit}", lines(position(SIZES))).met is met


def test_all_terms_add_and_deviations_count_k_times() -> None:
    shape = lines(position([0.1] * 4), deviation("Sensor", 0.2, 4, quantity="position", unit="m"))
    assert judge("c.lines.position.max < 1", shape, k=2).found == pytest.approx(0.5)
    assert judge("c.lines.position.max < 1", shape, k=3).found == pytest.approx(0.7)
    assert judge("c.lines[Sensor].position.max < 1", shape, k=2).found == pytest.approx(0.4)
    assert judge("c.lines[quantisation].position.max < 1", shape, k=2).found == pytest.approx(0.1)


def test_a_missing_source_is_not_met_whatever_the_number() -> None:
    shape = lines(position([0.0] * 4), missing=(Missing("Sensor", "nobody said"),))
    verdict = judge("c.lines.position.max < 1e9", shape)
    assert not verdict.met
    assert "Sensor" in verdict.why
    assert judge("c.lines[Quantisation].position.max < 1", shape).met
    assert not judge("c.lines[Sensor].position.max < 1", shape).met


def test_about_nothing_is_not_met() -> None:
    assert "about nothing" in judge("c.lines.position.max < 1", lines()).why
    assert "about nothing" in judge("c.lines.position.max < 1", lines(position([]), n=0)).why
    assert "no points" in judge("c.lines.position.max < 1", lines(position([]), n=0)).why
    assert not judge("c.lines.position.max < 1", object()).met


def test_exactly_zero_is_about_something() -> None:
    zero = exactly("Copied", "data", 4, quantity="position")
    assert judge("c.lines.position.max <= 0", lines(zero)).met


def test_infinity_and_not_a_number_are_not_met(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not judge("c.lines.position.max < 1e300", lines(position([math.inf] * 4))).met
    monkeypatch.setattr(Accuracy, "total", lambda *_: np.array([math.nan]))
    verdict = judge("c.lines.position.max < 1e300", lines(position([1.0] * 4)), k=2)
    assert not verdict.met
    assert "not a number" in verdict.why


def test_rigour() -> None:
    shape = lines(position(SIZES), deviation("Sensor", 1.0, 4, quantity="position", unit="m"))
    assert judge("c.lines.position.rigour >= estimated", shape).met
    assert not judge("c.lines.position.rigour >= proven", shape).met
    assert judge("c.lines[Quanti].position.rigour >= proven", shape).met
    assert not judge("c.lines.position.rigour >= proven", lines(position(SIZES), missing=(Missing("x"),))).met


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("c.lines.position.max", "write it as"),
        ("c.lines.max < 1", "write it as"),
        ("c.lines.position.maxi < 1", "did you mean 'max'?"),
        ("c.lines.position.max > 1", "write < or <="),
        ("c.lines.position.max < small", "no number"),
        ("c.lines.position.rigour < proven", "with >="),
        ("c.lines.position.rigour >= prooven", "did you mean 'proven'?"),
    ],
)
def test_words_that_are_no_demand(text: str, says: str) -> None:
    with pytest.raises(DemandRefused, match=r"c\.lines") as caught:
        Demand.of(text)
    assert says in str(caught.value)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("c.lines.positon.max < 1", "'position'"),
        ("c.lines[Quantization].position.max < 1", "Quantisation"),
        ("c.lines.position.max < 1 kg", "position is in m"),
        ("c.lines.position.max < 1 cel", "did you mean 'cell'?"),
    ],
)
def test_misspelt_parts_name_the_nearest(text: str, says: str) -> None:
    with pytest.raises(NetworkError) as caught:
        judge(text, lines(position(SIZES)))
    assert says in str(caught.value)
    assert isinstance(caught.value, UnknownName | DemandRefused)


def test_a_cell_needs_to_be_known() -> None:
    assert "does not know the size" in judge("c.lines.position.max < 1 cell", lines(position(SIZES), cell=None)).why


def test_numbers_are_of_the_c_locale() -> None:
    with pytest.raises(DemandRefused):
        judge("c.lines.position.max < 0,01", lines(position(SIZES)))


def test_statistics_agree_with_a_budget() -> None:
    term = position(SIZES)
    line = Accuracy((term,)).budget()[0]
    for name, number in statistics(term.size()).items():
        assert getattr(line, name) == number


def test_a_term_is_named_by_its_beginning_if_only_one_has_it() -> None:
    assert named("quant", ["Quantisation, half", "Sensor"]) == "Quantisation, half"
    assert named("S", ["Sensor", "Smoothing"]) == ""
    assert named("sensor", ["Sensor", "Sensor drift"]) == "Sensor"
