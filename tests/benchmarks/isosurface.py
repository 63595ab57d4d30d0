"""Isosurfaces against VTK's flying edges and scikit-image: time and triangles, as ratios within one run.

`nonius bench isosurface`, or `python -m tests.benchmarks.isosurface --sizes 64 128`. Array in, mesh out.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.kernels import marching

Floats = npt.NDArray[np.float64]
Draw = Callable[[Floats], int]


def fields(n: int) -> dict[str, Floats]:
    """Values on n^3 samples; the level is 0."""
    from scipy.ndimage import gaussian_filter

    axis = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    waves = np.sin(6 * x) * np.cos(6 * y) + np.sin(6 * y) * np.cos(6 * z) + np.sin(6 * z) * np.cos(6 * x)
    noise = np.asarray(gaussian_filter(np.random.default_rng(0).normal(size=(n, n, n)), 1.5))
    return {"sphere": 0.7 - np.sqrt(x * x + y * y + z * z), "gyroid": waves, "noise": noise}


def ours(threads: int) -> Draw:
    """The accurate method."""
    pool = ThreadPoolExecutor(threads)
    slabs = (lambda function, numbers: list(pool.map(function, numbers))) if threads > 1 else None

    def draw(values: Floats) -> int:
        axes = [np.arange(float(n)) for n in reversed(values.shape)]
        return len(marching.surface(values, axes[0], axes[1], axes[2], 0.0, slabs=slabs).triangles)

    return draw


def flying_edges(values: Floats) -> int:
    """VTK's fastest."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    image = vtkImageData()
    image.SetDimensions(*reversed(values.shape))
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=0))
    algorithm = vtkFlyingEdges3D()
    algorithm.SetInputData(image)
    algorithm.SetValue(0, 0.0)
    algorithm.ComputeNormalsOff()
    algorithm.ComputeGradientsOff()
    algorithm.ComputeScalarsOff()
    algorithm.Update()
    return int(algorithm.GetOutput().GetNumberOfCells())


def scikit_image(values: Floats) -> int:
    """Marching cubes with 33 cases."""
    from skimage.measure import marching_cubes

    return len(marching_cubes(values, 0.0)[1])


def best(draw: Draw, values: Floats, runs: int) -> tuple[float, int]:
    """The shortest of some runs, in seconds, and the number of triangles."""
    times, triangles = [], 0
    for _ in range(runs):
        start = time.perf_counter()
        triangles = draw(values)
        times.append(time.perf_counter() - start)
    return min(times), triangles


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    from vtkmodules.vtkCommonCore import vtkSMPTools

    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    options.add_argument("--runs", type=int, default=5)
    given = options.parse_args(arguments)
    vtkSMPTools.SetBackend("STDThread")
    marching.warm()
    titles = ("field", "samples", "threads", "triangles", "ms")
    print("{:>8} {:>8} {:>7} {:>10} {:>8}   times flying edges   a triangle   times skimage".format(*titles))
    for n in given.sizes:
        for name, values in fields(n).items():
            for threads in (1, 2):
                vtkSMPTools.Initialize(threads)
                mine, edges = best(ours(threads), values, given.runs), best(flying_edges, values, given.runs)
                other = best(scikit_image, values, 1)
                ratio = mine[0] / edges[0]
                print(
                    f"{name:>8} {n:>6}^3 {threads:>7} {mine[1]:>10} {1e3 * mine[0]:>8.1f} {ratio:>20.2f} "
                    f"{ratio * edges[1] / max(mine[1], 1):>12.2f} {mine[0] / other[0]:>15.2f}"
                )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
