"""Chapter 3 of the thesis, contouring: a test for each of its equations, propositions and numbers.

The program's shoulder points and areas come from `contour.lines` and `arcs`; what they are held against is the thesis's
own formula, evaluated here with c in its denominators as printed, in decimal arithmetic where it cancels.
"""

import math
from collections.abc import Iterator
from decimal import Decimal, getcontext
from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest

from modules.kernels import arcs, bilinear, contour

Floats = npt.NDArray[np.float64]

getcontext().prec = 60
UNIT = np.arange(2.0)
CORNERS = (15.0, 21.0, 24.0, 10.0)  # (3.27): f00, f10, f01, f11
THESIS_CELL = np.array(CORNERS).reshape(2, 2)  # rows are y
LEVEL = 17.6


class Arc:
    """An arc of a cell as the program drew it: P, R, Q; a, b, c, d with the level subtracted."""

    def __init__(self, values: Floats, level: float, line: Floats, bends: Floats) -> None:
        a, b, c, d = (float(z) for z in bilinear.coefficients(*values.ravel()))
        self.a, self.b, self.c, self.d = a, b, c, d - level
        f00, f10, f01, f11 = values.ravel().tolist()
        self.determinant = bilinear.determinant(f00, f10, f01, f11, level)
        self.p, self.r, self.q = line
        self.bends = bends

    def f(self, at: Floats) -> float:
        return float(self.a * at[0] + self.b * at[1] + self.c * at[0] * at[1] + self.d)

    def fx(self, at: Floats) -> float:
        return float(self.a + self.c * at[1])

    def fy(self, at: Floats) -> float:
        return float(self.b + self.c * at[0])

    @property
    def product(self) -> float:
        return self.a * self.b - self.c * self.d


def arcs_of(values: Floats, level: float) -> Iterator[Arc]:
    result = contour.lines(values, UNIT, UNIT, level, shoulder=True)
    for k, (first, last) in enumerate(zip(result.offsets[:-1], result.offsets[1:], strict=True)):
        if last - first == 3:
            yield Arc(values, level, result.points[first:last], result.bend[first - k : last - 1 - k])


def random_arcs(seed: int, number: int = 400, least: float = 0.05) -> list[Arc]:
    """Arcs that are neither short nor nearly straight, for the formulas that divide by c, alpha and beta."""
    random, found = np.random.default_rng(seed), list[Arc]()
    while len(found) < number:
        for arc in arcs_of(random.uniform(-1, 1, (2, 2)), float(random.uniform(-0.3, 0.3))):
            if np.abs(arc.q - arc.p).min() > least and abs(arc.c) > least and abs(arc.product) > 1e-3:
                found.append(arc)
    return found


def side(start: Floats, end: Floats, at: Floats) -> float:
    """Twice the area of the triangle, signed."""
    (x0, y0), (x1, y1) = start.tolist(), end.tolist()
    return float((x1 - x0) * (at[1] - y0) - (y1 - y0) * (at[0] - x0))


def tangents_meet(arc: Arc) -> Floats:
    """T by (3.12)-(3.14), as printed."""
    p, q = arc.p, arc.q
    alpha = -arc.fx(p) * p[0] - arc.fy(p) * p[1]
    beta = -arc.fx(q) * q[0] - arc.fy(q) * q[1]
    below = arc.fx(p) * arc.fy(q) - arc.fy(p) * arc.fx(q)
    return np.array([arc.fy(p) * beta - arc.fy(q) * alpha, arc.fx(q) * alpha - arc.fx(p) * beta]) / below


def saddle_of(arc: Arc) -> Floats:
    return np.array([-arc.b / arc.c, -arc.a / arc.c])


# --- 3.2: the bilinear cell


def test_equation_3_2_and_3_27_coefficients_of_the_thesis_cell() -> None:
    assert [float(z) for z in bilinear.coefficients(*CORNERS)] == [6.0, 9.0, -20.0, 15.0]
    for u, v in np.random.default_rng(0).random((20, 2)):
        assert bilinear.value(*CORNERS, u, v) == pytest.approx(6 * u + 9 * v - 20 * u * v + 15, rel=1e-14)


def test_equation_3_3_gradient() -> None:
    fx, fy = bilinear.gradient(*CORNERS, 0.25, 0.5)
    assert (fx, fy) == pytest.approx((6 - 20 * 0.5, 9 - 20 * 0.25), rel=1e-15)


