"""The command line: what it says, what it writes, how it ends."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from app import opengl
from app.commands.console import Console, columns
from app.commands.outbox import Outbox
from app.engine.errors import NetworkError

ROOT = Path(__file__).resolve().parent.parent
Nonius = Callable[..., Any]

SCRIPT = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from app.cli import script; script()"
"""What the console script runs. Children of a shell in the background would inherit that Ctrl+C is ignored."""

SLOW = '''
"""Slow and failing modules for tests."""

import time

from modules.api import Annotated, EXACT, Progress, Range, Samples, Table, exactly, modeller
import numpy as np


@modeller("Slow")
def slow(samples: Samples, progress: Progress, *, seconds: Annotated[float, Range(0, 60)] = 30.0) -> Samples:
    """The samples, late.

    Accuracy: passed on.
    """
    for i in range(int(seconds * 100)):
        progress(i / (seconds * 100))
        time.sleep(0.01)
    return samples


@modeller("Fails")
def fails(samples: Samples) -> Samples:
    """Nothing.

    Accuracy: none.
    """
    raise ValueError("the samples are not to its taste: give it others")


@modeller("List", output="table")
def list_them(samples: Samples) -> Table:
    """The samples as a table.

    Accuracy: not stated.
    """
    accuracy = samples.accuracy.end(None, "a list for tests")
    columns = {"number": np.arange(3), "value": np.array([0.1, 1e-30, 2.5])}
    return Table(columns=columns, units={"value": "m"}, accuracy=accuracy)
'''


def shell(*words: str, cwd: Path | None = None, env: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
    """`nonius` in a process of its own, its output in pipes."""
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, *words], cwd=cwd, text=True, encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(ROOT), **(env or {})}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


@pytest.fixture
def slow(small: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A network whose samples go through modules of a user folder: late, and failing."""
    folder = small.parent / "mine"
    folder.mkdir()
    (folder / "trying.py").write_text(SLOW)
    monkeypatch.setenv("NONIUS_MODULES", str(folder))
    record = json.loads(small.read_text())
    record["nodes"] += [
        {"id": "late", "module": "user.trying.slow", "parameters": {}},
        {"id": "bad", "module": "user.trying.fails", "parameters": {}},
        {"id": "after", "module": "user.trying.slow", "parameters": {}},
        {"id": "list", "module": "user.trying.list_them", "parameters": {}},
    ]
    record["wires"] += ["field.samples -> late.samples", "field.samples -> bad.samples", "bad.bad -> after.samples"]
    record["wires"] += ["field.samples -> list.samples"]
    record["wires"] = [w.replace("bad.bad", "bad.samples") for w in record["wires"]]
    small.write_text(json.dumps(record))
    return small


# --- starting


@pytest.mark.parametrize(
    "words", [["--help"], ["modules"], ["describe", "contour"], ["check", "NETWORK"], ["check", "PICTURE"]]
)
def test_it_starts_without_window_drawing_or_compiler(made: Path, words: list[str]) -> None:
    given = {"NETWORK": [str(made / "peak.json")], "PICTURE": [str(made / "peak.accuracy.json"), "--no-run"]}
    words = [w for word in words for w in given.get(word, [word])]
    code = f"""
import sys
from app.cli import main
assert main({words!r}) == 0
heavy = sorted({{name.split('.')[0] for name in sys.modules}} & {{'PySide6', 'vtkmodules', 'pyvista', 'numba', 'matplotlib'}})
assert not heavy, heavy
"""
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["check", "--help"], ["--version"], ["gui", "--help"]])
def test_help(nonius: Nonius, words: list[str]) -> None:
    said = nonius(*words)
    assert said.code == 0
    assert "nonius" in said.out
    assert said.err == ""


