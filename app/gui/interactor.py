"""A viewport that VTK draws in the window itself, where a graphics card does the work."""

from __future__ import annotations

import os
from typing import Any

from PySide6.QtCore import QRect, QTimer, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QVBoxLayout, QWidget

from app.gui import flat_axes
from app.gui.cameras import Camera
from app.theme import theme
from modules.data.scene import Scene


class Interactor(QWidget):
    """The back end of a real display: VTK's own interaction, the camera told when the mouse is let go."""

    cameraChanged = Signal(object)
    framed = Signal(object)
    failed = Signal(str)
    moved = Signal()
    steered = Signal(object)
    surfaceMade = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.scene: Scene | None = None
        self.tag: object = None
        self._right = 0
        self._view: Any = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._room = QVBoxLayout(self)
        self._room.setContentsMargins(0, 0, 0, 0)

    def _made(self) -> Any:
        """The viewport; it is made when the first scene is there, since VTK takes its time to load."""
        if self._view is None:
            os.environ.setdefault("QT_API", "pyside6")
            from pyvistaqt import QtInteractor

            from app.viewport import Viewport

            widget = QtInteractor(self, auto_update=False, lighting="none")
            self._room.addWidget(widget)
            widget.resize(self.size())
            ratio = self.devicePixelRatioF()
            widget.render_window.SetSize(max(16, round(self.width() * ratio)), max(16, round(self.height() * ratio)))
            widget.lower()
            widget.iren.add_observer("EndInteractionEvent", lambda *_: self.cameraChanged.emit(self.camera))
            widget.iren.add_observer("InteractionEvent", lambda *_: self.steered.emit(self.camera))
            self._view = Viewport(widget, scale=self.devicePixelRatioF())
            widget.renderer.AddObserver("EndEvent", lambda *_: self._drawn())
            self.surfaceMade.emit(widget)
        return self._view

    def show_scene(self, scene: Scene | None, camera: Camera | None, tag: object = None, numbers: bool = False) -> None:
        """Draw a scene; without a camera it is seen as it is, or whole if it is the first."""
        first = self.scene is None
        self.scene, self.tag = scene, tag
        if scene is None:
            return
        try:
            view = self._made()
            view.numbers = numbers
            self._margins()
            view.show(scene)
            if camera is not None:
                view.camera = camera
            elif first:
                QTimer.singleShot(100, self._see_all)
            view.plotter.render()
        except (ValueError, RuntimeError, ImportError) as error:
            self.failed.emit(str(error))
            return
        self.framed.emit(tag)

    def reserve(self, right: int) -> None:
        """Leave a column free at the right of the picture."""
        if right != self._right:
            self._right = right
            self._margins()

    def _margins(self) -> None:
        self.setContentsMargins(flat_axes.margins(self, self.scene, self._right))

    def _drawn(self) -> None:
        """A frame stands: what lies around and over it follows."""
        self.moved.emit()
        if not self.contentsMargins().isNull():
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The axes around a view of the plane."""
        camera = self.camera
        if camera is None or self.scene is None or self.contentsMargins().isNull():
            return
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme(self.scene.look.theme)["view"]))
        if self.contentsMargins().left():
            flat_axes.paint(painter, self.plot, self.scene, camera, bar=False)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """The room of the axes follows the size."""
        self._margins()

    def _see_all(self) -> None:
        """Once the window has its size."""
        if self.scene is not None and self._view is not None:
            self._view.fit()
            self._view.plotter.render()

    @property
    def camera(self) -> Camera | None:
        """Where the view is seen from."""
        return None if self._view is None or self.scene is None else dict(self._view.camera)

    def set_camera(self, camera: Camera) -> None:
        """See from there."""
        if self.scene is not None:
            view = self._made()
            view.camera = camera
            view.plotter.render()

    def fit(self) -> None:
        """See all."""
        if self.scene is not None:
            view = self._made()
            view.fit()
            view.plotter.render()
            self.cameraChanged.emit(self.camera)

    @property
    def plot(self) -> QRect:
        """Where in the widget the picture is."""
        return self.contentsRect()

    @property
    def surface(self) -> QWidget | None:
        """The widget that the mouse is over; None until there was a scene."""
        return None if self._view is None else self._view.plotter

    @property
    def flat(self) -> bool:
        """Whether the view is locked from above."""
        return self.scene is not None and self.scene.look.dimensions == 2

    def close_stage(self) -> None:
        """The viewport is gone."""
        if self._view is not None:
            self._view.plotter.close()
            self._view = None
