"""A viewport painted from off-screen frames: it works on any display, and the window never waits for a frame."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRect, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.gui import cameras, flat_axes, style
from app.gui.cameras import Camera
from app.gui.studio import Stage, Studio
from modules.data.scene import Scene


class Painted(QWidget):
    """The painted back end.

    Left button turns (moves in two dimensions), middle or Shift moves, wheel zooms, double click sees all.
    """

    cameraChanged = Signal(object)
    framed = Signal(object)
    failed = Signal(str)
    moved = Signal()
    steered = Signal(object)

    def __init__(self, studio: Studio, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.studio = studio
        self.stage = studio.stage()
        self.scene: Scene | None = None
        self.camera: Camera | None = None
        self.tag: object = None
        self._image: QImage | None = None
        self._from: QPointF | None = None
        self._asked = 0
        self._tell = False
        self._right = 0
        self._whole = True
        self._of: object = None
        self._settle = QTimer(self, singleShot=True, interval=250)
        self._settle.timeout.connect(self._told)
        studio.framed.connect(self._framed)
        studio.failed.connect(self._failed)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(120, 90)
        self.setAccessibleName("Viewport")

    # --- the interface of a viewport

    def show_scene(self, scene: Scene | None, camera: Camera | None, tag: object = None, numbers: bool = False) -> None:
        """Draw a scene; without a camera it is seen as it is, or whole if it is the first."""
        first = self.scene is None or (scene is not None and scene.look.dimensions != self.scene.look.dimensions)
        self.scene = scene
        if scene is None:
            self._image = self.camera = None
            self.studio.draw(self.stage, scene=None)
            self.update()
            return
        self._of = tag
        self._room()
        if first or camera is not None:
            self._whole = camera is None
        self._draw(scene=scene, camera=camera, fit=first and camera is None, numbers=numbers)

    def reserve(self, right: int) -> None:
        """Leave a column free at the right of the picture."""
        if right != self._right:
            self._right = right
            self._room()
            if self.scene is not None:
                self._draw(fit=self._whole)

    def _room(self) -> None:
        self.setContentsMargins(flat_axes.margins(self, self.scene, self._right))

    def set_camera(self, camera: Camera) -> None:
        """See from there."""
        self.camera, self._whole = camera, False
        if self.scene is not None:
            self._draw(camera=camera)

    def fit(self) -> None:
        """See all."""
        if self.scene is not None:
            self._tell = self._whole = True
            self._draw(camera=None, fit=True)

    @property
    def plot(self) -> QRect:
        """Where in the widget the picture is."""
        return self.contentsRect()

    @property
    def surface(self) -> QWidget:
        """The widget that the mouse is over."""
        return self

    @property
    def flat(self) -> bool:
        """Whether the view is locked from above."""
        return self.scene is not None and self.scene.look.dimensions == 2

    def close_stage(self) -> None:
        """The viewport is gone."""
        self.studio.drop(self.stage)

    # --- frames

    def _draw(self, **changes: object) -> None:
        ratio = self.devicePixelRatioF()
        size = (max(16, round(self.plot.width() * ratio)), max(16, round(self.plot.height() * ratio)))
        self._asked += 1
        self.studio.draw(self.stage, size=size, scale=ratio, tag=(self._of, self._asked), **changes)

    def _framed(self, stage: Stage, image: QImage, camera: Camera, tag: object) -> None:
        if stage is not self.stage or self.scene is None:
            return
        image.setDevicePixelRatio(self.devicePixelRatioF())
        self._image = image
        self.tag, serial = tag if isinstance(tag, tuple) else (tag, 0)
        if serial == self._asked:
            self.camera = camera
            if self._tell:
                self._tell = False
                self._settle.start(0)
        self.update()
        self.framed.emit(self.tag)
        self.moved.emit()

    def _failed(self, stage: Stage, sentence: str) -> None:
        if stage is self.stage:
            self.failed.emit(sentence)

    def paintEvent(self, event: QPaintEvent) -> None:
        """The last frame; while a new size is drawn, the old one in its middle."""
        painter = QPainter(self)
        ground = self._image.pixelColor(0, 0) if self._image is not None else style.colour("view")
        painter.fillRect(self.rect(), ground)
        if self._image is None:
            return
        size = self._image.deviceIndependentSize()
        plot = QRectF(self.plot)
        painter.setClipRect(plot)
        painter.drawImage(QRectF(plot.center() - QPointF(size.width(), size.height()) / 2, size), self._image)
        if self.camera is not None and not self.flat and self.scene is not None and self.scene.look.axes:
            self._triad(painter, ground)
        painter.setClipping(False)
        if self.camera is not None and self.scene is not None and self.contentsMargins().left():
            flat_axes.paint(painter, self.plot, self.scene, self.camera, bar=True)
        if self.hasFocus():
            painter.setPen(QPen(style.colour("action"), 1))
            painter.drawRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5))

    def _triad(self, painter: QPainter, ground: QColor) -> None:
        assert self.camera is not None
        right, up = cameras.directions(self.camera)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ink = QColor(style.present()["text"] if _contrasts(ground, style.colour("text")) else style.present()["panel"])
        painter.setPen(QPen(ink, 1.5))
        painter.setFont(style.body(11))
        origin = QPointF(36, self.height() - 34)
        for i, name in enumerate("xyz"):
            tip = QPointF(float(right[i]) * 22, -float(up[i]) * 22)
            if math.hypot(tip.x(), tip.y()) < 3:
                continue
            painter.drawLine(origin, origin + tip)
            painter.drawText(QRectF(origin + tip * 1.35 - QPointF(8, 8), origin + tip * 1.35 + QPointF(8, 8)),
                             Qt.AlignmentFlag.AlignCenter, name)  # fmt: skip

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Ask for a frame of the new size."""
        if self.scene is not None:
            self._room()
            self._draw(fit=self._whole)

    # --- mouse

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to turn or move."""
        self._from = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn or move."""
        if self._from is None or self.camera is None:
            return
        by = event.position() - self._from
        self._from = event.position()
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        left = event.buttons() & Qt.MouseButton.LeftButton
        if event.buttons() & Qt.MouseButton.RightButton:
            self._go(cameras.nearer(self.camera, math.exp(-by.y() / 150)))
        elif left and not shift and not self.flat:
            speed = math.pi / max(1, min(self.width(), self.height()))
            self._go(cameras.turned(self.camera, by.x() * speed, by.y() * speed))
        else:
            self._go(cameras.moved(self.camera, by.x(), by.y(), self.plot.height()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Keep where it is seen from."""
        self._from = None
        self._settle.start(0)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """See all."""
        self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom, in two dimensions to where the pointer is."""
        if self.camera is None:
            return
        plot = self.plot
        place = event.position() - plot.topLeft().toPointF()
        at = (2 * place.x() / max(1, plot.width()) - 1, 1 - 2 * place.y() / max(1, plot.height()))
        factor = math.exp(event.angleDelta().y() / 600)
        self._go(cameras.nearer(self.camera, factor, at, plot.width() / max(1, plot.height())))
        self._settle.start()

    def _go(self, camera: Camera) -> None:
        self.camera, self._whole = camera, False
        self._draw(camera=camera)
        self.steered.emit(camera)

    def _told(self) -> None:
        if self.camera is not None:
            self.cameraChanged.emit(self.camera)


def _contrasts(ground: QColor, ink: QColor) -> bool:
    return abs(ground.lightness() - ink.lightness()) > 90
