"""Elevation maps from the files that people have: values, places, units, and what is known of their errors."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import pyvista as pv
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from modules.api import Accuracy, Rectilinear, Regular, Samples
from modules.data.exchange import save
from modules.declare import record_of
from modules.modellers.state_accuracy import state_accuracy
from modules.readers._files import ReadError
from modules.readers._place import metres_per_degree
from modules.readers.dataset import dataset
from modules.readers.elevation import FORMATS, companions, elevation, peek
from modules.readers.shapes import shapes

SAMPLE = Path(matplotlib.__file__).parent / "mpl-data" / "sample_data"
JACKSBORO, TOPOBATHY = SAMPLE / "jacksboro_fault_dem.npz", SAMPLE / "topobathy.npz"
SHARED = Path(__file__).parents[3] / "shared" / "data"
HELENS = SHARED / "SainteHelens.dem"
needs_helens = pytest.mark.skipif(not HELENS.is_file(), reason="the elevation model of Mount St. Helens is not here")
needs_office = pytest.mark.skipif(not (SHARED / "office.binary.vtk").is_file(), reason="the office data set is not here")
RNG = np.random.default_rng(5)


def quantisation(samples: Samples) -> Any:
    return next(t for t in samples.accuracy.terms if t.id.endswith("/quantisation"))


def flag(samples: Samples, name: str) -> str:
    return next((f.words for f in samples.accuracy.flags if f.name == name), "")


# --- longitude and latitude --------------------------------------------------------------------------------------


def test_jacksboro_lies_north_up_in_metres() -> None:
    samples, stored = elevation(path=JACKSBORO), np.load(JACKSBORO)
    assert isinstance(samples.grid, Regular)
    np.testing.assert_array_equal(samples.values, stored["elevation"][::-1])
    east, north = metres_per_degree((36.73291667 + 36.44625) / 2)
    assert samples.grid.spacing == pytest.approx((east / 1200, north / 1200), rel=1e-6)
    assert samples.grid.frame.units[:2] == ("m", "m") and "WGS 84" in samples.grid.frame.crs
    assert "0.18%" in flag(samples, "local plane") and "degrees" in flag(samples, "assumed")


def test_topobathy_is_rectilinear() -> None:
    samples, stored = elevation(path=TOPOBATHY), np.load(TOPOBATHY)
    assert isinstance(samples.grid, Rectilinear) and "assumed" not in [f.name for f in samples.accuracy.flags]
    np.testing.assert_array_equal(samples.values, stored["topo"])
    assert samples.grid.axes[1][-1] == pytest.approx((49.98418 - 48.01637) * 111209.7, rel=1e-4)
    assert "multiples of 1" in flag(samples, "rounded before")


@pytest.mark.parametrize("latitude", [0.0, 36.6, 60.0, -45.0, 89.0])
def test_metres_per_degree_agree_with_the_ellipsoid(latitude: float) -> None:
    a, e2 = 6378137.0, 6.69437999014e-3
    p = np.deg2rad(latitude)
    w = 1 - e2 * np.sin(p) ** 2
    wanted = np.deg2rad(1.0) * a * np.cos(p) / np.sqrt(w), np.deg2rad(1.0) * a * (1 - e2) / w**1.5
    assert metres_per_degree(latitude) == pytest.approx(wanted, rel=1e-5)


def test_lengths_override_what_was_assumed() -> None:
    samples = elevation(path=JACKSBORO, lengths="m")
    assert samples.grid.bounds[0] == pytest.approx(-84.41333, abs=1e-4) and not flag(samples, "local plane")


# --- rounding and identity ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "half"), [
    ("u1", 0.5), ("i2", 0.5), (">i4", 0.5), ("?", 0.5), ("f2", 0.03125), ("f4", 2.0**-18), (">f4", 2.0**-18), ("f8", 2.0**-47),
])  # fmt: skip
def test_rounding_of_stored_numbers_is_a_proven_bound(kind: str, half: float, tmp_path: Path) -> None:
    values = np.full((3, 4), 100).astype(kind)
    np.save(tmp_path / "a.npy", values)
    samples = elevation(path=tmp_path / "a.npy")
    term = quantisation(samples)
    assert term.source.rigour == "proven" and term.kind == "bound" and term.value.ndim == 0
    assert float(term.value) == pytest.approx(half if kind != "?" else 0.5)
    assert [m.reason for m in samples.accuracy.missing] == ["the file states none"]


@given(st.floats(-1e4, 1e4, width=64), st.sampled_from(["f2", "f4"]))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_number_is_rounded_by_more_than_the_bound(tmp_path: Path, value: float, kind: str) -> None:
    truth = np.array([[value, value / 3], [value / 7, -value]])
    np.save(tmp_path / "a.npy", truth.astype(kind))
    samples = elevation(path=tmp_path / "a.npy")
    assert (np.abs(samples.values - truth).ravel() <= quantisation(samples).error()).all()


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("stride", [1, 2, 5])
def test_stride_keeps_the_identity_of_the_samples(tmp_path: Path, order: Any, stride: int) -> None:
    values = np.asarray(RNG.normal(size=(23, 37)).astype(">f4"), order=order)
    np.save(tmp_path / "a.npy", values)
    whole, thin = elevation(path=tmp_path / "a.npy"), elevation(path=tmp_path / "a.npy", stride=stride)
    np.testing.assert_array_equal(thin.values, values[::stride, ::stride])
    assert isinstance(thin.grid, Regular) and thin.grid.spacing == (float(stride), float(stride))
    a, b = quantisation(whole), quantisation(thin)
    assert a.id == b.id and a.value == b.value and b.operator.shape == (thin.grid.count, 23 * 37)
    picked = np.asarray(b.operator.rows(np.arange(thin.grid.count)).todense()).argmax(axis=1)
    np.testing.assert_array_equal(whole.values.ravel()[picked], thin.values.ravel())


@pytest.mark.parametrize("rows", ["north first", "south first"])
def test_rows_turned_by_hand_keep_the_identity(rows: Any, tmp_path: Path) -> None:
    Image.fromarray(RNG.integers(0, 255, (5, 7)).astype(np.uint8)).save(tmp_path / "a.png")
    natural, turned = elevation(path=tmp_path / "a.png"), elevation(path=tmp_path / "a.png", rows=rows, stride=2)
    picked = np.asarray(quantisation(turned).operator.rows(np.arange(12)).todense()).argmax(axis=1)
    np.testing.assert_array_equal(natural.values.ravel()[picked], turned.values.ravel())


def test_the_same_content_under_another_name_is_the_same_source(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        (tmp_path / name).write_bytes(JACKSBORO.read_bytes())
    a, b = (elevation(path=tmp_path / n) for n in ("a.npz", "b.npz"))
    assert quantisation(a).id == quantisation(b).id == quantisation(elevation(path=JACKSBORO)).id


def test_scale_reaches_the_budget(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(12, dtype=np.uint16).reshape(3, 4))
    samples = elevation(path=tmp_path / "a.npy", scale=-0.1, offset=100.0, unit="m", stride=2)
    np.testing.assert_allclose(samples.values, 100 - 0.1 * np.arange(12).reshape(3, 4)[::2, ::2])
    np.testing.assert_allclose(quantisation(samples).error(), 0.05)
    assert quantisation(samples).unit == samples.unit == "m"


def test_an_array_of_deviations_beside_the_map_is_picked_up(tmp_path: Path) -> None:
    sizes = RNG.uniform(0, 1, (3, 4))
    np.savez(tmp_path / "a.npz", z=RNG.normal(size=(3, 4)), z_std=sizes, x=np.arange(4.0), y=np.arange(3.0)[::-1])
    samples = elevation(path=tmp_path / "a.npz")
    assert samples.name == "z" and not samples.accuracy.missing
    np.testing.assert_array_equal(samples.accuracy.terms[1].error().reshape(3, 4), sizes[::-1])


# --- USGS elevation models ---------------------------------------------------------------------------------------


@needs_helens
def test_mount_st_helens_has_the_heights_that_vtk_reads() -> None:
    """Every profile holds VTK's heights; VTK counts rows from the border of the quadrangle, a slanted line."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkDEMReader

    samples = elevation(path=HELENS)
    other = vtkDEMReader()
    other.SetFileName(str(HELENS))
    other.Update()
    nx, ny, _ = other.GetOutput().GetDimensions()
    theirs = vtk_to_numpy(other.GetOutput().GetPointData().GetScalars()).reshape(ny, nx)
    assert samples.values.shape[1] == nx == 327
    assert np.nanmin(samples.values) == 682 and np.nanmax(samples.values) == 2543
    for mine, column in zip(samples.values.T[5:], theirs.T[5:], strict=True):
        heights = mine[np.isfinite(mine)]
        starts = [s for s in range(ny - len(heights) + 1) if np.array_equal(column[s : s + len(heights)], heights)]
        assert starts, "a profile has other heights"
    inner = slice(10, -10)
    mine, rough = (np.nanmean(np.abs(np.diff(v[inner, inner], axis=1))) for v in (samples.values, theirs))
    assert mine < rough, "profiles at their own coordinates join more smoothly than in VTK"


