"""Files of many named arrays opened behind one door: NetCDF, HDF5, Zarr, and what is built on them."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.readers import _bathymetry
from modules.readers._files import ReadError, existing, memory, reading
from modules.readers._store import Cut, Store, Variable, attributes_of, text

NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")
HDF5 = (".h5", ".hdf5", ".he5", ".hdf", ".bag")
ZARR = (".zarr", ".zip")
SUFFIXES = (*NETCDF, *HDF5, ".zarr")

EXTRAS = {"h5py": "hdf5", "zarr": "zarr"}
"""Package -> the extra of this program that brings it."""

def there(path: Path | None) -> Path:
    """The path, if it is a file, or the folder of a Zarr store.

    Raises
    ------
    ReadError : it is neither
    """
    if path is not None and path.is_dir() and is_zarr(path):
        return path
    found = existing(path)
    return found.parent if found.name in ("zarr.json", ".zgroup", ".zmetadata") else found


def is_zarr(folder: Path) -> bool:
    """Whether a folder is a Zarr store."""
    return any((folder / name).is_file() for name in ("zarr.json", ".zgroup", ".zarray", ".zmetadata"))


@contextmanager
def opened(path: Path) -> Iterator[Store]:
    """The store in a file, known by its first bytes.

    Raises
    ------
    ReadError : damaged, of another kind, or a package is not installed
    """
    with reading(path):
        if path.is_dir() or path.suffix.lower() in ZARR:
            yield from _zarr(path)
            return
        with path.open("rb") as file:
            magic = file.read(8)
        if magic[:3] == b"CDF":
            yield _classic(path, magic[3])
            return
        if magic != b"\x89HDF\r\n\x1a\n":
            raise ReadError(f"{path.name!r} is neither NetCDF nor HDF5, whatever its name says: choose another file")
        h5py = wanted("h5py", path)
        with h5py.File(path, "r") as file:
            yield _hierarchical(path, file)


def wanted(package: str, path: Path) -> Any:
    """An optional package.

    Raises
    ------
    ReadError : what to install
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        extra = EXTRAS[package]
        raise ReadError(
            f"{path.name!r} is read with {package}, which is not installed: run  pip install 'nonius-explorer[{extra}]'"
        ) from None


# --- NetCDF 3 ----------------------------------------------------------------------------------------------------


def _classic(path: Path, version: int) -> Store:
    """A classic file, which scipy reads whole."""
    if version not in (1, 2):
        raise ReadError(f"{path.name!r} is a NetCDF file of kind CDF-{version}: convert it with  nccopy -k nc4")
    if path.stat().st_size > memory() / 2:
        raise ReadError(f"{path.name!r} is larger than half of the memory here: convert it with  nccopy -k nc4, and read that")
    from scipy.io import netcdf_file

    with netcdf_file(path, "r", mmap=False, maskandscale=False) as file:
        variables = {}
        for name, one in file.variables.items():
            data = np.asarray(one.data)
            cut = _of_array(data)
            attributes = dict(one._attributes)
            variables[name] = Variable(name, tuple(one.dimensions), data.shape, data.dtype, attributes, cut)
        return Store(path, variables, dict(file._attributes))


def _of_array(data: NDArray[Any]) -> Callable[[Cut], NDArray[Any]]:
    return lambda cut: np.asarray(data[cut])


# --- HDF5, and NetCDF 4, which is HDF5 with dimensions -----------------------------------------------------------


def _hierarchical(path: Path, file: Any) -> Store:
    special = _bathymetry.of(path, file)
    if special is not None:
        return special
    import h5py

    variables: dict[str, Variable] = {}

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.names is None and not _bare(item):
            dims, said = _dimensions(item, name), attributes_of(item)
            variables[name] = Variable(name, dims, item.shape or (), item.dtype, said, _of_dataset(item))

    file.visititems(visit)
    return Store(path, variables, attributes_of(file))


def _bare(item: Any) -> bool:
    """Whether a NetCDF dimension has no coordinates: a dataset of zeros stands for it."""
    return text(item.attrs.get("NAME")).startswith("This is a netCDF dimension but not a netCDF variable")


def _nexus_axes(group: Any, name: str) -> list[str]:
    """Names of the axes of a NeXus group's signal."""
    signal, axes = text(group.attrs.get("signal")), group.attrs.get("axes")
    if not signal or axes is None or name.rsplit("/", 1)[-1] != signal:
        return []
    return [text(a) for a in np.atleast_1d(axes)]


def _dimensions(item: Any, name: str) -> tuple[str, ...]:
    """Names of the axes: of the scales that hang on them, or of itself if it is a scale."""
    if item.attrs.get("CLASS") == b"DIMENSION_SCALE" and len(item.shape) == 1:
        return (name,)
    axes = _nexus_axes(item.parent, name)
    found = []
    for i, dimension in enumerate(item.dims):
        if len(dimension):
            found.append(dimension[0].name.lstrip("/"))
        elif i < len(axes) and axes[i] != ".":
            found.append(f"{item.parent.name.strip('/')}/{axes[i]}".lstrip("/"))
        else:
            found.append(dimension.label or "")
    return tuple(found)


def _of_dataset(item: Any) -> Callable[[Cut], NDArray[Any]]:
    def read(cut: Cut) -> NDArray[Any]:
        return np.asarray(item[cut])

    return read


# --- Zarr --------------------------------------------------------------------------------------------------------


def _zarr(path: Path) -> Iterator[Store]:
    """A folder, or a zip of one."""
    zarr = wanted("zarr", path)
    store = zarr.storage.ZipStore(path, mode="r") if path.is_file() else zarr.storage.LocalStore(path, read_only=True)
    try:
        root = zarr.open(store, mode="r")
        arrays = {"values": root} if isinstance(root, zarr.Array) else _members(root, zarr)
        variables = {}
        for name, one in arrays.items():
            attributes = dict(one.attrs)
            dims = getattr(one.metadata, "dimension_names", None) or attributes.pop("_ARRAY_DIMENSIONS", None)
            dims = tuple(d or "" for d in dims or ("",) * one.ndim)
            if one.fill_value is not None and "_FillValue" not in attributes and one.fill_value != 0:
                attributes["_FillValue"] = one.fill_value
            variables[name] = Variable(name, dims, one.shape, np.dtype(one.dtype), attributes, _of_dataset(one))
        yield Store(path, variables, dict(root.attrs))
    finally:
        store.close()


def _members(group: Any, zarr: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, one in group.members():
        if isinstance(one, zarr.Array):
            found[prefix + name] = one
        else:
            found |= _members(one, zarr, f"{prefix}{name}/")
    return found
