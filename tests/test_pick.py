"""Picking without drawing: the pixel that VTK draws is the thing that is met, and the read-out is the algebra of accuracy."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from app.draw.sight import Sight
from app.pick import Hit, pick
from app.readout import read_out
from app.viewport import Viewport, off_screen
from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    ImageLook,
    Layer,
    LineLook,
    PointLook,
    Samples,
    Scene,
    SceneLook,
    Shown,
    Source,
    SurfaceLook,
    Table,
    Term,
    bound,
    deviation,
    unknown,
)
from modules.data.operators import Spread
from modules.data.scene import ChartLook

SIZE = (200, 150)


@pytest.fixture(scope="module")
def plotter() -> Iterator[Any]:
    made = off_screen(SIZE)
    made.render_window.SetMultiSamples(0)
    yield made
    made.close()


@pytest.fixture
def port(plotter: Any) -> Iterator[Viewport]:
    plotter.renderer.RemoveAllViewProps()
    yield Viewport(plotter)


def scene(*layers: Layer, **look: Any) -> Scene:
    return Scene(layers=layers, look=SceneLook(**{"axes": False, **look}), accuracy=EXACT)


def layer(shape: Any, look: Any, **more: Any) -> Layer:
    return Layer(shape=shape, look=look, accuracy=getattr(shape, "accuracy", EXACT), **more)


def sheet(seed: int = 3, n: int = 7, high: float = 1.0) -> Geometry:
    """A bumpy surface of triangles, each with a number."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    points = np.column_stack([x.ravel(), y.ravel(), high * random.random(n * n)]).astype(float)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.column_stack([a, a + 1, a + n]), np.column_stack([a + 1, a + n + 1, a + n])])
    return Geometry(points=points, polygons=Cells.of(triangles), accuracy=EXACT)


# --- the camera in numbers


@pytest.mark.parametrize("parallel", [False, True])
def test_the_camera_in_numbers_is_the_camera_of_vtk(port: Viewport, parallel: bool) -> None:
    port.show(scene(layer(sheet(), SurfaceLook()), dimensions=3, exaggeration=2.0))
    port.camera = {**port.camera, "parallel": parallel, "position": [-4.0, -9.0, 7.0], "up": [0.1, 0.2, 1.0]}
    points = np.random.default_rng(1).random((40, 3)) * 6
    sight = Sight(port.camera, SIZE)
    pixels, depth = sight.pixels(points)
    assert np.allclose(pixels, port.project(points) * SIZE, atol=1e-6)
    back = [sight.place(float(x), float(y), float(d)) for (x, y), d in zip(pixels, depth, strict=True)]
    assert np.allclose(back, points, atol=1e-9)


def test_what_lies_behind_the_eye_has_no_pixel() -> None:
    camera = {"position": [0, 0, 5], "focal": [0, 0, 0], "up": [0, 1, 0], "angle": 30.0, "height": 1.0, "parallel": False}
    pixels, depth = Sight(camera, SIZE).pixels(np.array([[0.0, 0.0, 9.0], [0.0, 0.0, 0.0]]))
    assert np.isnan(pixels[0]).all() and np.isnan(depth[0])
    assert pixels[1] == pytest.approx([100, 75]) and depth[1] == pytest.approx(5)


