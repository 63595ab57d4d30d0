"""Volumes and meshes of other programs, and numbers without a header: one file of each kind, and a broken one."""

from __future__ import annotations

import gzip
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkIOImage import vtkMetaImageWriter, vtkNIFTIImageWriter

from modules.api import Curvilinear, Regular, Samples, Unstructured
from modules.readers._files import ReadError
from modules.readers.dataset import companions, dataset, peek
from modules.readers.raw import peek as look
from modules.readers.raw import raw

VALUES = np.arange(24, dtype=np.int16).reshape(2, 3, 4) ** 2
SPACING, ORIGIN = (1.0, 2.0, 3.0), (5.0, 6.0, 7.0)


def image() -> Any:
    made = pv.ImageData(dimensions=(4, 3, 2), spacing=SPACING, origin=ORIGIN)
    made.point_data["v"] = VALUES.ravel()
    return made


def written(writer: Any, path: Path) -> Path:
    writer.SetInputData(image())
    writer.SetFileName(str(path))
    writer.Write()
    return path


def nrrd(folder: Path, fields: str, data: bytes | None = None, name: str = "t.nrrd") -> Path:
    data = VALUES.astype("<i2").tobytes() if data is None else data
    (folder / name).write_bytes(f"NRRD0004\n# made here\ntype: short\n{fields}\n\n".encode() + data)
    return folder / name


def plain_nrrd(folder: Path) -> Path:
    return nrrd(folder, "dimension: 3\nsizes: 4 3 2\nspacings: 1 2 3\naxis mins: 5 6 7\nendian: little\nencoding: raw")


def packed_nrrd(folder: Path) -> Path:
    place = "space: left-posterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (5,6,7)"
    fields = f"dimension: 3\nsizes: 4 3 2\n{place}\nkinds: domain domain domain\nendian: big\nencoding: gzip"
    return nrrd(folder, fields, gzip.compress(VALUES.astype(">i2").tobytes()))


def detached_nrrd(folder: Path) -> Path:
    (folder / "t.raw").write_bytes(VALUES.astype("<i2").tobytes())
    fields = "dimension: 3\r\nsizes: 4 3 2\r\nspacings: 1 2 3\r\naxis mins: 5 6 7\r\nendian: little\r\nencoding: raw"
    return nrrd(folder, f"{fields}\r\ndata file: t.raw\r", b"", "t.nhdr")


def metaimage(folder: Path) -> Path:
    return written(vtkMetaImageWriter(), folder / "t.mha")


def pair_of_metaimage(folder: Path) -> Path:
    return written(vtkMetaImageWriter(), folder / "t.mhd")


def nifti(folder: Path) -> Path:
    return written(vtkNIFTIImageWriter(), folder / "t.nii")


def ensight(folder: Path) -> Path:
    (folder / "t.case").write_text(
        "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: t.geo\nVARIABLE\nscalar per node: v t.v\n", "ascii"
    )
    head = f"made\nhere\nnode id assign\nelement id assign\npart\n{1:10d}\nbox\nblock\n{4:10d}{3:10d}{2:10d}\n"
    lines = "".join(f"{x:12.5e}\n" for x in image().points.T.ravel())
    (folder / "t.geo").write_text(head + lines, "ascii")
    numbers = "".join(f"{x:12.5e}\n" for x in VALUES.ravel())
    (folder / "t.v").write_text(f"v\npart\n{1:10d}\nblock\n{numbers}", "ascii")
    return folder / "t.case"


def plot3d(folder: Path) -> Path:
    size = np.array([4, 3, 2], "<i4").tobytes()
    (folder / "t.xyz").write_bytes(size + image().points.T.astype("<f4").tobytes())
    flow = np.tile(VALUES.ravel(), (5, 1)).astype("<f4").tobytes()
    (folder / "t.q").write_bytes(size + np.array([0.5, 0, 1e6, 0], "<f4").tobytes() + flow)
    about = {"auto-detect-format": True, "filenames": [{"time": 0.0, "xyz": "t.xyz", "q": "t.q"}]}
    (folder / "t.p3d").write_text(json.dumps(about))
    return folder / "t.p3d"


