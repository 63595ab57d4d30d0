"""The budget of a variable as its file states it: rounding, members, random and systematic errors, limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modules.data import correlation as correlated
from modules.data.accuracy import Accuracy, Missing, Source, Term
from modules.data.companions import DOUBTFUL
from modules.data.fold import Kind
from modules.data.grid import Grid
from modules.data.operators import Floats, Identity, Operator
from modules.readers._cf import Beside
from modules.readers._files import ReadError


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What the user asks for.

    Parameters
    ----------
    step : which time
    at : axis -> index, of axes that are cut
    correlation, length : of stated errors of which the file does not say it
    multiple : stated sizes are so many standard deviations; None for what the file says
    plane : whether longitude and latitude become metres; None where the map is narrow
    """

    step: int = 0
    at: tuple[tuple[str, int], ...] = ()
    correlation: correlated.Correlation = "independent"
    length: float = 1.0
    multiple: float | None = None
    plane: bool | None = None


class Budget:
    """The terms of one reading; collects what had to be assumed."""

    def __init__(
        self, grid: Grid, components: int, unit: str, name: str, picked: str, values: Floats, wish: Wish
    ) -> None:
        self.grid, self.components, self.unit, self.name, self.picked = grid, components, unit, name, picked
        self.values, self.wish = values, wish
        self.holes = np.isnan(values)
        self.assumed: list[str] = []
        self.missing: list[Missing] = []

    def accuracy(
        self, half: Floats, words: str, members: Floats | None, stated: Sequence[list[tuple[Beside, Floats]]]
    ) -> Accuracy:
        """Rounding, members, and what is stated of each component."""
        sizes = np.where(self.holes, 0.0, np.nan_to_num(half.ravel(), nan=0.0)) if half.ndim else half
        words += " (rounding of stored numbers/1)"
        terms = [self._term("Quantisation", "quantisation", "bound", "proven", sizes, words)]
        if members is not None:
            k = len(members)
            rule = f"{k} members of the file about their mean (ensemble members/1)"
            flat = members.reshape(k, -1)
            terms.append(self._term(f"Spread of {k} members", "members", "members", "sampled", flat, rule))
            self.missing.append(Missing("Error common to all members", "members tell of random differences only"))
        found = self._linear(stated) + self._limits(stated)
        if not found and members is None:
            self.missing.append(Missing("Measurement error", "the file states none"))
        return Accuracy(tuple(terms + found), tuple(dict.fromkeys(self.missing)))

    def _term(
        self, name: str, what: str, kind: Kind, rigour: str, value: Floats, rule: str, correlation: str = "independent"
    ) -> Term:
        picked = "" if correlation == "common" else self.picked
        operator: Operator = Identity(self.values.size)
        if correlation != "independent":
            value, operator = correlated.carried(self.grid, self.components, value, correlation, self.wish.length, named=True)
        source = Source(name, "data", rigour, rule)  # type: ignore[arg-type]  # one of the five words
        return Term(
            source, kind, "value", self.unit, value, operator, components=self.components, id=f"{self.name}{picked}/{what}"
        )  # fmt: skip

    def _linear(self, stated: Sequence[list[tuple[Beside, Floats]]]) -> list[Term]:
        """One term for each kind of uncertainty: components are told by their order."""
        terms = []
        for i in range(max((sum(b.kind == "linear" for b, _ in s) for s in stated), default=0)):
            some = [[p for p in s if p[0].kind == "linear"][i : i + 1] for s in stated]
            one = next(p[0][0] for p in some if p)
            sizes = self._sizes([p[0] if p else None for p in some])
            how = one.correlation or self.wish.correlation
            name = one.variable.name.rsplit("/", 1)[-1]
            words = correlated.words(self.grid, how, self.wish.length)
            words = words.replace("assumed to be", "by its name it is") if one.correlation else words
            if not one.correlation:
                self.assumed.append(f"the errors stated by {name} are {self._how()} (set 'correlation')")
            by = f", of which {1 / one.factor:g} make one standard deviation here" if one.factor != 1 else ""
            called = one.variable.text("long_name") or f"Stated by {name}"
            rule = f"{name!r} in the file ({one.why}){by}; {words} (stated in the file/1)"
            terms.append(self._term(called, name, "linear", "estimated", sizes, rule, how))
        return terms

    def _how(self) -> str:
        return {
            "independent": "independent from sample to sample",
            "common": "one error common to all samples",
            "length": f"alike within a length of {self.wish.length:g}",
        }[self.wish.correlation]

    def _limits(self, stated: Sequence[list[tuple[Beside, Floats]]]) -> list[Term]:
        low = [next((p for p in s if p[0].kind == "low"), None) for s in stated]
        high = [next((p for p in s if p[0].kind == "high"), None) for s in stated]
        if not all(low) or not all(high):
            return []
        below, above = (self._flat([p[1] for p in ends if p]) for ends in (low, high))
        if (~self.holes & ~((below <= self.values) & (self.values <= above))).any():
            if low[0] and low[0][0].variable.name.endswith(DOUBTFUL):
                return []
            raise ReadError(f"the limits {low[0][0].variable.name!r} do not enclose the values: rename them if they are none")  # type: ignore[index]  # all are there
        sizes = np.where(self.holes, 0.0, np.maximum(self.values - below, above - self.values))
        names = " and ".join(repr(p[0].variable.name) for p in (low[0], high[0]) if p)
        rule = f"{names} in the file, taken as limits (companion array/1)"
        return [self._term(f"Limits {names}", "limits", "bound", "estimated", sizes, rule)]

    def _flat(self, parts: Sequence[Floats]) -> Floats:
        padded = [*parts, *[np.zeros_like(parts[0])] * (self.components - len(parts))]
        return np.stack(padded, axis=-1).ravel()

    def _sizes(self, parts: Sequence[tuple[Beside, Floats] | None]) -> Floats:
        """Sizes of all values, 0 at holes; where one is not given that is listed as missing."""
        shape = next(p[1].shape for p in parts if p)
        flat = self._flat([np.full(shape, np.nan) if p is None else p[1] for p in parts])
        name = next(p[0].variable.name for p in parts if p)
        if (flat < 0).any():
            raise ReadError(f"{name!r} should hold sizes of errors; it holds negative ones")
        gaps = int((np.isnan(flat) & ~self.holes).sum())
        if gaps:
            self.missing.append(Missing(f"Error stated by {name}", f"it is not given at {gaps} of {flat.size} samples"))
        return np.where(self.holes, 0.0, np.nan_to_num(flat, nan=0.0))
