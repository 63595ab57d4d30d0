"""The document of the window: edits, waves, states, looks; driven through its public doors with modules without science."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from app.engine.catalogue import Catalogue, mine
from app.engine.network import Network
from app.gui.session import Session
from modules.api import EXACT, Annotated, Range, Samples, Value, modeller, reader
from modules.progress import Progress

GO = threading.Event()
RAN: list[float] = []


@reader("One", output="value")
def one(*, number: Annotated[float, Range(0, 10)] = 1.0) -> Value:
    """A number.

    Accuracy: exact.
    """
    RAN.append(number)
    return Value(value=number, accuracy=EXACT)


@reader("Slow", output="value")
def slow(progress: Progress, *, number: float = 1.0) -> Value:
    """A number that takes its time.

    Accuracy: exact.
    """
    RAN.append(number)
    for i in range(400):
        progress(i / 400)
        if GO.wait(0.005):
            break
    return Value(value=number, accuracy=EXACT)


@modeller("Bad", output="value")
def bad(value: Value) -> Value:
    """Fails.

    Accuracy: exact.
    """
    raise ValueError("the number is odd: choose an even one")


CATALOGUE = Catalogue.of([one, slow, bad])


@pytest.fixture
def session(session_of: Callable[..., Session]) -> Iterator[Session]:
    GO.clear()
    RAN.clear()
    yield session_of(CATALOGUE)
    GO.set()


def add(session: Session, module: str, **parameters: Any) -> str:
    name = session.network.fresh_id(CATALOGUE.find(module).id)
    session.edit(f"Add {name}", session.network.add(module, CATALOGUE, parameters=parameters))
    return name


def put(session: Session, node: str, number: float, interim: bool = False) -> None:
    network = session.network.set(node, "number", number, CATALOGUE)
    session.edit("Set number", network, merge=("set", node, "number"), interim=interim)


def value(session: Session, node: str) -> Any:
    outputs = session.outputs(node)
    return outputs["value"].value if outputs else None


def test_what_is_looked_at_runs_and_the_rest_does_not(session: Session, qtbot: Any) -> None:
    seen, unseen = add(session, "one"), add(session, "one", number=2.0)
    session.select([seen])
    qtbot.waitUntil(lambda: session.state(seen).kind == "clean", timeout=5000)
    assert value(session, seen) == 1.0
    assert session.state(unseen).kind == "dirty"
    session.run_all()
    qtbot.waitUntil(lambda: session.state(unseen).kind == "clean", timeout=5000)


def test_an_edit_makes_the_result_stale_until_the_next_is_there(session: Session, qtbot: Any) -> None:
    node = add(session, "one")
    session.select([node])
    qtbot.waitUntil(lambda: value(session, node) == 1.0, timeout=5000)
    put(session, node, 3.0)
    assert session.stale(node)
    assert value(session, node) == 1.0
    qtbot.waitUntil(lambda: not session.stale(node), timeout=5000)
    assert value(session, node) == 3.0


def test_moving_a_node_fires_nothing(session: Session, qtbot: Any) -> None:
    node = add(session, "one")
    session.select([node])
    qtbot.waitUntil(lambda: session.state(node).kind == "clean", timeout=5000)
    ran = len(RAN)
    session.edit("Move", session.network.move({node: (10, 20)}))
    session.amend(session.network.look(node, camera={"height": 1.0}))
    qtbot.wait(100)
    assert len(RAN) == ran
    assert session.state(node).kind == "clean"


def test_a_held_slider_is_one_step_of_undo_and_ends_with_its_last_value(session: Session, qtbot: Any) -> None:
    node = add(session, "one")
    session.select([node])
    for i in range(40):
        put(session, node, i / 10, interim=True)
        qtbot.wait(2)
    put(session, node, 3.9)
    qtbot.waitUntil(lambda: value(session, node) == 3.9 and not session.stale(node), timeout=5000)
    assert len(RAN) < 30
    session.undo()
    assert session.network[node].parameters.get("number") is None
    session.redo()
    assert session.network[node].parameters["number"] == 3.9


def test_pictures_come_while_a_slider_is_held(session: Session, qtbot: Any) -> None:
    node = add(session, "slow")
    session.select([node])
    GO.set()
    qtbot.waitUntil(lambda: session.state(node).kind == "clean", timeout=5000)
    seen = set()
    for i in range(20):
        put(session, node, float(i + 2), interim=True)
        qtbot.wait(40)
        seen.add(value(session, node))
    assert len(seen) > 5


def test_a_failure_is_told_in_a_sentence_and_stops_nothing_else(session: Session, qtbot: Any) -> None:
    source, broken, other = add(session, "one"), add(session, "bad"), add(session, "one", number=2.0)
    session.edit("Wire", session.network.connect(source, "value", broken, "value", CATALOGUE))
    session.run_all()
    qtbot.waitUntil(lambda: session.state(broken).kind == "failed", timeout=5000)
    qtbot.waitUntil(lambda: session.state(other).kind == "clean", timeout=5000)
    assert session.state(broken).sentence == "the number is odd: choose an even one"
    error = session.state(broken).error
    assert error is not None and "raise ValueError" in error.traceback


def test_cancel_keeps_what_was_there(session: Session, qtbot: Any) -> None:
    node = add(session, "slow")
    session.select([node])
    qtbot.waitUntil(lambda: session.state(node).kind == "running", timeout=5000)
    with qtbot.waitSignal(session.waveDone, timeout=5000):
        session.cancel()
    qtbot.waitUntil(lambda: session.state(node).kind == "dirty", timeout=5000)
    qtbot.waitUntil(lambda: not session.runs.worker.engine.firing, timeout=5000)  # the stopped one has ended
    GO.set()
    session.fire(node)
    qtbot.waitUntil(lambda: session.state(node).kind == "clean", timeout=5000)
    assert RAN == [1.0, 1.0]


def test_frozen_and_held_nodes_wait(session: Session, qtbot: Any) -> None:
    session.freeze(True)
    node = add(session, "one")
    session.select([node])
    qtbot.wait(80)
    assert not RAN
    session.hold(node)
    session.freeze(False)
    qtbot.wait(80)
    assert not RAN and session.state(node).kind == "held"
    session.fire(node)
    qtbot.waitUntil(lambda: session.state(node).kind == "clean", timeout=5000)


def test_disabled_and_missing_are_said(session: Session) -> None:
    node = add(session, "one")
    session.disable(node)
    assert session.state(node).kind == "disabled"
    session.undo()
    assert session.state(node).kind == "dirty"
    assert session.state("nobody").kind == "missing"


def test_copy_and_paste_with_fresh_ids(session: Session) -> None:
    source, broken = add(session, "one", number=4.0), add(session, "bad")
    session.edit("Wire", session.network.connect(source, "value", broken, "value", CATALOGUE))
    session.select([broken])
    text = session.copy()
    session.paste(text)
    assert session.selection == ("bad-2",)
    assert session.network.wires["bad-2", "value", 0] == (source, "value")
    session.paste(text, incoming=False)
    assert ("bad-3", "value", 0) not in session.network.wires


def test_text_that_is_no_network_says_so(session: Session, qtbot: Any) -> None:
    with qtbot.waitSignal(session.message) as said:
        session.paste("hello")
    assert said.args[0] == "error"
    assert not session.network.nodes


def test_save_and_open_keep_the_network(session: Session, tmp_path: Any) -> None:
    add(session, "one", number=7.0)
    seen = [(session.modified, session.path)]
    session.save(tmp_path / "a.json")
    seen.append((session.modified, session.path))
    session.new()
    seen.append((bool(session.network.nodes), session.path))
    session.open(tmp_path / "a.json")
    seen.append((session.modified, session.path))
    assert seen == [(True, None), (False, tmp_path / "a.json"), (False, None), (False, tmp_path / "a.json")]
    assert session.network["one-1"].parameters["number"] == 7.0


def test_the_event_loop_never_waits_for_a_module(session: Session, qtbot: Any, stalls: Any) -> None:
    add(session, "slow")
    session.run_all()
    with stalls() as worst:
        qtbot.wait(600)
    GO.set()
    assert worst() < 0.05


def test_results_for_a_thousand_nodes_come_without_a_stall(session: Session, qtbot: Any, stalls: Any) -> None:
    network = Network()
    for i in range(300):
        network = network.add("one", CATALOGUE, parameters={"number": float(i)})
    with stalls() as worst:
        session.edit("Add many", network)
        session.run_all()
        qtbot.waitUntil(lambda: all(session.state(n).kind in ("clean", "cached") for n in network.nodes), timeout=15000)
    assert worst() < 0.25


def test_a_glance_is_computed_elsewhere_and_told(session_of: Callable[..., Session], qtbot: Any) -> None:
    from app.engine.catalogue import mine

    real = session_of(mine())
    parameters = {"samples": (17, 17), "noise": 0.01}
    field = real.network.add("readers.analytic.analytic", real.catalogue, id="field", parameters=parameters)
    network = field.add("interpolate", real.catalogue, id="model")
    real.edit("Add", network.connect("field", "samples", "model", "samples", real.catalogue))
    real.select(["model"])
    qtbot.waitUntil(lambda: real.outputs("model") is not None, timeout=30000)
    here, where = threading.get_ident(), list[int]()
    assert real.look("glance of mine", "model", job=lambda: where.append(threading.get_ident())) is None
    qtbot.waitUntil(lambda: bool(where), timeout=5000)
    assert where[0] != here
    qtbot.waitUntil(lambda: bool(real.glance("model", "model")), timeout=10000)
    assert {one.stage for one in real.glance("model", "model")} >= {"data"}
    assert isinstance(real.outputs("field")["samples"], Samples)  # type: ignore[index]


def test_a_network_that_ran_before_shows_all_its_results_when_it_is_opened_again(
    session_of: Callable[..., Session], tmp_path: Path, qtbot: Any
) -> None:
    session = session_of(mine())
    network = session.network.add("readers.analytic.analytic", session.catalogue, id="field")
    network = network.add("interpolate", session.catalogue, id="model")
    session.edit("Add", network.connect("field", "samples", "model", "samples", session.catalogue))
    session.run_all()
    qtbot.waitUntil(lambda: session.state("model").kind == "clean", timeout=20000)
    session.save(tmp_path / "mine.json")
    session.new()
    session.open(tmp_path / "mine.json")
    session.run_all()
    qtbot.waitUntil(lambda: session.state("model").kind == "cached", timeout=20000)
    qtbot.waitUntil(lambda: session.state("field").kind == "cached", timeout=2000)
    assert session.outputs("field") is not None
