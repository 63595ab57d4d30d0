"""Isosurfaces against VTK, scikit-image and PyMCubes: time and triangles, as ratios to vtkFlyingEdges3D in one run.

`nonius bench isosurface`, or `python -m tests.benchmarks.isosurface --sizes 64 128 256`. Array in, mesh out: points and
triangles as numpy arrays (VTK's without a copy). The runs take turns; the shortest of each counts. A second table moves
the level through values whose blocks are indexed, a third tells where our own time goes, a fourth of memory.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.kernels import marching, marching_distance, marching_normals

Floats = npt.NDArray[np.float64]
Draw = Callable[[], int]
HEAD = Path(__file__).parents[3] / "shared" / "data" / "headsq"
"""A head by computed tomography, where it is at hand: 93 slices of 64 x 64 samples of two bytes."""


def fields(n: int) -> dict[str, tuple[Floats, float]]:
    """Values on n^3 samples, and a level."""
    from scipy.ndimage import gaussian_filter

    axis = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    waves = np.sin(6 * x) * np.cos(6 * y) + np.sin(6 * y) * np.cos(6 * z) + np.sin(6 * z) * np.cos(6 * x)
    noise = np.asarray(gaussian_filter(np.random.default_rng(0).normal(size=(n, n, n)), 1.5))
    return {"sphere": (0.7 - np.sqrt(x * x + y * y + z * z), 0.0), "gyroid": (waves, 0.0), "noise": (noise, 0.0)}


def head() -> dict[str, tuple[Floats, float]]:
    """The head's skin and bone; nothing where the slices are not at hand."""
    if not HEAD.is_dir():
        return {}
    slices = [np.fromfile(HEAD / f"quarter.{n}", "<u2").reshape(64, 64) for n in range(1, 94)]
    values = np.array(slices, float)
    return {"skin": (values, 500.5), "bone": (values, 1150.5)}


def shared(threads: int) -> Any:
    """How the slabs are shared."""
    if threads == 1:
        return None
    pool = ThreadPoolExecutor(threads)
    return lambda function, numbers: list(pool.map(function, numbers))


