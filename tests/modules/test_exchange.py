"""Wires as VTK files and back: nothing of what is known of their accuracy is lost, and other programs can read it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from scipy.sparse import csr_array, random_array

from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    Curvilinear,
    Field,
    Flag,
    Frame,
    Gather,
    Geometry,
    Grid,
    Identity,
    Matrix,
    Missing,
    Model,
    Operator,
    Primitive,
    Rectilinear,
    Regular,
    Samples,
    Shown,
    Source,
    Spread,
    Sum,
    Term,
    Unstructured,
    Value,
    bound,
    deviation,
    scaling,
    select,
    stencil,
)
from modules.data import codec
from modules.data.accuracy import Ended
from modules.data.exchange import ExchangeError, from_pyvista, load, save, to_pyvista
from modules.modellers.state_accuracy import state_accuracy

FRAME = Frame(("east", "north", "up"), ("km", "km", "m"), "right", "UTM zone 10, ∆ ≤ 3")
RNG = np.random.default_rng(7)


def term(kind: Any, value: Any, operator: Operator, **more: Any) -> Term:
    source = Source(f"{kind} error ≤ ∆", "data", "estimated", "who says so (rule/1)")
    return Term(source, kind, more.pop("quantity", "value"), "m", np.asarray(value), operator, **more)


def every_operator(shape: tuple[int, ...]) -> list[Operator]:
    n = int(np.prod(shape))
    first = stencil(shape, 0, (-1, 0, 1), (0.25, 0.5, 0.25))
    smooth = stencil(shape, len(shape) - 1, (-1, 0, 1), (0.25, 0.5, 0.25)).after(first)
    matrix = csr_array(random_array((n, 11), density=0.2, rng=np.random.default_rng(1), format="csr"))
    return [
        Identity(n), Spread(n), first, smooth, Sum((smooth, Identity(n))), Matrix(matrix), scaling(RNG.uniform(0, 2, n)),
        select(RNG.permutation(n), n), Gather(RNG.integers(0, 5, (n, 3)).astype(np.int32), RNG.normal(size=(n, 3)), 5),
        scaling(RNG.uniform(0, 2, n)).after(Sum((smooth.after(Identity(n)), select(RNG.permutation(n), n)))),
    ]  # fmt: skip


def rich(shape: tuple[int, ...]) -> Accuracy:
    """A budget with every kind of term through every operator."""
    n, terms = int(np.prod(shape)), []
    for i, operator in enumerate(every_operator(shape)):
        n_in = operator.shape[1]
        kinds: list[Any] = ["linear", "bound", "signed", "metric"]
        value = RNG.uniform(0, 1, n_in) if i % 2 else np.asarray(0.1 + i)
        terms.append(term(kinds[i % 4], value, operator, id=f"id {i} é"))
    terms.append(term("members", RNG.normal(size=(6, n)), Identity(n), id="members"))
    flags = (Flag("kappa", "too flat ≥", "point", np.array([1, 3]), np.array([0.5, np.nan])), Flag("unproven", "all of it"))
    missing = (Missing("Measurement error", "nobody gave it"),)
    return Accuracy(tuple(terms), missing, flags, {"gone": Ended("Old", "it stopped")})


def grids() -> dict[str, Grid]:
    x, y, z = np.cumsum(RNG.uniform(0.1, 1, 6)), np.cumsum(RNG.uniform(0.1, 1, 5)), np.cumsum(RNG.uniform(0.1, 1, 4))
    bent = np.stack(np.meshgrid(x, y, z), axis=-1).reshape(5, 6, 4, 3) + RNG.normal(0, 0.01, (5, 6, 4, 3))
    nodes = RNG.normal(size=(8, 3))
    tetra = Unstructured(nodes, np.array([0, 4, 8]), np.array([0, 1, 2, 3, 4, 5, 6, 7]), np.array([10, 10]), frame=FRAME)
    return {
        "regular 1": Regular((7,), (0.1,), (1 / 3,), frame=FRAME),
        "regular 2": Regular((5, 6), (0.1, 1 / 7), (1e6 + 1 / 3, -2e7), frame=FRAME),
        "regular 3": Regular((4, 5, 6), (0.1, 1 / 7, 3.0), (0.0, 1.0, 2.0), frame=FRAME),
        "a plane of one row": Regular((1, 6), (0.1, 1 / 7), (0.0, 1.0), frame=FRAME),
        "rectilinear 1": Rectilinear((x,), frame=FRAME),
        "rectilinear 2": Rectilinear((x, y), frame=FRAME),
        "rectilinear 3": Rectilinear((x, y, z), frame=FRAME),
        "curvilinear 2": Curvilinear(bent[:, :, 0], frame=FRAME),
        "curvilinear 3": Curvilinear(bent, frame=FRAME),
        "unstructured": tetra,
    }


SUFFIX = {"regular": ".vti", "rectilinear": ".vtr", "curvilinear": ".vts", "unstructured": ".vtu"}


def same_budget(a: Accuracy, b: Accuracy) -> None:
    """All is equal, to the bit."""
    assert [t.id for t in a.terms] == [t.id for t in b.terms]
    assert a.missing == b.missing and dict(a.ended) == dict(b.ended)
    for s, t in zip(a.terms, b.terms, strict=True):
        assert (s.source, s.kind, s.quantity, s.unit, s.place, s.components) == (
            t.source, t.kind, t.quantity, t.unit, t.place, t.components)  # fmt: skip
        np.testing.assert_array_equal(s.value, t.value)
        assert s.operator.shape == t.operator.shape
        rows = np.arange(s.operator.shape[0])
        assert (s.operator.rows(rows) != t.operator.rows(rows)).nnz == 0
        np.testing.assert_array_equal(s.error(), t.error())
        if s.points is not None:
            np.testing.assert_array_equal(s.points, t.points)
    for f, g in zip(a.flags, b.flags, strict=True):
        assert (f.name, f.words, f.place) == (g.name, g.words, g.place)
        np.testing.assert_array_equal(f.items, g.items)
        np.testing.assert_array_equal(f.values, g.values)


@pytest.mark.parametrize("name", grids())
def test_samples_come_back_exactly(name: str, tmp_path: Path) -> None:
    grid = grids()[name]
    values = RNG.normal(size=grid.shape)
    values.ravel()[2] = np.nan
    samples = Samples(grid=grid, values=values, unit="m/s", name="speed ≤", accuracy=rich(grid.shape), time=0.1)
    path = tmp_path / f"a{SUFFIX[grid.kind]}"
    save(samples, path)
    again = load(path)
    assert isinstance(again, Samples)
    assert type(again.grid) is type(grid) and again.grid.frame == FRAME and again.grid.shape == grid.shape
    np.testing.assert_array_equal(again.grid.points(), grid.points())
    if isinstance(grid, Regular):
        assert isinstance(again.grid, Regular) and (again.grid.spacing, again.grid.origin) == (grid.spacing, grid.origin)
    if isinstance(grid, Unstructured):
        assert isinstance(again.grid, Unstructured)
        np.testing.assert_array_equal(again.grid.connectivity, grid.connectivity)
        np.testing.assert_array_equal(again.grid.types, grid.types)
    np.testing.assert_array_equal(again.values, values)
    assert (again.unit, again.name, again.time) == ("m/s", "speed ≤", 0.1)
    same_budget(samples.accuracy, again.accuracy)


@pytest.mark.parametrize("kind", ["f4", "f8", "i2", "u1", "?", ">f8", ">i4"])
def test_types_of_numbers_are_kept(kind: str, tmp_path: Path) -> None:
    values = (RNG.uniform(0, 2, (4, 5)) * 3).astype(kind)
    save(Samples.from_array(values, accuracy=EXACT), tmp_path / "a.vti")
    again = load(tmp_path / "a.vti")
    assert isinstance(again, Samples) and again.values.dtype.newbyteorder("=") == values.dtype.newbyteorder("=")
    np.testing.assert_array_equal(again.values, values)


@pytest.mark.parametrize("extra", [(3,), (3, 3)])
def test_vectors_and_tensors(extra: tuple[int, ...], tmp_path: Path) -> None:
    grid = Regular((4, 5), (1.0, 1.0), (0.0, 0.0))
    c = int(np.prod(extra))
    error = replace(deviation("Noise", RNG.uniform(0, 1, 20 * c), 20 * c, id="n"), components=c)
    samples = Samples(grid=grid, values=RNG.normal(size=(4, 5, *extra)), name="v", accuracy=Accuracy((error,)))
    save(samples, tmp_path / "a.vti")
    again = load(tmp_path / "a.vti")
    assert isinstance(again, Samples)
    np.testing.assert_array_equal(again.values, samples.values)
    same_budget(samples.accuracy, again.accuracy)
    np.testing.assert_allclose(pv.read(tmp_path / "a.vti")["v_std"].reshape(20, c), error.error())


def test_smoothed_saved_loaded_and_probed_gives_the_same_deviation(tmp_path: Path) -> None:
    """And the difference of a field from itself, once through the file, has no error: they are one source."""
    samples = state_accuracy(Samples.from_array(RNG.normal(size=(20, 30)), accuracy=EXACT, unit="m"), amount=0.7)
    for axis in (0, 1):
        smooth = stencil((20, 30), axis, (-1, 0, 1), (0.25, 0.5, 0.25))
        samples = replace(samples, accuracy=samples.accuracy.push(smooth))
    save(samples, tmp_path / "a.vti")
    again = load(tmp_path / "a.vti")
    assert isinstance(again, Samples)
    points = np.column_stack([RNG.uniform(0, 29, 40), RNG.uniform(0, 19, 40), np.zeros(40)])
    before, after = (Model.between(s).at(points)[1].total(2.0, "value") for s in (samples, again))
    np.testing.assert_array_equal(before, after)
    joined = Accuracy.join([(samples.accuracy, None), (again.accuracy, scaling(-np.ones(600)))])
    assert len(joined.terms) == 1
    np.testing.assert_allclose(joined.terms[0].error(), 0, atol=1e-15)


def test_shared_operators_are_stored_once() -> None:
    operator = scaling(RNG.normal(size=500))
    terms = tuple(term("linear", 1.0, operator, id=str(i)) for i in range(20))
    text, arrays = codec.encode(Accuracy(terms))
    assert len(arrays) == 2
    again = codec.decode(text, arrays.__getitem__)
    assert len({id(t.operator) for t in again.terms}) == 1


def shape() -> Geometry:
    points = RNG.normal(size=(9, 3))
    lines, polygons = Cells.of([[0, 1, 2], [3, 4, 5, 6]]), Cells.of([[0, 1, 2], [2, 3, 4, 5]])
    n = {"point": 9, "cell": 5, "segment": 5}
    values = {
        "height": Field(RNG.normal(size=9), "point", "m"), "ids": Field(np.arange(5), "cell"),
        "area": Field(RNG.normal(size=5), "segment", "m2"), "flow": Field(RNG.normal(size=(9, 3)), "point", "m/s"),
    }  # fmt: skip
    terms = (
        replace(deviation("Noise", RNG.uniform(0, 1, 9), 9, quantity="position", unit="km"), id="noise"),
        replace(bound("Step", 0.5, n["cell"]), place="cell", id="step"),
        term("metric", RNG.uniform(0, 1, 5), Identity(5), place="segment", quantity="area", id="area"),
        term("signed", RNG.normal(size=4), Identity(4), place="own", points=RNG.normal(size=(4, 3)), id="own"),
        term("linear", RNG.uniform(0, 1, 27), Identity(27), components=3, quantity="velocity", id="v"),
    )
    ball = Primitive(
        kind="sphere", values={"centre": np.zeros(3), "radius": np.ones(1)},
        accuracy=Accuracy((term("linear", [0.1] * 3, Identity(3), quantity="centre", components=3, id="c"),)),
    )  # fmt: skip
    return Geometry(
        points=points, vertices=Cells.of([[7]]), lines=lines, polygons=polygons, values=values, primitives=(ball,),
        texture=RNG.integers(0, 255, (4, 6, 3)).astype(np.uint8), texture_at=RNG.uniform(size=(9, 2)),
        origin=np.array([3, 1, 4, 1, 5]), shows=(Shown("Noise", "position", "1 point = 34 m²", 30.0),), cell=0.25, frame=FRAME,
        name="lines", time=3.5,
        accuracy=Accuracy(terms, (Missing("Law", "unknown"),), (Flag("f", "w", "cell", np.array([1])),)),
    )  # fmt: skip


def test_geometry_comes_back_exactly(tmp_path: Path) -> None:
    one = shape()
    save(one, tmp_path / "a.vtp")
    two = load(tmp_path / "a.vtp")
    assert isinstance(two, Geometry)
    same_budget(one.accuracy, two.accuracy)
    np.testing.assert_array_equal(one.points, two.points)
    for name in ("vertices", "lines", "polygons"):
        for part in ("offsets", "connectivity"):
            np.testing.assert_array_equal(getattr(getattr(one, name), part), getattr(getattr(two, name), part))
    for name in ("texture", "texture_at", "origin"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert (one.shows, one.cell, one.frame, one.name, one.time) == (two.shows, two.cell, two.frame, two.name, two.time)
    assert list(one.values) == list(two.values)
    for a, b in zip(one.values.values(), two.values.values(), strict=True):
        assert (a.place, a.unit) == (b.place, b.unit)
        np.testing.assert_array_equal(a.values, b.values)
    assert two.primitives[0].kind == "sphere"
    same_budget(one.primitives[0].accuracy, two.primitives[0].accuracy)


def test_other_programs_read_how_far_points_may_lie_off() -> None:
    one = shape()
    dataset = to_pyvista(one)
    np.testing.assert_array_equal(dataset["position_std"], one.accuracy.terms[0].error())
    assert "position_bound" not in dataset.array_names
    off = replace(one, accuracy=Accuracy((bound("B", 0.5, 9, quantity="position"), bound("C", 0.25, 9, quantity="position"))))
    np.testing.assert_array_equal(to_pyvista(off)["position_bound"], 0.75)


def test_an_empty_geometry_comes_back(tmp_path: Path) -> None:
    save(Geometry(points=np.zeros((0, 3)), accuracy=Accuracy(missing=(Missing("a", "b"),))), tmp_path / "a.vtp")
    again = load(tmp_path / "a.vtp")
    assert isinstance(again, Geometry) and not len(again.points) and again.accuracy.missing == (Missing("a", "b"),)


def test_other_programs_read_deviation_limits_and_members() -> None:
    values = RNG.normal(size=(4, 5))
    terms = (
        deviation("A", 3.0, 20), deviation("B", 4.0, 20), bound("C", 0.5, 20), bound("D", 0.25, 20),
    )  # fmt: skip
    dataset = to_pyvista(Samples.from_array(values, name="h", accuracy=Accuracy(terms)))
    np.testing.assert_allclose(dataset["h_std"], 5.0)
    np.testing.assert_allclose(dataset["h_hi"] - dataset["h"], 0.75)
    np.testing.assert_allclose(dataset["h"] - dataset["h_lo"], 0.75)
    members = term("members", RNG.normal(size=(6, 20)), Identity(20))
    dataset = to_pyvista(Samples.from_array(values, name="h", accuracy=Accuracy((members,))))
    np.testing.assert_allclose(dataset["h_members"].std(axis=1, ddof=1), members.error())
    assert json.loads(dataset.field_data["accuracy"][0])["format"] == "nonius accuracy"


@pytest.mark.parametrize("ending", ["_std", "_sigma", "_stderr", "_unc", "_uncertainty", "_error", "_errors"])
def test_deviations_of_other_programs_are_picked_up(ending: str, tmp_path: Path) -> None:
    dataset = pv.ImageData(dimensions=(5, 4, 1), spacing=(2.0, 3.0, 1.0))
    dataset.point_data["depth"] = RNG.normal(size=20).astype(np.float32)
    dataset.point_data["depth" + ending] = sizes = RNG.uniform(0, 1, 20)
    dataset.save(tmp_path / "a.vti")
    got = load(tmp_path / "a.vti")
    assert isinstance(got, Samples) and got.name == "depth" and got.grid.shape == (4, 5)
    linear = next(t for t in got.accuracy.terms if t.kind == "linear")
    np.testing.assert_array_equal(linear.error(), sizes)
    assert "assumed" in linear.source.rule or "taken as independent" in linear.source.rule
    assert not got.accuracy.missing
    rounding = next(t for t in got.accuracy.terms if t.kind == "bound")
    assert rounding.id.endswith("/depth/quantisation") and rounding.source.rigour == "proven"
    twice = load(tmp_path / "a.vti")
    assert [t.id for t in twice.accuracy.terms] == [t.id for t in got.accuracy.terms]


def test_limits_and_members_of_other_programs_are_picked_up() -> None:
    dataset = pv.RectilinearGrid([0.0, 1.0, 3.0], [0.0, 2.0], [5.0])
    dataset.point_data["q"] = q = RNG.normal(size=6)
    dataset.point_data["q_lo"], dataset.point_data["q_hi"] = q - 0.25, q + 0.5
    dataset.point_data["q_members"] = members = q[:, None] + RNG.normal(size=(6, 9))
    got = from_pyvista(dataset, "q")
    assert isinstance(got, Samples) and isinstance(got.grid, Rectilinear) and got.grid.dimensions == 2
    kinds = {t.id.rsplit("/", 1)[1]: t for t in got.accuracy.terms}
    np.testing.assert_allclose(kinds["limits"].error(), 0.5)
    np.testing.assert_allclose(kinds["members"].error(), members.std(axis=1, ddof=1))
    assert got.accuracy.flags[0].name == "plane"


def test_a_file_that_says_nothing_says_so() -> None:
    dataset = pv.ImageData(dimensions=(5, 4, 3))
    dataset.point_data["n"] = np.arange(60, dtype=np.int16)
    got = from_pyvista(dataset)
    assert isinstance(got, Samples) and got.grid.shape == (3, 4, 5)
    assert got.accuracy.missing[0].reason == "the file states none"
    assert got.accuracy.terms[0].error()[0] == 0.5


def test_other_grids_and_shapes_of_other_programs() -> None:
    ball = pv.Sphere()
    ball.cell_data["id"] = np.arange(ball.n_cells)
    got = from_pyvista(ball)
    assert isinstance(got, Geometry) and len(got.polygons) == ball.n_cells and got.values["id"].place == "cell"
    assert got.accuracy.missing
    bent = pv.StructuredGrid(*np.meshgrid(np.arange(3.0), np.arange(4.0), np.arange(5.0), indexing="ij"))
    bent.point_data["v"] = RNG.normal(size=(60, 3))
    taken = from_pyvista(bent)
    assert isinstance(taken, Samples) and taken.values.shape == (5, 4, 3, 3)
    np.testing.assert_array_equal(taken.grid.points(), bent.points)
    cells = bent.cast_to_unstructured_grid()
    loose = from_pyvista(cells)
    assert isinstance(loose, Samples) and isinstance(loose.grid, Unstructured) and loose.grid.cells == 24


def test_what_another_program_changed_is_no_longer_claimed(tmp_path: Path) -> None:
    samples = Samples.from_array(RNG.normal(size=(4, 5)), name="h", accuracy=Accuracy((bound("B", 1.0, 20, id="b"),)))
    dataset = to_pyvista(samples)
    dataset["h"][3] += 1
    changed = from_pyvista(dataset)
    assert changed.accuracy.rigour() == "unknown" and not changed.accuracy.terms and "b" in changed.accuracy.accounted()
    del (dataset := to_pyvista(samples)).field_data["accuracy"]
    assert from_pyvista(dataset).accuracy.rigour() == "unknown"
    smaller = to_pyvista(samples).extract_subset((0, 2, 0, 2, 0, 0))
    for name, array in to_pyvista(samples).field_data.items():
        smaller.field_data[name] = array
    cut = from_pyvista(smaller)
    assert isinstance(cut, Samples) and cut.grid.count == 9 and cut.accuracy.rigour() == "unknown"
    moved = to_pyvista(shape())
    moved.points += 1.0
    assert from_pyvista(moved).accuracy.rigour() == "unknown"


def damaged(change: Any) -> Any:
    samples = Samples.from_array(np.ones((4, 5)), accuracy=rich((4, 5)))
    dataset = to_pyvista(samples)
    record = json.loads(dataset.field_data["accuracy"][0])
    change(record)
    dataset.field_data["accuracy"] = [json.dumps(record)]
    return dataset


def _outside(record: Any) -> None:
    gather = next(o for o in record["operators"] if o["kind"] == "Gather")
    gather["n_in"] = 1


def _axis(record: Any) -> None:
    next(o for o in record["operators"] if o["kind"] == "Stencil")["lattice"] = [2, 2]


def _order(record: Any) -> None:
    next(o for o in record["operators"] if o["kind"] == "Chain")["first"] = 99


@pytest.mark.parametrize(("change", "sentence"), [
    (_outside, "leads outside"),
    (_axis, "leads outside|damaged"),
    (_order, "does not come before it"),
    (lambda r: r.update(version=99), "knows 1: update it"),
    (lambda r: r.update(format="other"), "something else"),
    (lambda r: r["terms"][0].update(kind="magic"), "unknown to this version"),
    (lambda r: r["terms"][0].pop("unit"), "damaged"),
    (lambda r: r["operators"][0].update(kind="Pickle"), "not known to this version"),
    (lambda r: r["terms"][-1]["value"].update(type="|O"), "no part of a budget"),
    (lambda r: r["terms"][-1]["value"].update(shape=[7]), "damaged"),
    (lambda r: r["terms"][-1]["value"].update(array=4000), "cannot be read|damaged"),
])  # fmt: skip
def test_a_damaged_budget_is_refused_with_a_sentence(change: Any, sentence: str) -> None:
    with pytest.raises(ExchangeError, match=sentence):
        from_pyvista(damaged(change))


def test_arrays_that_are_not_there_are_refused() -> None:
    dataset = pv.ImageData(dimensions=(3, 3, 3))
    with pytest.raises(ExchangeError, match="no array of numbers lies on its points"):
        from_pyvista(dataset)
    dataset.cell_data["c"] = np.ones(8)
    with pytest.raises(ExchangeError, match="on cells lie c"):
        from_pyvista(dataset)
    dataset.point_data["p"] = np.ones(27)
    with pytest.raises(ExchangeError, match="'c' lies on cells"):
        from_pyvista(dataset, "c")
    with pytest.raises(ExchangeError, match="there is no array 'q'; on points lie p"):
        from_pyvista(dataset, "q")
    dataset.point_data["p_std"] = -np.ones(27)
    with pytest.raises(ExchangeError, match="standard deviations"):
        from_pyvista(dataset)
    with pytest.raises(ExchangeError, match="several blocks"):
        from_pyvista(pv.MultiBlock([dataset]))
    with pytest.raises(ExchangeError, match="no points"):
        from_pyvista(pv.PolyData())


def test_files_that_cannot_be_are_refused(tmp_path: Path) -> None:
    samples = Samples.from_array(np.ones((4, 5)), accuracy=EXACT)
    with pytest.raises(ExchangeError, match=r"saved as .vti, not .vtr: name it a.vti"):
        save(samples, tmp_path / "a.vtr")
    with pytest.raises(ExchangeError, match=r"saved as .vtp"):
        save(shape(), tmp_path / "a.vti")
    with pytest.raises(ExchangeError, match="give its samples"):
        to_pyvista(Model.between(samples))
    with pytest.raises(ExchangeError, match="is no data set"):
        to_pyvista(Value(value=1.0, accuracy=EXACT))
    with pytest.raises(ExchangeError, match="are not read here"):
        load(tmp_path / "a.obj")
    with pytest.raises(ExchangeError, match="there is no file"):
        load(tmp_path / "a.vti")


def test_a_file_cut_off_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.vti"
    save(Samples.from_array(np.ones((40, 50)), accuracy=EXACT), path)
    path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(ExchangeError, match=r"a\.vti"):
        load(path)
