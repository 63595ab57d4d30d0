"""The methods with which the accurate isosurface is compared, and isosurfaces on other grids: each against a count."""

import functools
import itertools
from typing import Any

import numpy as np
import pytest

from modules.api import EXACT, Accuracy, Curvilinear, Model, Progress, Samples, Unstructured, bound
from modules.kernels import straight, tetrahedra
from modules.mappers._isosurface_methods import METHODS, open_edges
from modules.mappers.isosurface import isosurface
from modules.readers.corner_cell import corner_cell

CLOSED = [name for name in METHODS if name != "classic"]


def field(values: Any, law: str = "linear", spacing: Any = None) -> Any:
    return Model.between(Samples.from_array(values, spacing=spacing, accuracy=EXACT), law)


def drawn(model: Any, **parameters: Any) -> Any:
    return isosurface(model, Progress(), **parameters)


def ball(n: int = 12) -> Any:
    a = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    return field(0.6 - (x**2 + y**2 + z**2), spacing=2 / (n - 1))


def noise(seed: int = 0) -> Any:
    return field(np.pad(np.random.default_rng(seed).normal(size=(5, 5, 5)), 1, constant_values=-1.0))


def euler(g: Any) -> int:
    edges = np.unique(np.sort(g.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    return len(g.points) - len(edges) + len(g.triangles)


def volume(g: Any) -> float:
    p = g.points[g.triangles]
    return float(np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6)


@pytest.mark.parametrize("method", CLOSED)
class TestMethodsWithoutHoles:
    def test_a_ball_is_a_ball(self, method: str) -> None:
        g = drawn(ball(), level=0.0, method=method)
        assert euler(g) == 2
        assert not len(open_edges(g.points, g.triangles))
        assert volume(g) == pytest.approx(4 / 3 * np.pi * 0.6**1.5, rel=0.12)

    def test_noise_leaves_it_closed(self, method: str) -> None:
        g = drawn(noise(), level=0.0, method=method)
        ends = np.sort(g.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(ends, axis=0, return_counts=True)[1] % 2 == 0).all()

    def test_the_distance_it_states_holds(self, method: str) -> None:
        model = ball()
        g = drawn(model, level=0.0, method=method)
        reach = g.values["distance"].values
        radius = np.linalg.norm(g.points[g.triangles].mean(axis=1) - 1, axis=1)
        assert np.isfinite(reach).mean() > 0.95
        known = np.isfinite(reach)
        assert (np.abs(radius - np.sqrt(0.6))[known] <= reach[known] + 0.02).all()  # 0.02: of the trilinear model

    def test_it_does_not_claim_the_topology(self, method: str) -> None:
        g = drawn(ball(), level=0.0, method=method)
        assert any(m.name == "Topology of the surface" for m in g.accuracy.missing)


def test_classic_leaves_holes_and_counts_them() -> None:
    values = np.full((2, 2, 3), -1.0)
    # two corners on a diagonal of the common face, in a cell with two above and in one with six above
    values[:, :, 2] = 1.0
    values[0, 0, 1] = values[1, 1, 1] = 1.0
    g = drawn(field(values), level=0.0, method="classic")
    flag = next(f for f in g.accuracy.flags if f.name == "holes")
    assert flag.count == g.values["beside a hole"].values.sum() > 0
    inside = open_edges(g.points, g.triangles)
    on_face = (g.points[inside][:, :, 0] == 1).all(axis=1)
    assert on_face.sum() == 4, "the four sides of a hole in the common face"
    assert f"along {on_face.sum()} edges" in flag.words
    assert not len([f for f in drawn(field(values), level=0.0, method="decider").accuracy.flags if f.name == "holes"])


def test_classic_is_closed_where_no_face_is_ambiguous() -> None:
    g = drawn(ball(), level=0.0, method="classic")
    assert euler(g) == 2
    assert not g.values["beside a hole"].values.any()


def test_four_triangles_is_wrong_where_mean_and_saddle_differ() -> None:
    values = np.zeros((2, 2, 2))
    values[0] = [[15.0, 21.0], [24.0, 10.0]]  # figure 3.9: the centre is 17.5, the saddle 17.7
    values[1] = values[0]
    four, decider = (drawn(field(values), level=17.6, method=m) for m in ("four_triangles", "decider"))
    assert not np.array_equal(np.sort(four.triangles, axis=1), np.sort(decider.triangles, axis=1))
    assert euler(four) == euler(decider) == 2, "two sheets each, about the other pair of corners"


def test_discretized_has_few_directions() -> None:
    g = drawn(noise(), level=0.0, method="discretized")
    p, q, r = (g.points[g.triangles[:, k]] for k in range(3))
    normal = np.cross(q - p, r - p)
    assert len(np.unique(np.round(2 * g.points) / 2, axis=0)) == len(np.unique(g.points, axis=0))
    assert np.allclose(normal * 8, np.round(normal * 8))


def test_brute_force_comes_to_the_accurate_topology() -> None:
    model = Model.between(corner_cell(figure="4.29 b"))
    accurate = drawn(model, level=0.0)
    assert euler(accurate) == 0, "a tunnel"
    assert euler(drawn(model, level=0.0, method="decider")) == 2, "two caps"
    assert euler(drawn(model, level=0.0, method="subdivided", cuts=12)) == 0


def test_dividing_cubes_gives_points_within_half_a_diagonal() -> None:
    model = ball()
    g = drawn(model, level=0.0, method="dividing", cuts=3)
    assert len(g.vertices) == len(g.points) > 1000
    assert not len(g.polygons)
    half = g.values["distance"].values
    assert half == pytest.approx(np.sqrt(3) / 2 * 2 / 11 / 3)
    assert (np.abs(np.linalg.norm(g.points - 1, axis=1) - np.sqrt(0.6)) <= half + 0.02).all()
    finer = drawn(model, level=0.0, method="dividing", cuts=6)
    assert len(finer.points) == pytest.approx(4 * len(g.points), rel=0.1)


@pytest.mark.parametrize("cuts", [0, 2000])
def test_too_many_cuts_are_refused(cuts: int) -> None:
    with pytest.raises(ValueError, match=r"pieces|cuts"):
        drawn(ball(), level=0.0, method="subdivided", cuts=cuts)


def test_five_tetrahedra_fill_a_cell() -> None:
    for pieces in tetrahedra.PIECES:
        values = np.arange(27.0).reshape(3, 3, 3)
        axis = np.arange(3.0)
        nodes, cells, _, origin = tetrahedra.cut_grid(values, (axis, axis, axis), 13.5, pieces)
        size = np.abs(np.linalg.det(np.diff(nodes[cells], axis=1))) / 6
        for cell in np.unique(origin):
            assert (origin == cell).sum() == pieces
            assert size[origin == cell].sum() == pytest.approx(1.0)


def test_the_diagonals_of_tetrahedra_show() -> None:
    values = np.array([[[1.0, -1.0], [-1.0, 1.0]], [[1.0, -1.0], [-1.0, 1.0]]])  # figure 4.8: a face, two diagonals
    along, across = (drawn(field(v), level=0.1, method="tetrahedra_6") for v in (values, values[:, ::-1]))
    mirrored = np.where([False, True, False], 1 - across.points, across.points)
    apart = np.linalg.norm(along.points[:, None] - mirrored[None], axis=2).min(axis=1)
    assert apart.max() > 0.1, "a mirrored field gives another surface"


class TestProposition4121:
    """An extra vertex is needed just where a polygon has more than two loop-back faces, or two opposite ones."""

    def test_it_holds_for_every_polygon(self) -> None:
        needing = 0
        polygons = {
            loop
            for code, faces in itertools.product(range(1, 255), range(64))
            for loop in straight.loops(code, faces)
            if len(loop) < 12 or (code, faces) in occurring()
        }
        for loop in polygons:
            bent = loop_back_faces(loop)
            opposite = any(2 * a in bent and 2 * a + 1 in bent for a in range(3))
            assert (straight.cut(loop) is None) == (len(bent) > 2 or opposite), loop
            needing += straight.cut(loop) is None
        assert needing == 12 + 48 + 8, "P8/1 of 10.bd, P9/3 of 7.c and 13.de, P12/3 of 13.i"

    def test_chords_lie_in_no_face(self) -> None:
        for seed in range(3):
            g = drawn(noise(seed), level=0.0, method="decider")
            corner = g.points[g.triangles]
            flat = (corner == corner[:, :1]).all(axis=1) & (corner[:, 0] % 1 == 0)
            assert not flat.any()


@functools.cache
def occurring() -> Any:
    """Faces of configuration 13 as they occur in a trilinear cell: 46 of 64 patterns, for each of two signs."""
    size = np.abs(np.random.default_rng(1).normal(size=(40000, 8))) ** 3
    sign = np.array([1 if c.bit_count() % 2 else -1 for c in range(8)])
    found = set()
    for turn in (1, -1):
        value = turn * sign * size
        code = (value >= 0) @ (1 << np.arange(8))
        cells = straight.Active(np.arange(len(value)), np.zeros((len(value), 8), int), value, code)
        found |= set(zip(code.tolist(), straight.joined(cells, 0.0, "decider").tolist(), strict=True))
    assert len(found) == 2 * 46
    return found


def loop_back_faces(loop: Any) -> set[int]:
    """Faces with two sides of the polygon, by the edges alone."""
    faces = [straight.faces_of(e) & straight.faces_of(loop[(n + 1) % len(loop)]) for n, e in enumerate(loop)]
    flat = [f for common in faces for f in common]
    return {f for f in flat if flat.count(f) == 2}


class TestTetrahedralGrid:
    def grid(self) -> Any:
        points = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
        cells = tetrahedra._six()
        n = len(cells)
        return Unstructured(points, 4 * np.arange(n + 1), cells.ravel().astype(np.int64), np.full(n, 10))

    def model(self, values: Any) -> Any:
        return Model.between(Samples(grid=self.grid(), values=values, accuracy=Accuracy((bound("Half a unit", 0.01, 8),))))

    def test_a_linear_field_is_a_plane(self) -> None:
        points = self.grid().nodes
        g = drawn(self.model(points @ [1.0, 2.0, 3.0]), level=2.5)
        assert g.points @ [1.0, 2.0, 3.0] == pytest.approx(2.5)
        p, q, r = (g.points[g.triangles[:, k]] for k in range(3))
        normal = np.cross(q - p, r - p)
        assert (normal @ [1.0, 2.0, 3.0] < 0).all()
        assert any(t.name == "Triangles in tetrahedra" and t.source.rigour == "exact" for t in g.accuracy.terms)

    def test_errors_of_values_become_displacements(self) -> None:
        points = self.grid().nodes
        g = drawn(self.model(points @ [1.0, 2.0, 3.0]), level=2.5)
        term = next(t for t in g.accuracy.terms if t.name == "Half a unit")
        assert term.size() == pytest.approx(0.01 / np.sqrt(14))

    def test_other_cells_are_refused(self) -> None:
        grid = Unstructured(self.grid().nodes, np.array([0, 8]), np.arange(8), np.array([12]))
        with pytest.raises(ValueError, match="tetrahedra"):
            drawn(Model.between(Samples(grid=grid, values=np.arange(8.0), accuracy=EXACT)), level=2.5)


class TestBentGrid:
    """A ball between two radii, in spherical coordinates: F = radius, so the surface is a sphere."""

    def model(self, n: int = 12, turned: bool = False) -> Any:
        r, theta, phi = np.linspace(0.5, 1.5, n), np.linspace(0.6, 2.4, n), np.linspace(0, 1.5, n)
        p, t, a = np.meshgrid(phi, theta, r[::-1] if turned else r, indexing="ij")
        nodes = np.stack([a * np.sin(t) * np.cos(p), a * np.sin(t) * np.sin(p), a * np.cos(t)], axis=-1)
        accuracy = Accuracy((bound("Half a unit", 0.01, a.size),))
        return Model.between(Samples(grid=Curvilinear(nodes), values=a, accuracy=accuracy))

    @pytest.mark.parametrize("turned", [False, True])
    def test_a_sphere(self, turned: bool) -> None:
        g = drawn(self.model(turned=turned), level=0.93)
        radius = np.linalg.norm(g.points, axis=1)
        assert radius == pytest.approx(0.93, abs=0.01)
        p, q, r = (g.points[g.triangles[:, k]] for k in range(3))
        assert (np.einsum("ij,ij->i", np.cross(q - p, r - p), p) < 0).all(), "to the low side, inwards"
        term = next(t for t in g.accuracy.terms if t.name == "Half a unit")
        assert term.size() == pytest.approx(0.01, rel=0.02)

    def test_its_distance_is_estimated_and_holds(self) -> None:
        g = drawn(self.model(), level=0.93)
        middle = g.points[g.triangles].mean(axis=1)
        # from the images of the lattice's plane radius = 0.93, a bilinear patchwork beneath the sphere
        away = np.abs(np.linalg.norm(middle, axis=1) - np.linalg.norm(g.points, axis=1).mean())
        assert np.nanmax(g.values["distance"].values) < 0.02
        assert away.max() < 0.02
        source = next(t.source for t in g.accuracy.terms if t.name.startswith("Triangles instead"))
        assert source.rigour == "estimated"


class TestCubicModel:
    def values(self, n: int) -> Any:
        a = np.linspace(-1, 1, n)
        z, y, x = np.meshgrid(a, a, a, indexing="ij")
        return np.exp(-(x**2 + y**2 + z**2))

    def test_it_is_nearer_to_a_smooth_truth_than_the_linear_model(self) -> None:
        level, spacing = 0.6, 2 / 8
        radius = np.sqrt(-np.log(level))
        points = {law: drawn(field(self.values(9), law, spacing), level=level).points for law in ("linear", "cubic")}
        off = {law: np.abs(np.linalg.norm(at - 1, axis=1) - radius).max() for law, at in points.items()}
        assert off["cubic"] < 0.25 * off["linear"]

    def test_the_pieces_are_a_term_of_their_own(self) -> None:
        model = field(self.values(9), "cubic", 2 / 8)
        g = drawn(model, level=0.6)
        term = next(t for t in g.accuracy.terms if t.name == "Cubic field in trilinear pieces")
        exact = np.abs(model.at(g.points)[0] - 0.6)  # of the pieces' vertices
        slope = np.linalg.norm(model.gradient(g.points)[0], axis=1)
        assert np.quantile(exact / slope, 0.9) < 2 * np.quantile(term.size(), 0.9) + 1e-6
        assert model.accuracy.accounted() <= g.accuracy.accounted()
        assert g.values["grid cell"].values.max() < 8**3


def test_a_nearest_model_is_refused() -> None:
    with pytest.raises(ValueError, match="nearest"):
        drawn(field(np.zeros((3, 3, 3)), "nearest"))


