"""Edits of a network: legal, or refused with a sentence; the network before stays as it was."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine import check
from app.engine.errors import CycleError, NameTaken, NetworkError, PortTaken, TypeMismatch, UnknownName, ValueRefused
from app.engine.network import Network, Node


@pytest.fixture
def pair(lab: Any) -> Network:
    network: Network = lab.network({"c": "constant", "n": "negate"}, "c.value -> n.a")
    return network


def test_an_edit_leaves_the_network_before_as_it_was(lab: Any, pair: Network) -> None:
    nodes, wires = dict(pair.nodes), dict(pair.wires)
    pair.set("c", "number", 4, lab.catalogue).remove("n").add("zero", lab.catalogue)
    assert (dict(pair.nodes), dict(pair.wires)) == (nodes, wires)


def test_ids_are_readable_and_are_not_given_twice(lab: Any) -> None:
    network = Network().add("constant", lab.catalogue).add("constant", lab.catalogue)
    assert list(network.nodes) == ["constant-1", "constant-2"]
    assert network.remove("constant-1").fresh_id("x.constant") == "constant-3"


def test_renaming_moves_the_wires(lab: Any, pair: Network) -> None:
    renamed = pair.rename("c", "level").rename("n", "below")
    assert dict(renamed.wires) == {("below", "a", 0): ("level", "value")}
    assert renamed.rename("level", "level") is renamed


def test_lists_keep_their_order_and_close_gaps(lab: Any) -> None:
    nodes = {"a": "zero", "b": "constant", "c": "constant", "o": "ordered"}
    network = lab.network(nodes, "a.value -> o.values", "b.value -> o.values")
    network = network.connect("c", "value", "o", "values", lab.catalogue, slot=0)
    assert network.incoming["o"]["values"] == (("c", "value"), ("a", "value"), ("b", "value"))
    closed = network.disconnect("o", "values", 1)
    assert closed.wires == {("o", "values", 0): ("c", "value"), ("o", "values", 1): ("b", "value")}
    assert network.remove("c").incoming["o"]["values"] == (("a", "value"), ("b", "value"))
    other = network.connect("b", "value", "o", "values", lab.catalogue, slot=0, instead=True)
    assert other.incoming["o"]["values"] == (("b", "value"), ("a", "value"), ("b", "value"))


def test_a_model_goes_where_samples_are_wanted_and_a_value_to_a_parameter(lab: Any) -> None:
    nodes = {"r": "ramp", "m": "between", "s": "summed", "c": "constant"}
    network = lab.network(nodes, "r.samples -> m.samples", "m.model -> s.samples", "s.value -> c.number")
    assert len(network.wires) == 3


REFUSALS: list[tuple[str, type[NetworkError], str]] = [
    ("n.connect('c', 'value', 'n', 'a', m)", PortTaken, r"n\.a has a wire from c\.value already: disconnect that first"),
    ("n.connect('n', 'value', 'n', 'a', m)", CycleError, "'n' cannot be wired to itself"),
    ("n.connect('n', 'value', 'c', 'number', m)", CycleError, "wiring 'n' to 'c' closes a circle: c -> n -> c"),
    ("n.connect('d', 'value', 'n', 'a', m)", UnknownName, "no node 'd'; there are 'c', 'n'"),
    ("n.connect('c', 'valeu', 'n', 'a', m)", UnknownName, r"c \(Constant\) has no output 'valeu'; did you mean 'value'\?"),
    ("n.connect('c', 'value:acc', 'n', 'a', m)", UnknownName, "has the twin socket 'value:accuracy'"),
    ("n.connect('c', 'value', 'n', 'aa', m)", UnknownName, r"n \(Negate\) has no port 'aa'; did you mean 'a'\?"),
    ("n.connect('c', 'value:accuracy', 'n', 'a', m)", TypeMismatch, "needs a Value, got Accuracy: take 'value'"),
    ("n.add('uncertainty', m, id='u').connect('c', 'value', 'u', 'accuracy', m)", TypeMismatch,
     "take the twin socket 'value:accuracy'"),
    ("n.add('ramp', m, id='r').add('mean', m, id='a').connect('r', 'samples', 'a', 'model', m)", TypeMismatch,
     r"r\.samples -> a\.model: 'model' needs a Model, got Samples: put an 'interpolate' between them"),
    ("n.add('ramp', m, id='r').connect('r', 'samples', 'c', 'number', m)", TypeMismatch,
     "'number' is a setting .*only a Value can be wired to it, not Samples"),
    ("n.disconnect('n', 'b')", UnknownName, r"no wire ends at n\.b"),
    ("n.disconnect('n', 'a', 3)", UnknownName, r"no wire ends at n\.a\[3\]"),
    ("n.set('c', 'numbr', 1, m)", UnknownName, r"c \(Constant\) has no parameter 'numbr'; did you mean 'number'\?"),
    ("n.set('n', 'a', 1, m)", UnknownName, r"n\.a is a port of 'Negate', not a parameter: wire it"),
    ("n.set('c', 'number', 'much', m)", ValueRefused, "c: number takes a number, not 'much'"),
    ("n.set('c', 'number', float('nan'), m)", ValueRefused, "leave it empty for 'automatic'"),
    ("n.set('c', 'number', float('inf'), m)", ValueRefused, "not infinite here"),
    ("n.add('wide', m, id='w').set('w', 'mode', 'fats', m)", ValueRefused, "no option 'fats'.*did you mean 'fast'"),
    ("n.add('wide', m, id='w').set('w', 'on', 3, m)", ValueRefused, "on takes true or false, not 3"),
    ("n.add('wide', m, id='w').set('w', 'levels', range(10000), m)", ValueRefused, "make it a data file and read it"),
    ("n.add('negat', m)", UnknownName, "no module 'negat'; did you mean 'negate'"),
    ("n.add('zero', m, id='c')", NameTaken, "there is a node 'c' already"),
    ("n.add('zero', m, id='a.b')", NameTaken, "use letters, digits"),
    ("n.rename('c', 'n')", NameTaken, "there is a node 'n' already"),
    ("n.rename('x', 'y')", UnknownName, "no node 'x'"),
    ("n.remove('cc')", UnknownName, "no node 'cc'; did you mean 'c'"),
    ("n.settle(k=-1)", ValueRefused, "k is a positive number"),
    ("n.settle(title=3)", ValueRefused, "title is text"),
]  # fmt: skip


@pytest.mark.parametrize(("edit", "kind", "sentence"), REFUSALS, ids=[r[0] for r in REFUSALS])
def test_what_is_refused_is_said_in_a_sentence(
    lab: Any, pair: Network, edit: str, kind: type[NetworkError], sentence: str
) -> None:
    with pytest.raises(kind, match=sentence) as caught:
        eval(edit, {"n": pair, "m": lab.catalogue, "float": float, "range": range})
    assert caught.value.exit_code == 2


def test_infinity_is_taken_where_the_range_says_so(lab: Any) -> None:
    network = lab.network({"w": ("wide", {"level": float("inf")})})
    assert network.nodes["w"].parameters["level"] == float("inf")


def test_setting_the_same_value_changes_nothing(lab: Any, pair: Network) -> None:
    network = pair.set("c", "number", 3, lab.catalogue)
    assert network.set("c", "number", 3.0, lab.catalogue) is network
    assert network.reset("c", "number", lab.catalogue) == pair


def test_a_pasted_part_has_new_ids_and_its_wires(lab: Any) -> None:
    nodes = {"constant-1": "constant", "negate-1": "negate", "total-1": "total"}
    network = lab.network(nodes, "constant-1.value -> negate-1.a", "negate-1.value -> total-1.values")
    network = network.move({"negate-1": (10, 20)})
    part = network.part(["negate-1", "total-1"])
    pasted = network.paste(part, lab.catalogue, by=(5, 5))
    assert network.pasted_ids(part) == {"negate-1": "negate-2", "total-1": "total-2"}
    assert pasted.wires[("total-2", "values", 0)] == ("negate-2", "value")
    assert pasted.wires[("negate-2", "a", 0)] == ("constant-1", "value")
    assert pasted.nodes["negate-2"].view == {"position": [15.0, 25.0]}
    bare = network.paste(part, lab.catalogue, incoming=False)
    assert ("negate-2", "a", 0) not in bare.wires
    assert set(Network().paste(part, lab.catalogue).nodes) == {"negate-1", "total-1"}


def test_problems_name_what_could_not_run(lab: Any) -> None:
    network = lab.network({"n": "negate", "t": "total"})
    network = Network({**network.nodes, "g": Node("g", "mappers.gone.gone")}, network.wires)
    sentences = [str(p) for p in check.problems(network.nodes, network.wires, lab.catalogue)]
    assert any("g is of a module 'mappers.gone.gone' that is not here" in s for s in sentences)
    assert "n (Negate) needs a Value at 'a': wire one" in sentences
    assert "t (Total) needs a Value, or several, at 'values': wire one" in sentences


def test_networks_pickle(lab: Any, pair: Network) -> None:
    assert pair.order and pair.incoming
    assert pickle.loads(pickle.dumps(pair)) == pair


def edit(lab: Any, network: Network, one: str, other: str, which: int) -> Network:
    match which:
        case 0:
            return network.connect(one, "value", other, "a", lab.catalogue)
        case 1:
            return network.connect(one, "value", other, "values", lab.catalogue)
        case 2:
            return network.disconnect(one, "values")
        case 3:
            return network.remove(one) if len(network.nodes) > 1 else network
        case 4:
            return network.rename(one, f"{one}x")
    return network.paste(network.part([one, other]), lab.catalogue)


@given(st.data())
def test_any_row_of_edits_leaves_a_legal_network(lab: Any, specs: Any, data: Any) -> None:
    network = lab.build(data.draw(specs))
    for _ in range(data.draw(st.integers(0, 6))):
        names = sorted(network.nodes)
        one, other = data.draw(st.sampled_from(names)), data.draw(st.sampled_from(names))
        try:
            network = edit(lab, network, one, other, data.draw(st.integers(0, 5)))
        except NetworkError:
            continue
        check.network(network.nodes, network.wires, lab.catalogue)
        for target, ports in network.incoming.items():
            for port, origins in ports.items():
                assert all((target, port, i) in network.wires for i in range(len(origins)))