# --- what is misspelt


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["runn", "small.json"], "did you mean 'run'?"),
        (["--quiet"], ""),
        (["run"], "NETWORK"),
        (["run", "small.json", "--tread", "2"], "did you mean '--threads'?"),
        (["run", "small.json", "another.json"], "one word too many"),
        (["run", "small.json", "--threads", "0"], "whole number from 1"),
        (["run", "smal.json"], "did you mean 'small.json'?"),
        (["run", "jacksbro"], "did you mean 'jacksboro'?"),
        (["run", "."], "is a folder"),
        (["run", "small.png"], "there is no picture"),
        (["run", "small.json", "--set", "contur.levels=1"], "did you mean 'contour'?"),
        (["run", "small.json", "--set", "contour.level=1"], "did you mean 'levels'?"),
        (["run", "small.json", "--set", "contour.method=sholder"], "did you mean 'shoulder'?"),
        (["run", "small.json", "--set", "contour.levels=high"], "levels takes a list, each a number"),
        (["run", "small.json", "--set", "field.noise=0,5"], "noise takes a number"),
        (["run", "small.json", "--set", "contour.levels"], "NODE.PARAM=VALUE"),
        (["run", "small.json", "--set", "k=much"], "k takes a number"),
        (["run", "small.json", "--set", "k=-1"], "positive number"),
        (["run", "small.json", "--out", "contur=x.vtp"], "did you mean 'contour'?"),
        (["run", "small.json", "--out", "contour.line=x.vtp"], "did you mean 'lines'?"),
        (["run", "small.json", "--out", "contour=x.png"], "goes to .vtp"),
        (["run", "small.json", "--out", "contour"], "NODE=FILE"),
        (["run", "small.json", "--out", "contour.lines:accuracy=x.json"], "no file holds Accuracy"),
        (["run", "small.json", "--report", "nowhere/r.json"], "there is no folder 'nowhere'"),
        (["run", "small.json", "--out", "contour=nowhere/x.vtp"], "there is no folder 'nowhere'"),
        (["run", "small.json", "--require", "contur.lines.position.max < 1"], "did you mean 'contour'?"),
        (["run", "small.json", "--require", "contour.lins.position.max < 1"], "did you mean 'lines'?"),
        (["run", "small.json", "--require", "contour.lines.position.maks < 1"], "did you mean 'max'?"),
        (["run", "small.json", "--require", "contour.lines.positon.max < 1"], "'position'"),
        (["describe", "contuor"], "did you mean 'contour'?"),
        (["check", "smal.json"], "did you mean 'small.json'?"),
        (["check", "small.png"], "has no certificate beside it"),
        (["bench", "no such thing"], "there is no benchmark"),
    ],
)
def test_what_is_misspelt_is_told_in_a_sentence(nonius: Nonius, small: Path, words: list[str], says: str) -> None:
    said = nonius(*words)
    assert said.code == 2, said
    assert says in said.err
    assert "Traceback" not in said.err
    assert said.err.count("\n") <= 1
    assert sorted(p.name for p in small.parent.iterdir()) == ["small.json"]


def test_a_file_that_is_no_network(nonius: Nonius, small: Path) -> None:
    small.write_text('{"a": 1}')
    assert nonius("run", small).code == 2
    small.write_text("\x89PNG\r\n")
    assert nonius("run", small).code == 2
    (small.parent / "small.png").write_bytes(b"not a picture")
    said = nonius("run", "small.png")
    assert (said.code, "no PNG" in said.err) == (2, True)


# --- running


def test_a_run_tells_each_node_with_time_and_budget(nonius: Nonius, small: Path) -> None:
    said = nonius("run", small, "--report", "r.json")
    assert said.code == 0, said
    lines = {line.split()[0]: line for line in said.out.splitlines() if line and not line.startswith(" ")}
    assert {"field", "model", "contour"} <= set(lines)
    assert "s  Contour" in lines["contour"]
    assert "± " not in said.out
    assert "lines: position " in said.out
    assert "±0.02 Added noise" in said.out
    assert "\r" not in said.out + said.err
    assert "\x1b" not in said.out + said.err
    report = json.loads((small.parent / "r.json").read_text("utf-8"))
    assert [n["status"] for n in report["nodes"]] == ["ran"] * 3
    budget = report["nodes"][-1]["budget"]["lines"]
    assert {t["name"] for t in budget["terms"]} >= {"Added noise", "Interpolation between samples"}
    assert (report["exit"], report["k"]) == (0, 2.0)


