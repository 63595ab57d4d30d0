"""Every module of the catalogue keeps the house's promises: words, types, sources, an example, the law, files."""

import inspect
import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from app.engine import document
from app.engine.catalogue import Catalogue
from app.engine.events import Failed, Settled
from app.engine.executor import execute
from app.engine.network import Network
from app.engine.results import Entry
from modules.data.accuracy import accuracies
from modules.declare import ROOMS, Module
from tests import golden

ROOT = Path(__file__).resolve().parent.parent
NETWORKS = sorted((ROOT / "networks").glob("*.json"))

NAMES_A_SOURCE = ("modellers", "mappers", "accuracy_mappers")

ELSEWHERE: dict[str, str] = {
    "mappers.colour_by.colour_by": "tests/modules/test_colour_by.py",
    "modellers.calculator.calculator": "tests/modules/test_calculator.py",
    "modellers.difference.difference": "tests/modules/test_field_difference.py",
    "modellers.ensemble.ensemble": "tests/modules/test_ensemble.py",
    "modellers.histogram.histogram": "tests/modules/test_statistics.py",
    "modellers.statistics.statistics": "tests/modules/test_statistics.py",
    "modellers.probe.probe": "tests/modules/test_probe.py",
    "modellers.state_accuracy.state_accuracy": "tests/modules/test_state_accuracy.py",
    "modellers.triangulate.triangulate": "tests/modules/test_points.py",
    "readers.dataset.dataset": "tests/modules/test_readers.py",
    "readers.raw.raw": "tests/modules/test_readers_volumes.py",
    "readers.shapes.shapes": "tests/modules/test_readers.py",
    "readers.table.table": "tests/modules/test_points.py",
}
"""Module -> where it is run, if it stands in no packaged network."""


@cache
def catalogue() -> Catalogue:
    """Ours alone, without the modules of who runs the tests."""
    found = Catalogue()
    found._rooms = True
    found.reload()
    return found


MODULES = list(catalogue())
each_module = pytest.mark.parametrize("record", MODULES, ids=lambda record: record.id)


class Ran(NamedTuple):
    """A network, and what its nodes gave."""

    network: Network
    entries: dict[str, Entry]


@cache
def examples() -> dict[str, Ran]:
    """Every packaged network, run."""
    found = {}
    for path in NETWORKS:
        network = document.load(path, catalogue())
        entries: dict[str, Entry] = {}
        for event in execute(network, catalogue=catalogue()):
            assert not isinstance(event, Failed), f"{path.name}: {event.error}"
            if isinstance(event, Settled):
                entries[event.node] = event.entry
        found[path.stem] = Ran(network, entries)
    return found


def firings(record: Module) -> list[tuple[str, str, Entry]]:
    """(network, node, result) of each example of a module."""
    return [
        (name, node.id, ran.entries[node.id])
        for name, ran in examples().items()
        for node in ran.network.nodes.values()
        if node.module == record.id and node.id in ran.entries
    ]


def test_everything_loads() -> None:
    assert not catalogue().broken
    assert {record.room for record in MODULES} <= set(ROOMS)
    assert len(MODULES) >= 10


@each_module
def test_it_is_documented(record: Module) -> None:
    assert record.summary.endswith((".", ":")), record.summary
    assert record.title[0].isupper()
    assert record.accuracy.strip(), "no 'Accuracy:' line"
    if record.room in NAMES_A_SOURCE:
        assert record.source.strip(), "no 'Source:' line"
    silent = [p.name for p in record.parameters if not p.words]
    assert not silent, f"no words about {', '.join(silent)}"


@each_module
def test_it_is_typed(record: Module) -> None:
    signature = inspect.signature(record.function)
    assert signature.return_annotation is not inspect.Signature.empty
    for argument in signature.parameters.values():
        assert argument.annotation is not inspect.Parameter.empty
    for parameter in record.parameters:
        assert parameter.coerce(parameter.default) == parameter.default
        assert parameter.coerce(json.loads(json.dumps(parameter.plain(parameter.default)))) == parameter.default


@each_module
def test_its_ranges_and_choices_name_ports_and_facts(record: Module) -> None:
    for parameter in record.parameters:
        for hint in (parameter.range, parameter.choice):
            if hint and hint.of:
                port, _, fact = hint.of.partition(".")
                found = record.port(port)
                if found is None:
                    own = record.parameter(port)
                    assert own is not None, f"{hint.of}: there is no port {port!r}"
                    assert own.is_path
                else:
                    assert fact in found.type.FACTS, f"{hint.of}: a {found.type.__name__} knows no {fact!r}"


@each_module
def test_its_node_comes_back_from_a_file(record: Module) -> None:
    network = Network().add(record.id, catalogue(), view={"position": [1.0, 2.0]})
    (node,) = network.nodes.values()
    for parameter in record.parameters:
        network = network.set(node.id, parameter.name, parameter.default, catalogue())
    text = document.dumps(network, catalogue())
    back = document.loads(text, catalogue()).network
    assert back.nodes == network.nodes
    assert document.dumps(back, catalogue()) == text
    assert set(back.nodes[node.id].parameters) == {p.name for p in record.parameters}


@each_module
def test_it_runs_in_an_example(record: Module) -> None:
    if not firings(record) and record.id in ELSEWHERE:
        assert f"{record.function.__name__}(" in (ROOT / ELSEWHERE[record.id]).read_text("utf-8")
        return
    assert firings(record), "it stands in no network of networks/"


@each_module
def test_it_obeys_the_law(record: Module) -> None:
    """The engine checks that nothing is lost; here, that what it claims can be evaluated, and is bound to its carrier."""
    for name, node, entry in firings(record):
        for output in record.outputs:
            value = entry.outputs[output.name]
            assert isinstance(value, output.type)
            for accuracy in accuracies(value):
                for line in accuracy.budget(200):
                    assert line.max >= 0 or line.count == 0, (name, node, line)
                    assert line.rule or line.rigour == "exact", f"{name}: {node}: {line.name!r} names no rule"


@each_module
def test_it_gives_the_same_again(record: Module) -> None:
    """A module has no state: a second firing in a new engine has the same key and facts."""
    for name, node, entry in firings(record)[:1]:
        network = examples()[name].network
        again: Any = None
        for event in execute(replace(network), wanted=[node], catalogue=catalogue()):
            if isinstance(event, Settled) and event.node == node:
                again = event.entry
        assert again is not None
        assert {k: repr(v) for k, v in again.facts.items()} == {k: repr(v) for k, v in entry.facts.items()}


@each_module
def test_its_version_stands_for_its_output(record: Module) -> None:
    """What it gave in one example is written down; another output needs another version."""
    written = golden.load().get(record.id)
    if not firings(record):
        assert written is None
        return
    assert written is not None, "it is not in tests/golden.json: run python tests/golden.py"
    ran = examples()[written["network"]]
    said = golden.complaint(written, golden.taken(ran.network, written["node"], ran.entries, catalogue()))
    assert not said, f"{record.id}: {said}"


def test_titles_and_ids_are_distinct_within_a_room() -> None:
    names = [(record.room, record.title) for record in MODULES]
    assert len(set(names)) == len(names)
