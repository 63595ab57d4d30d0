"""The user's own modules: each file of one folder is `nonius_user.<stem>`, helpers come by relative import.

The folder is not put on sys.path, and no compiled files are used: a file that was changed and kept its size and second
would else run as it was.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import linecache
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

PACKAGE = "nonius_user"


def default() -> Path:
    """`$NONIUS_MODULES`, or `nonius/modules` in the platform's folder for a user's data."""
    if named := os.environ.get("NONIUS_MODULES"):
        return Path(named).expanduser()
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA", Path.home() / "AppData" / "Roaming"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return base / "nonius" / "modules"


def open_folder(folder: Path, code: str) -> list[tuple[str, Path]]:
    """Make the folder importable and return (name, path) of its files; what was loaded of other code is dropped."""
    package = sys.modules.get(PACKAGE)
    if package is None or getattr(package, "_code", None) != code or list(package.__path__) != [str(folder)]:
        for name in [n for n in sys.modules if n == PACKAGE or n.startswith(f"{PACKAGE}.")]:
            del sys.modules[name]
        package = ModuleType(PACKAGE, "The user's own modules.")
        package.__path__ = [str(folder)]
        vars(package)["_code"] = code
        sys.modules[PACKAGE] = package
        linecache.checkcache()
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
    paths = sorted(folder.glob("*.py")) if folder.is_dir() else []
    return [(f"{PACKAGE}.{path.stem}", path) for path in paths if not path.name.startswith("_")]


class _Loader(importlib.machinery.SourceFileLoader):
    """Compiles from the text each time."""

    def get_code(self, fullname: str) -> CodeType | None:
        path = self.get_filename(fullname)
        code: CodeType = self.source_to_code(self.get_data(path), path)
        return code


class _Finder:
    """Finds the files of the user's package; the import system registers each before it runs."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if not name.startswith(f"{PACKAGE}.") or not path:
            return None
        place = Path(path[0]) / name.rsplit(".", 1)[-1]
        for file, inside in ((place.with_name(place.name + ".py"), None), (place / "__init__.py", [str(place)])):
            if file.is_file():
                loader = _Loader(name, str(file))
                return importlib.util.spec_from_file_location(name, file, loader=loader, submodule_search_locations=inside)
        return None
