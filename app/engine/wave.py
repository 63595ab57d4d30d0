"""One wave: what still has to fire, what waits for what, what is held for it. Kept by key, told by node."""

from __future__ import annotations

import heapq
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from app.engine import paths, scheduler
from app.engine.catalogue import Catalogue
from app.engine.errors import ModuleFailed
from app.engine.events import Blocked, Done, Event, Failed, Finished, Progressed, Reused, Started
from app.engine.firing import Call, Wired, fits, socket
from app.engine.network import Network
from app.engine.results import Entry, Results


@dataclass(frozen=True, eq=False)
class Want:
    """What someone asks for. `interim`: more is to come, what runs may finish."""

    network: Network
    wanted: tuple[str, ...]
    interim: bool = False


class Wave:
    """The state of a wave.

    Parameters
    ----------
    number : counted from 1
    want : the network and what is wanted of it
    catalogue : the modules as they are now
    identities : of its files
    results : the store
    adoptable : keys that run for the wave before and may go on
    """

    def __init__(
        self,
        number: int,
        want: Want,
        catalogue: Catalogue,
        identities: paths.Identities,
        results: Results,
        adoptable: Iterable[str] = (),
    ) -> None:
        self.number = number
        self.want = want
        self.done = False
        self._catalogue = catalogue
        self._identities = identities
        self._begin = time.perf_counter()
        self._out: deque[Event] = deque()
        self.keys = scheduler.keys(want.network, catalogue, identities)
        self._rank = {name: i for i, name in enumerate(want.network.order)}
        self._held: dict[str, Entry] = {}
        self._users: dict[str, int] = {}
        self._above: dict[str, frozenset[str]] = {}
        self._below: dict[str, list[str]] = {}
        self._nodes: dict[str, list[str]] = {}
        self._unmet: dict[str, set[str]] = {}
        self._ready: list[tuple[int, str]] = []
        self._begun = set[str]()
        self._plan(results, frozenset(adoptable))

    def _plan(self, results: Results, adoptable: frozenset[str]) -> None:
        network = self.want.network

        def there(key: str) -> bool:
            if key in self._held or key in adoptable:
                return True
            entry = results.get(key)
            if entry is not None:
                self._held[key] = entry
            return entry is not None

        args = (network, self._catalogue, self._identities, self.keys, self.want.wanted, there, results.failures)
        plan = scheduler.plan(*args)
        for name in plan.reuse:
            if self.keys[name] in self._held:
                self._say(Reused, node=name, key=self.keys[name], entry=self._held[self.keys[name]])
            else:
                self._nodes.setdefault(self.keys[name], []).append(name)
        for key in self._nodes:
            self._await(key, frozenset())
            self.started(key)
        for name in plan.fire:
            key = self.keys[name]
            self._nodes.setdefault(key, []).append(name)
            if key not in self._above:
                self._await(key, frozenset(self.keys[s] for s in network.graph.predecessors(name)))
                self.again(key)
        for name, error in plan.failed.items():
            self._say(Failed, node=name, key=self.keys[name], error=error)
        for name, by in plan.blocked.items():
            self._say(Blocked, node=name, by=by)
        self._held = {k: e for k, e in self._held.items() if k in self._users}

    def _await(self, key: str, above: frozenset[str]) -> None:
        self._above[key] = above
        self._unmet[key] = {k for k in above if k not in self._held}
        for k in above:
            self._users[k] = self._users.get(k, 0) + 1
            self._below.setdefault(k, []).append(key)

    # --- asking

    @property
    def settled(self) -> bool:
        """Whether nothing is left to fire."""
        return not self._nodes

    def wants(self, key: str) -> bool:
        """Whether the key is still to come."""
        return key in self._nodes

    def say(self) -> Iterator[Event]:
        """What has not been told yet."""
        while self._out:
            yield self._out.popleft()

    def next(self) -> str | None:
        """The next key that may fire; None if none may now."""
        while self._ready:
            key = heapq.heappop(self._ready)[1]
            if key in self._nodes:
                return key
        return None

    def call(self, key: str) -> Call:
        """All that the firing of a ready key needs."""
        network, name = self.want.network, self._nodes[key][0]
        node = network.nodes[name]
        record = self._catalogue[node.module]
        inputs: dict[str, Any] = {port.name: None for port in record.ports}
        wired: dict[str, Wired] = {}
        for port, origins in network.incoming.get(name, {}).items():
            values = [socket(self._held[self.keys[s]].outputs, output) for s, output in origins]
            declared = record.port(port)
            if declared is not None:
                fitted = [fits(declared.type, v) for v in values]
                inputs[port] = fitted if declared.many else fitted[0]
            else:
                source, output = origins[0]
                title = self._catalogue[network.nodes[source].module].title
                wired[port] = Wired(values[0], f"{title}.{output}")
        parameters = scheduler.effective(node, record)
        own = []
        for parameter in record.parameters:
            value = parameters[parameter.name]
            if parameter.is_path and value is not None and parameter.name not in wired:
                parameters[parameter.name] = paths.locate(value, network.folder)
                own += [i] if (i := self._identities.get((name, parameter.name))) else []
        return Call(key, name, record, inputs, parameters, wired, tuple(own))

    # --- what happens

    def started(self, key: str) -> None:
        """It fires, or did for the wave before."""
        if key not in self._begun:
            self._begun.add(key)
            self._say(Started, node=self._nodes[key][0], key=key)

    def again(self, key: str) -> None:
        """It may fire, if all it hangs on is there; also what was stopped for the wave before and is wanted in this one."""
        if self._unmet[key]:
            return
        heapq.heappush(self._ready, (self._rank[self._nodes[key][0]], key))

    def told(self, key: str, fraction: float) -> None:
        """How far a key is."""
        if key in self._nodes:
            self._say(Progressed, node=self._nodes[key][0], fraction=fraction)

    def finish(self, key: str, entry: Entry) -> None:
        """It gave a result: tell its nodes, hold it for what waits, and let that go."""
        self.started(key)
        first, *others = self._nodes[key]
        self._say(Finished, node=first, key=key, entry=entry)
        for name in others:
            self._say(Reused, node=name, key=key, entry=entry)
        if self._users.get(key):
            self._held[key] = entry
        self._settle(key)
        for waiting in self._below.get(key, ()):
            self._unmet[waiting].discard(key)
            if waiting in self._nodes:
                self.again(waiting)

    def fail(self, key: str, error: ModuleFailed) -> None:
        """It gave none: block what hangs on it; the rest goes on."""
        self.started(key)
        nodes, graph = list(self._nodes[key]), self.want.network.graph
        for name in nodes:
            self._say(Failed, node=name, key=key, error=error.at(name))
        self._settle(key)
        for culprit in nodes:
            stack = [culprit]
            while stack:
                for name in sorted(graph.successors(stack.pop()), reverse=True):
                    below = self._nodes.get(self.keys[name])
                    if below and name in below:
                        self._say(Blocked, node=name, by=culprit)
                        below.remove(name)
                        stack.append(name)
                        if not below:
                            self._settle(self.keys[name])

    def end(self, outcome: str) -> None:
        """Nothing more is fired for it."""
        self._nodes.clear()
        self._held.clear()
        if not self.done:
            self.done = True
            self._say(Done, outcome=outcome)

    def _settle(self, key: str) -> None:
        """No longer to come; what was held only for it is let go."""
        del self._nodes[key]
        for above in self._above[key]:
            self._users[above] -= 1
            if not self._users[above]:
                self._held.pop(above, None)

    def _say(self, kind: type[Event], **words: Any) -> None:
        self._out.append(kind(wave=self.number, at=time.perf_counter() - self._begin, **words))
