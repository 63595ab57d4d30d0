"""Arcs of hyperbolas, against decimal arithmetic of 60 digits and against dense sampling."""

import math
from decimal import Decimal, getcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modules.kernels import arcs

getcontext().prec = 60
BENDS = [0.0, 1e-300, 1e-15, 1e-9, 1e-4, 0.03, 0.5, 0.999, 1.0, 1.001, 2.0, 7.0, 40.0, 300.0, 745.0, arcs.TURN]
bends = st.sampled_from(BENDS) | st.floats(1e-12, 60.0)
sides = st.floats(1e-3, 10.0)
signs = st.sampled_from([-1.0, 1.0])


def area_in_decimals(dx: float, dy: float, w: float) -> float:
    rectangle, bend = abs(Decimal(dx) * Decimal(dy)), Decimal(w)
    if w < 1e-12:  # 60 digits would not be enough
        return float(rectangle * bend / 6)
    sinh = (bend.exp() - (-bend).exp()) / 2
    half = ((bend / 2).exp() - (-bend / 2).exp()) / 2
    return float(rectangle * (sinh - bend) / (4 * half * half))


@settings(derandomize=True, max_examples=300, deadline=None)
@given(sides, sides, bends)
def test_area_is_right_for_every_bend(dx: float, dy: float, w: float) -> None:
    assert arcs.area(dx, -dy, -w) == pytest.approx(area_in_decimals(dx, dy, w), rel=1e-13, abs=1e-320)


def test_area_of_a_right_angle_is_half_the_rectangle_and_of_a_chord_nothing() -> None:
    assert arcs.area(3.0, -2.0, arcs.TURN) == 3.0
    assert arcs.area(3.0, -2.0, 0.0) == 0.0


@settings(derandomize=True, max_examples=200, deadline=None)
@given(sides, sides, signs, signs, bends, signs)
def test_halving_leaves_at_most_a_quarter(dx: float, dy: float, sx: float, sy: float, w: float, sw: float) -> None:
    p, q = np.zeros(2), np.array([sx * dx, sy * dy])
    r = arcs.point(p, q, sw * w, 0.5)
    left = arcs.area(r[0], r[1], w / 2) + arcs.area(q[0] - r[0], q[1] - r[1], w / 2)
    # a bend so large that R lies on the corner in floats leaves rounding
    assert left <= arcs.area(dx, dy, w) / 4 * (1 + 1e-12) + 1e-15 * dx * dy * max(1.0, -math.log(1e-16))


