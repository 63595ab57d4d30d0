"""Which way a viewport draws: VTK in the window where a graphics card does it, painted frames everywhere else."""

from __future__ import annotations

import os
from functools import cache

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext
from PySide6.QtWidgets import QWidget

from app.gui.interactor import Interactor
from app.gui.painted import Painted
from app.gui.studio import Studio

BackEnd = Painted | Interactor
"""`show_scene(scene, camera, tag)`, `set_camera`, `fit`, `camera`, `flat`, `tag`; signals cameraChanged, framed, failed."""

PLATFORMS = ("xcb", "wayland", "windows", "cocoa")
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software", "swiftshader", "basic render")
RENDERER = 0x1F01


def back_end(studio: Studio, parent: QWidget | None = None) -> BackEnd:
    """A viewport for this display; `NONIUS_VIEWPORT` (painted or window) overrules."""
    return Interactor(parent) if in_window() else Painted(studio, parent)


def in_window() -> bool:
    """Whether VTK draws in the window itself."""
    asked = os.environ.get("NONIUS_VIEWPORT", "")
    return asked == "window" or (asked != "painted" and accelerated())


@cache
def accelerated() -> bool:
    """Whether a graphics card draws on this display."""
    if QGuiApplication.platformName() not in PLATFORMS:
        return False
    surface = QOffscreenSurface()
    surface.create()
    context = QOpenGLContext()
    if not context.create() or not context.makeCurrent(surface):
        return False
    try:
        name = str(context.functions().glGetString(RENDERER) or "").lower()
    finally:
        context.doneCurrent()
    return bool(name) and not any(word in name for word in SOFTWARE)
