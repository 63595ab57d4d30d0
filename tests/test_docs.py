"""The documentation, run: code blocks of writing-a-module.md, links, commands and words that the pages promise."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app import cli
from app.engine import certificate, demands, document, errors
from modules.data.accuracy import SIGNS

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "resources" / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
Nonius = Callable[..., Any]


def blocks(page: Path) -> list[tuple[str, str, str]]:
    """(language, file name, text) of each code block."""
    return re.findall(r"^```(\w+) ?([\w.-]*)\n(.*?)^```$", page.read_text("utf-8"), re.M | re.S)


def test_writing_a_module_works_as_written(nonius: Nonius, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    monkeypatch.setenv("NONIUS_MODULES", str(folder))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(folder)
    ran = []
    for language, name, text in blocks(DOCS / "writing-a-module.md"):
        if name:
            (folder if name.endswith(".py") else tmp_path).joinpath(name).write_text(text, "utf-8")
        elif language == "python":
            exec(compile(text, "writing-a-module.md", "exec"), {})
            del sys.modules["soften"]
        elif language == "sh":
            for line in text.splitlines():
                words = re.findall(r"'[^']*'|\S+", line)
                said = nonius(*(w.strip("'") for w in words[1:]))
                assert said.code == 0, (line, said)
                ran.append((words[1], said.out))
    assert [command for command, _ in ran] == ["modules", "describe", "run"]
    assert "user.soften.soften" in ran[0][1]
    assert "the binomial filter" in ran[1][1]
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert {n["node"]: n["status"] for n in report["nodes"]}["contour"] == "ran"
    assert "Smoothing" in report["nodes"][-1]["budget"]["lines"]["missing"]
    module = next(text for _, name, text in blocks(DOCS / "writing-a-module.md") if name == "soften.py")
    code = [line for line in module[module.rindex('"""') :].splitlines()[1:] if line.strip()]
    assert len(code) <= 20


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text("utf-8")):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_that_pages_name_exist(page: Path) -> None:
    for name in re.findall(r"\bnonius ([a-z]+)\b", page.read_text("utf-8")):
        assert name in cli.COMMANDS, f"{page.name} says `nonius {name}`"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_options_that_pages_name_exist(page: Path) -> None:
    known = cli._options(cli.parser())
    for line in re.findall(r"\bnonius \w+ [^\n`]*", page.read_text("utf-8")):
        for name in re.findall(r"(?<!\S)--[a-z-]+", line):
            assert name in known, f"{page.name}: {line}"


def test_the_readme_makes_the_main_picture_and_passes_the_tests_in_one_line_each() -> None:
    lines = [text.strip() for language, _, text in blocks(ROOT / "README.md") if language == "sh"]
    venv = "python3 -m venv .venv && .venv/bin/pip install -e"
    assert f"{venv} . && .venv/bin/nonius run networks/jacksboro.json" in lines
    assert f"{venv} '.[test]' && .venv/bin/python -m pytest" in lines
    assert (ROOT / "networks" / "jacksboro.json").is_file()
    first = (ROOT / "README.md").read_text("utf-8").splitlines()[0]
    assert first.startswith("![")
    assert "(resources/gallery/jacksboro.png)" in first


def test_the_readme_sets_what_its_network_has(nonius: Nonius) -> None:
    from app.commands import nets
    from app.engine.catalogue import Catalogue

    text = (ROOT / "README.md").read_text("utf-8")
    catalogue = Catalogue.load()
    found = nets.find(str(ROOT / "networks" / "jacksboro.json"), catalogue)
    edits = [a or b for a, b in re.findall(r"--set (?:'([^']+)'|(\S+))", text)]
    assert edits
    nets.edited(found, edits, catalogue)
    for demand in re.findall(r"--require '([^']+)'", text):
        demands.Demand.of(demand).against(found.network, catalogue)
    for node, output in re.findall(r"--out (\w+)=(\S+)", text):
        assert node in found.network.nodes
        assert output.endswith(".png")


def test_words_of_accuracy_are_all_explained() -> None:
    text = (DOCS / "accuracy.md").read_text("utf-8")
    for word, sign in SIGNS.items():
        assert f"`{sign}`" in text
        assert word in text or word == "unknown"
    for kind in ("linear", "bound", "signed", "members", "metric"):
        assert f"| {kind} |" in text


def test_formats_and_codes_are_all_explained() -> None:
    text = (DOCS / "files.md").read_text("utf-8")
    assert f'"format": "{document.FORMAT}"' in text
    assert f'"schema": {document.SCHEMA}' in text
    for key in (certificate.NETWORK, certificate.KEYS, certificate.ACCURACY):
        assert f"`{key}`" in text
    for name in (*demands.STATISTICS, *certificate.NUMBERS):
        assert name in text
    for demand in re.findall(r"^    (\S+ +(?:<=|>=|<) .*?)  ", text, re.M):
        if "|" not in demand and not demand.startswith("node."):
            demands.Demand.of(demand)
    codes = {0, errors.ModuleFailed.exit_code, errors.NetworkError.exit_code, errors.DemandError.exit_code, cli.CANCELLED}
    assert {int(c) for c in re.findall(r"^\| (\d+) \|", text, re.M)} == codes


def test_decisions_are_numbered_without_gaps() -> None:
    names = sorted(p.name for p in (DOCS / "decisions").glob("*.md"))
    assert [int(n[:4]) for n in names] == list(range(1, len(names) + 1))
    for name in names:
        assert (DOCS / "decisions" / name).read_text("utf-8").startswith(f"# {int(name[:4])}. ")
