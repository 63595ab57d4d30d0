"""Another module in the place of a node: fitting wires and values stay, the rest is told."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from app.engine import check
from app.engine.errors import UnknownName
from app.engine.network import Network
from app.engine.replacing import replaced, suggestions


@pytest.fixture
def network(lab: Any) -> Network:
    nodes = {"c": ("constant", {"number": 3}), "n": "negate", "m": "negate", "t": "total"}
    made: Network = lab.network(nodes, "c.value -> n.a", "n.value -> m.a", "n.value -> t.values", "c.value -> t.values")
    return made


def unknown(network: Network, node: str, module: str = "gone.turned.negated") -> Network:
    """The network with a node of a module that is not here."""
    return replace(network, nodes={**network.nodes, node: replace(network[node], module=module)})


def test_a_placeholder_gets_a_module_and_keeps_its_wires(lab: Any, network: Network) -> None:
    done = replaced(unknown(network, "n"), "n", "negate", lab.catalogue)
    assert done.network.wires == network.wires and not done.lost and done.kept == 3
    assert lab.run(done.network).values["m"] == 3.0


def test_values_of_the_same_name_stay_and_others_are_told(lab: Any, network: Network) -> None:
    lost = unknown(network, "c")
    values = {"number": 7.0, "sigma": 0.5, "colour": "red"}
    lost = replace(lost, nodes={**lost.nodes, "c": replace(lost["c"], parameters=values)})
    done = replaced(lost, "c", "constant", lab.catalogue)
    assert done.network["c"].parameters == {"number": 7.0, "sigma": 0.5}
    assert done.lost == ("colour",)


def test_a_wire_goes_to_another_socket_that_it_fits(lab: Any, network: Network) -> None:
    done = replaced(network, "m", "total", lab.catalogue)
    assert done.network.wires["m", "values", 0] == ("n", "value") and not done.lost


def test_several_wires_find_a_list_or_free_ports(lab: Any, network: Network) -> None:
    done = replaced(network, "t", "add", lab.catalogue)
    assert {port for (node, port, _) in done.network.wires if node == "t"} == {"a", "b"} and not done.lost
    back = replaced(done.network, "t", "total", lab.catalogue)
    assert len(back.network.incoming["t"]["values"]) == 2
    one = replaced(network, "t", "negate", lab.catalogue)
    assert len(one.lost) == 1 and one.lost[0].startswith("the wire from")


def test_what_cannot_be_wired_is_told(lab: Any, network: Network) -> None:
    done = replaced(network, "n", "ramp", lab.catalogue)
    assert set(done.lost) >= {"the wire from c.value", "the wire to m.a", "the wire to t.values"}
    check.network(done.network.nodes, done.network.wires, lab.catalogue)


def test_any_replacement_is_legal(lab: Any, network: Network) -> None:
    for node in network.nodes:
        for module, done in suggestions(unknown(network, node), node, lab.catalogue):
            check.network(done.network.nodes, done.network.wires, lab.catalogue)
            assert done.network[node].module == module.id


def test_the_likeliest_is_suggested_first(lab: Any, network: Network) -> None:
    first, done = suggestions(unknown(network, "n"), "n", lab.catalogue)[0]
    assert first.id.endswith("negate") and not done.lost


def test_a_module_that_is_not_there_is_refused(lab: Any, network: Network) -> None:
    with pytest.raises(UnknownName):
        replaced(network, "n", "no.such", lab.catalogue)
