"""Units as files write them, compared and converted: "m s-1", "m/s", "m·s⁻¹", "degrees_north", "0.01 K", "µm²".

Quantities travel in plain numbers with their unit as text; the text is read where two quantities meet.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from math import pi

BASE = ("m", "kg", "s", "A", "K", "mol", "cd", "rad")
"""What a unit is made of; an angle is a quantity of its own, so that degrees are not added to plain numbers."""

Powers = tuple[int, ...]


class UnitError(ValueError):
    """Units that are not known or do not fit; the sentence names both."""


@dataclass(frozen=True)
class Unit:
    """A unit in terms of the base: a number in it times `factor`, plus `offset`, is that number in base units.

    Parameters
    ----------
    factor, offset : to base units; an offset only for degrees of temperature
    powers : of m, kg, s, A, K, mol, cd, rad
    """

    factor: float = 1.0
    powers: Powers = (0,) * len(BASE)
    offset: float = 0.0

    def times(self, other: Unit, power: int = 1) -> Unit:
        """The product with a power of another one; an offset is lost, for differences have none."""
        powers = tuple(a + power * b for a, b in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * other.factor**power, powers)


def _of(factor: float, offset: float = 0.0, **powers: int) -> Unit:
    return Unit(factor, tuple(powers.get(name, 0) for name in BASE), offset)


NAMES: Mapping[str, Unit] = {
    "m": _of(1, m=1), "g": _of(1e-3, kg=1), "s": _of(1, s=1), "A": _of(1, A=1), "K": _of(1, K=1), "mol": _of(1, mol=1),
    "cd": _of(1, cd=1), "rad": _of(1, rad=1), "Hz": _of(1, s=-1), "N": _of(1, m=1, kg=1, s=-2), "Pa": _of(1, m=-1, kg=1, s=-2),
    "J": _of(1, m=2, kg=1, s=-2), "W": _of(1, m=2, kg=1, s=-3), "V": _of(1, m=2, kg=1, s=-3, A=-1), "C": _of(1, A=1, s=1),
    "T": _of(1, kg=1, s=-2, A=-1), "Bq": _of(1, s=-1), "Gy": _of(1, m=2, s=-2), "L": _of(1e-3, m=3), "l": _of(1e-3, m=3),
    "bar": _of(1e5, m=-1, kg=1, s=-2), "eV": _of(1.602176634e-19, m=2, kg=1, s=-2), "t": _of(1e3, kg=1),
}  # fmt: skip
"""Units that take a prefix."""

PLAIN: Mapping[str, Unit] = {
    "%": _of(1e-2), "percent": _of(1e-2), "ppm": _of(1e-6), "ppb": _of(1e-9),
    "°": _of(pi / 180, rad=1), "deg": _of(pi / 180, rad=1), "degree": _of(pi / 180, rad=1), "radian": _of(1, rad=1),
    "degrees_north": _of(pi / 180, rad=1), "degrees_east": _of(pi / 180, rad=1), "degree_north": _of(pi / 180, rad=1),
    "degree_east": _of(pi / 180, rad=1), "degrees_N": _of(pi / 180, rad=1), "degrees_E": _of(pi / 180, rad=1),
    "degree_N": _of(pi / 180, rad=1), "degree_E": _of(pi / 180, rad=1), "arcmin": _of(pi / 10800, rad=1),
    "arcsec": _of(pi / 648000, rad=1), "°C": _of(1, 273.15, K=1), "degC": _of(1, 273.15, K=1), "celsius": _of(1, 273.15, K=1),
    "deg_C": _of(1, 273.15, K=1), "degrees_C": _of(1, 273.15, K=1), "degreesC": _of(1, 273.15, K=1),
    "°F": _of(5 / 9, 459.67 * 5 / 9, K=1), "degF": _of(5 / 9, 459.67 * 5 / 9, K=1),
    "min": _of(60, s=1), "minute": _of(60, s=1), "h": _of(3600, s=1), "hr": _of(3600, s=1), "hour": _of(3600, s=1),
    "d": _of(86400, s=1), "day": _of(86400, s=1), "week": _of(604800, s=1), "second": _of(1, s=1), "sec": _of(1, s=1),
    "in": _of(0.0254, m=1), "inch": _of(0.0254, m=1), "ft": _of(0.3048, m=1), "foot": _of(0.3048, m=1),
    "feet": _of(0.3048, m=1), "yd": _of(0.9144, m=1), "mi": _of(1609.344, m=1),
    "nmi": _of(1852, m=1), "kn": _of(1852 / 3600, m=1, s=-1),
    "knot": _of(1852 / 3600, m=1, s=-1), "Å": _of(1e-10, m=1), "metre": _of(1, m=1), "meter": _of(1, m=1),
    "kilometre": _of(1e3, m=1), "kilometer": _of(1e3, m=1), "millimetre": _of(1e-3, m=1), "millimeter": _of(1e-3, m=1),
    "centimetre": _of(1e-2, m=1), "centimeter": _of(1e-2, m=1), "gram": _of(1e-3, kg=1), "kilogram": _of(1, kg=1),
    "kelvin": _of(1, K=1), "pascal": _of(1, m=-1, kg=1, s=-2), "millibar": _of(1e2, m=-1, kg=1, s=-2),
    "atm": _of(101325, m=-1, kg=1, s=-2), "newton": _of(1, m=1, kg=1, s=-2), "joule": _of(1, m=2, kg=1, s=-2),
    "watt": _of(1, m=2, kg=1, s=-3), "volt": _of(1, m=2, kg=1, s=-3, A=-1), "litre": _of(1e-3, m=3), "liter": _of(1e-3, m=3),
    "gpm": _of(1, m=1), "psu": _of(1), "dB": _of(1), "ha": _of(1e4, m=2), "Sv": _of(1e6, m=3, s=-1),
}  # fmt: skip
"""Units without a prefix. A geopotential metre counts as a metre; Sv is the sverdrup of oceanographers."""

PREFIXES: Mapping[str, float] = {
    "da": 1e1, "y": 1e-24, "z": 1e-21, "a": 1e-18, "f": 1e-15, "p": 1e-12, "n": 1e-9, "µ": 1e-6, "μ": 1e-6, "u": 1e-6,
    "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "P": 1e15, "E": 1e18,
}  # fmt: skip
PURE = ("", "1", "none", "-", "unitless", "dimensionless")
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
TOKEN = re.compile(
    r"\s*(?P<over>/|\bper\b)|\s*(?P<times>[*·×.](?![*])|\s)"
    r"|(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:(?:\^|\*\*)(?P<ten>[+-]?\d+))?"
    r"|(?P<name>[A-Za-zµμÅ°%_]+)(?:\^|\*\*)?(?P<power>[+-]?\d+)?"
)


@cache
def parse(text: str) -> Unit:
    """What a unit is made of; "" and "1" are plain numbers.

    Raises
    ------
    UnitError : a word that is no unit
    """
    rest = re.sub(r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda m: m.group().translate(RAISED), text.strip())
    if rest.lower() in PURE:
        return Unit()
    whole, sign, place, words = Unit(), 1, 0, 0
    alone: Unit | None = None
    while place < len(rest):
        found = TOKEN.match(rest, place)
        if found is None:
            raise UnitError(f"{text!r} is no unit: {rest[place:]!r} is not understood")
        place = found.end()
        if found["over"]:
            sign = -1
        elif found["number"]:
            whole = whole.times(Unit(float(found["number"]) ** int(found["ten"] or 1)), sign)
            sign, words = 1, words + 1
        elif found["name"]:
            alone = _named(found["name"], text)
            power = int(found["power"] or 1)
            whole = whole.times(alone, sign * power)
            words += 1
            alone = alone if (sign, power) == (1, 1) else None
            sign = 1
    return alone if alone is not None and words == 1 else whole


def _named(name: str, text: str) -> Unit:
    for known in (name, name.removesuffix("s")) if len(name) > 3 else (name,):
        if known in PLAIN or known in NAMES:
            return PLAIN.get(known) or NAMES[known]
        if len(name) > 3 and known.lower() in PLAIN:
            return PLAIN[known.lower()]
        for prefix, factor in PREFIXES.items():
            if known.startswith(prefix) and known[len(prefix) :] in NAMES:
                return Unit(factor).times(NAMES[known[len(prefix) :]])
    raise UnitError(f"{text!r} is no unit that is known here ({name!r})")


def known(text: str) -> bool:
    """Whether a text is a unit."""
    try:
        parse(text)
    except UnitError:
        return False
    return True


def same(one: str, other: str) -> bool:
    """Whether two texts mean one unit; texts that are no units must be equal."""
    if one.strip() == other.strip():
        return True
    if not (known(one) and known(other)):
        return False
    a, b = parse(one), parse(other)
    return a.powers == b.powers and abs(a.factor / b.factor - 1) < 1e-12 and a.offset == b.offset


def factor(unit: str, into: str) -> float:
    """By what a difference in `unit` is multiplied to be in `into`: what errors are converted with.

    Raises
    ------
    UnitError : they measure different things, or one is not known
    """
    if unit.strip() == into.strip():
        return 1.0
    a, b = parse(unit), parse(into)
    if a.powers != b.powers:
        raise UnitError(f"{unit or 'plain numbers'!r} and {into or 'plain numbers'!r} measure different things")
    return a.factor / b.factor


def linear(unit: str, into: str) -> tuple[float, float]:
    """(scale, offset) that bring values in `unit` to `into`: scale * value + offset; 25 °C is 298.15 K.

    Raises
    ------
    UnitError : they measure different things, or one is not known
    """
    scale = factor(unit, into)
    if scale == 1.0 and unit.strip() == into.strip():
        return 1.0, 0.0
    return scale, (parse(unit).offset - parse(into).offset) / parse(into).factor


LIFTED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def product(one: str, other: str, power: int = 1) -> str:
    """The text of one unit times another one to a power: "m" and "s" to -1 are "m/s"; equal words are drawn together.

    Words that are no known units are kept as they are.
    """
    powers: dict[str, int] = {}
    for text, times in ((one, 1), (other, power)):
        for name, own in _factors(text):
            powers[name] = powers.get(name, 0) + times * own
    return _written(powers)


def root(text: str) -> str:
    """The text of the square root of a unit.

    Raises
    ------
    UnitError : the root of m has no unit
    """
    factors: dict[str, int] = {}
    for name, own in _factors(text):
        factors[name] = factors.get(name, 0) + own
    if any(own % 2 for own in factors.values()):
        raise UnitError(f"a square root of {text} has no unit")
    return _written({name: own // 2 for name, own in factors.items()})


def _factors(text: str) -> list[tuple[str, int]]:
    """Words of a unit and their powers; a text that is not read so is one word."""
    rest = re.sub(r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda m: m.group().translate(RAISED), text.strip())
    if rest.lower() in PURE:
        return []
    found: list[tuple[str, int]] = []
    sign, place = 1, 0
    while place < len(rest):
        token = TOKEN.match(rest, place)
        if token is None:
            return [(text.strip(), 1)]
        place = token.end()
        if token["over"]:
            sign = -1
        elif token["number"]:
            if float(token["number"]) != 1:
                found.append((token["number"], sign * int(token["ten"] or 1)))
            sign = 1
        elif token["name"]:
            found.append((token["name"], sign * int(token["power"] or 1)))
            sign = 1
    return found


def _written(powers: Mapping[str, int]) -> str:
    def word(name: str, power: int) -> str:
        return name if power == 1 else f"{name}^{power}" if name[-1].isdigit() else name + str(power).translate(LIFTED)

    top = " ".join(word(name, power) for name, power in powers.items() if power > 0)
    below = "".join("/" + word(name, -power) for name, power in powers.items() if power < 0)
    return f"{top or '1'}{below}" if top or below else ""


def together(units: Iterable[str]) -> dict[str, float]:
    """For each of some units what a difference in it is multiplied by to be in the first of them.

    Raises
    ------
    UnitError : they measure different things, or one that differs is not known
    """
    wanted = list(dict.fromkeys(units))
    return {unit: 1.0 if same(unit, wanted[0]) else factor(unit, wanted[0]) for unit in wanted}


def is_length(unit: str) -> bool:
    """Whether a unit measures lengths."""
    return known(unit) and parse(unit).powers == parse("m").powers
