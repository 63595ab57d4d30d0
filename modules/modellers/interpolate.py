"""Samples become a model: a law between them, with an estimate of its own error."""

from __future__ import annotations

import numpy as np

from modules.api import Flag, Literal, Model, Samples, modeller

GLANCE = 2_000
"""Samples that are looked at to tell the noise."""


@modeller("Interpolate", aliases=("model", "bilinear", "trilinear", "nearest", "cubic"), output="model")
def interpolate(samples: Samples, *, law: Literal["linear", "nearest", "cubic"] = "linear") -> Model:
    """A value anywhere between the samples, by a law.

    Linear is bilinear on a rectangle and trilinear in a box: the law whose contours the thesis draws exactly.

    Parameters
    ----------
    law : linear; nearest (the value of the closest sample, with a jump half way); or cubic (smooth across the cells)

    Accuracy: errors of the samples go through the law's weights; the law adds its own error, estimated from second
        differences, which is zero at the samples. Where these are within the noise it is flagged as not resolvable.
    Source: Lopes 1999, 2.3.1 (accuracy model); error of piecewise linear interpolation, h^2 f''/8.
    """
    model = Model.between(samples, law)
    flag = _not_resolvable(model)
    if flag is None:
        return model
    return Model(samples=samples, law=model.law, accuracy=model.accuracy.flag(flag))


def _not_resolvable(model: Model) -> Flag | None:
    """Cells whose second differences are within what noise alone would give."""
    own = model.own
    if own is None:
        return None
    noise = [t for t in model.samples.accuracy.select("value", "point") if t.source.stage == "data"]
    looked = np.random.default_rng(0).integers(0, model.grid.count, GLANCE)
    bounds = sum((float(t.size(looked).max(initial=0.0)) for t in noise if t.kind == "bound"), 0.0)
    variance = sum((float((t.size(looked) ** 2).max(initial=0.0)) for t in noise if t.kind in ("linear", "members")), 0.0)
    # a second difference of rounding errors reaches 4 b, one of noise has the deviation sqrt(1 + 4 + 1) sigma
    limit = model.grid.dimensions / 8 * (4 * bounds + 2 * np.sqrt(6 * variance))
    below = np.flatnonzero(own.size() <= limit) if limit > 0 else np.zeros(0, np.int64)
    if not len(below):
        return None
    words = f"the interpolation error cannot be told from the noise in {len(below)} of {own.count} cells"
    return Flag("not resolvable", words, "cell", below)
