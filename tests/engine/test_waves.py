"""Any network and any row of edits: what is wanted equals a plain recursion, and nothing fires in vain.

`PLANTED` are faults put into the engine on purpose; the same checks find each of them.
"""

from __future__ import annotations

import queue
import random
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.engine import executor, scheduler, wave
from app.engine.events import Blocked, Done, Event, Failed, Finished, Settled, Started
from app.engine.executor import Engine
from app.engine.network import Network
from app.engine.results import Results


class Impatient(queue.Queue):  # type: ignore[type-arg]  # letters of any kind
    """A mailbox that fails where an engine would wait for ever."""

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        try:
            return super().get(block, 1.0)
        except queue.Empty:
            raise TimeoutError("the engine waits for nothing") from None


class Watched(Engine):
    """An engine that notes what it submits, and never runs one key twice at a time."""

    def __init__(self, *args: Any, **more: Any) -> None:
        super().__init__(*args, **more)
        self._mail = Impatient()  # type: ignore[assignment]  # a mailbox all the same
        self.submitted: list[str] = []

    def _submit(self, job: executor.Job) -> None:
        assert job.key not in self._running, "one key runs twice at a time"
        assert len(self._running) < self.workers, "more firings at once than workers"
        self.submitted.append(job.key)
        super()._submit(job)


def network_ancestors(network: Network, node: str) -> set[str]:
    return scheduler.upstream(network, [node]) - {node}


def expected_to_fire(lab: Any, network: Network, wanted: list[str], there: Callable[[str], bool]) -> set[str]:
    """Keys that a plain walk from what is wanted finds absent; what cannot fire, or waits for such, is left out."""
    keys, values = scheduler.keys(network, lab.catalogue), lab.naive(network)
    off = {n for n in network.nodes if network.nodes[n].disabled}
    off |= {n for n in network.nodes if off & network_ancestors(network, n)}
    found, stack = set[str](), list(wanted)
    while stack:
        name = stack.pop()
        if name not in off and not there(keys[name]):
            found.add(keys[name])
            stack.extend(network.graph.predecessors(name))
    fails = {n for n in network.nodes if network.nodes[n].module.endswith("failing")}
    below = {n for n in network.nodes if any(s in fails or values[s] is None for s in network.graph.predecessors(n))}
    return found - {keys[n] for n in below}


def check_one_wave(lab: Any, network: Network, wanted: list[str], results: Results, workers: int) -> None:
    keys, values = scheduler.keys(network, lab.catalogue), lab.naive(network)
    kept = {k for k in keys.values() if k in results}
    failed = {k for k in keys.values() if k in results.failures}
    bound = results.bound
    engine = Watched(lab.catalogue, results, workers=workers)
    with engine:
        engine.want(network, wanted)
        events = list(engine.events(once=True))
        fires = expected_to_fire(lab, network, wanted, kept.__contains__) - failed
        assert Counter(engine.submitted) == Counter(fires), "exactly what is wanted and absent fires, once"
    check_events(lab, network, wanted, events)
    if bound >= 1 << 20:
        assert all(keys[n] in results for n in wanted if values[n] is not None)


def check_events(lab: Any, network: Network, wanted: list[str], events: list[Event]) -> None:
    """Of the last wave: what is wanted is told, right, once, and after what it hangs on."""
    values = lab.naive(network)
    last = max(e.wave for e in events)
    mine = [e for e in events if e.wave == last]
    assert isinstance(mine[-1], Done) and sum(isinstance(e, Done) for e in mine) == 1
    ends = [e.node for e in mine if isinstance(e, Settled | Failed | Blocked)]
    assert len(ends) == len(set(ends)), "each node is settled at most once a wave"
    assert set(wanted) <= set(ends)
    begun = Counter(e.node for e in mine if isinstance(e, Started))
    assert set(begun.values()) <= {1}
    seen = set[str]()
    for event in mine:
        if isinstance(event, Finished):
            assert begun[event.node], "who finished has started"
            seen.add(event.node)
        if isinstance(event, Settled):
            got = next(iter(event.outputs.values())).value
            assert got == values[event.node], f"{event.node} gave {got}, not {values[event.node]}"
        if isinstance(event, Blocked):
            assert values[event.by] is None and event.by in {e.node for e in mine if isinstance(e, Failed | Blocked)}
        if isinstance(event, Failed):
            assert network.nodes[event.node].module.endswith("failing")


