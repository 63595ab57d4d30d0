"""What the engine promises, one case each; `test_waves.py` has any network and any row of edits."""

from __future__ import annotations

import json
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from app.engine import firing, scheduler
from app.engine.errors import UnknownName
from app.engine.events import Blocked, Done, Event, Failed, Finished, NodeEvent, Progressed, Reused, Started
from app.engine.executor import Engine, execute
from app.engine.network import Network
from app.engine.results import Results
from app.engine.wave import Wave

CHAIN = {"c": "constant", "n": "negate", "m": "negate"}
WIRES = ("c.value -> n.a", "n.value -> m.a")


def kinds(events: list[Event]) -> list[str]:
    return [type(e).__name__ + (f" {e.node}" if isinstance(e, NodeEvent) else "") for e in events]


def until(engine: Engine, kind: type[Event], node: str = "") -> list[Event]:
    seen: list[Event] = []
    for event in engine.events():
        seen.append(event)
        if isinstance(event, kind) and getattr(event, "node", "") == node:
            break
    return seen


def inside(lab: Any, name: str) -> None:
    """Wait until a module runs, and forget what has fired."""
    seen: list[str] = []
    end = time.monotonic() + 10
    while name not in seen:
        assert time.monotonic() < end
        time.sleep(0.001)
        seen += lab.fired


def test_a_wave_tells_what_happens_in_order(lab: Any) -> None:
    run = lab.run(lab.network(CHAIN, *WIRES), workers=1)
    said = ["Started c", "Finished c", "Started n", "Finished n", "Started m", "Finished m", "Done"]
    assert kinds(run.events) == said
    assert run.values == {"c": 1.0, "n": -1.0, "m": 1.0}


def test_results_are_pulled_only_as_far_as_wanted_and_known(lab: Any) -> None:
    network, results = lab.network({**CHAIN, "x": "zero"}, *WIRES), Results()
    assert lab.run(network, results, ["n"]).of(Started) == ["c", "n"]
    again = lab.run(network, results, ["m"])
    assert (again.of(Reused), again.of(Started)) == (["n"], ["m"])
    results.drop(scheduler.keys(network, lab.catalogue)["c"])
    assert lab.run(network, results, ["m"]).of(Started) == []
    edited = network.set("c", "number", 5, lab.catalogue)
    assert lab.run(edited, results, ["m"]).of(Started) == ["c", "n", "m"]


def test_equal_nodes_run_once(lab: Any) -> None:
    nodes = {"a": "constant", "b": "constant", "p": "negate", "q": "negate"}
    run = lab.run(lab.network(nodes, "a.value -> p.a", "b.value -> q.a"))
    assert lab.fired == ["constant 1", "negate"]
    assert (run.of(Finished), run.of(Reused)) == (["a", "p"], ["b", "q"])
    assert run.entry("p") is run.entry("q")


def test_order_is_the_same_whatever_the_order_of_edits(lab: Any) -> None:
    nodes = {name: ("constant", {"number": i}) for i, name in enumerate("dbac")}
    one = lab.run(lab.network(nodes), workers=1).of(Started)
    other = lab.run(lab.network(dict(reversed(nodes.items()))), workers=1).of(Started)
    assert one == other == ["a", "b", "c", "d"]


def test_a_failure_blocks_what_hangs_on_it_and_nothing_else(lab: Any) -> None:
    nodes = {**CHAIN, "f": "failing", "g": "negate", "h": "add"}
    wires = (*WIRES, "c.value -> f.a", "f.value -> g.a", "g.value -> h.a", "m.value -> h.b")
    run = lab.run(lab.network(nodes, *wires))
    assert run.error("f") == "f (Failing): 1 is not what it should be: take another"
    assert [(e.node, e.by) for e in run.events if isinstance(e, Blocked)] == [("g", "f"), ("h", "f")]
    assert run.values["m"] == 1.0


