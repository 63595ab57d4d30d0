"""What the engine costs, as ratios to peers measured in the same run.

    python tests/benchmarks/engine.py

A network of 1,000 trivial modules: a whole wave against the bare pool with the same functions, an edit near the end
against the whole wave, keys and edits against the wave, the latency of a cancel against a slab.
"""

from __future__ import annotations

import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from app.engine import document, scheduler  # noqa: E402  run as a script, the path comes first
from app.engine.catalogue import Catalogue  # noqa: E402  the same
from app.engine.events import Done, Finished, Started  # noqa: E402  the same
from app.engine.executor import Engine  # noqa: E402  the same
from app.engine.network import Network, Node  # noqa: E402  the same
from app.engine.results import Results  # noqa: E402  the same


def wide(catalogue: Catalogue, n: int = 1000) -> Network:
    """A graph of n nodes: sources, pairwise sums, and opposites of these."""
    nodes: dict[str, Node] = {}
    wires: dict[tuple[str, str, int], tuple[str, str]] = {}
    for i in range(n):
        name = f"n{i:04d}"
        if i < n // 3:
            nodes[name] = Node(name, "user.fakes.constant", 1, {"number": float(i % 90), "sigma": i / n})
        elif i < 2 * n // 3:
            nodes[name] = Node(name, "user.fakes.add", 1, {})
            wires[name, "a", 0] = (f"n{i - n // 3:04d}", "value")
            wires[name, "b", 0] = (f"n{(i * 7) % (n // 3):04d}", "value")
        else:
            nodes[name] = Node(name, "user.fakes.negate", 1, {})
            wires[name, "a", 0] = (f"n{i - n // 3:04d}", "value")
    return Network(nodes, wires)


def median(action: Callable[[], object], times: int = 5) -> float:
    """Seconds."""
    spent = []
    for _ in range(times):
        start = time.perf_counter()
        action()
        spent.append(time.perf_counter() - start)
    return statistics.median(spent)


def wave(catalogue: Catalogue, network: Network, results: Results) -> int:
    """Run what is absent; how many fired."""
    with Engine(catalogue, results) as engine:
        engine.want(network)
        return sum(isinstance(event, Finished) for event in engine.events(once=True))


def bare(catalogue: Catalogue, network: Network) -> None:
    """The same functions on the same pool, level by level, with nothing of the engine."""
    found: dict[str, object] = {}
    levels: dict[str, int] = {}
    for name in network.order:
        levels[name] = 1 + max((levels[s] for s in network.graph.predecessors(name)), default=-1)
    with ThreadPoolExecutor() as pool:
        for level in range(max(levels.values()) + 1):
            jobs = {}
            for name in (n for n in network.order if levels[n] == level):
                record = catalogue[network.nodes[name].module]
                inputs = [found[s] for origins in network.incoming.get(name, {}).values() for s, _ in origins]
                jobs[name] = pool.submit(record.function, *inputs, **network.nodes[name].parameters)
            found.update({name: job.result() for name, job in jobs.items()})


def fresh(network: Network) -> Network:
    """The same network with nothing remembered."""
    nodes = {n: Node(v.id, v.module, v.version, v.parameters) for n, v in network.nodes.items()}
    return Network(nodes, network.wires)


def cancel_latency(catalogue: Catalogue) -> float:
    """Seconds from a cancel to the end, in slabs of 20 ms."""
    network = Network().add("zero", catalogue).add("slow", catalogue, parameters={"slabs": 500, "pause": 0.02})
    network = network.connect("zero-1", "value", "slow-1", "a", catalogue)
    with Engine(catalogue) as engine:
        engine.want(network)
        events = engine.events(once=True)
        for event in events:
            if isinstance(event, Started) and event.node == "slow-1":
                break
        time.sleep(0.1)
        start = time.perf_counter()
        engine.cancel()
        assert any(isinstance(event, Done) for event in events)
        return time.perf_counter() - start


def main() -> dict[str, float]:
    """Measure, print, and return the ratios."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(ROOT / "tests" / "engine" / "fakes.py", Path(folder) / "fakes.py")
        catalogue = Catalogue.of([], Path(folder))
        return measured(catalogue)


def measured(catalogue: Catalogue) -> dict[str, float]:
    """All ratios."""
    network = wide(catalogue)
    whole = median(lambda: wave(catalogue, fresh(network), Results()))
    pool = median(lambda: bare(catalogue, network))
    keys = median(lambda: scheduler.keys(fresh(network), catalogue))
    results = Results()
    fired = wave(catalogue, network, results)
    numbers = iter(range(100, 1000))

    def edit() -> None:
        name = "n0300"
        changed = Node(name, "user.fakes.constant", 1, {"number": next(numbers) / 10.5, "sigma": 0.5})
        wave(catalogue, Network({**network.nodes, name: changed}, network.wires), results)

    edited = median(edit)
    text = document.dumps(network, catalogue)
    load = median(lambda: document.loads(text, catalogue))
    frozen = median(lambda: [network.set("n0300", "number", next(numbers) % 90, catalogue) for _ in range(20)]) / 20
    latency = median(lambda: cancel_latency(catalogue), 3) - 0.1
    ratios = {
        "whole wave / bare pool": whole / pool,
        "edit near the end / whole wave": edited / whole,
        "keys / whole wave": keys / whole,
        "reading the file / whole wave": load / whole,
        "one frozen edit / whole wave": frozen / whole,
        "cancel / slab of 20 ms": latency / 0.02,
    }
    print(f"{fired} of {len(network.nodes)} nodes fired (equal keys run once); a whole wave took {whole:.3f} s here")
    for name, ratio in ratios.items():
        print(f"{name:34} {ratio:8.4f}")
    return ratios


if __name__ == "__main__":
    main()
