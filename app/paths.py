"""Where the program's own files lie: beside `app` in a checkout, in `app/_data` when installed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Literal

HERE = Path(__file__).resolve().parent

PACKAGES = ("numpy", "scipy", "numba", "networkx", "matplotlib", "pillow", "vtk", "pyvista")
"""What the numbers and pixels of a picture depend on."""


def data(kind: Literal["networks", "resources"]) -> Path:
    """The folder of the packaged networks or of the resources.

    Raises
    ------
    FileNotFoundError : neither a checkout nor an installed wheel holds it
    """
    for place in (HERE / "_data" / kind, HERE.parent / kind):
        if place.is_dir():
            return place
    raise FileNotFoundError(f"the folder {kind!r} is neither in {HERE / '_data'} nor beside {HERE}: install the program again")


def networks() -> Mapping[str, Path]:
    """The packaged networks by bare name, in order."""
    try:
        return {path.stem: path for path in sorted(data("networks").glob("*.json"))}
    except FileNotFoundError:
        return {}


def checkout() -> Path | None:
    """The root of the checkout this runs from; None when installed."""
    root = HERE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "tests").is_dir() else None


def intruder() -> str:
    """The folder of a foreign package `modules` that is in the way; "" if ours lies beside `app`."""
    import importlib.util

    found = importlib.util.find_spec("modules")
    places = [] if found is None else [Path(p).resolve() for p in found.submodule_search_locations or ()]
    if HERE.parent / "modules" in places[:1]:
        return ""
    return str(places[0]) if places else "nowhere"


def versions() -> dict[str, str]:
    """Name -> version of this program, Python and `PACKAGES`, without importing any."""
    import platform

    from app import __version__

    found = {"nonius-explorer": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
