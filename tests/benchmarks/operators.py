"""The price of knowing: a whole error budget at isosurface-like rows against the smoothing that made the field.

`nonius bench operators` prints ratios within one run; absolute times mean nothing on a shared machine.
"""

from __future__ import annotations

import argparse
import sys
import time
import tracemalloc
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.data.accuracy import Accuracy, bound, deviation
from modules.data.operators import Chain, Gather, Operator, stencil

TAPS = np.array([0.25, 0.5, 0.25])
Floats = NDArray[np.float64]


def gyroid(n: int) -> Floats:
    """A gyroid of 32 samples a period with noise, (n, n, n): its surface crosses 2.5 million edges at n = 256."""
    t = 2 * np.pi / 32 * np.arange(n)
    z, y, x = np.meshgrid(t, t, t, indexing="ij", sparse=True)
    field = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return np.asarray(field + 0.1 * np.random.default_rng(0).normal(size=field.shape))


def smooth(field: Floats) -> Floats:
    """The separable smoothing by [1 2 1]/4 along each axis."""
    for axis in range(field.ndim):
        field = correlate1d(field, TAPS, axis=axis, mode="nearest")
    return field


def smoothing(shape: tuple[int, ...]) -> Operator:
    """The same as an operator."""
    steps = [stencil(shape, axis, (-1, 0, 1), TAPS.tolist()) for axis in range(len(shape))]
    operator: Operator = steps[0]
    for step in steps[1:]:
        operator = step.after(operator)
    return operator


def crossings(field: Floats) -> Gather:
    """A row for each grid edge on which the field changes sign: the displacement of an isosurface's vertices."""
    index, weight = [], []
    flat = field.ravel()
    numbers = np.arange(field.size).reshape(field.shape)
    for axis in range(3):
        low = numbers.take(range(field.shape[axis] - 1), axis).ravel()
        high = numbers.take(range(1, field.shape[axis]), axis).ravel()
        hit = (flat[low] > 0) != (flat[high] > 0)
        low, high = low[hit].astype(np.int32), high[hit].astype(np.int32)
        step = flat[high] - flat[low]
        u = -flat[low] / step
        index.append(np.column_stack([low, high]))
        weight.append(np.column_stack([(1 - u) / step, u / step]))
    return Gather(np.concatenate(index), np.concatenate(weight), field.size)


def measure(n: int) -> dict[str, float]:
    """Ratios for an n^3 field: budget / smoothing, extra memory in MB, rows."""
    field = gyroid(n)
    smooth(field[:8])
    start = time.perf_counter()
    smoothed = smooth(field)
    reference = time.perf_counter() - start
    rows = crossings(smoothed)
    accuracy = Accuracy().add(deviation("sensor", 0.1, field.size))
    pushed = accuracy.push(Chain(smoothing(field.shape), rows))
    pushed.budget(items=2000)
    start = time.perf_counter()
    lines = pushed.budget()
    spent = time.perf_counter() - start
    tracemalloc.start()
    pushed.budget()
    extra = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    proven = Accuracy().add(bound("rounding", 0.5, field.size)).push(Chain(smoothing(field.shape), rows))
    start = time.perf_counter()
    proven.budget(items=2000)
    glance = time.perf_counter() - start
    assert lines[0].count == len(rows.index)
    return {
        "rows": float(len(rows.index)),
        "budget / smoothing": spent / reference,
        "extra memory, MB": extra / 2**20,
        "glance of a bound / smoothing": glance / reference,
    }


def main(arguments: Sequence[str] = ()) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="*", default=[64, 256])
    for n in parser.parse_args(list(arguments)).sizes:
        for name, value in measure(n).items():
            print(f"{n}^3  {name:32} {value:12.3g}")
    return 0


if __name__ == "__main__":
    import sys

    sys.exit(main(sys.argv[1:]))
