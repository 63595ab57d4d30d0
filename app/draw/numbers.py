"""Numbers as they stand in pictures: two digits, real minus, thin spaces, the unit after a space; ticks at round places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Decimal
from itertools import pairwise

THIN = "\u2009"
SPACE = "\u00a0"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def significant(value: float, digits: int = 2, *, up: bool = False) -> str:
    """The number to so many significant digits.

    Parameters
    ----------
    up : round up, so that a bound stays a bound
    """
    if math.isnan(value):
        return "?"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    exact = Decimal(repr(float(value)))
    first = exact.adjusted()
    step = Decimal(1).scaleb(first - digits + 1)
    if up:
        exact -= abs(exact) * Decimal("1e-12")  # what is a hair above a round number is that number, not the next
    rounded = exact.quantize(step, rounding=ROUND_CEILING if up else ROUND_HALF_EVEN)
    first = rounded.adjusted()
    if first >= 6 or first < -3:
        mantissa = rounded.scaleb(-first)
        text = f"{mantissa:.{digits - 1}f}".rstrip("0").rstrip(".")
        return f"{text.replace('-', '−')}{THIN}×{THIN}10{str(first).translate(_RAISED)}"
    places = max(0, digits - 1 - first)
    text = f"{rounded:.{places}f}"
    if "." in text and abs(rounded - exact) <= abs(exact) * Decimal("1e-9"):
        text = text.rstrip("0").rstrip(".")  # 0.5 is 0.5: a nought would claim a digit that is not there
    return grouped(text)


def grouped(text: str) -> str:
    """A decimal number with real minus and thin spaces between thousands, from five digits on."""
    minus = "−" if text.startswith("-") else ""
    whole, dot, rest = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", THIN)
    return minus + whole + dot + rest


def power(exponent: int) -> str:
    """A power of ten."""
    return f"10{str(exponent).translate(_RAISED)}"


def count(n: int) -> str:
    """A number of things."""
    return grouped(str(n))


def quantity(value: float, unit: str, *, up: bool = False, digits: int = 2) -> str:
    """A number with its unit, many metres in kilometres and many square metres in square kilometres."""
    larger = {"m": ("km", 1e3, 1e5), "m²": ("km²", 1e6, 1e5)}
    if unit in larger and math.isfinite(value) and abs(value) >= larger[unit][2]:
        unit, by, _ = larger[unit]
        value /= by
    if value == 0:
        return "0"  # nothing needs no unit
    return with_unit(significant(value, digits, up=up), unit)


def with_unit(text: str, unit: str) -> str:
    """The unit after a space that does not break."""
    return f"{text}{SPACE}{unit}" if unit else text


def plural(n: int, one: str) -> str:
    """"1 place", "24 places"."""
    return f"{count(n)} {one}{'' if n == 1 else 's'}"


def step_for(span: float, wanted: int) -> float:
    """The round step, 1, 2 or 5 times a power of ten, that gives about the wanted number of intervals."""
    if not span > 0 or not math.isfinite(span):
        return 1.0
    raw = span / max(1, wanted)
    power: float = 10.0 ** math.floor(math.log10(raw))
    return min((m * power for m in (1.0, 2.0, 5.0, 10.0)), key=lambda s: abs(math.log(s / raw)))


def ticks(low: float, high: float, wanted: int) -> list[float]:
    """Round places from `low` to `high`, about `wanted` intervals."""
    step = step_for(high - low, wanted)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def decades(low: float, high: float) -> list[float]:
    """Powers of ten from `low` to `high`, thinned to five at most; the ends if there is none."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    if last - first < 1:
        return [low, high]
    stride = max(1, math.ceil((last - first) / 4))
    return [10.0**p for p in range(first, last + 1, stride)]


def labels(values: Sequence[float]) -> list[str]:
    """Labels of ticks, all with as many decimals as the finest needs."""
    if not values:
        return []
    largest = max(abs(v) for v in values)
    step = min((b - a for a, b in pairwise(values)), default=largest) or largest or 1.0
    if largest >= 1e7 or (0 < largest < 1e-3):
        power = math.floor(math.log10(largest))
        places = max(0, math.ceil(power - math.log10(abs(step)) - 1e-9))
        return [
            "0" if v == 0 else f"{grouped(f'{v / 10.0**power:.{places}f}')}{THIN}×{THIN}10{str(power).translate(_RAISED)}"
            for v in values
        ]
    places = max(0, -math.floor(math.log10(abs(step)) + 1e-9))
    if any(abs(v * 10**places - round(v * 10**places)) > 1e-6 for v in values):
        places += 1
    return [grouped(f"{v:.{places}f}" if round(v, places) else "0") for v in values]


def along(values: Sequence[float]) -> list[str]:
    """Numbers of a colour bar, to a hundredth of its length."""
    span = max(values) - min(values)
    largest = max(abs(v) for v in values)
    if not 0 < span < math.inf or largest >= 1e7 or span < 1e-4:
        return [significant(v, 3) for v in values]
    places = max(0, 2 - math.floor(math.log10(span)))
    texts = [f"{v:.{places}f}" for v in values]
    while places and all(t.endswith("0") for t in texts):
        places -= 1
        texts = [t[:-1].rstrip(".") for t in texts]
    return [grouped("0" if float(t) == 0 else t) for t in texts]


def display_unit(unit: str, span: float) -> tuple[str, float]:
    """(unit to show, factor by which values are divided): km instead of many metres."""
    if unit == "m" and span >= 5000:
        return "km", 1000.0
    return unit, 1.0