@needs_helens
def test_mount_st_helens_states_its_errors() -> None:
    samples = elevation(path=HELENS)
    assert samples.unit == "m" and isinstance(samples.grid, Regular)
    assert samples.grid.spacing == (30.0, 30.0) and samples.grid.origin == (557820.0, 5108010.0)
    assert "UTM zone 10" in samples.grid.frame.crs and not samples.accuracy.missing
    terms = {t.id.rsplit("/", 1)[1]: t for t in samples.accuracy.terms}
    assert set(terms) == {"quantisation", "datum-z", "datum-xy", "model-z", "model-xy"}
    few = np.arange(0, samples.grid.count, 97)
    for name, size in (("quantisation", 0.5), ("datum-z", 3.0), ("model-z", 3.0)):
        np.testing.assert_array_equal(terms[name].error(few), size)
    slope = np.hypot(*np.gradient(samples.values, 30.0)).ravel()[few]
    known = np.isfinite(slope)
    np.testing.assert_allclose(terms["datum-xy"].error(few)[known], 3.0 * slope[known], atol=0.3)
    np.testing.assert_allclose(terms["model-xy"].error(few)[known], 1.0 * slope[known], atol=0.1)
    assert "from 20 points" in terms["model-z"].source.rule and "common to all heights" in terms["datum-z"].source.rule
    assert terms["datum-z"].operator.shape == (samples.grid.count, 1)
    assert peek(HELENS)["range"] == (682.0, 2543.0)