def some_spec(random_: random.Random, n: int = 14) -> Any:
    return tuple(
        (random_.randrange(1000), random_.randrange(1000), random_.randrange(1000), random_.randint(-3, 3))
        for _ in range(random_.randint(1, n))
    )


def edited(lab: Any, network: Network, random_: random.Random) -> Network:
    """After one more legal edit."""
    for _ in range(random_.randint(1, 2)):
        name = random_.choice(sorted(network.nodes))
        if network.nodes[name].module.endswith("constant") and random_.random() < 0.8:
            network = network.set(name, "number", random_.randint(-3, 3), lab.catalogue)
        elif random_.random() < 0.3:
            network = network.disable(name, not network.nodes[name].disabled)
        elif random_.random() < 0.5:
            network = network.rename(name, network.fresh_id("x.node"))
        else:
            source = random_.choice(network.order[: network.order.index(name)] or (name,))
            ports = network.incoming.get(name, {})
            port = next(iter(sorted(ports)), "")
            output = "half" if network.nodes[source].module.endswith("both") else "value"
            if port and source != name:
                network = network.connect(source, output, name, port, lab.catalogue, slot=0, instead=True)
    return network


def disturbed(lab: Any, seed: int, bound: int | None) -> None:
    """Edits, held sliders, cancels and fires at random events; then one quiet wave must be right."""
    random_ = random.Random(seed)
    network, results = lab.build(some_spec(random_)), Results(bound)
    with Watched(lab.catalogue, results, workers=random_.choice([1, 2, 3])) as engine:
        engine.want(network)
        events: Iterator[Event] = engine.events()
        seen: list[Event] = []
        for _ in range(random_.randint(0, 12)):
            for event in events:
                seen.append(event)
                if random_.random() < 0.4 or isinstance(event, Done):
                    break
            action = random_.random()
            if action < 0.15:
                engine.cancel()
            elif action < 0.25:
                engine.fire(random_.choice(sorted(network.nodes)))
            else:
                network = edited(lab, network, random_)
            engine.want(network, interim=action > 0.6)
        engine.want(network)
        seen += list(engine.events(once=True))
        # what failed before may be told as failed; nothing else may linger
        check_events(lab, network, list(network.sinks()), seen)
        for number in {e.wave for e in seen}:
            ends = [e.node for e in seen if e.wave == number and isinstance(e, Settled | Failed | Blocked)]
            assert len(ends) == len(set(ends))
        assert not engine._running and not engine.results.bytes > max(results.bound, 0)
        engine.results.clear()
        assert not seen or sum(isinstance(e, Done) for e in seen) == len({e.wave for e in seen})
    check_one_wave(lab, network, list(network.sinks()), Results(bound), 2)


BOUNDS = (None, 0, 8, 24)


@given(st.data())
@settings(max_examples=150)
def test_what_is_wanted_equals_a_plain_recursion_and_only_what_is_absent_fires(lab: Any, specs: Any, data: Any) -> None:
    network = lab.build(data.draw(specs))
    names = sorted(network.nodes)
    results = Results(data.draw(st.sampled_from((None, 1 << 20))))
    workers = data.draw(st.integers(1, 3))
    for _ in range(2):
        wanted = data.draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
        check_one_wave(lab, network, wanted, results, workers)


@given(st.integers(0, 10**9), st.sampled_from(BOUNDS))
@settings(max_examples=150)
def test_edits_cancels_and_sliders_at_any_event_leave_a_sound_engine(lab: Any, seed: int, bound: int | None) -> None:
    disturbed(lab, seed, bound)


@given(st.data())
@settings(max_examples=40)
def test_stopping_at_any_event_leaves_what_a_fresh_run_leaves(lab: Any, specs: Any, data: Any) -> None:
    network, results = lab.build(data.draw(specs)), Results()
    whole = lab.run(network)
    stop_at = data.draw(st.integers(0, len(whole.events)))
    with lab.engine(results=results, workers=2) as engine:
        engine.want(network)
        for i, _ in enumerate(engine.events()):
            if i >= stop_at or engine._idle():
                break
        engine.cancel()
        list(engine.events(once=True))
    after = lab.run(network, results)
    assert {n: v for n, v in after.values.items() if n in network.sinks()} == {
        n: v for n, v in whole.values.items() if n in network.sinks()
    }
    assert sorted(after.of(Failed)) == sorted(whole.of(Failed)) or set(after.of(Failed)) <= set(whole.of(Failed))


