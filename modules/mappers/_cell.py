"""What can be constructed in one bilinear cell: crossings, shoulder points, tangents, the whole hyperbola."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modules import kernels

Floats = NDArray[np.float64]

SUBSCRIPTS = ("", "₁", "₂")
STEPS = 400
"""Points of a branch of the hyperbola outside the cell."""


@dataclass(frozen=True)
class Arc:
    """One arc of the contour within the cell, in the coordinates of the cell's place.

    Parameters
    ----------
    p, q : (2,) its ends; the high side lies to the left on the way
    bend : of the whole arc, from p to q
    """

    p: Floats
    q: Floats
    bend: float

    @property
    def middle(self) -> Floats:
        """M, in the middle of the chord."""
        return 0.5 * (self.p + self.q)

    @property
    def straight(self) -> bool:
        """Whether the arc is its chord."""
        return abs(self.bend) < kernels.arcs.STRAIGHT or bool((self.p == self.q).any())

    @property
    def shoulder(self) -> Floats:
        """R, where the tangent is parallel to the chord (thesis 3.3.1)."""
        return self._between(self.bend)

    @property
    def tangents_meet(self) -> Floats:
        """T, where the tangents at the ends meet; it is the shoulder point of an arc of twice the bend (3.12-3.14)."""
        return self._between(2 * self.bend)

    def _between(self, bend: float) -> Floats:
        share = kernels.arcs.shoulder_share(bend) if abs(bend) < kernels.arcs.TURN else 0.0
        d = self.q - self.p
        if bend > 0:
            return np.array([self.p[0] + share * d[0], self.q[1] - share * d[1]])
        return np.array([self.q[0] - share * d[0], self.p[1] + share * d[1]])

    def curve(self) -> tuple[Floats, float]:
        """(k, 2) points of the exact arc, and the largest distance of it from the line through them."""
        if self.straight:
            return np.stack([self.p, self.q]), 0.0
        if abs(self.bend) >= kernels.arcs.TURN:
            return np.stack([self.p, self.shoulder, self.q]), 0.0
        n = min(1024, 64 + 8 * math.ceil(abs(self.bend)))
        points = kernels.arcs.point(self.p, self.q, self.bend, np.linspace(0, 1, n + 1))
        step = np.diff(points, axis=0)
        return points, float(kernels.arcs.sagitta(step[:, 0], step[:, 1], self.bend / n).max())

    def areas(self) -> tuple[float, float]:
        """Area that one chord leaves, and that two chords through the shoulder point leave."""
        d = self.q - self.p
        whole = float(kernels.arcs.area(d[0], d[1], self.bend))
        if abs(self.bend) >= kernels.arcs.TURN:
            return whole, 0.0
        half = np.diff([self.p, self.shoulder, self.q], axis=0)
        return whole, float(kernels.arcs.area(half[:, 0], half[:, 1], self.bend / 2).sum())


@dataclass(frozen=True)
class Cell:
    """A bilinear cell at its place, and a level.

    Parameters
    ----------
    corner : (4,) values f00, f10, f01, f11
    level : of the contour
    low, size : (2,) lower left corner, and lengths of the sides
    """

    corner: Floats
    level: float
    low: Floats
    size: Floats

    def __post_init__(self) -> None:
        if not (np.isfinite(self.corner).all() and math.isfinite(self.level)):
            raise ValueError("a cell with a hole at a corner has no contour: choose another cell")

    @property
    def f(self) -> tuple[float, float, float, float]:
        """The corner values f00, f10, f01, f11."""
        a, b, c, d = self.corner.tolist()
        return a, b, c, d

    @property
    def high(self) -> Floats:
        """(2,) upper right corner."""
        return self.low + self.size

    def place(self, u: float, v: float) -> Floats:
        """Where the place (u, v) of the unit square lies."""
        return self.low + np.array([u, v]) * self.size

    def shows(self, at: Floats, around: float) -> bool:
        """Whether a window that is larger by `around` cells on each side shows a place."""
        return bool(np.all((at >= self.low - around * self.size) & (at <= self.high + around * self.size)))

    @property
    def twist(self) -> float:
        """The coefficient c: 0 exactly where F is linear."""
        return kernels.bilinear.twist(*self.f)

    @property
    def determinant(self) -> float:
        """Its sign is that of c (F(S) - level), without a division."""
        return kernels.bilinear.determinant(*self.f, self.level)

    @property
    def saddle(self) -> tuple[Floats, float] | None:
        """S and F(S); None where F is linear."""
        if self.twist == 0:
            return None
        u, v, value = kernels.bilinear.saddle(*self.f)
        return self.place(float(u), float(v)), float(value)

    def arcs(self) -> list[Arc]:
        """The arcs of the contour, none, one or two."""
        x, y = (np.array([a, b]) for a, b in zip(self.low, self.high, strict=True))
        found = kernels.contour.lines(self.corner.reshape(2, 2), x, y, self.level, False)
        bends = iter(found.bend.tolist())
        return [
            Arc(p, q, next(bends)) for a, b in pairwise(found.offsets) for p, q in pairwise(found.points[a:b])
        ]  # fmt: skip

    def beyond(self, around: float) -> list[Floats]:
        """The contour outside the cell, in a window that is larger by `around` cells on each side; lines of (k, 2) points."""
        low, high = self.low - around * self.size, self.high + around * self.size
        found: list[Floats] = []
        for branch in self._branches(low, high):
            middle = 0.5 * (branch[1:] + branch[:-1])
            seen = np.all((middle > low) & (middle < high), axis=1)
            inner = np.all((middle > self.low) & (middle < self.high), axis=1)
            found += _runs(branch, np.logical_and(seen, ~inner))
        return found

    def _branches(self, low: Floats, high: Floats) -> list[Floats]:
        """Each branch of the whole contour as points, those where it meets window and cell among them."""
        known = self.saddle
        if known is None:
            return self._line(low, high)
        if self.determinant == 0:
            return [self._through(known[0], axis, low, high) for axis in (0, 1)]
        saddle, k = known[0], -self.determinant / self.twist**2 * float(self.size.prod())
        edges = np.stack([low, self.low, self.high, high]) - saddle
        branches = []
        for side in (1.0, -1.0):
            x, y = edges[:, 0] * side, np.divide(k * side, edges[:, 1], out=np.full(4, -1.0), where=edges[:, 1] != 0)
            at = np.concatenate([x, y])
            at = at[at > 0]
            if at.size < 2:
                continue
            ends = np.geomspace(at.min(), at.max(), STEPS)
            x = side * np.unique(np.concatenate([ends, at]))
            branches.append(saddle + np.column_stack([x, k / x]))
        return branches

    def _through(self, at: Floats, axis: int, low: Floats, high: Floats) -> Floats:
        """A line along an axis through a place, with its meetings with window and cell."""
        line = np.repeat(at[None], 4, axis=0)
        line[:, axis] = [low[axis], self.low[axis], self.high[axis], high[axis]]
        return line

    def _line(self, low: Floats, high: Floats) -> list[Floats]:
        """The straight contour of a linear cell, with its meetings with window and cell."""
        f00, f10, f01, _ = self.f
        a, b = (f10 - f00) / self.size[0], (f01 - f00) / self.size[1]
        steep = math.hypot(a, b)
        if steep == 0:
            return []
        foot = self.low - (f00 - self.level) / steep**2 * np.array([a, b])
        along = np.array([-b, a]) / steep
        edges = np.stack([low, self.low, self.high, high]) - foot
        t = np.concatenate([edges[:, i] / along[i] for i in (0, 1) if along[i] != 0])
        return [foot + np.unique(t)[:, None] * along]


def _runs(points: Floats, keep: NDArray[np.bool_]) -> list[Floats]:
    """Stretches of a polyline whose segments are kept."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], keep.astype(np.int8), [0]])))
    return [points[a : b + 1] for a, b in edges.reshape(-1, 2)]
