"""Geometry and samples become layers, layers a scene: what is drawn is named, and nothing known of it is lost."""

from typing import Any

import numpy as np
import pytest

from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    Field,
    Geometry,
    Layer,
    Missing,
    Samples,
    Shown,
    bound,
    deviation,
    unknown,
)
from modules.data.accuracy import accuracies
from modules.data.scene import ImageLook, LineLook, PointLook, SurfaceLook, Text
from modules.declare import record_of
from modules.renderers._colours import CIVIDIS, colour_map, rgb
from modules.renderers.image import image
from modules.renderers.labels import labels, places
from modules.renderers.lines import lines
from modules.renderers.points import points
from modules.renderers.surface import surface
from modules.renderers.view import view


def contours(levels: Any = (100.0, 200.0, 300.0), *, unit: Any = "m", shows: Any = ()) -> Any:
    """Level lines y = i, from x = 0 to 10, each of 21 points."""
    x = np.linspace(0, 10, 21)
    parts = [np.column_stack([x, np.full(21, float(i)), np.zeros(21)]) for i in range(len(levels))]
    n = 21 * len(levels)
    return Geometry(
        points=np.concatenate(parts),
        lines=Cells.of(np.arange(n).reshape(-1, 21)),
        values={"level": Field(np.array(levels), "cell", unit), "height": Field(np.linspace(1, 2, n))},
        shows=shows,
        accuracy=Accuracy(terms=(bound("Chord", 0.1, n, quantity="position", unit="m"), deviation("Noise", 0.2, n))).miss(
            Missing("Survey error")
        ),
    )


def hill(n: Any = 20, **more: Any) -> Any:
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    values = 100 * np.exp(-2 * (x**2 + y**2))
    terms = Accuracy(terms=(bound("Rounding", 0.5, n * n, unit="m"),))
    return Samples.from_array(values, spacing=10.0, unit="m", name="height", accuracy=terms, **more)


def square() -> Any:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], float)
    values = {"error": Field(np.array([0.1]), "cell", "m"), "height": Field(np.arange(4.0))}
    return Geometry(points=corners, polygons=Cells.of([[0, 1, 2, 3]]), values=values, accuracy=unknown("not measured"))


MADE: dict[str, Any] = {
    "lines": lambda: (lines, contours()),
    "points": lambda: (points, contours()),
    "surface": lambda: (surface, square()),
    "image": lambda: (image, hill()),
    "labels": lambda: (labels, contours()),
}


@pytest.mark.parametrize("name", MADE)
def test_each_term_and_each_missing_source_of_the_input_goes_on(name: str) -> None:
    module, shape = MADE[name]()
    layer = module(shape)
    told = frozenset[str]().union(*(a.accounted() for a in accuracies(layer)))
    assert shape.accuracy.accounted() <= told
    assert layer.accuracy.missing == shape.accuracy.missing
    assert record_of(module).accuracy


def test_a_view_keeps_each_layer_and_its_accuracy_in_order() -> None:
    below, above = image(hill()), lines(contours())
    scene = view([below, above])
    assert scene.layers == (below, above)
    assert scene.accuracy is EXACT


@pytest.mark.parametrize(
    ("levels", "title"),
    [
        ((100.0, 200.0, 300.0), "Contour lines every 100\u00a0m"),
        ((0.1, 0.2, 0.3, 0.4), "Contour lines every 0.1\u00a0m"),
        ((-50.0,), "Contour line at −50\u00a0m"),
        ((1.0, 2.0, 5.0), "Contour lines at 1, 2 and 5\u00a0m"),
        ((1.0, 2.0, 5.0, 20.0, 21.0), "Contour lines at 5 levels"),
    ],
)
def test_lines_are_named_by_their_levels(levels: Any, title: Any) -> None:
    assert lines(contours(levels)).title == title


def test_a_title_that_is_given_stands() -> None:
    assert lines(contours(), title="Isobars").title == "Isobars"


def test_points_that_show_an_error_have_its_colour_and_leave_the_words_to_it() -> None:
    shown = Shown("Chord", "area", "1 point = 34 m²", 10.0)
    layer = points(contours(shows=(shown,)))
    assert isinstance(layer.look, PointLook)
    assert (layer.look.colour, layer.title, layer.shows) == ("dust", "", (shown,))
    assert points(contours()).look.colour == "line"  # type: ignore[union-attr]  # a point look


