"""A parameter that runs through values: how they are written, what is refused, and that each frame is a network."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from app.cli import main
from app.engine import certificate, pngtext
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError, ValueRefused
from app.engine.network import Network
from app.engine.sequence import SETTING, Sequence, each, kept


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


@pytest.fixture(scope="module")
def network(catalogue: Catalogue) -> Network:
    return Network().add("readers.analytic.analytic", catalogue, id="wave").add("mappers.trace.trace", catalogue, id="trace")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("trace.tolerance=1e-2..1e-8/4 log", (1e-2, 1e-4, 1e-6, 1e-8)),
        ("trace.tolerance=0.001, 0.0001", (1e-3, 1e-4)),
        ("trace.steps=1..5", (1, 2, 3, 4, 5)),
        ("trace.steps=5..1/3", (5, 3, 1)),
        ("wave.time=0..0.3/4", (0.0, 0.1, 0.2, 0.3)),
        ("trace.pair=RK4; Heun", ("RK4", "Heun")),
        ("wave.low=0,0,0; 1,0,0", ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    ],
)
def test_values_as_they_are_written(network: Network, catalogue: Catalogue, text: str, values: tuple[object, ...]) -> None:
    assert Sequence.of(text).frames(network, catalogue) == values
    assert Sequence.of(str(Sequence.of(text))) == Sequence.of(text)


@pytest.mark.parametrize(
    "text", ["trace=1..2", "trace.tolerance", "trace.tolerance=", "trace.tolerance=0..1/5 log", "trace.steps=1..100000",
             "trace.tolerance=1,,2", "trace.steps=1..2/3", "trace.no=1..2", "nobody.steps=1..2", "trace.pair=RK5"],
)  # fmt: skip
def test_what_cannot_run_is_refused_in_a_sentence(network: Network, catalogue: Catalogue, text: str) -> None:
    with pytest.raises(NetworkError):
        each([Sequence.of(text)], network, catalogue)


def test_several_run_through_every_combination(network: Network, catalogue: Catalogue) -> None:
    found = each([Sequence.of("trace.pair=RK4, Heun"), Sequence.of("trace.step=0.1, 0.2")], network, catalogue)
    assert [tuple(v.values()) for v, _ in found] == [("RK4", 0.1), ("RK4", 0.2), ("Heun", 0.1), ("Heun", 0.2)]
    assert found[3][1]["trace"].parameters["step"] == 0.2
    with pytest.raises(ValueRefused, match="together"):
        each([Sequence.of("trace.steps=1..5000"), Sequence.of("trace.step=0.1, 0.2, 0.3")], network, catalogue)


def test_it_is_a_setting_of_the_document(network: Network) -> None:
    assert kept(network.settings) is None
    assert kept(network.settle(**{SETTING: "trace.steps=1..5"}).settings) == Sequence("trace", "steps", "1..5")
    assert kept({SETTING: "no sequence"}) is None


@pytest.mark.usefixtures("little_pictures")
def test_frames_are_pictures_with_certificates_and_a_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["run", "colour-bands", "--out", "view=sweep.png", "--report", "r.json", "--quiet"]
    assert main([*words, "--for", "contour.interval="]) == 2 and "write it as" in capsys.readouterr().err
    assert main([*words, "--for", "saved"]) == 2 and "has no sequence" in capsys.readouterr().err
    assert main([*words, "--film", "5"]) == 2 and "--for" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    assert main([*words, "--for", "contour.interval=50..100/2", "--film", "5"]) == 0
    report, told = (json.loads((tmp_path / name).read_text("utf-8")) for name in ("r.json", "sweep.frames.json"))
    assert [f["set"] for f in report["frames"]] == [{"contour.interval": 50.0}, {"contour.interval": 100.0}]
    again = {n["node"] for n in report["frames"][1]["nodes"] if n["status"] == "ran"}
    assert "contour" in again and "read" not in again, "what does not hang on the value runs once"
    for frame in told["pictures"]:
        picture = (tmp_path / frame["file"]).read_bytes()
        assert certificate.digest(picture) == frame["sha256"]
        content = json.loads((tmp_path / frame["certificate"]).read_text("utf-8"))
        assert content["network"]["edits"] == [f"contour.interval={frame['set']['contour.interval']}"]
    assert main(["check", "sweep-001.png"]) == 0
    with Image.open(tmp_path / told["film"]["file"]) as film:
        assert frames(film) == 2


def frames(film: Any) -> int:
    return int(film.n_frames)


def test_a_film_is_its_pictures_bit_by_bit(tmp_path: Path) -> None:
    pictures = []
    for shade in (10, 120, 250):
        Image.new("RGB", (40, 30), (shade, 0, 255 - shade)).save(tmp_path / "one.png")
        pictures.append((tmp_path / "one.png").read_bytes())
    (tmp_path / "film.png").write_bytes(pngtext.animated(pictures, 8))
    with Image.open(tmp_path / "film.png") as film:
        assert frames(film) == 3 and film.info["duration"] == 125
        for i, shade in enumerate((10, 120, 250)):
            film.seek(i)
            assert film.convert("RGB").getpixel((3, 3)) == (shade, 0, 255 - shade)
    Image.new("RGB", (41, 30)).save(tmp_path / "one.png")
    with pytest.raises(pngtext.NotPNG, match="another size"):
        pngtext.animated([*pictures, (tmp_path / "one.png").read_bytes()], 8)
    with pytest.raises(pngtext.NotPNG):
        pngtext.animated([], 8)
