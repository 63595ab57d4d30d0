"""A parameter follows another: one value, one edit; saved, copied, replaced, never in a circle, and unknown to the engine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from app.engine import document, following, scheduler
from app.engine.errors import CycleError, PortTaken, UnknownName, ValueRefused
from app.engine.network import Network


@pytest.fixture
def three(lab: Any) -> Network:
    """c follows b, which follows a."""
    network: Network = lab.network({name: ("constant", {"number": number}) for name, number in (("a", 1), ("b", 2), ("c", 3))})
    network = following.follow(network, "c", "number", ("b", "number"), lab.catalogue)
    return following.follow(network, "b", "number", ("a", "number"), lab.catalogue)


def numbers(network: Network) -> dict[str, float]:
    return {name: node.parameters.get("number", 1.0) for name, node in network.nodes.items()}


def test_all_that_follow_have_the_value_of_the_first(lab: Any, three: Network) -> None:
    assert numbers(three) == {"a": 1.0, "b": 1.0, "c": 1.0}
    assert numbers(three.set("a", "number", 7, lab.catalogue)) == {"a": 7.0, "b": 7.0, "c": 7.0}
    default = lab.catalogue[three["a"].module].parameter("number").default
    assert three.set("a", "number", 7, lab.catalogue).reset("a", "number", lab.catalogue)["c"].parameters["number"] == default


def test_keys_are_those_of_the_values(lab: Any, three: Network) -> None:
    plain = lab.network({name: ("constant", {"number": 7}) for name in "abc"})
    assert scheduler.keys(three.set("a", "number", 7, lab.catalogue), lab.catalogue) == scheduler.keys(plain, lab.catalogue)


def test_what_follows_is_not_set_by_itself(lab: Any, three: Network) -> None:
    with pytest.raises(ValueRefused, match=r"c.number follows b.number: set that, or let it go"):
        three.set("c", "number", 4, lab.catalogue)
    free = following.let_go(three, "c", "number")
    assert numbers(free.set("c", "number", 4, lab.catalogue)) == {"a": 1.0, "b": 1.0, "c": 4.0}


def test_circles_wires_and_names_that_are_not_there_are_refused(lab: Any, three: Network) -> None:
    for led in (("c", "number"), ("a", "number")):
        with pytest.raises(CycleError, match="would follow itself"):
            following.follow(three, "a", "number", led, lab.catalogue)
    with pytest.raises(UnknownName):
        following.follow(three, "a", "number", ("a", "nothing"), lab.catalogue)
    with pytest.raises(UnknownName):
        following.follow(three, "a", "number", ("d", "number"), lab.catalogue)
    wired = lab.wire(three.add("zero", lab.catalogue, id="z").add("constant", lab.catalogue, id="d"), "z.value -> d.number")
    for one, other in (("d", "a"), ("c", "d")):
        with pytest.raises(PortTaken, match="from a wire"):
            following.follow(wired, one, "number", (other, "number"), lab.catalogue)
    for end in "ac":
        with pytest.raises(PortTaken, match="linked to another parameter"):
            lab.wire(wired, f"z.value -> {end}.number")


def test_links_are_saved_and_follow_names(lab: Any, three: Network) -> None:
    renamed = three.rename("b", "middle")
    text = document.dumps(renamed, lab.catalogue)
    assert '"follows": {"number": "middle.number"}' in text
    back = document.loads(text, lab.catalogue)
    assert not back.warnings
    assert numbers(back.network.set("a", "number", 5, lab.catalogue)) == {"a": 5.0, "middle": 5.0, "c": 5.0}
    assert document.dumps(back.network, lab.catalogue) == text


def test_without_its_leader_a_value_stays(lab: Any, three: Network) -> None:
    left = three.set("a", "number", 7, lab.catalogue).remove("b")
    assert not left["c"].follows and numbers(left) == {"a": 7.0, "c": 7.0}


@pytest.mark.parametrize(("incoming", "led"), [(True, "a.number"), (False, None)])
def test_copies_follow_the_copy_of_their_leader(lab: Any, three: Network, incoming: bool, led: str | None) -> None:
    copied = three.paste(three.part(["b", "c"]), lab.catalogue, incoming=incoming)
    assert copied["constant-2"].follows == {"number": "constant-1.number"}
    assert copied["constant-1"].follows.get("number") == led
    assert copied["c"].follows == {"number": "b.number"}


def test_a_file_that_says_otherwise_is_put_right_and_told(lab: Any, three: Network) -> None:
    text = document.dumps(three, lab.catalogue)
    other = text.replace('"number": 1.0', '"number": 9.0', 1)
    back = document.loads(other, lab.catalogue)
    assert numbers(back.network) == {"a": 9.0, "b": 9.0, "c": 9.0}
    assert any("b.number had another value than a.number" in sentence for sentence in back.warnings)
    ring = replace(three, nodes={**three.nodes, "a": replace(three["a"], follows={"number": "c.number"})})
    back = document.loads(document.dumps(ring, lab.catalogue), lab.catalogue)
    assert any("would follow itself" in sentence for sentence in back.warnings)
    assert following.chain(back.network.nodes, ("c", "number"))[-1] != ("c", "number")
    gone = document.loads(text.replace('"number": "a.number"', '"number": "nobody.number"'), lab.catalogue)
    assert any("no longer follows nobody.number" in sentence for sentence in gone.warnings)


def test_a_placeholder_keeps_its_links(lab: Any, three: Network) -> None:
    there = replace(three, nodes={**three.nodes, "b": replace(three["b"], module="mappers.not_here")})
    text = document.dumps(there, lab.catalogue)
    assert document.dumps(document.loads(text, lab.catalogue).network, lab.catalogue) == text
