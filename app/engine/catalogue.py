"""The modules there are: ours, those of installed packages, the user's own; and those that would not load, with why."""

from __future__ import annotations

import copy
import importlib
import importlib.metadata
import os
import pkgutil
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from app.engine import user_folder
from app.engine.errors import CatalogueError, UnknownName, hint
from modules.declare import ROOMS, DeclarationError, Module, record_of

GROUP = "nonius.modules"
"""Entry-point group of packages that bring modules."""


@dataclass(frozen=True)
class Broken:
    """A file or package that would not load."""

    where: str
    sentence: str
    traceback: str = ""


class Catalogue:
    """Modules by id. Reading is safe from any thread; `reload` swaps the tables at once.

    Attributes
    ----------
    broken : path, package or id -> why it did not load
    folder : the user's folder
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder
        self.broken: Mapping[str, Broken] = MappingProxyType({})
        self._modules: Mapping[str, Module] = MappingProxyType({})
        self._was: Mapping[str, str] = MappingProxyType({})
        self._functions: tuple[Callable[..., Any], ...] = ()
        self._rooms = False

    @classmethod
    def load(cls, folder: Path | None = None) -> Catalogue:
        """Everything installed, and the user's folder (`$NONIUS_MODULES` or the platform's, if none is given)."""
        catalogue = cls(user_folder.default() if folder is None else folder)
        catalogue._rooms = True
        catalogue.reload()
        return catalogue

    @classmethod
    def of(cls, functions: Iterable[Callable[..., Any]], folder: Path | None = None) -> Catalogue:
        """Of decorated functions, and the files of a folder.

        Raises
        ------
        CatalogueError : two functions of one id
        """
        catalogue = cls(folder)
        catalogue._functions = tuple(functions)
        catalogue.reload()
        for broken in catalogue.broken.values():
            if not broken.traceback:
                raise CatalogueError(broken.sentence)
        return catalogue

    # --- asking

    def __iter__(self) -> Iterator[Module]:
        return iter(self._modules.values())

    def __len__(self) -> int:
        return len(self._modules)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self.get(name) is not None

    def get(self, name: str) -> Module | None:
        """The module of that id or former id; None if there is none."""
        return self._modules.get(name) or self._modules.get(self._was.get(name, ""))

    def __getitem__(self, name: str) -> Module:
        record = self.get(name)
        if record is None:
            raise UnknownName(f"there is no module {name!r}{self.nearest(name)}")
        return record

    def find(self, name: str) -> Module:
        """The module of an id, a former id, or a part that only one has: "contour", "mappers.contour".

        Raises
        ------
        UnknownName : none, or several; the sentence names the nearest, or all
        """
        if record := self.get(name):
            return record
        for fits in (_is_function, _is_tail, _is_file, _is_part):
            found = [record for record in self if fits(record.id, name)]
            if len(found) == 1:
                return found[0]
            if found:
                ids = ", ".join(record.id for record in found)
                raise UnknownName(f"{name!r} may be any of {ids}: write the whole id")
        raise UnknownName(f"there is no module {name!r}{self.nearest(name)}")

    def nearest(self, name: str) -> str:
        """A hint that names the most similar module, or why it did not load."""
        for broken in self.broken.values():
            if name.split(".")[-2:-1] == [Path(broken.where).stem]:
                return f"; {broken.where} did not load: {broken.sentence}"
        tail = name.rsplit(".", 1)[-1]
        ids = {record.id.rsplit(".", 1)[-1]: record.id for record in self}
        if tail in ids:
            return f"; did you mean {ids[tail]!r}?"
        close = hint(name, [*self._modules, *ids], show=0)
        return close if close.startswith("; did") else "; `nonius modules` lists what there is"

    def room(self, name: str) -> tuple[Module, ...]:
        """The modules of a room, by title."""
        return tuple(sorted((r for r in self if r.room == name), key=lambda r: (r.title, r.id)))

    # --- loading

    def reload(self) -> tuple[str, ...]:
        """Read again what may have changed (the user's files), and return the ids of what is new, changed or gone."""
        table = _Table()
        for function in self._functions:
            table.add(record_of(function), "the functions given")
        if self._rooms:
            for room in ROOMS:
                table.package(f"modules.{room}")
            for entry in sorted(importlib.metadata.entry_points(group=GROUP), key=lambda e: e.name):
                table.entry(entry)
        if self.folder is not None:
            self._load_folder(table, self.folder)
        before, self._modules = self._modules, MappingProxyType(dict(sorted(table.modules.items())))
        self._was, self.broken = MappingProxyType(table.was), MappingProxyType(table.broken)
        ids = sorted({*before, *self._modules})
        return tuple(i for i in ids if _identity(before.get(i)) != _identity(self._modules.get(i)))

    def _load_folder(self, table: _Table, folder: Path) -> None:
        code = digest_of(folder)
        for name, path in user_folder.open_folder(folder, code):
            table.load(name, str(path), code)

    def snapshot(self) -> Catalogue:
        """The modules as they are now, whatever is reloaded later."""
        return copy.copy(self)

    def initializer(self) -> tuple[Callable[..., None], tuple[Any, ...]]:
        """What a child process calls first, so that it knows the same modules: `ProcessPoolExecutor(initializer=...)`."""
        return prepare, (list(sys.path), self._rooms, self._functions, self.folder)

    def by_name(self, name: str, digest: str) -> Module:
        """The module of that id and code."""
        found = self.get(name)
        if found is None or found.digest != digest:
            self.reload()
            found = self.get(name)
        if found is None or found.digest != digest:
            raise CatalogueError(f"the code of {name!r} differs between processes: its file changed while it ran; fire again")
        return found


class _Table:
    """What is being loaded."""

    def __init__(self) -> None:
        self.modules: dict[str, Module] = {}
        self.was: dict[str, str] = {}
        self.broken: dict[str, Broken] = {}

    def add(self, record: Module, where: str) -> None:
        if record.id in self.modules:
            self.refuse(record.id, where, f"there are two modules of the id {record.id!r}: rename a function or its file")
            return
        self.modules[record.id] = record
        for former in record.was:
            if former in self.was and self.was[former] != record.id:
                other = self.was[former]
                self.refuse(former, where, f"both {other!r} and {record.id!r} say that they were {former!r}: take one out")
            else:
                self.was[former] = record.id

    def refuse(self, key: str, where: str, sentence: str, trace: str = "") -> None:
        self.broken[key] = Broken(where, sentence, trace)

    def package(self, name: str, code: str = "") -> None:
        """A package and the files directly in it."""
        package = self.load(name, name, code)
        for info in pkgutil.iter_modules(getattr(package, "__path__", ())):
            if not info.name.startswith("_"):
                self.load(f"{name}.{info.name}", f"{name}.{info.name}", code)

    def entry(self, entry: importlib.metadata.EntryPoint) -> None:
        try:
            loaded = entry.load()
            place = loaded if isinstance(loaded, ModuleType) else sys.modules[loaded.__module__]
            file = Path(place.__file__ or "")
            code = digest_of(file.parent if hasattr(place, "__path__") else file)
        except (Exception, SystemExit) as error:
            self.refuse(entry.name, entry.value, _sentence(error), _trace(error))
            return
        self.package(place.__name__, code)

    def load(self, name: str, where: str, code: str) -> ModuleType | None:
        """Import a file and take its modules; what goes wrong is kept and stops nothing."""
        try:
            module = importlib.import_module(name)
        except (Exception, SystemExit) as error:
            sys.modules.pop(name, None)
            self.refuse(where, where, _sentence(error), _trace(error))
            return None
        for thing in vars(module).values():
            if getattr(thing, "__module__", "") == name and hasattr(thing, "__module_record__"):
                self.add(_with_code(thing, code), where)
        return module


def _with_code(function: Callable[..., Any], code: str) -> Module:
    record = record_of(function)
    if code and record.digest != code:
        record = replace(record, digest=code)
        vars(function)["__module_record__"] = record
    return record


_mine: Catalogue | None = None


def prepare(path: list[str], rooms: bool, functions: tuple[Callable[..., Any], ...], folder: Path | None) -> None:
    """Load the catalogue of a child process."""
    global _mine
    sys.path[:] = path
    _mine = Catalogue(folder)
    _mine._rooms, _mine._functions = rooms, functions
    _mine.reload()


def mine() -> Catalogue:
    """The catalogue of this process: what `prepare` loaded, or everything installed."""
    global _mine
    if _mine is None:
        _mine = Catalogue.load()
    return _mine


def digest_of(place: Path) -> str:
    """Digest of a file, or of all .py files below a folder with their relative names."""
    total = blake2b(digest_size=16)
    files = [place] if place.is_file() else sorted(place.rglob("*.py"))
    for path in files:
        name = path.relative_to(place).as_posix() if path != place else path.name
        try:
            content = path.read_bytes()
        except OSError:
            continue
        total.update(f"{name}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()


def _identity(record: Module | None) -> tuple[object, ...]:
    return () if record is None else (record.version, record.digest, record.title, record.ports, record.outputs)


def _is_function(module: str, name: str) -> bool:
    return module.rsplit(".", 1)[-1] == name


def _is_tail(module: str, name: str) -> bool:
    return module.endswith(f".{name}")


def _is_file(module: str, name: str) -> bool:
    return name in module.split(".")[-2:-1]


def _is_part(module: str, name: str) -> bool:
    return module.startswith(f"{name}.") or f".{name}." in module


def _sentence(error: BaseException) -> str:
    if isinstance(error, DeclarationError):
        return str(error)
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}: {error.msg}"
    return f"{type(error).__name__}: {error}".strip(": ")


def _trace(error: BaseException) -> str:
    return "".join(traceback.format_exception(error)).replace(os.getcwd() + os.sep, "")
