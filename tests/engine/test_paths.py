"""Data files enter keys by what they hold."""

from __future__ import annotations

import importlib.util
import os
import time
from pathlib import Path
from typing import Any

import pytest

from app.engine import paths, scheduler
from app.engine.paths import Digests, Identity, identify, locate
from modules.progress import Cancelled, Progress, Stop


def old(path: Path, text: str) -> Path:
    path.write_text(text)
    os.utime(path, (time.time() - 100, time.time() - 100))
    return path


def one(path: Path | str, folder: Path, record: Any = None) -> Identity:
    found = identify(Path(path), folder, record)
    assert found is not None
    return found


def test_content_and_suffix_identify_a_file_not_its_name_place_or_time(tmp_path: Path) -> None:
    old(tmp_path / "a.txt", "4")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.TXT").write_text("4")
    (tmp_path / "a.dat").write_text("4")
    (tmp_path / "c.txt").write_text("5")
    a, b, suffix, other = (one(n, tmp_path).content for n in ("a.txt", "sub/b.TXT", "a.dat", "c.txt"))
    assert a == b and a != suffix and a != other


def test_companions_are_part_of_it(lab: Any, tmp_path: Path) -> None:
    record = lab.catalogue["user.fakes.number_file"]
    (tmp_path / "a.txt").write_text("4")
    bare = one("a.txt", tmp_path, record)
    (tmp_path / "a.hdr").write_text("x")
    with_header = one("a.txt", tmp_path, record)
    assert bare.content != with_header.content and len(with_header.stamps) == 2
    for suffix in ("txt", "hdr"):
        (tmp_path / f"b.{suffix}").write_text((tmp_path / f"a.{suffix}").read_text())
    assert one("b.txt", tmp_path, record).content == with_header.content, "a renamed pair is the same data"


def test_a_folder_and_a_pattern_are_their_names_and_contents(tmp_path: Path) -> None:
    for name in ("b", "a", "sub/c"):
        (tmp_path / "d" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "d" / f"{name}.png").write_text(name)
    folder = one("d", tmp_path)
    assert [name for name, _ in folder.content[1]] == ["a.png", "b.png", "sub/c.png"]
    pattern = one("d/*.png", tmp_path)
    assert [name for name, _ in pattern.content[1]] == ["a.png", "b.png"]
    (tmp_path / "d" / "a.png").rename(tmp_path / "d" / "z.png")
    assert one("d", tmp_path).content != folder.content
    assert one("d/*.png", tmp_path).content != pattern.content
    assert "there is no file" in one("d/*.jpg", tmp_path).problem


def test_digests_are_remembered_but_not_of_a_young_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    digests = Digests()
    reads: list[str] = []
    whole = paths._whole

    def noted(path: Path, *rest: Any) -> str:
        reads.append(path.name)
        return whole(path, *rest)

    monkeypatch.setattr(paths, "_whole", noted)
    aged, young = old(tmp_path / "old", "1"), tmp_path / "young"
    young.write_text("1")
    for path in (aged, aged, young, young):
        digests.of(path)
    assert reads == ["old", "young", "young"]
    old(aged, "2")
    assert digests.of(aged)[0] != digests.of(young)[0]


def test_large_files_are_identified_by_a_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paths, "LARGE", 10 * paths.MIB)
    path = tmp_path / "large.raw"
    with path.open("wb") as file:
        file.truncate(300 * paths.MIB)
    first = one(path, tmp_path)
    assert first.sampled and first.content[1].startswith("sample-")
    with path.open("r+b") as file:
        file.seek(-1, os.SEEK_END)
        file.write(b"x")
    assert one(path, tmp_path).content != first.content
    with path.open("r+b") as file:
        file.truncate(300 * paths.MIB + 1)
    assert one(path, tmp_path).content != first.content


def test_digesting_is_cancelled_and_tells_how_far_it_is(tmp_path: Path) -> None:
    path = tmp_path / "f.raw"
    path.write_bytes(bytes(40 * paths.MIB))
    stop, told = Stop(), list[float]()

    def report(fraction: float) -> None:
        told.append(fraction)
        if len(told) == 3:
            stop.set()

    with pytest.raises(Cancelled):
        identify(path, tmp_path, progress=Progress(report, stop))
    assert len(told) == 3 and told == sorted(told)


