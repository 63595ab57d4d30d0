"""Cameras as plain numbers: turned, moved and brought nearer without asking VTK."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw.sight import basis

Camera = dict[str, Any]
Floats = NDArray[np.float64]

AXES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1), "-z": (0, 0, -1)}
"""Where the eye stands, as seen from the focal point."""


def directions(camera: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Right and up of the view in the world."""
    right, up, _, _ = basis(camera)
    return right, up


def turned(camera: Camera, dx: float, dy: float) -> Camera:
    """Turned about the focal point: dx to the side, dy upwards, in radians; it does not roll, z stays up where it is."""
    right, up, back, distance = basis(camera)
    upright = abs(up[2]) > 1e-3
    axis = np.array([0.0, 0.0, math.copysign(1.0, up[2])]) if upright else up
    back = _rotated(_rotated(back, right, -dy), axis, -dx)
    up = _rotated(_rotated(up, right, -dy), axis, -dx)
    focal = np.asarray(camera["focal"], float)
    return {**camera, "position": (focal + back * distance).tolist(), "up": up.tolist()}


def moved(camera: Camera, dx: float, dy: float, height: float) -> Camera:
    """Moved with what is seen, by so many pixels of a window of that height."""
    right, up, _, _ = basis(camera)
    by = (-dx * right + dy * up) * (seen(camera) / max(1.0, height))
    focal, position = np.asarray(camera["focal"], float) + by, np.asarray(camera["position"], float) + by
    return {**camera, "focal": focal.tolist(), "position": position.tolist()}


def nearer(camera: Camera, factor: float, at: tuple[float, float] = (0.0, 0.0), aspect: float = 1.0) -> Camera:
    """Brought nearer by a factor; in a parallel view towards a place of the window, each from -1 to 1."""
    if camera.get("parallel"):
        right, up, _, _ = basis(camera)
        height = float(camera["height"])
        by = (1 - 1 / factor) * height / 2 * (at[0] * aspect * right + at[1] * up)
        focal, position = np.asarray(camera["focal"], float) + by, np.asarray(camera["position"], float) + by
        return {**camera, "height": height / factor, "focal": focal.tolist(), "position": position.tolist()}
    focal = np.asarray(camera["focal"], float)
    back = np.asarray(camera["position"], float) - focal
    return {**camera, "position": (focal + back / factor).tolist(), "height": float(camera["height"]) / factor}


def along(camera: Camera, axis: str) -> Camera:
    """Seen along an axis, "+x" from the east."""
    _, _, _, distance = basis(camera)
    away = np.asarray(AXES[axis], float)
    up = [0.0, 1.0, 0.0] if axis.endswith("z") else [0.0, 0.0, 1.0]
    focal = np.asarray(camera["focal"], float)
    return {**camera, "position": (focal + away * distance).tolist(), "up": up}


def parallel(camera: Camera, on: bool) -> Camera:
    """Without perspective, or with it; what lies at the focal point keeps its size."""
    _, _, back, distance = basis(camera)
    tangent = math.tan(math.radians(float(camera["angle"])) / 2)
    if on:
        return {**camera, "parallel": True, "height": 2 * distance * tangent}
    focal = np.asarray(camera["focal"], float)
    position = focal + back * float(camera["height"]) / (2 * tangent)
    return {**camera, "parallel": False, "position": position.tolist()}


def seen(camera: Mapping[str, Any]) -> float:
    """How much of the world is seen from top to bottom; with perspective, at the focal point."""
    if camera.get("parallel"):
        return float(camera["height"])
    return 2 * basis(camera)[3] * math.tan(math.radians(float(camera["angle"])) / 2)


def looking_at(camera: Camera, point: Sequence[float], height: float) -> Camera:
    """From the same side, with a point in the middle and so much of the world seen from top to bottom."""
    _, _, back, distance = basis(camera)
    focal = np.asarray(point, float)
    away = distance if camera.get("parallel") else distance * height / seen(camera)
    return {**camera, "focal": focal.tolist(), "position": (focal + back * away).tolist(), "height": float(height)}


def between(start: Camera, end: Camera, t: float) -> Camera:
    """On the way from one camera to another of the same kind: places go straight, heights by their ratio."""
    mixed = {n: ((1 - t) * np.asarray(start[n], float) + t * np.asarray(end[n], float)).tolist() for n in ("focal", "position")}
    height = float(start["height"]) ** (1 - t) * float(end["height"]) ** t
    return {**end, **mixed, "height": height}


def _rotated(vector: Floats, axis: Floats, angle: float) -> Floats:
    """By Rodrigues' formula."""
    cos, sin = math.cos(angle), math.sin(angle)
    turned: Floats = vector * cos + np.cross(axis, vector) * sin + axis * float(axis @ vector) * (1 - cos)
    return turned
