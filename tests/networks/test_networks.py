"""Every packaged network: runs without a window, is saved as it stands, and its picture's certificate holds."""

import json
from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from app.engine import certificate, document, pngtext, writing
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError
from app.engine.paths import identities

HERE = Path(__file__).resolve().parent
NETWORKS = [*sorted((HERE.parents[1] / "networks").glob("*.json")), *sorted(HERE.glob("*.json"))]
"""Those that everyone gets, and those whose data come with packages that only tests need."""
each_network = pytest.mark.parametrize("path", NETWORKS, ids=lambda path: path.stem)


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def test_there_are_some() -> None:
    assert "jacksboro" in [p.stem for p in NETWORKS]


@each_network
def test_it_is_saved_as_it_stands(path: Path, catalogue: Catalogue) -> None:
    loaded = document.read(path, catalogue)
    assert not loaded.warnings
    assert document.dumps(loaded.network, catalogue).encode() == path.read_bytes()


@each_network
def test_its_data_is_as_it_was_when_it_was_saved(path: Path, catalogue: Catalogue) -> None:
    network = document.load(path, catalogue)
    found = identities(network, catalogue) or {}
    assert not [i.problem for i in found.values() if i.problem]
    assert not writing.changed_files(network, catalogue, found)
    assert all(not p.startswith("/") for p in network.files), "a packaged network reads what everyone has"


@pytest.mark.usefixtures("little_pictures")
@each_network
def test_its_picture_has_a_certificate_that_holds(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(path), "--report", "r.json"]) == 0, capsys.readouterr().err
    pictures = sorted(tmp_path.glob("*.png"))
    assert pictures
    for picture in pictures:
        assert main(["check", str(picture)]) == 0, capsys.readouterr().err
        content: dict[str, Any] = json.loads(certificate.beside(picture).read_text("utf-8"))
        assert content["caption"]
        assert len(content["layers"]) >= 1
        assert any(layer["terms"] for layer in content["layers"])
        assert pngtext.texts(picture.read_bytes())[certificate.NETWORK]
    statuses = {n["status"] for n in json.loads((tmp_path / "r.json").read_text("utf-8"))["nodes"]}
    assert statuses <= {"ran", "cached"}


def test_a_network_that_is_none_is_refused(tmp_path: Path, catalogue: Catalogue) -> None:
    (tmp_path / "x.json").write_text("[]")
    with pytest.raises(NetworkError):
        document.load(tmp_path / "x.json", catalogue)