# --- what is met


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_triangle_that_is_met_is_the_one_that_is_drawn(port: Viewport, dimensions: int) -> None:
    shape = sheet()
    shown = scene(layer(shape, SurfaceLook(smooth=False)), dimensions=dimensions, exaggeration=3.0 if dimensions == 3 else 1.0)
    port.show(shown)
    actor = port._drawn[0].props[0]
    number = np.arange(len(shape.polygons))
    from app.draw import meshes
    data = meshes.surface_of(shape)
    colours = np.column_stack([number * 3 % 256, number * 3 // 256 * 50, 255 - number]).astype(np.uint8)
    meshes.attach(data, colours, "cell")
    mapper = actor.GetMapper()
    mapper.SetInputData(data)
    mapper.SetColorModeToDirectScalars()
    mapper.ScalarVisibilityOn()
    prop = actor.GetProperty()
    prop.LightingOff()
    prop.SetAmbient(0.0)
    prop.SetDiffuse(1.0)
    pixels = port.pixels()
    met = 0
    for x in range(10, SIZE[0], 9):
        for y in range(7, SIZE[1], 9):
            window = pixels[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
            hit = pick(shown, port.camera, SIZE, (x + 0.5, y + 0.5))
            if hit is None:
                assert not (window == colours[:, None].astype(window.dtype)).all(axis=2).any(axis=0).all()
                continue
            met += 1
            assert (window == colours[hit.cell]).all(axis=1).any(), (x, y, hit.cell)
            assert Sight(port.camera, SIZE).pixels(np.array([hit.at]) * [1, 1, 3.0 if dimensions == 3 else 1.0])[0][0] == (
                pytest.approx([x + 0.5, y + 0.5], abs=0.01)
            )
    assert met > 60


def test_weights_are_barycentric_and_bring_the_points_to_the_place(port: Viewport) -> None:
    shape = sheet()
    shown = scene(layer(shape, SurfaceLook()), dimensions=3, exaggeration=4.0)
    port.show(shown)
    hit = pick(shown, port.camera, SIZE, (100.0, 75.0))
    assert hit is not None and hit.kind == "polygon"
    assert sum(hit.weights) == pytest.approx(1) and min(hit.weights) >= 0
    assert np.asarray(hit.weights) @ shape.points[list(hit.points)] == pytest.approx(hit.at)
    assert set(hit.points) == set(shape.triangles[hit.cell])


def test_polygons_of_more_corners_and_cells_before_them_keep_their_numbers(port: Viewport) -> None:
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [8, 0, 0], [8, 4, 0], [6, 6, 0]], float)
    shape = Geometry(
        points=points, vertices=Cells.of([[0], [1]]), lines=Cells.of([[0, 1, 2]]),
        polygons=Cells.of([[0, 1, 2, 3], [1, 4, 5, 6, 2]]), accuracy=EXACT,
    )  # fmt: skip
    shown = scene(layer(shape, SurfaceLook()))
    port.show(shown)
    for place, cell in (((1.0, 3.0, 0.0), 3), ((3.9, 0.1, 0.0), 3), ((7.0, 3.0, 0.0), 4), ((6.0, 5.5, 0.0), 4)):
        x, y = port.project(np.array([place]))[0] * SIZE
        hit = pick(shown, port.camera, SIZE, (x, y))
        assert hit is not None and hit.cell == cell and hit.at == pytest.approx(place, abs=1e-6)


def test_lines_are_met_within_reach_and_in_front_of_surfaces_only(port: Viewport) -> None:
    over = Geometry(points=np.array([[1, 3, 2.0], [5, 3, 2.0]]), lines=Cells.of([[0, 1]]), accuracy=EXACT)
    under = Geometry(points=np.array([[1, 2, -0.5], [5, 2, -0.5]]), lines=Cells.of([[0, 1]]), accuracy=EXACT)
    shown = scene(layer(sheet(), SurfaceLook()), layer(over, LineLook()), layer(under, LineLook()), dimensions=3)
    port.show(shown)
    x, y = port.project(np.array([[2.0, 3.0, 2.0]]))[0] * SIZE
    near = pick(shown, port.camera, SIZE, (x, y + 3))
    assert near is not None and near.layer == 1 and near.off == pytest.approx(3, abs=0.6)
    assert near.at == pytest.approx((2.0, 3.0, 2.0), abs=0.2)
    x, y = port.project(np.array([[2.0, 2.0, -0.5]]))[0] * SIZE
    hidden = pick(shown, port.camera, SIZE, (x, y))
    assert hidden is not None and hidden.kind == "polygon"


def test_a_line_on_a_surface_is_not_hidden_by_it(port: Viewport) -> None:
    shape = sheet(high=0.2)
    row = np.arange(7) + 21
    on = Geometry(points=shape.points, lines=Cells.of(row[None]), accuracy=EXACT)
    shown = scene(layer(shape, SurfaceLook()), layer(on, LineLook()), dimensions=3)
    port.show(shown)
    for part in (0.5, 2.5, 4.25):
        left = int(part)
        place = shape.points[row[left]] * (1 - (part - left)) + shape.points[row[left + 1]] * (part - left)
        hit = pick(shown, port.camera, SIZE, tuple(port.project(place[None])[0] * SIZE))
        assert hit is not None and hit.kind == "line" and hit.segment == left
        assert hit.at == pytest.approx(place, abs=1e-6)


def test_shares_along_a_line_are_right_in_perspective(port: Viewport) -> None:
    far = Geometry(points=np.array([[0, 0, 0], [0, 100.0, 0]]), lines=Cells.of([[0, 1]]), accuracy=EXACT)
    shown = scene(layer(far, LineLook()), dimensions=3)
    port.show(shown)
    port.camera = {**port.camera, "position": [3.0, -10.0, 4.0], "focal": [0.0, 20.0, 0.0], "angle": 40.0}
    for share in (0.1, 0.5, 0.9):
        x, y = port.project(np.array([[0, 100 * share, 0]]))[0] * SIZE
        hit = pick(shown, port.camera, SIZE, (x, y))
        assert hit is not None and hit.weights[1] == pytest.approx(share, abs=1e-6)


def test_in_the_plane_the_last_layer_lies_on_top(port: Viewport) -> None:
    low = Samples.from_array(np.arange(12.0).reshape(3, 4), name="height", unit="m", accuracy=EXACT)
    dots = Geometry(points=np.array([[1.0, 1.0, 0.0]]), vertices=Cells.of([[0]]), accuracy=EXACT)
    cover = Geometry(points=np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0.0]]), polygons=Cells.of([[0, 1, 2]]), accuracy=EXACT)
    for layers, kinds in (
        ((layer(low, ImageLook(relief=True)), layer(dots, PointLook())), "vertex"),
        ((layer(low, ImageLook(relief=True)), layer(dots, PointLook()), layer(cover, SurfaceLook())), "polygon"),
        ((layer(low, ImageLook(relief=True)), layer(dots, PointLook()), layer(cover, SurfaceLook(opacity=0.3))), "vertex"),
    ):
        shown = scene(*layers)
        port.show(shown)
        hit = pick(shown, port.camera, SIZE, tuple(port.project(np.array([[0.99, 0.99, 0.0]]))[0] * SIZE))
        assert hit is not None and hit.kind == kinds