def test_the_points_of_an_arc_lie_on_its_hyperbola() -> None:
    for w in (-7.0, -0.5, 1e-9, 0.3, 4.0, 30.0):
        dx, dy = 2.0, -0.7
        x_p, y_p = dx / math.expm1(w), dy / math.expm1(-w)  # from the saddle
        at = arcs.point(np.array([x_p, y_p]), np.array([x_p + dx, y_p + dy]), w, np.linspace(0, 1, 50))
        size = np.abs(at)
        off = np.abs(at[:, 0] * at[:, 1] - x_p * y_p)
        assert (off <= 1e-15 * (size[:, 0] * size[:, 1].max() + size[:, 1] * size[:, 0].max())).all()
        assert np.allclose(at[:, 0], x_p * np.exp(w * np.linspace(0, 1, 50)), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("w", [0.0, 1e-17, 0.1, 40.0, arcs.TURN])
@pytest.mark.parametrize("sign", [-1, 1])
def test_ends_are_exact_and_a_right_angle_turns_at_the_corner(w: float, sign: int) -> None:
    p, q = np.array([0.1, 0.7]), np.array([0.3, 1e9])
    assert (arcs.point(p, q, sign * w, 0.0) == p).all()
    assert (arcs.point(p, q, sign * w, 1.0) == q).all()
    if w == arcs.TURN:
        corner = [p[0], q[1]] if sign > 0 else [q[0], p[1]]
        assert (arcs.point(p, q, sign * w, 0.5) == corner).all()


@settings(derandomize=True, max_examples=100, deadline=None)
@given(sides, sides, signs, st.floats(1e-3, 30.0), signs)
def test_sagitta_and_length_against_dense_sampling(dx: float, dy: float, sy: float, w: float, sw: float) -> None:
    p, q = np.zeros(2), np.array([dx, sy * dy])
    t = np.linspace(0, 1, 20001)
    at = arcs.point(p, q, sw * w, t)
    distance = np.abs(at[:, 0] * q[1] - at[:, 1] * q[0]) / math.hypot(dx, dy)
    assert arcs.sagitta(dx, sy * dy, sw * w) == pytest.approx(distance.max(), rel=1e-6)
    assert abs(t[distance.argmax()] - 0.5) < 0.01 or w > 10
    chords = [np.hypot(*np.diff(at[::step], axis=0).T).sum() for step in (1, 2)]
    assert arcs.length(dx, sy * dy, sw * w) == pytest.approx((4 * chords[0] - chords[1]) / 3, rel=1e-8)


def test_length_at_its_ends() -> None:
    assert arcs.length(3.0, -4.0, 0.0) == 5.0
    assert arcs.length(3.0, -4.0, arcs.TURN) == pytest.approx(7.0, rel=1e-14)
    assert arcs.length(0.0, -4.0, 2.0) == 4.0
    assert arcs.length(0.0, 0.0, 2.0) == 0.0
    # X Y = 1 from (1, 1) to (2, 1/2), by Simpson's rule on sqrt(1 + X^-4)
    x = np.linspace(1, 2, 4001)
    f = np.sqrt(1 + x**-4.0)
    simpson = (f[0] + f[-1] + 4 * f[1::2].sum() + 2 * f[2:-1:2].sum()) * (x[1] - x[0]) / 3
    assert arcs.length(1.0, -0.5, math.log(2.0)) == pytest.approx(simpson, rel=1e-13)
    both = [arcs.length(0.5, -2.0, w) for w in (2.4999999, 2.5000001)]  # one piece or two
    assert both[0] == pytest.approx(both[1], rel=1e-7)


def test_halvings_are_enough_and_one_less_is_not_for_a_flat_arc() -> None:
    dx, dy, w = 1.0, 1.0, 1e-3
    area = arcs.area(dx, dy, w)
    assert arcs.halvings(area, area) == 0
    assert arcs.halvings([4.0**5, 0.0, 17.0], 1.0).tolist() == [5, 0, 3]
    n = int(arcs.halvings(area, area / 1000))
    ends = arcs.point(np.zeros(2), np.array([dx, dy]), w, np.linspace(0, 1, 2**n + 1))
    step = np.diff(ends, axis=0)
    assert arcs.area(step[:, 0], step[:, 1], w / 2**n).sum() <= area / 1000 < area / 4.0 ** (n - 1)
    with pytest.raises(ValueError, match="positive"):
        arcs.halvings(1.0, 0.0)


@pytest.mark.parametrize("w", [1e-3, -0.7, 5.0, -30.0])
def test_dust_lies_strictly_between_and_evenly(w: float) -> None:
    p, q, n = np.array([1.0, 2.0]), np.array([4.0, 1.0]), 40_000
    dust = arcs.uniform(p[None], q[None], np.array([w]), np.array([n]), np.random.default_rng(1))
    x, y = dust[:, 0], dust[:, 1]
    chord = 2 + (x - 1) / 3 * -1
    # the arc above or below x, from t(x)
    share = (x - 1) / 3
    t = np.log1p(share * math.expm1(w)) / w
    arc = arcs.point(p, q, w, t)[:, 1]
    assert ((y - chord) * (y - arc) < 0).all()
    # even: within the region the share of the height is uniform, and x has the height as its density
    height = (y - chord) / (arc - chord)
    assert np.histogram(height, 10, (0, 1))[0] == pytest.approx(n / 10, abs=5 * math.sqrt(n / 10))
    edges = np.linspace(1, 4, 11)
    fine = np.linspace(1, 4, 20_001)
    t_fine = np.log1p((fine - 1) / 3 * math.expm1(w)) / w
    gap = np.abs(arcs.point(p, q, w, t_fine)[:, 1] - (2 - (fine - 1) / 3))
    swept = np.concatenate([[0], np.cumsum((gap[1:] + gap[:-1]) / 2)])
    expected = np.diff(np.interp(edges, fine, swept / swept[-1])) * n
    assert np.abs(np.histogram(x, edges)[0] - expected).max() < 5 * math.sqrt(n / 10)


def test_dust_comes_in_the_order_of_the_arcs_from_a_named_source() -> None:
    start = np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]])
    end, bend, counts = start + 1.0, np.array([1.0, 0.0, -2.0]), np.array([2, 0, 3])
    one, two = (arcs.uniform(start, end, bend, counts, np.random.default_rng(3)) for _ in range(2))
    assert (one == two).all() and (one[:2, 0] < 1).all() and (one[2:, 0] > 20).all() and len(one) == 5
    assert arcs.uniform(start, end, bend, np.zeros(3, int), np.random.default_rng(3)).shape == (0, 2)