def dem(
    heights: list[list[int]], starts: list[float], *, plane: int = 2, height: int = 2, step: float = 1.0, c: str = ""
) -> bytes:
    """A USGS elevation model of a few profiles."""

    def real(v: float, w: int = 24) -> str:
        return f"{v:{w}.{15 if w == 24 else 6}E}".replace("E", "D" if w == 24 else "E")

    spacing = 3.0 if plane == 3 else 10.0
    head = f"{'A SMALL MAP':<144}" + "     1     1" + f"{0 if plane == 3 else 1:6d}{12:6d}" + real(0.0) * 15
    head = f"{head:<528}{plane:6d}{height:6d}     4" + real(0.0) * 8 + real(1.0) + real(99.0) + real(0.0)
    head += f"{int(bool(c)):6d}" + real(spacing, 12) * 2 + real(step, 12) + f"{1:6d}{len(heights):6d}"
    out = f"{head:<1024}"
    for j, (column, start) in enumerate(zip(heights, starts, strict=True)):
        top = f"{1:6d}{j + 1:6d}{len(column):6d}{1:6d}" + real(1000 + spacing * j) + real(start) + real(0.0) + real(0) * 2
        out += f"{top + ''.join(f'{v:6d}' for v in column[:146]):<1024}"
        for k in range(146, len(column), 170):
            out += f"{''.join(f'{v:6d}' for v in column[k : k + 170]):<1024}"
    return (out + (f"{c:<1024}" if c else "")).encode()


def test_profiles_of_different_length_leave_holes(tmp_path: Path) -> None:
    (tmp_path / "a.dem").write_bytes(dem([[1, 2, 3], [4, -32767], list(range(400))], [2000.0, 2010.0, 2000.0], step=0.5))
    samples = elevation(path=tmp_path / "a.dem", stride=1)
    np.testing.assert_array_equal(samples.values[:4, 0], [0.5, 1.0, 1.5, np.nan])
    np.testing.assert_array_equal(samples.values[:4, 1], [np.nan, 2.0, np.nan, np.nan])
    np.testing.assert_array_equal(samples.values[:, 2], 0.5 * np.arange(400))
    assert float(quantisation(samples).value) == 0.25 and samples.accuracy.missing
    thin = elevation(path=tmp_path / "a.dem", stride=2)
    np.testing.assert_array_equal(thin.values, samples.values[::2, ::2])


def test_feet_and_arc_seconds(tmp_path: Path) -> None:
    c = "".join(f"{v:6d}" for v in (0, 0, 0, 0, 0, 1, 0, 0, 7, 30))
    starts = [36.0 * 3600] * 3
    (tmp_path / "a.dem").write_bytes(dem([[1, 2, 3]] * 3, starts, plane=3, height=1, c=c))
    samples = elevation(path=tmp_path / "a.dem")
    assert samples.unit == "ft" and samples.grid.frame.units[0] == "m" and flag(samples, "local plane")
    assert samples.grid.bounds[3] == pytest.approx(6 / 3600 * metres_per_degree(36.0)[1], rel=1e-4)
    assert [t.name for t in samples.accuracy.terms][1:] == ["Height of the elevation model", "Place of the elevation model"]
    with pytest.raises(ReadError, match="states unit in 'ft'"):
        elevation(path=tmp_path / "a.dem", unit="m")


def test_a_damaged_record_of_accuracy_is_refused(tmp_path: Path) -> None:
    for c in ("     1     x", "     1    -3"):
        (tmp_path / "a.dem").write_bytes(dem([[1, 2, 3]] * 3, [0.0] * 3, c=c))
        with pytest.raises(ReadError, match=r"record C of 'a\.dem'.*is damaged"):
            elevation(path=tmp_path / "a.dem")


