"""A scene as a picture: drawn by VTK off screen, set on a page with title, axes and the legend that cannot be hidden."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import page, placing, space
from app.draw.charts import logs_of
from app.draw.extent import Box, frame_of, of_layers
from app.draw.parts import Legend
from app.draw.pen import Pen
from app.legend import legend
from app.theme import theme
from app.viewport import Camera, Viewport, fitted, ground_of, off_screen
from modules.data.scene import ChartLook, ImageLook, LabelLook, Scene, Text

FINER = 2
"""The scene is drawn so many times as large and averaged, which smooths all edges."""
LARGEST = 8192
"""Pixels of a side: what is larger, not every graphics card draws. Beyond half of it a scene is not drawn finer."""
LEAST = (320, 240)

Check = Callable[[float], object]


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """A picture and what it says.

    Parameters
    ----------
    image : (height, width, 4) uint8
    legend : what is drawn, what is not, what nobody gave
    caption : the same in words, one to three sentences
    pixel_unit : half the diagonal of a pixel in world units, a proven bound of what drawing adds to positions; in space
        across the line of sight, at the far end of the scene, where it is largest
    unit : of `pixel_unit`
    camera : where it is seen from
    """

    image: NDArray[np.uint8]
    legend: Legend
    caption: str
    pixel_unit: float
    unit: str
    camera: Camera


def render(
    scene: Scene,
    *,
    size: tuple[int, int] = (1600, 1000),
    k: float = 2.0,
    camera: Mapping[str, Any] | None = None,
    scale: float = 1.0,
    check: Check | None = None,
) -> Picture:
    """The picture of a scene, with its legend.

    Parameters
    ----------
    size : width and height in pixels, from 320 x 240 to 8192 x 8192
    k : coverage factor of standard deviations in the legend
    camera : where it is seen from, as a viewport gives it; None to see all
    scale : of text and widths; 1 suits the size
    check : called with the fraction done; what it raises ends the work

    Raises
    ------
    ValueError : a size too small for a page or too large to draw, or a layer that nobody draws

    Accuracy: adds at most half the diagonal of a pixel to the position of what is drawn (`pixel_unit`, proven).
    """
    if size[0] < LEAST[0] or size[1] < LEAST[1]:
        raise ValueError(f"a picture of {size[0]} x {size[1]} pixels has no room for its legend: 320 x 240 is the least")
    if max(size) > LARGEST:
        raise ValueError(f"a picture of {size[0]} x {size[1]} pixels is too large to draw: {LARGEST} a side is the most")
    words = legend(scene, k=k, check=check)
    pen = Pen(size, theme(scene.look.theme), scale * automatic_scale(size))
    flat = scene.look.dimensions == 2
    sheet = _Sheet(scene, words, pen, camera)
    finer = FINER if max(size) * FINER <= LARGEST else 1
    plotter = off_screen((sheet.plot.width * finer, sheet.plot.height * finer))
    try:
        viewport = Viewport(plotter, scale=pen.scale * finer, stretch=sheet.stretch, words=False)
        viewport.show(scene)
        viewport.camera = sheet.camera if sheet.camera is not None else viewport.camera
        pen.image(averaged(viewport.pixels(), finer), sheet.plot.x, sheet.plot.y)
        if flat:
            sheet.draw_flat(viewport)
        else:
            sheet.draw_space(viewport)
        pixel = viewport.pixel(farthest=not flat) * finer * math.sqrt(0.5)
        seen = viewport.camera
    finally:
        plotter.close()
    page.title(pen, scene.look, sheet.plan)
    sheet.plan.panel.draw(*sheet.plan.at)
    unit = sheet.frame.units[0]
    return Picture(image=pen.pixels(), legend=words, caption=words.caption, pixel_unit=pixel, unit=unit, camera=seen)


def automatic_scale(size: tuple[int, int]) -> float:
    """Text grows with the picture, more slowly: 1 up to about 1000 x 700 pixels, 1.4 at 1600 x 1000."""
    return float(min(3.0, max(1.0, math.sqrt(size[0] * size[1] / 800_000))))


def averaged(pixels: NDArray[np.uint8], times: int) -> NDArray[np.uint8]:
    """(h, w, 4) pixels that are the mean of `times` x `times` finer ones."""
    height, width = pixels.shape[0] // times, pixels.shape[1] // times
    blocks = pixels[: height * times, : width * times, :3].reshape(height, times, width, times, 3)
    total = blocks.sum(axis=(1, 3), dtype=np.uint16)
    out = np.full((height, width, 4), 255, np.uint8)
    out[..., :3] = (total + times * times // 2) // (times * times)
    return out


class _Sheet:
    """One picture being made: the plan of its page, and what is drawn over the scene."""

    def __init__(self, scene: Scene, words: Legend, pen: Pen, camera: Mapping[str, Any] | None) -> None:
        self.scene, self.pen = scene, pen
        self.look = scene.look
        self.frame = frame_of(scene.layers)
        self.logs = logs_of(scene.layers)
        charts = bool(scene.layers) and all(isinstance(one.look, ChartLook) for one in scene.layers)
        filled = any(isinstance(one.look, ImageLook) for one in scene.layers)
        box = of_layers(scene.layers)
        self.view = box if filled else box.padded(0.03, each=charts)
        flat = self.look.dimensions == 2
        free = not flat or charts or camera is not None
        aspect = None if free else (self.view.sides[0] or 1.0) / (self.view.sides[1] or self.view.sides[0] or 1.0)
        if aspect is not None:
            aspect = min(8.0, max(0.125, aspect))
        ground, logs = ground_of(scene), self.logs
        self.plan = page.plan(pen, self.look, words, self.view, self.frame, aspect=aspect, ground=ground, logs=logs)
        self.plot = self.plan.plot
        self.stretch = 1.0
        self.camera = None if camera is None else dict(camera)
        if flat:
            self._look_down(charts)

    def _look_down(self, charts: bool) -> None:
        """The part of the plane that the plot shows, and the camera that sees just that."""
        ratio = self.plot.width / self.plot.height
        if charts and self.camera is None:
            wide, high = self.view.sides[0] or 1.0, self.view.sides[1] or 1.0
            self.stretch = wide / high / ratio
            self.camera = fitted(self._stretched(self.view), 2, ratio)
            return
        self.camera = self.camera or fitted(self.view, 2, ratio)
        x, y, _ = self.camera["focal"]
        high = float(self.camera["height"])
        low = (x - high * ratio / 2, y - high / 2, self.view.low[2])
        self.view = Box(low, (x + high * ratio / 2, y + high / 2, self.view.high[2]))

    def _stretched(self, box: Box) -> Box:
        low, high = box.low, box.high
        return replace(box, low=(low[0], low[1] * self.stretch, low[2]), high=(high[0], high[1] * self.stretch, high[2]))

    def _projector(self, viewport: Viewport) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
        """Places as they are drawn to pixels of the page."""
        plot = self.plot
        return lambda points: viewport.project(points) * [plot.width, plot.height] + [plot.x, plot.y]

    def draw_flat(self, viewport: Viewport) -> None:
        """Labels, axes and the scale bar of a picture of the plane."""
        self._labels(viewport)
        if self.look.axes:
            page.flat_axes(self.pen, self.plot, self.view, self.frame, self.logs)
        cell = next((c for one in self.scene.layers if (c := getattr(one.shape, "cell", None))), None)
        if self.stretch == 1.0 and not any(self.logs):
            page.scale_bar(self.pen, self.plot, self.view, self.frame, cell, self.look.legend)

    def draw_space(self, viewport: Viewport) -> None:
        """Labels, numbers along the box, and the triad of a picture in space."""
        self._labels(viewport)
        if not self.look.axes:
            return
        box = of_layers(self.scene.layers)
        seen, factor = viewport.camera, self.look.exaggeration
        if box.known:
            project, eye = self._projector(viewport), np.asarray(seen["position"])
            space.axes(self.pen, self.plot, box.lifted(factor), self.frame, factor, project, eye)
        right, up = viewport.directions()
        space.triad(self.pen, self.plot, self.frame, right, up, self.look.legend)

    def _labels(self, viewport: Viewport) -> None:
        """Words of all label layers; the later ones make way for the earlier."""
        pen, taken = self.pen, list[placing.Placed]()
        bounds = (self.plot.x, self.plot.y, self.plot.right, self.plot.bottom)
        for layer in self.scene.layers:
            if not isinstance(layer.look, LabelLook) or not isinstance(layer.shape, Text):
                continue
            text, size = layer.shape, layer.look.size
            if text.corner:
                page.corner_words(pen, self.plot, text.corner, text.words, size, layer.look.colour)
            found = placing.place(
                text,
                lambda points: self._seen(viewport, points),
                lambda words, size=size: pen.extent(words, size),  # type: ignore[misc]  # the size is bound now
                bounds,
                pad=pen.px(3),
                apart=pen.px(150),
                taken=taken,
            )
            taken += found
            for one in found:
                _write(pen, one, size, layer.look.colour)

    def _seen(self, viewport: Viewport, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels of places in the world; NaN where something lies before them."""
        if self.look.dimensions == 2:
            return self._projector(viewport)(points)
        lifted = points * [1.0, 1.0, self.look.exaggeration]
        at = self._projector(viewport)(lifted)
        at[viewport.hidden(lifted)] = np.nan
        return at


def _write(pen: Pen, label: placing.Placed, size: float, role: str) -> None:
    """A label centred on its place, along its angle."""
    turn = math.radians(label.angle)
    drop = 0.36 * pen.px(size)
    x, y = label.x + drop * math.sin(turn), label.y + drop * math.cos(turn)
    pen.text(x, y, label.words, size=size, role=role, across="center", angle=label.angle, halo="view")
