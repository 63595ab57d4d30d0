"""Which way imports run, how long files get, what is documented: read from the syntax trees."""

import ast
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("readers", "modellers", "mappers", "accuracy_mappers", "renderers")
WINDOWS = ("PySide6", "PyQt5", "PyQt6", "qtpy", "pyvistaqt")
DRAWING = ("pyvista", "vtk", "vtkmodules")
HEAVY = (*WINDOWS, *DRAWING, "numba", "matplotlib")

LONGEST_FILE, LONGEST_FUNCTION, LONGEST_KERNEL = 450, 50, 90


class Import(NamedTuple):
    name: str
    line: int
    top: bool


def imports(source: str, module: str, package: bool = False) -> Iterator[Import]:
    """Every import of a file, wherever it stands; `top` if it runs when the file is loaded."""

    def walk(node: ast.AST, top: bool) -> Iterator[Import]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                yield from (Import(alias.name, child.lineno, top) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                base = child.module or ""
                if child.level:
                    parts = module.split(".") if package else module.split(".")[:-1]
                    base = ".".join([*parts[: len(parts) - child.level + 1], *([base] if base else [])])
                # `from modules import kernels` imports modules.kernels
                yield from (Import(f"{base}.{alias.name}", child.lineno, top) for alias in child.names)
            else:
                inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
                yield from walk(child, top and not inside)

    yield from walk(ast.parse(source), True)


def below(name: str, *packages: str) -> bool:
    """Whether a name lies in one of some packages."""
    return any(name == p or name.startswith(f"{p}.") for p in packages)


def layer(module: str) -> str:
    """The layer a file of `modules` belongs to."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "modules"


LAYERS: dict[str, tuple[str, ...]] = {
    "kernels": ("modules.kernels",),
    "data": ("modules.kernels", "modules.data"),
    "parameters": ("modules.kernels", "modules.data"),
    "progress": ("modules.kernels", "modules.data"),
    "records": ("modules.kernels", "modules.data", "modules.parameters", "modules.progress"),
    "declare": ("modules.kernels", "modules.data", "modules.parameters", "modules.progress", "modules.records"),
    "api": (
        "modules.kernels", "modules.data", "modules.parameters", "modules.progress", "modules.records", "modules.declare",
    ),
    **{room: ("modules.kernels", "modules.data", "modules.api", f"modules.{room}") for room in ROOMS},
    "modules": (),
}  # fmt: skip
"""A layer, and what of `modules` it may import."""

ENGINE = ("app.engine", "modules.data", "modules.records", "modules.declare", "modules.progress", "modules.parameters")


def violations(module: str, source: str, package: bool = False) -> list[str]:
    """What a file imports that it may not."""
    found = []
    for one in imports(source, module, package):
        if why := refused(module, one):
            found.append(f"{module}:{one.line} imports {one.name}: {why}")
    return found


def refused(module: str, one: Import) -> str:
    """Why an import may not be; "" if it may."""
    if below(one.name, *WINDOWS) and not below(module, "app.gui"):
        return "windows live in app/gui"
    if below(module, "modules"):
        return _in_modules(module, one)
    if below(module, "app.engine"):
        return _in_engine(one)
    if below(one.name, *DRAWING, "numba", "matplotlib") and one.top and below(module, "app.cli", "app.commands", "app.paths"):
        return "the command line starts fast: import it where it is needed"
    if below(one.name, *(f"modules.{room}" for room in ROOMS)):
        return "the application knows modules through the catalogue"
    if below(one.name, "app.gui") and not below(module, "app.gui"):
        return "nothing hangs on the window"
    return ""


def _in_modules(module: str, one: Import) -> str:
    if below(one.name, "app"):
        return "modules know nothing of the application"
    if below(one.name, *DRAWING) and one.top:
        return "import it inside the function that needs it"
    if below(one.name, "numba") and layer(module) != "kernels":
        return "only kernels are compiled"
    if below(one.name, *DRAWING, "matplotlib", "networkx") and layer(module) == "kernels":
        return "a kernel knows numpy, scipy and numba"
    if below(one.name, "modules") and not below(one.name, *LAYERS[layer(module)]):
        return f"{layer(module)} may import {', '.join(LAYERS[layer(module)]) or 'nothing of modules'}"
    return ""


def _in_engine(one: Import) -> str:
    if below(one.name, *HEAVY):
        return "the engine computes without window, drawing or compiler"
    if below(one.name, "app", "modules") and not below(one.name, *ENGINE):
        return f"the engine knows {', '.join(ENGINE)} and no room"
    return ""


def sources() -> list[tuple[str, Path, bool]]:
    """(module name, path, whether it is a package) of every file of the program."""
    found = []
    for top in ("app", "modules"):
        for path in sorted((ROOT / top).rglob("*.py")):
            if "_data" in path.parts:
                continue
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            package = path.name == "__init__.py"
            found.append((name.removesuffix(".__init__") if package else name, path, package))
    return found


SOURCES = sources()


def test_imports_run_one_way() -> None:
    found = [v for module, path, package in SOURCES for v in violations(module, path.read_text("utf-8"), package)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("modules.kernels.new", "from modules.data.wires import Samples"),
        ("modules.kernels.new", "import pyvista"),
        ("modules.data.new", "from modules.declare import record_of"),
        ("modules.data.new", "def f():\n    from modules import api"),
        ("modules.parameters", "import modules.api"),
        ("modules.mappers.new", "from modules.modellers.interpolate import interpolate"),
        ("modules.mappers.new", "from ..modellers import interpolate"),
        ("modules.mappers.new", "import numba"),
        ("modules.mappers.new", "import pyvista as pv"),
        ("modules.mappers.new", "class A:\n    import vtkmodules.vtkCommonCore"),
        ("modules.mappers.new", "def f():\n    from app.engine import document"),
        ("modules.renderers.new", "def f():\n    from PySide6.QtCore import QObject"),
        ("app.engine.new", "from modules.mappers.contour import contour"),
        ("app.engine.new", "from modules import mappers"),
        ("app.engine.new", "from modules import kernels"),
        ("app.engine.new", "def f():\n    import pyvista"),
        ("app.engine.new", "from app import paths"),
        ("app.commands.new", "import pyvista"),
        ("app.commands.new", "def f():\n    from PySide6 import QtCore"),
        ("app.commands.new", "from modules.readers import elevation"),
        ("app.picture", "def f():\n    from app.gui import window"),
    ],
)
def test_a_planted_violation_is_found(module: str, source: str) -> None:
    assert violations(module, source)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("modules.mappers.new", "from modules.api import Model\nfrom modules import kernels\ndef f():\n    import pyvista"),
        ("modules.readers.new", "from modules.readers import _files"),
        ("modules.kernels.new", "from modules.kernels._jit import jit\nimport numba"),
        ("app.engine.new", "from app.engine.errors import hint\nfrom modules.data.accuracy import Accuracy"),
        ("app.commands.new", "def f():\n    import pyvista"),
        ("app.gui.window", "from PySide6 import QtCore"),
    ],
)
def test_what_is_right_is_let_pass(module: str, source: str) -> None:
    assert not violations(module, source)


def functions(tree: ast.AST) -> Iterator[tuple[str, int, int]]:
    """(name, line, lines without the docstring) of every function."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            words = ast.get_docstring(node, clean=False)
            first, last = node.body[0], node.end_lineno or node.lineno
            docs = (first.end_lineno or 0) - first.lineno + 1 if words is not None else 0
            yield node.name, node.lineno, last - node.lineno + 1 - docs


def test_files_and_functions_are_short_enough_to_read() -> None:
    found = []
    for module, path, _ in SOURCES:
        text = path.read_text("utf-8")
        if (n := text.count("\n")) > LONGEST_FILE:
            found.append(f"{module} has {n} lines: is there a second file inside?")
        longest = LONGEST_KERNEL if below(module, "modules.kernels") else LONGEST_FUNCTION
        found += [f"{module}:{line} {name} has {n} lines" for name, line, n in functions(ast.parse(text)) if n > longest]
    assert not found, "\n".join(found)


def undocumented(tree: ast.Module) -> Iterator[str]:
    """Public classes, functions and methods of a file without a docstring."""
    for node in tree.body:
        if not isinstance(node, ast.ClassDef | ast.FunctionDef) or node.name.startswith("_"):
            continue
        if ast.get_docstring(node) is None:
            yield node.name
        if isinstance(node, ast.ClassDef) and not any(_says_more(base) for base in node.bases):
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef) and not _is_silent(inner) and ast.get_docstring(inner) is None:
                    yield f"{node.name}.{inner.name}"