@pytest.mark.parametrize(("change", "sentence"), [
    (lambda b: b[:2100], "ends early or is damaged in profile 2 of 3"),
    (lambda b: b"\0" * 2000, "does not begin as an elevation model"),
    (lambda b: b.replace(b"     2     3", b"     x     3"), "does not begin|damaged"),
])  # fmt: skip
def test_a_damaged_elevation_model_is_refused(change: Any, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "a.dem").write_bytes(change(dem([[1, 2, 3]] * 3, [0.0] * 3)))
    with pytest.raises(ReadError, match=sentence):
        elevation(path=tmp_path / "a.dem")


# --- pictures ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ending", "kind"), [("png", "u1"), ("png", "u2"), ("tif", "u1"), ("tif", "u2"), ("tif", "i4"), ("tif", "f4")]
)
def test_grey_pictures(ending: str, kind: str, tmp_path: Path) -> None:
    values = (RNG.uniform(0, 250, (6, 9)) * (200 if kind in ("u2", "i4") else 1)).astype(kind)
    path = tmp_path / f"a.{ending}"
    Image.fromarray(values).save(path)
    samples = elevation(path=path)
    np.testing.assert_array_equal(samples.values, values[::-1])
    assert "north edge" in flag(samples, "assumed") and "1 apart" in flag(samples, "assumed")
    assert peek(path)["shape"] == (6, 9)
    half = 0.5 if kind != "f4" else np.spacing(values.max()) / 2
    assert quantisation(samples).error(np.array([0]))[0] == half


def test_a_world_file_says_where_a_picture_lies(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    Image.fromarray(RNG.integers(0, 255, (6, 9)).astype(np.uint8)).save(path)
    assert companions(path) == []
    (tmp_path / "a.pgw").write_text("2.5\n0.0\n0.0\n-5\n1000.25\n2000\n")
    samples = elevation(path=path, lengths="m")
    assert samples.grid.bounds[:4] == (1000.25, 1020.25, 1975.0, 2000.0) and not flag(samples, "assumed")
    assert companions(path) == [tmp_path / "a.pgw"] == list(record_of(elevation).companions(path))  # type: ignore[misc]  # it has one
    (tmp_path / "a.pgw").write_text("2.5\n0.1\n0.1\n-5\n0\n0\n")
    with pytest.raises(ReadError, match=r"'a\.pgw' turns the picture"):
        elevation(path=path)
    (tmp_path / "a.pgw").write_text("2.5 oops")
    with pytest.raises(ReadError, match="should hold six numbers"):
        elevation(path=path)


def test_geotiff_tags_are_read(tmp_path: Path) -> None:
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    tags = ImageFileDirectory_v2()
    for tag, kind, value in (
        (33550, 12, (10.0, 20.0, 0.0)), (33922, 12, (0.0, 0.0, 0.0, 500.0, 900.0, 0.0)),
        (34735, 3, (1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32610, 3076, 0, 1, 9001)), (42113, 2, "-1"),
    ):  # fmt: skip
        tags.tagtype[tag] = kind
        tags[tag] = value
    values = np.arange(12, dtype=np.float32).reshape(3, 4) - 1
    Image.fromarray(values).save(tmp_path / "a.tif", tiffinfo=tags)
    samples = elevation(path=tmp_path / "a.tif")
    assert samples.grid.bounds[:4] == (505.0, 535.0, 850.0, 890.0)
    assert samples.grid.frame.crs == "EPSG:32610" and samples.grid.frame.units[0] == "m"
    assert np.isnan(samples.values[2, 0]) and np.isnan(samples.values).sum() == 1


def test_a_grey_picture_stored_in_colours_is_read_and_a_coloured_one_refused(tmp_path: Path) -> None:
    grey = RNG.integers(0, 255, (5, 6)).astype(np.uint8)
    pixels = np.stack([grey] * 3 + [np.full_like(grey, 255)], axis=-1)
    pixels[0, 0, 3] = 0
    Image.fromarray(pixels).save(tmp_path / "a.png")
    samples = elevation(path=tmp_path / "a.png")
    assert np.isnan(samples.values[-1, 0]) and np.isfinite(samples.values).sum() == 29
    pixels[2, 2, 0] ^= 9
    Image.fromarray(pixels).save(tmp_path / "a.png")
    with pytest.raises(ReadError, match="colour picture"):
        elevation(path=tmp_path / "a.png")


def test_jpg_says_that_it_lost_something(tmp_path: Path) -> None:
    Image.fromarray(RNG.integers(0, 255, (16, 16)).astype(np.uint8)).save(tmp_path / "a.jpg")
    assert "Compression error" in [m.name for m in elevation(path=tmp_path / "a.jpg").accuracy.missing]


# --- text --------------------------------------------------------------------------------------------------------


@given(
    st.lists(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4), min_size=1, max_size=5), st.integers(0, 6),
    st.sampled_from([",", ";", "\t", "  "]),
)  # fmt: skip
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_number_in_a_text_is_off_by_more_than_its_last_digit(
    tmp_path: Path, rows: list[list[float]], digits: int, cut: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(cut.join(f"{v:.{digits}f}" for v in row) for row in rows))
    samples = elevation(path=path)
    error = quantisation(samples).error().reshape(len(rows), 4)
    assert (np.abs(samples.values - np.array(rows)) <= error * (1 + 1e-9) + 1e-9).all()
    np.testing.assert_allclose(error, 0.5 * 10.0**-digits, rtol=1e-3)


