"""A camera as plain numbers: places of the world as pixels of a window and back, without asking VTK."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def basis(camera: Mapping[str, Any]) -> tuple[Floats, Floats, Floats, float]:
    """Right, up and back of the view as unit vectors, and the distance to the focal point."""
    back = np.asarray(camera["position"], float) - np.asarray(camera["focal"], float)
    distance = float(np.linalg.norm(back)) or 1.0
    back = back / distance
    right = np.cross(np.asarray(camera["up"], float), back)
    length = float(np.linalg.norm(right))
    if length < 1e-9:
        right = np.cross([0.0, 1.0, 0.0] if abs(back[1]) < 0.9 else [1.0, 0.0, 0.0], back)
        length = float(np.linalg.norm(right))
    right = right / length
    return right, np.cross(back, right), back, distance


@dataclass(frozen=True)
class Sight:
    """What a camera sees in a window.

    Parameters
    ----------
    camera : as a viewport gives it
    size : width and height of the window in pixels
    """

    camera: Mapping[str, Any]
    size: tuple[float, float]

    @property
    def parallel(self) -> bool:
        """Whether lines of sight are parallel."""
        return bool(self.camera.get("parallel"))

    def half(self, depth: Any) -> Any:
        """Half the height of what is seen at a distance from the eye, in world units."""
        if self.parallel:
            return np.full_like(np.asarray(depth, float), float(self.camera["height"]) / 2)
        return np.asarray(depth, float) * math.tan(math.radians(float(self.camera["angle"])) / 2)

    def pixels(self, points: Floats) -> tuple[Floats, Floats]:
        """(n, 2) pixels from the upper left corner, and (n,) distances along the line of sight; NaN behind the eye.

        Parameters
        ----------
        points : (n, 3) as they are drawn
        """
        right, up, back, _ = basis(self.camera)
        away = np.asarray(points, float).reshape(-1, 3) - np.asarray(self.camera["position"], float)
        depth = -(away @ back)
        if not self.parallel:
            depth = np.where(depth > 0, depth, np.nan)
        width, height = self.size
        by = height / 2 / self.half(depth)
        return np.stack([width / 2 + by * (away @ right), height / 2 - by * (away @ up)], axis=1), depth

    def ray(self, x: float, y: float) -> tuple[Floats, Floats]:
        """(start, direction) of the line of sight through a pixel; one step goes one unit away from the eye."""
        right, up, back, _ = basis(self.camera)
        width, height = self.size
        eye = np.asarray(self.camera["position"], float)
        aside = (2 * x - width) / height * right + (1 - 2 * y / height) * up
        if self.parallel:
            return eye + float(self.half(0.0)) * aside, -back
        return eye, float(self.half(1.0)) * aside - back

    def place(self, x: float, y: float, depth: float) -> Floats:
        """(3,) the place under a pixel at a distance along the line of sight."""
        start, along = self.ray(x, y)
        place: Floats = start + depth * along
        return place
