"""Data files: where a path leads, and what identifies the content behind it.

A path is relative to the network's folder, absolute, a pattern (`slices/*.png`), a folder, or
"package:<package>/<file inside it>". Into a key goes the content alone, never the name, the time or the place.
"""

from __future__ import annotations

import importlib.util
import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from app.engine.errors import nearest
from modules.parameters import Parameter
from modules.progress import Cancelled, Progress

if TYPE_CHECKING:
    from app.engine.catalogue import Catalogue
    from app.engine.network import Network
    from modules.declare import Module

MIB = 1 << 20
LARGE = 1 << 30
"""Bytes above which content is identified by a sample: first, last and 62 spread MiB, and the size."""

YOUNG = 2.0
"""Seconds; the digest of a file that changed more recently is not remembered, for the clock may not tell a next change."""

PACKAGE = "package:"

Stamp = tuple[str, int, int, int, int]
"""(path, device, inode, size, mtime in ns)."""


@dataclass(frozen=True)
class Identity:
    """What is behind a path.

    Parameters
    ----------
    content : what enters the key: digests with suffixes or relative names
    stamps : the files, as they were when they were digested
    sampled : a file was larger than 1 GiB and identified by a sample
    problem : why there is none: a sentence without the node's name
    """

    content: tuple[Any, ...] = ()
    stamps: tuple[Stamp, ...] = ()
    sampled: bool = False
    problem: str = ""

    @property
    def sha256(self) -> str:
        """Of a single file; "" for others."""
        single = len(self.content) and self.content[0] == "file"
        return str(self.content[1]) if single else ""

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(stamp[3] for stamp in self.stamps)

    def changed(self) -> str:
        """The first file that is no longer as it was; "" if all are."""
        for stamp in self.stamps:
            try:
                now = stamp_of(Path(stamp[0]))
            except OSError:
                return stamp[0]
            if now != stamp:
                return stamp[0]
        return ""


Identities = Mapping[tuple[str, str], Identity]
"""(node, parameter) -> identity."""


