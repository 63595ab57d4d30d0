"""The divergence of a vector field at its samples."""

from __future__ import annotations

from modules.api import Operator, Samples, Sum, modeller
from modules.modellers._derivative import Part, differentiated


@modeller("Divergence", output="samples", aliases=("sources and sinks", "outflow", "nabla dot"))
def divergence(samples: Samples) -> Samples:
    """How much of a vector field flows out of each place: the sum of the slopes of each component along its own axis.

    Parameters
    ----------
    samples : a vector on a regular or rectilinear grid; neighbours of a hole are holes

    Raises
    ------
    ValueError : not a vector; a bent or unstructured grid; axes of different units; an axis of one sample

    Accuracy: errors of the samples go through the same differences. Adds the error of the differences, estimated with its
    sign from third derivatives, and says where noise hides it; a field without sources shows what is left of it.
    Source: three-point derivative, error f'''/6 times the distances; Fornberg 1988.
    """
    if samples.components != 3:
        raise ValueError(f"the divergence is that of a vector; this has {samples.components} number(s) a sample")

    def build(part: Part) -> Operator:
        return Sum(tuple(part(axis, axis) for axis in range(len(samples.grid.shape))))

    return differentiated(samples, build, (), "divergence", "Differences instead of derivatives")
