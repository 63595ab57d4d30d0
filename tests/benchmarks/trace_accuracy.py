"""True errors of particle traces, and how good their estimates are, against the exact path through the interpolated flow.

`nonius bench trace_accuracy`, or `python -m tests.benchmarks.trace_accuracy --seeds 60`. Errors are parts of the diagonal of
the domain, the largest of each trace. Effectivity is the estimate over the true error at the samples whose error is above
1e-12 of the diagonal.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels import trace
from tests.oracles.traces import Exact, exact

Floats = npt.NDArray[np.float64]
GLAZING = Path(__file__).parents[2] / "networks" / "data" / "double-glazing.vti"

CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("restarts, 1e-2", {"tolerance": 1e-2}),
    ("restarts, 1e-4", {"tolerance": 1e-4}),
    ("restarts, 1e-6", {"tolerance": 1e-6}),
    ("restarts, 1e-8", {"tolerance": 1e-8}),
    ("restarts, 3(2), 1e-6", {"tolerance": 1e-6, "pair": "Bogacki-Shampine 3(2)"}),
    ("without restarts, 1e-4", {"tolerance": 1e-4, "faces": False}),
    ("without restarts, 1e-6", {"tolerance": 1e-6, "faces": False}),
)


class Case(NamedTuple):
    """A field, its axes, seeds and times."""

    values: Floats
    axes: list[Floats]
    seeds: Floats
    times: Floats


class Found(NamedTuple):
    """Largest error of each trace as a part of the diagonal; error and estimate of the samples; counts."""

    worst: Floats
    true: Floats
    estimate: Floats
    assessed: float
    lost: int
    exits: tuple[int, int, float]
    evaluations: float


def fields(count: int) -> dict[str, Case]:
    """ABC 33^3, Taylor-Green 33^3, the double glazing."""
    random = np.random.default_rng(0)
    axis = np.linspace(0.0, 2 * np.pi, 33)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    a, b = np.sqrt(3.0), np.sqrt(2.0)
    abc = np.stack([a * np.sin(z) + np.cos(y), b * np.sin(x) + a * np.cos(z), np.sin(y) + b * np.cos(x)], axis=-1)
    green = np.stack([np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z), 0 * z], axis=-1)
    inside = random.uniform(1.0, 5.0, (count, 3))
    found = {
        "ABC 33^3": Case(abc, [axis] * 3, inside, 0.05 * np.arange(1.0, 41.0)),
        "Taylor-Green 33^3": Case(green, [axis] * 3, inside, 0.1 * np.arange(1.0, 41.0)),
    }
    values, axes = glazing()
    low, high = (np.array([a[end] for a in axes]) for end in (0, -1))
    seeds = low + (high - low) * random.uniform(0.1, 0.9, (count, 3))
    speed = float(np.sqrt((values**2).sum(axis=-1).mean()))
    end = 2 * float(np.linalg.norm(high - low)) / speed
    return {**found, "double glazing 10x10x18": Case(values, axes, seeds, end / 40 * np.arange(1.0, 41.0))}


def glazing() -> tuple[Floats, list[Floats]]:
    """The velocity between two sheets of glass, and its axes."""
    import pyvista

    read = pyvista.read(GLAZING)
    nx, ny, nz = read.dimensions
    values = np.asarray(read.point_data["velocity"], float).reshape(nz, ny, nx, 3)
    axes = [o + h * np.arange(n) for o, h, n in zip(read.origin, read.spacing, read.dimensions, strict=True)]
    return values, axes


def judged(case: Case, true: Exact, pair: str = "Dormand-Prince 5(4)", **rules: Any) -> Found:
    """A march with its estimates against the exact one."""
    flow = trace.flow_of(case.values, *case.axes)
    interval, end = float(case.times[0]), float(case.times[-1])
    checked = trace.rules_of(flow, pair=pair, end=end, interval=interval, assess=True, **rules)
    run = trace.march(flow, case.seeds, checked, pair)
    diagonal = float(np.linalg.norm([np.ptp(a) for a in case.axes]))
    left = np.array([trace.REASONS[r] == "left the domain" for r in run.reason])
    worst, pairs, assessed, lost, late = np.zeros(len(case.seeds)), [], [], 0, 0.0
    for i in range(len(case.seeds)):
        rows = np.arange(run.offsets[i] + 1, run.offsets[i + 1] - int(left[i]))
        at = np.rint(run.time[rows] / interval).astype(int) - 1
        away = np.linalg.norm(run.points[rows] - true.points[i, at], axis=1) / diagonal
        away = away[np.isfinite(away)]
        worst[i] = away.max(initial=0.0)
        lost += int(np.isfinite(true.points[i]).all(axis=1).sum()) - len(away)
        pairs.append(np.column_stack([away, np.linalg.norm(run.error[rows], axis=1)[: len(away)] / diagonal]))
        assessed.append(run.time[rows] <= run.trusted[i])
        if left[i] and np.isfinite(true.left[i]):
            late = max(late, abs(run.time[run.offsets[i + 1] - 1] - true.left[i]) / end)
    both, really = np.concatenate(pairs), np.isfinite(true.left)
    exits = int((really & ~left).sum()), int((left & ~really).sum()), late
    trusted, cost = float(np.concatenate(assessed).mean()), float(run.evaluations.mean())
    return Found(worst, both[:, 0], both[:, 1], trusted, lost, exits, cost)


def told(found: Found) -> str:
    """One line."""
    some = found.true > 1e-12
    ratio = found.estimate[some] / found.true[some]
    low, middle, high = np.quantile(ratio, (0.05, 0.5, 0.95)) if some.any() else (np.nan,) * 3
    within = float(((ratio > 0.5) & (ratio < 2)).mean()) if some.any() else np.nan
    covered = float((2 * found.estimate >= found.true - 1e-14).mean())
    missed, false, late = found.exits
    return (
        f"error median {np.median(found.worst):.1e}, largest {found.worst.max():.1e}; {found.evaluations:.0f} evaluations; "
        f"assessed {found.assessed:.0%}; effectivity {middle:.2f} [{low:.2f}, {high:.2f}], {within:.0%} within 0.5 to 2; "
        f"twice it covers {covered:.0%}; {found.lost} samples lost, {missed} exits missed, {false} false, time {late:.0e}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line a method and field."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=30)
    chosen = parser.parse_args(arguments)
    for name, case in fields(chosen.seeds).items():
        true = exact(case.values, case.axes, case.seeds, case.times)
        print(f"{name}: {chosen.seeds} traces, {int(np.isfinite(true.left).sum())} leave the domain")
        for words, rules in CASES:
            print(f"  {words}: {told(judged(case, true, **rules))}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
