"""Undo and redo."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from app.engine.history import History
from app.engine.network import Network


def test_undo_and_redo_walk_the_list(lab: Any) -> None:
    first = Network()
    history = History(first)
    one = history.commit("Add Zero", first.add("zero", lab.catalogue))
    two = history.commit("Add Negate", one.add("negate", lab.catalogue))
    assert history.labels == ("", "Add Zero", "Add Negate")
    assert (history.undo_label, history.redo_label) == ("Add Negate", "")
    assert history.undo() is one and history.undo() is first and history.undo() is first
    assert history.redo() is one and history.redo() is two and history.redo() is two
    history.undo()
    history.commit("Add Add", one.add("add", lab.catalogue))
    assert history.labels == ("", "Add Zero", "Add Add")
    assert history.go(0) is first and history.place == 0


def test_edits_of_a_held_slider_are_one_step(lab: Any) -> None:
    network = lab.network({"c": "constant"})
    history = History(network)
    for number in range(2, 6):
        history.commit("Set number", history.network.set("c", "number", number, lab.catalogue), merge=("set", "c", "number"))
    history.seal()
    history.commit("Set number", history.network.set("c", "number", 9, lab.catalogue), merge=("set", "c", "number"))
    assert len(history.labels) == 3
    assert history.undo().nodes["c"].parameters["number"] == 5
    assert history.undo() is network


def test_a_camera_is_no_step_and_stays_when_a_step_is_undone(lab: Any) -> None:
    history = History(lab.network({"c": "constant"}))
    history.commit("Move", history.network.move({"c": (1, 1)}))
    history.amend(history.network.look("c", camera=[1, 2, 3]))
    assert len(history.labels) == 2
    undone = history.undo()
    assert undone.nodes["c"].view == {"camera": [1, 2, 3]}
    assert history.redo().nodes["c"].view == {"position": [1.0, 1.0], "camera": [1, 2, 3]}


def test_it_knows_whether_something_has_changed_since_it_was_saved(lab: Any) -> None:
    history = History(lab.network({"c": "constant"}))
    seen = [history.modified]
    history.commit("Set", history.network.set("c", "number", 4, lab.catalogue))
    seen.append(history.modified)
    for step in (history.saved, history.undo, history.redo):
        step()
        seen.append(history.modified)
    assert seen == [False, True, False, True, False]


def test_the_oldest_steps_are_forgotten(lab: Any) -> None:
    history = History(lab.network({"c": "constant"}), bound=3)
    for number in range(10):
        history.commit(str(number), history.network.set("c", "number", number + 2, lab.catalogue))
    assert history.labels == ("6", "7", "8", "9")


@given(st.data())
def test_undo_then_redo_is_the_identity(lab: Any, specs: Any, data: Any) -> None:
    history = History(Network())
    for i in range(data.draw(st.integers(1, 5))):
        history.commit(str(i), lab.build(data.draw(specs)), merge=data.draw(st.sampled_from([None, "slider"])))
    before = history.network
    steps = data.draw(st.integers(0, 6))
    taken = 0
    for _ in range(steps):
        taken += bool(history.undo_label)
        history.undo()
    for _ in range(taken):
        history.redo()
    assert history.network == before
