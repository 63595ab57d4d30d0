"""The largest errors of a geometry: which, where, how large, in an order that never changes."""

from __future__ import annotations

import numpy as np
import pytest

from modules.accuracy_mappers.worst import Worst, worst
from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    Frame,
    Geometry,
    Identity,
    Model,
    Progress,
    Samples,
    Source,
    Term,
    bound,
    deviation,
)
from modules.mappers.contour import contour
from modules.modellers.interpolate import interpolate


def model(n: int = 30) -> Model:
    y, x = np.mgrid[0:n, 0:n] / n
    values = np.sin(9 * x) * np.cos(7 * y) + 0.3 * x
    frame = Frame(units=("m", "m", "m"))
    return interpolate(Samples.from_array(values, frame=frame, accuracy=EXACT.add(bound("rounding", 0.01, values.size))))


def listed(geometry: Geometry, **words: object) -> Worst:
    return worst(geometry, Progress(), **words)  # type: ignore[arg-type]  # any words


def test_the_largest_areas_and_where_they_are() -> None:
    lines = contour(model(), Progress(), levels=(0.2,), method="basic")
    got = listed(lines, count=7, quantity="area")
    (term,) = lines.accuracy.select("area")
    by_size = sorted(range(term.count), key=lambda i: (-term.size()[i], i))[:7]
    assert got.table.columns["item"].tolist() == by_size
    assert got.table.columns["size"].tolist() == [term.size()[i] for i in by_size]
    assert got.table.columns["rank"].tolist() == list(range(1, 8))
    assert set(got.table.columns["sign"]) == {"="}
    assert set(got.table.columns["unit"]) == {"m²"}
    assert got.table.units == {"x": "m", "y": "m", "z": "m", "size": "m²"}
    for row, i in enumerate(by_size):
        a, b = lines.segments()[i]
        where = [got.table.columns[c][row] for c in "xyz"]
        assert where == pytest.approx(((lines.points[a] + lines.points[b]) / 2).tolist(), rel=1e-15)
    assert np.array_equal(got.places.points, np.column_stack([got.table.columns[c] for c in "xyz"]))


def test_sources_of_one_quantity_are_ranked_together() -> None:
    lines = contour(model(), Progress(), levels=(0.2,))
    got = listed(lines, count=40)  # position, as nothing else is said
    assert set(got.table.columns["quantity"]) == {"position"}
    every = [(-s, k, i) for k, t in enumerate(lines.accuracy.select("position")) for i, s in enumerate(t.size()) if s > 0]
    wanted = sorted(every)[:40]
    names = [t.name for t in lines.accuracy.select("position")]
    assert got.table.columns["term"].tolist() == [names[k] for _, k, _ in wanted]
    assert got.table.columns["item"].tolist() == [i for _, _, i in wanted]


def two_lines(**accuracy: Term) -> Geometry:
    points = np.array([[0, 0, 0], [1, 0, 0], [3, 0, 0], [0, 5, 0], [0, 7, 0], [9, 9, 9]], float)
    cells = Cells.of([[0, 1, 2], [3, 4]])
    vertex = Cells.of([[5]])
    return Geometry(points=points, vertices=vertex, lines=cells, accuracy=EXACT.add(*accuracy.values()))


def test_ties_go_by_source_and_then_by_item() -> None:
    terms = [deviation(f"t{i}", s, 6, quantity="position") for i, s in enumerate(([1.0] * 6, [2, 1, 2, 2, 1, 0.0]))]
    got = listed(two_lines(a=terms[0], b=terms[1]), count=6)
    assert got.table.columns["term"].tolist() == ["t1", "t1", "t1", "t0", "t0", "t0"]
    assert got.table.columns["item"].tolist() == [0, 2, 3, 0, 1, 2]
    assert set(got.table.columns["sign"]) == {"~"}


def test_cells_are_vertices_then_lines_then_polygons() -> None:
    source = Source("s", "mapping", "proven", "r [s/1]")
    term = Term(source, "bound", "position", "", np.array([1.0, 3.0, 2.0]), Identity(3), "cell")
    got = listed(two_lines(a=term))
    assert np.column_stack([got.table.columns[c] for c in "xyz"]).tolist() == [[4 / 3, 0, 0], [0, 6, 0], [9, 9, 9]]
    assert got.table.columns["item"].tolist() == [1, 2, 0]


def test_points_of_their_own() -> None:
    source = Source("s", "mapping", "proven", "r [s/1]")
    own = np.array([[1.0, 2, 3], [4, 5, 6]])
    term = Term(source, "signed", "value", "K", np.array([0.5, -2.0]), Identity(2), "own", points=own)
    got = listed(two_lines(a=term), quantity="value")
    assert got.places.points.tolist() == [[4, 5, 6], [1, 2, 3]]
    assert got.table.columns["size"].tolist() == [2.0, 0.5]


def test_no_error_is_no_worst_place() -> None:
    none = listed(two_lines(a=bound("b", 0.0, 6, quantity="position")))
    assert none.table.rows == 0
    assert none.places.counts["point"] == 0
    assert not none.table.accuracy.flags


def test_errors_without_a_bound_come_last_and_are_counted() -> None:
    shape = two_lines(a=bound("b", [1, np.inf, 2, 0, 50, 0], 6, quantity="position"))
    got = listed(shape)
    assert got.table.columns["size"].tolist() == [2.0, 1.0, np.inf, 50.0]  # 50 is beyond the whole shape
    assert got.table.columns["item"].tolist() == [2, 0, 1, 4]
    (flag,) = got.table.accuracy.flags
    assert flag.words.startswith("2 of 6 errors of position have no bound or one beyond 15.6:")
    assert listed(shape, count=1).table.columns["size"].tolist() == [2.0]
    assert listed(shape, reach=60.0).table.columns["size"].tolist() == [50.0, 2.0, 1.0, np.inf]
    assert listed(shape, reach=1.5).table.columns["item"].tolist() == [0, 1, 2, 4]
    with pytest.raises(ValueError, match="above zero"):
        listed(shape, reach=0.0)


def test_everything_is_accounted_for() -> None:
    lines = contour(model(), Progress(), levels=(0.2,))
    for one in listed(lines):
        assert one.accuracy.accounted() == lines.accuracy.accounted()
        assert not one.accuracy.terms
        assert all(e.why for e in one.accuracy.ended.values())


def test_what_cannot_be_ranked_is_told() -> None:
    lines = contour(model(), Progress(), levels=(0.2,))
    with pytest.raises(ValueError, match="no error of 'speed' is known: there are errors of position"):
        listed(lines, quantity="speed")
    with pytest.raises(ValueError, match="nothing to rank"):
        listed(Geometry(points=np.zeros((1, 3)), accuracy=EXACT))
    with pytest.raises(ValueError, match="at least 1"):
        listed(lines, count=0)
    mixed = two_lines(a=bound("a", 1, 6, quantity="position", unit="m"), b=bound("b", 1, 6, quantity="position", unit="km"))
    with pytest.raises(ValueError, match="km, m"):
        listed(mixed)
    with pytest.raises(ValueError, match="wire the accuracy of the same geometry"):
        listed(lines, accuracy=Geometry(points=np.zeros((2, 3)), accuracy=Accuracy((bound("a", 1, 2),))).accuracy)
