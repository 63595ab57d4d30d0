"""Files that belong together: steps of time by index, and members of an ensemble."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv

from app.gui.dropping import pattern_of
from modules.progress import Cancelled, Progress
from modules.readers._files import ReadError
from modules.readers.series import files, peek, series

QUIET = Progress()
RNG = np.random.default_rng(4)
FIELDS = RNG.normal(10, 2, (12, 4, 5))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for i, values in enumerate(FIELDS):
        image = pv.ImageData(dimensions=(5, 4, 1))
        image.point_data["p"] = values.ravel().astype(np.float32)
        image.save(tmp_path / f"flow_{i}.vti")
    return tmp_path


def test_steps_come_in_the_order_of_their_numbers(folder: Path) -> None:
    assert [f.name for f in files(folder / "flow_*.vti")] == [f"flow_{i}.vti" for i in range(12)]
    for step in (2, 10):
        samples = series(QUIET, path=folder / "flow_*.vti", step=step, interval=0.5)
        np.testing.assert_allclose(samples.values, FIELDS[step], rtol=1e-6)
        assert samples.time == step * 0.5
    facts = peek(folder / "flow_*.vti")
    assert facts["steps"] == (0, 11) and facts["names"] == ("p",) and facts["shape"] == (4, 5)


def test_members_give_mean_and_spread(folder: Path) -> None:
    samples = series(QUIET, path=folder / "flow_*.vti", files_are="members")
    stored = FIELDS.astype(np.float32).astype(float)
    np.testing.assert_allclose(samples.values, stored.mean(axis=0))
    bits, spread = samples.accuracy.terms
    np.testing.assert_allclose(spread.error(), stored.std(axis=0, ddof=1).ravel())
    assert spread.kind == "members" and spread.source.rigour == "sampled" and bits.source.rigour == "proven"
    assert (np.abs(stored - FIELDS) <= float(bits.value)).all()
    assert [m.name for m in samples.accuracy.missing] == ["Error common to all members"]


def test_members_that_do_not_fit_are_named(folder: Path) -> None:
    image = pv.ImageData(dimensions=(5, 4, 1), spacing=(2, 1, 1))
    image.point_data["p"] = np.zeros(20)
    image.save(folder / "flow_7.vti")
    with pytest.raises(ReadError, match=r"'flow_7.vti' lies on another grid than 'flow_0.vti'"):
        series(QUIET, path=folder / "flow_*.vti", files_are="members")


def test_a_broken_member_is_named(folder: Path) -> None:
    whole = (folder / "flow_3.vti").read_bytes()
    (folder / "flow_3.vti").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ReadError, match=r"flow_3.vti"):
        series(QUIET, path=folder / "flow_*.vti", files_are="members")


def test_reading_is_cancelled_between_files(folder: Path) -> None:
    def stop(fraction: float, *_: Any) -> None:
        if fraction > 0.4:
            raise Cancelled

    with pytest.raises(Cancelled):
        series(Progress(stop), path=folder / "flow_*.vti", files_are="members")


@pytest.mark.parametrize(("given", "words"), [
    ({"path": None}, "velocity_"), ({"path": "none_*.vti"}, "no file fits"), ({"path": "flow_1.vti"}, "is one file"),
    ({"path": "flow_*.vti", "step": 12}, "from 0 to 11"), ({"path": "flow_3*.vti", "files_are": "members"}, "one file fits"),
    ({"path": "*.what"}, "not read here"),
])  # fmt: skip
def test_what_cannot_be_read_is_said(folder: Path, given: dict[str, Any], words: str) -> None:
    (folder / "a.what").write_text("words")
    path = folder / given.pop("path") if given["path"] else given.pop("path")
    with pytest.raises(ReadError, match=words):
        series(QUIET, path=path, **given)


def test_what_is_no_series_says_so_to_the_window(folder: Path) -> None:
    assert peek(folder / "flow_1.vti")["foreign"] and "no file fits" in peek(folder / "none_*.vti")["problem"]


@pytest.mark.parametrize(("names", "wanted"), [
    (("v_01.vti", "v_02.vti"), "v_*.vti"), (("a.vti", "b.vti"), None), (("v1_t1.nc", "v1_t2.nc"), "v1_t*.nc"),
    (("v.nc",), None), (("v1_t1.nc", "v2_t2.nc"), None), (("v_9.vti", "v_10.vti"), "v_*.vti"), (("v1.vti", "v1.vtk"), None),
])  # fmt: skip
def test_names_that_differ_in_one_number_are_a_series(names: tuple[str, ...], wanted: str | None) -> None:
    got = pattern_of([Path("data") / n for n in names])
    assert got == (None if wanted is None else Path("data") / wanted)
