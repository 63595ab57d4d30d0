"""The data set of thesis chapter 5: its solver against the bench mark of de Vahl Davis, and what the file holds."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from modules.modellers.interpolate import interpolate
from modules.readers.dataset import dataset, peek

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "networks" / "data" / "double-glazing.vti"


@pytest.fixture(scope="module")
def solver() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "resources" / "data" / "double_glazing.py")))


@pytest.mark.parametrize(("rayleigh", "u", "v", "nusselt"), [(1e3, 3.649, 3.697, 1.118), (1e4, 16.178, 19.617, 2.243)])
def test_the_bench_mark_of_de_vahl_davis(solver: SimpleNamespace, rayleigh: float, u: float, v: float, nusselt: float) -> None:
    """International Journal for Numerical Methods in Fluids 3 (1983) 249-264, tables IV and V; 20 x 20 cells here."""
    got = solver.benchmark(20, rayleigh)
    assert got[0] == pytest.approx(u, rel=0.02)
    assert got[1] == pytest.approx(v, rel=0.02)
    assert got[2] == pytest.approx(nusselt, rel=0.03)


def test_a_finer_lattice_comes_nearer_by_the_second_order(solver: SimpleNamespace) -> None:
    """Nu = 2.24475 of Hortmann, Peric and Scheuerer, same journal 11 (1990) 189-207."""
    coarse, fine = (abs(solver.benchmark(n, 1e4)[2] - 2.24475) for n in (16, 32))
    assert 3.0 < coarse / fine < 5.0


def test_nodes_on_walls_are_walls(solver: SimpleNamespace) -> None:
    found = solver.at_nodes(solver.solve((8, 6, 4), 1e3), 2)
    velocity, temperature = found["velocity"], found["temperature"]
    assert velocity.shape == (5, 4, 3, 3) and found["pressure"].shape == temperature.shape == (5, 4, 3)
    for axis in range(3):
        for end in (0, -1):
            assert (np.take(velocity, end, axis) == 0).all()
    assert (temperature[..., 0] == 0.5).all() and (temperature[..., -1] == -0.5).all()
    assert velocity[2, 2, 1].any()


def test_what_the_file_holds() -> None:
    assert set(peek(FILE)["names"]) == {"velocity", "temperature", "pressure"}
    flow = dataset(path=FILE, name="velocity", unit="mm/s", lengths="mm")
    assert flow.values.shape == (18, 10, 10, 3)
    assert flow.grid.bounds == pytest.approx((0, 18, 0, 18, 0, 34))
    warm = dataset(path=FILE, name="temperature", unit="°C", lengths="mm")
    assert warm.values[..., 0] == pytest.approx(17.0) and warm.values[..., -1] == pytest.approx(3.0)
    assert any("float32" in t.name or "float32" in t.source.rule for t in flow.accuracy.terms), "the rounding is stated"


def test_air_goes_round_along_the_walls_and_slowly_in_the_middle() -> None:
    """Thesis 5.3: the particles tend to travel near the boundaries; in the middle the motion is much slower."""
    flow = dataset(path=FILE, name="velocity", unit="mm/s", lengths="mm")
    up = flow.values[9, 5, :, 2]
    assert up[1] > 10 and up[-2] < -10, "up along the warm sheet, down along the cold one"
    speed = np.linalg.norm(flow.values, axis=-1)
    assert speed[8:10, 4:6, 4:6].max() < 0.35 * speed.max()
    turned = flow.values[::-1, :, ::-1] * [-1, 1, -1]
    assert flow.values == pytest.approx(turned, abs=0.02), "half a turn gives the same flow"
    at, _ = interpolate(flow).at(np.array([[9.0, 9.0, 17.0]]))
    assert np.linalg.norm(at) < 1.0
