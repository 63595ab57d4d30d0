"""The laboratory of one cell, against the thesis's own cell, its formulas, and the field itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.api import EXACT, Frame, Model, Samples, bound
from modules.mappers.cell import CellParts, cell
from modules.modellers.interpolate import interpolate

Floats = NDArray[np.float64]


def places(parts: CellParts) -> dict[str, Floats]:
    return dict(zip(parts.points.values["name"].values.tolist(), parts.points.points[:, :2], strict=True))


def numbers(parts: CellParts) -> dict[str, float]:
    return dict(zip(parts.table.columns["name"].tolist(), parts.table.columns["number"].tolist(), strict=True))


def field(parts: CellParts, at: Floats) -> Floats:
    """F of the cell by (3.2), on the unit square."""
    f00, f10, f01, f11 = parts.corners.values["value"].values
    x, y = at.T
    return np.asarray(f00 + (f10 - f00) * x + (f01 - f00) * y + (f00 + f11 - f01 - f10) * x * y)


def flags(parts: CellParts) -> dict[str, str]:
    return {f.name: f.words for f in parts.outline.accuracy.flags}


def test_the_thesis_cell() -> None:
    got = cell()
    at, number = places(got), numbers(got)
    assert {n: number[n] for n in "abc"} == {"a": 6, "b": 9, "c": -20}
    assert number["d"] == pytest.approx(15 - 17.6)
    assert at["S"] == pytest.approx([0.45, 0.3], rel=1e-15)
    assert number["S"] == pytest.approx(17.7 - 17.6, rel=1e-12)
    low, high = ("₁", "₂") if at["R₁"][0] < 0.45 else ("₂", "₁")
    assert sorted([at[f"P{low}"].tolist(), at[f"Q{low}"].tolist()]) == [
        pytest.approx([0, 0.2888888889]), pytest.approx([0.4333333333, 0]),
    ]  # fmt: skip
    assert sorted([at[f"P{high}"].tolist(), at[f"Q{high}"].tolist()]) == [
        pytest.approx([0.4571428571, 1]), pytest.approx([1, 0.3090909091]),
    ]  # fmt: skip
    assert at[f"R{low}"] == pytest.approx([0.3633975, 0.2422650], abs=1e-7)
    assert at[f"R{high}"] == pytest.approx([0.5126783, 0.3797724], abs=1e-7)
    assert (number[f"Q{low}"], number[f"R{low}"]) == pytest.approx((0.050928223, 0.008539327), rel=1e-7)
    assert (number[f"Q{high}"], number[f"R{high}"]) == pytest.approx((0.170748505, 0.021585992), rel=1e-7)
    assert got.corners.values["name"].values.tolist() == ["15, below", "21, above", "24, above", "10, below"]


@pytest.mark.parametrize("seed", range(40))
def test_all_that_is_constructed_satisfies_its_definition(seed: int) -> None:
    random = np.random.default_rng(seed)
    f = dict(zip(("f00", "f10", "f01", "f11"), random.normal(size=4).tolist(), strict=True))
    level = float(random.normal(scale=0.3))
    got = cell(level=level, around=0.4, **f)
    at = places(got)
    a, b = f["f10"] - f["f00"], f["f01"] - f["f00"]
    c = f["f00"] + f["f11"] - f["f01"] - f["f10"]

    def slope(p: Floats) -> Floats:
        return np.array([a + c * p[1], b + c * p[0]])

    for curve in got.hyperbola.polylines():
        assert np.abs(field(got, curve[:, :2]) - level).max() < 1e-9
    for curve in got.beyond.polylines():
        assert np.abs(field(got, curve[:, :2]) - level).max() < 1e-9
        middle = 0.5 * (curve[1:] + curve[:-1])
        assert not ((middle[:, :2] > 1e-9) & (middle[:, :2] < 1 - 1e-9)).all(axis=1).any()
        assert ((curve[:, :2] > -0.4 - 1e-9) & (curve[:, :2] < 1.4 + 1e-9)).all()
    tails = [name[1:] for name in at if name[0] == "R"]
    for tail in tails:
        p, q, r, m, t = (at[f"{name}{tail}"] for name in "PQRMT")
        chord = q - p
        assert abs(slope(r) @ chord) < 1e-9 * np.hypot(*slope(r)) * np.hypot(*chord)  # (3.22): the tangent at R is parallel
        assert field(got, r[None]) == pytest.approx([level], abs=1e-9)
        assert m == pytest.approx((p + q) / 2)
        assert slope(p) @ (t - p) == pytest.approx(0, abs=1e-9)  # (3.8), (3.9): T lies on both tangents
        assert slope(q) @ (t - q) == pytest.approx(0, abs=1e-9)
        s = np.array([-b / c, -a / c])
        cross = (t - m)[0] * (s - m)[1] - (t - m)[1] * (s - m)[0]
        assert abs(cross) < 1e-9 * np.hypot(*(s - m))  # proposition 3.3.1.3
    for line in got.parallels.polylines():
        assert min(np.abs(slope(r) @ (line[1] - line[0])[:2]) for n, r in at.items() if n[0] == "R") < 1e-9
    for x, y in [(p[:, 0], p[:, 1]) for p in got.asymptotes.polylines()]:
        upright, level_ = np.ptp(x) < 1e-12, np.ptp(y) < 1e-12
        assert upright != level_
        assert abs(b + c * x[0] if upright else a + c * y[0]) < 1e-9


def test_the_drawn_curve_keeps_its_promise() -> None:
    """Its distance from the hyperbola, sampled between its points, is at most what is stated, and not much less."""
    got = cell(f00=0.0, f10=5.0, f01=3.5, f11=30.0, level=6.0)
    (term,) = [t for t in got.hyperbola.accuracy.terms if t.name == "Chords of the drawn curve"]
    (curve,) = got.hyperbola.polylines()
    worst = 0.0
    for p, q in zip(curve[:-1, :2], curve[1:, :2], strict=True):
        at = p + np.linspace(0, 1, 51)[:, None] * (q - p)
        slope = np.column_stack([5 + 21.5 * at[:, 1], 3.5 + 21.5 * at[:, 0]])
        worst = max(worst, float(np.abs((field(got, at) - 6) / np.hypot(*slope.T)).max()))
    assert worst <= term.size().max() * 1.0001
    assert worst > 0.9 * term.size().max()
    assert term.source.rigour == "proven"


@pytest.mark.parametrize(
    ("corners", "level", "name", "arcs", "bent"),
    [
        ((0.0, 1.0, 1.0, 2.0), 0.7, "linear cell", 1, 0),
        ((1.0, -1.0, -1.0, 1.0), 0.0, "saddle on the level", 2, 2),
        ((5.0, 5.0, 5.0, 5.0), 5.0, "flat cell on the level", 0, 0),
        ((1.0, 2.0, 3.0, 0.0), 1.0, "corner on the level", 1, 1),
        ((0.0, 0.0, 1.0, -1.0), 0.0, "corners on the level", 1, 1),
        ((1.0, 2.0, 3.0, 5.0), 9.0, "", 0, 0),
    ],
)
def test_special_cells_say_what_they_are(
    corners: tuple[float, ...], level: float, name: str, arcs: int, bent: int
) -> None:
    got = cell(**dict(zip(("f00", "f10", "f01", "f11"), corners, strict=True)), level=level)  # type: ignore[arg-type]  # four numbers
    said = flags(got)
    assert (name in said) if name else not said
    assert len(got.hyperbola.polylines()) == len(got.chords.polylines()) == arcs
    assert len(got.tangents.polylines()) == len(got.shoulders.polylines()) == bent
    remarks = got.table.columns["words"][got.table.columns["name"] == "remark"].tolist()
    assert remarks == list(said.values())
    for line in got.hyperbola.polylines():
        assert np.abs(field(got, line[:, :2]) - level).max() < 1e-12


def test_a_saddle_on_the_level_bends_at_a_right_angle_in_it() -> None:
    got = cell(f00=2.0, f10=-1.0, f01=-4.0, f11=2.0, level=0.0)
    at = places(got)
    assert at["R₁"] == pytest.approx(at["S"], abs=1e-15)
    assert at["R₂"] == pytest.approx(at["S"], abs=1e-15)
    assert all(len(line) == 3 for line in got.hyperbola.polylines())
    assert len(got.beyond.polylines()) == 4


def test_a_cell_of_a_model_lies_where_it_lies_there() -> None:
    values = np.random.default_rng(0).normal(size=(5, 7))
    axes = (np.array([0, 1, 3, 4, 6, 7, 9.0]), np.array([0, 2, 3, 7, 8.0]))
    frame = Frame(units=("m", "m", ""))
    accuracy = EXACT.add(bound("rounding", np.arange(35.0), 35, unit="K"))
    model = interpolate(Samples.from_array(values, axes=axes, frame=frame, unit="K", accuracy=accuracy))
    got = cell(model, row=2, column=3, level=float(values[2:4, 3:5].mean()))
    assert got.outline.bounds == pytest.approx((4, 6, 3, 7, 0, 0))
    assert got.corners.values["value"].values.tolist() == values[2:4, 3:5].ravel().tolist()
    for line in got.hyperbola.polylines():
        assert model.at(line)[0] == pytest.approx(np.full(len(line), values[2:4, 3:5].mean()), abs=1e-12)
    rounding = next(t for t in got.corners.accuracy.terms if t.name == "rounding")
    assert rounding.size().tolist() == [17, 18, 24, 25]
    parts: list[Any] = list(got)
    for part in parts:
        assert part.accuracy.accounted() >= model.accuracy.accounted()
    assert all(part.frame == frame for part in (got.outline, got.hyperbola, got.points, got.corners))


def test_axes_of_different_units_have_no_distances() -> None:
    values = np.array([[15.0, 21.0], [24.0, 10.0]])
    samples = Samples.from_array(values, frame=Frame(units=("s", "m", "")), accuracy=EXACT)
    got = cell(interpolate(samples))
    assert any(f.name == "not measured" for f in got.hyperbola.accuracy.flags)
    assert not [t for t in got.hyperbola.accuracy.terms if t.name == "Chords of the drawn curve"]


def test_points_are_those_that_are_named() -> None:
    assert set(places(cell(named="S C"))) == {"S", "C"}
    assert places(cell(named="C", at=(3.0, 5.0)))["C"].tolist() == [3.5, 5.5]
    with pytest.raises(ValueError, match="no point 'X'"):
        cell(named="P X")


def solid(law: str = "linear", **words: Any) -> Model:
    return interpolate(Samples.from_array(words.pop("values", np.zeros((3, 4))), accuracy=EXACT, **words), law=law)  # type: ignore[arg-type]  # a word


@pytest.mark.parametrize(
    ("model", "words", "message"),
    [
        (solid(), {"row": 2}, "no cell lies in row 2, column 0: the model has 2 rows, 3 columns"),
        (solid(), {"column": -1}, "no cell lies in row 0, column -1"),
        (solid(values=np.zeros((3, 3, 3))), {}, "of the plane with one value"),
        (solid("nearest"), {}, "choose law 'linear'"),
        (solid(values=np.full((2, 2), np.nan)), {}, "a hole at a corner"),
        (None, {"f00": np.nan}, "a hole at a corner"),
        (None, {"around": -1.0}, "0 or more"),
        (None, {"at": (1.0,)}, "x and y"),
    ],
)
def test_what_is_no_cell_is_told(model: Model | None, words: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        cell(model, **words)
