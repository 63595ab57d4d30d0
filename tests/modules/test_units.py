"""Units as files write them: read, compared, converted; what does not fit is refused."""

from __future__ import annotations

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modules.data.units import NAMES, PREFIXES, UnitError, factor, known, linear, parse, same


@pytest.mark.parametrize(("one", "other"), [
    ("m s-1", "m/s"), ("m s**-1", "m·s⁻¹"), ("m.s-1", "meters per second"), ("kg m-2 s-1", "g m^-2 ms^-1"),
    ("degrees_north", "°"),     ("hPa", "millibar"), ("mbar", "hPa"),
    ("1", ""), ("N m", "J"), ("W m-2", "J s-1 m-2"), ("0.01 m", "cm"), ("10^-2 m", "cm"),
    ("degC", "celsius"), ("Days", "d"), ("m2 s-2", "J/kg"), ("µm²", "um2"), ("feet", "ft"), ("kilometers", "km"),
    ("percent", "%"),
])  # fmt: skip
def test_spellings_of_one_unit_are_one(one: str, other: str) -> None:
    assert same(one, other) and factor(one, other) == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize(("unit", "into", "wanted"), [
    ("km", "m", 1e3), ("ft", "m", 0.3048), ("nmi", "km", 1.852), ("kn", "m/s", 1852 / 3600), ("h", "s", 3600.0),
    ("degree", "rad", pi / 180), ("%", "1", 0.01), ("atm", "hPa", 1013.25), ("degF", "K", 5 / 9), ("g/cm3", "kg m-3", 1e3),
    ("mm/day", "m/s", 1e-3 / 86400), ("eV", "J", 1.602176634e-19), ("L", "m3", 1e-3), ("Sv", "m3/s", 1e6), ("dam", "m", 10.0),
])  # fmt: skip
def test_differences_are_converted(unit: str, into: str, wanted: float) -> None:
    assert factor(unit, into) == pytest.approx(wanted, rel=1e-14)
    assert factor(into, unit) == pytest.approx(1 / wanted, rel=1e-14)


@pytest.mark.parametrize(("value", "unit", "into", "wanted"), [
    (25, "degC", "K", 298.15), (0, "K", "degC", -273.15), (212, "degF", "degC", 100), (32, "°F", "K", 273.15),
    (3, "km", "m", 3000),
])  # fmt: skip
def test_temperatures_have_an_offset_and_differences_none(value: float, unit: str, into: str, wanted: float) -> None:
    scale, offset = linear(unit, into)
    assert scale * value + offset == pytest.approx(wanted, abs=1e-9)
    assert not parse(f"{unit} s-1").offset


@pytest.mark.parametrize(("unit", "into", "words"), [
    ("m", "s", "different things"), ("degree", "1", "different things"), ("m", "furlongs", "furlongs"), ("m!", "m", "'!'"),
])  # fmt: skip
def test_what_does_not_fit_is_refused(unit: str, into: str, words: str) -> None:
    with pytest.raises(UnitError, match=words):
        factor(unit, into)
    assert not same(unit, into)


def test_units_that_nobody_knows_are_the_same_if_they_are_spelled_so() -> None:
    assert same("hounsfield", "hounsfield") and not same("hounsfield", "m") and not known("hounsfield")


@given(st.sampled_from(sorted(NAMES)), st.integers(-3, 3).filter(bool), st.sampled_from(sorted(NAMES)))
def test_products_multiply_and_powers_raise(name: str, power: int, other: str) -> None:
    got, one, two = parse(f"{name}{power} {other}"), parse(name), parse(other)
    assert got.factor == pytest.approx(one.factor**power * two.factor)
    assert got.powers == tuple(a * power + b for a, b in zip(one.powers, two.powers, strict=True))


@pytest.mark.parametrize("prefix", sorted(PREFIXES))
def test_a_prefix_scales(prefix: str) -> None:
    assert factor(f"{prefix}W", "W") == pytest.approx(PREFIXES[prefix], rel=1e-12)
