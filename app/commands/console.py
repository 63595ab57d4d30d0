"""What the command line says and where: results to stdout, progress and complaints to stderr."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from typing import TextIO

from app.engine.errors import NetworkError

BAR = 24
CLEAR = "\r\x1b[K"


class Usage(NetworkError):
    """Words on the command line that mean nothing here."""


class Console:
    """Plain lines in a pipe, bars on a terminal; always UTF-8.

    Parameters
    ----------
    quiet, verbose : nothing but complaints; or everything, tracebacks too
    """

    def __init__(self, *, quiet: bool = False, verbose: bool = False) -> None:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(encoding="utf-8", errors="replace")
        self.quiet, self.verbose = quiet, verbose
        self.out, self.err = sys.stdout, sys.stderr
        self.live = not quiet and _is_terminal(self.err)
        self._bar = False

    def say(self, text: str = "") -> None:
        """A line of the result; not when quiet."""
        if not self.quiet:
            self._clear()
            print(text, file=self.out, flush=True)

    def write(self, text: str) -> None:
        """What was asked for, quiet or not."""
        self._clear()
        print(text, file=self.out, flush=True)

    def complain(self, text: str) -> None:
        """A sentence about what went wrong."""
        self._clear()
        print(text, file=self.err, flush=True)

    def detail(self, text: str) -> None:
        """Only when verbose."""
        if self.verbose and text:
            self.complain(text)

    def progress(self, name: str, fraction: float, rest: str = "") -> None:
        """A bar, on a terminal only."""
        if not self.live:
            return
        full = round(BAR * min(1.0, max(0.0, fraction)))
        bar = f"{'━' * full}{'┄' * (BAR - full)} {100 * fraction:3.0f} %"
        print(f"{CLEAR}{name}  {bar}{rest}", end="", file=self.err, flush=True)
        self._bar = True

    def _clear(self) -> None:
        if self._bar:
            print(CLEAR, end="", file=self.err, flush=True)
            self._bar = False


def _is_terminal(stream: TextIO) -> bool:
    return stream.isatty() and os.environ.get("TERM", "") != "dumb"


def columns(rows: Sequence[Sequence[str]], gap: str = "  ") -> list[str]:
    """Rows as aligned text; the last cell of a row is left as it is."""
    widths: dict[int, int] = {}
    for row in rows:
        for i, cell in enumerate(row[:-1]):
            widths[i] = max(widths.get(i, 0), len(cell))
    return [gap.join([*(cell.ljust(widths[i]) for i, cell in enumerate(row[:-1])), *row[-1:]]).rstrip() for row in rows]
