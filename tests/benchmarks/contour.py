"""Contour lines against contourpy and scikit-image: time, area and pieces, each as a ratio within one run.

`nonius bench contour`, or `python -m tests.benchmarks.contour --sizes 1024 4096`. The judge knows nothing of shoulder
points: on many columns it compares where a method's lines cross with where the bilinear interpolant does.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.kernels import arcs, contour

Floats = npt.NDArray[np.float64]
Lines = list[Floats]


class Method(NamedTuple):
    """A way to draw contours: values -> (level -> what the method itself returns), and that as a list of lines."""

    prepare: Callable[[Floats], Callable[[float], Any]]
    lines: Callable[[Any], Lines]


COLUMNS = 12
"""Of the judge, in each cell."""


def field(kind: str, n: int) -> Floats:
    """Waves, (n, n); `noisy` has 2 % of noise, `rough` is noise alone."""
    y, x = np.mgrid[0:n, 0:n] / n
    waves = np.sin(9 * x + 0.2) * np.cos(7 * y) + 0.5 * np.sin(20 * x * y)
    noise = np.random.default_rng(0).standard_normal((n, n))
    return np.asarray({"smooth": waves, "noisy": waves + 0.02 * noise, "rough": noise}[kind])


def ours(shoulder: bool) -> Method:
    def draw(values: Floats, level: float) -> contour.ContourLines:
        y, x = (np.arange(float(n)) for n in values.shape)
        return contour.lines(values, x, y, level, shoulder)

    def split(drawn: contour.ContourLines) -> Lines:
        return np.split(drawn.points, drawn.offsets[1:-1]) if len(drawn.points) else []

    return Method(lambda values: lambda level: draw(values, level), split)


def contourpy(line_type: str, **options: object) -> Method:
    from contourpy import contour_generator, convert_lines

    def prepare(values: Floats) -> Callable[[float], Any]:
        return contour_generator(z=values, name="serial", line_type=line_type, **options).lines  # type: ignore[no-any-return]  # untyped

    return Method(prepare, lambda drawn: list(convert_lines(drawn, line_type, "Separate")))


def skimage() -> Method:
    from skimage.measure import find_contours

    return Method(
        lambda values: lambda level: find_contours(values, level),
        lambda drawn: [line[:, ::-1] for line in drawn],
    )


def methods() -> dict[str, Method]:
    """Those that are installed; the first is the peer of the ratios."""
    found: dict[str, Method] = {}
    try:
        found["contourpy serial"] = contourpy("Separate")
        found["contourpy serial, joined"] = contourpy("ChunkCombinedOffset")
        found["contourpy quad_as_tri"] = contourpy("Separate", quad_as_tri=True)
    except ImportError:
        print("contourpy is not installed: no ratios to it")
    found["shoulder"] = ours(True)
    found["basic"] = ours(False)
    try:
        found["skimage"] = skimage()
    except ImportError:
        print("scikit-image is not installed")
    return found


def wrong_area(values: Floats, level: float, lines: Lines) -> float:
    """The area, in cells, where the side told by the lines differs from the sign of F - level.

    Along a column of fixed x the interpolant is linear from row to row, so its crossings are exact; where an odd number
    of crossings of either kind lies below, the sides differ.
    """
    nx = values.shape[1]
    at = (np.arange((nx - 1) * COLUMNS) + 0.5) / COLUMNS
    i, u = at.astype(int), at % 1.0
    along = values[:, i] * (1 - u) + values[:, i + 1] * u
    row, column = np.nonzero((along[:-1] >= level) != (along[1:] >= level))
    f, g = along[row, column], along[row + 1, column]
    columns, heights = [column], [row + (level - f) / (g - f)]
    for line in lines:
        p, q = line[:-1], line[1:]
        low, high = np.minimum(p[:, 0], q[:, 0]), np.maximum(p[:, 0], q[:, 0])
        first = np.ceil(low * COLUMNS - 0.5).astype(int)
        count = np.maximum(np.ceil(high * COLUMNS - 0.5).astype(int) - first, 0)
        k = np.repeat(np.arange(len(p)), count)
        c = first[k] + np.arange(len(k)) - np.repeat(np.cumsum(count) - count, count)
        t = (at[c] - p[k, 0]) / (q[k, 0] - p[k, 0])
        columns.append(c)
        heights.append(p[k, 1] + t * (q[k, 1] - p[k, 1]))
    c, y = np.concatenate(columns), np.concatenate(heights)
    order = np.lexsort((y, c))
    assert (np.bincount(c) % 2 == 0).all(), "a line ends inside the grid"
    return float(np.diff(y[order].reshape(-1, 2), axis=1).sum() / COLUMNS)


def exact_pieces(values: Floats, level: float) -> int:
    """The number of contour lines: parts above plus parts below, less one; saddles by their value (3.4)."""
    ny, nx = values.shape
    index = np.arange(ny * nx).reshape(ny, nx)
    high = (values >= level).ravel()
    f00, f10, f01, f11 = values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        saddle = (f00 * f11 - f10 * f01) / (f00 + f11 - f10 - f01) >= level
    main = saddle == (f00 >= level)  # which diagonal is joined, if the corners alternate
    pairs = [
        (index[:, :-1], index[:, 1:]),
        (index[:-1], index[1:]),
        (np.where(main, index[:-1, :-1], index[:-1, 1:]), np.where(main, index[1:, 1:], index[1:, :-1])),
    ]
    p, q = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    same = high[p] == high[q]
    graph = coo_array((np.ones(same.sum()), (p[same], q[same])), shape=(ny * nx, ny * nx))
    return int(connected_components(graph, directed=False)[0]) - 1


def pieces_off(kind: str, n: int) -> tuple[int, int]:
    """(pieces too many or too few, pieces) of our lines on an n^2 grid, at a level that no node has."""
    random = np.random.default_rng(7)
    if kind == "integers":
        values: Floats = random.integers(-2, 3, (n, n)).astype(float)
    else:
        values = random.normal(size=(n, n))
    if kind == "ratios":
        values = np.exp(3 * values) * random.choice([-1.0, 1.0], (n, n))
    level = 0.5 if kind == "integers" else 0.1
    drawn = contour.lines(values, np.arange(float(n)), np.arange(float(n)), level)
    exact = exact_pieces(values, level)
    return len(drawn.offsets) - 1 - exact, exact


def real_maps() -> dict[str, Floats]:
    """The elevation data that come with matplotlib."""
    import matplotlib

    folder = Path(matplotlib.__file__).parent / "mpl-data" / "sample_data"
    with np.load(folder / "jacksboro_fault_dem.npz") as one, np.load(folder / "topobathy.npz") as two:
        return {"Jacksboro": one["elevation"].astype(float), "topobathy": two["topo"].astype(float)}


def farthest(values: Floats, shoulder: bool) -> float:
    """The largest distance of a line from the exact contour, in cells, over twenty levels of a map."""
    x, y = (np.arange(float(n)) for n in reversed(values.shape))
    reach = 0.0
    for level in np.linspace(values.min(), values.max(), 22)[1:-1] + 0.25:
        drawn = contour.lines(values, x, y, float(level), shoulder)
        keep = np.ones(max(0, len(drawn.points) - 1), bool)
        keep[drawn.offsets[1:-1] - 1] = False
        step = np.diff(drawn.points, axis=0)[keep]
        reach = max(reach, float(arcs.sagitta(step[:, 0], step[:, 1], drawn.bend).max(initial=0.0)))
    return reach


def two_threads(values: Floats, levels: Sequence[float]) -> None:
    """Our lines of all levels on two threads."""
    n, m = values.shape
    x, y = np.arange(float(m)), np.arange(float(n))
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda level: contour.lines(values, x, y, level), levels))


def main(arguments: Sequence[str] = ()) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="*", default=[1024])
    parser.add_argument("--judged", type=int, default=300, help="size of the grids for area and pieces")
    options = parser.parse_args(list(arguments))
    runners = methods()
    ours(True).prepare(field("rough", 8))(0.0)  # compile
    levels = np.linspace(-1.3, 1.3, 10).tolist()
    for size in options.sizes:
        for kind in ("smooth", "noisy"):
            values = field(kind, size)
            peer = 0.0
            for name, method in runners.items():
                if name == "skimage" and size > 1024:
                    continue
                spent, drawn = np.inf, []
                for _ in range(2):
                    start = time.perf_counter()
                    draw = method.prepare(values)
                    drawn = [draw(level) for level in levels]
                    spent = min(spent, time.perf_counter() - start)
                points = sum(len(line) for each in drawn for line in method.lines(each))
                peer = peer or spent
                print(f"{kind:7} {size}^2  {name:24} {spent / peer:6.2f} x time, {points:9} points")
            start = time.perf_counter()
            two_threads(values, levels)
            print(f"{kind:7} {size}^2  {'shoulder, 2 threads':24} {(time.perf_counter() - start) / peer:6.2f} x time")
    for kind in ("smooth", "rough"):
        values, level = field(kind, options.judged), 0.1
        basic = wrong_area(values, level, ours(False).lines(ours(False).prepare(values)(level)))
        pieces = exact_pieces(values, level)
        for name, method in runners.items():
            lines = method.lines(method.prepare(values)(level))
            area = wrong_area(values, level, lines) / basic
            print(f"{kind:7} {options.judged}^2  {name:24} {area:6.3f} x area, {len(lines) - pieces:+6} of {pieces} pieces")
    for kind in ("normal", "integers", "ratios"):
        off, pieces = pieces_off(kind, 1001)
        print(f"{kind:9} 10^6 cells  {off:+d} of {pieces} pieces")
    for name, values in real_maps().items():
        two, one = farthest(values, True), farthest(values, False)
        print(f"{name:10} farthest from the contour: {two:.3f} cell; one chord a cell {one:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
