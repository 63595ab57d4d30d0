"""The law of the budget: by identity, each source goes on or is ended; new ones are signed with the key."""

from __future__ import annotations

from typing import Any

import pytest

from app.engine import law, scheduler
from app.engine.errors import Unaccounted
from app.engine.events import Failed
from modules.data.accuracy import EXACT, Accuracy, accuracies, bound
from modules.data.wires import Value

TWO = {"a": ("constant", {"sigma": 1}), "b": ("constant", {"sigma": 2})}


def test_a_module_that_forgets_an_input_fails_with_the_remedy(lab: Any) -> None:
    network = lab.network({**TWO, "f": "forgets"}, "a.value -> f.a", "b.value -> f.b")
    run = lab.run(network)
    error = next(e.error for e in run.events if isinstance(e, Failed))
    assert isinstance(error, Unaccounted)
    assert str(error) == (
        "f.value (Forgets): the output 'value' says nothing of 'stated', which came in at 'b': pass it on, end it with "
        ".end(..., 'why') or .end_from(..., 'why'), or declare independent={'value': ('b',)}"
    )


@pytest.mark.parametrize("module", ["independent", "selects", "add"])
def test_who_says_what_happens_to_each_source_is_heard(lab: Any, module: str) -> None:
    run = lab.run(lab.network({**TWO, "f": module}, "a.value -> f.a", "b.value -> f.b"))
    assert "f" in run.values


def test_what_ended_upstream_is_not_asked_again(lab: Any) -> None:
    wires = ("a.value -> s.a", "b.value -> s.b", "s.value -> n.a")
    run = lab.run(lab.network({**TWO, "s": "selects", "n": "negate"}, *wires))
    assert [e.why for e in run.output("n").accuracy.ended.values()] == ["not selected"]


def test_new_sources_are_signed_with_the_key_of_their_firing(lab: Any) -> None:
    network = lab.network({"c": ("constant", {"sigma": 1}), "n": "noise"}, "c.value -> n.a")
    keys = scheduler.keys(network, lab.catalogue)
    ids = [t.id for t in lab.run(network).output("n").accuracy.terms]
    assert ids == [f"{keys['c']}:value:stated", f"{keys['n']}:value:noise", f"{keys['n']}:value:noise:2"]


def test_equal_firings_make_one_source_so_that_x_minus_x_is_exact(lab: Any) -> None:
    nodes = {"a": ("constant", {"sigma": 1}), "b": ("constant", {"sigma": 1}), "n": "negate", "s": "add", "o": "add"}
    wires = ("a.value -> n.a", "a.value -> s.a", "b.value -> s.b")
    output = lab.run(lab.network(nodes, *wires, "a.value -> o.a", "n.value -> o.b")).output("s")
    assert len(output.accuracy.terms) == 1, "two readers of one thing are one source"
    assert float(output.accuracy.terms[0].size()[0]) == 2.0


def test_sources_named_by_a_reader_keep_their_name() -> None:
    named = Value(value=1.0, accuracy=EXACT.add(bound("half a unit", 0.5, 1, id="abc/height/half a unit")))
    signed = law.sign("key", {}, {"value": named})
    assert [t.id for t in signed["value"].accuracy.terms] == ["abc/height/half a unit"]


def test_a_source_in_two_outputs_has_one_name_and_ended_ones_are_signed_too() -> None:
    term = bound("b", 1.0, 1)
    one = Value(value=1.0, accuracy=EXACT.add(term))
    other = Value(value=2.0, accuracy=EXACT.add(term).end(term, "why"))
    signed = law.sign("key", {}, {"x": one, "y": other})
    assert set(signed["x"].accuracy.accounted()) == set(signed["y"].accuracy.accounted()) == {"key:x:b"}


def test_what_needs_no_signature_stays_the_very_object(lab: Any) -> None:
    run = lab.run(lab.network({"c": ("constant", {"sigma": 1}), "h": "held"}, "c.value -> h.a"), wanted=["c", "h"])
    assert run.output("h") is run.output("c")


def test_a_twin_socket_carries_the_accuracy_alone(lab: Any) -> None:
    network = lab.network({"c": ("constant", {"sigma": 1}), "u": "uncertainty"}, "c.value:accuracy -> u.accuracy")
    assert lab.run(network).values["u"] == 1.0


def test_a_value_wired_to_a_setting_leaves_its_uncertainty_behind_and_says_so(lab: Any) -> None:
    network = lab.network({"l": ("constant", {"number": 3, "sigma": 1}), "c": "constant"}, "l.value -> c.number")
    output = lab.run(network).output("c")
    assert output.value == 3.0
    assert [m.name for m in output.accuracy.missing] == ["number: uncertainty of Constant.value not carried"]
    assert output.accuracy.rigour() == "unknown"
    exact = lab.run(network.set("l", "sigma", 0, lab.catalogue)).output("c")
    assert exact.accuracy.missing == ()


def test_a_colour_map_carries_none_and_is_asked_nothing(lab: Any) -> None:
    run = lab.run(lab.network({"c": "colours"}))
    assert not law.carries_accuracy(run.output("c"))


def test_a_port_of_samples_gets_the_samples_of_a_model(lab: Any) -> None:
    nodes = {"r": "ramp", "m": "between", "s": "summed"}
    run = lab.run(lab.network(nodes, "r.samples -> m.samples", "m.model -> s.samples"))
    assert run.values["s"] == sum(range(16))


def test_carriers_know_the_firing_they_come_from(lab: Any) -> None:
    network = lab.network({"r": "ramp"})
    run, keys = lab.run(network), scheduler.keys(network, lab.catalogue)
    assert run.output("r").accuracy.of.key == f"{keys['r']}:samples"


def test_every_source_of_a_long_list_is_checked(lab: Any) -> None:
    terms = [bound(f"b{i}", 1.0, 1) for i in range(200)]
    inputs = {f"p{i}": [Value(value=0.0, accuracy=Accuracy(tuple(terms)))] for i in range(20)}
    module = lab.catalogue["user.fakes.add"]
    law.check(module, "n", inputs, {"value": Value(value=0.0, accuracy=Accuracy(tuple(terms)))})
    with pytest.raises(Unaccounted, match="'b199'"):
        law.check(module, "n", inputs, {"value": Value(value=0.0, accuracy=Accuracy(tuple(terms[:-1])))})
    assert len(list(accuracies(inputs))) == 20