def test_paths_lead_into_installed_packages_that_are_not_imported(tmp_path: Path) -> None:
    spec = importlib.util.find_spec("networkx")
    assert spec is not None and spec.submodule_search_locations
    inside = Path(spec.submodule_search_locations[0]) / "readwrite" / "gml.py"
    assert locate("package:networkx/readwrite/gml.py", tmp_path) == inside
    assert "not installed: install it" in one("package:no_such_package/x.npz", tmp_path).problem
    assert "leads out of the package" in one("package:networkx/../numpy/x", tmp_path).problem
    assert "did you" not in one("package:networkx/readwrite/gmll.py", tmp_path).problem
    assert "the nearest is 'gml.py'" in one("package:networkx/readwrite/gmll.py", tmp_path).problem


def test_what_is_missing_is_said_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "terrain.png").write_text("")
    assert "the nearest is 'terrain.png'" in one("data/terain.png", tmp_path).problem
    assert "there is no folder 'dat'" in one("dat/terrain.png", tmp_path).problem
    assert "the nearest is 'data'" in one("dat/terrain.png", tmp_path).problem
    assert one("", tmp_path).problem == "no file is chosen: set it"


def test_paths_without_a_file_take_part_in_no_key_but_as_missing(lab: Any, tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text("4")
    there = lab.network({"f": ("number_file", {"path": "x.txt"})}, folder=tmp_path)
    gone = lab.network({"f": ("number_file", {"path": "y.txt"})}, folder=tmp_path)
    keys = [scheduler.keys(n, lab.catalogue, paths.identities(n, lab.catalogue))["f"] for n in (there, gone)]
    assert keys[0] != keys[1]
    nothing = lab.network({"f": "number_files"})
    assert paths.identities(nothing, lab.catalogue) == {}, "no path is a value of its own: automatic"
    assert lab.run(nothing).values == {"f": 0.0}


def test_a_file_that_changes_while_it_is_read_gives_no_result(lab: Any, tmp_path: Path) -> None:
    old(tmp_path / "x.txt", "4")
    network = lab.network({"f": ("number_file", {"path": "x.txt"})}, folder=tmp_path)
    lab.gate.clear()
    with lab.engine(workers=1) as engine:
        engine.want(network)
        seen = []
        for event in engine.events(once=True):
            seen.append(type(event).__name__)
            if seen[-1] == "Started":
                (tmp_path / "x.txt").write_text("5")
                lab.gate.set()
            if seen[-1] == "Failed":
                assert "changed while it was read: run again" in str(event.error)
        assert "Failed" in seen and not engine.results.failures
        engine.want(network)
        values = [e.outputs["value"].value for e in engine.events(once=True) if hasattr(e, "entry")]
    assert values == [5.0]


def test_the_engine_digests_beside_its_mailbox_and_can_be_cancelled(
    lab: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "x.txt").write_text("4")
    network = lab.network({"f": ("number_file", {"path": "x.txt"})}, folder=tmp_path)
    whole = paths._whole

    def slowly(path: Path, size: int, progress: Progress) -> str:
        for i in range(200):
            time.sleep(0.005)
            progress(i / 200)
        return whole(path, size, progress)

    with lab.engine() as engine:
        with monkeypatch.context() as patch:
            patch.setattr(paths, "_whole", slowly)
            engine.want(network)
            seen = []
            for event in engine.events(once=True):
                seen.append(event.record())
                if len(seen) == 3:
                    start = time.perf_counter()
                    engine.cancel()
        assert time.perf_counter() - start < 0.1
        assert [e["event"] for e in seen if e["event"] != "progressed"] == ["done"]
        assert seen[0]["event"] == "progressed" and {e["wave"] for e in seen} == {1} and seen[-1]["outcome"] == "cancelled"
        engine.want(network)
        assert [e.wave for e in engine.events(once=True) if hasattr(e, "entry")] == [2]


def test_an_edited_file_fires_again_and_a_touched_one_does_not(lab: Any, tmp_path: Path) -> None:
    path = old(tmp_path / "x.txt", "4")
    network = lab.network({"f": ("number_file", {"path": "x.txt"}), "n": "negate"}, "f.value -> n.a", folder=tmp_path)
    with lab.engine() as engine:
        for text, fires in (("4", ["number_file", "negate"]), ("4", []), ("5", ["number_file", "negate"]), ("4", [])):
            path.write_text(text)
            engine.want(network)
            values = [e.outputs["value"].value for e in engine.events(once=True) if hasattr(e, "entry") and e.node == "n"]
            assert values == [-float(text)]
            assert lab.fired == fires
