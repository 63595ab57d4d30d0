"""Isosurfaces held against the topology of the trilinear model, by an oracle that shares no table with the methods.

`nonius bench topology`, or `python -m tests.benchmarks.topology --random 1000 --methods accurate decider flying_edges`. Grids
of random numbers, grids padded by a constant layer, integers with ties, and real volumes where `../shared/data` is there.
Prints, for each method, the grids with a fault and the faults.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.kernels import marching
from modules.mappers._isosurface_methods import draw
from modules.progress import Progress
from tests.oracles import topology

Floats = npt.NDArray[np.float64]
Mesh = tuple[Floats, npt.NDArray[np.int64], npt.NDArray[np.int64]]
DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def axes_of(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Lattice coordinates."""
    x, y, z = (np.arange(float(n)) for n in reversed(values.shape))
    return x, y, z


def method(name: str) -> Callable[[Floats, float], tuple[Mesh, float]]:
    """A method by name: (values, level) -> points, triangles, cells; and the level it has drawn."""

    def mesh(values: Floats, level: float) -> tuple[Mesh, float]:
        if name == "accurate":
            drawn = marching.surface(values, *axes_of(values), level)
            return (drawn.points, drawn.triangles, drawn.cell), drawn.level
        return draw(name, values, axes_of(values), level, 2, Progress()), level

    return mesh


def is_whole(values: Floats, level: float, mesh: Mesh) -> bool:
    """Whether Euler characteristic and, for a closed surface, components agree with the grid subdivided as one."""
    points, triangles, _ = mesh
    chi = topology.euler(len(points), triangles)
    closed = topology.boundary_loops(len(points), triangles) == 0
    pieces = topology.components(len(points), triangles) if len(points) else 0
    for k in (8, 16, 32):
        told, regions = topology.whole(values, level, k)
        if chi == told and (not closed or pieces == regions - 1):
            return True
    return False


def random_grids(name: str, kind: str, count: int, seed: int) -> None:
    """One line: how many grids of a kind have a fault, and which."""
    mesh, bad, faults, tunnels, cells = method(name), 0, Counter[str](), 0, 0
    start = time.perf_counter()
    for values in topology.grids(kind, count, seed):
        found, level = mesh(values, 0.0)
        tied = bool((values == level).any())
        verdict = topology.judged(values, axes_of(values), level, found, ties=tied)
        seen = kind != "ties" and verdict.right and verdict.finest <= 8  # thinner parts the whole would not show
        if seen and not is_whole(values, 0.0, found):
            verdict.wrong["another whole"] = 1
        bad += not verdict.right
        for corner in verdict.examples:
            print(f"{name:14} a cell of another topology: {corner.tolist()}")
        faults.update({name: n for name, n in verdict.wrong.items() if n})
        tunnels, cells = tunnels + verdict.tunnels, cells + verdict.cells
    words = ", ".join(f"{n} {name}" for name, n in faults.most_common()) or "no fault"
    seconds = time.perf_counter() - start
    of = f"{cells:7} cells {tunnels:5} tunnels"
    print(f"{name:14} {count:5} {kind:10} {bad:5} bad   {of}   {words}   {seconds:.0f} s", flush=True)


def volumes() -> Iterator[tuple[str, Floats, tuple[float, ...]]]:
    """Real volumes with their levels, whole and half."""
    head = DATA / "headsq"
    if head.is_dir():
        slices = [np.fromfile(head / f"quarter.{n}", "<u2").reshape(64, 64) for n in range(1, 94)]
        yield "CT head", np.stack(slices).astype(float), (500.0, 500.5, 1150.0, 1150.5)
        eight = np.clip(np.stack(slices) >> 4, 0, 255).astype(float)
        yield "CT head, 8 bits", eight, (31.0, 31.5, 71.0, 71.5)


def real(name: str) -> None:
    """One line for each volume and level."""
    if not DATA.is_dir():
        print("real volumes: left out, ../shared/data is absent")
    mesh = method(name)
    for title, values, levels in volumes():
        for level in levels:
            start = time.perf_counter()
            (points, triangles, _), drawn = found = mesh(values, level)
            tied = bool((values == drawn).any())
            verdict = topology.judged(values, axes_of(values), drawn, found[0], ties=tied)
            n = len(points)
            shape = f"{topology.components(n, triangles)} pieces, Euler {topology.euler(n, triangles)}"
            shape += f", {topology.boundary_loops(n, triangles)} loops"
            seconds = time.perf_counter() - start
            cells = f"{verdict.cells:6} cells {verdict.tunnels:4} tunnels"
            print(f"{name:14} {title:16} {level:7g}   {cells}, {shape}: {verdict}   {seconds:.0f} s", flush=True)


def main(arguments: Sequence[str] = ()) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=1000)
    parser.add_argument("--padded", type=int, default=300)
    parser.add_argument("--ties", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-volumes", action="store_true")
    parser.add_argument("--methods", nargs="+", default=["accurate"])
    given = parser.parse_args(list(arguments))
    for name in given.methods:
        random_grids(name, "normal", given.random // 2, given.seed)
        random_grids(name, "log-normal", given.random - given.random // 2, given.seed + 1)
        random_grids(name, "padded", given.padded, given.seed + 2)
        random_grids(name, "ties", given.ties, given.seed + 3)
        if not given.no_volumes:
            real(name)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
