"""Where a scene is drawn: a plotter without a window, its lights, and the camera that sees all of a scene."""

from __future__ import annotations

import math
import os
import sys
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from app.draw.extent import Box
from modules.data.scene import Scene, SurfaceLook

Camera = dict[str, Any]
"""position, focal, up: three numbers each; angle in degrees; height in world units (parallel); parallel: a flag."""

ANGLE = 26.0
"""Of view, in degrees: a long lens, which bends a surface little."""
FROM = (-0.42, -1.0, 0.72)
"""Where a view in space is first seen from: the south, a little west, above."""
MARGIN = 1.13
"""Room around a box for its numbers, as a factor."""


def prepare() -> None:
    """Before VTK is first imported: no X server is asked for where there is none."""
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def off_screen(size: tuple[int, int]) -> Any:
    """A plotter without a window, `size` pixels wide and high, that smooths its edges."""
    prepare()
    import pyvista
    from vtkmodules.vtkCommonCore import vtkSMPTools

    vtkSMPTools.SetBackend("STDThread")
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
    plotter.render_window.SetMultiSamples(4)
    return plotter


def ground_of(scene: Scene) -> Literal["view", "clay"]:
    """What lines and dust of a scene lie on."""
    surfaces = [one.look for one in scene.layers if isinstance(one.look, SurfaceLook)]
    return "clay" if any(look.colour == "clay" and look.opacity > 0.5 for look in surfaces) else "view"


def fitted(extent: Box, dimensions: int, aspect: float, exaggeration: float = 1.0) -> Camera:
    """The camera that sees all of a box: from above in two dimensions, from the south and above in three."""
    if dimensions == 2:
        wide, high = extent.sides[0] or 1.0, extent.sides[1] or 1.0
        height = max(high, wide / aspect)
        x, y, z = extent.centre
        return {
            "position": [x, y, z + 10 * extent.diagonal], "focal": [x, y, z], "up": [0.0, 1.0, 0.0],
            "angle": ANGLE, "height": height, "parallel": True,
        }  # fmt: skip
    lifted = extent.lifted(exaggeration)
    length = math.sqrt(sum(v * v for v in FROM))
    away = [v / length for v in FROM]
    position, focal = lifted.seen_from(away, ANGLE, aspect, MARGIN)
    return {
        "position": position.tolist(), "focal": focal.tolist(), "up": [0.0, 0.0, 1.0],
        "angle": ANGLE, "height": lifted.diagonal, "parallel": False,
    }  # fmt: skip


def lights(renderer: Any) -> None:
    """A light over the left shoulder, and a weak one from the right that opens the shadows."""
    from vtkmodules.vtkRenderingCore import vtkLight

    renderer.RemoveAllLights()
    for place, strength in (((-0.7, 0.75, 0.8), 0.92), ((0.9, 0.1, 0.7), 0.22)):
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*place)
        light.SetFocalPoint(0.0, 0.0, 0.0)
        light.SetIntensity(strength)
        renderer.AddLight(light)


def grabbed(window: Any) -> NDArray[np.uint8]:
    """(height, width, 3) what a window shows, without drawing it again."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGB()
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    grab.Update()
    width, height = window.GetSize()
    flat = np.asarray(vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()), np.uint8)
    return flat.reshape(height, width, 3)[::-1]


def depths(window: Any) -> NDArray[np.float32]:
    """(height, width) depth of what a window shows, 0 near to 1 far; row 0 lowest."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkFloatArray

    width, height = window.GetSize()
    buffer = vtkFloatArray()
    window.GetZbufferData(0, 0, width - 1, height - 1, buffer)
    return np.asarray(vtk_to_numpy(buffer), np.float32).reshape(height, width)
