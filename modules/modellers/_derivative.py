"""What gradient, divergence and curl share: one operator for values and errors, one for what differences leave out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from modules.api import Missing, Operator, Samples, Source, Stencil, along, uniform
from modules.data.grid import Axial
from modules.data.operators import Floats
from modules.data.wires import TOO_FEW
from modules.modellers._linear import axial, carried, dimension, estimated, lattice_of, per
from modules.modellers._weights import slope, slope_bias

RULE = "a third derivative by differences, times the product of the distances over 6 [slope-third-derivative/1]"


class Part(Protocol):
    """What a derivative is put together from."""

    def __call__(self, axis: int, component: int, factor: float = 1.0) -> Operator:
        """The derivative of a component along an axis, times a factor: an operator on the samples."""



def differentiated(
    samples: Samples, build: Callable[[Part], Operator], extra: tuple[int, ...], name: str, what: str
) -> Samples:
    """The outcome of derivatives, with the error that differences make.

    Parameters
    ----------
    build : puts the wanted operator together from derivatives
    extra : () of a scalar, (3,) of a vector, (3, 3) of a tensor
    what : name of the error
    """
    grid = axial(samples, name)
    for axis, coordinates in enumerate(grid.axes):
        if len(coordinates) < 2:
            raise ValueError(f"axis {grid.frame.axes[axis]} has a single sample, so nothing has a slope along it: slice it off")
    unit = per(samples.unit, grid.frame.length_unit(len(grid.axes)))
    title = f"{name} of {samples.name}" if samples.name else name
    result = carried(samples, build(_parts(samples, grid, slope)), extra=extra, unit=unit, name=title)
    if min(grid.shape) < 4:
        return replace(result, accuracy=result.accuracy.miss(Missing(what, f"{TOO_FEW}: four along each axis")))
    bias = build(_parts(samples, grid, _bias))
    return estimated(result, samples, bias, Source(what, "model", "estimated", RULE))


def _bias(x: Floats) -> Any:
    found = slope_bias(x)
    assert found is not None
    return found


def _parts(samples: Samples, grid: Axial, matrix: Callable[[Floats], Any]) -> Part:
    lattice, c = lattice_of(samples), samples.components
    one = (*samples.grid.shape, 1) if c > 1 else lattice

    def part(axis: int, component: int, factor: float = 1.0) -> Operator:
        if axis >= len(grid.axes):
            step = uniform(one, 0.0)
        else:
            step = along(one, dimension(grid, axis), factor * matrix(grid.axes[axis]))
        return step if c == 1 else step.after(pick(lattice, component))

    return part


def pick(lattice: tuple[int, ...], component: int) -> Stencil:
    """One component of samples whose lattice has them as its last axis."""
    return Stencil(lattice, len(lattice) - 1, np.array([[component]]), np.ones((1, 1)))