# --- faults put in on purpose


def _swap(place: Any, name: str, change: Callable[[Any], Any]) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setattr(place, name, change(getattr(place, name)))


def _no_canonical_parameters(own: Any) -> Any:
    return lambda node, record, wired, identities: own(node, record, frozenset(p.name for p in record.parameters), identities)


def _shows_late(land: Any) -> Any:
    def landed(self: Any, job: Any) -> None:
        wants = self._wave.wants
        self._wave.wants = lambda key: True
        try:
            land(self, job)
        finally:
            self._wave.wants = wants

    return landed


def _walks_through(plan: Any) -> Any:
    def walked(*args: Any) -> Any:
        *rest, _, failures = args
        return plan(*rest, lambda key: False, failures)

    return walked


def _first_slot_only(call: Any) -> Any:
    def called(self: Any, key: str) -> Any:
        made = call(self, key)
        made.inputs.update({p: v[::-1] for p, v in made.inputs.items() if isinstance(v, list)})
        return made

    return called


def _no_wires(key: Any) -> Any:
    return lambda network, node, *rest: key(Network({node.id: node}, {}), node, *rest)


def _never_blocks(fail: Any) -> Any:
    def failed(self: Any, key: str, error: Any) -> None:
        for name in list(self._nodes[key]):
            self._say(Failed, node=name, key=key, error=error.at(name))
        self._settle(key)

    return failed


def _forgets_some(again: Any) -> Any:
    return lambda self, key: None if self._rank[self._nodes[key][0]] % 3 == 2 else again(self, key)


def _first_twin_only(finish: Any) -> Any:
    def finished(self: Any, key: str, entry: Any) -> None:
        del self._nodes[key][1:]
        finish(self, key, entry)

    return finished


def _fires_early(again: Any) -> Any:
    def ready(self: Any, key: str) -> None:
        self._unmet[key] = set()
        again(self, key)

    return ready


PLANTED: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "parameters are not in the key": _swap(scheduler, "_own", _no_canonical_parameters),
    "wires are not in the key": _swap(scheduler, "_key", _no_wires),
    "late results are shown": _swap(Engine, "_land", _shows_late),
    "known results fire again": _swap(scheduler, "plan", _walks_through),
    "lists arrive backwards": _swap(wave.Wave, "call", _first_slot_only),
    "a failure blocks nothing": _swap(wave.Wave, "fail", _never_blocks),
    "disabled nodes are not looked at": _swap(scheduler, "_disabled", lambda _: lambda network, names: {}),
    "equal keys are not joined": _swap(wave.Wave, "wants", lambda _: lambda self, key: False),
    "the second output is taken": _swap(wave, "socket", lambda _: lambda outputs, output: list(outputs.values())[-1]),
    "some that are ready are forgotten": _swap(wave.Wave, "again", _forgets_some),
    "only the first twin is told": _swap(wave.Wave, "finish", _first_twin_only),
    "what was stopped fires before its inputs are there": _swap(wave.Wave, "again", _fires_early),
}


def test_the_checks_find_nothing_where_nothing_is_planted(lab: Any) -> None:
    for seed in range(60):
        search(lab, seed)


@pytest.mark.parametrize("fault", PLANTED)
def test_each_planted_fault_is_found(lab: Any, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    PLANTED[fault](monkeypatch)
    faults = (AssertionError, KeyError, IndexError, TypeError, ValueError, TimeoutError)
    for seed in range(60):
        try:
            search(lab, seed)
        except faults:
            return
    pytest.fail(f"not found: {fault}")


def search(lab: Any, seed: int) -> None:
    """All the checks on the networks of one seed."""
    random_ = random.Random(seed)
    network, results = lab.build(some_spec(random_)), Results()
    check_one_wave(lab, network, list(network.sinks()), Results(), 2)
    lab.run(network, results, [network.order[0]])
    check_one_wave(lab, network, list(network.sinks()), results, 2)
    changed = edited(lab, network, random_)
    check_one_wave(lab, changed, list(changed.sinks()), results, 2)
    disturbed(lab, seed, None)
