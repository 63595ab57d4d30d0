"""What all linear smoothings share: the same matrix for values and errors, and what it takes from the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any

from scipy.sparse import csr_array, eye_array

from modules.api import Operator, Progress, Samples, Source, Sum, along
from modules.data.grid import Axial
from modules.data.operators import Floats
from modules.modellers._linear import carried, dimension, estimated, lattice_of

RULE = "what smoothing takes from the field that twicing restores; low where a detail is narrower than the window [twicing/1]"


def smoothed(
    samples: Samples,
    grid: Axial,
    axes: tuple[int, ...],
    matrix: Callable[[Floats], Any],
    what: str,
    progress: Progress,
    passes: int = 1,
) -> Samples:
    """The samples after a small matrix along each of some axes, with an estimate of what that takes from the truth.

    With S the smoothing and R = 2 S - S^2 what restores the field best from its smoothing, the bias S - 1 is that of R y.
    It is a sum over the axes of products along them: (S_x - 1) + S_x (S_y - 1) + S_x S_y (S_z - 1).

    Parameters
    ----------
    matrix : coordinates of an axis -> (m, m) sparse
    what : name of the error
    """
    if not passes:
        return samples
    once = {a: csr_array(matrix(grid.axes[a])) for a in axes}
    smooth = {a: reduce(lambda p, q: p @ q, [m] * passes) for a, m in once.items()}
    progress(0.1)
    result = carried(samples, _product(samples, grid, smooth))
    progress(0.5)
    restored = {a: 2 * s - s @ s for a, s in smooth.items()}
    parts = []
    for place, axis in enumerate(axes):
        part = dict(restored)
        for before in axes[:place]:
            part[before] = smooth[before] @ restored[before]
        part[axis] = (smooth[axis] - eye_array(smooth[axis].shape[0])) @ restored[axis]
        parts.append(_product(samples, grid, part))
    return estimated(result, samples, Sum(tuple(parts)), Source(what, "model", "estimated", RULE))


def _product(samples: Samples, grid: Axial, matrices: Mapping[int, Any]) -> Operator:
    lattice = lattice_of(samples)
    steps: list[Operator] = [along(lattice, dimension(grid, axis), matrix) for axis, matrix in matrices.items()]
    return reduce(lambda first, then: then.after(first), steps)
