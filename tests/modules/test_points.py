"""Scattered points: read from tables, joined by triangles, brought to a grid; and how far their errors hold."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from modules.api import Accuracy, Model, Progress, Samples, Unstructured, deviation
from modules.mappers.contour import contour
from modules.modellers.grid_points import Method, grid_points
from modules.modellers.interpolate import interpolate
from modules.modellers.triangulate import triangulate
from modules.readers.scattered import peek
from modules.readers.scattered import scattered as points
from modules.readers.table import table

ROOT = Path(__file__).resolve().parents[2]
LAKE = ROOT / "networks" / "data" / "soundings.csv"
Floats = NDArray[np.float64]


def written(folder: Path, text: str, name: str = "table.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def field(at: Floats) -> Floats:
    return np.asarray(np.sin(at[:, 0]) + np.cos(0.7 * at[:, 1]) * np.sin(0.3 * at[:, 0]) + 0.2 * at[:, 2])


def scattered(n: int, noise: float = 0.0, dimensions: int = 2, seed: int = 1) -> Samples:
    random = np.random.default_rng(seed)
    at = np.zeros((n, 3))
    at[:, :dimensions] = random.uniform(0, 10, (n, dimensions))
    none = np.zeros(0, np.int64)
    grid = Unstructured(at, np.zeros(1, np.int64), none, none)
    accuracy = Accuracy((deviation("Sounder", noise, n),)) if noise else Accuracy()
    return Samples(grid=grid, values=field(at) + noise * random.standard_normal(n), accuracy=accuracy, name="depth")


# --- reading -----------------------------------------------------------------------------------------------------


def test_a_survey_brings_its_errors_along(tmp_path: Path) -> None:
    rows = "S1,10.0,20.0,3.51,0.2\nS2,14.5,22.0,3.7,0.1\nS3,12.0,29.0,,0.1\nS4,15.0,25.0,4.25,0.3\n"
    path = written(tmp_path, "station,Easting [m],Northing [m],depth [ft],depth_std\n" + rows)
    assert peek(path)["names"] == ("Easting", "Northing", "depth", "depth_std")
    read = points(path=path)
    assert (read.name, read.unit, read.grid.frame.units[0]) == ("depth", "ft", "m")
    assert read.values.tolist() == [3.51, 3.7, 4.25] and read.grid.points()[1].tolist() == [14.5, 22.0, 0.0]
    digits, stated = read.accuracy.terms
    assert digits.error().tolist() == [0.005, 0.05, 0.005] and digits.source.rigour == "proven"
    assert stated.error().tolist() == [0.2, 0.1, 0.3] and not read.accuracy.missing
    alone = points(path=written(tmp_path, "x y depth\n1 2 3\n4 5 6\n", "alone.txt"))
    assert [m.name for m in alone.accuracy.missing] == ["Measurement error"]


def test_degrees_become_metres_and_coarse_coordinates_are_told(tmp_path: Path) -> None:
    rows = "".join(f"{8 + i / 10:.1f},{47 + j / 10:.1f},{i * j}\n" for i in range(5) for j in range(5))
    read = points(path=written(tmp_path, "lon,lat,value\n" + rows))
    assert read.grid.frame.units[:2] == ("m", "m") and 30000 < read.grid.bounds[1] < 31000
    assert {f.name for f in read.accuracy.flags} == {"local plane", "coarse coordinates"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("# nothing\n", "no line of numbers"),
        ("x,y\n1,2\n", "coordinates x, y and a value"),
        ("x,y,v\n1,2,3\n4,5\n", "line 3: there are 2"),
        ("x,y,v\n1,2,3\n4,five,6\n7,8,9\n1,1,1\n", "line 3, column 2: 'five' is not a number"),
        ("x,y,v\n1,2,3\n,5,6\n7,8,9\n1,1,1\n", "line 3: a point has no x or no y"),
        ("x,y,v\n1,2,\n4,5,\n", "has no value in its column"),
        ("x,y,v,v_std\n1,2,3,-1\n4,5,6,1\n", "negative sizes"),
        ("a,b\nred,blue\n", "no line of numbers|words only"),
    ],
)
def test_a_wrong_table_is_told_in_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        points(path=written(tmp_path, text))


def test_a_column_that_is_not_there_names_the_nearest(tmp_path: Path) -> None:
    path = written(tmp_path, "x,y,depth\n1,2,3\n4,5,6\n")
    with pytest.raises(ValueError, match=r"no column 'deepth'.*nearest is 'depth'"):
        points(path=path, name="deepth")


def test_a_table_keeps_what_its_columns_state(tmp_path: Path) -> None:
    read = table(path=written(tmp_path, "t [s];speed [m/s];speed_lo;speed_hi;who\n0;1,5;1,0;2,5;Ada\n1;2,25;2;2,5;Bob\n"))
    assert list(read.columns) == ["t", "speed"] and read.units == {"t": "s", "speed": "m/s"}
    speed = [t for t in read.accuracy.terms if t.quantity == "speed"]
    assert [t.error().tolist() for t in speed] == [[0.05, 0.005], [1.0, 0.25]]
    assert "none of t" in read.accuracy.missing[0].reason


# --- triangles ---------------------------------------------------------------------------------------------------


def test_triangles_carry_a_model_whose_contour_is_exact() -> None:
    whole = triangulate(scattered(200, 0.1))
    assert isinstance(whole.grid, Unstructured) and whole.grid.cells > 300
    assert np.allclose(whole.accuracy.terms[0].error(), 0.1)
    lines = contour(Model.between(whole), Progress(), levels=(0.5,))
    assert len(lines.points) > 20
    few = triangulate(scattered(200, 0.1), longest=1.0)
    assert few.grid.cells < whole.grid.cells
    with pytest.raises(ValueError, match=r"longer than 0\.001"):
        triangulate(scattered(200), longest=0.001)
    space = triangulate(scattered(60, dimensions=3))
    assert set(np.asarray(space.grid.types)) == {10}  # type: ignore[attr-defined]  # tetrahedra


def test_samples_at_one_place_are_averaged_and_told() -> None:
    one = scattered(30, 0.2)
    nodes = one.grid.points().copy()
    nodes[1] = nodes[0]
    none = np.zeros(0, np.int64)
    twice = Samples(grid=Unstructured(nodes, np.zeros(1, np.int64), none, none), values=one.values, accuracy=one.accuracy)
    joined = triangulate(twice)
    where = int(np.argmin(np.abs(joined.grid.points() - nodes[0]).sum(axis=1)))
    assert joined.grid.count == 29 and joined.values[where] == pytest.approx((one.values[0] + one.values[1]) / 2)
    assert joined.accuracy.terms[0].error()[where] == pytest.approx(0.2 / np.sqrt(2))
    assert "1 samples lay" in joined.accuracy.flags[0].words


# --- grids -------------------------------------------------------------------------------------------------------


def test_a_spline_is_that_of_scipy() -> None:
    from scipy.interpolate import RBFInterpolator

    for dimensions in (2, 3):
        given = scattered(150, dimensions=dimensions)
        made = grid_points(given, Progress(), method="spline", neighbours=20, samples=(12,))
        at = given.grid.points()[:, :dimensions]
        other = RBFInterpolator(at, given.values, neighbors=20, kernel="thin_plate_spline")(made.grid.points()[:, :dimensions])
        there = np.isfinite(made.values.ravel())
        assert np.abs(made.values.ravel() - other)[there].max() < 1e-11


def test_kriging_is_the_best_linear_guess() -> None:
    """Against the textbook's system of all points, solved once; no other weights of sum one have less variance."""
    from modules.modellers._scattered import Variogram, kriging

    given = scattered(20, 0.3)
    at, law = given.grid.points()[:, :2], Variogram("exponential", 6.0, 2.0, 0.3)
    place = np.array([[4.2, 5.1]])
    found = kriging(at, place, 20, law, np.full(20, 0.09))
    order = np.argsort(found.index[0])
    weight = found.weight[0][order]
    apart = np.linalg.norm(at[:, None] - at[None], axis=2)
    shared = 2.0 * np.exp(-apart / 2.0) + np.diag(np.full(20, 0.3))
    cross = 2.0 * np.exp(-np.linalg.norm(at - place, axis=1) / 2.0)

    def variance(w: Floats, noise: float) -> float:
        return float(2.3 - 2 * w @ cross + w @ (shared + noise * np.eye(20)) @ w)

    assert weight.sum() == pytest.approx(1)
    assert found.variance[0] == pytest.approx(variance(weight, 0.0), rel=1e-6)
    random = np.random.default_rng(0)
    for _ in range(50):
        other = random.standard_normal(20)
        assert variance(weight + 0.01 * (other - other.mean()), 0.09) > variance(weight, 0.09)


