"""Drawing off screen in a thread of its own: plotters live, draw and are closed there; frames cross as images."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QThread, Signal
from PySide6.QtGui import QImage

from app.gui.cameras import Camera
from modules.data.scene import Scene


@dataclass(eq=False)
class Stage:
    """What one viewport wants drawn next; the newest wins. Written by the window, taken by the thread."""

    scene: Scene | None = None
    size: tuple[int, int] = (640, 400)
    scale: float = 1.0
    numbers: bool = False
    camera: Camera | None = None
    fit: bool = False
    due: bool = False
    gone: bool = False
    tag: object = None
    drawn: Any = field(default=None, repr=False)


class Studio(QThread):
    """The thread that draws for all viewports.

    `framed` gives (stage, image, camera, tag); `failed` (stage, sentence). Jobs that need VTK run here too.
    """

    framed = Signal(object, QImage, object, object)
    failed = Signal(object, str)
    did = Signal(object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("nonius-studio")
        self._stages: list[Stage] = []
        self._jobs: list[tuple[object, Callable[[], Any]]] = []
        self._some = threading.Condition()
        self._closed = False
        self._why = ""
        self._ready = False

    def stage(self) -> Stage:
        """A new place to draw on."""
        made = Stage()
        with self._some:
            self._stages.append(made)
        return made

    def draw(self, stage: Stage, **changes: Any) -> None:
        """Ask for a frame; what was asked and not yet drawn is overtaken."""
        with self._some:
            for name, value in changes.items():
                setattr(stage, name, value or getattr(stage, name) if name == "fit" else value)
            if changes.get("camera") is not None:
                stage.fit = False
            stage.due = stage.scene is not None
            self._some.notify()
        if not self.isRunning() and not self._closed:
            self.start()

    def do(self, tag: object, job: Callable[[], Any]) -> None:
        """Run a job that draws; `did` gives (tag, result or exception)."""
        with self._some:
            self._jobs.append((tag, job))
            self._some.notify()
        if not self.isRunning() and not self._closed:
            self.start()

    def drop(self, stage: Stage) -> None:
        """The viewport is gone."""
        with self._some:
            stage.gone = True
            self._some.notify()

    def close(self) -> None:
        """End the thread; its plotters are closed in it."""
        with self._some:
            self._closed = True
            self._some.notify()
        self.wait(20000)

    # --- in the thread

    def run(self) -> None:
        """What the thread does."""
        try:
            self._load()
            while (work := self._next()) is not None:
                if isinstance(work, Stage):
                    self._draw(work)
                else:
                    self._do(*work)
        finally:
            for stage in self._stages:
                _shut(stage)

    def _next(self) -> Stage | tuple[object, Callable[[], Any]] | None:
        with self._some:
            while True:
                if self._closed:
                    return None
                for stage in [s for s in self._stages if s.gone]:
                    self._stages.remove(stage)
                    _shut(stage)
                due = next((s for s in self._stages if s.due), None)
                if due is not None:
                    due.due = False
                    self._stages.remove(due)
                    self._stages.append(due)  # the others have their turn first next time
                    return due
                if self._jobs:
                    return self._jobs.pop(0)
                self._some.wait()

    def _load(self) -> None:
        """Load what draws before it is needed; why it cannot is said when something is to be drawn."""
        try:
            self._prepare()
            import pyvista.plotting  # noqa: F401

            import app.viewport  # noqa: F401  # pyvista comes with the first plotter
        except Exception:
            return

    def _prepare(self) -> None:
        """Find out how this machine draws, before VTK is asked.

        Raises
        ------
        NoOpenGL : with what to install
        """
        if not self._ready:
            from app.doctor import Drawer

            Drawer().prepare()
            self._ready = True

    def _draw(self, stage: Stage) -> None:
        with self._some:
            scene, size, scale = stage.scene, stage.size, stage.scale
            camera, fit, tag = stage.camera, stage.fit, stage.tag
            stage.camera, stage.fit = None, False
        if scene is None:
            return
        try:
            self._prepare()
            image, seen = frame(stage, scene, size, scale, camera, fit)
        except Exception as error:
            self.failed.emit(stage, str(error))
            return
        self.framed.emit(stage, image, seen, tag)

    def _do(self, tag: object, job: Callable[[], Any]) -> None:
        try:
            self._prepare()
            result = job()
        except Exception as error:
            result = error
        self.did.emit(tag, result)


def frame(
    stage: Stage, scene: Scene, size: tuple[int, int], scale: float, camera: Camera | None, fit: bool
) -> tuple[QImage, Camera]:
    """One frame of a stage, in the thread that owns its plotter; the camera as it was drawn."""
    from app.viewport import Viewport, off_screen

    if stage.drawn is None:
        stage.drawn = Viewport(off_screen(size), scale=scale)
    view = stage.drawn
    view.scale = scale
    view.plotter.render_window.SetSize(*size)
    if view.scene is not scene or view.numbers != stage.numbers:
        view.numbers = stage.numbers
        view.show(scene)
    if camera is not None:
        view.camera = camera
    elif fit:
        view.fit()
    pixels = np.ascontiguousarray(view.pixels())
    height, width = pixels.shape[:2]
    image = QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()
    return image, view.camera


def _shut(stage: Stage) -> None:
    if stage.drawn is not None:
        stage.drawn.plotter.close()
        stage.drawn = None
