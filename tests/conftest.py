"""What several tests share: the command line as a function, a small network, one picture made once."""

import functools
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")


class Said(NamedTuple):
    """What the command line answered."""

    code: int
    out: str
    err: str


@pytest.fixture(autouse=True, scope="session")
def no_modules_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Tests do not see what the person who runs them has installed for herself."""
    folder = tmp_path_factory.mktemp("modules-of-the-user")
    before = os.environ.get("NONIUS_MODULES")
    os.environ["NONIUS_MODULES"] = str(folder)
    yield folder
    if before is None:
        del os.environ["NONIUS_MODULES"]
    else:
        os.environ["NONIUS_MODULES"] = before


@pytest.fixture
def nonius(capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """`nonius` in this process: words -> (exit code, stdout, stderr)."""
    from app.cli import main

    def call(*words: str | Path) -> Said:
        capsys.readouterr()
        code = main([str(word) for word in words])
        return Said(code, *capsys.readouterr())

    return call


def node(name: str, module: str, **parameters: Any) -> dict[str, Any]:
    """A node as a network file has it; of the version that is here."""
    return {"id": name, "module": module, "version": versions()[module], "parameters": parameters}


@functools.cache
def versions() -> dict[str, int]:
    """Module -> version."""
    from app.engine.catalogue import Catalogue

    catalogue = Catalogue()
    catalogue._rooms = True
    catalogue.reload()
    return {record.id: record.version for record in catalogue}


def network(*nodes: dict[str, Any], wires: tuple[str, ...] = ()) -> str:
    """The text of a network file."""
    return json.dumps({"format": "nonius-network", "schema": 1, "nodes": nodes, "wires": wires})


def lines() -> tuple[dict[str, Any], ...]:
    """From samples to contour lines."""
    return (
        node("model", "modellers.interpolate.interpolate"),
        node("contour", "mappers.contour.contour", levels=[0.25]),
    )


def seen() -> tuple[dict[str, Any], ...]:
    """From contour lines to a view."""
    return node("lines", "renderers.lines.lines"), node("view", "renderers.view.view", title="A peak, é")


WIRES = ("field.samples -> model.samples", "model.model -> contour.model")
SEEN_WIRES = ("contour.lines -> lines.geometry", "lines.layer -> view.layers[0]")


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """small.json in an empty current folder: contour lines of a formula, no view."""
    path = tmp_path / "small.json"
    field = node("field", "readers.analytic.analytic", samples=[17, 17], noise=0.01)
    path.write_text(network(field, *lines(), wires=WIRES), "utf-8")
    monkeypatch.chdir(tmp_path)
    return path


def draw_little(patch: pytest.MonkeyPatch) -> None:
    """Make the command line draw 480 x 320 pixels: drawing in software takes a while."""
    from app import picture

    patch.setattr(picture, "render", functools.partial(picture.render, size=(480, 320)))


@pytest.fixture
def little_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """The pictures of this test are of 480 x 320 pixels."""
    draw_little(monkeypatch)


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with peak.json, the data heights.npy, and the picture peak.png with its certificate. Copy it to change it."""
    from app.cli import main

    folder = tmp_path_factory.mktemp("made")
    y, x = np.mgrid[-1:1:17j, -1:1:17j]
    np.save(folder / "heights.npy", np.exp(-3 * (x**2 + y**2)))
    field = node("field", "readers.elevation.elevation", path="heights.npy")
    nodes = (field, *lines(), *seen())
    (folder / "peak.json").write_text(network(*nodes, wires=(*WIRES, *SEEN_WIRES)), "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        draw_little(patch)
        assert main(["run", str(folder / "peak.json"), "--out", f"view={folder / 'peak.png'}", "--quiet"]) == 0
    return folder