def test_a_failure_is_kept_by_key_until_it_is_fired_again(lab: Any) -> None:
    network = lab.network({"c": "constant", "f": "failing", "n": "negate"}, "c.value -> f.a", "f.value -> n.a")
    with lab.engine() as engine:
        engine.want(network)
        list(engine.events(once=True))
        engine.want(network)
        again = list(engine.events(once=True))
        assert lab.fired.count("failing") == 1
        assert kinds(again) == ["Failed f", "Blocked n", "Done"]
        engine.fire("f")
        list(engine.events(once=True))
        assert lab.fired == ["failing"]
        engine.want(network.set("c", "number", 2, lab.catalogue))
        list(engine.events(once=True))
        assert lab.fired == ["constant 2", "failing"]


def test_fire_runs_a_node_that_has_a_result(lab: Any) -> None:
    with lab.engine() as engine:
        engine.want(lab.network(CHAIN, *WIRES))
        list(engine.events(once=True))
        assert len(lab.fired) == 3
        engine.fire("n")
        list(engine.events(once=True))
        assert lab.fired == ["negate"]
        engine.fire("nobody")
        list(engine.events(once=True))


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ("value", "1 is not what it should be: take another"),
        ("key", "KeyError: 'absent'"),
        ("exit", "SystemExit: 3"),
        ("cancel", "it stopped by itself and gave nothing"),
        ("type", "Failing gave a str as 'value'; it declares a Value"),
        ("memory", "there is not enough memory: take a part of the data, or a coarser step"),
    ],
)
def test_what_a_module_raises_becomes_one_sentence(lab: Any, how: str, sentence: str) -> None:
    network = lab.network({"c": "constant", "f": ("failing", {"how": how})}, "c.value -> f.a")
    results = Results()
    run = lab.run(network, results)
    assert run.error("f") == f"f (Failing): {sentence}"
    fires = 2 if how == "memory" else 1
    assert lab.fired.count("failing") == fires, "short of memory it empties the store and tries once more"
    if how == "memory":
        assert len(results) == 0
    failed = next(e for e in run.events if isinstance(e, Failed))
    if how in ("value", "key"):
        assert "fakes.py" in failed.error.traceback and "executor" not in failed.error.traceback
    assert failed.error.__traceback__ is None and failed.error.__context__ is None, "it holds no data"


def test_warnings_travel_with_the_result_each_time(lab: Any) -> None:
    for _ in range(2):
        entry = lab.run(lab.network({"c": "constant", "w": "warning"}, "c.value -> w.a")).entry("w")
        assert entry.warnings == ("few samples", "RuntimeWarning: divide by zero encountered in divide")
    with pytest.warns(UserWarning, match="elsewhere"):
        warnings.warn("elsewhere", stacklevel=1)


def test_required_ports_without_a_wire_and_disabled_nodes(lab: Any) -> None:
    network = lab.network({**CHAIN, "u": "negate", "v": "negate"}, *WIRES, "u.value -> v.a")
    run = lab.run(network.disable("n"))
    assert run.error("u") == "u.a (Negate): needs a Value at 'a': wire one"
    blocked = [(e.node, e.by) for e in run.events if isinstance(e, Blocked)]
    assert sorted(blocked) == [("m", "n"), ("n", "n"), ("v", "u")]
    assert lab.fired == [], "nothing that only a blocked node wants is computed"


def test_a_disabled_node_blocks_also_what_is_known(lab: Any) -> None:
    network, results = lab.network(CHAIN, *WIRES), Results()
    lab.run(network, results)
    run = lab.run(network.disable("c"), results)
    assert run.of(Reused) == [] and set(run.of(Blocked)) == {"c", "n", "m"}
    assert lab.run(network, results).of(Reused) == ["m"]


def test_optional_ports(lab: Any) -> None:
    nodes = {"c": "constant", "t": "total", "f": "failing"}
    alone = lab.network(nodes, "c.value -> t.values", "c.value -> f.a")
    assert lab.run(alone).values["t"] == 1.0
    wired = lab.wire(alone, "f.value -> t.extra")
    assert [(e.node, e.by) for e in lab.run(wired).events if isinstance(e, Blocked)] == [("t", "f")]


def test_several_outputs_and_their_facts(lab: Any) -> None:
    nodes = {"c": ("constant", {"number": 4}), "b": "both", "n": "negate"}
    run = lab.run(lab.network(nodes, "c.value -> b.a", "b.half -> n.a"), wanted=["n", "b"])
    assert run.values["n"] == -2.0
    assert run.entry("b").facts["table"] == {"names": ("x",), "rows": 1}


