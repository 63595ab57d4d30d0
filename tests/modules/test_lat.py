"""IRIS Explorer's plain lattices: the three kinds of coordinates, several variables and steps, and what is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from modules.api import Curvilinear, Rectilinear, Regular, Unstructured
from modules.readers.dataset import dataset, peek

HEAD = "#!/usr/explorer/bin/explorer cxLattice plain 1.0\n# made up\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "a.lat"
    path.write_text(HEAD + text, encoding="ascii")
    return path


def test_a_uniform_lattice_of_space(tmp_path: Path) -> None:
    values = " ".join(f"{v}.5" for v in range(24))
    path = written(tmp_path, f"3 4 3 2  # dimensions\n1 3 0 1\n0 6 0 1 -1 1\n{values}\n")
    assert peek(path) == {"names": ("variable 1",), "shape": (2, 3, 4)}
    read = dataset(path=path)
    assert isinstance(read.grid, Regular)
    assert (read.grid.spacing, read.grid.origin) == ((2.0, 0.5, 2.0), (0.0, 0.0, -1.0))
    assert read.values[1, 2, 3] == 23.5 and read.values[0, 0, 1] == 1.5, "the first dimension varies fastest"
    assert float(read.accuracy.terms[0].error().max()) == 0.05
    assert [m.name for m in read.accuracy.missing] == ["Measurement error"]


def test_perimeter_and_steps_and_variables(tmp_path: Path) -> None:
    one = " ".join(f"{n} {10 * n}" for n in range(6))
    two = " ".join(f"{n + 100} {n + 200}" for n in range(6))
    path = written(tmp_path, f"2\n3 2\n2 1 1 2\n0 1 4\n0 10\n{one}\n{two}\n")
    assert peek(path)["names"] == ("variable 1, step 1", "variable 2, step 1", "variable 1, step 2", "variable 2, step 2")
    read = dataset(path=path, name="variable 2, step 2")
    assert isinstance(read.grid, Rectilinear) and [a.tolist() for a in read.grid.axes] == [[0, 1, 4], [0, 10]]
    assert read.values.tolist() == [[200, 201, 202], [203, 204, 205]] and read.time == 1.0
    assert read.accuracy.flags[0].name == "assumed"


def test_curvilinear_vectors_and_a_row_of_nodes(tmp_path: Path) -> None:
    nodes = "0 0  1 0.1  2 0  0 1  1 1.1  2 1"
    vectors = " ".join(f"{n} 0 1" for n in range(6))
    read = dataset(path=written(tmp_path, f"2 3 2 3 4 2 1 2 {nodes} {vectors}"))
    assert isinstance(read.grid, Curvilinear) and read.grid.nodes[1, 1].tolist() == [1, 1.1, 0]
    assert read.name == "vector" and read.values[1, 2].tolist() == [5, 0, 1]
    read = dataset(path=written(tmp_path, "1 4 1 3 2 1 2  0 0 1 0 0 1 3 3  5 6 7 8"))
    assert isinstance(read.grid, Unstructured) and not read.grid.cells
    assert np.array_equal(read.values, [5, 6, 7, 8]) and read.grid.points()[3].tolist() == [3, 3, 0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("3 4 3", "a dimension should be a whole number"),
        ("4 1 1 1 1", "the number of dimensions should be a whole number from 1 to 3"),
        ("2 2 2 1 3 0 1\n0 1 0 1\n1 2 3", "ends after 7 of 8 numbers"),
        ("2 2 2 1 3 0 1\n0 1 0 1\n1 2 3 x", "'x' is not a number"),
        ("2 2 2 1 9 0 1\n0 1 0 1\n1 2 3 4", "the type of the data should be a whole number from 0 to 4"),
        ("2 2 2 1 3 1 1\n1 0 0 1\n1 2 3 4", "not strictly ascending"),
    ],
)
def test_a_wrong_one_is_told_in_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        dataset(path=written(tmp_path, text))


def test_other_formats_are_named(tmp_path: Path) -> None:
    path = tmp_path / "b.lat"
    path.write_bytes(b"#!/usr/explorer/bin/explorer cxLattice binary 1.0\n\0\1\2")
    with pytest.raises(ValueError, match="write it as 'plain' with WriteLat"):
        dataset(path=path)
    assert "WriteLat" in str(peek(path)["problem"])
