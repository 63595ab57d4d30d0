"""The figures of chapter 3: every case of a cell on one page, each held against a dense sampling of the field.

The page is `resources/docs/cell-cases.png`. NONIUS_WRITE_PAGES=1 writes it anew; otherwise it is compared.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from modules.accuracy_mappers.difference import difference
from modules.api import EXACT, Geometry, Model, Progress, Samples
from modules.mappers.cell import cell
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate

Floats = NDArray[np.float64]
Sides = NDArray[np.bool_]

PAGE = Path(__file__).resolve().parents[2] / "resources" / "docs" / "cell-cases.png"
RASTER = 240
SIZES = (1.0, 1.6, 0.7, 1.3)  # of the corner values 00, 10, 01, 11
METHODS = ("basic", "shoulder")


@dataclass(frozen=True)
class Case:
    """A cell at level 0."""

    name: str
    corner: tuple[float, float, float, float]  # f00, f10, f01, f11

    def lines(self, method: str) -> Geometry:
        samples = Samples.from_array(np.reshape(self.corner, (2, 2)), accuracy=EXACT)
        return contour(interpolate(samples), Progress(), levels=(0.0,), method=method)  # type: ignore[arg-type]  # a word

    def above(self) -> Sides:
        """The field itself, sampled at the middles of a raster: at or above the level; ties count as above."""
        u = (np.arange(RASTER) + 0.5) / RASTER
        x, y = np.meshgrid(u, u)
        a, b, c, d = self.corner
        return np.asarray(a * (1 - x) * (1 - y) + b * x * (1 - y) + c * (1 - x) * y + d * x * y >= 0)

    @property
    def hole(self) -> bool:
        return not np.isfinite(self.corner).all()

    @property
    def ambiguous(self) -> bool:
        high = [f >= 0 for f in self.corner]
        return high in ([True, False, False, True], [False, True, True, False])

    @property
    def degenerate(self) -> bool:
        """Whether the contour is two straight lines that cross (definition 3.2.0.2)."""
        a, b, c, d = map(Fraction, self.corner)
        return a * d == b * c and a + d != b + c

    @property
    def saddle(self) -> Fraction:
        """F(S), exactly."""
        a, b, c, d = map(Fraction, self.corner)
        return (a * d - b * c) / (a + d - b - c)


def patterns() -> list[Case]:
    """Each corner below, on and above the level: 81 cells, row by row of the page."""
    sign = {"−": -1.0, "0": 0.0, "+": 1.0}
    return [
        Case("".join(word), tuple(sign[w] * s for w, s in zip(word, SIZES, strict=True)))  # type: ignore[arg-type]  # four numbers
        for word in itertools.product(sign, repeat=4)
    ]


SPECIAL = [
    Case("S above", (-1.0, 1.5, 1.2, -0.8)),
    Case("S on the level", (-1.0, 1.5, 1.0, -1.5)),
    Case("S below", (-1.5, 1.0, 0.8, -1.2)),
    Case("S above", (1.5, -1.0, -0.8, 1.2)),
    Case("S on the level", (1.5, -1.0, -1.5, 1.0)),
    Case("S below", (0.8, -1.2, -1.5, 1.0)),
    Case("linear", (-1.0, 0.5, 0.25, 1.75)),
    Case("strongly bent", (-1.0, 0.02, 0.03, 60.0)),
    Case("a hole", (-1.0, 1.0, 1.0, np.nan)),
]
CASES = [*patterns(), *SPECIAL]
each_case = pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c.name} {c.corner}")


def drawn_above(case: Case, lines: Geometry) -> Sides:
    """Which places of the raster the drawing calls above: the side of the lower edge, turned at each line in between."""
    u = (np.arange(RASTER) + 0.5) / RASTER
    x, y = np.meshgrid(u, u)
    above = (1 - x) * case.corner[0] + x * case.corner[1] >= 0
    for line in lines.polylines():
        for p, q in pairwise(line[:, :2]):
            if p[0] == q[0]:
                continue
            between = (x < p[0]) != (x < q[0])
            above ^= between & (p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1]) < y)
    return above


def pieces(sides: Sides) -> tuple[int, int]:
    """Connected pieces above and below; specks of a few samples are none."""
    found = []
    for which in (sides, ~sides):
        labels, n = ndimage.label(which)
        found.append(int((ndimage.sum_labels(which, labels, np.arange(1, n + 1)) > 12).sum()))
    return found[0], found[1]


@each_case
@pytest.mark.parametrize("method", METHODS)
def test_figure_3_1_every_cell_is_drawn_as_its_field_is(case: Case, method: str) -> None:
    lines = case.lines(method)
    if case.hole:
        assert lines.counts["point"] == 0
        return
    above = case.above()
    drawn = drawn_above(case, lines)
    stated = float(lines.accuracy.select("area")[0].size().sum())
    assert float((drawn ^ above).mean()) == pytest.approx(stated, abs=0.006)
    if not (case.degenerate and (case.ambiguous or method == "basic")):  # pieces that meet in S: one or two, as one likes
        assert pieces(drawn) == pieces(above)
    values = dict(zip(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)), case.corner, strict=True))
    for line in lines.polylines():
        for end in line[[0, -1], :2]:
            on = [i for i in (0, 1) if end[i] in (0.0, 1.0)]
            assert on, "a line ends inside of its cell"
            assert len(on) == 1 or values[end[0], end[1]] == 0


@pytest.mark.parametrize("case", [c for c in CASES if not c.hole and c.ambiguous], ids=lambda c: f"{c.name} {c.corner}")
@pytest.mark.parametrize("method", METHODS)
def test_figure_3_4_corners_on_the_other_side_than_the_saddle_are_cut_off(case: Case, method: str) -> None:
    """A saddle on the level counts as above it, as a corner does."""
    lines = case.lines(method).polylines()
    corners = dict(zip(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)), case.corner, strict=True))
    cut = {at for at, f in corners.items() if (f >= 0) != (case.saddle >= 0)}
    assert len(cut) == 2
    found = set()
    for line in lines:
        ends = line[[0, -1], :2]
        found |= {at for at in corners if all((end == at).any() for end in ends)}
    if not any(f == 0 for f in case.corner):
        assert len(lines) == 2
        assert found == cut


def test_the_high_side_lies_to_the_left() -> None:
    for case in CASES:
        for method in () if case.hole else METHODS:
            for line in case.lines(method).polylines():
                for p, q in pairwise(line[:, :2]):
                    left = (p + q) / 2 + 1e-4 * np.array([-(q - p)[1], (q - p)[0]]) / np.hypot(*(q - p))
                    if method == "basic" or not ((left > 0) & (left < 1)).all():
                        continue
                    x, y = left
                    a, b, c, d = case.corner
                    high = a * (1 - x) * (1 - y) + b * x * (1 - y) + c * (1 - x) * y + d * x * y
                    slack = 0.05 * max(map(abs, case.corner)) if len(line) > 2 else 1e-12
                    assert high > -slack, case


# --- the page


def ink(axes: Any, case: Case) -> None:
    """One cell: the sampled field as ground, the two methods as lines, the corners as signs."""
    if case.hole:
        axes.plot([0, 1, 1, 0, 0], [0, 0, 1, 1, 0], color="#7A8492", linewidth=0.5, linestyle=(0, (4, 3)))
    else:
        axes.imshow(case.above(), origin="lower", extent=(0, 1, 0, 1), cmap=GROUND, vmin=0, vmax=1, interpolation="nearest")
        axes.plot([0, 1, 1, 0, 0], [0, 0, 1, 1, 0], color="#AEB6C0", linewidth=0.5)
        for method, colour, width in (("basic", "#1C6FB5", 0.9), ("shoulder", "#1A1E24", 1.3)):
            for line in case.lines(method).polylines():
                axes.plot(line[:, 0], line[:, 1], color=colour, linewidth=width, solid_capstyle="round", clip_on=False)
    for (x, y), f in zip(((0, 0), (1, 0), (0, 1), (1, 1)), case.corner, strict=True):
        word = "?" if not np.isfinite(f) else "−0+"[int(np.sign(f)) + 1]
        axes.text(x + (x - 0.5) * 0.22, y + (y - 0.5) * 0.22, word, fontsize=6.5, ha="center", va="center", color="#4E5763")
    axes.set_xlim(-0.2, 1.2)
    axes.set_ylim(-0.2, 1.2)
    axes.set_aspect("equal")
    axes.set_axis_off()


GROUND: Any = None


def page() -> NDArray[np.uint8]:
    """All cells on one sheet, (height, width, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    global GROUND
    GROUND = ListedColormap(["#FFFFFF", "#DCE1E7"])
    figure = Figure(figsize=(9.0, 11.0), dpi=150, facecolor="#FFFFFF")
    canvas = FigureCanvasAgg(figure)
    words: dict[str, Any] = {"color": "#1A1E24", "family": "DejaVu Sans"}
    figure.text(0.045, 0.978, "Every case of a bilinear cell", fontsize=13, weight="bold", **words)
    key = "grey: the field, sampled, on or above the level   blue: basic, one chord an arc   black: through the shoulder point"
    figure.text(0.045, 0.962, key, fontsize=7.5, **{**words, "color": "#4E5763"})
    for i, case in enumerate(patterns()):
        row, column = divmod(i, 9)
        ink(figure.add_axes((0.04 + column * 0.1035, 0.862 - row * 0.0875, 0.09, 0.0875 * 0.95)), case)
    figure.text(0.045, 0.136, "Saddle and level, and what else is special", fontsize=9.5, weight="bold", **words)
    for i, case in enumerate(SPECIAL):
        at = 0.04 + i * 0.1035
        ink(figure.add_axes((at, 0.045, 0.09, 0.0875 * 0.95)), case)
        figure.text(at + 0.045, 0.035, case.name, fontsize=6.5, ha="center", va="top", **words)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), np.uint8)[..., :3].copy()