def test_what_is_wired_to_a_setting_must_fit_it(lab: Any) -> None:
    network = lab.network({"c": ("constant", {"number": 2.5}), "s": "slow"}, "c.value -> s.a")
    run = lab.run(lab.wire(network, "c.value -> s.slabs"))
    assert run.error("s") == "s.slabs (Slow): slabs takes a whole number, not 2.5; that came from Constant.value"


def test_published_arrays_are_read_only(lab: Any) -> None:
    run = lab.run(lab.network({"r": "ramp", "v": "vandal"}, "r.samples -> v.samples"))
    assert run.error("v") == "v (Writes into its input): assignment destination is read-only"
    with pytest.raises(ValueError, match="read-only"):
        run.output("r").values[0, 0] = 1


def test_a_bound_of_zero_gives_the_same_results(lab: Any) -> None:
    run = lab.run(lab.network(CHAIN, *WIRES), Results(bound=0))
    assert run.values["m"] == 1.0 and run.of(Started) == ["c", "n", "m"]


def test_wanting_what_is_not_there_is_refused_at_once(lab: Any) -> None:
    with pytest.raises(UnknownName, match="no node 'x'"):
        list(execute(Network(), wanted=["x"], catalogue=lab.catalogue))
    assert kinds(list(execute(Network(), catalogue=lab.catalogue))) == ["Done"]


def test_records_of_events_are_plain_values(lab: Any) -> None:
    nodes = {"c": ("constant", {"sigma": 1}), "f": "failing", "g": "negate", "s": "slow"}
    run = lab.run(lab.network(nodes, "c.value -> f.a", "f.value -> g.a", "c.value -> s.a"))
    records = [json.loads(json.dumps(e.record())) for e in run.events]
    finished = next(r for r in records if r["event"] == "finished" and r["node"] == "c")
    assert finished["budget"]["value"]["terms"][0]["name"] == "stated"
    assert {"wave", "at", "key", "seconds", "bytes", "warnings"} <= set(finished)
    failed = next(r for r in records if r["event"] == "failed")
    assert failed["sentence"].startswith("f (Failing): ") and "ValueError" in failed["traceback"]
    assert records[-1] == {**records[-1], "event": "done", "outcome": "settled"}


# --- edits while it runs


def test_a_final_edit_stops_what_is_stale_and_keeps_what_is_wanted(lab: Any) -> None:
    nodes = {"c": "constant", "s": ("slow", {"slabs": 400}), "t": ("slow", {"slabs": 20}), "o": "total"}
    network = lab.network(nodes, "c.value -> s.a", "c.value -> t.a", "s.value -> o.values", "t.value -> o.values")
    with lab.engine(workers=2) as engine:
        engine.want(network)
        until(engine, Started, "t")
        start = time.perf_counter()
        engine.want(network.set("s", "slabs", 3, lab.catalogue))
        events = list(engine.events(once=True))
        assert time.perf_counter() - start < 2
        assert kinds(events).count("Finished o") == 1
        assert [type(e).__name__ for e in events if e.wave == 1] == ["Done"]
        assert next(e for e in events if isinstance(e, Done)).outcome == "overtaken"
        assert lab.fired.count("slow") == 3, "t ran once, s twice"


def test_interim_edits_keep_pictures_coming(lab: Any) -> None:
    network = lab.network({"c": "constant", "s": ("slow", {"slabs": 5, "pause": 0.01})}, "c.value -> s.a")
    shown: list[float] = []
    with lab.engine() as engine:

        def slide() -> None:
            for number in range(40):
                engine.want(network.set("c", "number", number, lab.catalogue), interim=True)
                time.sleep(0.01)
            engine.want(network.set("c", "number", 99, lab.catalogue))
            time.sleep(0.3)
            engine.close()

        thread = threading.Thread(target=slide)
        thread.start()
        for event in engine.events():
            if isinstance(event, Finished) and event.node == "s":
                shown.append(event.outputs["value"].value)
        thread.join()
    assert shown[-1] == 99 and shown == sorted(shown)
    assert len(shown) >= 3, "pictures came while the slider moved"
    assert lab.fired.count("slow") <= len(shown) + 1, "what ran was not thrown away, but for the last"


