"""The one door to numba: how kernels are compiled, and where the compiled code is kept.

Kernels are compiled at first call, never at import. Each kernel file has a folder of its own in the cache, named by a
digest of the file and of the kernel files it imports: numba itself does not notice that a function called from another
file has changed. Importing this file does not import numba; decorating a function does.
"""

import ast
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

    folder = None if "no_cpython_wrapper" in options else _folder(function.__module__.rpartition(".")[2])
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
    name = f"kernels-{_machine()}"
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
        _forget_old(parent, "kernels-*", keep=folder)
        _forget_old(folder, "*-*", keep=folder)
        return folder
    return None


@functools.cache
def _folder(name: str) -> Path | None:
    """Where the compiled code of one kernel file is kept, made if need be."""
    cache = cache_folder()
    if cache is None:
        return None
    folder = cache / f"{name}-{_digest(name)}"
    folder.mkdir(exist_ok=True, mode=0o700)
    os.utime(folder)
    return folder


def is_warm(name: str = "") -> bool:
    """Whether all kernels of these sources, or those of one file, have been compiled and kept: none waits for the compiler."""
    cache = cache_folder()
    return cache is not None and all(_marker(cache, each).exists() for each in ([name] if name else _names()))


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
    names = _names()
    left, wanted = list(names), [] if asked is None else asked
    while left:
        name = next((each for each in wanted if each in left), left[0])
        left.remove(name)
        progress(1.0 - (len(left) + 1) / len(names), name)
        if is_warm(name):
            continue
        warm_file = getattr(import_module(f"{__package__}.{name}"), "warm", None)
        if warm_file is not None:
            warm_file()
        folder = _folder(name)
        if folder is not None:
            (folder / _MARKER).touch()
    progress(1.0, "")


def _marker(cache: Path, name: str) -> Path:
    return cache / f"{name}-{_digest(name)}" / _MARKER


def _names() -> list[str]:
    """The kernel files, in the order of their names."""
    return sorted(path.stem for path in Path(__file__).parent.glob("*.py") if not path.stem.startswith("_"))


@functools.cache
def _machine() -> str:
    """A name for what all machine code depends on: numba, interpreter, kind of processor, and how kernels are compiled."""
    depends = f"{version('numba')} {version('llvmlite')} {sys.version} {platform.machine()}"
    return hashlib.blake2b(depends.encode() + _source("_jit"), digest_size=10).hexdigest()


@functools.cache
def _digest(name: str) -> str:
    """A name for the source of a kernel file and of all kernel files that it imports."""
    digest = hashlib.blake2b(digest_size=10)
    for each in sorted(_reached(name)):
        digest.update(each.encode() + b"\0" + _source(each) + b"\0")
    return digest.hexdigest()


def _reached(name: str) -> set[str]:
    """The kernel file, and those it imports, and those they import, and so on."""
    found, left = set(), [name]
    while left:
        each = left.pop()
        if each not in found:
            found.add(each)
            left += _imported(each)
    return found


def _imported(name: str) -> set[str]:
    """The kernel files that a kernel file imports by its own statements."""
    found = set()
    for statement in ast.walk(ast.parse(_source(name))):
        if isinstance(statement, ast.ImportFrom) and statement.module == __package__:
            found |= {each.name for each in statement.names}
        elif isinstance(statement, ast.ImportFrom) and (statement.module or "").startswith(f"{__package__}."):
            found.add((statement.module or "").rpartition(".")[2])
    return found - {"_jit"}


def _source(name: str) -> bytes:
    return (Path(__file__).parent / f"{name}.py").read_bytes()


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


def _forget_old(parent: Path, pattern: str, keep: Path) -> None:
    """Remove the folders of earlier sources that nobody has used for `KEEP_DAYS` days; a failure is of no interest."""
    oldest = time.time() - KEEP_DAYS * 86400
    try:
        old = [path for path in parent.glob(pattern) if path != keep and path.stat().st_mtime < oldest]
    except OSError:
        return
    for path in old:
        shutil.rmtree(path, ignore_errors=True)
