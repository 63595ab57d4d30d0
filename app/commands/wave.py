"""One run on the command line: what happened, told as it happens, and kept for a report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from app.commands.console import Console
from app.draw import numbers
from app.engine import certificate
from app.engine.catalogue import Catalogue
from app.engine.errors import ModuleFailed
from app.engine.executor import Blocked, Failed, Finished, Progressed, Reused, Started, execute
from app.engine.network import Network
from app.engine.results import Entry
from modules.data.accuracy import SIGNS, Accuracy, Line
from modules.data.wires import ColourMap, Layer, Scene

GLANCE = 2000
"""Items that are looked at for the lines of a run; certificates and demands look at all."""

SHOWN = 3
"""Terms of an output in one line; `--verbose` shows all."""


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
    network: Network, wanted: Iterable[str], catalogue: Catalogue, console: Console, threads: int | None = None
) -> Outcome:
    """Run what is wanted and say how it goes.

    Raises
    ------
    KeyboardInterrupt : with what had not finished
    """
    names = list(wanted)
    outcome, running = Outcome(), dict[str, float]()
    titles = {n: record.title for n, node in network.nodes.items() if (record := catalogue.get(node.module))}
    width = max(map(len, network.nodes), default=0)
    events = execute(network, None, names, catalogue=catalogue, workers=threads)
    try:
        for event in events:
            match event:
                case Started():
                    running[event.node] = 0.0
                    console.detail(f"  {event.node}: started")
                case Progressed():
                    running[event.node] = event.fraction
                    _bar(console, running)
                case Finished() | Reused():
                    running.pop(event.node, None)
                    ran = isinstance(event, Finished)
                    outcome.keys[event.node] = event.key
                    if event.node in names:
                        outcome.entries[event.node] = event.entry
                    _settled(event.node, titles.get(event.node, ""), event.entry, ran, network, console, width, outcome)
                case Failed():
                    running.pop(event.node, None)
                    outcome.errors[event.node] = event.error
                    outcome.nodes.append({"node": event.node, "status": "failed", **event.error.record()})
                    console.complain(f"nonius: {event.error}")
                    console.detail(event.error.traceback)
                case Blocked():
                    outcome.blocked[event.node] = event.by
                    outcome.nodes.append({"node": event.node, "status": "blocked", "by": event.by})
                    console.complain(f"nonius: {event.node} waits for {event.by}")
    except KeyboardInterrupt:
        done = {*outcome.keys, *outcome.errors, *outcome.blocked}
        rest = [n for n in network.nodes if n not in done]
        raise KeyboardInterrupt(f"cancelled; nothing was written; not finished: {', '.join(rest) or 'the pictures'}") from None
    finally:
        events.close()  # type: ignore[attr-defined]  # a generator
    return outcome


def _bar(console: Console, running: dict[str, float]) -> None:
    slowest = min(running, key=lambda n: running[n])
    others = f"  and {len(running) - 1} more" if len(running) > 1 else ""
    console.progress(slowest, running[slowest], others)


def _settled(
    node: str, title: str, entry: Entry, ran: bool, network: Network, console: Console, width: int, outcome: Outcome
) -> None:
    budgets = {name: found for name, value in entry.outputs.items() if (found := _accuracy(value)) is not None}
    lines = {name: accuracy.budget(GLANCE) for name, accuracy in budgets.items()}
    outcome.nodes.append(
        {
            "node": node,
            "module": network.nodes[node].module,
            "status": "ran" if ran else "cached",
            "key": outcome.keys[node],
            "seconds": round(entry.seconds, 4),
            "bytes": entry.bytes,
            "warnings": list(entry.warnings),
            "budget": {
                name: {
                    "rigour": accuracy.rigour(),
                    "terms": [certificate.term(line) for line in lines[name]],
                    "missing": [m.name for m in accuracy.missing],
                    "flags": [certificate.flag(f) for f in accuracy.flags],
                    "ended": {e.name: e.why for e in accuracy.ended.values()},
                }
                for name, accuracy in budgets.items()
            },
        }
    )
    time = f"{entry.seconds:6.2f} s" if ran else "  cached"
    console.say(f"{node.ljust(width)}  {time}  {title}")
    for name, accuracy in budgets.items():
        for text in said(accuracy, lines[name], network.k, None if console.verbose else SHOWN, reach(entry.outputs[name])):
            console.say(f"{' ' * width}            {name}: {text}")
    for warning in entry.warnings:
        console.complain(f"nonius: {node}: {warning}")


def _accuracy(value: Any) -> Accuracy | None:
    """What an output says of its accuracy; a layer repeats its shape, a scene its layers."""
    return None if isinstance(value, Layer | Scene | ColourMap) else getattr(value, "accuracy", None)


def reach(value: Any) -> float:
    """The size of a shape: an error of position beyond it says only that there is no bound."""
    bounds = getattr(value, "bounds", None)
    return (math.dist(bounds[::2], bounds[1::2]) or math.inf) if bounds is not None else math.inf


def said(
    accuracy: Accuracy, lines: Iterable[Line], k: float, most: int | None = None, reach: float = math.inf
) -> Iterator[str]:
    """A budget in words and signs, one line a quantity; what is missing on a line of its own.

    Parameters
    ----------
    lines : of the budget, the largest of a quantity first
    most : terms of a quantity that are named; all for None
    reach : size of the shape
    """
    by: dict[str, list[Line]] = {}
    for line in lines:
        by.setdefault(line.quantity, []).append(line)
    for quantity, terms in by.items():
        named = [words(term, k, reach) for term in terms[:most]]
        rest = f"; and {len(terms) - len(named)} more" if len(terms) > len(named) else ""
        looked = [t for t in terms if t.looked < t.count]
        note = f"  (n={looked[0].looked} of {looked[0].count} {looked[0].place}s)" if looked else ""
        yield f"{quantity} {'; '.join(named)}{rest}{note}"
    if accuracy.missing:
        yield f"{SIGNS['unknown']} {'; '.join(dict.fromkeys(m.name for m in accuracy.missing))}"
    if not by and not accuracy.missing:
        yield f"{SIGNS['exact']} exact"


def words(line: Line, k: float, reach: float = math.inf) -> str:
    """A term's largest size with its sign; bounds are rounded up, standard deviations times k.

    Of a measure (an area) the sum; where the largest error of position exceeds the shape itself, that on 95 %.
    """
    spread = line.kind in ("linear", "members")
    size, note = line.max, ""
    if line.kind == "metric" and line.count > 1:
        size, note = line.sum, " in all"
    elif line.quantity == "position" and line.max > reach:
        size, note = line.p95, " on 95 %"
    number = numbers.significant(size * (k if spread else 1.0), up=line.rigour == "proven")
    return f"{line.sign} {'±' if spread else ''}{numbers.with_unit(number, line.unit)}{note} {line.name}"


def output(entry: Entry, name: str) -> Any:
    """An output of a result, or its twin: what is known of its accuracy."""
    plain, _, twin = name.partition(":")
    value = entry.outputs[plain]
    return getattr(value, "accuracy", None) if twin else value
