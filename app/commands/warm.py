"""`nonius warm`: compile the kernels in a child process, so that it can be stopped at once."""

from __future__ import annotations

import argparse
import subprocess
import sys

from app.commands.console import Console

CHILD = """
import sys, threading
sys.path[:] = {path!r}
from modules.kernels import _jit
asked = []
threading.Thread(target=lambda: [asked.append(line.strip()) for line in sys.stdin], daemon=True).start()
_jit.warm(lambda fraction, name: print(f"{{fraction:.3f}} {{name}}", flush=True), asked)
"""
"""Tells how far it is; takes names of kernel files, which then come first."""


def run(options: argparse.Namespace, console: Console) -> int:
    """Compile what is not compiled."""
    from modules.kernels import _jit

    if _jit.is_warm():
        console.say(f"the kernels are compiled already, in {_jit.cache_folder()}")
        return 0
    code = warm(console)
    folder = _jit.cache_folder()
    if code == 0:
        console.say(f"compiled into {folder}" if folder else "compiled, but no folder can be written to keep it")
    else:
        console.complain("nonius: the kernels did not compile; the lines above say why")
    return 0 if code == 0 else 1


def warm(console: Console) -> int:
    """Compile in a child and say how far it is; its exit code."""
    words = [sys.executable, "-c", CHILD.format(path=sys.path)]
    child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    try:
        for line in child.stdout or ():
            fraction, _, name = line.strip().partition(" ")
            console.progress("compiling the kernels", float(fraction), f"  {name}")
            if name and not console.live:
                console.say(f"compiling {name}")
        return child.wait()
    finally:
        child.kill()
        child.wait()
        if child.stdout:
            child.stdout.close()
