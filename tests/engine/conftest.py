"""The engine's laboratory: a catalogue of fake modules, random networks, and what they should give."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from app.engine.catalogue import Catalogue
from app.engine.events import Event, Failed, Finished, Reused, Settled
from app.engine.executor import Engine, execute
from app.engine.network import Network
from app.engine.results import Results

settings.register_profile("engine", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("engine")

Spec = tuple[tuple[int, int, int, int], ...]
"""One node each: kind, two picks of what is before it, a number."""

KINDS = ("zero", "constant", "add", "negate", "total", "both", "failing", "ordered")


class Lab:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.catalogue = Catalogue.of([], folder)
        assert not self.catalogue.broken
        self.fakes = SimpleNamespace(vars=self.catalogue["user.fakes.zero"].function.__globals__)

    @property
    def fired(self) -> list[str]:
        """Names of what has fired since the last look."""
        names: list[str] = self.fakes.vars["fired"]
        taken = list(names)
        names.clear()
        return taken

    @property
    def gate(self) -> Any:
        return self.fakes.vars["gate"]

    # --- networks

    def network(self, nodes: Mapping[str, Any], *wires: str, folder: Path | None = None) -> Network:
        """{"a": "zero", "b": ("constant", {"number": 2})}, "a.value -> b.values"."""
        network = Network(folder=folder)
        for name, what in nodes.items():
            module, values = (what, {}) if isinstance(what, str) else what
            network = network.add(module, self.catalogue, id=name, parameters=values)
        return self.wire(network, *wires)

    def wire(self, network: Network, *wires: str) -> Network:
        for wire in wires:
            start, end = wire.split(" -> ")
            source, output = start.split(".", 1)
            target, port = end.split(".", 1)
            network = network.connect(source, output, target, port, self.catalogue)
        return network

    def build(self, spec: Spec) -> Network:
        """A network from a specification; nodes that have no source become constants."""
        network = Network()
        for i, (kind, one, other, number) in enumerate(spec):
            name, module = f"n{i}", KINDS[kind % len(KINDS)]
            if i == 0 and module not in ("zero", "constant"):
                module = "constant"
            values = {"number": float(number)} if module == "constant" else {}
            network = network.add(module, self.catalogue, id=name, parameters=values)
            sources = [f"n{one % i}", f"n{other % i}"] if i else []
            ports = {"add": ("a", "b"), "negate": ("a",), "total": ("values", "values"), "both": ("a",)}
            ports |= {"failing": ("a",), "ordered": ("values", "values")}
            for source, port in zip(sources, ports.get(module, ()), strict=False):
                output = "half" if network.nodes[source].module.endswith("both") else "value"
                network = network.connect(source, output, name, port, self.catalogue)
        return network

    def naive(self, network: Network) -> dict[str, float | None]:
        """What each node should give, by plain recursion; None if it, or what it hangs on, fails."""
        found: dict[str, float | None] = {}
        for name in network.order:
            node, kind = network.nodes[name], network.nodes[name].module.rsplit(".", 1)[-1]
            inputs = [found[s] for _, origins in sorted(network.incoming.get(name, {}).items()) for s, _ in origins]
            if node.disabled or any(v is None for v in inputs) or kind == "failing":
                found[name] = None
                continue
            numbers = [v for v in inputs if v is not None]
            found[name] = _compute(kind, numbers, node.parameters)
        return found

    # --- runs

    def run(self, network: Network, results: Results | None = None, wanted: Iterable[str] | None = None, **more: Any) -> Run:
        return Run(list(execute(network, results, wanted, catalogue=self.catalogue, **more)))

    def engine(self, **more: Any) -> Engine:
        return Engine(self.catalogue, **more)


class Run:
    """The events of a wave, by kind and node."""

    def __init__(self, events: list[Event]) -> None:
        self.events = events

    def of(self, kind: type[Event]) -> list[str]:
        return [e.node for e in self.events if isinstance(e, kind)]  # type: ignore[attr-defined]  # asked of node events only

    @property
    def values(self) -> dict[str, float]:
        return {e.node: _number(e) for e in self.events if isinstance(e, Settled)}

    def entry(self, node: str) -> Any:
        return next(e.entry for e in self.events if isinstance(e, Settled) and e.node == node)

    def output(self, node: str, name: str = "") -> Any:
        outputs = self.entry(node).outputs
        return outputs[name] if name else next(iter(outputs.values()))

    def error(self, node: str) -> str:
        return str(next(e.error for e in self.events if isinstance(e, Failed) and e.node == node))

    def settled_once(self) -> bool:
        names = self.of(Finished) + self.of(Reused) + self.of(Failed)
        return len(names) == len(set(names))


def _number(event: Settled) -> float:
    first = next(iter(event.outputs.values()))
    return float(getattr(first, "value", float("nan")))


def _compute(kind: str, numbers: list[float], parameters: Mapping[str, Any]) -> float:
    if kind == "ordered":
        digits = 0.0
        for number in numbers:
            digits = 10 * digits + number
        return digits
    rules: dict[str, Callable[[], float]] = {
        "zero": lambda: 0.0,
        "constant": lambda: float(parameters["number"]),
        "add": lambda: sum(numbers),
        "total": lambda: sum(numbers),
        "negate": lambda: -numbers[0],
        "both": lambda: numbers[0] / 2,
    }
    return rules[kind]()


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    folder = tmp_path_factory.mktemp("modules")
    shutil.copy(Path(__file__).with_name("fakes.py"), folder / "fakes.py")
    return Lab(folder)


@pytest.fixture(autouse=True)
def fresh(lab: Lab) -> Iterator[None]:
    lab.gate.set()
    assert lab.fired is not None
    yield
    lab.gate.set()


@pytest.fixture(scope="session")
def specs() -> st.SearchStrategy[Spec]:
    pick = st.integers(0, 1000)
    return st.lists(st.tuples(pick, pick, pick, st.integers(-3, 3)), min_size=1, max_size=14).map(tuple)
