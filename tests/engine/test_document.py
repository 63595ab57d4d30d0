"""Networks in files: nothing lost, nothing executed, and a sentence for everything that is wrong."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine import document, paths, scheduler, writing
from app.engine.errors import (
    CycleError,
    DocumentError,
    NetworkError,
    NewerSchema,
    PortTaken,
    TypeMismatch,
    UnknownName,
    ValueRefused,
)
from app.engine.network import Network

TEXT = """{
"format": "nonius-network",
"schema": 1,
"settings": {"k": 2.0, "title": ""},
"nodes": [
{"id": "c", "module": "user.fakes.constant", "version": 1, "parameters": {"number": 1.0, "sigma": 0.0}},
{"id": "n", "module": "user.fakes.negate", "version": 1, "parameters": {}},
{"id": "t", "module": "user.fakes.total", "version": 1, "parameters": {}}
],
"wires": [
"c.value -> n.a",
"n.value -> t.values[0]",
"c.value -> t.values[1]"
]
}
"""


def again(text: str, lab: Any) -> str:
    return document.dumps(document.loads(text, lab.catalogue).network, lab.catalogue)


def test_a_file_is_readable_and_reads_back_byte_for_byte(lab: Any) -> None:
    loaded = document.loads(TEXT, lab.catalogue)
    assert loaded.warnings == ()
    assert document.dumps(loaded.network, lab.catalogue) == TEXT


def test_all_parameter_values_are_written_defaults_too(lab: Any) -> None:
    record = json.loads(document.dumps(lab.network({"w": ("wide", {"level": 2})}), lab.catalogue))
    assert record["nodes"][0]["parameters"] == {"level": 2.0, "levels": None, "mode": "fast", "on": True, "title": ""}


def test_infinity_is_written_as_text_and_read_where_the_range_allows_it(lab: Any) -> None:
    text = document.dumps(lab.network({"w": ("wide", {"level": float("inf")})}), lab.catalogue)
    assert '"level": "inf"' in text and again(text, lab) == text
    assert again(text.replace('"inf"', "Infinity"), lab) == text


def test_unknown_keys_are_kept_at_every_level(lab: Any) -> None:
    record = json.loads(TEXT)
    record["later"] = {"a": [1, {"b": None}]}
    record["settings"]["theme"] = "dark"
    record["nodes"][0]["tags"] = ["x"]
    record["nodes"][0]["view"] = {"position": [1, 2.5], "ring": {"on": True}}
    record["files"] = {}
    once = again(json.dumps(record), lab)
    kept = json.loads(once)
    assert kept["later"] == record["later"] and kept["settings"]["theme"] == "dark"
    assert kept["nodes"][0]["tags"] == ["x"] and kept["nodes"][0]["view"] == record["nodes"][0]["view"]
    assert again(once, lab) == once


def test_a_module_that_is_not_here_stays_with_its_values_and_wires(lab: Any) -> None:
    ghost = '{"id": "g", "module": "mappers.ghost.ghost", "version": 7, "parameters": {"a": [1, 2], "b": {"c": null}}}'
    text = TEXT.replace('{"id": "n"', ghost + ',\n{"id": "n"')
    more = '"c.value -> g.plain",\n"c.value -> g.list[0]",\n"n.value -> g.list[1]",\n"c.value -> n.a"'
    text = text.replace('"c.value -> n.a"', more).replace('"c.value -> t.values[1]"', '"g.value -> t.values[1]"')
    loaded = document.loads(text, lab.catalogue)
    assert len(loaded.warnings) == 1
    assert "line 7: g: there is no module 'mappers.ghost.ghost'" in loaded.warnings[0]
    written = document.dumps(loaded.network, lab.catalogue)
    assert ghost in written and again(written, lab) == written
    for wire in ("c.value -> g.plain", "c.value -> g.list[0]", "n.value -> g.list[1]", "g.value -> t.values[1]"):
        assert f'"{wire}"' in written
    run = lab.run(loaded.network)
    assert "its module 'mappers.ghost.ghost' is not here" in run.error("g")


def test_a_ghost_names_the_nearest_module(lab: Any) -> None:
    loaded = document.loads(TEXT.replace("fakes.negate", "fakes.negat"), lab.catalogue)
    assert "did you mean 'user.fakes.negate'?; it is kept as it is" in loaded.warnings[0]


def test_a_renamed_module_is_found_by_its_former_name(lab: Any) -> None:
    assert again(TEXT.replace("user.fakes.negate", "user.fakes.minus"), lab) == TEXT


def test_another_version_is_told_and_what_does_not_fit_is_kept(lab: Any) -> None:
    later = TEXT.replace('"user.fakes.constant", "version": 1', '"user.fakes.constant", "version": 3')
    later = later.replace('"sigma": 0.0', '"shape": "round", "sigma": 0.0').replace("c.value -> n.a", "c.odd -> n.a")
    loaded = document.loads(later, lab.catalogue)
    assert any("a later 'Constant' (version 3; this is 1)" in w for w in loaded.warnings)
    assert any("no parameter 'shape'" in w for w in loaded.warnings)
    assert document.dumps(loaded.network, lab.catalogue) == later
    run = lab.run(loaded.network)
    assert "has no output 'odd'" in run.error("n")
    old = document.loads(TEXT.replace("user.fakes.negate", "user.fakes.slow"), lab.catalogue)
    assert any("an earlier 'Slow' (version 1; this is 2)" in w for w in old.warnings)
    assert '"user.fakes.slow", "version": 2' in document.dumps(old.network, lab.catalogue)


def test_gaps_in_a_list_are_closed_and_told(lab: Any) -> None:
    loaded = document.loads(TEXT.replace("values[1]", "values[5]"), lab.catalogue)
    assert "gaps" in loaded.warnings[0]
    assert document.dumps(loaded.network, lab.catalogue) == TEXT


def without(line: str) -> str:
    return TEXT.replace(line, "")


REFUSALS: list[tuple[str, Any, type[NetworkError], str]] = [
    ("empty", "", DocumentError, "the text, line 1, column 1: the file is empty"),
    ("no JSON", TEXT.replace('"schema": 1,', '"schema": 1'), DocumentError,
     "line 4, column 1: this is not JSON .*near '\"settings\""),
    ("a list", "[]", DocumentError, "it holds a list, not an object"),
    ("other JSON", "{}", DocumentError, 'it has no "format"'),
    ("other format", '{"format": "geojson"}', DocumentError, "\"format\" is 'geojson', not \"nonius-network\""),
    ("schema", TEXT.replace('"schema": 1', '"schema": "1"'), DocumentError, "\"schema\" is a whole number from 1, not '1'"),
    ("newer", TEXT.replace('"schema": 1', '"schema": 9'), NewerSchema,
     "written by a later version .*schema 9; this one reads up to 1"),
    ("key twice", TEXT.replace('{"number": 1.0', '{"number": 2, "number": 1.0'), DocumentError, "'number' occurs twice"),
    ("NaN", TEXT.replace("1.0", "NaN"), DocumentError, "line 6: NaN is not a value"),
    ("infinity", TEXT.replace('"k": 2.0', '"k": 2.0, "z": Infinity'), DocumentError, "infinite number has no place here"),
    ("infinite value", TEXT.replace("1.0", "Infinity"), ValueRefused,
     "line 6: c: number takes a number, which is not infinite"),
    ("id twice", TEXT.replace('"id": "n"', '"id": "c"'), DocumentError, "line 7: two nodes have the id 'c'"),
    ("no id", TEXT.replace('"id": "n", ', ""), DocumentError, 'node 2 is an object without an "id"'),
    ("bad id", TEXT.replace('"id": "n"', '"id": "n.n"'), DocumentError, "line 7: 'n.n' cannot be the id"),
    ("no module", TEXT.replace('"module": "user.fakes.negate", ', ""), DocumentError, "line 7: node 'n' has no \"module\""),
    ("version", TEXT.replace('"version": 1', '"version": 1.5'), DocumentError,
     'line 6: node \'c\': "version" is a whole number'),
    ("parameters", TEXT.replace('"parameters": {}', '"parameters": []'), DocumentError,
     '"parameters" is a list, not an object'),
    ("nodes", TEXT.replace('"nodes": [', '"nodes": 3, "x": ['), DocumentError, '"nodes" is a number, not a list'),
    ("parameter", TEXT.replace('"number"', '"numer"'), UnknownName,
     "line 6: c .Constant. has no parameter 'numer'; did you mean"),
    ("type", TEXT.replace("1.0", '"much"'), ValueRefused, "line 6: c: number takes a number, not 'much'"),
    ("no wire", TEXT.replace("c.value -> n.a", "c.value => n.a"), DocumentError, "line 11: 'c.value => n.a' is no wire"),
    ("wire to nothing", TEXT.replace("c.value -> n.a", "c.value -> m.a"), UnknownName,
     "line 11: wire 'c.value -> m.a': there is no node 'm'"),
    ("port", TEXT.replace("n.a", "n.b"), UnknownName, "line 11: n .Negate. has no port 'b'"),
    ("output", TEXT.replace("c.value -> n.a", "c.valve -> n.a"), UnknownName, "no output 'valve'; did you mean 'value'"),
    ("taken", TEXT.replace("t.values[1]", "t.values[0]"), DocumentError, r"line 13: two wires end at 't.values\[0\]'"),
    ("no list", TEXT.replace("n.a", "n.a[1]"), PortTaken, r"line 11: n.a takes one wire, not a list: leave out \[1\]"),
    ("cycle", TEXT.replace("c.value -> n.a", "t.value -> n.a"), CycleError, "the wires close a circle: .*data runs one way"),
    ("type mismatch", TEXT.replace("c.value -> n.a", "c.value:accuracy -> n.a"), TypeMismatch,
     "line 11: .*needs a Value, got Accuracy"),
    ("k", TEXT.replace('"k": 2.0', '"k": 0'), DocumentError, "line 4: the coverage factor k is a positive number"),
    ("bytes", b"\xff\xfe\x00", DocumentError, "is not UTF-8 text"),
    ("surrogate", TEXT.replace('"title": ""', '"title": "\\ud800"'), DocumentError, "is not UTF-8 text"),
    ("deep", "[" * 100_000, DocumentError, "nested too deeply"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "kind", "sentence"), [r[1:] for r in REFUSALS], ids=[r[0] for r in REFUSALS])
def test_what_is_wrong_in_a_file_is_said_with_its_place(lab: Any, text: Any, kind: type[NetworkError], sentence: str) -> None:
    with pytest.raises(kind, match=sentence) as caught:
        document.loads(text, lab.catalogue)
    assert str(caught.value).startswith("the text")


def test_a_file_that_is_not_there_names_the_nearest(lab: Any, tmp_path: Path) -> None:
    (tmp_path / "contours.json").write_text(TEXT)
    with pytest.raises(DocumentError, match=r"no file 'contour\.json' in .*; the nearest is 'contours.json'"):
        document.load(tmp_path / "contour.json", lab.catalogue)


def test_an_older_schema_is_migrated(lab: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def migrated(record: dict[str, Any]) -> dict[str, Any]:
        return {**record, "wires": record["edges"]}

    monkeypatch.setattr(document, "SCHEMA", 2)
    monkeypatch.setattr(document, "MIGRATIONS", {1: migrated})
    loaded = document.loads(TEXT.replace('"wires"', '"edges"'), lab.catalogue)
    assert len(loaded.network.wires) == 3


# --- on disk


def test_saving_keeps_the_version_before_and_writes_nothing_twice(lab: Any, tmp_path: Path) -> None:
    path = tmp_path / "net.json"
    network = document.loads(TEXT, lab.catalogue).network
    document.save(network, path, lab.catalogue)
    assert path.read_text() == TEXT
    stamp = path.stat().st_mtime_ns, path.stat().st_ino
    document.save(document.load(path, lab.catalogue), path, lab.catalogue)
    assert stamp == (path.stat().st_mtime_ns, path.stat().st_ino)
    document.save(network.set("c", "number", 5, lab.catalogue), path, lab.catalogue)
    assert (tmp_path / "net.json~1").read_text() == TEXT
    assert '"number": 5.0' in path.read_text()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["net.json", "net.json~1"]


def test_a_save_that_fails_leaves_what_was_there(lab: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "net.json"
    network = document.loads(TEXT, lab.catalogue).network
    document.save(network, path, lab.catalogue)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(DocumentError, match=r"was not written: No space left on device; what was there is still there"):
        document.save(network.set("c", "number", 5, lab.catalogue), path, lab.catalogue)
    assert path.read_text() == TEXT
    assert [p.name for p in tmp_path.iterdir()] == ["net.json"]
    monkeypatch.undo()
    with pytest.raises(DocumentError, match="was not written: No such file or directory"):
        document.save(network, tmp_path / "none" / "net.json", lab.catalogue)


def test_what_would_not_read_back_is_not_written(lab: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network = document.loads(TEXT, lab.catalogue).network
    good = writing.node_record
    monkeypatch.setattr(writing, "node_record", lambda n, c, f: {**good(n, c, f), "version": "x"})
    with pytest.raises(DocumentError, match="was not written, it would not read back"):
        document.save(network, tmp_path / "net.json", lab.catalogue)
    assert not list(tmp_path.iterdir())
    with pytest.raises(DocumentError, match="cannot be written to a file"):
        document.dumps(network.look("c", camera=object()), lab.catalogue)


def test_paths_are_saved_relative_and_move_with_the_file(lab: Any, tmp_path: Path) -> None:
    home, other = tmp_path / "home", tmp_path / "other"
    for folder in (home / "data", other):
        folder.mkdir(parents=True)
    (home / "data" / "x.txt").write_text("4")
    network = lab.network({"f": ("number_file", {"path": "data/x.txt"})}, folder=home)
    saved = document.save(network, home / "net.json", lab.catalogue)
    assert saved.warnings == ()
    record = json.loads((home / "net.json").read_text())
    assert record["nodes"][0]["parameters"]["path"] == "data/x.txt"
    assert record["files"]["data/x.txt"]["size"] == 1 and len(record["files"]["data/x.txt"]["sha256"]) == 64
    moved = document.save(saved.network, other / "net.json", lab.catalogue)
    assert "outside the network's folder" in moved.warnings[0]
    written = json.loads((other / "net.json").read_text())["nodes"][0]["parameters"]["path"]
    assert written == (home / "data" / "x.txt").as_posix()
    assert lab.run(document.load(other / "net.json", lab.catalogue)).values == {"f": 4.0}
    back = document.save(moved.network, home / "again.json", lab.catalogue)
    assert str(back.network.nodes["f"].parameters["path"]) == "data/x.txt"


def test_a_changed_or_missing_data_file_is_told_not_refused(lab: Any, tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text("4")
    network = lab.network({"f": ("number_file", {"path": "x.txt"})}, folder=tmp_path)
    document.save(network, tmp_path / "net.json", lab.catalogue)
    (tmp_path / "x.txt").write_text("5")
    loaded = document.load(tmp_path / "net.json", lab.catalogue)
    identities = paths.identities(loaded, lab.catalogue)
    assert identities is not None
    assert "f.path: 'x.txt' has changed since" in writing.changed_files(loaded, lab.catalogue, identities)[0]
    (tmp_path / "x.txt").rename(tmp_path / "xx.txt")
    loaded = document.load(tmp_path / "net.json", lab.catalogue)
    run = lab.run(loaded)
    assert run.error("f").startswith("f.path (Number in a file): there is no file 'x.txt'")
    assert "the nearest is 'xx.txt'" in run.error("f")
    again = document.save(loaded, tmp_path / "net.json", lab.catalogue)
    assert again.network.files["x.txt"]["size"] == 1, "what is known of a file that is away is kept"


def test_a_part_travels_as_text_with_absolute_paths(lab: Any, tmp_path: Path) -> None:
    network = lab.network({"f": ("number_file", {"path": "x.txt"}), "c": "constant"}, folder=tmp_path)
    text = document.clipboard(network.part(["f"]), lab.catalogue)
    part = document.loads(text, lab.catalogue).network
    assert Path(part.nodes["f"].parameters["path"]) == tmp_path / "x.txt"


# --- any network

plain = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)
unknown_keys = st.dictionaries(st.text(min_size=1).map(lambda t: f"x{t}"), plain, max_size=3)


@given(st.data())
def test_save_load_save_is_byte_equal(lab: Any, specs: Any, data: Any) -> None:
    from dataclasses import replace

    network = lab.build(data.draw(specs))
    name = data.draw(st.sampled_from(sorted(network.nodes)))
    drawn = {"extras": data.draw(unknown_keys), "view": data.draw(unknown_keys), "disabled": data.draw(st.booleans())}
    changed = replace(network.nodes[name], **drawn)
    network = replace(network, nodes={**network.nodes, name: changed}, extras=data.draw(unknown_keys))
    network = network.settle(k=data.draw(st.floats(0.1, 10)), **data.draw(unknown_keys))
    text = document.dumps(network, lab.catalogue)
    loaded = document.loads(text.encode(), lab.catalogue)
    assert document.dumps(loaded.network, lab.catalogue) == text
    assert loaded.network.wires == network.wires
    assert scheduler.keys(loaded.network, lab.catalogue) == scheduler.keys(network, lab.catalogue)


@given(st.data())
def test_any_damage_to_a_file_ends_in_a_network_or_a_sentence(lab: Any, data: Any) -> None:
    start = data.draw(st.integers(0, len(TEXT)))
    end = data.draw(st.integers(start, min(len(TEXT), start + 40)))
    text = TEXT[:start] + data.draw(st.text(max_size=5)) + TEXT[end:]
    try:
        network = document.loads(text, lab.catalogue).network
    except NetworkError as error:
        assert str(error)
    else:
        assert again(text, lab) == document.dumps(network, lab.catalogue)


@given(plain)
def test_any_json_ends_in_a_network_or_a_sentence(lab: Any, value: Any) -> None:
    record = {"format": "nonius-network", "schema": 1, "nodes": value, "wires": value, "settings": value}
    for kept in ("nodes", "wires", "settings"):
        one = {"format": "nonius-network", "schema": 1, kept: record[kept]}
        try:
            assert isinstance(document.loads(json.dumps(one), lab.catalogue).network, Network)
        except NetworkError as error:
            assert str(error)
