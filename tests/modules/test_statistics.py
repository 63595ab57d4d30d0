"""Numbers of whole fields and their errors: against numpy, against draws, against integrals that are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from app.draw.meshes import chart_of
from modules.api import Accuracy, ChartLook, Frame, Identity, Progress, Samples, Source, Spread, Table, Term, bound, deviation
from modules.data.adjoint import weighed
from modules.modellers.gradient import gradient
from modules.modellers.histogram import histogram
from modules.modellers.smooth import smooth
from modules.modellers.statistics import statistics
from modules.renderers.chart import chart
from tests.modules.manufactured import errors, fields

Floats = NDArray[np.float64]
SHAPE = (30, 40)
N = 1200
TRUE = np.add.outer(np.sin(np.linspace(0, 5, 30)) * 3, np.linspace(-2, 4, 40) ** 2 / 4)
SAID = Source("made up", "data", "estimated", "made up [test/1]")


def samples(*terms: Term, values: Floats = TRUE) -> Samples:
    return Samples.from_array(values, unit="m", name="height", spacing=0.1, accuracy=Accuracy(terms))


def independent(sigma: float) -> Term:
    return deviation("noise", sigma, N, unit="m", id="noise")


def common(sigma: float) -> Term:
    return Term(replace(SAID, name="offset"), "linear", "value", "m", np.asarray(sigma), Spread(N), id="offset")


def drawn(make: Callable[[Samples], Table], column: str, sigma: float, bias: float, draws: int = 300) -> Floats:
    random, found = np.random.default_rng(3), []
    plain = TRUE
    for _ in range(draws):
        noisy = plain + sigma * random.standard_normal(SHAPE) + bias * random.standard_normal()
        found.append(make(samples(values=noisy)).columns[column])
    return np.asarray(found, float)


@pytest.mark.parametrize("field", fields()[:5], ids=lambda f: f.name)
def test_an_operator_turned_round_is_its_transpose(field: object) -> None:
    data = field.samples  # type: ignore[attr-defined]  # a field
    known = gradient(smooth(replace(data, accuracy=errors(data)), Progress())).accuracy
    random = np.random.default_rng(0)
    for term in known.terms:
        n_out, n_in = term.operator.shape
        weights, into = random.normal(size=n_out), random.normal(size=n_in)
        assert weighed(term.operator, weights) @ into == pytest.approx(weights @ term.operator.apply(into), rel=1e-9)


def test_numbers_are_numpys() -> None:
    table = statistics(samples(), percentiles=(10.0, 50.0))
    found = dict(zip(table.columns["statistic"].tolist(), table.columns["value"].tolist(), strict=True))
    wanted = {
        "mean": TRUE.mean(), "standard deviation": TRUE.std(ddof=1), "minimum": TRUE.min(), "maximum": TRUE.max(),
        "10 %": np.quantile(TRUE, 0.1), "median": np.median(TRUE), "samples": N,
    }  # fmt: skip
    assert {name: found[name] for name in wanted} == pytest.approx(wanted)
    top = list(table.columns["statistic"]).index("maximum")
    j, i = np.unravel_index(TRUE.argmax(), SHAPE)
    assert (table.columns["x"][top], table.columns["y"][top]) == pytest.approx((0.1 * i, 0.1 * j))


@pytest.mark.parametrize(("sigma", "bias"), [(0.3, 0.0), (0.0, 0.2), (0.2, 0.2)])
def test_errors_are_those_of_draws(sigma: float, bias: float) -> None:
    terms = [t for t, size in ((independent(sigma), sigma), (common(bias), bias)) if size]
    table = statistics(samples(*terms), k=1.0)
    counted = drawn(statistics, "value", sigma, bias).std(axis=0)
    said = table.columns["error"]
    names = list(table.columns["statistic"])
    for name in ("mean", "standard deviation", "5 %", "median", "95 %"):
        i = names.index(name)
        assert said[i] == pytest.approx(counted[i], rel=0.35 if name == "standard deviation" or "%" in name else 0.25, abs=1e-9)


def test_a_mean_averages_noise_out_and_keeps_what_is_common() -> None:
    table = statistics(samples(independent(0.3), common(0.2)), k=1.0)
    assert table.columns["error"][0] == pytest.approx(np.hypot(0.3 / np.sqrt(N), 0.2))
    assert table.columns["error"][1] == pytest.approx(0.3 / np.sqrt(N - 1), rel=1e-3)


def test_bounds_of_each_number_hold() -> None:
    limits = np.random.default_rng(4).uniform(0, 0.4, N)
    table = statistics(samples(bound("limit", limits, N, unit="m")), k=2.0)
    random = np.random.default_rng(5)
    for kind in range(40):
        share = np.full(N, 2.0 * kind - 1)
        if kind > 1:
            share = random.uniform(-1, 1, N) if kind > 5 else random.choice([-1.0, 1.0], N)
        moved = statistics(samples(values=TRUE + (share * limits).reshape(SHAPE)))
        off = np.abs(moved.columns["value"] - table.columns["value"])
        left = {"integral": np.inf}.get
        for name, o, e in zip(table.columns["statistic"].tolist(), off, table.columns["error"], strict=True):
            assert o <= left(name, e) + 1e-12, name


def test_members_go_through_each_number() -> None:
    draws = np.random.default_rng(6).normal(size=(25, N)) * 0.2
    member = Term(SAID, "members", "value", "m", draws, Identity(N), id="m")
    table = statistics(samples(member), k=1.0)
    each = np.array([statistics(samples(values=TRUE + d.reshape(SHAPE))).columns["value"] for d in draws])
    rows = list(range(len(each[0]) - 2))
    assert table.columns["error"][rows] == pytest.approx(each.std(axis=0, ddof=1)[rows])


@pytest.mark.parametrize("name", ["map", "uneven map", "line", "uneven volume"])
def test_the_integral_knows_what_straight_lines_leave(name: str) -> None:
    field = next(f for f in fields() if f.name == name)
    grid = field.samples.grid
    table = statistics(field.samples)
    i = list(table.columns["statistic"]).index("integral")
    ends = np.reshape(grid.bounds, (3, 2))[: grid.dimensions]
    error = table.columns["value"][i] - exact_integral(field, ends)
    own = next(t for t in table.accuracy.terms if t.name == "Straight lines in the integral")
    assert abs(error - own.error()[i]) < 0.25 * abs(error)
    assert table.columns["error"][i] == pytest.approx(abs(own.error()[i]))


def exact_integral(field: object, ends: Floats) -> float:
    """By Gauss's rule of many points along each axis."""
    x, w = np.polynomial.legendre.leggauss(24)
    axes = [(a + b) / 2 + (b - a) / 2 * x for a, b in ends]
    weights = [(b - a) / 2 * w for a, b in ends]
    mesh = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(ends))
    points = np.column_stack([mesh, np.zeros((len(mesh), 3 - len(ends)))])
    whole = weights[0]
    for one in weights[1:]:
        whole = np.multiply.outer(whole, one)
    return float(whole.ravel() @ field.value(points)[:, 0])  # type: ignore[attr-defined]  # a field


