"""What a file holds, before it becomes samples: numbers as stored, where they lie, and what the file says of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Missing
from modules.data.fold import Kind
from modules.data.operators import Floats


@dataclass(frozen=True, kw_only=True)
class Stated:
    """An error that the file states.

    Parameters
    ----------
    name : of the source, as the user reads it
    what : last part of the term's id
    kind : linear (standard deviation) or bound
    value : primitive values in the unit of the file: 0-d when all are the same, (ny, nx) of the whole array, (k,) if common
    rule : one sentence
    common : k errors that are the same for all samples, instead of one for each
    weights : (ny, nx, k) how the k common errors reach each sample; None for 1
    """

    name: str
    what: str
    kind: Kind
    value: Floats
    rule: str
    common: bool = False
    weights: Floats | None = None


@dataclass(frozen=True, kw_only=True)
class Raw:
    """A map as it is stored.

    Parameters
    ----------
    values : (ny, nx) in the order of the file, every `stride`-th row and column
    full : shape of the file's whole array
    half : largest rounding error of a stored number times `scale`: 0-d, or (ny, nx) of the whole array
    stored : how it was rounded, in words
    x, y : coordinates of all columns and rows in the order of the file; None where it states none
    north_first : whether row 0 is the north edge when `y` is not stated; None: the file does not say
    unit, lengths : of the values and of the coordinates; "degree" for longitude and latitude
    scale, offset : heights are scale * stored + offset, as the file says
    holes : (ny, nx) bool, where there is no value; None where all are
    stated : errors that the file states
    missing : errors that the file is known to have and does not state
    assumed : what was taken for granted, in words
    """

    values: NDArray[Any]
    full: tuple[int, int]
    half: Floats
    stored: str
    name: str = ""
    x: NDArray[Any] | None = None
    y: NDArray[Any] | None = None
    north_first: bool | None = None
    unit: str = ""
    lengths: str = ""
    crs: str = ""
    scale: float = 1.0
    offset: float = 0.0
    holes: NDArray[np.bool_] | None = None
    stated: tuple[Stated, ...] = ()
    missing: tuple[Missing, ...] = ()
    handed: str = "right"
    assumed: tuple[str, ...] = ()
