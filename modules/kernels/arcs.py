"""Arcs of hyperbolas whose asymptotes are parallel to the axes: the contours of bilinear interpolants.

An arc runs from P to Q = P + (dx, dy) with the *bend* w = ln(F_y(Q) / F_y(P)) = ln(F_x(P) / F_x(Q)). Measured from the
saddle it is X = X_P e^(w t), Y = Y_P e^(-w t), 0 <= t <= 1, hence

    x = x_P + dx (e^(w t) - 1) / (e^w - 1),    y = y_P + dy (1 - e^(-w t)) / (1 - e^(-w)).

With w = 0 it is the chord, with w -> +inf it goes up along y and then along x. A bend of +-`TURN` stands for that right
angle (the saddle on the level). The point t = 1/2 is the shoulder point, where the tangent is parallel to the chord;
each half is an arc of bend w/2. All functions broadcast, take any bend and never overflow. Lengths are in the units of
dx and dy, which must be the same wherever they are mixed (`sagitta`, `length`).

Source: thesis section 3.3.1, proposition 3.3.1.2 (F_x F_y constant along the contour).
"""

import math

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import jit

Floats = npt.NDArray[np.float64]

TURN = 1000.0
"""The bend that stands for a right angle: e^-TURN is 0 beside 1, and TURN itself is far from overflow."""

STRAIGHT = 2.0**-50
"""A smaller bend is none: the shoulder point is the middle of the chord, to rounding."""


@jit
def shoulder_share(bend: float) -> float:
    """1 / (1 + e^(|w|/2)): the part of the chord that the shoulder point takes along the axis it covers last.

    The shoulder point is (x_P + s dx, y_Q - s dy) if w > 0, (x_Q - s dx, y_P + s dy) if w < 0.
    """
    q = math.exp(-0.5 * abs(bend))
    return q / (1.0 + q)