def test_an_image_gives_the_samples_around(port: Viewport) -> None:
    values = np.arange(12.0).reshape(3, 4)
    values[2, 3] = np.nan
    shape = Samples.from_array(values, name="height", unit="m", accuracy=EXACT)
    shown = scene(layer(shape, ImageLook(relief=True)))
    port.show(shown)

    def at(x: float, y: float, picked: Scene = shown) -> Hit | None:
        return pick(picked, port.camera, SIZE, tuple(port.project(np.array([[x, y, 0.0]]))[0] * SIZE))

    hit = at(1.25, 0.5)
    assert hit is not None and hit.points == (1, 2, 5, 6) and hit.cell == 1
    assert hit.weights == pytest.approx((0.375, 0.125, 0.375, 0.125), abs=1e-6)
    words = read_out(shown.layers[0], hit)
    assert words.values == (("height", "3.25\u00a0m"),)
    assert words.lines[-1].sign == "?" and "no law is stated" in words.lines[-1].words
    assert at(2.8, 1.9) is None and at(-0.2, 1.0) is None
    boxes = scene(layer(shape, ImageLook(relief=True, interpolate=False)))
    nearest = at(1.25, 0.4, boxes)
    assert nearest is not None and (nearest.points, nearest.weights) == ((1,), (1.0,))
    assert not read_out(boxes.layers[0], nearest).lines