def test_where_there_is_no_integral_it_is_told() -> None:
    holed = TRUE.copy()
    holed[3, 4] = np.nan
    table = statistics(samples(values=holed))
    assert np.isnan(table.columns["value"][-2])
    assert table.columns["value"][-1] == N - 1
    assert any("no integral" in f.words for f in table.accuracy.flags)
    assert not np.isnan(statistics(samples()).columns["value"][-2])


def test_units_of_the_integral() -> None:
    data = Samples.from_array(TRUE, unit="m", accuracy=Accuracy(), frame=Frame(units=("m", "m", "m")))
    table = statistics(data)
    assert table.columns["unit"].tolist()[-2:] == ["m³", ""]


def test_extremes_among_noise_and_spread_of_noise_are_flagged() -> None:
    words = " ".join(f.words for f in statistics(samples(independent(3.0))).accuracy.flags)
    assert "may be the smallest" in words and "may be noise" in words
    assert not statistics(samples(independent(1e-9))).accuracy.flags


def test_what_has_no_statistics_is_refused() -> None:
    with pytest.raises(ValueError, match="every sample is a hole"):
        statistics(samples(values=np.full(SHAPE, np.nan)))
    with pytest.raises(ValueError, match="single numbers"):
        statistics(Samples.from_array(np.zeros((2, 2, 3)), vector=True, accuracy=Accuracy()))
    with pytest.raises(ValueError, match="from 0 to 100"):
        statistics(samples(), percentiles=(120.0,))


# --- histogram ---------------------------------------------------------------------------------------------------


def test_counts_are_numpys() -> None:
    table = histogram(samples(), classes=12)
    wanted, edges = np.histogram(TRUE, 12)
    assert np.array_equal(table.columns["count"], wanted)
    assert np.allclose(table.columns["high"], edges[1:])
    assert histogram(samples(), classes=12, measure="share").columns["share"].sum() == pytest.approx(1)
    density = histogram(samples(), classes=12, measure="density")
    assert (density.columns["density"] * np.diff(edges)).sum() == pytest.approx(1)
    assert density.units["density"] == "1/m"
    assert histogram(samples(), classes=12, cumulative=True).columns["count"][-1] == N


