"""`nonius gui [network]`: open the window."""

from __future__ import annotations

import argparse
import os
import sys
from importlib import import_module, util

from app.commands.console import Console, Usage

HEADLESS = "there is no display to open a window on: set DISPLAY, or use `nonius run`, which needs none"


def run(options: argparse.Namespace, console: Console) -> int:
    """Open the window, if there is something to open it on.

    Raises
    ------
    Usage : no display, or no Qt
    """
    if util.find_spec("PySide6") is None:
        raise Usage("the window needs Qt: pip install pyside6-essentials pyvistaqt")
    chosen = os.environ.get("QT_QPA_PLATFORM", "")
    screens = [name for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)]
    if sys.platform.startswith("linux") and not screens and not chosen:
        raise Usage(HEADLESS)
    return int(import_module("app.gui").main(options.network or "", options.theme or ""))