@pytest.mark.parametrize("method", ["linear", "nearest", "spline", "kriging"])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_errors_are_about_as_large_as_stated(method: Method, noise: float) -> None:
    """The known field less what is given, over what is stated: not far below one, and never far above."""
    ratios = []
    for seed in range(4):
        made = grid_points(scattered(300, noise, seed=seed), Progress(), method=method, samples=(30,))
        error = made.values.ravel() - field(made.grid.points())
        there = np.isfinite(error)
        ratios.append(np.sqrt(np.mean((error / made.accuracy.total(1, "value"))[there] ** 2)))
    assert 0.2 < np.median(ratios) < 1.35, ratios


def test_the_lake_is_as_deep_as_its_errors_say(tmp_path: Path) -> None:
    script = runpy.run_path(str(ROOT / "resources" / "data" / "soundings.py"))
    script["write"](tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == LAKE.read_bytes()
    made = grid_points(points(path=LAKE), Progress(), samples=(60,))
    at = made.grid.points()
    error = made.values.ravel() - script["truth"](at[:, 0], at[:, 1])
    there = np.isfinite(error)
    inside = np.abs(error[there]) < made.accuracy.total(2, "value")[there]
    assert 0.92 < inside.mean() <= 0.995
    assert there.mean() > 0.85 and np.isfinite(grid_points(points(path=LAKE), Progress(), extrapolate=True).values).all()
    assert np.isfinite(contour(interpolate(made), Progress(), interval=2.0).points).all()


def test_what_cannot_be_gridded_is_told() -> None:
    line = scattered(20)
    nodes = line.grid.points().copy()
    nodes[:, 1] = 2 * nodes[:, 0]
    none = np.zeros(0, np.int64)
    flat = Unstructured(nodes, np.zeros(1, np.int64), none, none)
    with pytest.raises(ValueError, match="on a line"):
        grid_points(Samples(grid=flat, values=line.values, accuracy=Accuracy()), Progress())
    with pytest.raises(ValueError, match="the same"):
        grid_points(Samples(grid=line.grid, values=0 * line.values, accuracy=Accuracy()), Progress())
    with pytest.raises(ValueError, match="too many"):
        grid_points(scattered(20), Progress(), samples=(20000, 20000))
