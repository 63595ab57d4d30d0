"""Grids as lines: every edge of every cell, once, through the samples."""

from __future__ import annotations

import numpy as np
import pytest

from modules.api import EXACT, Geometry, Samples, Unstructured, bound
from modules.mappers.grid_lines import grid_lines
from modules.readers.analytic import analytic

Edge = frozenset[int]


def edges(lines: Geometry) -> list[Edge]:
    return [frozenset(pair) for pair in lines.segments().tolist()]


def lattice_edges(shape: tuple[int, ...]) -> set[Edge]:
    """Neighbours along each axis, from the indices alone."""
    index = np.arange(np.prod(shape)).reshape(shape)
    pairs = [
        np.stack([index.take(range(n - 1), a).ravel(), index.take(range(1, n), a).ravel()], 1) for a, n in enumerate(shape)
    ]
    return {frozenset(pair) for pair in np.concatenate(pairs).tolist()}


@pytest.mark.parametrize("grid", ["regular", "rectilinear", "curvilinear"])
@pytest.mark.parametrize("samples", [(5,), (4, 6), (3, 4, 5)])
def test_lattices_of_any_dimension(grid: str, samples: tuple[int, ...]) -> None:
    if grid == "curvilinear" and len(samples) == 1:
        return
    field = analytic(formula="x", low=(0, 0, 0), high=(1, 2, 3), samples=samples, grid=grid)  # type: ignore[arg-type]  # a word
    got = grid_lines(field)
    found = edges(got)
    assert len(found) == len(set(found))
    assert set(found) == lattice_edges(field.grid.shape)
    assert np.array_equal(got.points, field.grid.points())
    axis = got.values["axis"].values
    assert [int((axis == a).sum()) for a in range(len(samples))] == [int(np.prod(samples)) // n for n in samples]


def test_every_third_line_and_the_last() -> None:
    field = analytic(samples=(8, 11))
    got = grid_lines(field, every=3)
    x, y = (np.unique(c.round(9)) for c in field.grid.points().T[:2])
    rows = sorted({line[0, 1].round(9) for line in got.polylines() if np.ptp(line[:, 1]) < 1e-12})
    columns = sorted({line[0, 0].round(9) for line in got.polylines() if np.ptp(line[:, 0]) < 1e-12})
    assert rows == y[[0, 3, 6, 9, 10]].tolist()
    assert columns == x[[0, 3, 6, 7]].tolist()


def test_triangles_share_their_edges() -> None:
    field = analytic(samples=(6, 5), grid="triangles")
    assert isinstance(field.grid, Unstructured)
    found = edges(grid_lines(field))
    cells = field.grid.connectivity.reshape(-1, 3)
    assert set(found) == {frozenset(p) for c in cells.tolist() for p in ((c[0], c[1]), (c[1], c[2]), (c[2], c[0]))}
    assert len(found) == len(set(found))
    assert len(field.grid.nodes) - len(found) + len(cells) == 1  # Euler: a disc


KINDS = [(3, 2, 1), (5, 3, 3), (9, 4, 4), (10, 4, 6), (12, 8, 12), (13, 6, 9), (14, 5, 8)]


@pytest.mark.parametrize(("kind", "size", "count"), KINDS)
def test_cells_of_each_kind(kind: int, size: int, count: int) -> None:
    nodes = np.random.default_rng(0).normal(size=(size + 1, 3))
    grid = Unstructured(nodes=nodes, offsets=np.array([0, size]), connectivity=np.arange(1, size + 1), types=np.array([kind]))
    got = grid_lines(Samples(grid=grid, values=np.zeros(size + 1), accuracy=EXACT))
    assert len(got.lines) == count
    solid = np.bincount(got.segments().ravel(), minlength=size + 1)
    assert solid[0] == 0
    assert {3: {1}, 5: {2}, 9: {2}, 10: {3}, 12: {3}, 13: {3}, 14: {3, 4}}[kind] == set(solid[1:].tolist())


def test_values_end_and_positions_go_on() -> None:
    values = np.arange(12.0).reshape(3, 4)
    accuracy = EXACT.add(bound("rounding", 0.5, 12), bound("survey", 0.1, 12, quantity="position"))
    samples = Samples.from_array(values, name="height", unit="m", accuracy=accuracy)
    got = grid_lines(samples)
    assert {t.name for t in got.accuracy.terms} == {"survey", "Lines of the regular grid"}
    assert got.accuracy.accounted() >= samples.accuracy.accounted()
    assert got.values["height"].values.tolist() == values.ravel().tolist()
    assert got.values["height"].unit == "m"


def test_what_cannot_be_drawn_is_told() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        grid_lines(analytic(), every=0)
    grid = Unstructured(nodes=np.zeros((2, 3)), offsets=np.array([0, 2]), connectivity=np.arange(2), types=np.array([21]))
    with pytest.raises(ValueError, match="type 21"):
        grid_lines(Samples(grid=grid, values=np.zeros(2), accuracy=EXACT))