def test_final_edits_under_a_slider_show_nothing_before_release(lab: Any) -> None:
    """The other way, so that the difference is known: each edit stops the one before."""
    network = lab.network({"c": "constant", "s": ("slow", {"slabs": 10, "pause": 0.02})}, "c.value -> s.a")
    shown = 0
    with lab.engine() as engine:
        for number in range(5):
            engine.want(network.set("c", "number", number, lab.catalogue))
            shown += sum(isinstance(e, Finished) and e.node == "s" for e in until(engine, Started, "s"))
        assert shown == 0
        assert any(isinstance(e, Finished) and e.node == "s" for e in engine.events(once=True))


@pytest.mark.parametrize("adopts", [True, False], ids=["as it is", "planted fault: nothing is adopted"])
def test_a_running_node_goes_on_for_the_next_wave_also_if_its_inputs_are_gone(
    lab: Any, adopts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not adopts:
        made: Any = Wave.__init__
        monkeypatch.setattr(Wave, "__init__", lambda self, *rest: made(self, *rest[:-1], ()))
    network = lab.network({"c": "constant", "h": "held", "x": "zero"}, "c.value -> h.a")
    lab.gate.clear()
    with lab.engine(results=Results(bound=0), workers=2) as engine:
        engine.want(network, ["h"])
        until(engine, Started, "h")
        inside(lab, "held 0")
        engine.want(network, ["h", "x"])
        events = until(engine, Finished, "x")
        lab.gate.set()
        events += list(engine.events(once=True))
    again = lab.fired.count("constant 1")
    assert (again == 0 and kinds(events).count("Started h") == 1 and "Finished h" in kinds(events)) == adopts


def test_a_late_result_is_kept_and_not_shown(lab: Any) -> None:
    network = lab.network({"c": "constant", "h": "held"}, "c.value -> h.a")
    lab.gate.clear()
    with lab.engine(workers=2) as engine:
        engine.want(network)
        until(engine, Started, "h")
        inside(lab, "held 0")
        engine.want(network, ["c"])
        until(engine, Reused, "c")
        lab.gate.set()
        rest = list(engine.events(once=True))
        assert "Finished h" not in kinds(rest)
        engine.want(network)
        assert "Reused h" in kinds(list(engine.events(once=True)))


def test_what_was_stopped_and_is_wanted_again_runs_again(lab: Any) -> None:
    network = lab.network({"c": "constant", "s": ("slow", {"slabs": 30})}, "c.value -> s.a")
    with lab.engine() as engine:
        engine.want(network)
        until(engine, Started, "s")
        engine.cancel()
        engine.want(network)
        events = list(engine.events(once=True))
        assert kinds(events)[-2:] == ["Finished s", "Done"]
        assert [e.outcome for e in events if isinstance(e, Done)] == ["cancelled", "settled"]


def test_fire_runs_anew_what_was_stopped_and_has_not_ended(lab: Any) -> None:
    network = lab.network({"c": "constant", "h": "held"}, "c.value -> h.a")
    lab.gate.clear()
    with lab.engine(workers=2) as engine:
        engine.want(network)
        until(engine, Started, "h")
        inside(lab, "held 0")
        engine.cancel()
        engine.fire("h")
        threading.Timer(0.2, lab.gate.set).start()
        assert kinds(list(engine.events(once=True)))[-2:] == ["Finished h", "Done"]
    assert lab.fired == ["held 0"], "what fired before it was stopped has been forgotten"


def test_firing_a_node_does_not_bring_back_the_network_before(lab: Any) -> None:
    network = lab.network(CHAIN, *WIRES)
    with lab.engine() as engine:
        engine.want(network)
        list(engine.events(once=True))
        engine.want(network.set("c", "number", 7, lab.catalogue))
        engine.fire("n")
        events = list(engine.events(once=True))
    assert [e.outputs["value"].value for e in events if isinstance(e, Finished) and e.node == "m"] == [7.0]


def test_a_modules_own_handling_of_warnings_does_no_harm(lab: Any) -> None:
    """Filters belong to the process: what a module saves and puts back late may be the engine's."""
    with firing.heard():
        late = warnings.catch_warnings()
        late.__enter__()
    late.__exit__(None, None, None)
    with firing.heard() as said:
        warnings.warn("inside", stacklevel=1)
    assert said == ["inside"]
    with pytest.warns(UserWarning, match="outside"):
        warnings.warn("outside", stacklevel=1)


def test_cancelling_is_not_failing_and_keeps_what_is_done(lab: Any) -> None:
    network = lab.network({"c": "constant", "s": ("slow", {"slabs": 300})}, "c.value -> s.a")
    with lab.engine() as engine:
        engine.want(network)
        until(engine, Started, "s")
        start = time.perf_counter()
        engine.cancel()
        events = list(engine.events(once=True))
        assert time.perf_counter() - start < 0.1
        assert [type(e) for e in events if not isinstance(e, Progressed)] == [Done]
        assert not engine.results.failures and len(engine.results) == 1


def test_closing_ends_the_events_from_any_thread(lab: Any) -> None:
    engine = lab.engine()
    engine.want(lab.network({"c": "constant", "s": ("slow", {"slabs": 300})}, "c.value -> s.a"))
    threading.Timer(0.1, engine.close).start()
    start = time.perf_counter()
    list(engine.events())
    assert time.perf_counter() - start < 1


def test_leaving_the_iterator_stops_the_work(lab: Any) -> None:
    network = lab.network({"c": "constant", "s": ("slow", {"slabs": 300})}, "c.value -> s.a")
    events = execute(network, catalogue=lab.catalogue)
    for event in events:
        if isinstance(event, Started) and event.node == "s":
            break
    events.close()  # type: ignore[attr-defined]  # a generator closes
    time.sleep(0.1)
    assert "slow ended" not in lab.fired


def test_progress_is_told_and_slabs_share_a_full_pool(lab: Any) -> None:
    nodes = {"c": "constant", "s": ("slow", {"slabs": 20, "pause": 0.02}), "t": ("slow", {"slabs": 21, "pause": 0.02})}
    with ThreadPoolExecutor(2) as pool:
        run = lab.run(lab.network(nodes, "c.value -> s.a", "c.value -> t.a"), pool=pool, workers=2)
    told = [e.fraction for e in run.events if isinstance(e, Progressed) and e.node == "s"]
    assert told == sorted(told) and len(told) > 2
    assert set(run.of(Finished)) == {"c", "s", "t"}


def test_results_do_not_depend_on_the_number_of_threads(lab: Any) -> None:
    nodes = {f"c{i}": ("constant", {"number": i, "sigma": 1}) for i in range(6)}
    wires = [f"c{i}.value -> o.values" for i in range(6)]
    network = lab.network({**nodes, "o": "ordered"}, *wires)
    runs = [lab.run(network, workers=n) for n in (1, 2, 8)]
    assert len({r.output("o").value for r in runs}) == 1
    assert len({tuple(t.id for t in r.output("o").accuracy.terms) for r in runs}) == 1


def test_documents_share_a_store(lab: Any) -> None:
    results = Results()
    lab.run(lab.network(CHAIN, *WIRES), results)
    other = lab.network({"x": "constant", "y": "negate"}, "x.value -> y.a")
    assert lab.run(other, results).of(Reused) == ["y"]


def test_a_reloaded_module_fires_again_by_itself(lab: Any, tmp_path: Any) -> None:
    from app.engine.catalogue import Catalogue
    from tests.engine.test_catalogue import module

    path = tmp_path / "mine.py"
    path.write_text(module(value="1.0"))
    catalogue = Catalogue.of([], tmp_path)
    network = Network().add("one", catalogue)
    with Engine(catalogue) as engine:
        for value in ("1.0", "2.0"):
            path.write_text(module(value=value))
            catalogue.reload()
            engine.want(network)
            shown = [e.outputs["value"].value for e in engine.events(once=True) if isinstance(e, Finished)]
            assert shown == [float(value)]


def test_large_arrays_are_counted_and_not_copied(lab: Any) -> None:
    results = Results()
    network = lab.network({"r": ("ramp", {"count": 1000}), "m": "between"}, "r.samples -> m.samples")
    run = lab.run(network, results, wanted=["r", "m"])
    samples, model = run.output("r"), run.output("m")
    assert np.shares_memory(samples.values, model.samples.values)
    assert results.bytes < 2 * samples.values.nbytes + 50_000
