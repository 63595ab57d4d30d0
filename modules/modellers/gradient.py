"""The gradient of a field at its samples."""

from __future__ import annotations

from modules.api import Interleave, Operator, Samples, modeller
from modules.modellers._derivative import Part, differentiated


@modeller("Gradient", output="samples", aliases=("derivative", "slope", "jacobian", "velocity gradient", "nabla"))
def gradient(samples: Samples) -> Samples:
    """How fast a field changes along x, y and z: a vector of a scalar, a tensor of a vector.

    At each sample it is the slope of the parabola through it and its two neighbours, one-sided at the ends of an axis and
    right on uneven axes. Row i of the tensor holds the derivatives of component i. Along an axis that a map does not
    have it is 0.

    Parameters
    ----------
    samples : a scalar or a vector on a regular or rectilinear grid; neighbours of a hole are holes

    Raises
    ------
    ValueError : a tensor; a bent or unstructured grid; axes of different units; an axis of one sample

    Accuracy: errors of the samples go through the same differences; what two differences share is known, an error
    common to all has none. Adds the error of the parabola, estimated with its sign from third derivatives, and says where
    noise hides it.
    Source: three-point derivative, error f'''/6 times the distances; Fornberg 1988.
    """
    if samples.components == 9:
        raise ValueError("the gradient of a tensor has 27 numbers, which no wire carries: take one of its components")

    def build(part: Part) -> Operator:
        vector = samples.components == 3
        return Interleave(tuple(part(axis, component) for component in range(3 if vector else 1) for axis in range(3)))

    extra = (3, 3) if samples.components == 3 else (3,)
    return differentiated(samples, build, extra, "gradient", "Differences instead of derivatives")
