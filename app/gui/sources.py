"""Where the error of a picture comes from: its sources over the whole network, and the nodes that made them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import networkx

from app.commands.budget import reach
from app.draw import numbers
from app.engine.network import Network
from app.gui.bars import Row
from app.gui.budgets import SPREAD, Budget, Total, budget_of
from modules.data.accuracy import SIGNS, Accuracy, Line
from modules.data.wires import Scene

ORDER = ("position", "value", "velocity", "area", "length")
"""Quantities, the one that is meant first if none is chosen."""

Outputs = Callable[[str], Mapping[str, Any] | None]


@dataclass(frozen=True)
class Part:
    """A layer of a picture and its budget. `derived`: drawn of another shape's errors, so its sums count some twice."""

    title: str
    budget: Budget
    derived: bool


@dataclass(frozen=True)
class Share:
    """A source as it counts in a picture: at its largest over the layers."""

    line: Line
    size: float
    layer: str


@dataclass(frozen=True)
class Overview:
    """The budgets of all layers of a picture."""

    parts: tuple[Part, ...]

    @property
    def quantities(self) -> tuple[str, ...]:
        """What errors are of, in this picture; position first."""
        names = dict.fromkeys(t.quantity for part in self._own() for t in part.budget.totals)
        return tuple(sorted(names, key=lambda q: ORDER.index(q) if q in ORDER else len(ORDER)))

    @property
    def missing(self) -> dict[str, str]:
        """What is not given: name -> reason."""
        return {m.name: m.reason for part in self.parts for m in part.budget.missing}

    def _own(self) -> list[Part]:
        return sorted(self.parts, key=lambda part: part.derived)

    def total(self, quantity: str) -> tuple[Total, str] | None:
        """The layer with the largest error, and its title."""
        found = [
            (t, part.title, part.derived) for part in self.parts for t in part.budget.totals if t.quantity == quantity
        ]
        if not found:
            return None
        own = [f for f in found if not f[2]] or found
        total, title, _ = max(own, key=lambda f: f[0].value)
        return total, title

    def shares(self, quantity: str) -> list[Share]:
        """The sources of a quantity, the largest first."""
        found: dict[str, tuple[bool, Share]] = {}
        for part in self._own():
            for line in part.budget.lines:
                if line.quantity != quantity:
                    continue
                share = Share(line, part.budget.size(line), part.title)
                before = found.get(line.id)
                if before is None or (before[0] == part.derived and before[1].size < share.size):
                    found[line.id] = (part.derived, share)
        return sorted((share for _, share in found.values()), key=lambda s: (-s.size, s.line.name))


def overview_of(scene: Scene, k: float) -> Overview:
    """Evaluate the layers of a picture; call it in no window's thread."""
    parts = []
    sizes = [reach(layer.shape) for layer in scene.layers]
    whole = max((size for size in sizes if math.isfinite(size)), default=math.inf)
    for layer, size in zip(scene.layers, sizes, strict=True):
        budget = budget_of(layer.accuracy, k, min(size, whole))
        if budget.lines or budget.missing:
            parts.append(Part(layer.title, budget, getattr(layer.shape, "origin", None) is not None))
    return Overview(tuple(parts))


def number(line: Line, size: float) -> str:
    """A size as a row has it."""
    spread = "±" if line.kind in SPREAD else ""
    return f"{spread}{numbers.quantity(size, line.unit, up=line.rigour == 'proven')}"


def rows_of(lines: list[tuple[Line, float]], missing: Mapping[str, str]) -> list[Row]:
    """Rows of sources with their sizes, the largest first, and of what is not given."""
    longest = max((size for _, size in lines), default=0.0)
    found = [
        Row(line.sign, line.name, line.stage, number(line, size), line.rigour, size / longest if longest else 0.0, line.rule)
        for line, size in sorted(lines, key=lambda one: -one[1])
    ]
    return found + [Row(SIGNS["unknown"], n, "", "not given", "unknown", 1.0, why) for n, why in missing.items()]


def accuracies(network: Network, node: str, outputs: Outputs) -> Iterator[tuple[str, str, Accuracy]]:
    """(node, output, accuracy) of a node and all it hangs on, sources first, where a result is there."""
    near = {node, *networkx.ancestors(network.graph, node)}
    for name in network.order:
        for output, value in (outputs(name) or {}).items() if name in near else ():
            accuracy = getattr(value, "accuracy", None)
            if isinstance(accuracy, Accuracy):
                yield name, output, accuracy


def made_in(network: Network, node: str, outputs: Outputs) -> tuple[dict[str, str], dict[str, str]]:
    """(id of a term -> node in which it first occurs, name of a missing source -> the same)."""
    terms: dict[str, str] = {}
    missing: dict[str, str] = {}
    for name, _, accuracy in accuracies(network, node, outputs):
        for term in accuracy.terms:
            terms.setdefault(term.id, name)
        for gap in accuracy.missing:
            missing.setdefault(gap.name, name)
    return terms, missing


def overview_rows(overview: Overview, quantity: str, terms: Mapping[str, str], missing: Mapping[str, str]) -> list[Row]:
    """The rows of a picture: with the node in which each source arises."""
    shares = overview.shares(quantity)
    plain = rows_of([(s.line, s.size) for s in shares], overview.missing)
    found = []
    for i, row in enumerate(plain):
        node = terms.get(shares[i].line.id, "") if i < len(shares) else missing.get(row.name, "")
        layer = f" Largest in “{shares[i].layer}”." if i < len(shares) and shares[i].layer else ""
        made = ", ".join(part for part in (row.made, node) if part)
        found.append(replace(row, made=made, node=node, rule=f"{row.rule}{layer}"))
    return found
