"""The moving average: a window of samples that slides along the axes."""

from __future__ import annotations

from modules.api import Annotated, Literal, Progress, Range, Samples, modeller
from modules.modellers._linear import axial, chosen
from modules.modellers._smoothing import smoothed
from modules.modellers._weights import running


@modeller("Moving average", output="samples", aliases=("running mean", "box filter", "boxcar", "window"))
def moving_average(
    samples: Samples,
    progress: Progress,
    *,
    size: Annotated[int, Range(1, 51)] = 5,
    axis: Literal["all", "x", "y", "z"] = "all",
) -> Samples:
    """Each sample becomes the mean of a window around it.

    It is the value of a straight line fitted to the samples of the window: on an evenly spaced axis their mean, and
    near a border, where the window is cut, still without a drift.

    Parameters
    ----------
    samples : of a regular or rectilinear grid; vectors and tensors by component
    size : samples in the window along an axis, an odd number
    axis : along which it works

    Raises
    ------
    ValueError : a bent or unstructured grid, an axis that the data does not have, an even size

    Accuracy: errors of the samples go through the same weights, so what neighbours have in common afterwards is known;
    adds what averaging takes from the truth, estimated with its sign from the field itself, and says where noise hides it.
    Source: Savitzky and Golay 1964, of first order; bias by twicing, Tukey 1977.
    """
    if size < 1 or size % 2 == 0:
        raise ValueError(f"size = {size} should be an odd number: the window has its sample in the middle")
    grid = axial(samples, "a moving average")
    return smoothed(
        samples, grid, chosen(grid, axis), lambda x: running(x, size), "Moving average", progress, int(size > 1)
    )