def axes_of(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Coordinates one apart."""
    nz, ny, nx = values.shape
    return np.arange(float(nx)), np.arange(float(ny)), np.arange(float(nz))


def accurate(values: Floats, level: float, threads: int, index: marching.Blocks | None = None) -> Draw:
    """Our accurate method."""
    slabs, (x, y, z) = shared(threads), axes_of(values)
    return lambda: len(marching.surface(values, x, y, z, level, slabs=slabs, index=index).triangles)


def vtk(name: str, values: Floats, level: float) -> Draw:
    """A filter of VTK on the array."""
    from vtkmodules import vtkFiltersCore
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData

    def draw() -> int:
        image = vtkImageData()
        image.SetDimensions(*reversed(values.shape))
        image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=0))
        algorithm = getattr(vtkFiltersCore, name)()
        algorithm.SetInputData(image)
        algorithm.SetValue(0, level)
        algorithm.ComputeNormalsOff()
        algorithm.ComputeGradientsOff()
        algorithm.ComputeScalarsOff()
        algorithm.Update()
        output = algorithm.GetOutput()
        vtk_to_numpy(output.GetPoints().GetData())
        return len(vtk_to_numpy(output.GetPolys().GetConnectivityArray())) // 3

    return draw


def peers(values: Floats, level: float) -> dict[str, Draw]:
    """The others that run in one thread."""
    others = {"VTK MC": vtk("vtkMarchingCubes", values, level)}
    try:
        from skimage.measure import marching_cubes

        others["skimage"] = lambda: len(marching_cubes(values, level)[1])
    except ImportError:
        pass
    try:
        import mcubes

        others["PyMCubes"] = lambda: len(mcubes.marching_cubes(values, level)[1])
    except ImportError:
        pass
    return others


def taking_turns(draws: dict[str, Draw], runs: int) -> dict[str, tuple[float, int]]:
    """The shortest of some runs of each, in seconds, and its triangles."""
    best = dict.fromkeys(draws, (np.inf, 0))
    for _ in range(runs):
        for name, draw in draws.items():
            start = time.perf_counter()
            triangles = draw()
            best[name] = min(best[name], (time.perf_counter() - start, triangles))
    return best


def against_peers(cases: dict[str, tuple[Floats, float]], runs: int) -> None:
    """The first table."""
    from vtkmodules.vtkCommonCore import vtkSMPTools

    print("Times flying edges with as many threads\n")
    print(f"{'field':>8} {'samples':>12} {'threads':>7} {'triangles':>10} {'FE ms':>8} {'ours ms':>8} {'ours':>6} a triangle")
    for name, (values, level) in cases.items():
        size = "x".join(map(str, values.shape))
        for threads in (1, 2):
            vtkSMPTools.Initialize(threads)
            draws = {"FE": vtk("vtkFlyingEdges3D", values, level), "ours": accurate(values, level, threads)}
            best = taking_turns(draws, runs)
            edges, mine = best["FE"], best["ours"]
            ratio, each = mine[0] / edges[0], mine[0] / edges[0] * edges[1] / max(mine[1], 1)
            line = f"{name:>8} {size:>12} {threads:>7} {mine[1]:>10} {1e3 * edges[0]:>8.1f} {1e3 * mine[0]:>8.1f}"
            others = taking_turns(peers(values, level), 1) if threads == 1 else {}
            rest = "  ".join(f"{other} {taken / edges[0]:.1f}" for other, (taken, _) in others.items())
            print(f"{line} {ratio:>6.2f} {each:>10.2f}  {rest}", flush=True)


def moved_level(cases: dict[str, tuple[Floats, float]], runs: int) -> None:
    """The second table: one thread, the level where about 3 % of the cells are active."""
    from vtkmodules.vtkCommonCore import vtkSMPTools

    vtkSMPTools.Initialize(1)
    print("\nA new level on values seen before, one thread, times flying edges\n")
    for name, (values, _) in cases.items():
        start = time.perf_counter()
        index = marching.blocks(values)
        built = time.perf_counter() - start
        levels = np.quantile(values[::4, ::4, ::4], (0.98, 0.995))
        for level in map(float, levels):
            draws = {
                "FE": vtk("vtkFlyingEdges3D", values, level),
                "ours": accurate(values, level, 1),
                "indexed": accurate(values, level, 1, index),
            }
            best = taking_turns(draws, runs)
            active = best["FE"][1] / 2 / values.size
            edges = best["FE"][0]
            print(
                f"{name:>8} {100 * active:>5.1f} % active: {best['ours'][0] / edges:.2f} without the index, "
                f"{best['indexed'][0] / edges:.2f} with it (made once in {1e3 * built:.0f} ms)",
                flush=True,
            )


def stages(cases: dict[str, tuple[Floats, float]]) -> None:
    """The third table: processor time of one thread."""
    print("\nWhere our time goes, one thread, ms\n")
    for name, (values, level) in cases.items():
        taken: dict[str, list[float]] = {}

        def timed(stage: str, function: Callable[..., Any], taken: dict[str, list[float]] = taken) -> Callable[..., Any]:
            def call(*given: Any) -> Any:
                start = time.thread_time()
                result = function(*given)
                taken.setdefault(stage, []).append(time.thread_time() - start)
                return result

            return call

        names = {"first pass": "find", "cells that need thought": "patches", "second pass": "write"}
        kept = {inside: getattr(marching, inside) for inside in names.values()}
        for stage, inside in names.items():
            setattr(marching, inside, timed(stage, kept[inside]))
        (x, y, z) = axes_of(values)
        surface = timed("all", marching.surface)(values, x, y, z, level)
        for inside, function in kept.items():
            setattr(marching, inside, function)
        cell = timed("cell of each triangle", lambda s: s.cell)(surface)
        timed("proof of distance", marching_distance.distances)(
            values, x, y, z, level, surface.points, surface.triangles, cell
        )
        timed("normals", marching_normals.from_nodes)(values, x, y, z, surface.points)
        print(f"{name:>8}  " + "  ".join(f"{stage} {1e3 * sum(times):.1f}" for stage, times in taken.items()), flush=True)


def resident(name: str) -> int:
    """VmRSS, the memory in use, or VmHWM, the most since `forget`: in bytes (Linux)."""
    status = Path("/proc/self/status").read_text()
    return 1024 * int(next(line for line in status.splitlines() if line.startswith(name)).split()[1])


def forget() -> None:
    """Give back what is free, and forget the most that was in use."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5")


def memory(cases: dict[str, tuple[Floats, float]]) -> None:
    """The fourth table: what is in use besides input and output."""
    print("\nMemory, MB: input, output, and the most in use besides, with one and two threads\n")
    if not Path("/proc/self/clear_refs").exists():
        print("not told on this system")
        return
    for name, (values, level) in cases.items():
        besides, output = [], 0
        for threads in (1, 2):
            slabs, (x, y, z) = shared(threads), axes_of(values)
            forget()
            before = resident("VmRSS")
            surface = marching.surface(values, x, y, z, level, slabs=slabs)
            output = surface.points.nbytes + surface.triangles.nbytes
            besides.append(resident("VmHWM") - before - output)
            del surface
        rest = " ".join(f"{n / 1e6:6.1f}" for n in besides)
        print(f"{name:>8}  {values.nbytes / 1e6:6.1f} {output / 1e6:6.1f} {rest}", flush=True)


def main(arguments: Sequence[str] = ()) -> int:
    """Print the tables."""
    from vtkmodules.vtkCommonCore import vtkSMPTools

    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    options.add_argument("--runs", type=int, default=5)
    given = options.parse_args(list(arguments))
    vtkSMPTools.SetBackend("STDThread")
    start = time.process_time()
    marching.warm()
    marching_distance.warm()
    marching_normals.warm()
    print(f"Kernels ready after {time.process_time() - start:.1f} s of processor time\n")
    cases = head()
    against_peers(cases, given.runs)
    for n in given.sizes:
        cases = {**head(), **fields(n)}
        against_peers(fields(n), given.runs)
    moved_level(cases, given.runs)
    stages(cases)
    memory(cases)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
