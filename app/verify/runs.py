"""Running a network with other data in place of what its readers give: results are laid under their keys beforehand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any

from app.engine import paths, scheduler
from app.engine.catalogue import Catalogue
from app.engine.errors import ModuleFailed
from app.engine.executor import Blocked, Failed, Finished, Reused, execute
from app.engine.network import Network
from app.engine.results import Entry, Results
from modules.data.wires import Model, Samples
from modules.declare import Module
from modules.progress import Progress

Outputs = Mapping[str, Any]

JUDGED = ("readers", "modellers", "mappers")
"""Rooms whose outputs state errors of their own; the others show them."""


@dataclass(frozen=True, eq=False)
class Bench:
    """A network that can be run on other data.

    Parameters
    ----------
    keys : of its nodes, with the real files
    """

    network: Network
    catalogue: Catalogue
    keys: Mapping[str, str]
    wanted: tuple[str, ...]

    @classmethod
    def of(cls, network: Network, catalogue: Catalogue) -> Bench:
        """With all nodes that state errors wanted."""
        network = network.around
        known = paths.identities(network, catalogue) or {}
        wanted = tuple(n for n in network.order if _judged(network, n, catalogue))
        return cls(network, catalogue, scheduler.keys(network, catalogue, known), wanted)

    def record(self, node: str) -> Module:
        """The module of a node."""
        return self.catalogue[self.network.nodes[node].module]

    @property
    def sources(self) -> tuple[str, ...]:
        """Nodes at which data begin: readers to which no wire leads."""
        return tuple(n for n in self.wanted if not self.network.incoming.get(n))

    def below(self, nodes: Iterable[str]) -> set[str]:
        """The nodes and all that hang on them."""
        stack, seen = list(nodes), set[str]()
        while stack:
            node = stack.pop()
            if node not in seen:
                seen.add(node)
                stack.extend(self.network.graph.successors(node))
        return seen

    def changed(self, name: str, factor: float) -> Bench:
        """With each setting of that name times a factor, where it has a number."""
        network = self.network
        for node in self.wanted:
            record = self.record(node)
            parameter = record.parameter(name)
            if parameter is None or parameter.type is not float or name in self.network.incoming.get(node, {}):
                continue
            value = scheduler.effective(network.nodes[node], record)[name]
            if value is not None:
                network = network.set(node, name, value * factor, self.catalogue)
        return self if network is self.network else Bench.of(network, self.catalogue)

    def run(self, laid: Mapping[str, Outputs], progress: Progress, kept: Run | None = None) -> Run:
        """What all judged nodes give when some nodes give what is laid.

        Parameters
        ----------
        laid : node -> its outputs
        kept : a run whose results stand for all nodes that do not hang on these

        Raises
        ------
        Cancelled : through the progress
        """
        results = Results()
        touched = self.below(laid)
        for node in self.wanted if kept else ():
            if node not in touched and kept and node in kept.outputs:
                results.put(self.keys[node], Entry(kept.outputs[node]))
        for node, outputs in laid.items():
            results.put(self.keys[node], Entry(outputs))
        found: dict[str, Outputs] = {}
        failed: dict[str, ModuleFailed] = {}
        with closing(execute(self.network, results, self.wanted, catalogue=self.catalogue)) as events:  # type: ignore[type-var]  # a generator
            for event in events:
                progress.check()
                match event:
                    case Finished() | Reused():
                        found[event.node] = event.entry.outputs
                    case Failed():
                        failed[event.node] = event.error
                    case Blocked():
                        pass
        return Run(found, failed)

    def model_of(self, node: str, run: Run) -> Any:
        """The Model that is wired to a node in a run; None if there is none."""
        for origins in self.network.incoming.get(node, {}).values():
            for source, output in origins:
                value = run.outputs.get(source, {}).get(output)
                if isinstance(value, Model):
                    return value
        return None


def _judged(network: Network, node: str, catalogue: Catalogue) -> bool:
    record = catalogue.get(network.nodes[node].module)
    return record is not None and record.room in JUDGED and not network.nodes[node].passes


@dataclass(frozen=True, eq=False)
class Run:
    """What the nodes gave, and why some gave nothing."""

    outputs: Mapping[str, Outputs]
    failed: Mapping[str, ModuleFailed] = field(default_factory=dict)


def with_values(outputs: Outputs, name: str, samples: Samples) -> Outputs:
    """The outputs of a node with other samples as one of them."""
    return {**outputs, name: samples}


def perturbed(samples: Samples, by: Any) -> Samples:
    """Samples with errors added to their values."""
    return replace(samples, values=samples.values + by.reshape(samples.values.shape))
