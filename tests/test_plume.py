"""The packaged plume: its solver against the Gaussian plume, and what the file holds."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from modules.readers.dataset import dataset

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def script() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "resources" / "data" / "plume.py")))


def test_in_an_even_wind_it_is_the_gaussian_plume(script: SimpleNamespace) -> None:
    """With its mirror image at the ground; finer steps come nearer by the second order."""
    stack = script.Stack(150.0, 0.0, 150.0, 100.0)
    x, y, z = (h * np.arange(n) for n, h in zip(script.SAMPLES, script.SPACING, strict=True))
    y -= y[-1] / 2
    off = []
    for finer in (2, 4):
        found = script.solve((stack,), np.full((script.SAMPLES[2] - 1) * finer + 1, 6.0), finer)
        assert not found[:, :, 0].any()
        near = slice(1, 15)  # before the top of the box is felt
        along = x[near] - stack.x
        wide, high = (np.sqrt(script.WIDTH**2 + 2 * k * along / 6.0) for k in (script.KY, script.KZ))
        mirrored = sum(script.gaussian(z[:, None, None] + side * stack.height, high) for side in (-1, 1))
        exact = 1e6 * stack.emission / 6.0 * script.gaussian(y[None, :, None], wide) * mirrored
        off.append(np.abs(found[:, :, near] - exact).max() / exact.max())
    assert off[1] < 0.012 and off[0] / off[1] > 1.9


def test_the_wind_carries_away_what_the_stacks_give_off(script: SimpleNamespace) -> None:
    z = script.SPACING[2] * np.arange(script.SAMPLES[2])
    found = script.solve(script.STACKS, script.wind(np.arange((script.SAMPLES[2] - 1) * 2 + 1) / 2 * script.SPACING[2]))
    weight = np.ones(len(z))
    weight[[0, -1]] = 0.5
    carried = (found[:, :, 12] * (script.wind(z) * weight)[:, None]).sum() * script.SPACING[1] * script.SPACING[2]
    assert carried == pytest.approx(1e6 * sum(s.emission for s in script.STACKS), rel=0.01)


def test_the_file_is_what_the_script_writes(script: SimpleNamespace) -> None:
    values, left = script.plume()
    read = dataset(path=ROOT / "networks" / "data" / "plume.vti", name="so2")
    assert np.abs(read.values - values).max() < 1e-3
    stated = next(t for t in read.accuracy.terms if "so2_std" in t.name)
    assert np.abs(stated.error() - left.ravel()).max() < 1e-4