def dicom(folder: Path) -> Path:
    """Two slices, explicit little-endian, with the elements that an image needs."""

    def element(group: int, number: int, kind: bytes, value: bytes) -> bytes:
        value += b"\0" * (len(value) % 2) if kind in (b"UI", b"OW") else b" " * (len(value) % 2)
        length = struct.pack("<HI", 0, len(value)) if kind == b"OW" else struct.pack("<H", len(value))
        return struct.pack("<HH", group, number) + kind + length + value

    for z in range(2):
        meta = element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1")
        short: Callable[[int], bytes] = lambda n: struct.pack("<H", n)  # noqa: E731  # a word of two bytes
        body = (
            element(0x18, 0x50, b"DS", b"3") + element(0x20, 0x0D, b"UI", b"1.2.3") + element(0x20, 0x0E, b"UI", b"1.2.4")
            + element(0x20, 0x13, b"IS", str(z + 1).encode()) + element(0x20, 0x32, b"DS", f"5\\6\\{7 + 3 * z}".encode())
            + element(0x20, 0x37, b"DS", b"1\\0\\0\\0\\1\\0") + element(0x28, 2, b"US", short(1))
            + element(0x28, 0x10, b"US", short(3)) + element(0x28, 0x11, b"US", short(4)) + element(0x28, 0x30, b"DS", b"2\\1")
            + element(0x28, 0x100, b"US", short(16)) + element(0x28, 0x101, b"US", short(16))
            + element(0x28, 0x102, b"US", short(15)) + element(0x28, 0x103, b"US", short(1))
            + element(0x7FE0, 0x10, b"OW", VALUES[z].astype("<i2").tobytes())
        )  # fmt: skip
        head = element(2, 0, b"UL", struct.pack("<I", len(meta)))
        (folder / f"slice{z}.dcm").write_bytes(b"\0" * 128 + b"DICM" + head + meta + body)
    return folder / "slice0.dcm"


def cgns(folder: Path) -> Path:
    """The HDF5 form, node by node: base, zone, coordinates, a solution on vertices."""

    def node(parent: Any, name: str, label: str, data: Any = None) -> Any:
        made = parent.create_group(name)
        kind = "MT" if data is None else {"i4": "I4", "f8": "R8", "S1": "C1"}[np.asarray(data).dtype.str[1:]]
        for key, value, size in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
            text = np.zeros((), f"S{size}")
            text[...] = value.encode()
            made.attrs.create(key, text, dtype=h5py.string_dtype("ascii", size))
        made.attrs["flags"] = np.array([1], np.int32)
        if data is not None:
            made[" data"] = data
        return made

    def chars(word: str) -> Any:
        return np.frombuffer(word.encode(), "i1")

    with h5py.File(folder / "t.cgns", "w") as file:
        for key, value, size in (("name", "HDF5 MotherNode", 33), ("label", "Root Node of HDF5 File", 33), ("type", "MT", 3)):
            file.attrs.create(key, np.bytes_(value), dtype=h5py.string_dtype("ascii", size))
        node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.2], "f4").astype("f8"))
        base = node(file, "Base", "CGNSBase_t", np.array([3, 3], "i4"))
        zone = node(base, "Zone", "Zone_t", np.array([[4, 3, 2], [3, 2, 1], [0, 0, 0]], "i4"))
        kind = node(zone, "ZoneType", "ZoneType_t")
        kind[" data"] = chars("Structured")
        kind.attrs.modify("type", np.bytes_("C1"))
        grid = node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis, name in enumerate(("CoordinateX", "CoordinateY", "CoordinateZ")):
            node(grid, name, "DataArray_t", image().points[:, axis].reshape(2, 3, 4).astype("f8"))
        flow = node(zone, "Flow", "FlowSolution_t")
        place = node(flow, "GridLocation", "GridLocation_t")
        place[" data"] = chars("Vertex")
        place.attrs.modify("type", np.bytes_("C1"))
        node(flow, "v", "DataArray_t", VALUES.astype("f8"))
    return folder / "t.cgns"


def collection(folder: Path) -> Path:
    blocks = pv.MultiBlock({"box": image(), "mesh": image().cast_to_unstructured_grid()})
    blocks.save(folder / "t.vtm")
    return folder / "t.vtm"


MADE = [plain_nrrd, packed_nrrd, detached_nrrd, metaimage, pair_of_metaimage, nifti, ensight, plot3d, dicom, cgns, collection]


@pytest.mark.parametrize("make", MADE)
def test_a_file_of_each_kind_is_read_with_its_places(make: Callable[[Path], Path], tmp_path: Path) -> None:
    path = make(tmp_path)
    samples = dataset(path=path)
    values = samples.values[::-1, ::-1] if make is dicom else samples.values  # VTK turns it about x, and it is flagged
    np.testing.assert_array_equal(values.reshape(2, 3, 4), VALUES)
    assert isinstance(samples.grid, Regular | Curvilinear)
    low, high = np.array(samples.grid.bounds[::2]), np.array(samples.grid.bounds[1::2])
    np.testing.assert_allclose(high - low, [3, 4, 3])
    if make not in (nifti, dicom):
        np.testing.assert_allclose(low, ORIGIN)
    term = samples.accuracy.terms[0]
    assert term.source.rigour == "proven" and [m.name for m in samples.accuracy.missing] == ["Measurement error"]
    assert float(term.value) == 0.5 or make in (ensight, plot3d, cgns)
    assert peek(path)["names"] and not peek(path).get("problem")


@pytest.mark.parametrize("make", MADE)
def test_half_a_file_gives_one_sentence(make: Callable[[Path], Path], tmp_path: Path) -> None:
    path = make(tmp_path)
    for file in (path, *companions(path)):
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(ReadError) as error:
        dataset(path=path)
    assert "\n" not in str(error.value) and path.stem[:5] in str(error.value)


