"""What a verification finds, in words, and its verdict."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal

Verdict = Literal["holds", "wrong", "not judged"]
MARKS = {"holds": "✓", "wrong": "✗", "not judged": "·"}


@dataclass(frozen=True)
class Finding:
    """One claim of one output, and whether it is so.

    Parameters
    ----------
    node, output : whose claim it is
    term : the source, "" for all together
    check : propagation, spread, coverage, bound, estimate, order, total, area, distance
    words : what was found, in one sentence
    numbers : of it, for a report
    """

    node: str
    output: str
    term: str
    check: str
    verdict: Verdict
    words: str
    numbers: dict[str, float] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """As plain values."""
        numbers = {k: v if math.isfinite(v) else str(v) for k, v in self.numbers.items()}
        return {
            "node": self.node, "output": self.output, "term": self.term, "check": self.check, "verdict": self.verdict,
            "words": self.words, "numbers": numbers,
        }  # fmt: skip

    def __str__(self) -> str:
        of = f"{self.term}: " if self.term else ""
        return f"{MARKS[self.verdict]} {self.check}  {of}{self.words}"


@dataclass(frozen=True)
class Report:
    """All findings of a network.

    Parameters
    ----------
    runs : realisations of each term
    notes : what was put in place of the data, in words
    seconds : it took
    """

    findings: tuple[Finding, ...]
    runs: int
    notes: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """The claims that are not so."""
        return tuple(f for f in self.findings if f.verdict == "wrong")

    @property
    def judged(self) -> int:
        """How many claims were held against the truth."""
        return sum(f.verdict != "not judged" for f in self.findings)

    def nodes(self) -> Iterable[tuple[str, list[Finding]]]:
        """Findings by output, in the order of the walk."""
        groups: dict[str, list[Finding]] = {}
        for one in self.findings:
            groups.setdefault(f"{one.node}.{one.output}", []).append(one)
        return groups.items()

    @property
    def verdict(self) -> str:
        """The whole in one sentence."""
        if not self.judged:
            return "Nothing could be judged: no output of this network has a truth that manufactured data can give."
        if not self.wrong:
            return f"What this network states of its errors holds: {self.judged} claims, none of them wrong."
        places = ", ".join(dict.fromkeys(f"{f.node}.{f.output}" for f in self.wrong))
        return f"{len(self.wrong)} of {self.judged} claims are wrong, at {places}; begin at the first, others may follow."

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "verify": 1, "verdict": self.verdict, "wrong": len(self.wrong), "judged": self.judged, "runs": self.runs,
            "notes": list(self.notes), "findings": [f.record() for f in self.findings],
        }  # fmt: skip