def test_equal_nodes_run_once(nonius: Nonius, small: Path) -> None:
    record = json.loads(small.read_text())
    record["nodes"] += [dict(record["nodes"][0], id="twin")]
    small.write_text(json.dumps(record))
    said = nonius("run", small, "--report", "r.json")
    nodes = {n["node"]: n["status"] for n in json.loads((small.parent / "r.json").read_text())["nodes"]}
    assert sorted([nodes["field"], nodes["twin"]]) == ["cached", "ran"]
    assert "cached" in said.out


def test_quiet_says_nothing_and_verbose_the_traceback(nonius: Nonius, slow: Path) -> None:
    words = ("run", slow, "--set", "late.seconds=0", "--set", "after.seconds=0")
    said = nonius(*words, "--quiet", "--require", "list.table:accuracy.value.max < 1", "--report", "r.json")
    assert said.out == ""
    assert "Traceback" not in said.err
    assert "Traceback" in nonius(*words, "--verbose").err


def test_a_module_fails_and_the_others_go_on(nonius: Nonius, slow: Path) -> None:
    (slow.parent / "list.csv").write_text("before")
    words = ("--set", "late.seconds=0", "--report", "r.json", "--out", "list=list.csv", "--out", "after=after.vti")
    said = nonius("run", slow, *words)
    assert said.code == 1
    assert "bad (Fails): the samples are not to its taste: give it others" in said.err
    assert "after waits for bad" in said.err
    report = json.loads((slow.parent / "r.json").read_text())
    assert {n["node"]: n["status"] for n in report["nodes"]} == {
        "field": "ran", "list": "ran", "bad": "failed", "after": "blocked",
    }  # fmt: skip
    assert report["exit"] == 1
    assert (slow.parent / "list.csv").read_text() == "number,value [m]\n0,0.1\n1,1e-30\n2,2.5\n"
    assert not (slow.parent / "after.vti").exists()


def test_shapes_and_samples_are_written(nonius: Nonius, small: Path) -> None:
    pytest.importorskip("modules.data.exchange")
    words = ("--out", "contour.lines=lines.vtp", "--out", "field=field.vti", "--out", "model=model.vti", "--quiet")
    said = nonius("run", small, *words)
    assert said.code == 0, said
    for name in ("lines.vtp", "field.vti", "model.vti"):
        assert (small.parent / name).stat().st_size > 500
    (small.parent / "field.vtu").write_text("before")
    said = nonius("run", small, "--out", "contour=lines.vtp", "--out", "field=field.vtu")
    assert (said.code, "name it field.vti" in said.err) == (2, True)
    assert (small.parent / "field.vtu").read_text() == "before"
    assert sorted(p.name for p in small.parent.iterdir()) == ["field.vti", "field.vtu", "lines.vtp", "model.vti", "small.json"]


def test_demands(nonius: Nonius, small: Path) -> None:
    met = "contour.lines[Interpolation].position.median < 1 cell"
    said = nonius("run", small, "--require", met)
    assert (said.code, f"met: {met}" in said.out) == (0, True)
    unmet = "contour.lines[Interpolation].position.max < 1e-9"
    said = nonius("run", small, "--require", met, "--require", unmet, "--report", "r.json")
    assert said.code == 3
    assert f"not met: {unmet}: it is" in said.err
    assert [d["met"] for d in json.loads((small.parent / "r.json").read_text())["demands"]] == [True, False]
    nothing = ("--set", "contour.levels=99", "--require", "contour.lines.position.max < 1e9")
    assert "about nothing" in nonius("run", small, *nothing).err


def test_k_is_a_setting(nonius: Nonius, small: Path) -> None:
    demand = "contour.lines[Added noise].position.max < 1e-9"
    found = [nonius("run", small, "--set", f"k={k}", "--require", demand).err for k in (1, 3)]
    numbers = [float(text.rsplit("it is ", 1)[1].split()[0]) for text in found]
    assert numbers[1] == pytest.approx(3 * numbers[0], rel=1e-3)


