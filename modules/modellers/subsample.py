"""Fewer samples: every n-th one, or the mean of each block."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array

from modules.api import Annotated, Literal, Operator, Range, Rectilinear, Regular, Samples, Source, Sum, along, modeller
from modules.data.grid import Axial
from modules.data.operators import Floats, Ints, fixed
from modules.modellers._lattice import mixing, taken
from modules.modellers._linear import axial, dimension, estimated, lattice_of
from modules.modellers._weights import second_derivative

RULE = "half the variance of the coordinates in a block times the mean of its second derivatives [block-mean/1]"


@modeller("Subsample", output="samples", aliases=("stride", "thin out", "decimate", "downsample", "block mean"))
def subsample(
    samples: Samples,
    *,
    stride: Annotated[tuple[int, ...], Range(1, 64)] = (2,),
    method: Literal["pick", "mean"] = "pick",
) -> Samples:
    """Every n-th sample along each axis, or the mean of each block of n.

    Samples at the end that fill no whole block are left out of the means.

    Parameters
    ----------
    samples : of a regular or rectilinear grid
    stride : how many become one, along x, y[, z]; one number serves all axes
    method : pick, the first of every n; or mean, in the middle of each block

    Raises
    ------
    ValueError : a bent or unstructured grid, a stride below 1 or longer than its axis

    Accuracy: samples that are picked keep their errors and nothing is added: what was left out is missed between
    samples, where the law of a model estimates it from those that remain. Means average the errors, and add what a mean
    differs from the value in the middle, estimated with its sign from second derivatives.
    Source: a choice of rows; mean over a block, Taylor to second order.
    """
    grid = axial(samples, "subsampling")
    strides = stride * len(grid.axes) if len(stride) == 1 else stride
    if len(strides) != len(grid.axes):
        raise ValueError(f"stride should be one number, or {len(grid.axes)}, as the data has {len(grid.axes)} axes")
    for name, x, s in zip(grid.frame.axes, grid.axes, strides, strict=False):
        if not 1 <= s <= len(x):
            raise ValueError(f"stride {s} along {name} should be 1 to {len(x)}, the number of its samples")
    lattice = lattice_of(samples)
    if method == "pick":
        kept: list[Ints] = [np.arange(0, len(x), s)[:, None] for x, s in zip(grid.axes, strides, strict=True)]
        places = [x[k[:, 0]] for x, k in zip(grid.axes, kept, strict=True)]
        return taken(samples, _grid(grid, strides, places), [(k, np.ones(k.shape)) for k in kept], lattice)
    return _means(samples, grid, strides, lattice)


def _means(samples: Samples, grid: Axial, strides: tuple[int, ...], lattice: tuple[int, ...]) -> Samples:
    blocks = [np.arange(len(x) // s * s).reshape(-1, s) for x, s in zip(grid.axes, strides, strict=True)]
    parts: list[tuple[Ints, Floats]] = [(b, np.full(b.shape, 1 / b.shape[1])) for b in blocks]
    places = [x[b].mean(axis=1) for x, b in zip(grid.axes, blocks, strict=True)]
    result = taken(samples, _grid(grid, strides, places), parts, lattice)
    if max(strides) == 1:
        return result
    ways = [_bias(grid, axis, parts, lattice) for axis in range(len(blocks)) if strides[axis] > 1]
    whole = Sum(tuple(ways))
    return estimated(result, samples, whole, Source("Block means", "model", "estimated", RULE))


def _bias(grid: Axial, axis: int, parts: list[tuple[Ints, Floats]], lattice: tuple[int, ...]) -> Operator:
    """Samples -> mean less value in the middle, by the curvature along one axis; NaN where three samples are not to be had."""
    x, (block, weights) = grid.axes[axis], parts[axis]
    curved, n = second_derivative(x), len(x)
    if curved is None:
        curved = csr_array(fixed(np.arange(n)[:, None], np.full((n, 1), np.nan), n))
    spread = diags_array(x[block].var(axis=1) / 2)
    matrix = spread @ csr_array(fixed(block, weights, n)) @ curved
    bent = along(lattice, dimension(grid, axis), matrix)
    rest = [p if a != axis else (np.arange(len(block))[:, None], np.ones((len(block), 1))) for a, p in enumerate(parts)]
    return mixing(rest, bent.outcome).after(bent)


def _grid(grid: Axial, strides: tuple[int, ...], places: list[Floats]) -> Axial:
    if isinstance(grid, Regular):
        spacing = tuple(h * s for h, s in zip(grid.spacing, strides, strict=True))
        return Regular(tuple(len(p) for p in reversed(places)), spacing, tuple(float(p[0]) for p in places), frame=grid.frame)
    return Rectilinear(tuple(places), frame=grid.frame)
