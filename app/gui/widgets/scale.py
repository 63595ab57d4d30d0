"""The ends of a slider and what lies between them, evenly or in powers; the same in the panel and on the node."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from modules.parameters import Parameter

STEPS = 1000
WHOLE = 200
"""Whole numbers up to which a slider has one step each."""


@dataclass(frozen=True)
class Scale:
    """From `low` to `high`; `log`: in powers; `whole`: numbers without a fraction."""

    low: float
    high: float
    log: bool = False
    whole: bool = False

    @property
    def steps(self) -> int:
        """How many steps a slider has."""
        span = self.high - self.low
        return int(span) if self.whole and not self.log and 0 < span <= WHOLE else STEPS

    def share(self, value: float) -> float:
        """Where a number lies, from 0 to 1."""
        if self.log:
            share = math.log(max(value, self.low) / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return min(1.0, max(0.0, share))

    def number(self, share: float) -> float:
        """The number that lies there, to three digits of the span; the very ends at the ends."""
        if share <= 0 or share >= 1:
            value = self.high if share >= 1 else self.low
            return float(round(value)) if self.whole else value
        value = self.low * (self.high / self.low) ** share if self.log else self.low + share * (self.high - self.low)
        if self.whole:
            return float(round(value))
        if self.log:
            return float(f"{value:.3g}")
        return round(value, max(0, 3 - math.floor(math.log10(self.high - self.low))))


def scale_of(
    parameter: Parameter,
    value: float | None,
    facts: Mapping[str, Mapping[str, Any]],
    own: tuple[float, float] | None = None,
    log: bool | None = None,
) -> Scale | None:
    """The ends that the user chose, else those declared, else some about the value; None if there are none.

    Parameters
    ----------
    facts : of the inputs
    own : ends that the user chose
    log : in powers or not; as declared by default
    """
    given, whole = parameter.range, parameter.type is int
    powers = bool(given and given.log) if log is None else log
    found = own or (given.ends(facts) if given else None) or _about(parameter, value)
    if found is None:
        return None
    if value is not None and own is None and math.isfinite(value):
        found = (min(found[0], value), max(found[1], value))
    low, high = found
    if powers and low <= 0:
        low = high * 1e-6
    return Scale(low, high, powers, whole) if low < high else None


def _about(parameter: Parameter, value: float | None) -> tuple[float, float] | None:
    if value is None or not math.isfinite(value) or value == 0:
        return None
    given = parameter.range
    low = given.low if given and given.low else value / 5
    high = given.high if given and given.high is not None else value * 5
    if parameter.type is int:
        low, high = math.floor(low), math.ceil(high)
    return (min(low, high), max(low, high))