def test_equation_3_4_saddle_of_the_thesis_cell() -> None:
    assert bilinear.saddle(*CORNERS) == pytest.approx((0.45, 0.3, 17.7), rel=1e-15)
    assert bilinear.value(*CORNERS, 0.5, 0.5) == 17.5
    assert np.isnan(bilinear.saddle(0.0, 1.0, 2.0, 3.0)).all()  # linear: there is none
    result = contour.lines(THESIS_CELL, UNIT, UNIT, LEVEL)
    assert result.saddle_cell.tolist() == [0]
    assert result.saddle_margin == pytest.approx([17.7 - LEVEL], rel=1e-13)
    f00, f10, f01, f11 = THESIS_CELL.ravel() - LEVEL
    det = bilinear.determinant(*CORNERS, LEVEL)
    assert det / (f00 + f11 - f01 - f10) == pytest.approx(0.1, rel=1e-13)


def test_section_3_2_1_the_decider_joins_10_and_01_where_the_mean_of_the_corners_does_not() -> None:
    ends = {tuple(sorted((tuple(a.p), tuple(a.q)))) for a in arcs_of(THESIS_CELL, LEVEL)}
    cut_off = {(0.0, 0.0): False, (1.0, 1.0): False}
    for p, q in ends:
        for corner in cut_off:
            cut_off[corner] |= all(np.any(np.array(end) == corner) for end in (p, q))
    assert len(ends) == 2 and all(cut_off.values())
    mean_above, saddle_above = THESIS_CELL.mean() >= LEVEL, bilinear.saddle(*CORNERS)[2] >= LEVEL
    assert saddle_above and not mean_above  # figure 3.9: the four triangles are wrong here


@pytest.mark.parametrize("bits", range(16))
def test_figure_3_1_configurations(bits: int) -> None:
    values = np.array([[1.0 if bits >> k & 1 else -1.0 for k in (0, 1)], [1.0 if bits >> k & 1 else -1.0 for k in (2, 3)]])
    for joined, bump in ((True, 1.0), (False, -1.0)):  # ambiguous: the saddle a little above, or below
        cell = np.where(values > 0, values + 0.2 * bump, values)
        pieces = len(contour.lines(cell, UNIT, UNIT, 0.0).offsets) - 1
        assert pieces == {0: 0, 15: 0, 6: 2, 9: 2}.get(bits, 1)
        if bits in (6, 9):
            corners_cut = {tuple(np.where(np.isin(a.p, [0, 1]), a.p, a.q).round()) for a in arcs_of(cell, 0.0)}
            low = {(0.0, 0.0), (1.0, 1.0)} if bits == 6 else {(1.0, 0.0), (0.0, 1.0)}
            assert (corners_cut == low) == joined


# --- 3.3.1: the shoulder point


def test_proposition_3_3_1_2_and_equation_3_5_constant_product() -> None:
    for arc in random_arcs(1):
        for t in (0.0, 0.2, 0.5, 0.9, 1.0):
            at = arcs.point(arc.p, arc.q, 2 * arc.bends[0], t)
            assert arc.f(at) == pytest.approx(0, abs=1e-14)
            assert arc.fx(at) * arc.fy(at) == pytest.approx(arc.product, rel=1e-11)
        assert -arc.determinant == pytest.approx(arc.product, rel=1e-11)


def test_equations_3_6_and_3_7_the_shoulder_is_on_the_line_from_m_to_s() -> None:
    for arc in random_arcs(2):
        m = (arc.p + arc.q) / 2
        alpha, beta = saddle_of(arc) - m
        roots = np.roots([arc.c * alpha * beta, arc.a * alpha + arc.b * beta + arc.c * (m[0] * beta + m[1] * alpha), arc.f(m)])
        inside = [t.real for t in roots if abs(t.imag) < 1e-12 and 0 < t.real < 1]
        assert len(inside) == 1
        assert arc.r == pytest.approx(m + inside[0] * np.array([alpha, beta]), abs=1e-11)


def test_equations_3_8_to_3_14_and_proposition_3_3_1_3_m_t_s_and_r_are_collinear() -> None:
    for arc in random_arcs(3):
        m, t, s = (arc.p + arc.q) / 2, tangents_meet(arc), saddle_of(arc)
        assert arc.fx(arc.p) * (t[0] - arc.p[0]) + arc.fy(arc.p) * (t[1] - arc.p[1]) == pytest.approx(0, abs=1e-11)
        assert arc.fx(arc.q) * (t[0] - arc.q[0]) + arc.fy(arc.q) * (t[1] - arc.q[1]) == pytest.approx(0, abs=1e-11)
        for point in (t, arc.r):
            size = np.linalg.norm(s - m) * max(1.0, float(np.linalg.norm(point - m)))
            assert side(m, s, point) == pytest.approx(0, abs=1e-10 * float(size))


