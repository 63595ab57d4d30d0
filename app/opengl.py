"""Whether pictures can be drawn on this machine, found out before VTK is asked: without OpenGL it ends the process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
OSMESA = "vtkOSOpenGLRenderWindow"
INSTALL = "apt-get install -y --no-install-recommends libegl1 libgl1"
PATIENCE = 60.0
"""Seconds that one attempt may take on a cold machine."""

SCRIPT = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderer
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.AddRenderer(vtkRenderer())
window.SetSize(8, 8)
window.Render()
print(window.GetClassName())
"""


@dataclass(frozen=True)
class Probe:
    """What was found.

    Parameters
    ----------
    ok : whether a picture can be drawn
    window_class : VTK's window that works, "" if none does
    sentence : what it is, or what to do
    """

    ok: bool
    window_class: str
    sentence: str


@cache
def probe() -> Probe:
    """Draw 8 x 8 pixels in a process of its own, as the machine is and then without a screen; once a process.

    What works is set in the environment, so that VTK takes it when it is first imported here.
    """
    tried: list[str] = []
    for settings in attempts(os.environ):
        outcome = _try(settings)
        if outcome.startswith("vtk"):
            os.environ.update(settings)
            return Probe(True, outcome, f"pictures are drawn by {outcome}")
        tried.append(outcome)
    return Probe(False, "", sentence(tried))


def attempts(environment: Mapping[str, str]) -> list[dict[str, str]]:
    """Settings to try in order: as the machine is (no X server is asked for where there is none), then OSMesa."""
    first: dict[str, str] = {}
    if _linux() and not environment.get("DISPLAY") and not environment.get(VARIABLE):
        first = {VARIABLE: "vtkEGLRenderWindow"}
    return [first, {VARIABLE: OSMESA}] if _linux() else [first]


def sentence(tried: list[str]) -> str:
    """What to do when nothing works."""
    why = f" ({'; '.join(dict.fromkeys(tried))})" if tried else ""
    if _linux():
        return f"this machine has no OpenGL, so no picture can be drawn{why}: {INSTALL}"
    return f"this machine has no OpenGL, so no picture can be drawn{why}: install a graphics driver"


def _linux() -> bool:
    return sys.platform.startswith("linux")


def _try(settings: Mapping[str, str]) -> str:
    """The class of the window that drew, or how the attempt ended."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, **settings},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {PATIENCE:.0f} s"
    except OSError as error:
        return str(error)
    words = done.stdout.split()
    if done.returncode == 0 and words:
        return words[-1]
    return f"exit code {done.returncode}" if done.returncode >= 0 else f"signal {-done.returncode}"
