"""What every reader of files needs: a clear sentence when a file cannot be read, its identity, and room in memory."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

import numpy as np

MIB = 1 << 20
SAMPLED_ABOVE = 1 << 30
"""Bytes above which a file is identified by its size and 64 of its MiB."""


class ReadError(ValueError):
    """A file that cannot be read; the sentence names the file and says what to do."""


class NotReadHere(ReadError):
    """A file of a kind that is another reader's."""


def problem(error: ReadError) -> dict[str, object]:
    """The facts of a file that cannot be read; `foreign` if another reader may."""
    return {"names": (), "problem": str(error), "foreign": isinstance(error, NotReadHere)}


def existing(path: Path | None) -> Path:
    """The path, if a file is there.

    Raises
    ------
    ReadError : no file is chosen, it is not there, is a folder, is empty or may not be read
    """
    if path is None or path.as_posix() in ("", "."):
        raise ReadError("no file is chosen: set 'path'")
    if path.is_dir():
        raise NotReadHere(f"{path.name!r} is a folder: choose a file in it")
    if not path.exists():
        raise ReadError(_gone(path))
    if not os.access(path, os.R_OK):
        raise ReadError(f"{path.name!r} may not be read by you: change its permissions, or choose another file")
    if not path.stat().st_size:
        raise ReadError(f"{path.name!r} is empty: copy or download it again")
    return path


def _gone(path: Path) -> str:
    folder = path.parent
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    names = [p.name for p in folder.iterdir()] if os.access(folder, os.R_OK) else []
    if folder != path.parent:
        part = path.relative_to(folder).parts[0]
        return f"there is no folder {part!r} in {folder.as_posix()!r}{nearest(part, names)}"
    return f"there is no file {path.name!r} in {folder.as_posix()!r}{nearest(path.name, names)}"


def nearest(name: str, names: list[str] | tuple[str, ...]) -> str:
    """Words that name what is nearest; "" if nothing is near."""
    lower = {n.lower(): n for n in names}
    close = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=0.5)
    return f"; the nearest is {lower[close[0]]!r}" if close else ""


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what a library raises on a broken file into one sentence."""
    try:
        yield
    except ReadError:
        raise
    except PermissionError:
        raise ReadError(f"{path.name!r} may not be read by you: change its permissions") from None
    except MemoryError:
        raise ReadError(f"{path.name!r} does not fit into memory: read it with a larger 'stride'") from None
    except Exception as error:  # a broken file makes a decoder raise almost anything
        why = short(error)
        raise ReadError(f"{path.name!r} is damaged or is not what its name says ({why}): copy or download it again") from error


def short(error: Exception) -> str:
    """The first line of what a library says, as far as it can be printed and read."""
    line = "".join(c for c in str(error).strip().split("\n")[0] if c.isprintable()).rstrip(".")
    return (line if len(line) <= 100 else line[:97] + "...") or type(error).__name__


def digest(path: Path) -> str:
    """sha256 of the content; of a sample of it, "sample-...", above 1 GiB."""
    size = path.stat().st_size
    total = sha256()
    with path.open("rb") as file:
        if size <= SAMPLED_ABOVE:
            while block := file.read(4 * MIB):
                total.update(block)
            return total.hexdigest()
        total.update(str(size).encode())
        for i in range(64):
            file.seek((size - MIB) * i // 63)
            total.update(file.read(MIB))
    return f"sample-{total.hexdigest()}"


def memory() -> int:
    """Bytes of memory that this process may use."""
    try:
        physical = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 4 << 30
    for limit in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            physical = min(physical, int(Path(limit).read_text()))
        except (OSError, ValueError):
            continue
    return physical


def fits(path: Path, shape: tuple[int, ...], stride: int = 1) -> None:
    """Refuse what would take more than half of the memory.

    Raises
    ------
    ReadError : with both sizes and the stride that would do
    """
    samples = float(np.prod([max(1, -(-n // stride)) for n in shape], dtype=float))
    room = memory() / 2
    if samples * 8 > room:
        enough = stride * int(np.ceil(np.sqrt(samples * 8 / room)))
        named = " x ".join(str(n) for n in shape)
        raise ReadError(
            f"{path.name!r} says it holds {named} samples; as read they take {samples * 8 / 2**30:.3g} GiB, more than half "
            f"of the {memory() / 2**30:.3g} GiB of memory here: read it with stride = {enough}"
        )


def unreadable(path: Path, suffixes: Iterable[str]) -> NotReadHere:
    """That a file of this suffix is not read, and which are."""
    ends = path.suffix or "nothing"
    return NotReadHere(f"{path.name!r}: files that end in {ends!r} are not read here; this reads {', '.join(suffixes)}")