@pytest.mark.parametrize("name", ["t.nrrd", "t.mha", "t.nii", "t.case", "t.cgns", "t.p3d", "t.dcm", "t.vtm"])
def test_what_is_none_of_its_kind_gives_one_sentence(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"Dear reader, these are words. " * 20)
    with pytest.raises(ReadError) as error:
        dataset(path=tmp_path / name)
    assert "\n" not in str(error.value) and "t" in str(error.value)


def test_a_block_is_chosen_by_name(tmp_path: Path) -> None:
    path = collection(tmp_path)
    assert peek(path)["names"] == ("box/v", "mesh/v")
    assert isinstance(dataset(path=path, name="mesh/v").grid, Unstructured)
    with pytest.raises(ReadError, match="box/v"):
        dataset(path=path, name="boxes/v")


def test_nrrd_vectors_and_turned_volumes(tmp_path: Path) -> None:
    samples = dataset(path=nrrd(tmp_path, "dimension: 3\nsizes: 3 4 2\nkinds: vector domain domain\nencoding: ascii",
                                " ".join(map(str, range(24))).encode()))  # fmt: skip
    assert samples.values.shape == (2, 4, 3) and samples.accuracy.terms[0].components == 3
    turned = nrrd(tmp_path, "dimension: 3\nsizes: 4 3 2\nspace directions: (0,1,0) (2,0,0) (0,0,3)\nencoding: raw")
    assert "turns the volume" in dataset(path=turned).accuracy.flags[0].words
    with pytest.raises(ReadError, match="hex"):
        dataset(path=nrrd(tmp_path, "dimension: 3\nsizes: 4 3 2\nencoding: hex"))


# --- raw ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["uint8", "int16", "uint32", "float32", "float64"])
@pytest.mark.parametrize("order", ["little", "big"])
def test_numbers_are_read_as_told(kind: Any, order: Any, tmp_path: Path) -> None:
    stored = (VALUES % 200).astype(np.dtype(kind).newbyteorder("<" if order == "little" else ">"))
    (tmp_path / "v.raw").write_bytes(b"HEADER" + stored.tobytes())
    told: dict[str, Any] = {"size": (4, 3, 2), "type": kind, "order": order, "header": 6, "spacing": SPACING}
    samples = raw(path=tmp_path / "v.raw", unit="K", lengths="mm", **told)
    np.testing.assert_array_equal(samples.values, VALUES % 200)
    assert isinstance(samples.grid, Regular) and samples.grid.spacing == SPACING and samples.grid.frame.units[0] == "mm"
    assert samples.unit == "K" and (float(samples.accuracy.terms[0].value) == 0.5 or kind.startswith("float"))


def test_vectors_and_no_data(tmp_path: Path) -> None:
    (tmp_path / "v.raw").write_bytes(np.arange(24, dtype="<f4").tobytes())
    vector = raw(path=tmp_path / "v.raw", size=(4, 2), components="3")
    assert vector.values.shape == (2, 4, 3) and vector.values[0, 1, 2] == 5 and vector.accuracy.terms[0].components == 3
    assert np.isnan(raw(path=tmp_path / "v.raw", size=(6, 4), no_data=7.0).values).sum() == 1


@pytest.mark.parametrize(("given", "words"), [
    ({"size": (4, 3, 3)}, "need 144: check the dimensions"), ({"size": (4, 3), "type": "float64"}, ""),
    ({"size": (4, 3)}, "a header of 48 bytes would fit"), ({"size": (4, 6), "type": "float64"}, "type int32 would fit"),
    ({}, "set 'size'"), ({"size": (4, 0)}, "set 'size'"), ({"size": (4, 6), "spacing": (1.0,)}, "2 positive numbers"),
    ({"guess": "four"}, "no shape"), ({"size": (4, 6), "spacing": (1.0, -1.0)}, "2 positive numbers"),
])  # fmt: skip
def test_what_does_not_fit_says_what_would(given: dict[str, Any], words: str, tmp_path: Path) -> None:
    (tmp_path / "v.raw").write_bytes(np.arange(24, dtype="<f4").tobytes())
    if given == {"size": (4, 3), "type": "float64"}:
        assert raw(path=tmp_path / "v.raw", **given).values.shape == (3, 4)
        return
    with pytest.raises(ReadError, match=words):
        raw(path=tmp_path / "v.raw", **given)


def test_shapes_are_guessed_from_the_bytes(tmp_path: Path) -> None:
    (tmp_path / "v.raw").write_bytes(np.arange(64, dtype="<f4").tobytes())
    facts = look(tmp_path / "v.raw")
    assert facts["bytes"] == 256 and "4 4 4 float32" in facts["names"] and "Read raw numbers" in facts["problem"]
    assert raw(path=tmp_path / "v.raw", guess="4 4 4 float32").values.shape == (4, 4, 4)
    assert look(tmp_path / "v.xyz")["problem"] and isinstance(raw(path=tmp_path / "v.raw", guess="8 8 float32"), Samples)
