"""Runge-Kutta pairs as data: what a step is made of, its error estimate and its dense output.

Every method here is written so that its last stage is the velocity at the new position ("first same as last"), and
with a dense output of four coefficients, so one compiled step serves them all. Dormand-Prince and Bogacki-Shampine
report the result of the higher order (local extrapolation). These are not the pairs of NAG and RKSUITE throughout:
their 2(3) is the same Bogacki-Shampine pair; their 4(5) is another pair of Bogacki and Shampine, of the same orders.

Source: Dormand and Prince 1980, dense output of Shampine 1986; Bogacki and Shampine 1989; Lopes 1999, table 5.1 with
    its second-order formula corrected to p + (dt/2)(V(p) + V(p*)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Pair(NamedTuple):
    """A method as its tableau.

    Attributes
    ----------
    stages : (s, s) weights of the earlier stages; the last row is the new position
    result : (s,) weights of the new position
    error : (s,) weights of the local error estimate; zeros where the method has none
    dense : (s, 4) position at start + theta step = p + step sum_i k_i sum_m dense[i, m] theta^(m+1)
    order : of the reported result
    estimate : order of the result that the error estimate belongs to; 0 for none
    between : order of the dense output
    """

    stages: Floats
    result: Floats
    error: Floats
    dense: Floats
    order: int
    estimate: int
    between: int


def _single(rows: Sequence[Sequence[float]], weights: Sequence[float], order: int) -> Pair:
    """A method without an error estimate, with the velocity at its end as one more stage and a Hermite dense output."""
    s = len(weights) + 1
    stages, result = np.zeros((s, s)), np.zeros(s)
    for i, row in enumerate((*rows, weights)):
        stages[i, : len(row)] = row
    result[: s - 1] = weights
    dense = np.outer(result, (0.0, 3.0, -2.0, 0.0))
    dense[0] += (1.0, -2.0, 1.0, 0.0)
    dense[-1] += (0.0, -1.0, 1.0, 0.0)
    return Pair(stages, result, np.zeros(s), dense, order, 0, min(order, 3))


def _dormand_prince() -> Pair:
    stages = np.zeros((7, 7))
    rows = (
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    )
    for i, row in enumerate(rows):
        stages[i, : len(row)] = row
    error = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
    dense = np.array(
        [
            [1.0, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
            [0.0, 0.0, 0.0, 0.0],
            [0.0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
            [0.0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
            [0.0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
            [0.0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
            [0.0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
        ]
    )
    return Pair(stages, stages[6].copy(), error, dense, 5, 4, 4)


def _bogacki_shampine() -> Pair:
    stages = np.zeros((4, 4))
    stages[1, 0], stages[2, 1] = 1 / 2, 3 / 4
    stages[3, :3] = 2 / 9, 1 / 3, 4 / 9
    error = np.array([-5 / 72, 1 / 12, 1 / 9, -1 / 8])
    dense = np.zeros((4, 4))
    dense[:, :3] = (1.0, -4 / 3, 5 / 9), (0.0, 1.0, -2 / 3), (0.0, 4 / 3, -8 / 9), (0.0, -1.0, 1.0)
    return Pair(stages, stages[3].copy(), error, dense, 3, 2, 3)


PAIRS: Mapping[str, Pair] = {
    "Dormand-Prince 5(4)": _dormand_prince(),
    "Bogacki-Shampine 3(2)": _bogacki_shampine(),
    "Euler": _single([()], [1.0], 1),
    "Heun": _single([(), (1.0,)], [0.5, 0.5], 2),
    "midpoint": _single([(), (0.5,)], [0.0, 1.0], 2),
    "RK4": _single([(), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)], [1 / 6, 1 / 3, 1 / 3, 1 / 6], 4),
}
"""By the name that a user reads; the first two estimate their local error."""