def test_a_chart_gives_its_row(port: Viewport) -> None:
    table = Table(
        columns={"t": np.arange(5.0), "v": np.arange(5.0) ** 2}, units={"v": "m"},
        accuracy=Accuracy((bound("Clock", 0.04, 5, quantity="v", unit="m"),)),
    )  # fmt: skip
    shown = scene(layer(table, ChartLook()))
    port.show(shown)
    hit = pick(shown, port.camera, SIZE, tuple(port.project(np.array([[3.0, 9.0, 0.0]]))[0] * SIZE))
    assert hit is not None and (hit.kind, hit.cell) == ("row", 3)
    assert dict(read_out(shown.layers[0], hit).values)["v"] == "9.000\u00a0m"


def test_the_bare_view_gives_nothing_and_work_can_be_stopped(port: Viewport) -> None:
    shown = scene(layer(sheet(), SurfaceLook()), dimensions=3)
    port.show(shown)
    assert pick(shown, port.camera, SIZE, (1.0, 1.0)) is None

    def stop(fraction: float) -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        pick(shown, port.camera, SIZE, (100.0, 75.0), check=stop)


# --- what is said of it


def cloth(*terms: Term, **more: Any) -> Layer:
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 1], [0, 4, 0]], float)
    shape = Geometry(points=points, polygons=Cells.of([[0, 1, 2], [0, 2, 3]]), name="cloth",
                     accuracy=Accuracy(terms, **more))  # fmt: skip
    return layer(shape, SurfaceLook())


HERE = Hit(0, "polygon", 1, (0, 2, 3), (0.5, 0.3, 0.2), (1.2, 2.0, 0.3))


def test_bounds_go_through_the_weights_and_deviations_add_in_squares() -> None:
    sizes = np.array([1.0, 9.0, 2.0, 4.0])
    one = cloth(bound("A", sizes, 4, quantity="position", unit="m"), deviation("B", sizes, 4, quantity="position", unit="m"))
    out = read_out(one, HERE, k=3.0)
    a = 0.5 * 1 + 0.3 * 2 + 0.2 * 4
    b = 3.0 * np.sqrt((0.5 * 1) ** 2 + (0.3 * 2) ** 2 + (0.2 * 4) ** 2)
    found = {line.words: line for line in out.lines}
    assert found["A"].value == pytest.approx(a) and found["B"].value == pytest.approx(b)
    assert (found["A"].sign, found["B"].sign) == ("≤", "~") and found["B"].number.startswith("±")
    assert out.totals[0].value == pytest.approx(a + b) and out.totals[0].sign == "~"
    each = one.accuracy.total(3.0, "position", "point")  # what a point-wise reading would say is more
    assert out.totals[0].value < np.asarray(HERE.weights) @ each[[0, 2, 3]]


def test_an_error_that_all_points_share_stays_whole() -> None:
    shared = Term(Source("Bias", "data", "estimated"), "linear", "value", "m", np.asarray([2.0]), Spread(4))
    out = read_out(cloth(shared), HERE, k=1.0)
    assert out.lines[0].value == pytest.approx(2.0)


def test_an_estimate_of_the_error_itself_keeps_its_sign_and_may_cancel() -> None:
    errors = np.array([0.2, 9.0, -1.0, 0.5])
    out = read_out(cloth(Term(Source("Law", "model", "estimated"), "signed", "value", "m", errors, Identity(4))), HERE)
    assert out.lines[0].value == pytest.approx(abs(0.5 * 0.2 - 0.3 * 1.0 + 0.2 * 0.5), abs=1e-12)
    assert out.lines[0].number.startswith("−")


