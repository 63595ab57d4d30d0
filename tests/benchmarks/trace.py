"""Particle traces against vtkStreamTracer RK45: time and true error in the same run, as ratios.

`nonius bench trace`, or `python -m tests.benchmarks.trace --particles 1000`. The judge is our own march at tolerance 1e-12
with restarts, which the tests hold against DOP853. VTK is judged by how far its points lie from the true curve, since
its times are of first order only.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from modules.kernels import trace

Floats = npt.NDArray[np.float64]
END = 2.0
"""Time of our traces; those of the peer get the mean length of these."""


def field(n: int) -> tuple[Floats, Floats]:
    """The ABC flow on n^3 samples, and their coordinates along each axis."""
    axis = np.linspace(0.0, 2 * np.pi, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    a, b = np.sqrt(3.0), np.sqrt(2.0)
    return np.stack([a * np.sin(z) + np.cos(y), b * np.sin(x) + a * np.cos(z), np.sin(y) + b * np.cos(x)], axis=-1), axis


def best(function: Callable[[], Any], times: int = 3) -> tuple[float, Any]:
    """The shortest of some runs in seconds, and what it gave."""
    taken, result = [], None
    for _ in range(times):
        start = time.perf_counter()
        result = function()
        taken.append(time.perf_counter() - start)
    return min(taken), result


def vtk(values: Floats, axis: Floats, seeds: Floats, error: float, length: float) -> Callable[[], Any]:
    """vtkStreamTracer, Runge-Kutta 4(5), to a length: it cannot be told a time."""
    import pyvista

    n, h = len(axis), axis[1] - axis[0]
    image = pyvista.ImageData(dimensions=(n, n, n), spacing=(h, h, h))
    image["v"] = values.reshape(-1, 3)
    image.set_active_vectors("v")
    source = pyvista.PolyData(seeds)
    return lambda: image.streamlines_from_source(
        source, vectors="v", integrator_type=45, integration_direction="forward", max_length=length, max_error=error,
        max_steps=100_000,
    )  # fmt: skip


def across(tree: Any, judge: trace.Traces, points: Floats) -> Floats:
    """(n,) distance of points from the true curves, as a part of the diagonal: across the velocity at the nearest point."""
    near = tree.query(points)[1]
    away = points - judge.points[near]
    u = judge.velocity[near] / np.linalg.norm(judge.velocity[near], axis=1, keepdims=True)
    off = np.linalg.norm(away - (away * u).sum(axis=1, keepdims=True) * u, axis=1)
    return np.asarray(off / (2 * np.pi * np.sqrt(3.0)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line a method."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--particles", type=int, nargs="*", default=[1000])
    parser.add_argument("--samples", type=int, default=33)
    chosen = parser.parse_args(arguments)
    values, axis = field(chosen.samples)
    flow = trace.flow_of(values, axis, axis, axis)
    for count in chosen.particles:
        seeds = np.random.default_rng(0).uniform(1.0, 5.0, (count, 3))
        judge = trace.march(flow, seeds[:100], trace.rules_of(flow, end=END, tolerance=1e-12, interval=2e-3))
        off_curve = partial(across, cKDTree(judge.points), judge)
        length = float(judge.length.mean())
        peer, _ = best(vtk(values, axis, seeds, 1e-6, length))
        print(f"{count} particles, {chosen.samples}^3 samples; time over that of vtkStreamTracer RK45 ({peer * 1e3:.0f} ms)")
        few = vtk(values, axis, seeds[:100], 1e-6, 0.5 * length)()
        off = off_curve(few.points)
        print(f"  vtkStreamTracer RK45, error 1e-6: 1.00; off the curve {np.median(off):.1e}, at most {off.max():.1e}")
        for name, rules in (
            ("without restarts, 1e-6", {"faces": False}),
            ("restarts, 1e-6", {}),
            ("restarts, 1e-6, error known", {"assess": True}),
        ):
            known = trace.rules_of(flow, end=END, tolerance=1e-6, **rules)  # type: ignore[arg-type]  # rules of all kinds
            taken, _ = best(partial(trace.march, flow, seeds, known))
            off = off_curve(trace.march(flow, seeds[:100], known).points)
            print(f"  {name}: {taken / peer:.2f}; off the curve {np.median(off):.1e}, at most {off.max():.1e}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
