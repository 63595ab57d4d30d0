"""One cell by its eight corner values, to look closely at what a method makes of it."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256

import numpy as np

from modules.api import Accuracy, Literal, Samples, exactly, reader, regular

CELLS: dict[str, tuple[float, ...]] = {
    "4.5": (1, -3, -1.5, 2, -3, 2, 2, -1),
    "4.11": (5, -1.5, -2, -3, -3, -2, -1, 15),
    "4.19": (2.5, -2, -1, -1, -2, 1, 1.5, -1.5),
    "4.20": (1, -1.5, -1.5, 3.5, 2, -1, -1, -1),
    "4.21": (2, 1, -1, -1, -1, -1.5, 1, 1),
    "4.22": (1, -1, -1.5, -1, -2, 5, 1, 1.5),
    "4.23": (1.5, -2.5, -1, -1, -1, 1, 2, -1),
    "4.24": (1, -1, -1, 2, -2.5, 1, 1, -1),
    "4.26": (-1.5, 1, -1, 2, 1, -1, -2, 0.5),
    "4.27": (4, -2, 5, -8, -2, -1, -8, -1),
    "4.28": (2, 5, 3, -6, -2, -1, -10, -4),
    "4.29 a": (5, -1.5, -2, -3, -3, -2, -1, 5),
    "4.29 b": (5, -1.5, -2, -3, -3, -2, -1, 15),
    "4.31": (1.5, -1.5, -3, 2, 10, -1, -1, -1),
    "4.32": (2, -1, -1, -1, -3, 1, 1, 5),
    "4.33": (2, -2, -2, -2, -4, 4.5, 4.5, -2),
    "4.34": (1, 2, -1, -5, -2, -1, 2.5, 3),
    "tunnel of configuration 13": (16.1, -9.9, -15.6, 5.6, -19.6, 13.4, 20.0, -11.7),
}
"""The worked cells of the thesis by their figure, level 0; corners 000 001 010 011 100 101 110 111 of xyz."""


PAIRS: dict[str, tuple[float, ...]] = {
    "4.2 two cells": (-1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
}
"""Two cells with a common face at x = 1: configuration 6 beside the complement of 3, where the table of 1987 leaves a hole."""


@reader("Corner cell", version=2, output="samples", aliases=("eight corners", "worked cell", "trilinear cell"))
def corner_cell(
    *,
    figure: Literal[
        "", "4.5", "4.11", "4.19", "4.20", "4.21", "4.22", "4.23", "4.24", "4.26", "4.27", "4.28", "4.29 a", "4.29 b",
        "4.31", "4.32", "4.33", "4.34", "tunnel of configuration 13", "4.2 two cells",
    ] = "4.29 b",
    corners: tuple[float, ...] = (5.0, -1.5, -2.0, -3.0, -3.0, -2.0, -1.0, 15.0),
    unit: str = "",
) -> Samples:
    """A unit cell with a value at each of its eight corners: a worked cell of the thesis, or values of your own.

    With twelve values two cells stand side by side along x.

    Parameters
    ----------
    figure : of the thesis whose cell it is; empty: the corners given below
    corners : values at 000 001 010 011 100 101 110 111, the digits being x, y and z; of two cells 200 201 210 211 too
    unit : of the values

    Raises
    ------
    ValueError : there are not eight or twelve values

    Accuracy: the values are exact, as they are typed.
    Source: Lopes 1999, figures 4.5 to 4.34; configuration 13 with a tunnel is not in it.
    """  # fmt: skip
    chosen = (CELLS | PAIRS)[figure] if figure else corners
    if len(chosen) not in (8, 12):
        raise ValueError(f"a cell has eight corners, two have twelve, not {len(chosen)}: give values at 000 001 010 … 111")
    values = np.ascontiguousarray(np.asarray(chosen, float).reshape(-1, 2, 2).transpose(2, 1, 0))
    name = f"cell of figure {figure}" if figure[:1].isdigit() else figure or "cell"
    content = sha256(values.tobytes()).hexdigest()[:32]
    term = exactly("Typed values", "data", len(chosen), unit=unit, rule="exact as typed (typed/1)")
    term = replace(term, id=f"cell-{content}/typed")
    return Samples(grid=regular(values.shape), values=values, unit=unit, name=name, accuracy=Accuracy((term,)))
