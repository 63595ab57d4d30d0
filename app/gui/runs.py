"""What runs and what has run: the engine's events as the states of nodes. No event is computed here."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.engine import scheduler
from app.engine.catalogue import Catalogue
from app.engine.errors import Unwired
from app.engine.events import Blocked, Done, Failed, NodeEvent, Progressed, Reused, Settled, Started
from app.engine.executor import Engine
from app.engine.network import Network
from app.engine.results import Entry, Results
from app.gui.state import NodeState, changed, with_descendants
from app.gui.worker import Told, Worker

AT_WORK = ("queued", "running")


class Runs(QObject):
    """The states of the nodes of one network after the other.

    Parameters
    ----------
    catalogue : the modules
    results : store of results; a new one by default
    """

    stateChanged = Signal(str)
    resultChanged = Signal(str)
    waveDone = Signal(str)

    def __init__(
        self, catalogue: Catalogue, results: Results | None = None, parent: QObject | None = None, workers: int = 0
    ) -> None:
        super().__init__(parent)
        self.catalogue = catalogue
        self.network = Network()
        self.results = Results() if results is None else results
        self.worker = Worker(Engine(catalogue, self.results, workers=workers or None), self)
        self.worker.arrived.connect(self._arrived)
        self.worker.start()
        self.keep: frozenset[str] = frozenset()
        self._serial = 0
        self._edited: dict[str, int] = {}
        self._states: dict[str, NodeState] = {}
        self._keys: dict[str, str] = {}
        self._held: OrderedDict[str, tuple[str, Entry]] = OrderedDict()
        self._fresh: set[str] = set()
        self._done = self._all = 0

    # --- asking

    def state(self, node: str) -> NodeState:
        """How a node is."""
        there = self.network.nodes.get(node)
        if there is None:
            return NodeState("missing", sentence="there is no such node")
        if self.catalogue.get(there.module) is None:
            words = f"the module {there.module!r} is not here{self.catalogue.nearest(there.module)}"
            return NodeState("missing", sentence=words)
        if there.disabled:
            return NodeState("disabled", sentence="disabled: it gives nothing; enable it in the Run menu")
        if there.bypass:
            ways = ", ".join(f"{port} goes on as {output}" for output, port in there.bypass.items())
            return NodeState("bypassed", sentence=f"bypassed: {ways}")
        state = self._states.get(node, NodeState())
        if there.view.get("held") and state.kind not in ("running", "clean", "cached"):
            return NodeState("held", seconds=state.seconds, sentence="held: fires only when you press Fire")
        return state

    def entry(self, node: str) -> Entry | None:
        """The last good result of a node, also when it is stale."""
        if node in self._held:
            return self._held[node][1]
        key = self._keys.get(node)
        return self.results.get(key) if key else None

    def stale(self, node: str) -> bool:
        """Whether the result that is there is of an earlier network."""
        return node not in self._fresh and self.entry(node) is not None

    def key(self, node: str) -> str:
        """Of the last good result."""
        return self._keys.get(node, "")

    @property
    def busy(self) -> tuple[str, ...]:
        """Nodes that run."""
        return tuple(n for n, s in self._states.items() if s.kind == "running")

    @property
    def progress(self) -> tuple[int, int]:
        """Nodes of this wave that are done, and all of it."""
        return self._done, self._all

    # --- changing

    def follow(self, network: Network, fresh: bool = False) -> bool:
        """Take a network; True if results may differ. `fresh`: it is another document."""
        before, self.network = self.network, network
        self._serial += 1
        if fresh:
            for store in (self._states, self._keys, self._held, self._edited):
                store.clear()
            self._fresh.clear()
        touched = set(network.nodes) if fresh else changed(before, network)
        for name in before.nodes.keys() - network.nodes.keys():
            for lost in (self._states, self._keys, self._held, self._edited):
                lost.pop(name, None)
            self._fresh.discard(name)
        for name in touched:
            self._edited[name] = self._serial
            self._fresh.discard(name)
            self._become(name, NodeState("dirty", seconds=self.seconds(name)))
        return bool(touched) or before.nodes.keys() != network.nodes.keys()

    def want(self, wanted: Iterable[str], interim: bool) -> None:
        """Ask for results; held nodes, and what hangs on them, wait unless their result is there."""
        held = {n for n, node in self.network.nodes.items() if node.view.get("held") and n not in self._fresh}
        waiting = with_descendants(self.network, held)
        nodes = self.network.nodes
        names = [n for n in dict.fromkeys(wanted) if n in nodes and n not in waiting and not nodes[n].passes]
        self._ask(names, interim)

    def fire(self, node: str) -> None:
        """Run a node, also one that is held, failed before, or has a result."""
        if node not in self.network.nodes or self.network[node].passes:
            return
        self._edited[node] = self._serial = self._serial + 1
        self._ask([node], False)
        self.worker.engine.fire(node)

    def _ask(self, names: list[str], interim: bool) -> None:
        needed = scheduler.upstream(self.network.around, names)
        for name in needed:
            if name not in self._fresh and self._states.get(name, NodeState()).kind in ("dirty", "blocked"):
                self._become(name, NodeState("queued", seconds=self.seconds(name)))
        self._done, self._all = 0, len(needed)
        self.worker.want(self.network, names, interim, self._serial)

    def cancel(self) -> None:
        """Stop; what has been computed stays."""
        self.worker.engine.cancel()

    def seconds(self, node: str) -> float:
        """That the last run of a node took."""
        return self._states.get(node, NodeState()).seconds

    def close(self) -> None:
        """Stop everything."""
        self.worker.close()

    # --- what happens

    def _arrived(self) -> None:
        for told in self.worker.take():
            event = told.event
            if isinstance(event, Done):
                self._ended(event, told)
            elif isinstance(event, NodeEvent) and event.node in self.network.nodes:
                self._happened(event, told)

    def _happened(self, event: NodeEvent, told: Told) -> None:
        name = event.node
        current = told.serial >= self._edited.get(name, 0)
        match event:
            case Settled():
                self._settled(event, current)
            case Started() if current:
                self._become(name, NodeState("running", seconds=self.seconds(name)))
            case Progressed() if current:
                self._become(name, NodeState("running", event.fraction, self.seconds(name)))
            case Failed() if current and isinstance(event.error, Unwired):
                self._become(name, NodeState("blocked", sentence=event.error.sentence, error=event.error))
            case Failed() if current:
                self._become(name, NodeState("failed", sentence=event.error.sentence, error=event.error))
            case Blocked() if current:
                self._become(name, NodeState("blocked", seconds=self.seconds(name), sentence=f"waits for {event.by}"))

    def _settled(self, event: Settled, current: bool) -> None:
        name, reused = event.node, isinstance(event, Reused)
        same = self._keys.get(name) == event.key
        self._keys[name] = event.key
        self._held.pop(name, None)
        if name in self.keep:
            self._held[name] = (event.key, event.entry)
        if current:
            self._fresh.add(name)
            self._done += 1
            said = "; ".join(event.entry.warnings)
            kind = "cached" if reused and not same else self._states.get(name, NodeState()).kind if reused else "clean"
            kind = kind if kind in ("clean", "cached") else "cached"
            self._become(name, NodeState(kind, None, event.entry.seconds, said, reused=reused))
        self.resultChanged.emit(name)

    def _ended(self, event: Done, told: Told) -> None:
        latest = told.serial >= self._serial
        for name, state in list(self._states.items()) if event.outcome != "overtaken" else ():
            if state.kind not in AT_WORK:
                continue
            key = told.keys.get(name, "") if latest and event.outcome == "settled" else ""
            entry = self.results.get(key) if key else None
            if entry is not None:  # nobody needed it in this wave, but it is there: the network ran before
                self._settled(Reused(wave=event.wave, node=name, key=key, entry=entry), True)
            elif latest or event.outcome == "cancelled" or name in self._fresh:
                self._become(name, NodeState("dirty", seconds=state.seconds))
        self.waveDone.emit(event.outcome)

    def _become(self, node: str, state: NodeState) -> None:
        if self._states.get(node) != state:
            self._states[node] = state
            self.stateChanged.emit(node)

    def facts(self, node: str) -> Mapping[str, Mapping[str, Any]]:
        """Facts of the outputs of a node, as far as known."""
        entry = self.entry(node)
        return {} if entry is None else entry.facts
