"""Colour tables: by name, from a file, and where a logarithmic one meets zero."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.api import EXACT, Colouring, Layer, Progress, Samples, SurfaceLook
from modules.mappers.bands import bands
from modules.modellers.interpolate import interpolate
from modules.readers._files import ReadError
from modules.readers.colour_table import colour_table
from modules.renderers.image import image
from modules.renderers.surface import surface

NAMES = ("values", "errors", "greys", "diverging")
Floats = NDArray[np.float64]


def linear(rgb: Floats) -> Floats:
    found: Floats = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return found


def lightness(rgb: Floats) -> list[float]:
    """CIE L*."""
    return [116 * max(float(y), 0.008856) ** (1 / 3) - 16 for y in linear(rgb) @ np.array([0.2126, 0.7152, 0.0722])]


def without_green(rgb: Floats) -> Floats:
    """Deuteranopia, after Machado, Oliveira and Fernandes 2009."""
    matrix = np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]])
    seen: Floats = np.clip(linear(rgb) @ matrix.T, 0, 1)
    return seen


@pytest.mark.parametrize("name", NAMES)
def test_a_table_by_name(name: str) -> None:
    found = colour_table(table=name)  # type: ignore[arg-type]  # one of the words
    assert found.name == name
    assert found.colours.shape[1] == 3
    assert 0 <= found.colours.min() <= found.colours.max() <= 1
    back = colour_table(table=name, reverse=True)  # type: ignore[arg-type]
    assert np.array_equal(back.colours, found.colours[::-1])


@pytest.mark.parametrize(("name", "rises"), [("values", True), ("greys", True), ("errors", False)])
def test_lightness_runs_one_way_for_every_eye(name: str, rises: bool) -> None:
    """Light is much for values, as in images; of errors dark is much, so that what is sure stays quiet."""
    colours = colour_table(table=name).colours  # type: ignore[arg-type]  # one of the words
    at = np.linspace(0, len(colours) - 1, 101)
    between = np.column_stack([np.interp(at, np.arange(len(colours)), c) for c in colours.T])
    way = 1 if rises else -1
    light = np.array(lightness(between))
    assert (way * np.diff(light) > 0).all()
    assert np.ptp(light) > 60
    seen = without_green(between) @ np.array([0.2126, 0.7152, 0.0722])
    assert (way * np.diff(seen) > 0).all()


def test_both_sides_of_the_diverging_table_are_equally_dark_and_told_apart_by_every_eye() -> None:
    colours = colour_table(table="diverging").colours
    light = lightness(colours)
    assert light == pytest.approx(light[::-1], abs=1.0)
    assert (np.diff(light[:5]) > 10).all()
    seen = without_green(colours)
    assert (np.abs(seen[:4] - seen[:4:-1]).max(axis=1) > 0.15).all()


@pytest.mark.parametrize(
    "text",
    [
        "0 0 0\n0.5 0.25 1\n",
        "red,green,blue\n0,0,0\n0.5,0.25,1\n",
        "# my colours\n0; 0; 0\n\n0.5; 0.25; 1\n",
        "\ufeff0\t0\t0\n.5\t.25\t1",
    ],
)
def test_a_file_of_numbers(tmp_path: Path, text: str) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(text, "utf-8")
    found = colour_table(table="file", path=path, steps=3)
    assert found.colours.tolist() == [[0, 0, 0], [0.5, 0.25, 1]]
    assert (found.name, found.steps) == ("mine", 3)


def test_numbers_to_255_and_codes(tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    path.write_text("0 0 1\n255 51 102\n#FF3366\n00ff00\n")
    colours = colour_table(table="file", path=path).colours
    assert colours == pytest.approx(np.array([[0, 0, 1 / 255], [1, 0.2, 0.4], [1, 0.2, 0.4], [0, 1, 0]]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0 0 0\n1 1\n", "line 2: there are 2 numbers"),
        ("0 0 0\nblue\n", "line 2: 'blue' is no colour"),
        ("0 0 0\n300 0 0\n", "leaves 0 to 255"),
        ("0 0 0\n-1 0 0\n", "leaves 0 to 255"),
        ("0 0 0\nnan 0 0\n", "leaves 0 to 255"),
        ("0 0 0\n", "holds 1 colours"),
        ("r g b\n", "holds 0 colours"),
        ("0 0 0\n" * 5000, "at most 4096"),
    ],
)
def test_a_file_that_is_no_table_is_told(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(ReadError, match=words):
        colour_table(table="file", path=path)


def test_no_file_and_no_text(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="no file is chosen"):
        colour_table(table="file")
    (tmp_path / "x.bin").write_bytes(b"\xff\x00\xfe" * 9)
    with pytest.raises(ReadError, match="is no text"):
        colour_table(table="file", path=tmp_path / "x.bin")
    with pytest.raises(ValueError, match="at least 2 steps"):
        colour_table(steps=1)


def test_a_logarithmic_map_refuses_zero_where_it_meets_it() -> None:
    logarithmic = colour_table(scale="logarithmic")
    good, bad = (Samples.from_array(np.arange(9.0).reshape(3, 3) + low, accuracy=EXACT) for low in (1, 0))
    assert image(good, logarithmic).look.colouring.range == (1.0, 9.0)  # type: ignore[union-attr]  # it has one
    with pytest.raises(ValueError, match="above zero"):
        image(bad, logarithmic)
    shapes = bands(interpolate(bad), Progress(), levels=(-1.0, 3.0, 9.0)).bands
    with pytest.raises(ValueError, match="above zero"):
        surface(shapes, logarithmic, colour_by="level")


def test_colours_of_bands_change_at_the_levels() -> None:
    field = interpolate(Samples.from_array(np.arange(9.0).reshape(3, 3) + 0.5, unit="m", accuracy=EXACT))
    shapes = bands(field, Progress(), interval=2.0).bands
    layer = surface(shapes, colour_table(table="diverging"), colour_by="level")
    colouring = look_of(layer)
    assert colouring.range == (0.0, 10.0)
    assert colouring.map.steps == 5
    assert layer.title == "Bands of 2\u00a0m"
    uneven = bands(field, Progress(), levels=(0.0, 1.0, 5.0)).bands
    colouring = look_of(surface(uneven, colour_table(), colour_by="level"))
    assert colouring.range == (0.0, 5.0)
    assert colouring.map.steps == 0
    given = look_of(surface(shapes, colour_table(), colour_by="level", low=1.0, high=3.0))
    assert (given.range, given.map.steps) == ((1.0, 3.0), 0)


def look_of(layer: Layer) -> Colouring:
    assert isinstance(layer.look, SurfaceLook)
    assert layer.look.colouring is not None
    return layer.look.colouring
