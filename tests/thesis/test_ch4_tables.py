"""Tables 4.1 to 4.7: kinds of cells by enumeration, and statistics of any volume against the mesh and the thesis's numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Model, Samples, bound
from modules.data.accuracy import Accuracy
from modules.kernels import cell_types, marching, trilinear
from modules.mappers.cell_statistics import cell_statistics
from modules.readers.cell_tables import cell_tables
from modules.readers.corner_cell import CELLS, corner_cell
from tests.oracles import topology

HEAD = Path(__file__).resolve().parents[3] / "shared" / "data" / "headsq"


def numbers(table: Any) -> dict[str, int]:
    return dict(zip(table.columns["name"].tolist(), table.columns["number"].tolist(), strict=True))


def random_model(seed: int = 0, shape: Any = (9, 9, 9)) -> Any:
    values = np.random.default_rng(seed).normal(size=shape)
    accuracy = Accuracy((bound("Half a unit", 0.01, values.size),))
    return Model.between(Samples.from_array(values, accuracy=accuracy))


class TestEnumeration:
    def test_256_patterns_are_14_configurations(self) -> None:
        found = [cell_types.configuration(code) for code in range(256)]
        assert sorted(set(found)) == list(range(14))
        assert [found.count(n) for n in range(14)] == [2, 16, 24, 24, 8, 48, 48, 16, 6, 8, 6, 24, 24, 2]

    def test_configurations_are_classes_under_the_group_of_the_cube(self) -> None:
        corner = np.array([[c >> 2, c >> 1 & 1, c & 1] for c in range(8)])
        random = np.random.default_rng(0)
        for code in range(256):
            moved = corner[:, random.permutation(3)] ^ random.integers(0, 2, 3)
            other = sum((code >> c & 1) << int(moved[c] @ [4, 2, 1]) for c in range(8))
            assert cell_types.configuration(code) == cell_types.configuration(other) == cell_types.configuration(255 - other)

    def test_table_4_1(self) -> None:
        table = cell_tables(table="4.1")
        kinds = cell_types.kinds()
        assert len(kinds) == table.rows
        rows = set(zip(table.columns["configuration"].tolist(), table.columns["polygons"].tolist(), strict=True))
        assert len(rows) == table.rows == 24 == len({(k.configuration, k.polygons) for k in kinds})
        wanted = {(3, "P6/1"), (6, "P7/1"), (7, "P9/3"), (10, "P8/1"), (12, "P8/2"), (13, "P12/3"), (13, "P3/0 P3/0 P6/0")}
        assert wanted <= rows
        tunnel = table.columns["tunnel"] == "yes"
        assert sorted(table.columns["configuration"][tunnel].tolist()) == [4, 6, 7, 10, 12, 13]

    def test_46_patterns_of_faces_of_configuration_13(self) -> None:
        kinds = [k for k in cell_types.kinds() if k.configuration == 13]
        assert sum(k.patterns for k in kinds) == 2 * 46

    def test_tables_4_2_and_4_3(self) -> None:
        loop_back, plain = cell_tables(table="4.2"), cell_tables(table="4.3")
        assert loop_back.columns["polygon"].tolist() == ["P6/1", "P7/1", "P8/1", "P8/2", "P9/3", "P12/3"]
        assert loop_back.columns["triangles"].tolist() == [12, 14, 16, 18, 22, 34]
        assert plain.columns["triangles"].tolist() == [6, 8, 10, 12]
        assert loop_back.columns["configurations"].tolist() == ["3 7 13", "6", "10", "12", "7 13", "13"]

    def test_table_4_4(self) -> None:
        table = cell_tables(table="4.4")
        assert table.columns["configurations"].tolist() == ["4", "6", "12", "7 13", "10"]
        assert table.columns["triangles"].tolist() == [24, 26, 28, 30, 28]


class TestStatistics:
    def test_table_4_5_the_mesh_has_as_many_triangles(self) -> None:
        for seed in range(3):
            model = random_model(seed)
            table = cell_statistics(model, level=0.1).table
            axis = np.arange(9.0)
            drawn = marching.surface(model.samples.values, axis, axis, axis, 0.1)
            told = numbers(table)
            assert told["cells"] == 8**3 == told["empty cells"] + told["cells passed"]
            assert told["cells passed"] == len(np.unique(drawn.cell))
            triangles = dict(zip(table.columns["name"].tolist(), table.columns["triangles"].tolist(), strict=True))
            assert triangles["cells"] == len(drawn.triangles)
            assert told["tunnels"] == drawn.tunnels > 0
            polygons = [n for n in triangles if n.startswith("P")]
            assert sum(triangles[n] for n in polygons) == len(drawn.triangles)

    def test_table_4_7_is_4_6_as_shares(self) -> None:
        table = cell_statistics(random_model(), level=0.1).table
        share = dict(zip(table.columns["name"].tolist(), table.columns["share"].tolist(), strict=True))
        assert sum(v for n, v in share.items() if n.startswith("P")) == pytest.approx(100)

    @pytest.mark.parametrize("figure", list(CELLS))
    def test_worked_cells(self, figure: Any) -> None:
        found = cell_statistics(Model.between(corner_cell(figure=figure)), level=0.0)
        told = numbers(found.table)
        tunnel = figure in ("4.11", "4.29 b", "4.31", "4.32", "4.33", "4.34", "tunnel of configuration 13")
        assert told["tunnels"] == int(tunnel)
        assert len(found.places.points) == int(tunnel)

    def test_places_are_the_cells(self) -> None:
        model = random_model()
        for show in ("tunnels", "ambiguous", "classic wrong", "means wrong", "saddle test wrong"):
            found = cell_statistics(model, level=0.1, show=show)
            name = "ambiguous cells" if show == "ambiguous" else show
            assert len(found.places.points) == numbers(found.table)[name]
            cell = found.places.values["grid cell"].values
            row, i = np.divmod(cell, 8)
            assert np.array_equal(found.places.points[:, 0], i + 0.5)
            assert np.array_equal(found.places.points[:, 2], row // 8 + 0.5)

    def test_what_comes_in_is_accounted_for(self) -> None:
        model = random_model()
        found = cell_statistics(model)
        assert model.accuracy.accounted() <= found.table.accuracy.accounted()
        assert found.table.accuracy.rigour("number") == "unknown" or not model.accuracy.missing

    def test_what_cannot_be_counted_is_refused(self) -> None:
        with pytest.raises(ValueError, match="3 dimensions"):
            cell_statistics(Model.between(Samples.from_array(np.zeros((3, 3)), accuracy=EXACT)))
        with pytest.raises(ValueError, match="linear"):
            cell_statistics(Model.between(random_model().samples, "nearest"))

    def test_an_empty_level(self) -> None:
        found = cell_statistics(random_model(), level=99.0)
        assert numbers(found.table)["cells passed"] == 0 == len(found.places.points)


class TestNatarajan:
    """The body saddle is no criterion of its own (4.1.1); held to parts of one side it agrees with the inflection points."""

    def test_a_saddle_within_is_no_tunnel(self) -> None:
        value = np.random.default_rng(3).normal(size=(20000, 8))
        known = cell_types.cells(np.ascontiguousarray(value[:400].reshape(-1, 2, 2)), 0.0)
        f = known.active.value
        saddle = trilinear.inside(trilinear.body_saddles(f)).any(axis=1)
        assert (saddle & ~known.tunnel).sum() > known.tunnel.sum() > 0

    def test_where_it_says_another_thing_it_is_wrong(self) -> None:
        random = np.random.default_rng(4)
        tunnels, wrong, ours = 0, [], []
        for _ in range(4):
            known = cell_types.cells(random.normal(size=(12, 12, 12)), 0.0)
            tunnels += int(known.tunnel.sum())
            wrong.append(known.active.value[known.saddle_wrong])
            ours.append(known.tunnel[known.saddle_wrong])
        corner, told = np.concatenate(wrong).reshape(-1, 2, 2, 2), np.concatenate(ours)
        assert 0 < len(corner) < tunnels / 2
        for k in (16, 32, 64, 128):  # finer where thin parts need it
            chi, pieces = topology.truth(corner, 0.0, k)
            corner, told = corner[(chi < pieces) != told], told[(chi < pieces) != told]
            if not len(corner):
                return
        pytest.fail(f"the inflection points are wrong in {corner.reshape(-1, 8).tolist()}")


def test_one_discriminant_for_three_quadratics() -> None:
    f = np.random.default_rng(5).normal(size=(2000, 8))
    known = trilinear.inflections(f)
    real = np.asarray(np.isfinite(known).reshape(len(f), 3, -1).all(axis=2))
    assert np.array_equal(real[:, 0], real[:, 1])
    assert np.array_equal(real[:, 0], trilinear.discriminant(f) > 0)


def test_body_saddles_have_no_slope() -> None:
    f = np.random.default_rng(6).normal(size=(2000, 8))
    saddle = trilinear.body_saddles(f)
    near = np.isfinite(saddle).all(axis=2) & (np.abs(saddle) < 5).all(axis=2)
    assert near.sum() > 500
    assert np.abs(trilinear.gradient(f, saddle)[near]).max() < 1e-9


def test_the_hexagon_lies_on_the_surface() -> None:
    f = np.random.default_rng(7).normal(size=(3000, 8))
    f = f[np.flatnonzero(trilinear.inner_inflections(f).reshape(-1, 6).all(axis=1))]
    corner = trilinear.hexagon(f)
    assert len(corner) > 10
    following = np.roll(corner, -1, axis=1)
    assert ((np.abs(corner - following) > 1e-9).sum(axis=2) == 1).all()
    for t in (0.25, 0.5, 0.9):
        on = trilinear.value(f, (1 - t) * corner + t * following)
        assert np.abs(on).max() < 1e-9


@pytest.mark.skipif(not HEAD.is_dir(), reason="the CT head is not here: ../shared/data is absent")
def test_the_ct_head() -> None:
    values = np.stack([np.fromfile(HEAD / f"quarter.{n}", "<u2").reshape(64, 64) for n in range(1, 94)]).astype(float)
    told = numbers(cell_statistics(Model.between(Samples.from_array(values, accuracy=EXACT)), level=1150.5).table)
    assert (told["cells passed"], told["ambiguous cells"], told["tunnels"]) == (38436, 892, 6)


def test_table_4_5_the_weights_of_the_polygons() -> None:
    assert [cell_types.triangles_of(name) for name in cell_types.KNOWN] == [6, 8, 10, 12, 12, 14, 16, 18, 22, 34]