class Digests:
    """Remembers digests by (device, inode, size, mtime)."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int, int, int], str] = {}
        self._lock = threading.Lock()

    def of(self, path: Path, progress: Progress | None = None) -> tuple[str, Stamp]:
        """sha256 of a file's content (of a sample, "sample-...", above 1 GiB) and its stamp.

        Raises
        ------
        OSError : it cannot be read
        Cancelled : through the progress
        """
        stamp = stamp_of(path)
        if known := self.known(stamp):
            return known, stamp
        digest = _sample(path, stamp[3], progress) if stamp[3] > LARGE else _whole(path, stamp[3], progress)
        if stamp_of(path) == stamp and time.time_ns() - stamp[4] > YOUNG * 1e9:
            with self._lock:
                self._known[stamp[1:]] = digest
        return digest, stamp

    def known(self, stamp: Stamp) -> str:
        """The remembered digest, or ""."""
        with self._lock:
            return self._known.get(stamp[1:], "")


DIGESTS = Digests()


def stamp_of(path: Path) -> Stamp:
    """What changes when a file does."""
    found = path.stat()
    return str(path), found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def locate(path: PurePath | str, folder: Path | None) -> Path:
    """Where a saved path leads; existence is not asked.

    Raises
    ------
    FileNotFoundError : "package:..." of a package that is not installed
    """
    text = PurePath(path).as_posix()
    if text.startswith(PACKAGE):
        return _in_package(text)
    place = Path(text).expanduser()
    return Path(os.path.normpath((folder or Path.cwd()) / place))


def _in_package(text: str) -> Path:
    package, _, inside = text.removeprefix(PACKAGE).partition("/")
    try:
        spec = importlib.util.find_spec(package) if package.isidentifier() else None
    except (ImportError, ValueError):
        spec = None
    if spec is None or not spec.submodule_search_locations:
        raise FileNotFoundError(f"{text!r} lies in the package {package!r}, which is not installed: install it")
    root = Path(next(iter(spec.submodule_search_locations)))
    place = Path(os.path.normpath(root / inside))
    if not place.is_relative_to(root):
        raise FileNotFoundError(f"{text!r} leads out of the package {package!r}")
    return place


def saved(path: PurePath | str, before: Path | None, folder: Path | None) -> tuple[str, bool]:
    """A path as it is written in a file of `folder`, and whether it leads out of it (then it is absolute).

    Parameters
    ----------
    before : where relative paths start now
    """
    text = PurePath(path).as_posix()
    if text in ("", ".") or text.startswith(PACKAGE) or folder is None:
        return text, False
    place = locate(text, before)
    root = Path(os.path.abspath(folder))
    if place.is_relative_to(root):
        return place.relative_to(root).as_posix(), False
    return place.as_posix(), True


def unset(path: PurePath) -> bool:
    """Whether no file was chosen."""
    return path.as_posix() in ("", ".")


def named(network: Network, catalogue: Catalogue) -> list[tuple[str, str, Path]]:
    """(node, parameter, path as given) of all files that the network names; what it would read."""
    found: list[tuple[str, str, Path]] = []
    for name, node in sorted(network.nodes.items()):
        record = catalogue.get(node.module)
        for parameter in record.parameters if record else ():
            found += [(name, parameter.name, path) for path in _given(node.parameters, parameter)]
    return found


def _given(values: Mapping[str, Any], parameter: Parameter) -> list[Path]:
    if not parameter.is_path:
        return []
    value = values.get(parameter.name, parameter.default)
    return [] if value is None else [Path(value)]


def identities(
    network: Network,
    catalogue: Catalogue,
    progress: Callable[[str], Progress] | None = None,
    *,
    only: frozenset[str] | None = None,
    quick: bool = False,
) -> dict[tuple[str, str], Identity] | None:
    """Digest the files that a network names. This reads them: it is not pure, and may take long.

    Parameters
    ----------
    progress : node -> where to report and to be cancelled
    only : nodes that are asked for; all by default
    quick : read nothing; None if a digest is not remembered

    Raises
    ------
    Cancelled : through the progress
    """
    found: dict[tuple[str, str], Identity] = {}
    for name, node in network.nodes.items():
        record = catalogue.get(node.module)
        if record is None or (only is not None and name not in only):
            continue
        for parameter in record.parameters:
            for path in _given(node.parameters, parameter):
                one = identify(path, network.folder, record, progress(name) if progress else None, quick=quick)
                if one is None:
                    return None
                found[name, parameter.name] = one
    return found


def identify(
    path: Path, folder: Path | None, record: Module | None = None, progress: Progress | None = None, *, quick: bool = False
) -> Identity | None:
    """The identity of one path, with the companions that its reader names; None if `quick` and not remembered."""
    if unset(path):
        return Identity(problem="no file is chosen: set it")
    try:
        place = locate(path, folder)
        files, kind = _files(place)
        if kind == "file" and record is not None and record.companions is not None:
            files += [Path(c) for c in sorted(map(str, record.companions(place))) if Path(c).is_file()]
        stamps = [stamp_of(file) for file in files]
        if quick and not all(map(DIGESTS.known, stamps)):
            return None
        return _digested(files, kind, place, progress)
    except FileNotFoundError as error:
        return Identity(problem=_missing(path, folder, error))
    except Cancelled:
        raise
    except Exception as error:  # a reader's companions() may raise anything
        return Identity(problem=f"{path.as_posix()!r} cannot be read: {error}")


def _digested(files: Sequence[Path], kind: str, place: Path, progress: Progress | None) -> Identity:
    total = max(1, sum(f.stat().st_size for f in files))
    done, stamps, digests = 0, [], []
    for file in files:
        size = file.stat().st_size
        share = progress.part(done / total, min(1.0, (done + size) / total)) if progress else None
        digest, stamp = DIGESTS.of(file, share)
        done += size
        digests.append(digest)
        stamps.append(stamp)
    if kind == "file":
        content: tuple[Any, ...] = ("file", digests[0], place.suffix.lower())
        names = [os.path.relpath(f, place.parent).replace(os.sep, "/") for f in files[1:]]
        content += (tuple(zip(_without_stem(names, place), digests[1:], strict=True)),)
    else:
        root = place if kind == "folder" else _root(place)
        content = (kind, tuple((f.relative_to(root).as_posix(), d) for f, d in zip(files, digests, strict=True)))
    return Identity(content, tuple(stamps), any(d.startswith("sample") for d in digests))


def _without_stem(names: Sequence[str], place: Path) -> list[str]:
    """Companions' names with the file's own stem as '*': a renamed pair is the same data."""
    return [n.replace(place.stem, "*", 1) if n.startswith(place.stem) else n for n in names]


def _files(place: Path) -> tuple[list[Path], str]:
    if place.is_file():
        return [place], "file"
    if place.is_dir():
        found = sorted((p for p in place.rglob("*") if p.is_file()), key=lambda p: p.relative_to(place).as_posix())
        return found, "folder"
    if any(c in str(place) for c in "*?["):
        root = _root(place)
        found = [p for p in root.glob(place.relative_to(root).as_posix()) if p.is_file()]
        if found:
            return sorted(found, key=lambda p: p.relative_to(root).as_posix()), "pattern"
        raise FileNotFoundError(f"no file fits {place}")
    raise FileNotFoundError(str(place))


def _root(pattern: Path) -> Path:
    parts = pattern.parts
    fixed = next((i for i, part in enumerate(parts) if any(c in part for c in "*?[")), len(parts))
    return Path(*parts[:fixed])


def _missing(path: Path, folder: Path | None, error: FileNotFoundError) -> str:
    text = path.as_posix()
    if text.startswith(PACKAGE) and "installed" in str(error):
        return str(error)
    try:
        place = locate(path, folder)
    except FileNotFoundError as wrong:
        return str(wrong)
    where = place.parent
    while not where.is_dir() and where != where.parent:
        where = where.parent
    names = [p.name for p in where.iterdir()] if os.access(where, os.R_OK) else []
    if where != place.parent:
        gone = place.relative_to(where).parts[0]
        close = nearest(gone, names)
        return f"there is no folder {gone!r} in {str(where)!r}, named by {text!r}" + _did(close)
    return f"there is no file {text!r}" + (f" in {str(folder)!r}" if folder else "") + _did(nearest(place.name, names))


def _did(close: str) -> str:
    return f"; the nearest is {close!r}" if close else "; set another path"


def _whole(path: Path, size: int, progress: Progress | None) -> str:
    total, done = sha256(), 0
    with path.open("rb") as file:
        while block := file.read(4 * MIB):
            total.update(block)
            done += len(block)
            if progress:
                progress(done / max(size, 1))
    return total.hexdigest()


def _sample(path: Path, size: int, progress: Progress | None) -> str:
    total = sha256(str(size).encode())
    with path.open("rb") as file:
        for i in range(64):
            file.seek((size - MIB) * i // 63)
            total.update(file.read(MIB))
            if progress:
                progress((i + 1) / 64)
    return f"sample-{total.hexdigest()}"
