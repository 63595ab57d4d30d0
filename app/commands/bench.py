"""`nonius bench [NAME]`: the scripts in tests/benchmarks of a checkout; each gives ratios to a peer in the same run."""

from __future__ import annotations

import argparse
import runpy
from pathlib import Path

from app import paths
from app.commands.console import Console, Usage
from app.engine.errors import hint


def run(options: argparse.Namespace, console: Console) -> int:
    """Run one benchmark, or all."""
    scripts = found()
    if not scripts:
        raise Usage("benchmarks come with a checkout of the sources, not with the installed program")
    if options.name and options.name not in scripts:
        raise Usage(f"there is no benchmark {options.name!r}{hint(options.name, scripts)}")
    for name, path in scripts.items():
        if options.name in (None, name):
            console.say(f"{name}")
            main = runpy.run_path(str(path)).get("main")
            if main is None:
                console.complain(f"nonius: {path.name} has no main()")
                return 1
            main()
    return 0


def found() -> dict[str, Path]:
    """The benchmarks by name."""
    root = paths.checkout()
    folder = root / "tests" / "benchmarks" if root else None
    return {p.stem.removeprefix("bench_"): p for p in sorted(folder.glob("*.py"))} if folder else {}
