"""The certificate: what it claims, that no stored byte changes unseen, and that its numbers come out again."""

import copy
import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.engine import certificate, pngtext
from modules.data.accuracy import Accuracy, Flag, Missing, bound, deviation
from modules.data.geometry import Geometry


@pytest.fixture
def picture(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the picture with all that lies beside it, in the current folder."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "peak.png"


def content_of(picture: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(certificate.beside(picture).read_text("utf-8"))
    return content


# --- text in a PNG


def test_texts_come_back_as_they_were(picture: Path) -> None:
    given = {"nonius:a": "≤ 3 µm, 漢字, \0 and a line\n", "nonius:b": "x" * 300_000}
    png = pngtext.insert(picture.read_bytes(), given)
    assert {**pngtext.texts(png), **given} == pngtext.texts(png)
    assert len(png) < len(picture.read_bytes()) + 2_000
    assert pngtext.texts(pngtext.insert(png, {"nonius:a": "new"}))["nonius:a"] == "new"


def test_another_reader_finds_the_texts_and_the_same_pixels(picture: Path) -> None:
    from PIL import Image

    with Image.open(picture) as image:
        image.load()
        assert json.loads(image.text["nonius:network"])["format"] == "nonius-network"  # type: ignore[attr-defined]  # of PNG
        assert certificate.digest(image.tobytes()) == content_of(picture)["picture"]["pixels"]


@pytest.mark.parametrize("at", [3, 20, 40, 5000, -20, -5])
def test_a_damaged_png_is_refused(picture: Path, at: int) -> None:
    png = bytearray(picture.read_bytes())
    png[at] ^= 1
    with pytest.raises(pngtext.NotPNG):
        pngtext.texts(bytes(png))
    with pytest.raises(pngtext.NotPNG):
        pngtext.texts(bytes(png[:-30]))


# --- what is claimed


def test_every_term_is_claimed_with_all_its_numbers(picture: Path) -> None:
    content = content_of(picture)
    layer = content["layers"][0]
    assert layer["title"]
    assert {t["name"] for t in layer["terms"]} >= {"Quantisation", "Interpolation between samples"}
    for term in layer["terms"]:
        assert term["sign"] in "= ≤ ~ n= ?".split()
        assert term["rule"]
        assert term["looked"] == term["count"] > 0
        for name in certificate.NUMBERS:
            assert isinstance(term[name], float), name
    assert {t["quantity"] for t in layer["totals"]} == {t["quantity"] for t in layer["terms"]}
    assert content["caption"].startswith("A peak, é")
    assert content["k"] == 2.0
    assert content["pixel"]["bound"] > 0
    assert set(content["versions"]) >= {"nonius-explorer", "python", "numpy", "scipy", "numba", "vtk", "pyvista"}
    assert content["data"][0]["files"][0]["name"] == "heights.npy"
    assert set(content["keys"]) == {"field", "model", "contour", "lines", "view"}
    assert str(picture.parent) not in json.dumps(content)


def test_a_budget_in_plain_values() -> None:
    terms = (
        bound("Grid", np.array([1.0, 2.0, math.inf]), 3, quantity="position", unit="m"),
        deviation("Sensor", 0.5, 3, quantity="position", unit="m"),
        deviation("Other", 0.5, 3, quantity="value", unit="K"),
    )
    flag = Flag("kappa", "bent", "point", np.array([1, 2]), np.array([0.5, -0.7]))
    shape = Geometry(points=np.zeros((3, 3)), accuracy=Accuracy(terms, (Missing("Tide"),), (flag,)))
    plain = json.loads(json.dumps(certificate.budget(shape.accuracy, 3.0), allow_nan=False))
    assert plain["rigour"] == "unknown"
    assert plain["missing"] == [{"name": "Tide", "reason": "not given"}]
    assert plain["flags"] == [{"name": "kappa", "words": "bent", "place": "point", "count": 2, "largest": 0.7}]
    grid = next(t for t in plain["terms"] if t["name"] == "Grid")
    assert (grid["max"], grid["median"]) == ("inf", 2.0)
    position = next(t for t in plain["totals"] if t["quantity"] == "position")
    assert (position["max"], position["median"], position["k"]) == ("inf", 3.5, 3.0)


# --- no byte changes unseen


def check(nonius: Callable[..., Any], picture: Path, *words: str) -> Any:
    return nonius("check", certificate.beside(picture), *words)


def test_an_untouched_picture_holds(nonius: Callable[..., Any], picture: Path) -> None:
    said = check(nonius, picture)
    assert said.code == 0, said
    assert "recomputed" in said.out
    assert nonius("check", picture, "--no-run").code == 0


def test_it_holds_in_another_folder_with_its_data(nonius: Callable[..., Any], picture: Path) -> None:
    other = picture.parent / "other"
    other.mkdir()
    for name in ("peak.png", "peak.accuracy.json", "heights.npy"):
        shutil.move(picture.parent / name, other / name)
    assert check(nonius, other / "peak.png", "--no-run").code == 0


def flip(path: Path, at: int) -> None:
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(bytes(data))


@pytest.mark.parametrize("share", [0.0, 0.13, 0.4, 0.77, 0.9999])
def test_a_changed_byte_of_the_picture(nonius: Callable[..., Any], picture: Path, share: float) -> None:
    flip(picture, int(share * picture.stat().st_size))
    said = check(nonius, picture, "--no-run")
    assert said.code == 3, said
    assert "the picture 'peak.png' was changed" in said.err


def test_a_changed_byte_anywhere_in_the_certificate(picture: Path) -> None:
    data = certificate.beside(picture).read_bytes()
    for at in np.random.default_rng(1).choice(len(data), 300, replace=False):
        changed = bytearray(data)
        changed[at] ^= 1
        try:
            assert certificate.unseal(bytes(changed), "it")[1], at
        except certificate.CertificateError:
            pass
    assert certificate.unseal(data, "it")[1] == ""
    assert "bytes" in certificate.unseal(data.replace(b"\n ", b"\n  ", 1), "it")[1]


def test_a_changed_certificate_is_named(nonius: Callable[..., Any], picture: Path) -> None:
    path = certificate.beside(picture)
    path.write_text(path.read_text("utf-8").replace('"k": 2.0', '"k": 1.0', 1), "utf-8")
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "peak.accuracy.json: its content was changed" in said.err


def test_changed_data_is_named(nonius: Callable[..., Any], picture: Path) -> None:
    flip(picture.with_name("heights.npy"), -1)
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "heights.npy was changed" in said.err
    picture.with_name("heights.npy").unlink()
    assert check(nonius, picture, "--no-run").code == 3


def test_a_changed_network_file_is_named(nonius: Callable[..., Any], picture: Path) -> None:
    flip(picture.with_name("peak.json"), -2)
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "the network file 'peak.json' was changed" in said.err


def test_another_network_in_the_picture_is_named(nonius: Callable[..., Any], picture: Path) -> None:
    text = pngtext.texts(picture.read_bytes())[certificate.NETWORK].replace("0.25", "0.26")
    picture.write_bytes(pngtext.insert(picture.read_bytes(), {certificate.NETWORK: text}))
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "the network in 'peak.png' is another" in said.err
    assert "its pixels are the same" in said.err


def test_other_pixels_are_named(nonius: Callable[..., Any], picture: Path) -> None:
    from PIL import Image, PngImagePlugin

    texts = pngtext.texts(picture.read_bytes())
    with Image.open(picture) as image:
        image.putpixel((5, 5), (1, 2, 3, 255))
        image.save(picture, pnginfo=PngImagePlugin.PngInfo())
    picture.write_bytes(pngtext.insert(picture.read_bytes(), texts))
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "its pixels differ" in said.err


def test_a_missing_picture_is_named(nonius: Callable[..., Any], picture: Path) -> None:
    picture.unlink()
    said = check(nonius, picture, "--no-run")
    assert said.code == 3
    assert "not beside the certificate" in said.err


# --- the numbers come out again


def resealed(picture: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    """A forger's certificate: changed, and sealed again."""
    content = content_of(picture)
    change(content)
    certificate.beside(picture).write_bytes(certificate.seal(content))


def larger(term: dict[str, Any], name: str) -> None:
    term[name] *= 1 + 1e-5


@pytest.mark.parametrize("name", certificate.NUMBERS)
def test_a_resealed_number_is_found_by_recomputing(nonius: Callable[..., Any], picture: Path, name: str) -> None:
    resealed(picture, lambda content: larger(content["layers"][0]["terms"][0], name))
    assert check(nonius, picture, "--no-run").code == 0
    said = check(nonius, picture)
    assert said.code == 3
    term = content_of(picture)["layers"][0]["terms"][0]
    assert repr(term["name"]) in said.err
    assert name in said.err
    assert repr(term[name]) in said.err


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda c: c["layers"][0]["terms"][0].update(rigour="proven", sign="≤"), "rigour"),
        (lambda c: c["layers"][0]["terms"][0].update(count=1), "count is"),
        (lambda c: c["layers"][0]["missing"].clear(), "missing"),
        (lambda c: c["layers"][0]["ended"].append({"id": "x", "name": "x", "why": "x"}), "ended"),
        (lambda c: c["layers"][0]["terms"].pop(), "terms"),
        (lambda c: c["layers"].pop(), "layers"),
        (lambda c: c.update(k=3.0), "k is 2.0"),
        (lambda c: c["keys"].update(contour="0"), "contour: its key differs"),
        (lambda c: larger(c["layers"][0]["totals"][0], "p95"), "p95"),
        (lambda c: c.pop("layers"), "missing or not what it should be"),
        (lambda c: c.update(layers=[1]), "layer 1"),
        (lambda c: (c["tolerance"].update(relative=1e9), c["layers"][0]["terms"][0].update(max=7.0)), "max"),
    ],
)
def test_a_resealed_claim_is_found_by_recomputing(
    nonius: Callable[..., Any], picture: Path, change: Callable[[dict[str, Any]], Any], says: str
) -> None:
    resealed(picture, change)
    said = check(nonius, picture)
    assert said.code == 3
    assert says in said.err