@pytest.mark.parametrize("cumulative", [False, True])
@pytest.mark.parametrize(("sigma", "bias"), [(0.2, 0.0), (0.0, 0.1), (0.15, 0.1)])
def test_error_bars_are_those_of_draws(sigma: float, bias: float, cumulative: bool) -> None:
    terms = [t for t, size in ((independent(sigma), sigma), (common(bias), bias)) if size]
    words = {"classes": 8, "low": -2.5, "high": 5.5, "cumulative": cumulative}
    said = histogram(samples(*terms), k=1.0, **words).columns["total error"]  # type: ignore[arg-type]  # any words
    counted = drawn(lambda s: histogram(s, **words), "count", sigma, bias).std(axis=0)  # type: ignore[arg-type]  # any words
    assert said.sum() == pytest.approx(counted.sum(), rel=0.2)
    assert (np.abs(said - counted) < 0.5 * counted.max()).all()


def test_bounds_of_counts_hold() -> None:
    limits = np.random.default_rng(4).uniform(0, 0.2, N)
    for cumulative in (False, True):
        words = {"classes": 9, "low": -2.5, "high": 6.0, "cumulative": cumulative}
        table = histogram(samples(bound("limit", limits, N, unit="m", id="limit")), **words)  # type: ignore[arg-type]  # any words
        assert "limit" in table.accuracy.ended
        random = np.random.default_rng(5)
        for _ in range(30):
            moved = TRUE + (random.choice([-1.0, 0.3, 1.0], N) * limits).reshape(SHAPE)
            other = histogram(samples(values=moved), **words)  # type: ignore[arg-type]  # any words
            assert (np.abs(other.columns["count"] - table.columns["count"]) <= table.columns["total error"]).all()


def test_members_and_estimates_are_counted_again() -> None:
    draws = np.random.default_rng(6).normal(size=(25, N)) * 0.2
    member = Term(SAID, "members", "value", "m", draws, Identity(N), id="m")
    words = {"classes": 9, "low": -2.5, "high": 6.0}
    table = histogram(samples(member), k=1.0, **words)  # type: ignore[arg-type]  # any words
    each = np.array([histogram(samples(values=TRUE + d.reshape(SHAPE)), **words).columns["count"] for d in draws])  # type: ignore[arg-type]
    assert table.columns["total error"] == pytest.approx(each.std(axis=0, ddof=1))
    signed = Term(SAID, "signed", "value", "m", np.full(N, 0.3), Identity(N), id="s")
    told = histogram(samples(signed), **words)  # type: ignore[arg-type]  # any words
    right = histogram(samples(values=TRUE - 0.3), **words)  # type: ignore[arg-type]  # any words
    assert np.array_equal(told.accuracy.terms[0].error(), told.columns["count"] - right.columns["count"])


def test_a_constant_field_is_in_one_class_and_nonsense_is_refused() -> None:
    assert histogram(samples(values=np.full(SHAPE, 7.0)), classes=5).columns["count"].tolist() == [0, 0, N, 0, 0]
    with pytest.raises(ValueError, match="above high"):
        histogram(samples(), low=3.0, high=1.0)
    with pytest.raises(ValueError, match="every sample is a hole"):
        histogram(samples(values=np.full(SHAPE, np.nan)))


# --- drawn -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "note"), [("band", "in the band"), ("error bars", "in the bars")])
def test_a_chart_draws_the_error_between_two_columns(kind: str, note: str) -> None:
    table = histogram(samples(independent(0.2)), classes=7)
    layer = chart(table, kind=kind)  # type: ignore[arg-type]  # a word
    look = layer.look
    assert isinstance(look, ChartLook)
    assert (look.x, look.y, look.upper) == ("height", "count less error", "count and error")
    assert [(s.name, s.quantity, s.note) for s in layer.shows] == [("noise", "count", note)]
    drawn_as = chart_of(table, look.x, look.y, look.kind, look.upper)
    bounds = drawn_as.bounds if hasattr(drawn_as, "bounds") else drawn_as.GetBounds()
    assert bounds[2] == pytest.approx(table.columns["count less error"].min())
    assert bounds[3] == pytest.approx(table.columns["count and error"].max())
    with pytest.raises(ValueError, match="no column ends in"):
        chart(statistics(samples()), kind=kind)  # type: ignore[arg-type]  # a word