@pytest.mark.usefixtures("little_pictures")
def test_a_path_is_as_seen_from_here(nonius: Nonius, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(made / "heights.npy", tmp_path / "mine.npy")
    monkeypatch.chdir(tmp_path)
    words = ("run", made / "peak.json", "--out", "view=x.png", "--set")
    said = nonius("check", made / "peak.json")
    assert (said.code, "could run" in said.out) == (0, True)
    assert "there is no file" in nonius(*words, "field.path=yours.npy").err
    assert nonius(*words, "field.path=mine.npy").code == 0


def test_data_that_changed_since_the_network_was_saved_is_told(nonius: Nonius, made: Path, tmp_path: Path) -> None:
    for name in ("peak.json", "heights.npy"):
        shutil.copy(made / name, tmp_path / name)
    from app.engine import document

    document.save(document.load(tmp_path / "peak.json"), tmp_path / "peak.json")
    words = ("run", tmp_path / "peak.json", "--out", f"contour={tmp_path / 'x.vtp'}")
    assert nonius(*words).err == ""
    data = bytearray((tmp_path / "heights.npy").read_bytes())
    data[-1] ^= 1
    (tmp_path / "heights.npy").write_bytes(bytes(data))
    said = nonius(*words)
    assert said.code == 0
    assert "has changed since the network was saved" in said.err
    assert "has changed since the network was saved" in nonius("check", tmp_path / "peak.json").err


# --- pictures


@pytest.mark.usefixtures("little_pictures")
def test_a_picture_runs_again(nonius: Nonius, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    before = (tmp_path / "peak.png").read_bytes()
    said = nonius("run", "peak.png")
    assert said.code == 0, said
    assert "field.path reads heights.npy" in said.out
    assert (tmp_path / "peak.png").read_bytes() == before
    again, first = (json.loads((tmp_path / f"{n}.accuracy.json").read_text("utf-8")) for n in ("peak-again", "peak"))
    assert again["keys"] == first["keys"]
    assert again["layers"] == first["layers"]


def test_each_view_is_written_under_its_name(made: Path) -> None:
    from app.commands import nets, run
    from app.engine.catalogue import Catalogue

    catalogue = Catalogue.load()
    network = nets.find(str(made / "peak.json"), catalogue).network
    assert [o.path.name for o in run.default(network, "peak", catalogue)] == ["peak.png"]
    two = network.add("renderers.view.view", catalogue, id="other")
    assert [o.path.name for o in run.default(two, "peak", catalogue)] == ["peak-other.png", "peak-view.png"]


def test_without_opengl_the_answer_is_a_sentence(
    nonius: Nonius, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(opengl, "SCRIPT", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    opengl.probe.cache_clear()
    said = nonius("run", made / "peak.json", "--report", "r.json")
    assert said.code == 1
    assert "this machine has no OpenGL" in said.err
    assert "apt-get install" in said.err or not sys.platform.startswith("linux")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r.json"]
    said = nonius("doctor")
    assert (said.code, "no  this machine has no OpenGL" in said.out) == (1, True)
    opengl.probe.cache_clear()


@pytest.mark.usefixtures("little_pictures")
def test_the_gallery_shows_every_network(nonius: Nonius, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from app import paths

    monkeypatch.setattr(paths, "networks", lambda: {"peak": made / "peak.json"})
    said = nonius("gallery", "--to", tmp_path / "g", "--quiet")
    assert said.code == 0, said
    page = (tmp_path / "g" / "index.html").read_text("utf-8")
    assert 'src="peak.png"' in page
    assert "A peak, é" in page
    assert sorted(p.name for p in (tmp_path / "g").iterdir()) == ["index.html", "peak.accuracy.json", "peak.png"]


# --- ending


def test_cancelling_ends_at_once_and_writes_nothing(slow: Path) -> None:
    process = shell("run", str(slow), "--report", "r.json", cwd=slow.parent, env={"NONIUS_MODULES": str(slow.parent / "mine")})
    assert process.stdout
    for line in process.stdout:
        if line.startswith("contour"):
            break
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    took = time.monotonic() - start
    assert process.returncode == 130, err
    assert "cancelled; nothing was written; not finished: " in err
    assert "late" in err.rsplit("not finished:", 1)[1]
    assert "Traceback" not in err
    assert took < 1.0, took
    assert sorted(p.name for p in slow.parent.iterdir()) == ["mine", "small.json"]


def test_output_is_utf_8_whatever_the_locale(small: Path) -> None:
    env = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii", "PYTHONCOERCECLOCALE": "0"}
    process = shell("run", str(small), "--set", "field.formula=x+y", cwd=small.parent, env=env)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "≤" in out or "±" in out


def test_a_reader_that_goes_away_is_no_failure(small: Path) -> None:
    process = shell("modules", cwd=small.parent)
    assert process.stdout
    assert process.stderr
    process.stdout.close()
    assert "Traceback" not in process.stderr.read()
    process.stderr.close()
    process.wait(timeout=60)


# --- parts


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_bars_are_for_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    for stream, live in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        console = Console()
        console.progress("contour", 0.5)
        console.complain("done")
        text = stream.getvalue()
        assert ("50 %" in text) is live
        assert ("\x1b" in text) is live
        assert text.endswith("done\n")


def test_columns_are_aligned() -> None:
    assert columns([("a", "bb", "c"), ("aaa", "b", "cc")]) == ["a    bb  c", "aaa  b   cc"]


def test_an_outbox_writes_all_or_nothing(tmp_path: Path) -> None:
    one, two = tmp_path / "one.txt", tmp_path / "two.txt"
    one.write_text("before")
    with pytest.raises(RuntimeError), Outbox() as outbox:
        outbox.put(one, b"after")
        outbox.put(two, b"after")
        raise RuntimeError
    assert one.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["one.txt"]
    with Outbox() as outbox:
        outbox.put(one, b"after")
        outbox.put(two, b"after")
        with pytest.raises(NetworkError, match="two outputs"):
            outbox.place(tmp_path / "." / "two.txt")
        with pytest.raises(NetworkError, match="no folder"):
            outbox.place(tmp_path / "no" / "two.txt")
        assert outbox.commit() == [one, two]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.txt", "two.txt"]
    assert one.read_text() == two.read_text() == "after"


def test_modules_as_json(nonius: Nonius) -> None:
    listed = json.loads(nonius("modules", "--json").out)
    contour = next(m for m in listed["modules"] if m["id"] == "mappers.contour.contour")
    assert contour["outputs"] == [{"name": "lines", "type": "Geometry"}]
    assert {p["name"] for p in contour["parameters"]} >= {"levels", "method"}


def test_describe_says_what_the_function_says(nonius: Nonius) -> None:
    said = nonius("describe", "contour").out
    for part in ("Contour", "model", "levels", '"shoulder"', "accuracy", "source", "jacksboro"):
        assert part in said


def test_a_fault_of_the_program_is_said_to_be_one(nonius: Nonius, small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from app.commands import run

    monkeypatch.setattr(run, "_wanted", lambda *_: 1 / 0)
    said = nonius("run", small)
    assert (said.code, "Traceback" in said.err) == (1, False)
    assert "the program itself is at fault (ZeroDivisionError" in said.err
    assert "Traceback" in nonius("run", small, "--verbose").err


def test_warm_reports_a_child_that_fails(nonius: Nonius, monkeypatch: pytest.MonkeyPatch) -> None:
    from app.commands import warm
    from modules.kernels import _jit

    monkeypatch.setattr(_jit, "is_warm", lambda: False)
    monkeypatch.setattr(warm, "CHILD", "print('0.5 arcs'); raise SystemExit({path!r} and 0)")
    said = nonius("warm")
    assert (said.code, "compiling arcs" in said.out) == (0, True)
    monkeypatch.setattr(warm, "CHILD", "raise SystemExit({path!r} and 3)")
    assert nonius("warm").code == 1
