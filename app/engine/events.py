"""What the engine says. Each event names its wave; `record()` gives plain values for a log or report (rule S22)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from app.engine.errors import ModuleFailed
from app.engine.results import Entry
from modules.data.accuracy import accuracies


@dataclass(frozen=True, eq=False, kw_only=True)
class Event:
    """Base of all.

    Parameters
    ----------
    wave : number of the wave, counted from 1
    at : seconds since the wave began
    """

    wave: int
    at: float = 0.0

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {"event": type(self).__name__.lower(), "wave": self.wave, "at": round(self.at, 6)}


@dataclass(frozen=True, eq=False, kw_only=True)
class NodeEvent(Event):
    """Of one node."""

    node: str

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "node": self.node}


@dataclass(frozen=True, eq=False, kw_only=True)
class Started(NodeEvent):
    """It fires; also said of a node that ran already for the wave before and is still wanted."""

    key: str

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "key": self.key}


@dataclass(frozen=True, eq=False, kw_only=True)
class Progressed(NodeEvent):
    """How far it is, in [0, 1]; before Started: how far its files are digested."""

    fraction: float

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "fraction": round(self.fraction, 4)}


@dataclass(frozen=True, eq=False, kw_only=True)
class Settled(NodeEvent):
    """It has a result.

    Parameters
    ----------
    key, entry : outputs, facts, warnings, seconds; `entry.outputs["lines"]`
    """

    key: str
    entry: Entry

    @property
    def outputs(self) -> Any:
        """The wire values by name."""
        return self.entry.outputs

    def record(self) -> dict[str, Any]:
        """As plain values, with what each output says of its accuracy."""
        entry = self.entry
        budget = {name: said for name, value in entry.outputs.items() if (said := _said(value))}
        return {
            **super().record(),
            "key": self.key,
            "seconds": round(entry.seconds, 6),
            "bytes": entry.bytes,
            "warnings": list(entry.warnings),
            "budget": budget,
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Finished(Settled):
    """It fired and gave a result."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Reused(Settled):
    """Its result was there, or an equal node fired for both."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Failed(NodeEvent):
    """It gave none."""

    key: str
    error: ModuleFailed

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "key": self.key, **self.error.record(), "traceback": self.error.traceback}


@dataclass(frozen=True, eq=False, kw_only=True)
class Blocked(NodeEvent):
    """It waits for a node that failed or is disabled."""

    by: str

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "by": self.by}


@dataclass(frozen=True, eq=False, kw_only=True)
class Done(Event):
    """The wave has ended: all settled, cancelled, or overtaken by a later one."""

    outcome: Literal["settled", "cancelled", "overtaken"] = "settled"

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {**super().record(), "outcome": self.outcome}


def _said(value: Any) -> dict[str, Any]:
    """The outermost accuracy of an output, unevaluated: who made errors, what is missing, flagged and ended."""
    accuracy = getattr(value, "accuracy", None) or next(accuracies(value), None)
    if accuracy is None:
        return {}
    return {
        "terms": [
            {"name": t.name, "stage": t.source.stage, "rigour": t.source.rigour}
            | {"kind": t.kind, "quantity": t.quantity, "unit": t.unit}
            for t in accuracy.terms
        ],
        "missing": [m.name for m in accuracy.missing],
        "flags": [f.name for f in accuracy.flags],
        "ended": {e.name: e.why for e in accuracy.ended.values()},
    }