def test_equations_3_17_to_3_21_slopes_of_mt_and_ms() -> None:
    for arc in random_arcs(4):
        xp, yp, xq, yq = arc.fx(arc.p), arc.fy(arc.p), arc.fx(arc.q), arc.fy(arc.q)
        m, s = (arc.p + arc.q) / 2, saddle_of(arc)
        assert m == pytest.approx([(yp + yq - 2 * arc.b) / (2 * arc.c), (xp + xq - 2 * arc.a) / (2 * arc.c)], abs=1e-13)
        slope_ms = (xp + xq) / (yp + yq)  # (3.20)
        assert (s - m)[1] / (s - m)[0] == pytest.approx(slope_ms, rel=1e-9)
        above = -3 * xp * yp * xq + 3 * xp * xq * yq - xp**2 * yq + yp * xq**2
        below = -3 * yp * xq * yq + 3 * xp * yp * yq - xp * yq**2 + yp**2 * xq
        if abs(below) > 1e-4:
            assert above / below == pytest.approx(slope_ms, rel=1e-7)  # (3.19)
        zero = [xp * xq * yq * yq, -xp * yp * yp * xq, yp * xq * xq * yq, -xp * xp * yp * yq]
        assert sum(zero) == pytest.approx(0, abs=1e-12 * max(map(abs, zero)))  # (3.21)


def test_equations_3_22_to_3_26_the_tangent_at_the_shoulder_is_parallel_to_the_chord() -> None:
    for arc in random_arcs(5):
        alpha, beta = arc.q - arc.p
        fx = math.copysign(math.sqrt(-arc.product * beta / alpha), arc.fx(arc.p))  # (3.24)
        fy = arc.product / fx
        assert arc.r == pytest.approx([(fy - arc.b) / arc.c, (fx - arc.a) / arc.c], abs=1e-11)  # (3.25)
        assert arc.r == pytest.approx(np.array([fy, fx]) / arc.c + saddle_of(arc), abs=1e-11)  # (3.26)
        assert arc.fx(arc.r) * alpha + arc.fy(arc.r) * beta == pytest.approx(0, abs=1e-12)  # (3.22)
        assert arc.fx(arc.r) * arc.fy(arc.r) == pytest.approx(arc.product, rel=1e-10)  # (3.23)


def test_section_3_3_1_the_shoulder_is_farthest_from_the_chord_and_leaves_the_least_area() -> None:
    t = np.linspace(0, 1, 1001)[1:-1]
    for arc in random_arcs(6, 60):
        bend = 2 * arc.bends[0]
        at = arcs.point(arc.p, arc.q, bend, t)
        far = np.abs([side(arc.p, arc.q, point) for point in at])
        assert abs(side(arc.p, arc.q, arc.r)) >= far.max() * (1 - 1e-13)
        (dx, dy), (ex, ey) = (at - arc.p).T, (arc.q - at).T
        left = arcs.area(dx, dy, bend * t) + arcs.area(ex, ey, bend * (1 - t))
        best = area_left(arc)
        assert (left >= best * (1 - 1e-12)).all()
        others = np.abs(t - 0.5) > 0.1
        assert (left[others] > best * 1.01).all()  # moving R along the arc either way raises the area


# --- 3.4, 3.5: figures and the error metric


def test_figure_3_9_shoulder_points_and_areas() -> None:
    drawn = sorted(arcs_of(THESIS_CELL, LEVEL), key=lambda arc: arc.r[0])
    expected = [
        [(0, 0.28888889), (0.3633975, 0.2422650), (0.43333333, 0), 0.050928223, 0.008539327],
        [(1, 0.30909091), (0.5126783, 0.3797724), (0.45714286, 1), 0.170748505, 0.021585992],
    ]
    for arc, (p, r, q, basic, new) in zip(drawn, expected, strict=True):
        assert arc.p == pytest.approx(p, abs=5e-9) and arc.q == pytest.approx(q, abs=5e-9)
        assert arc.r == pytest.approx(r, abs=5e-8)
        assert area_of(arc.p, arc.q, 2 * arc.bends[0]) == pytest.approx(basic, abs=5e-10)
        assert area_left(arc) == pytest.approx(new, abs=5e-10)


def exact_area(values: Floats, level: float, p: Floats, q: Floats) -> float:
    """Area between chord and contour by (3.28) and (3.29), as printed, with 60 digits; P and Q are exact."""
    f00, f10, f01, f11 = (Fraction(v) for v in values.ravel().tolist())
    a, b, c, d = f10 - f00, f01 - f00, f00 + f11 - f10 - f01, f00 - Fraction(level)

    def exact(end: Floats) -> tuple[Fraction, Fraction]:
        x, y = map(Fraction, end.tolist())
        return (-(b * y + d) / (a + c * y), y) if y in (0, 1) else (x, -(a * x + d) / (b + c * x))

    def primitive(x: Fraction) -> Decimal:
        return (decimals(-a * x) + decimals(a * b / c - d) * decimals(abs(b + c * x)).ln()) / decimals(c)

    (xp, yp), (xq, yq) = exact(p), exact(q)
    return float(abs(primitive(xq) - primitive(xp) - decimals((yp + yq) / 2 * (xq - xp))))


