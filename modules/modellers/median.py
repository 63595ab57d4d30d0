"""The median of a window: takes out single wrong values and keeps edges."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from scipy import ndimage

from modules.api import Accuracy, Annotated, Flag, Missing, Progress, Range, Samples, modeller, select
from modules.data.operators import Floats, Ints
from modules.modellers._linear import axial, carried, noise_in


@modeller("Median", output="samples", aliases=("rank filter", "despeckle", "salt and pepper", "outliers"))
def median(samples: Samples, progress: Progress, *, size: Annotated[int, Range(1, 9)] = 3) -> Samples:
    """Each sample becomes the median of a window around it; at borders the border sample is repeated.

    Parameters
    ----------
    samples : single numbers on a regular or rectilinear grid; neighbours of a hole are holes
    size : samples along each side of the window, an odd number

    Raises
    ------
    ValueError : vectors, a bent or unstructured grid, an even size

    Accuracy: a median is one of the samples and has that one's errors. Where errors are as large as the distance to the
    next in order, another sample may be the median: flagged as not linear, and the error, which is smaller than a
    sample's, is then too large. What the median takes from the truth is not known.
    Source: Tukey 1977; first order, the median moves with the sample that it is.
    """
    axial(samples, "a median")
    if samples.components != 1:
        raise ValueError("a median is that of single numbers: vectors have no order")
    if size < 1 or size % 2 == 0:
        raise ValueError(f"size = {size} should be an odd number: the window has its sample in the middle")
    if size == 1:
        return samples
    values = samples.values.astype(np.float64, copy=False)
    hole = np.isnan(values)
    filled = np.where(hole, 0.0, values)
    middle = size**values.ndim // 2
    found = ndimage.rank_filter(filled, middle, size=size, mode="nearest")
    progress(0.3)
    place = _which(filled, found, size, progress.part(0.3, 0.6))
    result = carried(samples, select(place, values.size))
    if hole.any():
        lost = ndimage.maximum_filter(hole, size=size, mode="nearest")
        result = replace(result, values=np.where(lost, np.nan, result.values))
    accuracy = _told_apart(result.accuracy, samples, filled, found, middle, size, progress.part(0.6, 1.0))
    missing = Missing("Median", "what it takes from the truth is not estimated")
    return replace(result, accuracy=accuracy.miss(missing))


def _which(values: Floats, found: Floats, size: int, progress: Progress) -> Ints:
    """The sample of each window that is its median."""
    half = size // 2
    padded = np.pad(values, half, mode="edge")
    numbers = np.pad(np.arange(values.size, dtype=np.int64).reshape(values.shape), half, mode="edge")
    place = np.full(values.shape, -1, np.int64)
    offsets = sorted(itertools.product(range(size), repeat=values.ndim), key=lambda o: sum(abs(i - half) for i in o))
    for k, offset in enumerate(offsets):
        progress(k / len(offsets))
        window = tuple(slice(o, o + n) for o, n in zip(offset, values.shape, strict=True))
        hit = (place < 0) & (padded[window] == found)
        place[hit] = numbers[window][hit]
    return place.ravel()


def _told_apart(
    accuracy: Accuracy, samples: Samples, values: Floats, found: Floats, middle: int, size: int, progress: Progress
) -> Accuracy:
    """Flagged where the next in order lies within the noise of a difference of two samples."""
    noise = noise_in(samples, select(np.arange(values.size), values.size), 1)
    if noise <= 0:
        return accuracy
    below = ndimage.rank_filter(values, middle - 1, size=size, mode="nearest")
    progress(0.5)
    above = ndimage.rank_filter(values, middle + 1, size=size, mode="nearest")
    near = np.flatnonzero((np.minimum(found - below, above - found) <= np.sqrt(2) * noise).ravel())
    if not len(near):
        return accuracy
    words = f"noise may make another sample the median at {len(near)} of {values.size} samples"
    return accuracy.flag(Flag("not linear", words, "point", near))
