"""Numbers of a vector or tensor that do not depend on the axes: length, trace, eigenvalues and others."""

from __future__ import annotations

import numpy as np

from modules.api import Literal, Samples, modeller
from modules.data import units
from modules.data.operators import Floats
from modules.modellers._pointwise import pointwise

Measure = Literal[
    "automatic", "length", "trace", "determinant", "norm", "second invariant", "largest eigenvalue", "middle eigenvalue",
    "smallest eigenvalue", "largest shear", "von Mises", "Q criterion",
]  # fmt: skip

POWERS = {"determinant": 3, "second invariant": 2, "Q criterion": 2}
"""Measure -> how often the unit occurs in it; once for others."""


@modeller("Invariants", output="samples", aliases=("magnitude", "speed", "tensor", "eigenvalues", "von mises", "q criterion"))
def invariants(samples: Samples, *, measure: Measure = "automatic") -> Samples:
    """One number of each vector or tensor that is the same whichever way the axes point.

    Eigenvalues, shear and von Mises are those of the symmetric part. The Q criterion of a velocity gradient is positive
    where turning outweighs stretching.

    Parameters
    ----------
    samples : vectors, or tensors
    measure : automatic takes the length of a vector, the trace of a tensor; the others are of a tensor

    Raises
    ------
    ValueError : scalars, or a measure that a vector does not have

    Accuracy: errors of the components go through the derivatives of the measure; where they reach so far that the measure
    bends (a length near 0, two eigenvalues that meet) it is flagged as not linear.
    Source: JCGM 100:2008, 5.1; derivatives of eigenvalues, Magnus 1985; Q after Hunt, Wray and Moin 1988.
    """
    if samples.components == 1:
        raise ValueError("invariants are of vectors and tensors, and these samples are single numbers")
    chosen: str = measure
    if measure == "automatic":
        chosen = "length" if samples.components == 3 else "trace"
    if (chosen == "length") != (samples.components == 3):
        what = "a vector has a length only" if samples.components == 3 else "a length is that of a vector; take the norm"
        raise ValueError(f"measure {chosen!r}: {what}")
    title = f"{chosen} of {samples.name}" if samples.name else chosen

    def function(numbers: Floats) -> tuple[Floats, Floats]:
        return measured(numbers, chosen)

    return pointwise(samples, function, unit=units.product("", samples.unit, POWERS.get(chosen, 1)), name=title)


def measured(numbers: Floats, measure: str) -> tuple[Floats, Floats]:
    """(n, 3 or 9) components -> (n,) values and (n, 3 or 9) derivatives; NaN where there is no derivative."""
    if measure in ("length", "norm"):
        size = np.sqrt((numbers**2).sum(axis=1))
        with np.errstate(invalid="ignore", divide="ignore"):
            return size, numbers / size[:, None]
    t = numbers.reshape(-1, 3, 3)
    one = np.eye(3)
    trace = np.trace(t, axis1=1, axis2=2)
    if measure == "trace":
        return trace, np.broadcast_to(one.ravel(), (len(t), 9))
    if measure == "determinant":
        rows = t[:, 0], t[:, 1], t[:, 2]
        cofactor = np.stack([np.cross(rows[1], rows[2]), np.cross(rows[2], rows[0]), np.cross(rows[0], rows[1])], axis=1)
        return (rows[0] * cofactor[:, 0]).sum(axis=1), cofactor.reshape(-1, 9)
    if measure in ("second invariant", "Q criterion"):
        squared = trace**2 - np.einsum("nij,nji->n", t, t)
        slope = trace[:, None, None] * one - t.transpose(0, 2, 1)
        return squared / 2, slope.reshape(-1, 9)
    symmetric = (t + t.transpose(0, 2, 1)) / 2
    if measure == "von Mises":
        apart = symmetric - trace[:, None, None] / 3 * one
        size = np.sqrt(1.5 * (apart**2).sum(axis=(1, 2)))
        with np.errstate(invalid="ignore", divide="ignore"):
            return size, (1.5 * apart / size[:, None, None]).reshape(-1, 9)
    return _eigen(symmetric, measure)


def _eigen(symmetric: Floats, measure: str) -> tuple[Floats, Floats]:
    """Eigenvalues, or half the difference of the outermost; the derivative is the product of the eigenvector with itself."""
    known = np.asarray(np.isfinite(symmetric).all(axis=(1, 2)))
    values, vectors = np.linalg.eigh(np.where(known[:, None, None], symmetric, 0.0))
    outer = np.einsum("nik,njk->nkij", vectors, vectors)
    gap = np.diff(values, axis=1)
    if measure == "largest shear":
        value, slope = (values[:, 2] - values[:, 0]) / 2, (outer[:, 2] - outer[:, 0]) / 2
        alone = gap.min(axis=1) > 0
    else:
        place = {"smallest eigenvalue": 0, "middle eigenvalue": 1, "largest eigenvalue": 2}[measure]
        value, slope = values[:, place], outer[:, place]
        alone = {0: gap[:, 0], 1: gap.min(axis=1), 2: gap[:, 1]}[place] > 0
    good = (known & alone)[:, None]
    return np.where(known, value, np.nan), np.where(good, slope.reshape(-1, 9), np.nan)