def test_numbers_agree_within_the_tolerance() -> None:
    t = certificate.TOLERANCE
    assert certificate.agree(1.0, 1.0 + 1e-7, t)
    assert not certificate.agree(1.0, 1.0 + 1e-5, t)
    assert certificate.agree(1e-15, 3e-15, t, largest=1.0)
    assert not certificate.agree(1e-15, 3e-15, t, largest=1e-12)
    assert not certificate.agree(3, 4, {"relative": 1.0, "of_largest": 1.0})


def test_the_order_of_terms_is_no_difference(picture: Path) -> None:
    layers = content_of(picture)["layers"]
    turned = copy.deepcopy(layers)
    turned[0]["terms"].reverse()
    assert certificate.differences(layers, turned, certificate.TOLERANCE) == []


# --- files that are no certificate


@pytest.mark.parametrize(
    ("text", "says"),
    [("", "not JSON"), ("{}", "no certificate"), ("[]", "no certificate"), ('{"certificate": 99}', "later version")],
)
def test_what_is_no_certificate(nonius: Callable[..., Any], tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "x.accuracy.json"
    path.write_text(text)
    said = nonius("check", path)
    assert said.code == 2
    assert says in said.err


def test_a_misspelt_certificate_names_the_nearest(nonius: Callable[..., Any], picture: Path) -> None:
    said = nonius("check", "peek.accuracy.json")
    assert said.code == 2
    assert "did you mean 'peak.accuracy.json'?" in said.err
