"""Whether this machine can draw. Without OpenGL VTK dies with a segmentation fault, so a child process tries it first."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Self

from app import paths
from app.engine.errors import NoniusError

WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
EGL, OSMESA = "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"
APT = "sudo apt-get install -y --no-install-recommends libegl1 libgl1"
PATIENCE = 60.0
"""Seconds after which a driver that does not answer counts as none."""

TRY = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderer
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.AddRenderer(vtkRenderer())
window.SetSize(8, 8)
window.Render()
print(window.GetClassName())
"""


class NoOpenGL(NoniusError):
    """Nothing can be drawn on this machine as it is."""


@dataclass(frozen=True)
class Drawing:
    """How this machine draws: the kind of window, and the variable that chooses it; no window if it cannot."""

    window: str
    environment: Mapping[str, str]
    said: str = ""


def ways() -> Iterator[dict[str, str]]:
    """Ways to draw off screen, the best first. Where there is no display, no X server is asked for."""
    if os.environ.get(WINDOW):
        yield {}
    elif sys.platform.startswith("linux"):
        yield {} if os.environ.get("DISPLAY") else {WINDOW: EGL}
        yield {WINDOW: OSMESA}
    else:
        yield {}


class Probe:
    """Tries in child processes, from the moment it is made; `result` waits for the answer."""

    def __init__(self) -> None:
        self._ways = list(ways())
        self._child = self._start(self._ways[0])

    def result(self) -> Drawing:
        """How this machine draws."""
        said = ""
        for i, way in enumerate(self._ways):
            child = self._child if i == 0 else self._start(way)
            try:
                out, err = child.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                child.kill()
                out, err = child.communicate()
            if child.returncode == 0 and out.split():
                return Drawing(out.split()[-1], way)
            said = said or err.strip() or f"it ended with {child.returncode}"
        return Drawing("", {}, said)

    def close(self) -> None:
        """Nobody waits for the answer."""
        if self._child.poll() is None:
            self._child.kill()
            self._child.communicate()

    @staticmethod
    def _start(way: Mapping[str, str]) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-c", TRY], env={**os.environ, **way}, text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip


class Drawer:
    """Finds out how to draw while the network runs, for whoever will draw."""

    def __init__(self, draws: bool) -> None:
        self._probe = Probe() if draws else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._probe:
            self._probe.close()

    def prepare(self) -> None:
        """Make this process draw as the child could.

        Raises
        ------
        NoOpenGL : with what to install
        """
        drawing = (self._probe or Probe()).result()
        if not drawing.window:
            raise NoOpenGL(f"this machine cannot draw, VTK finds no OpenGL: {remedy()}; `nonius doctor` says more")
        os.environ.update(drawing.environment)


def remedy() -> str:
    """What to install."""
    return f"on Debian or Ubuntu `{APT}`" if sys.platform.startswith("linux") else "install a driver of the graphics card"


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: whether it is well, and what to do if not."""

    well: bool
    what: str
    remedy: str = ""


def findings() -> Iterator[Finding]:
    """All that may keep the program from working here."""
    from app.engine import user_folder
    from app.engine.catalogue import Catalogue
    from app.engine.machine import cores, memory
    from modules.kernels import _jit

    probe = Probe()
    found = paths.versions()
    yield Finding(True, ", ".join(f"{name} {version}" for name, version in found.items()))
    yield Finding(True, f"{cores()} cores, {memory() / 2**30:.1f} GiB of memory for this process")
    intruder = paths.intruder()
    beside = f"another package 'modules' is in the way: {intruder}" if intruder else "its modules lie beside it"
    yield Finding(not intruder, beside, "give nonius-explorer an environment of its own")
    yield Finding(bool(paths.networks()), f"{len(paths.networks())} packaged networks", "install the program again")
    yield _binding()
    folder = _jit.cache_folder()
    warm = "compiled" if _jit.is_warm() else "not all compiled yet (`nonius warm`)"
    kernels = f"kernels {warm}, kept in {folder}" if folder else "no folder for compiled kernels can be written"
    yield Finding(folder is not None, kernels, "set NONIUS_CACHE to a folder that can; until then each run compiles anew")
    catalogue = Catalogue.load()
    yield Finding(True, f"{len(catalogue)} modules; your own go to {user_folder.default()}")
    for broken in catalogue.broken.values():
        yield Finding(False, f"{broken.where} did not load: {broken.sentence}", "mend the file, or take it out")
    drawing = probe.result()
    draws = f"draws by {drawing.window}" if drawing.window else f"cannot draw: {last_line(drawing.said)}"
    yield Finding(bool(drawing.window), draws, remedy())


def _binding() -> Finding:
    from importlib import metadata

    try:
        version = metadata.version("pyside6-essentials")
    except metadata.PackageNotFoundError:
        return Finding(True, "no Qt: pictures without windows")
    bad = version.startswith("6.12.0") and sys.version_info < (3, 12)
    return Finding(not bad, f"Qt {version}", "PySide6 6.12.0 ends the process on Python before 3.12: install another version")


def last_line(text: str) -> str:
    """The last line that says something, without a logger's decoration."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
    line = next((line for line in reversed(plain.splitlines()) if line.strip()), "no reason given")
    return line.rsplit("| ", 1)[-1].strip()