def test_the_page_of_all_cells_is_as_it_was() -> None:
    from PIL import Image

    drawn = page()
    if os.environ.get("NONIUS_WRITE_PAGES"):
        Image.fromarray(drawn).quantize(64).save(PAGE, optimize=True)
    with Image.open(PAGE) as stored:
        before = np.asarray(stored.convert("RGB"), float)
    assert before.shape == drawn.shape
    assert np.abs(before - drawn).mean() < 1.5, "draw it anew with NONIUS_WRITE_PAGES=1, and look at it"


# --- figures 3.3 to 3.12, on the thesis's cell and on a map


def field(values: object) -> Model:
    return interpolate(Samples.from_array(np.asarray(values, float), accuracy=EXACT))


def rough() -> Floats:
    """A map of 30 by 36 samples, as large as the thesis's."""
    y, x = np.mgrid[0:30, 0:36]
    random = np.random.default_rng(34)
    return np.asarray(20 + 14 * np.sin(x / 5) * np.cos(y / 4) + ndimage.gaussian_filter(random.normal(0, 30, x.shape), 1))


LEVELS = (0.1, 17.6, 25.9, 31.9, 38.8)


def drawn(model: Model, method: str, levels: tuple[float, ...]) -> Geometry:
    return contour(model, Progress(), levels=levels, method=method)  # type: ignore[arg-type]  # a word


