"""Formulas over intervals: what values an expression can take while its names lie between two ends.

Each operation gives an interval that holds all outcomes, rounded outwards; where it has none, or knows none, the whole line.

Source: Moore 1966, Interval Analysis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from modules.data.expression import FUNCTIONS, Floats, Node, order

Interval = tuple[Floats, Floats]
Bools = NDArray[np.bool_]

EPS = 8 * np.finfo(float).eps
"""Relative rounding that one operation may add; functions of libraries are within a few last places."""


def enclosed(roots: Sequence[Node], ends: Mapping[str, Interval]) -> list[Interval]:
    """For each expression the (low, high) between which its values lie, while each name lies between its ends.

    Parameters
    ----------
    ends : name -> (low, high) arrays that broadcast
    """
    found: dict[int, Interval] = {}
    with np.errstate(all="ignore"):
        for node in order(*roots):
            if node.what == "number":
                one = np.asarray(node.number)
                found[id(node)] = (one, one)
            elif node.what.startswith("$"):
                low, high = ends[node.what[1:]]
                found[id(node)] = (np.asarray(low, float), np.asarray(high, float))
            else:
                found[id(node)] = _outward(*_of(node, [found[id(one)] for one in node.inputs]))
    return [found[id(root)] for root in roots]


JUMPING = ("floor", "ceil", "sign", "and", "or", "not", "<", "<=", ">", ">=", "==", "!=")


def steady(root: Node, ends: Mapping[str, Interval]) -> Bools:
    """Whether an expression has no jump while its names lie between their ends: all steps and conditions stay as they are."""
    jumps = [node for node in order(root) if node.what in (*JUMPING, "atan2")]
    conditions = [node.inputs[0] for node in order(root) if node.what == "where"]
    result: Bools = np.asarray(True)
    for node, (low, high) in zip(jumps, enclosed(jumps, ends), strict=True):
        result = result & (high - low < (2 * np.pi if node.what == "atan2" else 0.5))
    for inner in enclosed(conditions, ends):
        sure, possible = _truth(inner)
        result = result & (sure == possible)
    return result


def _outward(low: Floats, high: Floats) -> Interval:
    low, high = np.asarray(low, float), np.asarray(high, float)
    lost = np.isnan(low) | np.isnan(high)
    low = np.where(lost, -np.inf, low - EPS * np.abs(low))
    high = np.where(lost, np.inf, high + EPS * np.abs(high))
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def _of(node: Node, inner: list[Interval]) -> Interval:
    what = node.what
    if what in RISING:
        low, high = RISING[what]
        return _rising(what, inner[0], low, high)
    if what in ONE:
        return ONE[what](*inner[0])
    if what in TWO:
        return TWO[what](inner[0], inner[1])
    if what == "**":
        return _power(node, inner[0], inner[1])
    if what == "where":
        sure, possible = _truth(inner[0])
        (a, b), (c, d) = inner[1], inner[2]
        return (
            np.where(sure, a, np.where(possible, np.minimum(a, c), c)),
            np.where(sure, b, np.where(possible, np.maximum(b, d), d)),
        )
    return _logic(what, [_truth(one) for one in inner])


RISING: Mapping[str, tuple[float, float]] = {
    "sqrt": (0.0, math.inf), "exp": (-math.inf, math.inf), "log": (0.0, math.inf), "log10": (0.0, math.inf),
    "asin": (-1.0, 1.0), "atan": (-math.inf, math.inf), "sinh": (-math.inf, math.inf), "tanh": (-math.inf, math.inf),
    "floor": (-math.inf, math.inf), "ceil": (-math.inf, math.inf), "sign": (-math.inf, math.inf),
}  # fmt: skip
"""Functions that never fall -> where they are defined."""


def _rising(what: str, inner: Interval, low: float, high: float) -> Interval:
    outside = (inner[0] < low) | (inner[1] > high)
    compute = FUNCTIONS[what].compute
    return np.where(outside, np.nan, compute(inner[0])), np.where(outside, np.nan, compute(inner[1]))


def _abs(a: Floats, b: Floats) -> Interval:
    most = np.maximum(np.abs(a), np.abs(b))
    return np.where((a <= 0) & (b >= 0), 0.0, np.minimum(np.abs(a), np.abs(b))), most


def _cosh(a: Floats, b: Floats) -> Interval:
    low, high = _abs(a, b)
    return np.cosh(low), np.cosh(high)


def _cos(a: Floats, b: Floats) -> Interval:
    """A top lies at each even, a bottom at each odd multiple of pi."""
    one, other = np.cos(a), np.cos(b)
    slack = EPS * (1 + np.maximum(np.abs(a), np.abs(b)))
    first, last = np.ceil((a - slack) / np.pi), np.floor((b + slack) / np.pi)
    several = last - first >= 1
    even = (last >= first) & (first % 2 == 0)
    odd = (last >= first) & (first % 2 == 1)
    return (
        np.where(several | odd, -1.0, np.minimum(one, other) - slack),
        np.where(several | even, 1.0, np.maximum(one, other) + slack),
    )


def _sin(a: Floats, b: Floats) -> Interval:
    return _cos(a - np.pi / 2, b - np.pi / 2)


def _tan(a: Floats, b: Floats) -> Interval:
    slack = EPS * (1 + np.maximum(np.abs(a), np.abs(b)))
    pole = np.floor((a - slack) / np.pi + 0.5) != np.floor((b + slack) / np.pi + 0.5)
    return np.where(pole, np.nan, np.tan(a)), np.where(pole, np.nan, np.tan(b))


def _acos(a: Floats, b: Floats) -> Interval:
    return np.arccos(b), np.arccos(a)


def _negative(a: Floats, b: Floats) -> Interval:
    return -b, -a


ONE: Mapping[str, Callable[[Floats, Floats], Interval]] = {
    "neg": _negative, "abs": _abs, "cosh": _cosh, "cos": _cos, "sin": _sin, "tan": _tan, "acos": _acos,
}  # fmt: skip


def _sum(p: Interval, q: Interval) -> Interval:
    return p[0] + q[0], p[1] + q[1]


def _difference(p: Interval, q: Interval) -> Interval:
    return p[0] - q[1], p[1] - q[0]


def _product(p: Interval, q: Interval) -> Interval:
    corners = [np.where((x == 0) | (y == 0), 0.0, x * y) for x in p for y in q]
    return np.minimum.reduce(corners), np.maximum.reduce(corners)


def _quotient(p: Interval, q: Interval) -> Interval:
    pole = (q[0] <= 0) & (q[1] >= 0)
    low, high = _product(p, (1 / q[1], 1 / q[0]))
    return np.where(pole, np.nan, low), np.where(pole, np.nan, high)


def _hypot(p: Interval, q: Interval) -> Interval:
    (a, b), (c, d) = _abs(*p), _abs(*q)
    return np.asarray(np.hypot(a, c)), np.asarray(np.hypot(b, d))


def _angle(p: Interval, q: Interval) -> Interval:
    """atan2 of a box: its ends are at corners, unless the box meets the cut along the negative axis or the origin."""
    cut = (p[0] <= 0) & (p[1] >= 0) & (q[0] <= 0)
    corners = [np.arctan2(y, x) for y in p for x in q]
    return np.where(cut, -np.pi, np.minimum.reduce(corners)), np.where(cut, np.pi, np.maximum.reduce(corners))


def _least(p: Interval, q: Interval) -> Interval:
    return np.minimum(p[0], q[0]), np.minimum(p[1], q[1])


def _most(p: Interval, q: Interval) -> Interval:
    return np.maximum(p[0], q[0]), np.maximum(p[1], q[1])


def _known(sure: Bools, possible: Bools) -> Interval:
    """1 where it is sure, 0 where it cannot be."""
    return np.asarray(sure, np.float64), np.asarray(possible, np.float64)


def _below(p: Interval, q: Interval) -> Interval:
    return _known(p[1] < q[0], p[0] < q[1])


def _at_most(p: Interval, q: Interval) -> Interval:
    return _known(p[1] <= q[0], p[0] <= q[1])


def _equal(p: Interval, q: Interval) -> Interval:
    single = (p[0] == p[1]) & (q[0] == q[1]) & (p[0] == q[0])
    return _known(single, (p[0] <= q[1]) & (q[0] <= p[1]))


def _unequal(p: Interval, q: Interval) -> Interval:
    low, high = _equal(p, q)
    return 1 - high, 1 - low


TWO: Mapping[str, Callable[[Interval, Interval], Interval]] = {
    "+": _sum, "-": _difference, "*": _product, "/": _quotient, "hypot": _hypot, "atan2": _angle, "min": _least,
    "max": _most, "<": _below, "<=": _at_most, ">": lambda p, q: _below(q, p), ">=": lambda p, q: _at_most(q, p),
    "==": _equal, "!=": _unequal,
}  # fmt: skip


def _power(node: Node, p: Interval, q: Interval) -> Interval:
    exponent = node.inputs[1]
    if exponent.what == "number" and exponent.number == round(exponent.number):
        return _whole(p, int(exponent.number))
    corners = [np.power(x, y) for x in p for y in q]
    inside = (p[0] > 0) | ((p[0] >= 0) & (q[0] > 0))
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    return np.where(inside, low, np.nan), np.where(inside, high, np.nan)


def _whole(p: Interval, n: int) -> Interval:
    if n < 0:
        one = np.asarray(1.0)
        return _quotient((one, one), _outward(*_whole(p, -n)))
    if n % 2:
        return np.power(p[0], n), np.power(p[1], n)
    low, high = _abs(*p)
    return np.power(low, n), np.power(high, n)


def _truth(inner: Interval) -> tuple[Bools, Bools]:
    """(surely true, possibly true)."""
    return np.asarray((inner[0] > 0) | (inner[1] < 0)), np.asarray((inner[0] != 0) | (inner[1] != 0))


def _logic(what: str, inner: list[tuple[Bools, Bools]]) -> Interval:
    (sure, possible), *rest = inner
    if what == "not":
        return _known(~possible, ~sure)
    other_sure, other_possible = rest[0]
    if what == "and":
        return _known(sure & other_sure, possible & other_possible)
    return _known(sure | other_sure, possible | other_possible)
