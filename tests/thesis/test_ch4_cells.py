"""The worked cells of chapter 4: their polygons, tunnels, points and triangles (figures 4.5 to 4.34)."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modules.kernels import marching

CELLS = json.loads(Path(__file__).with_name("ch4_cells.json").read_text())
INNER = {"P6/1": 1, "P7/1": 1, "P8/1": 1, "P8/2": 2, "P9/3": 3, "P12/3": 6}


def drawn(cell: Any) -> Any:
    values = np.array(cell["corners"], float).reshape(2, 2, 2).transpose(2, 1, 0)  # from [x, y, z]
    x = np.arange(2.0)
    return marching.surface(values, x, x, x, 0.0)


def nearest(points: Any, wanted: Any) -> Any:
    return np.abs(points[None] - np.atleast_2d(wanted)[:, None]).max(axis=2).min(axis=1)


@pytest.mark.parametrize("cell", CELLS, ids=[c["name"] for c in CELLS])
class TestWorkedCell:
    def test_tunnel(self, cell: Any) -> None:
        assert drawn(cell).tunnels == int(cell["tunnel"])

    def test_number_of_triangles(self, cell: Any) -> None:
        tunnel = list(cell["polygons"])
        alone = [tunnel.pop(0)] if cell["tunnel"] and len(tunnel) == 3 else [] if cell["tunnel"] else tunnel
        tunnel = tunnel if cell["tunnel"] else []
        sizes = [(int(name[1:].split("/")[0]), INNER.get(name, 1)) for name in alone]
        wanted = sum(2 * i + 2 * m - 2 for i, m in sizes) + sum(2 * int(name[1:].split("/")[0]) + 6 for name in tunnel)
        assert len(drawn(cell).triangles) == wanted

    def test_face_shoulder_points(self, cell: Any) -> None:
        assert nearest(drawn(cell).points, cell["shoulders"]).max() < 1e-8

    def test_inflection_points_of_loop_back_polygons_and_tunnels(self, cell: Any) -> None:
        points = [p for name in ("Ix", "Iy", "Iz") for p in cell["inflections"][name]]
        if cell["tunnel"] or any(name in cell["polygons"] for name in ("P8/2", "P9/3", "P12/3")):
            assert nearest(drawn(cell).points, points).max() < 1e-8
        elif any(name in INNER for name in cell["polygons"]):
            assert nearest(drawn(cell).points, points).min() < 1e-8

    def test_bi_shoulder_points(self, cell: Any) -> None:
        for name in sorted({name for name, _ in cell["bi_shoulders"]}):
            known = [point for other, point in cell["bi_shoulders"] if other == name]
            if not cell["tunnel"]:
                assert nearest(drawn(cell).points, known).min() < 1e-8


@pytest.mark.parametrize(
    ("polygon", "triangles"),
    [("P3/0", 6), ("P4/0", 8), ("P5/0", 10), ("P6/0", 12)],
)
def test_table_4_5_triangles_of_a_polygon(polygon: Any, triangles: Any) -> None:
    corners = {"P3/0": (0,), "P4/0": (0, 1), "P5/0": (0, 1, 2), "P6/0": (0, 1, 2, 4)}[polygon]
    values = [1.0 if c in corners else -1.0 for c in range(8)]
    if polygon == "P6/0":
        values = [1.0 if c in (0, 1, 3, 7) else -1.0 for c in range(8)]  # configuration 11
    assert len(drawn({"corners": values}).triangles) == triangles
