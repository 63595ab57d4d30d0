"""NetCDF, HDF5, Zarr, BAG and S-102: written by other programs, read with their places, units, holes and errors."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import netCDF4
import numpy as np
import pytest
import xarray
import zarr
from scipy.io import netcdf_file

from modules.api import Curvilinear, Matrix, Rectilinear, Regular, Samples
from modules.readers._files import ReadError
from modules.readers.gridded import gridded, peek

RNG = np.random.default_rng(11)
Z, Y, X = 3, 5, 7


def term(samples: Samples, what: str) -> Any:
    return next(t for t in samples.accuracy.terms if t.id.endswith("/" + what))


def flag(samples: Samples, name: str) -> str:
    return next((f.words for f in samples.accuracy.flags if f.name == name), "")


def variable(file: Any, name: str, values: Any, dims: Any, kind: str = "f8", fill: Any = None, **said: Any) -> Any:
    for dim, size in zip(dims, np.shape(values), strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, size)
    made = file.createVariable(name, kind, dims, fill_value=fill)
    made.set_auto_maskandscale(False)
    made.setncatts(said)
    made[...] = values
    return made


def ocean(path: Path, form: Any = "NETCDF4") -> dict[str, Any]:
    """Temperatures with axes out of order and running down, packed, with holes and two kinds of uncertainty."""
    packed = RNG.integers(-200, 200, (Y, 2, X, Z)).astype(np.int16)
    packed[0, 0, 0, 0] = -999
    packed[1, 0, 0, 0] = 31000
    with netCDF4.Dataset(path, "w", format=form) as file:
        variable(file, "lat", np.linspace(44.0, 43.0, Y), ("lat",), units="degrees_north", standard_name="latitude")
        variable(file, "lon", 5 + np.array([0, 1, 2, 3, 5, 6, 8.0]), ("lon",), units="degrees_east")
        variable(file, "depth", [100.0, 50.0, 5.0], ("depth",), units="m", positive="down", axis="Z")
        variable(file, "time", [6, 12], ("time",), "i4", units="hours since 2020-01-01 00:00:00")
        variable(
            file, "temp", packed, ("lat", "time", "lon", "depth"), "i2", -999, units="degC", scale_factor=0.01, add_offset=10.0,
            valid_range=np.array([-300, 300], np.int16), standard_name="sea_water_temperature",
            ancillary_variables="temp_se temp_bias flag",
        )  # fmt: skip
        variable(
            file, "temp_se", np.full((Y, 2, X, Z), 0.5) + np.arange(Z), ("lat", "time", "lon", "depth"), "f4", units="K",
            standard_name="sea_water_temperature standard_error", standard_error_multiplier=2.0,
        )  # fmt: skip
        bias = "systematic uncertainty of calibration"
        variable(file, "temp_bias", [0.3, 0.2, 0.1], ("depth",), units="0.1 K", long_name=bias)
        variable(file, "flag", np.zeros((Y, 2, X, Z)), ("lat", "time", "lon", "depth"), "i1", standard_name="status_flag")
    return {"packed": packed}


@pytest.fixture(params=["NETCDF4", "NETCDF4_CLASSIC", "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET"])
def form(request: pytest.FixtureRequest) -> str:
    return str(request.param)


# --- NetCDF ------------------------------------------------------------------------------------------------------


def test_axes_come_in_order_and_ascend_and_numbers_are_unpacked(tmp_path: Path, form: str) -> None:
    ocean(tmp_path / "t.nc", form)
    samples = gridded(path=tmp_path / "t.nc", step=1, plane="degrees")
    with xarray.open_dataset(tmp_path / "t.nc", engine="scipy" if "3" in form else "netcdf4") as oracle:
        wanted = oracle["temp"].isel(time=1).transpose("depth", "lat", "lon").sortby(["depth", "lat", "lon"]).values
    np.testing.assert_allclose(samples.values, wanted, rtol=1e-12)
    assert isinstance(samples.grid, Rectilinear) and samples.grid.frame.axes == ("lon", "lat", "depth")
    assert samples.grid.frame.units == ("degrees_east", "degrees_north", "m") and samples.grid.frame.handed == "left"
    np.testing.assert_array_equal(samples.grid.axes[2], [5, 50, 100])
    assert samples.time == 12 * 3600 and samples.unit == "degC" and samples.name == "temp"


def test_fill_values_and_what_is_outside_the_valid_range_are_holes(tmp_path: Path) -> None:
    ocean(tmp_path / "t.nc")
    samples = gridded(path=tmp_path / "t.nc")
    assert np.isnan(samples.values[-1, -1, 0]) and np.isnan(samples.values[-1, -2, 0])
    assert np.isnan(samples.values).sum() == 2


def test_the_errors_that_it_states_keep_apart(tmp_path: Path) -> None:
    packed = ocean(tmp_path / "t.nc")["packed"]
    samples = gridded(path=tmp_path / "t.nc")
    bits, random, common = (term(samples, w) for w in ("quantisation", "temp_se", "temp_bias"))
    assert len(samples.accuracy.terms) == 3 and not samples.accuracy.missing
    assert bits.kind == "bound" and bits.source.rigour == "proven" and float(bits.value) == pytest.approx(0.005)
    sizes = random.error().reshape(samples.grid.shape)
    holes = np.isnan(samples.values)
    np.testing.assert_allclose(sizes[2][~holes[2]], 0.25)
    np.testing.assert_allclose(sizes[0], 1.25)
    assert (sizes[holes] == 0).all() and "2 make one standard deviation" in random.source.rule
    np.testing.assert_allclose(common.error().reshape(samples.grid.shape)[:, 0, 1], [0.01, 0.02, 0.03])
    assert common.operator.shape[1] == 1 and random.operator.shape[1] == packed[:, 0].size
    assert "by its name it is one error" in common.source.rule and common.name == "systematic uncertainty of calibration"
    assert "temp_se are independent" in flag(samples, "assumed") and "temp_bias" not in flag(samples, "assumed")


def test_a_common_error_is_the_same_at_all_times_and_a_random_one_is_not(tmp_path: Path) -> None:
    ocean(tmp_path / "t.nc")
    first, second = (gridded(path=tmp_path / "t.nc", step=i) for i in (0, 1))
    assert term(first, "temp_bias").id == term(second, "temp_bias").id
    assert term(first, "temp_se").id != term(second, "temp_se").id
    thin = gridded(path=tmp_path / "t.nc", stride=2)
    assert term(thin, "temp_se").id == term(first, "temp_se").id


@pytest.mark.parametrize(("correlation", "mean"), [("independent", 0.5 / 10), ("common", 0.5), ("length", 0.5)])
def test_what_is_assumed_of_the_noise_decides_what_a_mean_keeps(tmp_path: Path, correlation: Any, mean: float) -> None:
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        variable(file, "h", RNG.normal(size=(10, 10)), ("y", "x"), units="m")
        variable(file, "h_sigma", np.full((10, 10), 50.0), ("y", "x"), units="cm")
    samples = gridded(path=tmp_path / "a.nc", correlation=correlation, length=100.0)
    one = term(samples, "h_sigma")
    np.testing.assert_allclose(one.error(), 0.5, rtol=1e-6)
    average = one.push(Matrix(np.full((1, 100), 0.01)))
    assert float(average.error()[0]) == pytest.approx(mean, rel=0.02)
    assert "set 'correlation'" in flag(samples, "assumed")


def test_members_become_their_mean_and_its_spread(tmp_path: Path) -> None:
    members = RNG.normal(280, 3, (6, 4, Y, X))
    with netCDF4.Dataset(tmp_path / "era.nc", "w") as file:
        variable(file, "number", np.arange(4), ("number",), "i4", standard_name="realization")
        variable(file, "valid_time", np.arange(6) * 3600, ("valid_time",), "i8", units="seconds since 1970-01-01")
        variable(file, "latitude", np.linspace(60, -60, Y), ("latitude",), units="degrees_north")
        variable(file, "longitude", np.linspace(0, 300, X), ("longitude",), units="degrees_east")
        variable(file, "t2m", members, ("valid_time", "number", "latitude", "longitude"), units="K")
    samples = gridded(path=tmp_path / "era.nc", step=5)
    np.testing.assert_allclose(samples.values, members[5].mean(axis=0)[::-1])
    spread = term(samples, "members")
    assert spread.kind == "members" and spread.source.rigour == "sampled"
    np.testing.assert_allclose(spread.error(), members[5].std(axis=0, ddof=1)[::-1].ravel())
    assert [m.name for m in samples.accuracy.missing] == ["Error common to all members"]
    assert samples.grid.frame.units[0] == "degrees_east", "a map of the world is no plane"
    control = gridded(path=tmp_path / "era.nc", step=5, at="number=0")
    np.testing.assert_array_equal(control.values, members[5, 0][::-1])
    assert [m.name for m in control.accuracy.missing] == ["Measurement error"]
    facts = peek(tmp_path / "era.nc")
    assert facts["names"] == ("t2m",) and facts["steps"] == (0, 5) and facts["members"] == 4 and facts["shape"] == (Y, X)


def test_components_become_one_vector_with_the_errors_of_each(tmp_path: Path) -> None:
    u, v = RNG.normal(size=(2, Y, X))
    with netCDF4.Dataset(tmp_path / "flow.nc", "w") as file:
        variable(file, "u", u, ("y", "x"), "f4", units="m s-1")
        variable(file, "v", v, ("y", "x"), "f4", units="m s-1")
        variable(file, "u_std", np.full((Y, X), 0.1), ("y", "x"), units="m s-1")
        variable(file, "v_std", np.full((Y, X), 0.2), ("y", "x"), units="m s-1")
    assert "u, v" in peek(tmp_path / "flow.nc")["names"]
    samples = gridded(path=tmp_path / "flow.nc", name="u, v")
    np.testing.assert_allclose(samples.values, np.stack([u, v, 0 * u], axis=-1), rtol=1e-6)
    np.testing.assert_allclose(term(samples, "u_std").error(), np.tile([0.1, 0.2, 0.0], (Y * X, 1)))
    assert samples.components == 3 and (term(samples, "quantisation").error()[:, 2] <= 1e-6).all()


def test_a_bent_grid_and_its_reference_are_kept(tmp_path: Path) -> None:
    i, j = np.meshgrid(np.arange(X), np.arange(Y))
    with netCDF4.Dataset(tmp_path / "bent.nc", "w") as file:
        variable(file, "nav_lon", 2 + 0.1 * i + 0.02 * j, ("j", "i"), units="degrees_east", standard_name="longitude")
        variable(file, "nav_lat", 50 + 0.1 * j - 0.01 * i, ("j", "i"), units="degrees_north", standard_name="latitude")
        variable(file, "ssh", RNG.normal(size=(Y, X)), ("j", "i"), units="m", coordinates="nav_lon nav_lat")
    samples = gridded(path=tmp_path / "bent.nc")
    assert isinstance(samples.grid, Curvilinear) and samples.grid.frame.units[0] == "m"
    points = samples.grid.points().reshape(Y, X, 3)
    assert points[0, 1, 0] - points[0, 0, 0] == pytest.approx(0.1 * 71500, rel=0.01)


def test_a_projected_map_is_regular_and_names_its_system(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "p.nc", "w") as file:
        variable(file, "crs", 0, (), "i4", grid_mapping_name="transverse_mercator", crs_wkt='PROJCS["UTM 31N"]')
        variable(file, "x", 5e5 + 30.0 * np.arange(X), ("x",), "f4", units="m", standard_name="projection_x_coordinate")
        variable(file, "y", 4e6 - 30.0 * np.arange(Y), ("y",), "f4", units="m", standard_name="projection_y_coordinate")
        variable(file, "h", RNG.normal(size=(Y, X)), ("y", "x"), units="m", grid_mapping="crs")
    samples = gridded(path=tmp_path / "p.nc")
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == (30.0, 30.0)
    assert samples.grid.frame.crs == 'PROJCS["UTM 31N"]'


@pytest.mark.parametrize(("how", "limit"), [
    ({"least_significant_digit": 1}, 2.0**-5), ({"significant_digits": 3, "quantize_mode": "BitGroom"}, None),
    ({"significant_digits": 8, "quantize_mode": "BitRound"}, None),
    ({"significant_digits": 3, "quantize_mode": "GranularBitRound"}, None),
])  # fmt: skip
def test_lossy_compression_stays_within_the_bound(tmp_path: Path, how: dict[str, Any], limit: float | None) -> None:
    truth = RNG.normal(0, 40, (50, 60))
    with netCDF4.Dataset(tmp_path / "q.nc", "w") as file:
        file.createDimension("y", 50), file.createDimension("x", 60)
        file.createVariable("h", "f4", ("y", "x"), zlib=True, **how)[...] = truth
    samples = gridded(path=tmp_path / "q.nc")
    error, bound = np.abs(samples.values - truth).ravel(), term(samples, "quantisation").error()
    assert (error <= bound).all() and error.max() > 0.05 * bound.max()
    assert limit is None or bound[0] == pytest.approx(limit, rel=1e-3)


def test_limits_enclose(tmp_path: Path) -> None:
    h = RNG.normal(size=(Y, X))
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        variable(file, "h", h, ("y", "x"))
        variable(file, "h_lo", h - 1, ("y", "x"))
        variable(file, "h_hi", h + 2, ("y", "x"))
    np.testing.assert_allclose(term(gridded(path=tmp_path / "a.nc"), "limits").error(), 2.0)
    with netCDF4.Dataset(tmp_path / "a.nc", "a") as file:
        file["h_lo"][0, 0] = 99
    with pytest.raises(ReadError, match="do not enclose"):
        gridded(path=tmp_path / "a.nc")


def test_an_error_that_has_gaps_is_missing_there(tmp_path: Path) -> None:
    sizes = np.full((Y, X), 0.5)
    sizes[0, :2] = np.nan
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        variable(file, "h", RNG.normal(size=(Y, X)), ("y", "x"))
        variable(file, "h_unc", sizes, ("y", "x"))
    samples = gridded(path=tmp_path / "a.nc")
    assert [m.reason for m in samples.accuracy.missing] == [f"it is not given at 2 of {Y * X} samples"]
    assert samples.accuracy.rigour("value") == "unknown"


def test_units_are_converted_with_their_errors(tmp_path: Path) -> None:
    ocean(tmp_path / "t.nc")
    celsius, kelvin = (gridded(path=tmp_path / "t.nc", unit=u) for u in (None, "K"))
    np.testing.assert_allclose(kelvin.values, celsius.values + 273.15)
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        variable(file, "h", RNG.normal(size=(Y, X)), ("y", "x"), units="m")
        variable(file, "h_std", np.full((Y, X), 0.5), ("y", "x"), units="m")
    feet = gridded(path=tmp_path / "a.nc", unit="ft")
    assert term(feet, "h_std").unit == "ft" and term(feet, "h_std").error()[0] == pytest.approx(0.5 / 0.3048)
    with pytest.raises(ReadError, match="different things"):
        gridded(path=tmp_path / "a.nc", unit="s")


# --- HDF5, Zarr, and soundings -----------------------------------------------------------------------------------


def test_nexus_signals_have_axes_and_errors(tmp_path: Path) -> None:
    counts = RNG.poisson(50, (Y, X)).astype(float)
    with h5py.File(tmp_path / "n.h5", "w") as file:
        data = file.create_group("entry/data")
        data.attrs.update(signal="counts", axes=["qy", "qx"])
        data["counts"], data["counts_errors"] = counts, np.sqrt(counts)
        data["qx"], data["qy"] = np.linspace(-1, 1, X), np.linspace(2, 0, Y)
        data["qx"].attrs["units"] = data["qy"].attrs["units"] = "nm-1"
    samples = gridded(path=tmp_path / "n.h5")
    np.testing.assert_array_equal(samples.values, counts[::-1])
    assert samples.grid.bounds[:4] == (-1, 1, 0, 2) and samples.grid.frame.units[0] == "nm-1"
    np.testing.assert_allclose(term(samples, "counts_errors").error(), np.sqrt(counts[::-1]).ravel())


def test_netcdf_groups_find_the_axes_of_their_parents(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "g.nc", "w") as file:
        variable(file, "x", 10.0 * np.arange(X), ("x",), units="m")
        variable(file, "y", 10.0 * np.arange(Y), ("y",), units="m")
        group = file.createGroup("land")
        one = group.createVariable("h", "f8", ("y", "x"))
        one[...] = 1.5
    samples = gridded(path=tmp_path / "g.nc", name="land/h")
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == (10.0, 10.0)


@pytest.mark.parametrize("version", [2, 3])
def test_zarr_of_both_versions(tmp_path: Path, version: Any) -> None:
    values = RNG.normal(size=(Y, X))
    data = xarray.Dataset(
        {"h": (("y", "x"), values, {"units": "m"}), "h_std": (("y", "x"), np.full((Y, X), 0.25), {"units": "m"})},
        coords={"y": ("y", np.linspace(4, 0, Y), {"units": "m"}), "x": ("x", np.arange(X) * 1.0, {"units": "m"})},
    )
    data.to_zarr(tmp_path / "a.zarr", zarr_format=version, consolidated=False)
    samples = gridded(path=tmp_path / "a.zarr")
    np.testing.assert_array_equal(samples.values, values[::-1])
    assert term(samples, "h_std").error()[0] == 0.25 and samples.unit == "m"
    assert peek(tmp_path / "a.zarr")["names"] == ("h",)


def test_zarr_of_one_array(tmp_path: Path) -> None:
    zarr.save(str(tmp_path / "b.zarr"), np.arange(12.0).reshape(3, 4))
    samples = gridded(path=tmp_path / "b.zarr")
    assert samples.values[2, 3] == 11 and "1 apart" in flag(samples, "assumed")


METADATA = (
    "<gmd:x xmlns:gmd='g' xmlns:gml='m'><gml:coordinates>500000.0,4000000.0 500012.0,4000008.0</gml:coordinates>"
    "<c>PROJCS[&quot;UTM 18N&quot;]</c><gmd:BAG_VertUncertCode codeListValue='rawStdDev'/></gmd:x>"
)


def bag(path: Path, metadata: str = METADATA) -> tuple[Any, Any]:
    depth = RNG.normal(-20, 3, (Y, X)).astype(np.float32)
    depth[0, 0] = 1e6
    sigma = np.where(depth > 1e5, 1e6, 0.3).astype(np.float32)
    with h5py.File(path, "w") as file:
        root = file.create_group("BAG_root")
        root.attrs["Bag Version"] = "1.6.2"
        root["elevation"], root["uncertainty"] = depth, sigma
        root["metadata"] = np.frombuffer(metadata.encode(), "S1")
    return depth, sigma


def test_soundings_of_a_bag(tmp_path: Path) -> None:
    depth, _ = bag(tmp_path / "survey.bag")
    samples = gridded(path=tmp_path / "survey.bag")
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == (2.0, 2.0) and samples.grid.origin == (5e5, 4e6)
    assert np.isnan(samples.values[0, 0]) and samples.values[1, 1] == depth[1, 1] and samples.unit == "m"
    assert samples.grid.frame.crs == 'PROJCS["UTM 18N"]' and "rawStdDev" in flag(samples, "assumed")
    np.testing.assert_allclose(term(samples, "uncertainty").error()[1:], 0.3, rtol=1e-6)
    twice = gridded(path=tmp_path / "survey.bag", multiple=1.96)
    np.testing.assert_allclose(term(twice, "uncertainty").error()[1:], 0.3 / 1.96, rtol=1e-6)


@pytest.mark.parametrize(("metadata", "words"), [("<a>", "no XML"), ("<a/>", "names no corners")])
def test_a_bag_without_a_place_says_so(tmp_path: Path, metadata: str, words: str) -> None:
    bag(tmp_path / "a.bag", metadata)
    with pytest.raises(ReadError, match=words):
        gridded(path=tmp_path / "a.bag")


def test_soundings_of_s_102(tmp_path: Path) -> None:
    values = np.zeros((Y, X), [("depth", "f4"), ("uncertainty", "f4")])
    values["depth"], values["uncertainty"] = RNG.uniform(5, 9, (Y, X)), 0.2
    values[2, 3] = (1e6, 1e6)
    with h5py.File(tmp_path / "102US.h5", "w") as file:
        file.attrs["horizontalCRS"] = 4326
        place = file.create_group("BathymetryCoverage/BathymetryCoverage.01")
        place.attrs.update(gridOriginLongitude=-70.0, gridOriginLatitude=43.0)
        place.attrs.update(gridSpacingLongitudinal=1e-3, gridSpacingLatitudinal=1e-3)
        place["Group_001/values"] = values
    samples = gridded(path=tmp_path / "102US.h5")
    assert samples.grid.frame.units[0] == "m" and np.isnan(samples.values[2, 3])
    assert samples.values[0, 0] == values["depth"][0, 0]
    np.testing.assert_allclose(np.delete(term(samples, "uncertainty").error(), 2 * X + 3), 0.2, rtol=1e-6)


# --- what cannot be read -----------------------------------------------------------------------------------------


def short(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def wrong(path: Path) -> None:
    path.write_bytes(b"this is a letter, not data" * 40)


def nothing(path: Path) -> None:
    path.write_bytes(b"")


@pytest.mark.parametrize(("spoil", "words"), [(short, "damaged"), (wrong, "neither NetCDF nor HDF5"), (nothing, "is empty")])
@pytest.mark.parametrize("form", ["NETCDF4", "NETCDF3_CLASSIC"])
def test_a_spoilt_file_gives_one_sentence(tmp_path: Path, spoil: Callable[[Path], None], words: str, form: str) -> None:
    ocean(tmp_path / "t.nc", form)
    spoil(tmp_path / "t.nc")
    with pytest.raises(ReadError, match=words) as error:
        gridded(path=tmp_path / "t.nc")
    assert "\n" not in str(error.value) and "t.nc" in str(error.value)
    assert words in peek(tmp_path / "t.nc")["problem"]


@pytest.mark.parametrize(("given", "words"), [
    ({"name": "salinity"}, "it holds temp"), ({"step": 7}, "from 0 to 1"), ({"at": "depth"}, "'depth=0'"),
    ({"at": "up=1"}, "no axis 'up'"),
    ({"stride": 0}, "keeps nothing"), ({"multiple": 0.0}, "must be positive"), ({"name": "a,b,c,d"}, "two or three"),
    ({"name": "temp, lat"}, "not components"),
    ({"correlation": "length", "length": 1.0, "plane": "degrees"}, "different units"),
])  # fmt: skip
def test_what_cannot_be_meant_is_said(tmp_path: Path, given: dict[str, Any], words: str) -> None:
    ocean(tmp_path / "t.nc")
    with pytest.raises(ValueError, match=words):
        gridded(path=tmp_path / "t.nc", **given)


def test_an_axis_that_is_none_of_space_has_to_be_cut(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "b.nc", "w") as file:
        variable(file, "y", np.arange(Y), ("y",)), variable(file, "x", np.arange(X), ("x",))
        variable(file, "z", [0, 1], ("z",))
        variable(file, "r", RNG.normal(size=(4, 2, Y, X)), ("band", "z", "y", "x"))
        variable(file, "e", RNG.normal(size=(Y, X)), ("y", "x"), units="m", ancillary_variables="e_se", standard_name="e")
        variable(file, "e_se", np.ones((Y, X)), ("y", "x"), units="s", standard_name="e standard_error")
    with pytest.raises(ReadError, match="'band=0'"):
        gridded(path=tmp_path / "b.nc", name="r")
    assert gridded(path=tmp_path / "b.nc", name="r", at="band=3, z=1").values.shape == (Y, X)
    with pytest.raises(ReadError, match="should state errors of 'e'"):
        gridded(path=tmp_path / "b.nc", name="e")


@pytest.mark.parametrize(("package", "file"), [("h5py", "t.nc"), ("zarr", "t.zarr")])
def test_what_to_install_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, file: str) -> None:
    ocean(tmp_path / "t.nc")
    zarr.save(str(tmp_path / "t.zarr"), np.zeros((3, 4)))
    real = importlib.import_module

    def absent(name: str, *more: Any) -> Any:
        if name == package:
            raise ImportError(name)
        return real(name, *more)

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(ReadError, match=r"pip install 'nonius-explorer\[(hdf5|zarr)\]'"):
        gridded(path=tmp_path / file)


def test_classic_files_need_no_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str, *more: Any) -> Any:
        raise ImportError(name)

    with netcdf_file(tmp_path / "c.nc", "w") as file:
        file.createDimension("y", 3), file.createDimension("x", 4)
        made = file.createVariable("h", ">f4", ("y", "x"))
        made[:] = 1.5
        made.units = b"m"
    monkeypatch.setattr(importlib, "import_module", absent)
    assert gridded(path=tmp_path / "c.nc").unit == "m"