@pytest.mark.parametrize(("level", "right"), [(17.2, True), (17.6, False)])
def test_figure_3_3_four_triangles_are_right_only_where_centre_and_saddle_are_on_one_side(level: float, right: bool) -> None:
    model = field([[15, 21], [24, 10]])
    got = difference(drawn(model, "basic", (level,)), drawn(model, "four_triangles", (level,)), Progress())
    joined = not got.table.columns["joined in another way"].any()
    assert joined == right
    numbers = dict(zip(got.table.columns["level"], got.table.columns["area"], strict=True))
    assert numbers[level] > 0


def test_figure_3_5_both_ways_lead_to_the_same_shoulder_point() -> None:
    got = cell(f00=0.0, f10=5.0, f01=3.5, f11=30.0, level=6.0, around=0.3)
    at = dict(zip(got.points.values["name"].values, got.points.points[:, :2], strict=True))
    (parallel,) = got.parallels.polylines()
    (median,) = got.medians.polylines()
    for line in (parallel[[0, -1], :2], median[[0, -1], :2]):
        p, q = line
        assert abs((q - p)[0] * (at["R"] - p)[1] - (q - p)[1] * (at["R"] - p)[0]) < 1e-12
    assert np.allclose(parallel[1] - parallel[0], got.chords.polylines()[0][1] - got.chords.polylines()[0][0])
    assert np.allclose(median[-1, :2], at["S"])


def test_figures_3_6_and_3_7_the_triangles_hold_what_the_new_method_gains() -> None:
    model = field(rough())
    new, basic = drawn(model, "shoulder", LEVELS), drawn(model, "basic", LEVELS)
    got = difference(new, basic, Progress())
    areas = [float(g.accuracy.select("area")[0].size().sum()) for g in (basic, new)]
    assert float(got.between.values["area"].values.sum()) == pytest.approx(areas[0] - areas[1], rel=1e-12)
    assert set(got.between.polygons.sizes()) == {3}
    assert not got.between.accuracy.flags  # "the topology is always the same"
    assert areas[1] < areas[0] / 4


def test_figure_3_8_cells_that_four_triangles_join_wrongly_are_found() -> None:
    values = rough()
    values[20:22, 25:27] = [[15, 21], [24, 10]]
    model = field(values)
    got = difference(drawn(model, "shoulder", LEVELS), drawn(model, "four_triangles", LEVELS), Progress())
    wrong = got.table.columns["joined in another way"] == 1
    assert (20 * 35 + 25, 17.6) in set(
        zip(got.table.columns["grid cell"][wrong].tolist(), got.table.columns["level"][wrong].tolist(), strict=True)
    )


def saved() -> Iterator[str]:
    for path in sorted((Path(__file__).resolve().parents[2] / "networks").glob("thesis-3-*.json")):
        yield path.stem


def test_every_figure_of_the_chapter_that_can_be_drawn_is_saved() -> None:
    numbers = {name.split("-")[2] for name in saved()}
    assert numbers == {"01", "03", "04", "05", "06", "07", "08", "09", "10", "11", "12"}
    text = (PAGE.parent / "chapter-3.md").read_text("utf-8")
    missing = [name for name in saved() if name not in text]
    assert not missing, f"chapter-3.md does not say what these are: {missing}"
