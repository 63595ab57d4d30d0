"""Particle traces against vtkStreamTracer RK45: processor time and true error in the same run, as ratios.

`nonius bench trace`, or `python -m tests.benchmarks.trace --particles 1000`. Times are of the processor, all threads
together, since the peer uses several. Besides the time at one tolerance the table tells the time at one *true* error: the
peer is made to reach what each of ours reaches, by a smaller error of its own. The judge is our own march at tolerance 1e-12
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

ERRORS = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
"""Of the peer, from which it gets the one that is as good as ours."""

MANY = 20_000
"""From so many particles on each is timed once, and the peer at the first three errors."""

CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("without restarts, 1e-6", {"faces": False, "tolerance": 1e-6}),
    ("without restarts, 1e-7", {"faces": False, "tolerance": 1e-7}),
    ("restarts, 1e-4", {"tolerance": 1e-4}),
    ("restarts, 1e-4, error known", {"tolerance": 1e-4, "assess": True}),
    ("restarts, 1e-6", {"tolerance": 1e-6}),
    ("restarts, 1e-6, error known", {"tolerance": 1e-6, "assess": True}),
    ("restarts, 3(2), 1e-4, error known", {"tolerance": 1e-4, "assess": True, "pair": "Bogacki-Shampine 3(2)"}),
)


def field(n: int) -> tuple[Floats, Floats]:
    """The ABC flow on n^3 samples, and their coordinates along each axis."""
    axis = np.linspace(0.0, 2 * np.pi, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    a, b = np.sqrt(3.0), np.sqrt(2.0)
    return np.stack([a * np.sin(z) + np.cos(y), b * np.sin(x) + a * np.cos(z), np.sin(y) + b * np.cos(x)], axis=-1), axis


def best(function: Callable[[], Any], times: int = 3) -> tuple[float, Any]:
    """The shortest of some runs in seconds of the processor, and what it gave."""
    taken, result = [], None
    for _ in range(times):
        start = time.process_time()
        result = function()
        taken.append(time.process_time() - start)
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
    parser.add_argument("--particles", type=int, nargs="*", default=[1000, 100_000])
    parser.add_argument("--samples", type=int, default=33)
    chosen = parser.parse_args(arguments)
    values, axis = field(chosen.samples)
    flow = trace.flow_of(values, axis, axis, axis)
    for count in chosen.particles:
        seeds = np.random.default_rng(0).uniform(1.0, 5.0, (count, 3))
        judge = trace.march(flow, seeds[:100], trace.rules_of(flow, end=END, tolerance=1e-12, interval=5e-4))
        off_curve = partial(across, cKDTree(judge.points), judge)
        length = float(judge.length.mean())
        peers, again = [], 3 if count < MANY else 1
        asked = ERRORS if count < MANY else ERRORS[:3]
        for error in asked:
            taken, _ = best(vtk(values, axis, seeds, error, length), again)
            off = off_curve(vtk(values, axis, seeds[:100], error, 0.5 * length)().points)
            peers.append((taken, float(np.median(off))))
        first = peers[0][0]
        print(f"{count} particles, {chosen.samples}^3 samples; time over vtkStreamTracer RK45 at 1e-6 ({first * 1e3:.0f} ms)")
        for (taken, level), error in zip(peers, asked, strict=True):
            print(f"  vtkStreamTracer RK45, error {error:.0e}: {taken / first:.2f}; off the curve {level:.1e}")
        for name, rules in CASES:
            known = trace.rules_of(flow, end=END, **rules)
            pair = rules.get("pair", "Dormand-Prince 5(4)")
            taken, _ = best(partial(trace.march, flow, seeds, known, pair), again)
            off = off_curve(trace.march(flow, seeds[:100], known, pair).points)
            level = float(np.median(off))
            equal = next((p for p, error in peers if error <= level), None)
            told = "that error is not reached by the peer" if equal is None else f"{taken / equal:.2f} at equal true error"
            print(f"  {name}: {taken / first:.2f}; off the curve {level:.1e}, at most {off.max():.1e}; {told}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
