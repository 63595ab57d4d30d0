"""The packaged map of the sea surface: written by its script, and wrong by what it says that it is."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from modules.readers.gridded import gridded, peek

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "networks" / "data" / "sea-surface.nc"


@pytest.fixture(scope="module")
def script() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "resources" / "data" / "sea_surface.py")))


def test_the_file_is_what_the_script_writes(script: SimpleNamespace, tmp_path: Path) -> None:
    script.write(tmp_path / "again.nc")
    assert (tmp_path / "again.nc").read_bytes() == FILE.read_bytes() and FILE.stat().st_size < 100_000


def test_its_errors_are_as_large_as_it_states(script: SimpleNamespace) -> None:
    samples = gridded(path=FILE, plane="degrees")
    bits, noise, bias = samples.accuracy.terms
    assert [t.source.rigour for t in samples.accuracy.terms] == ["proven", "estimated", "estimated"]
    points = samples.grid.points()
    error = samples.values.ravel() - script.truth(points[:, 0], points[:, 1])
    known = np.isfinite(error)
    common = error[known].mean()
    assert abs(common) < 3 * bias.error()[0] == pytest.approx(3 * script.CALIBRATION)
    normal = (error[known] - common) / noise.error()[known]
    assert normal.std() == pytest.approx(1, abs=0.03) and (np.abs(normal) < 2).mean() == pytest.approx(0.954, abs=0.015)
    assert float(bits.value) == pytest.approx(script.PACKED / 2)


def test_a_look_at_it_tells_what_it_states() -> None:
    facts = peek(FILE)
    assert facts["names"] == ("ssh",) and facts["errors"] == ("ssh_noise", "ssh_calibration") and facts["shape"] == (61, 91)