@pytest.mark.parametrize("text", [
    "1,2.5,3\n4,5,6\n",
    "# a map\n1;2.5;3\r\n4;5;6\r\n", "1\t2.5\t3\n4\t5\t6", " 1  2.5 3 \n\n 4 5   6\n", "a,b,c\n1,2.5,3\n4,5,6",
    "1,2.5,3,\n4,5,6,\n", "1;2,5;3\n4;5;6", '"1","2.5","3"\n"4","5","6"', "\ufeff1,2.5,3\n4,5,6", "1,25e-1,3\n4,5,0.6e1",
])  # fmt: skip
def test_a_matrix_of_numbers_in_many_spellings(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    samples = elevation(path=tmp_path / "a.csv")
    np.testing.assert_array_equal(samples.values, [[1, 2.5, 3], [4, 5, 6]])
    (tmp_path / "b.csv").write_bytes(text.encode("utf-16"))
    if not text.startswith("\ufeff"):
        np.testing.assert_array_equal(elevation(path=tmp_path / "b.csv").values, samples.values)


def test_each_printed_digit_counts(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("1,2.50\n1e2,nan\n")
    np.testing.assert_allclose(quantisation(elevation(path=tmp_path / "a.csv")).error(), [0.5, 0.005, 50.0, 0.0])


@pytest.mark.parametrize("rows", ["automatic", "north first"])
@pytest.mark.parametrize("stride", [1, 2])
def test_digits_stay_with_their_numbers(rows: Any, stride: int, tmp_path: Path) -> None:
    words = [["1", "2.5", "3.25"], ["4.125", "5", "6.5"], ["7.5", "8", "9.125"]]
    (tmp_path / "a.csv").write_text("\n".join(",".join(row) for row in words))
    samples = elevation(path=tmp_path / "a.csv", rows=rows, stride=stride)
    halves = {float(w): 0.5 * 10.0 ** -len(w.partition(".")[2]) for row in words for w in row}
    np.testing.assert_allclose(quantisation(samples).error(), [halves[v] for v in samples.values.ravel()])


def test_columns_that_fill_a_lattice(tmp_path: Path) -> None:
    x, y = np.array([10.0, 11.0, 13.0]), np.array([5.0, 4.0])
    points = [(a, b) for b in y for a in x]
    lines = [f"{a},{b},{a * b:.1f},{a - b:.2f}" for a, b in points]
    path = tmp_path / "a.csv"
    path.write_text("x,y,depth,speed\n" + "\n".join(lines))
    samples = elevation(path=path, name="speed")
    assert isinstance(samples.grid, Rectilinear) and samples.name == "speed"
    np.testing.assert_allclose(samples.values, [[6, 7, 9], [5, 6, 8]])
    assert peek(path)["names"] == ("depth", "speed")
    path.write_text("x,y,depth,speed\n" + "\n".join(lines[:-1]))
    assert np.isnan(elevation(path=path).values).sum() == 1
    path.write_text("\n".join(",".join(line.split(",")[:3]) for line in lines))
    np.testing.assert_allclose(elevation(path=path).values, [[40, 44, 52], [50, 55, 65]])


def test_longitude_and_latitude_in_columns(tmp_path: Path) -> None:
    rows = [f"{lon},{lat},{lon + lat}" for lat in (40.0, 40.1, 40.2) for lon in (8.0, 8.1)]
    (tmp_path / "a.csv").write_text("lon,lat,z\n" + "\n".join(rows))
    samples = elevation(path=tmp_path / "a.csv")
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == pytest.approx(
        tuple(0.1 * m for m in metres_per_degree(40.1)), rel=1e-6
    )


def test_an_esri_grid(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    path.write_text("ncols 3\nNROWS 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6\n")
    samples = elevation(path=path)
    assert samples.grid.bounds[:4] == (105.0, 125.0, 205.0, 215.0)
    np.testing.assert_array_equal(samples.values, [[4, np.nan, 6], [1, 2, 3]])
    path.write_text("ncols 4\nnrows 2\ncellsize 10\n1 2 3\n4 -1 6\n")
    with pytest.raises(ReadError, match="says it has 2 rows and 4 columns"):
        elevation(path=path)


@pytest.mark.parametrize(("text", "sentence"), [
    ("1,2\n3,x4\n", "line 2, column 2: 'x4' is not a number"),
    ("# c\n\n1,2\n3,4,5\n", "line 4: there are 3 numbers; the lines before have 2"),
    ("# nothing\n", "holds no line of numbers"),
    ("a,b\n", "holds no line of numbers"),
    ("nan,nan\nnan,nan\n", "no value at all"),
    ("1,inf\n2,3\n", "infinite"),
    ("x,y,z\n0,0,1\n1,1,2\n2,5,3\n3,7,4\n4,9,1", "do not fill a lattice"),
    ("x,y,z\n0,0,1\n1,0,2\n0,0,3\n1,1,4", "line 4: this point occurs twice"),
    ("x,y,z\n0,0,1\n1,,2\n0,1,3\n1,1,4", "line 3: a point has no x or y"),
])  # fmt: skip
def test_text_that_is_no_map_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(ReadError, match=sentence):
        elevation(path=tmp_path / "a.csv")


# --- VTK files ---------------------------------------------------------------------------------------------------


def test_a_budget_comes_along_in_a_vtk_file(tmp_path: Path) -> None:
    samples = state_accuracy(elevation(path=JACKSBORO, stride=8), amount=3.0, who="the survey")
    save(samples, tmp_path / "a.vti")
    again = elevation(path=tmp_path / "a.vti")
    assert [t.id for t in again.accuracy.terms] == [t.id for t in samples.accuracy.terms]
    joined = Accuracy.join([(again.accuracy, None), (samples.accuracy, None)])
    assert len(joined.terms) == len(samples.accuracy.terms)
    thin = elevation(path=tmp_path / "a.vti", stride=3, scale=2.0)
    np.testing.assert_array_equal(thin.values, 2 * samples.values[::3, ::3])
    np.testing.assert_allclose(thin.accuracy.terms[-1].error(), 6.0)
    assert peek(tmp_path / "a.vti") == {"names": ("elevation",), "shape": samples.grid.shape}
    with pytest.raises(ReadError, match="has no array 'elevatoin'; the nearest is 'elevation'"):
        elevation(path=tmp_path / "a.vti", name="elevatoin")
    with pytest.raises(ReadError, match="states where its samples lie"):
        elevation(path=tmp_path / "a.vti", rows="north first")


@needs_office
def test_the_office_is_read_with_its_vectors() -> None:
    samples = dataset(path=SHARED / "office.binary.vtk", name="vectors")
    assert samples.values.shape == (20, 20, 21, 3) and samples.grid.kind == "curvilinear"
    assert quantisation(samples).components == 3 and samples.accuracy.missing
    with pytest.raises(ReadError, match="is no map of heights"):
        elevation(path=SHARED / "office.binary.vtk")


def test_shapes_and_samples_are_told_apart(tmp_path: Path) -> None:
    pv.Sphere().save(tmp_path / "a.vtp")
    assert len(shapes(path=tmp_path / "a.vtp").polygons) == 1680
    pv.Sphere().save(tmp_path / "a.vtk")
    with pytest.raises(ReadError, match="holds shapes, not samples"):
        dataset(path=tmp_path / "a.vtk")
    save(elevation(path=JACKSBORO, stride=16), tmp_path / "b.vti")
    with pytest.raises(ReadError, match=r"files that end in '\.vti' are not read here"):
        shapes(path=tmp_path / "b.vti")


# --- files that cannot be read -----------------------------------------------------------------------------------


def npy_header(shape: str, kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    text += " " * (117 - len(text)) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def write(path: Path, name: str, content: Any) -> Path:
    path = path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif path.suffix == ".npz":
        np.savez(path, **content)
    else:
        np.save(path, content)
    return path


def test_a_changed_byte_inside_a_zip_is_noticed(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", z=np.arange(100.0).reshape(10, 10))
    data = bytearray((tmp_path / "a.npz").read_bytes())
    data[500] ^= 1
    (tmp_path / "a.npz").write_bytes(data)
    with pytest.raises(ReadError, match="Bad CRC-32"):
        elevation(path=tmp_path / "a.npz")


def test_no_damage_makes_another_error_than_one_sentence(tmp_path: Path) -> None:
    """Bytes changed, cut off or taken out at random, seed fixed."""
    rng = np.random.default_rng(8)
    values = RNG.normal(100, 50, (7, 9))
    Image.fromarray(values.astype(np.uint8)).save(tmp_path / "a.png")
    np.savez_compressed(tmp_path / "a.npz", z=values.astype(np.int16), z_std=np.abs(values), xmin=0.0, xmax=1.0, ymin=0, ymax=1)
    np.save(tmp_path / "a.npy", values)
    (tmp_path / "a.csv").write_text("\n".join(",".join(f"{v:.2f}" for v in row) for row in values))
    (tmp_path / "a.dem").write_bytes(dem([[1, 2, 3] * 3] * 3, [0.0] * 3, c=f"{1:6d}{3:6d}{3:6d}{3:6d}"))
    for path in sorted(tmp_path.iterdir()):
        whole = path.read_bytes()
        for _ in range(40):
            data = bytearray(whole[: rng.integers(1, len(whole))] if rng.random() < 0.2 else whole)
            for at in rng.integers(0, min(len(data), int(rng.choice((80, 500, 10**6)))), 3):
                data[at] = rng.integers(0, 256)
            path.write_bytes(data)
            peek(path)
            try:
                elevation(path=path)
            except ReadError as error:
                assert "\n" not in str(error) and path.name in str(error) and len(str(error)) < 300


@pytest.mark.parametrize(("name", "content", "sentence"), [
    ("a.npz", b"", "'a.npz' is empty"),
    ("a.npz", b"PK\x03\x04rubbish", "damaged or is not what its name says"),
    ("a.npz", JACKSBORO.read_bytes()[:9000], "damaged"),
    ("a.npy", npy_header("(4, 4)") + b"\0" * 40, "ends early, after 1 of the 4 rows"),
    ("a.npy", b"no array at all, just words", "damaged"),
    ("a.npy", npy_header("(900000, 9000000)"), r"900000 x 9000000 samples.*stride = \d+"),
    ("a.npy", npy_header("(4, 4)", "|O"), "Python objects"),
    ("a.npy", npy_header("(4, 4)", "<M8[s]"), "not numbers"),
    ("a.npy", np.array([["a", "b"]]), "not numbers"),
    ("a.npy", np.ones((3, 3), complex), "complex numbers"),
    ("a.npy", np.ones(5), r"has shape \(5,\); an elevation map has two axes"),
    ("a.npy", np.float64(3), "is a single number"),
    ("a.npy", np.ones((2, 3, 4)), "has two axes"),
    ("a.npy", np.ones((2, 3, 4, 5)), "has two axes"),
    ("a.npy", np.ones((0, 4)), "there is no sample in it"),
    ("a.npy", np.full((3, 3), np.nan), "no value at all"),
    ("a.npy", np.array([[1.0, np.inf]]), "infinite numbers"),
    ("a.npz", {"a": np.ones(3), "b": np.ones((2, 2, 2))}, "holds no map"),
    ("a.npz", {"z": np.ones((3, 3)), "z_std": -np.ones((3, 3))}, "should hold standard deviations"),
    ("a.dem", b"x" * 3000, "does not begin as an elevation model"),
    ("a.png", b"\x89PNG\r\n\x1a\nrubbish", "damaged"),
    ("a.png", b"not a picture", "damaged"),
    ("a.csv", b"\x00\x01\x02\xff\xfe\x00", "no text"),
    ("a.vti", b"<VTKFile", "a.vti"),
    ("a.xyz3", b"1 2 3", "files that end in '.xyz3' are not read here; this reads .npz"),
])  # fmt: skip
def test_bad_files_are_refused_with_one_sentence(
    name: str, content: Any, sentence: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, name, content)
    with pytest.raises(ReadError, match=sentence) as caught:
        elevation(path=path)
    assert repr(name) in str(caught.value) or name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert isinstance(peek(path), dict)


def test_pickles_are_never_opened(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([[{"run": "me"}]], dtype=object), allow_pickle=True)
    with pytest.raises(ReadError, match="Python objects"):
        elevation(path=tmp_path / "a.npy")


def test_a_missing_file_names_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "mountain.npz").write_bytes(b"x")
    with pytest.raises(ReadError, match=r"there is no file 'mountian\.npz'.*the nearest is 'mountain\.npz'"):
        elevation(path=tmp_path / "mountian.npz")
    with pytest.raises(ReadError, match="there is no folder 'maps'"):
        elevation(path=tmp_path / "maps" / "deep" / "a.npz")
    with pytest.raises(ReadError, match="is a folder"):
        elevation(path=tmp_path)
    with pytest.raises(ReadError, match="no file is chosen"):
        elevation()
    assert "no file" in peek(tmp_path / "none.npz")["problem"]


def test_an_unreadable_file_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import os

    np.save(tmp_path / "a.npy", np.ones((3, 3)))
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(ReadError, match=r"'a\.npy' may not be read by you"):
        elevation(path=tmp_path / "a.npy")


def test_names_of_arrays(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", one=np.ones((2, 2)), two=np.arange(9.0).reshape(3, 3), words=np.array(["a"]))
    samples = elevation(path=tmp_path / "a.npz")
    assert samples.name == "two" and "'two' is the map" in flag(samples, "assumed")
    assert elevation(path=tmp_path / "a.npz", name="one").values.shape == (2, 2)
    assert peek(tmp_path / "a.npz") == {"names": ("one", "two"), "shape": (3, 3)}
    with pytest.raises(ReadError, match="has no array 'tow'; the nearest is 'two'; it holds one, two, words"):
        elevation(path=tmp_path / "a.npz", name="tow")


def test_a_constant_map_is_read_and_says_so(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.full((3, 4), 7, np.int8))
    assert "all values are 7" in flag(elevation(path=tmp_path / "a.npy"), "constant")


def test_holes_and_settings(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([[1, -99, 3], [4, 5, 6]], np.int16))
    samples = elevation(path=tmp_path / "a.npy", no_data=-99, spacing=(2, 3), lengths="km", unit="m", rows="north first")
    np.testing.assert_array_equal(samples.values, [[4, 5, 6], [1, np.nan, 3]])
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == (2.0, 3.0)
    assert samples.grid.frame.length_unit(2) == "km" and samples.unit == "m" and not flag(samples, "assumed")
    for wrong in ({"stride": 0}, {"spacing": (0.0, 1.0)}, {"scale": 0.0}, {"offset": float("inf")}):
        with pytest.raises(ReadError):
            elevation(path=tmp_path / "a.npy", **wrong)


@pytest.mark.parametrize("axes", [
    {"x": np.array([1.0, 2.0, 3.0]), "y": np.array([5.0, 4.0])}, {"x": np.array([3.0, 2.0, 1.0]), "y": np.array([4.0, 5.0])},
    {"xmin": 1.0, "xmax": 3.0, "ymin": 5.0, "ymax": 4.0},
    {"easting": np.array([1.0, 2.0, 4.0]), "northing": np.array([5.0, 4.0])},
])  # fmt: skip
def test_axes_of_arrays_are_brought_to_ascending_order(axes: dict[str, Any], tmp_path: Path) -> None:
    z = np.arange(6.0).reshape(2, 3) / 7
    np.savez(tmp_path / "a.npz", z=z, **axes)
    samples = elevation(path=tmp_path / "a.npz", lengths="m")
    x, y = (np.asarray(v) for v in list(axes.values())[:2]) if len(axes) == 2 else (np.array([1.0, 2, 3]), np.array([5.0, 4]))
    for (i, j), value in np.ndenumerate(z):
        at = np.isclose(samples.grid.points()[:, 0], x[j]) & np.isclose(samples.grid.points()[:, 1], y[i])
        assert samples.values.ravel()[at] == value


def test_every_suffix_is_documented() -> None:
    text = elevation.__doc__ or ""
    for suffix in set(FORMATS) - {".tiff", ".jpeg", ".tsv", ".xyz"}:
        assert suffix in text
    record = record_of(elevation)
    assert record.accuracy and all(p.words for p in record.parameters)


@pytest.mark.parametrize(("low", "high"), [("_lo", "_hi"), ("_lower", "_upper"), ("_min", "_max")])
def test_limits_beside_a_map_are_bounds(low: str, high: str, tmp_path: Path) -> None:
    h = RNG.normal(size=(4, 5))
    arrays: dict[str, Any] = {"h": h, f"h{low}": h - 1, f"h{high}": h + 2}
    np.savez(tmp_path / "a.npz", **arrays)
    term = next(t for t in elevation(path=tmp_path / "a.npz").accuracy.terms if t.id.endswith("/limits"))
    np.testing.assert_allclose(term.error(), 2.0)
    np.savez(tmp_path / "a.npz", **(arrays | {f"h{low}": h + 1}))
    if low == "_min":
        assert len(elevation(path=tmp_path / "a.npz").accuracy.terms) == 1
    else:
        with pytest.raises(ReadError, match="do not enclose"):
            elevation(path=tmp_path / "a.npz")


@pytest.mark.parametrize("ending", ["_std", "_sigma", "_stderr", "_error", "_errors", "_unc", "_spread"])
def test_deviations_beside_an_array_of_vtk(ending: str, tmp_path: Path) -> None:
    image = pv.ImageData(dimensions=(4, 3, 2))
    image.point_data["p"], image.point_data[f"p{ending}"] = np.arange(24.0), np.full(24, 0.5)
    image.point_data["p_min"], image.point_data["p_max"] = np.arange(24.0) - 3, np.arange(24.0) + 1
    image.save(tmp_path / "a.vti")
    samples = dataset(path=tmp_path / "a.vti")
    assert samples.name == "p" and [t.kind for t in samples.accuracy.terms] == ["bound", "linear", "bound"]
    assert samples.accuracy.terms[1].error()[0] == 0.5 and samples.accuracy.terms[2].error()[0] == 3.0
