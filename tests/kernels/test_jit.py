"""Kernels load at first use, and what was compiled is kept in a folder of its own that no other sources share."""

import ast
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from modules.kernels import _jit

ROOT = Path(__file__).parents[2]


def run(code: str, **environment: str) -> str:
    """What a fresh interpreter prints."""
    return subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env={**os.environ, **environment}, check=True, text=True, capture_output=True
    ).stdout.strip()


def test_numba_is_imported_at_first_use_and_not_before() -> None:
    code = """
import sys
from modules import kernels
from modules.kernels import _jit
_jit.is_warm()
print("numba" in sys.modules, end=" ")
kernels.arcs
print("numba" in sys.modules)
"""
    assert run(code) == "False True"


def test_a_name_that_is_no_kernel_file_is_an_attribute_error() -> None:
    from modules import kernels

    with pytest.raises(AttributeError, match="no kernel file 'marching_squares'"):
        _ = kernels.marching_squares
    assert not hasattr(kernels, "__wrapped__")


def test_other_users_of_numba_keep_their_cache_folder(tmp_path: Path) -> None:
    code = """
import numba
numba.config.CACHE_DIR = "elsewhere"
from modules import kernels
kernels.arcs.shoulder_share(1.0)
print(numba.config.CACHE_DIR)
"""
    assert run(code, NONIUS_CACHE=str(tmp_path)) == "elsewhere"
    (folder,) = tmp_path.iterdir()
    assert list(folder.rglob("arcs.shoulder_share*.nbi"))


@pytest.mark.timeout(900)  # every kernel, from nothing
def test_warming_compiles_every_kernel_and_is_remembered(tmp_path: Path) -> None:
    code = """
import gc, sys
from modules.kernels import _jit
heard = []
assert not _jit.is_warm()
_jit.warm(lambda fraction, name: heard.append((fraction, name)))
assert _jit.is_warm()
assert heard == sorted(heard, key=lambda each: each[0]) and heard[0][0] == 0 and heard[-1] == (1.0, "")
from numba.core.dispatcher import Dispatcher
ours = [f for f in gc.get_objects() if isinstance(f, Dispatcher) and f.__module__.startswith("modules.kernels")]
print(sorted(f"{f.__module__}.{f.__name__}" for f in ours if not f.signatures), len(ours) > 10)
"""
    assert run(code, NONIUS_CACHE=str(tmp_path)) == "[] True"
    assert run("from modules.kernels import _jit; print(_jit.is_warm())", NONIUS_CACHE=str(tmp_path)) == "True"


def test_an_interrupted_warming_is_not_warm(tmp_path: Path) -> None:
    code = """
from modules.kernels import _jit
def stop(fraction, name):
    raise KeyboardInterrupt
try:
    _jit.warm(stop)
except KeyboardInterrupt:
    print(_jit.is_warm())
"""
    assert run(code, NONIUS_CACHE=str(tmp_path)) == "False"


def test_without_a_writable_folder_kernels_still_run() -> None:
    code = """
import tempfile
tempfile.tempdir = "/dev/null/none"
from modules import kernels
from modules.kernels import _jit
print(_jit.cache_folder(), kernels.arcs.shoulder_share(0.0), _jit.is_warm())
"""
    assert run(code, NONIUS_CACHE="/dev/null/none") == "None 0.5 False"


def test_the_temporary_folder_is_second_choice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NONIUS_CACHE", "/dev/null/none")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = _jit.cache_folder.__wrapped__()
    assert folder is not None and tmp_path in folder.parents
    monkeypatch.setattr(_jit, "_is_ours", lambda folder: False)  # made by somebody else: its code is not run
    assert _jit.cache_folder.__wrapped__() is None


def test_folders_of_old_sources_go_after_a_month(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NONIUS_CACHE", str(tmp_path))
    old, recent, foreign = tmp_path / "kernels-1", tmp_path / "kernels-2", tmp_path / "pictures"
    for folder, days in ((old, 31), (recent, 29), (foreign, 400)):
        folder.mkdir()
        (folder / "file").touch()
        os.utime(folder, (time.time() - 86400 * days,) * 2)
    kept = _jit.cache_folder.__wrapped__()
    assert set(tmp_path.iterdir()) == {kept, recent, foreign}


def test_a_change_renames_what_imports_the_file_and_nothing_else(tmp_path: Path) -> None:
    """The folders of kernels are named by their own source and by those they call, near or far."""
    code = """
import sys
from modules.kernels import _jit
_jit.__file__ = sys.argv[1]
print(*(_jit._digest(name) for name in ("bilinear", "crossings", "contour", "solid")))
"""
    for path in (ROOT / "modules" / "kernels").glob("*.py"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    words = [sys.executable, "-c", code, str(tmp_path / "_jit.py")]
    before = subprocess.run(words, cwd=ROOT, check=True, text=True, capture_output=True).stdout.split()
    with (tmp_path / "bilinear.py").open("a") as file:
        file.write("# changed\n")
    after = subprocess.run(words, cwd=ROOT, check=True, text=True, capture_output=True).stdout.split()
    assert [one == other for one, other in zip(before, after, strict=True)] == [False, False, False, True]


def test_kernel_files_import_each_other_by_statements_that_the_folders_names_see() -> None:
    for path in (ROOT / "modules" / "kernels").glob("*.py"):
        for statement in ast.walk(ast.parse(path.read_text())):
            if isinstance(statement, ast.Import):
                assert not any("kernels" in each.name for each in statement.names), path.name
            elif isinstance(statement, ast.ImportFrom):
                assert statement.level == 0, path.name
