"""Kernels: arrays in, arrays out; numpy and numba, no house types, no knowledge of modules.

A kernel file is loaded at its first use, so that importing a room that uses kernels does not import numba::

    from modules import kernels
    lines = kernels.contour.lines(values, x, y, level, shoulder=True)
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from modules.kernels import arcs as arcs
    from modules.kernels import bands as bands
    from modules.kernels import bilinear as bilinear
    from modules.kernels import cell_types as cell_types
    from modules.kernels import contour as contour
    from modules.kernels import crossings as crossings
    from modules.kernels import interpolation as interpolation
    from modules.kernels import operators as operators
    from modules.kernels import refine as refine
    from modules.kernels import solid as solid
    from modules.kernels import triangles as triangles
    from modules.kernels import trilinear as trilinear


before_loading: list[Callable[[str], None]] = []
"""Called with the name of a kernel file before it is loaded. A window waits here until a child has compiled it: the compiler
would hold the interpreter, and the window with it."""


def __getattr__(name: str) -> ModuleType:
    """The kernel file `name`, loaded now if it was not yet.

    Raises
    ------
    AttributeError
        If there is no kernel file of that name.
    """
    full = f"{__name__}.{name}"
    if not name.startswith("_"):
        for wait in before_loading:
            wait(name)
        try:
            return import_module(full)
        except ModuleNotFoundError as error:
            if error.name != full:
                raise
    raise AttributeError(f"there is no kernel file {name!r} in {__name__}")
