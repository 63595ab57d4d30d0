"""Every kind of trilinear cell on one page, each held against its subdivision (figures 4.1, 4.3, 4.4 and 4.29).

The page is `resources/docs/cell-solids.png`. NONIUS_WRITE_PAGES=1 writes it anew; otherwise its list of cells is compared.
"""

from __future__ import annotations

import functools
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from modules.kernels import cell_types, marching, marching_cases, straight, trilinear
from tests.oracles import topology

PAGE = Path(__file__).resolve().parents[2] / "resources" / "docs" / "cell-solids.png"


class Case(NamedTuple):
    """A cell of a kind at level 0."""

    title: str
    corners: tuple[float, ...]

    @property
    def lattice(self) -> Any:
        return np.ascontiguousarray(np.array(self.corners).reshape(2, 2, 2).transpose(2, 1, 0))


@functools.cache
def cases() -> tuple[Case, ...]:
    """One random cell for each kind, with and without a tunnel; of several that whose values are least apart."""
    random, best = np.random.default_rng(8), dict[str, Case]()
    first = {cell_types.configuration(code): code for code in range(254, 0, -1) if code.bit_count() <= 4}
    for number, code in sorted(first.items()):
        value = np.exp(0.7 * random.normal(size=(12000, 8)))
        if number == 13:
            value[:2000] = np.abs(cell_types.TUNNEL_OF_13) * (1 + 0.02 * random.normal(size=(2000, 8)))
        value[:, [c for c in range(8) if not code >> c & 1]] *= -1
        found = straight.Active(np.arange(len(value)), np.zeros((len(value), 8), np.int64), value, np.full(len(value), code))
        faces = straight.joined(found, 0.0, "decider")
        six = np.asarray(trilinear.inner_inflections(value).all(axis=(1, 2)))
        spread = np.abs(value).max(axis=1) / np.abs(value).min(axis=1)
        for n in np.argsort(spread, kind="stable").tolist():
            loops = straight.loops(code, int(faces[n]))
            names = sorted((cell_types.polygon_name(loop) for loop in loops), key=lambda name: (len(name), name))
            tunnel = bool(six[n]) and len(loops) > 1
            title = f"{number}: {' '.join(names)}{', tunnel' if tunnel else ''}"
            best.setdefault(title, Case(title, tuple(np.round(value[n], 4).tolist())))
    return tuple(best.values())


def drawn(case: Case) -> Any:
    axis = np.arange(2.0)
    return marching.surface(case.lattice, axis, axis, axis, 0.0)


def test_there_are_30_kinds() -> None:
    assert len(cases()) == 30
    assert sum("tunnel" in case.title for case in cases()) == 6


@pytest.mark.parametrize("number", range(30))
def test_it_has_the_topology_of_its_subdivision(number: int) -> None:
    case = cases()[number]
    mesh = drawn(case)
    axis = np.arange(2.0)
    verdict = topology.judged(case.lattice, (axis, axis, axis), 0.0, (mesh.points, mesh.triangles, mesh.cell))
    assert verdict.right, f"{case.title}: {verdict}"
    assert verdict.tunnels == ("tunnel" in case.title)
    pieces = len(case.title.split(": ")[1].split(",")[0].split()) - ("tunnel" in case.title)
    assert topology.components(len(mesh.points), mesh.triangles) == pieces


def test_the_page_shows_them() -> None:
    from PIL import Image

    told = "; ".join(f"{case.title} {case.corners}" for case in cases())
    if os.environ.get("NONIUS_WRITE_PAGES"):
        _write(told)
    with Image.open(PAGE) as page:
        assert page.info["Cells"] == told, "write it anew with NONIUS_WRITE_PAGES=1"


def _write(told: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = Figure(figsize=(14, 12.4), layout="constrained")
    FigureCanvasAgg(figure)
    for n, case in enumerate(cases()):
        axes: Any = figure.add_subplot(5, 6, n + 1, projection="3d")
        mesh = drawn(case)
        look: Any = {"facecolors": "#C4C9D0", "edgecolors": "#4E5763", "linewidth": 0.5, "shade": True}
        axes.add_collection3d(Poly3DCollection(mesh.points[mesh.triangles], **look))
        corner = np.array([[c >> 2, c >> 1 & 1, c & 1] for c in range(8)], float)
        for a, b in marching_cases.EDGE_ENDS:
            axes.plot(*corner[[a, b]].T, color="#7A8492", linewidth=0.8)
        above = np.array(case.corners) >= 0
        axes.scatter(*corner[above].T, color="#1A1E24", s=22, depthshade=False)
        axes.set_title(case.title, fontsize=9.5, color="#1A1E24", pad=0)
        axes.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1), box_aspect=(1, 1, 1))
        axes.view_init(22, -58)
        axes.set_axis_off()
    figure.savefig(PAGE, dpi=100, metadata={"Cells": told, "Software": None})
