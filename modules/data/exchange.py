"""Wires as VTK data sets and files, and back, with their accuracy: exactly for ourselves, readable for other programs.

Beside an array X lie X_std (standard deviation), X_lo and X_hi (limits), X_members. The field data holds "nonius", what
the wire says of itself, and "accuracy", the budget, both as JSON, and the arrays that these name by number. Nothing is
unpickled.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data import codec, companions, foreign
from modules.data.accuracy import Accuracy, unknown
from modules.data.codec import CodecError, Reader, Writer
from modules.data.foreign import ExchangeError
from modules.data.geometry import Field, Geometry, Primitive, Shown
from modules.data.grid import Curvilinear, Frame, Grid, Rectilinear, Regular, Unstructured
from modules.data.wires import Model, Samples

FORMAT = "nonius wire"
VERSION = 1
ABOUT, BUDGET, ARRAY = "nonius", "accuracy", "accuracy_{}"
SUFFIXES: Mapping[type, str] = {
    Regular: ".vti", Rectilinear: ".vtr", Curvilinear: ".vts", Unstructured: ".vtu", Geometry: ".vtp",
}  # fmt: skip
__all__ = ["ABOUT", "READ", "ExchangeError", "from_pyvista", "load", "save", "to_pyvista"]

READ = (*SUFFIXES.values(), ".vtk")
"""Suffixes that `load` takes."""


def to_pyvista(wire: Samples | Geometry | Any) -> Any:
    """The wire as a pyvista data set that carries all of it.

    Returns
    -------
    ImageData, RectilinearGrid, StructuredGrid, UnstructuredGrid or PolyData

    Raises
    ------
    ExchangeError : a wire that has no data set
    """
    writer = Writer()
    if isinstance(wire, Samples):
        dataset, about = _samples_out(wire)
    elif isinstance(wire, Geometry):
        dataset, about = _geometry_out(wire, writer)
    else:
        instead = ": give its samples" if isinstance(wire, Model) else ""
        raise ExchangeError(f"a {type(wire).__name__} is no data set{instead}")
    budget = writer.accuracy(wire.accuracy)
    frame = wire.frame if isinstance(wire, Geometry) else wire.grid.frame
    about |= {"format": FORMAT, "version": VERSION, "frame": _frame_out(frame), "time": wire.time, "name": wire.name}
    budget |= {"format": codec.FORMAT, "version": codec.VERSION, "operators": writer.operators}
    dataset.field_data[ABOUT] = [codec.dumps(about)]
    dataset.field_data[BUDGET] = [codec.dumps(budget)]
    for number, array in enumerate(writer.arrays):
        dataset.field_data[ARRAY.format(number)] = array
    if wire.time is not None:
        dataset.field_data["TimeValue"] = np.array([wire.time])
    return dataset


def from_pyvista(dataset: Any, name: str | None = None, content: str = "") -> Samples | Geometry:
    """A data set as a wire: one of ours as it was, one of other programs with the errors that lie beside its array.

    Parameters
    ----------
    name : which point array; by default the active one, else the first
    content : identity of the file, for the ids of new terms; by default that of the values

    Raises
    ------
    ExchangeError : no points, several blocks, no such array, or an array on cells
    """
    if not hasattr(dataset, "point_data"):
        raise ExchangeError("the data set has several blocks: choose one of them")
    if not dataset.n_points and ABOUT not in dataset.field_data:
        raise ExchangeError("the data set has no points")
    try:
        if ABOUT not in dataset.field_data or name not in (None, "", _stored_name(dataset)):
            return foreign.taken(dataset, name or "", content)
        about = codec.loads(_text(dataset, ABOUT), FORMAT, VERSION)
        reader, accuracy = _budget(dataset)
        build = _geometry_in if about["kind"] == "geometry" else _samples_in
        return build(dataset, about, reader, accuracy)
    except (CodecError, KeyError, TypeError, IndexError) as error:
        raise ExchangeError(f"what the file says of its accuracy cannot be read: {error}") from error


def save(wire: Samples | Geometry, path: Path) -> None:
    """Write a wire to a VTK file (.vti, .vtr, .vts, .vtu, .vtp).

    Raises
    ------
    ExchangeError : the suffix does not fit
    """
    wanted = SUFFIXES.get(type(wire.grid) if isinstance(wire, Samples) else type(wire), "")
    if path.suffix.lower() != wanted and wanted:
        what = f"samples on a {wire.grid.kind} grid are" if isinstance(wire, Samples) else "geometry is"
        raise ExchangeError(f"{what} saved as {wanted}, not {path.suffix or 'without a suffix'}: name it {path.stem}{wanted}")
    to_pyvista(wire).save(path, binary=True)


def load(path: Path, name: str | None = None) -> Samples | Geometry:
    """Read a VTK file: ours exactly as it was saved, others with the errors that lie beside the array.

    Raises
    ------
    ExchangeError : a suffix that is not read here, a damaged file, no such array
    """
    import pyvista as pv

    if path.suffix.lower() not in READ:
        raise ExchangeError(f"{path.name!r}: files that end in {path.suffix!r} are not read here; this reads {', '.join(READ)}")
    if not path.is_file():
        raise ExchangeError(f"there is no file {path.name!r} in {path.parent.as_posix()!r}")
    try:
        dataset = pv.read(path)
    except Exception as error:  # VTK's readers raise what they like
        why = str(error).strip().split("\n")[0]
        raise ExchangeError(f"{path.name!r} cannot be read ({why}): copy or download it again") from error
    try:
        return from_pyvista(dataset, name, sha256(path.read_bytes()).hexdigest())
    except ExchangeError as error:
        raise ExchangeError(f"{path.name!r}: {error}") from error


# --- samples -----------------------------------------------------------------------------------------------------


def _samples_out(samples: Samples) -> tuple[Any, dict[str, Any]]:
    grid = samples.grid
    dataset = grid_out(grid)
    name = samples.name or "values"
    values = samples.values
    stored = codec.native(values).copy()  # VTK shares memory, and a wire does not change
    flat = stored.reshape(grid.count, -1)
    dataset.point_data[name] = flat[:, 0] if flat.shape[1] == 1 else flat
    dataset.point_data.active_scalars_name = name
    for beside, array in companions.readable(name, values.reshape(grid.count, -1), samples.accuracy).items():
        dataset.point_data[beside] = array
    about: dict[str, Any] = {
        "kind": grid.kind, "array": name, "unit": samples.unit, "shape": list(values.shape), "grid": list(grid.shape),
        "type": values.dtype.str, "digest": _digest(flat),
    }  # fmt: skip
    if isinstance(grid, Regular):
        about |= {"spacing": list(grid.spacing), "origin": list(grid.origin)}
    return dataset, about


def _samples_in(dataset: Any, about: Mapping[str, Any], reader: Reader | None, accuracy: Accuracy) -> Samples:
    if about["array"] not in dataset.point_data:
        raise ExchangeError(f"the array {about['array']!r} was taken out of the file: name another one")
    stored = np.asarray(dataset.point_data[about["array"]])
    frame = _frame_in(about["frame"])
    shape = tuple(about["shape"])
    if stored.size != np.prod(shape, dtype=int):
        other = foreign.taken(dataset, about["array"], "")
        return replace(other, accuracy=unknown("the samples were changed by another program"))  # type: ignore[return-value]  # of samples
    grid = foreign.grid_in(dataset, tuple(about["grid"]), frame)
    if isinstance(grid, Regular) and "spacing" in about:
        exact = Regular(grid.size, tuple(about["spacing"]), tuple(about["origin"]), frame=frame)
        far = np.abs(np.subtract(exact.bounds, grid.bounds)).max()
        grid = exact if far <= 1e-6 * max(1e-300, np.ptp(exact.bounds)) else grid
    if _digest(stored.reshape(grid.count, -1)) != about["digest"]:
        accuracy = unknown("the values were changed after their accuracy was written").end_from(accuracy, "of values before")
    values = stored.astype(np.dtype(about["type"])).reshape(shape)
    return Samples(
        grid=grid, values=values, unit=about["unit"], name=about["name"], accuracy=accuracy, time=about["time"]
    )  # fmt: skip


def grid_out(grid: Grid) -> Any:
    """A grid as a pyvista data set without values."""
    import pyvista as pv

    if isinstance(grid, Regular):
        size = [*reversed(grid.size), 1, 1][:3]
        return pv.ImageData(dimensions=size, spacing=[*grid.spacing, 1.0, 1.0][:3], origin=[*grid.origin, 0.0, 0.0][:3])
    if isinstance(grid, Rectilinear):
        return pv.RectilinearGrid(*[*grid.axes, np.zeros(1), np.zeros(1)][:3])
    if isinstance(grid, Curvilinear):
        dataset = pv.StructuredGrid()
        dataset.points = grid.points().copy()
        dataset.dimensions = [*reversed(grid.shape), 1, 1][:3]
        return dataset
    if isinstance(grid, Unstructured):
        sizes = np.diff(grid.offsets)
        cells = np.insert(grid.connectivity, grid.offsets[:-1], sizes) if len(sizes) else np.zeros(0, np.int64)
        return pv.UnstructuredGrid(cells, grid.types.astype(np.uint8), grid.nodes.copy())
    raise ExchangeError(f"a {grid.kind} grid has no data set")


# --- geometry ----------------------------------------------------------------------------------------------------


def _geometry_out(shape: Geometry, writer: Writer) -> tuple[Any, dict[str, Any]]:
    import pyvista as pv

    dataset = pv.PolyData()
    dataset.points = np.array(shape.points)
    for part, cells in (("SetVerts", shape.vertices), ("SetLines", shape.lines), ("SetPolys", shape.polygons)):
        if len(cells):
            getattr(dataset, part)(pv.CellArray.from_arrays(cells.offsets, cells.connectivity))
    data = {"point": dataset.point_data, "cell": dataset.cell_data}
    about: dict[str, Any] = {"kind": "geometry", "values": {}, "cell": shape.cell, "digest": _digest(shape.points)}
    for name, one in shape.values.items():
        about["values"][name] = {"place": one.place, "unit": one.unit, "array": writer.array(one.values)}
        if one.place in data and np.asarray(one.values).dtype.kind in "fiu":
            data[one.place][name] = codec.native(one.values).copy()
    for name, array in (("texture", shape.texture), ("texture_at", shape.texture_at), ("origin", shape.origin)):
        about[name] = None if array is None else writer.array(array)
    if shape.origin is not None and len(shape.origin):
        dataset.cell_data["origin"] = codec.native(shape.origin).copy()
    about["shows"] = [[s.name, s.quantity, s.note, s.factor] for s in shape.shows]
    about["primitives"] = [
        {"kind": p.kind, "values": {n: writer.array(np.atleast_1d(v)) for n, v in p.values.items()},
         "accuracy": writer.accuracy(p.accuracy)}
        for p in shape.primitives
    ]  # fmt: skip
    for name, sizes in _positions(shape.accuracy).items():
        dataset.point_data[name] = sizes
    return dataset, about


def _positions(accuracy: Accuracy) -> dict[str, NDArray[Any]]:
    """How far points may lie off, for other programs: position_std, and position_bound of bounds and signed errors."""
    terms = accuracy.select("position", "point")
    if not terms or len({t.unit for t in terms}) > 1 or not terms[0].count:
        return {}
    random = tuple(t for t in terms if t.kind in ("linear", "members"))
    straight = tuple(t for t in terms if t.kind in ("bound", "signed"))
    named = {"position_std": random, "position_bound": straight}
    return {name: replace(accuracy, terms=some).total(1.0, "position") for name, some in named.items() if some}


def _geometry_in(dataset: Any, about: Mapping[str, Any], reader: Reader | None, accuracy: Accuracy) -> Geometry:
    points = np.array(dataset.points, dtype=float)
    if reader is None or _digest(points) != about["digest"]:
        changed = foreign.taken(dataset, "", "")
        return replace(changed, accuracy=unknown("the points were changed after their accuracy was written"))  # type: ignore[return-value]  # of geometry
    values = {
        name: Field(reader.array(one["array"]), one["place"], one["unit"]) for name, one in about["values"].items()
    }  # fmt: skip
    extra = [None if about[n] is None else reader.array(about[n]) for n in ("texture", "texture_at", "origin")]
    texture, texture_at, origin = extra
    vertices, lines, polygons = foreign.cells_in(dataset)
    primitives = tuple(
        Primitive(
            kind=p["kind"], values={n: reader.array(v) for n, v in p["values"].items()}, accuracy=reader.accuracy(p["accuracy"])
        )
        for p in about["primitives"]
    )
    return Geometry(
        points=points, vertices=vertices, lines=lines, polygons=polygons, values=values, primitives=primitives,
        texture=texture, texture_at=texture_at, origin=origin,
        shows=tuple(Shown(*s) for s in about["shows"]), cell=about["cell"], frame=_frame_in(about["frame"]), name=about["name"],
        time=about["time"], accuracy=accuracy,
    )  # fmt: skip


# --- what is said beside the arrays ------------------------------------------------------------------------------


def _budget(dataset: Any) -> tuple[Reader | None, Accuracy]:
    if BUDGET not in dataset.field_data:
        return None, unknown("the budget was taken out of the file")
    record = codec.loads(_text(dataset, BUDGET), codec.FORMAT, codec.VERSION)

    def array(number: int) -> NDArray[Any]:
        return np.asarray(dataset.field_data[ARRAY.format(number)])

    found: list[Reader] = []

    def build() -> Accuracy:
        found.append(Reader(record["operators"], array))
        return found[0].accuracy(record)

    accuracy = codec.guarded(build)
    return found[0], accuracy


def _text(dataset: Any, name: str) -> str:
    stored = dataset.field_data[name]
    return str(stored if isinstance(stored, str) else stored[0])


def _stored_name(dataset: Any) -> str:
    about = codec.loads(_text(dataset, ABOUT), FORMAT, VERSION)
    return str(about.get("array", about.get("name", "")))


def _digest(array: NDArray[Any]) -> str:
    stored = np.ascontiguousarray(array)
    return sha256(stored.astype(stored.dtype.newbyteorder("<")).tobytes()).hexdigest()


def _frame_out(frame: Frame) -> dict[str, Any]:
    return {"axes": list(frame.axes), "units": list(frame.units), "handed": frame.handed, "crs": frame.crs}


def _frame_in(record: Mapping[str, Any]) -> Frame:
    return Frame(tuple(record["axes"]), tuple(record["units"]), record["handed"], record["crs"])
