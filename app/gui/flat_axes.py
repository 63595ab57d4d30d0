"""Axes around a view of the plane, by the rules of a picture: room for them, ticks, numbers, and the bar of scale."""

from __future__ import annotations

from PySide6.QtCore import QMargins, QRect
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QWidget

from app.draw import page
from app.draw.charts import logs_of
from app.draw.extent import Box, frame_of, of_layers
from app.draw.page import Rect
from app.gui.cameras import Camera
from app.gui.ink import QtInk
from app.theme import theme
from modules.data.scene import ChartLook, Scene

TOP = 14
RIGHT = 18
BELOW = 42
LEFT = 32
"""Beside the numbers: ticks, and the name of the axis."""


def wanted(scene: Scene | None) -> bool:
    """Whether a view of the scene has axes around it."""
    return scene is not None and scene.look.dimensions == 2 and scene.look.axes


def margins(widget: QWidget, scene: Scene | None, right: int = 0) -> QMargins:
    """The room that axes need around a picture, and a legend at its right."""
    if scene is None or not wanted(scene) or min(widget.width(), widget.height()) < 160:
        return QMargins(0, 0, right, 0)
    box, frame = of_layers(scene.layers), frame_of(scene.layers)
    log = logs_of(scene.layers)[1]
    upright = page.axis(frame.axes[1], frame.units[1], box.low[1], box.high[1], widget.height(), 70, log)
    ink = QtInk(None, theme(scene.look.theme))
    widest = max((ink.extent(words, 10.5)[0] for words in upright.words), default=0.0)
    return QMargins(round(LEFT + widest), TOP, max(RIGHT, right), BELOW)


def paint(painter: QPainter, plot: QRect, scene: Scene, camera: Camera, bar: bool) -> None:
    """Axes around the plot, and in it the bar of scale if wanted."""
    x, y, z = camera["focal"]
    high = float(camera["height"])
    wide = high * plot.width() / max(1, plot.height())
    seen = Box((x - wide / 2, y - high / 2, z), (x + wide / 2, y + high / 2, z))
    ink, frame = QtInk(painter, theme(scene.look.theme)), frame_of(scene.layers)
    where = Rect(plot.x(), plot.y(), plot.width(), plot.height())
    page.flat_axes(ink, where, seen, frame, logs_of(scene.layers))
    if bar and not any(isinstance(one.look, ChartLook) for one in scene.layers):
        cell = next((c for one in scene.layers if (c := getattr(one.shape, "cell", None))), None)
        page.scale_bar(ink, where, seen, frame, cell, "")
