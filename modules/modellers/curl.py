"""The curl of a vector field at its samples."""

from __future__ import annotations

from modules.api import Interleave, Operator, Samples, Sum, modeller
from modules.modellers._derivative import Part, differentiated


@modeller("Curl", output="samples", aliases=("vorticity", "rotation", "nabla cross", "rot"))
def curl(samples: Samples) -> Samples:
    """How a vector field turns about each place: twice the angular velocity of what floats in it.

    Of a flow in a plane only the component along z differs from 0.

    Parameters
    ----------
    samples : a vector on a regular or rectilinear grid; neighbours of a hole are holes

    Raises
    ------
    ValueError : not a vector; a bent or unstructured grid; axes of different units, or left-handed; an axis of one sample

    Accuracy: errors of the samples go through the same differences. Adds the error of the differences, estimated with its
    sign from third derivatives, and says where noise hides it.
    Source: three-point derivative, error f'''/6 times the distances; Fornberg 1988.
    """
    if samples.components != 3:
        raise ValueError(f"the curl is that of a vector; this has {samples.components} number(s) a sample")
    if samples.grid.frame.handed != "right":
        raise ValueError("the axes are left-handed, so the curl would have the other sign: transform them first")

    def build(part: Part) -> Operator:
        def component(i: int) -> Operator:
            j, k = (i + 1) % 3, (i + 2) % 3
            return Sum((part(j, k), part(k, j, -1.0)))

        return Interleave((component(0), component(1), component(2)))

    return differentiated(samples, build, (3,), "curl", "Differences instead of derivatives")