def decimals(number: Fraction) -> Decimal:
    return Decimal(number.numerator) / Decimal(number.denominator)


def area_of(p: Floats, q: Floats, bend: float) -> float:
    return float(arcs.area(q[0] - p[0], q[1] - p[1], bend))


def sagitta_of(p: Floats, q: Floats, bend: float) -> float:
    return float(arcs.sagitta(q[0] - p[0], q[1] - p[1], bend))


def area_left(arc: Arc) -> float:
    """Between the exact arc and P, R, Q."""
    steps = np.diff([arc.p, arc.r, arc.q], axis=0)
    return float(arcs.area(steps[:, 0], steps[:, 1], arc.bends).sum())


def test_equations_3_28_and_3_29_the_area_in_60_digits() -> None:
    """Cells of any bend, c down to 1e-9, where (3.29) in floats is worth nothing."""
    random, seen = np.random.default_rng(7), 0
    for _ in range(600):
        values = random.uniform(-1, 1, (2, 2))
        small = 10.0 ** random.integers(-9, 1)
        values[1, 1] = values[0, 1] + values[1, 0] - values[0, 0] + small * random.uniform(-1, 1)
        level = float(random.uniform(-0.3, 0.3))
        result = contour.lines(values, UNIT, UNIT, level, shoulder=False)
        for k in range(len(result.bend)):
            p, q = result.points[result.offsets[k] : result.offsets[k + 1]]
            if np.abs(q - p).min() > 1e-2:  # differences of rounded places are good to 1e-14
                area = exact_area(values, level, p, q)
                assert area_of(p, q, result.bend[k]) == pytest.approx(area, rel=1e-12, abs=0)
                seen += 1
    assert seen > 200


def test_equation_3_29_the_worked_line_with_a_small_c() -> None:
    for c in (1e-3, 1e-6, 1e-9):
        values = np.array([[0.0, 1.0], [2.0, 3.0 + c]])
        result = contour.lines(values, UNIT, UNIT, 1.2, shoulder=False)
        p, q = result.points
        assert area_of(p, q, result.bend[0]) == pytest.approx(exact_area(values, 1.2, p, q), rel=1e-12)
        if c == 1e-6:
            assert area_of(p, q, result.bend[0]) == pytest.approx(4.17e-8, rel=1e-3)


def test_section_3_5_1_the_area_is_at_least_quartered_on_every_arc() -> None:
    random, ratios = np.random.default_rng(8), []
    for _ in range(3000):
        for arc in arcs_of(random.standard_normal((2, 2)), float(random.normal(0, 0.5))):
            steps = np.diff([arc.p, arc.r, arc.q], axis=0)
            if np.abs(steps).min() > 1e-6:
                basic = area_of(arc.p, arc.q, 2 * arc.bends[0])
                ratios.append(basic / arcs.area(steps[:, 0], steps[:, 1], arc.bends).sum())
    assert len(ratios) > 2000 and min(ratios) >= 4 * (1 - 1e-9)
    assert min(ratios) < 4.0001 and max(ratios) > 8  # near the limit of flat arcs; bent ones gain more


def test_section_3_5_1_the_largest_deviation() -> None:
    for arc in random_arcs(9, 100):
        bend = 2 * arc.bends[0]
        at = arcs.point(arc.p, arc.q, bend, np.linspace(0, 1, 2001))
        chord = np.hypot(*(arc.q - arc.p))
        off = max(abs(side(arc.p, arc.q, point)) for point in at) / chord
        assert sagitta_of(arc.p, arc.q, bend) == pytest.approx(off, rel=1e-12)
        assert sagitta_of(arc.p, arc.q, bend) == pytest.approx(abs(side(arc.p, arc.q, arc.r)) / chord, rel=1e-10)


def test_figure_3_11b_the_dust_lies_between_the_drawn_line_and_the_exact_one() -> None:
    result = contour.lines(THESIS_CELL, UNIT, UNIT, LEVEL)
    start = result.points[[0, 1, 3, 4]]
    end = result.points[[1, 2, 4, 5]]
    counts = np.array([500] * 4)
    dust = arcs.uniform(start, end, result.bend, counts, np.random.default_rng(0))
    exact_side = np.sign(bilinear.value(*CORNERS, dust[:, 0], dust[:, 1]) - LEVEL)
    arc = np.repeat(np.arange(4), counts)
    drawn_side = np.sign([side(start[k], end[k], at) for k, at in zip(arc, dust, strict=True)])
    # high is on the left of the line: in between, one of the two says high and the other low
    assert (exact_side * drawn_side == -1).all()
