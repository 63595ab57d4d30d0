"""The one door to numba: how kernels are compiled, and where the compiled code is kept.

Kernels are compiled at first call, never at import, and cached in a folder named by a digest of *all* kernel sources:
numba itself does not notice that a function called from another file has changed. Importing this file does not
import numba; decorating a function does.
"""

import functools
import hashlib
import os
import platform
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

KEEP_DAYS = 30
_MARKER = ".warm"
_PART: dict[str, Any] = {"no_cpython_wrapper": True}
"""Of kernels that only other kernels call: they are kept within those, and cannot be called from Python."""
_decorating = threading.Lock()


def jit(function: Function) -> Function:
    """Compile `function` at its first call, without the interpreter lock, and keep the machine code for other runs.

    Never `parallel=True`: slabs of work are shared out by the caller, who can also stop them.
    """
    return _compiled(function)


def inlined(function: Function) -> Function:
    """As `jit`, for a part of an inner loop: it becomes part of each kernel that calls it."""
    return _compiled(function, forceinline=True)


def lean(function: Function) -> Function:
    """As `jit`, for an inner loop that allocates nothing: its arrays are not counted, so that passing one costs nothing."""
    return _compiled(function, _nrt=False)


def lean_part(function: Function) -> Function:
    """As `lean`, for a part that only other kernels call: it compiles faster."""
    return _compiled(function, _nrt=False, **_PART)


def lean_inlined(function: Function) -> Function:
    """As `inlined`, for a part of a `lean` one."""
    return _compiled(function, forceinline=True, _nrt=False, **_PART)


def vectorized(function: Function) -> Function:
    """As `inlined`, for arithmetic in a loop over many cells: a division by zero gives inf or nan, as in numpy.

    Without the test that it else needs, and without branches, the loop runs on whole vector registers.
    """
    return _compiled(function, forceinline=True, error_model="numpy", _nrt=False, **_PART)


def _compiled(function: Function, **options: Any) -> Function:
    import numba

    folder = None if "no_cpython_wrapper" in options else cache_folder()
    if folder is None:
        compiled: Function = numba.njit(nogil=True, no_cfunc_wrapper=True, **options)(function)
        return compiled
    with _decorating:  # numba reads the folder while it decorates; other users of numba keep their own
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder)
        try:
            compiled = numba.njit(nogil=True, no_cfunc_wrapper=True, cache=True, **options)(function)
        finally:
            numba.config.CACHE_DIR = before
    return compiled


@functools.cache
def cache_folder() -> Path | None:
    """The folder of the compiled kernels, made if need be; None if no folder can be written.

    `NONIUS_CACHE` names another parent than the user's cache folder.
    """
    name = f"kernels-{_digest()}"
    for parent in (_user_cache(), Path(tempfile.gettempdir()) / f"nonius-{_user()}"):
        folder = parent / name
        try:
            parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            folder.mkdir(exist_ok=True, mode=0o700)
            with tempfile.TemporaryFile(dir=folder):
                pass
            os.utime(folder)
            if not (_is_ours(parent) and _is_ours(folder)):
                continue
        except OSError:
            continue
        _forget_old(parent, keep=folder)
        return folder
    return None


def is_warm(name: str = "") -> bool:
    """Whether all kernels of these sources, or those of one file, have been compiled and kept: none waits for the compiler."""
    folder = cache_folder()
    return folder is not None and any((folder / f"{each}{_MARKER}").exists() for each in ("", name))


def warm(progress: Callable[[float, str], None] = lambda fraction, name: None, asked: list[str] | None = None) -> None:
    """Compile every kernel by calling it on tiny data.

    Each kernel file that compiles something has a function `warm()` which does so for that file.

    Parameters
    ----------
    progress
        Called with the fraction done and the name of the file that comes next; what it raises ends the work.
    asked
        Names of files that are to come first; more may be put in while the work goes on.
    """
    names = sorted(path.stem for path in _sources() if not path.stem.startswith("_"))
    left, wanted = list(names), [] if asked is None else asked
    while left:
        name = next((each for each in wanted if each in left), left[0])
        left.remove(name)
        progress(1.0 - (len(left) + 1) / len(names), name)
        warm_file = getattr(import_module(f"{__package__}.{name}"), "warm", None)
        if warm_file is not None:
            warm_file()
        _mark(name)
    progress(1.0, "")
    _mark("")


def _mark(name: str) -> None:
    folder = cache_folder()
    if folder is not None:
        (folder / f"{name}{_MARKER}").touch()


def _sources() -> list[Path]:
    return sorted(Path(__file__).parent.glob("*.py"))


@functools.cache
def _digest() -> str:
    """A name for all that the machine code depends on: sources, numba, interpreter, kind of processor."""
    digest = hashlib.blake2b(digest_size=10)
    for path in _sources():
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    digest.update(f"{version('numba')} {version('llvmlite')} {sys.version} {platform.machine()}".encode())
    return digest.hexdigest()


def _user_cache() -> Path:
    if chosen := os.environ.get("NONIUS_CACHE"):
        return Path(chosen)
    if sys.platform == "win32":
        home = os.environ.get("LOCALAPPDATA") or os.path.expanduser("~")
        return Path(home) / "nonius" / "cache"
    if sys.platform == "darwin":
        return Path(os.path.expanduser("~/Library/Caches/nonius"))
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "nonius"


def _is_ours(folder: Path) -> bool:
    """Whether the folder belongs to this user: what lies in it will be run."""
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")


def _forget_old(parent: Path, keep: Path) -> None:
    """Remove the folders of earlier sources that nobody has used for `KEEP_DAYS` days; a failure is of no interest."""
    oldest = time.time() - KEEP_DAYS * 86400
    try:
        old = [path for path in parent.glob("kernels-*") if path != keep and path.stat().st_mtime < oldest]
    except OSError:
        return
    for path in old:
        shutil.rmtree(path, ignore_errors=True)
