"""What may keep the program from working on this machine, and what to do about it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from threading import Thread

from app import opengl, paths
from app.engine.errors import NoniusError


class NoOpenGL(NoniusError):
    """Nothing can be drawn on this machine as it is."""


class Drawer:
    """Finds out how this machine draws while the network runs: without OpenGL VTK would end the process.

    Parameters
    ----------
    draws : whether it will be asked
    """

    def __init__(self, draws: bool = True) -> None:
        self._asking = Thread(target=opengl.probe, name="nonius-opengl", daemon=True)
        if draws:
            self._asking.start()

    def prepare(self) -> None:
        """Make this process draw as a child could.

        Raises
        ------
        NoOpenGL : with what to install
        """
        if self._asking.is_alive():
            self._asking.join()
        found = opengl.probe()
        if not found.ok:
            raise NoOpenGL(f"{found.sentence}; `nonius doctor` says more")


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
    drawing = opengl.probe()
    yield Finding(drawing.ok, drawing.sentence)


def _binding() -> Finding:
    from importlib import metadata

    try:
        version = metadata.version("pyside6-essentials")
    except metadata.PackageNotFoundError:
        return Finding(True, "no Qt: pictures without windows")
    bad = version.startswith("6.12.0") and sys.version_info < (3, 12)
    return Finding(not bad, f"Qt {version}", "PySide6 6.12.0 ends the process on Python before 3.12: install another version")