def test_a_vector_is_told_by_its_length() -> None:
    sizes = np.arange(12.0)
    vector = Term(Source("V", "mapping", "proven"), "bound", "position", "m", sizes, Identity(12), "point", 3)
    out = read_out(cloth(vector), HERE)
    rows = sizes.reshape(4, 3)
    assert out.lines[0].value == pytest.approx(np.linalg.norm(0.5 * rows[0] + 0.3 * rows[2] + 0.2 * rows[3]))


def test_terms_and_flags_of_cells_and_segments_are_of_the_one_that_was_met() -> None:
    per_cell = Term(Source("Chord", "mapping", "proven"), "bound", "position", "m", np.array([5.0, 7.0]), Identity(2), "cell")
    flags = (
        Flag("topology at risk", "near a saddle", "cell", np.array([1]), np.array([0.25])),
        Flag("kappa", "steep", "cell", np.array([0])),
        Flag("whole", "made by hand"), Flag("kappa", "flat", "point", np.array([1])),
    )  # fmt: skip
    out = read_out(cloth(per_cell, flags=flags), HERE)
    assert out.lines[0].value == 7.0
    assert out.flags == ("Topology at risk (0.25): near a saddle", "made by hand")


def test_a_measure_is_that_of_its_item_and_counts_in_no_total() -> None:
    area = Term(Source("Area", "mapping", "exact"), "metric", "area", "m²", np.array([1.0, 2.0, 4.0, 8.0]), Identity(4))
    out = read_out(cloth(area), HERE)
    assert out.lines[0].value == 1.0 and not out.totals


def test_no_bound_is_said_and_not_counted_as_zero() -> None:
    endless = Term(Source("Slope", "data", "proven"), "bound", "position", "m", np.array([1.0, 1.0, np.inf, 1.0]), Identity(4))
    out = read_out(cloth(endless), HERE)
    assert out.lines[0].number == "no bound" and "no bound here" in out.summary


def test_what_nobody_gave_stands_last_with_a_question_mark() -> None:
    out = read_out(cloth(bound("A", 1.0, 4, unit="m"), missing=unknown("no survey").missing), HERE)
    assert [line.sign for line in out.lines] == ["≤", "?"]
    assert "One source is not known, so it may be more." in out.summary
    text = out.text()
    assert "≤\t1\u00a0m\tA\tvalue, data" in text and "?\taccuracy: no survey" in text
    import json
    assert json.loads(json.dumps(out.plain()))["hit"]["cell"] == 1


def test_exact_is_said_in_words_and_nothing_stated_is_not_exact() -> None:
    zero = Term(Source("Formula", "data", "exact"), "bound", "value", "", np.asarray(0.0), Identity(4))
    assert read_out(cloth(zero), HERE).summary == "Exact: nothing here is in doubt."
    assert "Nothing is stated" in read_out(cloth(), HERE).summary


def test_a_point_of_dust_says_what_it_stands_for() -> None:
    points = np.zeros((3, 3))
    dust = Geometry(
        points=points, vertices=Cells.of([[0], [1], [2]]), origin=np.array([7, 8, 9]), shows=(Shown("Area", "area", "", 20.0),),
        values={"level": Field(np.array([100.0, 200.0, 300.0]), "cell", "m")}, accuracy=EXACT,
    )  # fmt: skip
    out = read_out(layer(dust, PointLook()), Hit(0, "vertex", 2, (2,), (1.0,), (0.0, 0.0, 0.0)))
    assert out.title == "Area, drawn ×20" and "item 9" in out.place
    assert out.values == (("level", "300\u00a0m"),)


def test_a_place_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="pick again"):
        read_out(cloth(bound("A", 1.0, 4)), Hit(0, "polygon", 1, (0, 2, 44), (0.5, 0.3, 0.2), (0.0, 0.0, 0.0)))