def _is_silent(method: ast.FunctionDef) -> bool:
    """Whether a method needs no words: private, or the setter of a documented property."""
    setter = any(isinstance(d, ast.Attribute) and d.attr == "setter" for d in method.decorator_list)
    return setter or method.name.startswith("_")


def _says_more(base: ast.expr) -> bool:
    """Whether a base class documents what its children override."""
    return not isinstance(base, ast.Name) or base.id not in ("object", "Protocol")


def test_every_file_and_every_public_door_is_documented() -> None:
    found = []
    for module, path, _ in SOURCES:
        tree = ast.parse(path.read_text("utf-8"))
        if ast.get_docstring(tree) is None:
            found.append(f"{module} has no docstring")
        found += [f"{module}: {name} has no docstring" for name in undocumented(tree)]
    assert not found, "\n".join(found)


def test_an_undocumented_door_is_found() -> None:
    planted = "def f():\n    pass\nclass A:\n    'x'\n    def g(self):\n        pass\n    def _h(self):\n        pass"
    assert list(undocumented(ast.parse(planted))) == ["f", "A.g"]


def tracked() -> list[Path]:
    """The files of the project."""
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("what is tracked is known in a checkout with git")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
    return [ROOT / name.decode() for name in listed.split(b"\0") if name and (ROOT / name.decode()).is_file()]


OTHERWHERE = re.compile("|".join([
    r"/(?:home|root|Users)/[\w.-]", "index" + "-url", r"py" + r"pi\.org", "python" + "hosted", r"C:\\+Users",
]))  # fmt: skip


def test_no_file_names_a_home_folder_or_a_registry() -> None:
    found = []
    for path in tracked():
        try:
            text = path.read_text("utf-8")
        except UnicodeDecodeError:
            continue
        found += [f"{path.relative_to(ROOT)}: {m[0]}" for m in OTHERWHERE.finditer(text) if path != Path(__file__).resolve()]
    assert not found, "\n".join(found)


def test_tests_are_no_package() -> None:
    assert not list((ROOT / "tests").rglob("__init__.py")), "tests/modules would become the package 'modules'"
