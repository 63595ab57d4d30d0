"""What the thesis proposes to show of a triangle: the lines to G, and the area metric in the faces of its cell."""

from typing import Any

import numpy as np
import pytest

from modules import kernels
from modules.accuracy_mappers.centre_lines import centre_lines
from modules.accuracy_mappers.face_metric import face_metric
from modules.api import Accuracy, Model, Progress, Samples, bound, regular
from modules.mappers.isosurface import isosurface


def model(values: Any = None) -> Any:
    a = np.linspace(-1, 1, 6)
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    values = np.asarray(1 - x**2 - 0.7 * y**2 - 1.3 * z**2 + 0.4 * x * y * z if values is None else values)
    accuracy = Accuracy((bound("Half a unit", 0.01, values.size, unit="K"),))
    return Model.between(Samples(grid=regular(values.shape), values=values, unit="K", accuracy=accuracy))


def drawn(of: Any, level: float = 0.4, method: Any = "accurate") -> Any:
    return isosurface(of, Progress(), level=level, method=method)


class TestLinesToG:
    def test_three_lines_end_on_the_surface(self) -> None:
        field = model()
        surface = drawn(field)
        lines = centre_lines(surface, field, Progress())
        ends = lines.lines.connectivity.reshape(-1, 2)
        assert np.abs(field.at(lines.points[ends[:, 1]])[0] - 0.4).max() < 1e-9
        assert lines.origin is not None
        corners = surface.points[surface.triangles[lines.origin[::3]]].reshape(-1, 3)
        assert np.array_equal(lines.points[ends[:, 0]], corners)

    def test_the_number_is_the_proven_distance(self) -> None:
        field = model()
        surface = drawn(field, method="classic")
        lines = centre_lines(surface, field, Progress())
        assert lines.origin is not None
        known = np.asarray(surface.values["distance"].values)[lines.origin]
        assert np.array_equal(lines.accuracy.terms[0].size(), known)
        assert (np.asarray(lines.values["distance of G"].values) <= known * (1 + 1e-9)).mean() > 0.95

    def test_only_those_above(self) -> None:
        field = model()
        surface = drawn(field, method="classic")
        few = centre_lines(surface, field, Progress(), above=0.03)
        assert 0 < len(few.lines) < len(centre_lines(surface, field, Progress()).lines)
        assert np.asarray(few.values["distance"].values).min() > 0.03 * (surface.cell or 0)

    def test_the_law_of_the_budget(self) -> None:
        field = model()
        surface = drawn(field)
        lines = centre_lines(surface, field, Progress())
        assert surface.accuracy.accounted() | field.accuracy.accounted() <= lines.accuracy.accounted()


class TestFaceMetric:
    def test_it_is_the_area_between_side_and_arc(self) -> None:
        """Held against quadrature of the arc between the ends of a side, in one face."""
        values = np.array([0.0, 1.0, 2.0, 5.0, 1.0, 3.0, 3.0, 7.0]).reshape(2, 2, 2)
        axis = np.arange(2.0)
        field = kernels.mesh_proof.Field(values, axis, axis, axis, 1.5)
        made = kernels.straight.surface(values, axis, axis, axis, 1.5, "classic")
        sides = kernels.mesh_faces.areas(field, *made)
        points, triangles, _ = made
        seen = 0
        for t, side in zip(*np.nonzero(sides > 0), strict=True):
            p, q = points[triangles[t, side]], points[triangles[t, (side + 1) % 3]]
            if not p[2] == q[2] == 0.0:
                continue
            s = np.linspace(0, 1, 20001)
            x = p[0] + s * (q[0] - p[0])
            y = (1.5 - values[0, 0, 0] - x * (values[0, 0, 1] - values[0, 0, 0])) / (
                values[0, 1, 0] - values[0, 0, 0] + x * (values[0, 1, 1] - values[0, 1, 0] - values[0, 0, 1] + values[0, 0, 0])
            )
            gap = np.abs(y - (p[1] + s * (q[1] - p[1])))
            assert sides[t, side] == pytest.approx(np.trapezoid(gap, dx=abs(q[0] - p[0]) / 20000), rel=1e-6)
            seen += 1
        assert seen

    def test_a_cell_gives_the_sum_of_its_sides(self) -> None:
        field = model()
        surface = drawn(field)
        own = np.asarray(face_metric(surface, field, Progress()).values["face metric"].values)
        whole = np.asarray(face_metric(surface, field, Progress(), of="cell").values["face metric"].values)
        assert (own >= 0).all()
        assert (own <= whole * (1 + 1e-12) + 1e-15).all()
        assert own.max() > 0

    def test_a_plane_has_none(self) -> None:
        z, y, x = np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij")
        field = model(x + 2 * y + 0.5 * z)
        metric = face_metric(drawn(field, 4.2), field, Progress()).values["face metric"]
        assert np.asarray(metric.values).max() < 1e-12

    def test_what_is_known_of_the_surface_goes_on(self) -> None:
        field = model()
        surface = drawn(field)
        shown = face_metric(surface, field, Progress())
        assert {t.id for t in surface.accuracy.terms} <= {t.id for t in shown.accuracy.terms}
        assert surface.accuracy.accounted() | field.accuracy.accounted() <= shown.accuracy.accounted()

    def test_other_shapes_are_refused(self) -> None:
        field = model()
        dots = drawn(field, method="dividing")
        with pytest.raises(ValueError, match="wire the surface of 'isosurface'"):
            face_metric(dots, field, Progress())
