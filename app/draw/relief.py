"""Colours of images and of shaded relief, in numbers: no VTK."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.theme import Theme
from modules.data.grid import Rectilinear, Regular
from modules.data.scene import ColourMap, ImageLook
from modules.data.wires import Samples

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

SUN = np.array([-1.0, 1.0, np.sqrt(2.0)]) / 2.0
"""Towards the light: from the north-west, 45 degrees high; maps have been lit so for centuries."""
FLAT = float(SUN[2])
FINEST = 4096
"""An image is not refined beyond this many pixels a side."""


def shading(normals: Floats) -> Floats:
    """(n,) light on faces with normals (n, 3): 0 in shadow, 0.5 on level ground, 1 square to the light."""
    length = np.linalg.norm(normals, axis=-1)
    light = np.clip((normals @ SUN) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    return np.where(light < FLAT, 0.5 * light / FLAT, 0.5 + 0.5 * (light - FLAT) / (1 - FLAT))


def slopes(values: Floats, x: Floats, y: Floats, factor: float) -> Floats:
    """(ny, nx, 3) normals of the height field, its slopes taken `factor` times as steep; level where there is a hole."""
    up, across = np.gradient(values * factor, y, x)
    normals = np.stack([-across, -up, np.ones_like(values)], axis=-1)
    return np.where(np.isfinite(normals).all(axis=-1, keepdims=True), normals, [0.0, 0.0, 1.0])


def grey(light: Floats, theme: Theme) -> Floats:
    """(..., 3) colours of shaded ground: pale in the light theme, dark in the other, so that lines and dust stand out."""
    tones = np.array([theme.rgb(f"relief {name}") for name in ("shadow", "flat", "light")])
    return np.stack([np.interp(light, [0.0, 0.5, 1.0], tones[:, c]) for c in range(3)], axis=-1)


def tones(colour: tuple[float, float, float], light: Floats) -> Floats:
    """(..., 3) one colour under the light: darker to its half in shadow, a little lighter in full light."""
    strength = np.interp(light, [0.0, 0.5, 1.0], [0.58, 0.96, 1.12])[..., None]
    return np.clip(np.asarray(colour) * strength, 0.0, 1.0)


def table(map: ColourMap, n: int = 256) -> Floats:
    """(n, 3) colours of a map at n places, or its `steps` colours each over an equal share of them."""
    places = np.linspace(0.0, 1.0, n)
    if map.steps:
        places = np.minimum(np.floor(places * map.steps), map.steps - 1) / (map.steps - 1)
    own = np.linspace(0.0, 1.0, len(map.colours))
    return np.stack([np.interp(places, own, map.colours[:, c]) for c in range(3)], axis=-1)


def share(values: Floats, span: tuple[float, float], scale: str) -> Floats:
    """Place of each value between the ends of the colours, in [0, 1]."""
    low, high = span
    if scale == "logarithmic":
        values, low, high = np.log(np.maximum(values, 1e-300)), float(np.log(low)), float(np.log(high))
    return np.clip((values - low) / ((high - low) or 1.0), 0.0, 1.0)


def colours(values: Floats, map: ColourMap, span: tuple[float, float]) -> Floats:
    """(..., 3) colours of values."""
    known = table(map)
    place = np.nan_to_num(share(values, span, map.scale)) * (len(known) - 1)
    found: Floats = known[np.rint(place).astype(int)]
    return found


def refined(values: Floats, times: int) -> Floats:
    """The field of bilinear cells at `times` as many places along each axis, ends kept."""
    for axis in (0, 1):
        n = values.shape[axis]
        at = np.linspace(0, n - 1, (n - 1) * times + 1)
        left = np.minimum(at.astype(int), n - 2)
        part = (at - left).reshape([-1 if a == axis else 1 for a in (0, 1)])
        values = np.take(values, left, axis) * (1 - part) + np.take(values, left + 1, axis) * part
    return values


def picture(samples: Samples, look: ImageLook, theme: Theme) -> Bytes:
    """(ny, nx, 4) colours of samples of the plane, row 0 at the least y; holes are clear.

    Axes are brought to even steps first, and the field is refined, so that colours follow it and not the other way round.
    """
    assert isinstance(samples.grid, Regular | Rectilinear)
    values = np.asarray(samples.values, float)
    x, y = samples.grid.axes
    times = 1
    if look.interpolate:
        times = max(1, min(4, FINEST // max(values.shape)))
    light: Any = None
    if look.relief:
        light = shading(slopes(values, x, y, look.exaggeration))
    values, light = _even(values, x, y), None if light is None else _even(light, x, y)
    if times > 1:
        values, light = refined(values, times), None if light is None else refined(light, times)
    if look.colouring is None:
        base = grey(light, theme)
    else:
        finite = values[np.isfinite(values)]
        span = look.colouring.range or (float(finite.min()), float(finite.max()))
        base = colours(values, look.colouring.map, span)
        if light is not None:
            base = np.clip(base * np.interp(light, [0.0, 0.5, 1.0], [0.55, 1.0, 1.15])[..., None], 0.0, 1.0)
    out = np.empty((*values.shape, 4), np.uint8)
    out[..., :3] = np.rint(base * 255)
    out[..., 3] = np.where(np.isfinite(values), round(255 * look.opacity), 0)
    return out


def _even(values: Floats, x: Floats, y: Floats) -> Floats:
    """The bilinear field at even steps along both axes, no finer than needed; as it is if they are even."""
    for axis, at in ((1, x), (0, y)):
        steps = np.diff(at)
        if len(steps) < 2 or np.allclose(steps, steps[0]):
            continue
        n = int(min(FINEST, np.ceil((at[-1] - at[0]) / steps.min()) + 1))
        place = np.interp(np.linspace(at[0], at[-1], n), at, np.arange(len(at)))
        left = np.minimum(place.astype(int), len(at) - 2)
        part = (place - left).reshape([-1 if a == axis else 1 for a in (0, 1)])
        values = np.take(values, left, axis) * (1 - part) + np.take(values, left + 1, axis) * part
    return values
