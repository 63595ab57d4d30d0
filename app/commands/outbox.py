"""Files are written whole or not at all: each to a temporary name beside its place, all renamed at the end."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

from app.commands.console import Usage


class Outbox:
    """Stages files; `commit` puts them in their places. Without it nothing is changed."""

    def __init__(self) -> None:
        self._staged: list[tuple[Path, Path]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for temporary, _ in self._staged:
            temporary.unlink(missing_ok=True)

    def place(self, path: Path) -> Path:
        """A name beside `path`, with its suffix, to write to.

        Raises
        ------
        Usage : there is no such folder, it cannot be written, or the name is taken by another output
        """
        if path.is_dir():
            raise Usage(f"{str(path)!r} is a folder: name a file in it")
        if not path.parent.is_dir():
            raise Usage(f"there is no folder {str(path.parent)!r} to write {path.name!r} to: make it first")
        if any(final.absolute() == path.absolute() for _, final in self._staged):
            raise Usage(f"two outputs would go to {str(path)!r}: name two files")
        try:
            handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        except OSError as error:
            raise Usage(f"{str(path)!r} cannot be written: {error.strerror or error}") from None
        os.close(handle)
        self._staged.append((Path(name), path))
        return Path(name)

    def put(self, path: Path, data: bytes) -> None:
        """Stage a file by its bytes."""
        with self.place(path).open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())

    def staged(self, path: Path) -> bytes:
        """What will stand in a file that was staged.

        Raises
        ------
        KeyError : it was not
        """
        return {final.absolute(): temporary for temporary, final in self._staged}[path.absolute()].read_bytes()

    def commit(self) -> list[Path]:
        """Rename all, and return where they are."""
        mask = os.umask(0)
        os.umask(mask)
        written = []
        while self._staged:
            temporary, final = self._staged[0]
            os.chmod(temporary, (final.stat().st_mode & 0o7777) if final.exists() else 0o666 & ~mask)
            os.replace(temporary, final)
            self._staged.pop(0)
            written.append(final)
        return written
