"""One run on the command line: what happened, told as it happens, and kept for a report."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from app.commands import budget
from app.commands.console import Console
from app.engine import certificate
from app.engine.catalogue import Catalogue
from app.engine.errors import ModuleFailed
from app.engine.executor import Blocked, Event, Failed, Finished, Progressed, Reused, Started, execute
from app.engine.network import Network
from app.engine.results import Entry, Results
from app.engine.scheduler import order
from modules.data.accuracy import Accuracy, Line


@dataclass
class Outcome:
    """What a run gave.

    Parameters
    ----------
    entries : node -> its result, of what was wanted
    errors : node -> why there is none
    blocked : node -> the node it waits for
    nodes : one record a node, in the order in which they settled
    """

    entries: dict[str, Entry] = field(default_factory=dict)
    keys: dict[str, str] = field(default_factory=dict)
    errors: dict[str, ModuleFailed] = field(default_factory=dict)
    blocked: dict[str, str] = field(default_factory=dict)
    nodes: list[dict[str, Any]] = field(default_factory=list)


def watch(
    network: Network, wanted: Iterable[str], catalogue: Catalogue, console: Console, threads: int | None = None,
    results: Results | None = None,
) -> Outcome:  # fmt: skip
    """Run what is wanted and say how it goes.

    Raises
    ------
    KeyboardInterrupt : with what had not finished
    """
    watching = Watch(network, tuple(wanted), catalogue, console)
    events = execute(network, results, watching.wanted, catalogue=catalogue, workers=threads)
    try:
        for event in events:
            watching.hear(event)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"cancelled; nothing was written; not finished: {watching.rest()}") from None
    return watching.outcome


class Watch:
    """Hears the engine's events, tells them, and keeps what was wanted."""

    def __init__(self, network: Network, wanted: tuple[str, ...], catalogue: Catalogue, console: Console) -> None:
        self.network, self.wanted, self.catalogue, self.console = network, wanted, catalogue, console
        self.outcome = Outcome()
        self._running: dict[str, float] = {}
        self._width = max(map(len, network.nodes), default=0)

    def rest(self) -> str:
        """What has not finished."""
        done = {*self.outcome.keys, *self.outcome.errors, *self.outcome.blocked}
        return ", ".join(n for n in order(self.network, self.wanted) if n not in done) or "none"

    def hear(self, event: Event) -> None:
        """Tell one event, and keep it."""
        outcome = self.outcome
        match event:
            case Started():
                self._running[event.node] = 0.0
                self.console.detail(f"{event.node}: started")
            case Progressed():
                self._running[event.node] = event.fraction
                self._bar()
            case Finished() | Reused():
                self._running.pop(event.node, None)
                outcome.keys[event.node] = event.key
                if event.node in self.wanted:
                    outcome.entries[event.node] = event.entry
                self._settled(event.node, event.entry, isinstance(event, Finished))
            case Failed():
                self._running.pop(event.node, None)
                outcome.errors[event.node] = event.error
                outcome.nodes.append({"node": event.node, "status": "failed", **event.error.record()})
                self.console.complain(f"nonius: {event.error}")
                self.console.detail(event.error.traceback)
            case Blocked():
                outcome.blocked[event.node] = event.by
                outcome.nodes.append({"node": event.node, "status": "blocked", "by": event.by})
                self.console.complain(f"nonius: {event.node} waits for {event.by}")

    def _bar(self) -> None:
        slowest = min(self._running, key=lambda n: self._running[n])
        others = f"  and {len(self._running) - 1} more" if len(self._running) > 1 else ""
        self.console.progress(slowest, self._running[slowest], others)

    def _settled(self, node: str, entry: Entry, ran: bool) -> None:
        speaking = {name: value for name, value in entry.outputs.items() if budget.speaks(value)}
        lines = {name: budget.glance(value.accuracy) for name, value in speaking.items()}
        module = self.network.nodes[node].module
        self.outcome.nodes.append(
            {
                "node": node,
                "module": module,
                "status": "ran" if ran else "cached",
                "key": self.outcome.keys[node],
                "seconds": round(entry.seconds, 4),
                "bytes": entry.bytes,
                "warnings": list(entry.warnings),
                "budget": {name: _record(value.accuracy, lines[name]) for name, value in speaking.items()},
            }
        )
        time = f"{entry.seconds:6.2f} s" if ran else "  cached"
        record = self.catalogue.get(module)
        self.console.say(f"{node.ljust(self._width)}  {time}  {record.title if record else module}")
        most = None if self.console.verbose else budget.SHOWN
        for name, value in speaking.items():
            for text in budget.said(value, lines[name], self.network.k, most):
                self.console.say(f"{' ' * self._width}            {name}: {text}")
        for warning in entry.warnings:
            self.console.complain(f"nonius: {node}: {warning}")


def _record(accuracy: Accuracy, lines: Iterable[Line]) -> dict[str, Any]:
    return {
        "rigour": accuracy.rigour(),
        "terms": [certificate.term(line) for line in lines],
        "missing": [m.name for m in accuracy.missing],
        "flags": [certificate.flag(f) for f in accuracy.flags],
        "ended": {e.name: e.why for e in accuracy.ended.values()},
    }


def output(entry: Entry, name: str) -> Any:
    """An output of a result, or its twin: what is known of its accuracy."""
    plain, _, twin = name.partition(":")
    value = entry.outputs[plain]
    return getattr(value, "accuracy", None) if twin else value