def test_a_renderer_refuses_what_it_cannot_draw_and_says_what_can() -> None:
    with pytest.raises(ValueError, match="use 'lines' or 'points'"):
        surface(contours())
    with pytest.raises(ValueError, match="use 'points' or 'surface'"):
        lines(square())
    with pytest.raises(ValueError, match=r"no values 'speed': it has level, height"):
        lines(contours(), colour_by="speed")
    with pytest.raises(ValueError, match="take a slice"):
        image(Samples.from_array(np.zeros((3, 3, 3)), accuracy=EXACT))
    with pytest.raises(ValueError, match="above zero"):
        view([], exaggeration=0.0)


def test_a_logarithmic_map_refuses_zero_and_less() -> None:
    with pytest.raises(ValueError, match="above zero; the lowest value is 0"):
        lines(contours((0.0, 1.0, 2.0)), colour_by="level", scale="logarithmic")
    with pytest.raises(ValueError, match="above zero; the lower end is -1"):
        lines(contours(), colour_by="level", scale="logarithmic", low=-1.0)
    layer = lines(contours((0.0, 1.0, 2.0)), colour_by="level", scale="logarithmic", low=0.5)
    assert isinstance(layer.look, LineLook) and layer.look.colouring is not None
    assert layer.look.colouring.range == (0.5, 2.0)


def test_errors_are_told_from_zero_and_values_from_their_least() -> None:
    errors: Any = surface(square(), colour_by="error", map="errors").look
    heights: Any = lines(contours(), colour_by="height").look
    assert (errors.colouring.range[0], heights.colouring.range) == (0.0, (1.0, 2.0))


def test_the_colours_of_values_are_cividis_and_those_of_errors_only_darken() -> None:
    import matplotlib

    original = matplotlib.colormaps["cividis"](np.linspace(0, 1, 33))[:, :3]
    assert np.abs(rgb(CIVIDIS) - original).max() < 0.03
    light = colour_map("errors").colours @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) < 0).all()
    with pytest.raises(ValueError, match="maps are values, errors, greys"):
        colour_map("rainbow")
    with pytest.raises(ValueError, match="at least 2 steps"):
        colour_map("values", steps=1)


def test_the_light_of_a_relief_stands_in_its_title() -> None:
    layer = image(hill(), show="relief")
    assert isinstance(layer.look, ImageLook) and layer.look.relief
    assert f"slopes ×{layer.look.exaggeration:g}" in layer.title
    assert "slopes" not in image(hill(), show="relief", light=1.0).title
    lit = surface(square(), relief=True, light=3.0)
    assert isinstance(lit.look, SurfaceLook) and lit.title.endswith("lit from the north-west, slopes ×3")


def test_a_view_is_flat_when_all_that_it_shows_is() -> None:
    flat, high = lines(contours()), surface(square())
    assert view([flat]).look.dimensions == 2
    assert view([flat, image(hill())]).look.dimensions == 2
    assert view([flat, high]).look.dimensions == 3
    assert view([flat, high], dimensions="2").look.dimensions == 2
    assert view([flat], exaggeration=5.0).look.exaggeration == 1.0


def test_a_label_stands_where_its_line_runs_straightest() -> None:
    bend = np.linspace(0, np.pi, 60)
    curved = np.column_stack([np.cos(bend), np.sin(bend), 0 * bend])
    straight = np.column_stack([np.linspace(-1, -1, 30), np.linspace(0, -3, 30), np.zeros(30)])
    found = sorted(places(np.concatenate([curved, straight]), 10.0), key=lambda f: f[0])
    _, middle, direction, room = found[0]
    assert middle[0] == pytest.approx(-1) and middle[1] < 0
    assert abs(direction[1]) == pytest.approx(room)


def test_labels_write_each_level_along_its_line() -> None:
    layer = labels(contours(), unit=True, every=2)
    text = layer.shape
    assert isinstance(text, Text)
    assert set(text.words) == {"100\u00a0m", "300\u00a0m"}
    assert len(text.words) == len(text.at) == len(text.along) == len(text.room)
    assert all(a[1] == 0 and a[0] != 0 for a in text.along)


def test_a_layer_leaves_the_shape_as_it_was() -> None:
    shape = contours()
    for layer in (lines(shape, width=3.0, major=2), points(shape, size=5.0)):
        assert isinstance(layer, Layer)
        assert layer.shape is shape
