"""Bypassed nodes: wires go round them before keys, so results are those of the network without them."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine import document, scheduler
from app.engine.errors import DocumentError, TypeMismatch
from app.engine.network import Network

CHAIN = {"c": ("constant", {"number": 3}), "n": "negate", "m": "negate", "z": "negate"}
WIRES = ("c.value -> n.a", "n.value -> m.a", "m.value -> z.a")


@pytest.fixture
def chain(lab: Any) -> Network:
    network: Network = lab.network(CHAIN, *WIRES)
    return network


def test_what_comes_in_goes_on(lab: Any, chain: Network) -> None:
    assert lab.run(chain).values["z"] == -3.0
    one = chain.pass_through("n", True, lab.catalogue)
    run = lab.run(one)
    assert run.values["z"] == 3.0 and "n" not in run.values
    two = one.pass_through("m", True, lab.catalogue)
    assert lab.run(two).values["z"] == -3.0
    assert two.pass_through("n", False, lab.catalogue).pass_through("m", False, lab.catalogue).nodes == chain.nodes


def test_keys_are_those_of_the_network_without_it(lab: Any, chain: Network) -> None:
    without = chain.remove("n").connect("c", "value", "m", "a", lab.catalogue)
    keys = scheduler.keys(chain.pass_through("n", True, lab.catalogue).around, lab.catalogue)
    assert {n: keys[n] for n in ("c", "m", "z")} == scheduler.keys(without, lab.catalogue)


def test_a_network_without_any_is_run_as_it_is(chain: Network) -> None:
    assert chain.around is chain


def test_a_node_that_gives_another_type_is_refused_with_a_reason(lab: Any) -> None:
    network = lab.network({"r": "ramp", "b": "between"}, "r.samples -> b.samples")
    with pytest.raises(TypeMismatch, match=r"it takes .+ and gives .+; disable it"):
        network.pass_through("b", True, lab.catalogue)
    with pytest.raises(TypeMismatch):
        network.pass_through("r", True, lab.catalogue)


def test_a_wired_port_goes_on_before_one_that_is_not(lab: Any) -> None:
    network = lab.network({"c": "constant", "s": "add", "n": "negate"}, "c.value -> s.b", "s.value -> n.a")
    passed = network.pass_through("s", True, lab.catalogue)
    assert passed["s"].bypass == {"value": "b"}
    assert passed.around.wires["n", "a", 0] == ("c", "value")


def test_nothing_wired_gives_nothing_on(lab: Any, chain: Network) -> None:
    loose = chain.disconnect("n", "a").pass_through("n", True, lab.catalogue)
    run = lab.run(loose)
    assert run.error("m") == "m.a (Negate): needs a Value at 'a': wire one"


def test_a_disabled_node_is_disabled_whether_bypassed_or_not(lab: Any, chain: Network) -> None:
    assert lab.run(chain.pass_through("n", True, lab.catalogue).disable("n")).values == {}


def test_the_last_of_a_chain_makes_the_one_before_it_wanted(lab: Any, chain: Network) -> None:
    passed = chain.pass_through("z", True, lab.catalogue)
    assert passed.sinks() == ("m",)
    assert lab.run(passed).values["m"] == 3.0


def test_it_is_saved_and_read(lab: Any, chain: Network) -> None:
    passed = chain.pass_through("n", True, lab.catalogue)
    text = document.dumps(passed, lab.catalogue)
    assert '"bypass": {"value": "a"}' in text
    read = document.loads(text, lab.catalogue).network
    assert read["n"].bypass == {"value": "a"} and document.dumps(read, lab.catalogue) == text
    with pytest.raises(DocumentError, match="names a port for each output"):
        document.loads(text.replace('{"value": "a"}', '{"value": 1}'), lab.catalogue)
    assert "bypass" not in document.dumps(chain, lab.catalogue)


@given(spec=st.lists(st.tuples(*[st.integers(0, 9)] * 4), min_size=2, max_size=8), off=st.sets(st.integers(1, 7), max_size=4))
def test_any_set_of_them_is_taken_out(lab: Any, spec: Any, off: set[int]) -> None:
    network = lab.build([(1 if kind % 3 == 0 else 3, *rest) for kind, *rest in spec])
    for name in (f"n{i}" for i in off if f"n{i}" in network.nodes):
        if network[name].module.endswith("negate"):
            network = network.pass_through(name, True, lab.catalogue)
    gone = {n for n, node in network.nodes.items() if node.passes}
    around = network.around
    assert not any(source in gone or target in gone for (target, _, _), (source, _) in around.wires.items())
    values = lab.run(network).values
    plain = lab.naive(around.remove(*gone))
    assert all(plain[name] == value for name, value in values.items())
    assert gone.isdisjoint(values)
