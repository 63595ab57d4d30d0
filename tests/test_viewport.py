"""A scene on a plotter: only what changed is touched, and a flat view is seen from above whatever is asked."""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.theme import THEMES, rgb, theme
from app.viewport import Changes, Viewport, off_screen
from modules.api import (
    EXACT,
    Cells,
    ChartLook,
    Field,
    Geometry,
    Layer,
    LineLook,
    PointLook,
    Primitive,
    Samples,
    Scene,
    SceneLook,
    SurfaceLook,
    Table,
    unknown,
)
from modules.data.scene import Colouring, VolumeLook
from modules.renderers._colours import colour_map
from modules.renderers.image import image
from modules.renderers.labels import labels
from modules.renderers.lines import lines
from modules.renderers.view import view


@pytest.fixture
def port() -> Iterator[Viewport]:
    plotter = off_screen((120, 90))
    yield Viewport(plotter)
    plotter.close()


def strokes(y: Any = 0.0, n: Any = 3) -> Any:
    """n level lines of 5 points, from x = 0 to 4."""
    parts = [np.column_stack([np.arange(5.0), np.full(5, y + i), np.zeros(5)]) for i in range(n)]
    return Geometry(
        points=np.concatenate(parts),
        lines=Cells.of(np.arange(5 * n).reshape(n, 5)),
        values={"level": Field(np.arange(n) * 100.0, "cell", "m"), "bend": Field(np.arange(4.0 * n), "segment")},
        accuracy=EXACT,
    )


def sheet() -> Any:
    values = {"height": Field(np.arange(4.0))}
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 1], [0, 4, 0]], float)
    return Geometry(points=corners, polygons=Cells.of([[0, 1, 2], [0, 2, 3]]), values=values, accuracy=EXACT)


def layer(shape: Any, look: Any) -> Any:
    return Layer(shape=shape, look=look, accuracy=EXACT)


def scene(*layers: Any, **look: Any) -> Any:
    return Scene(layers=layers, look=SceneLook(**look), accuracy=EXACT)


def props(port: Viewport) -> Any:
    return [prop for drawn in port._drawn for prop in drawn.props]


def test_the_same_scene_again_touches_nothing(port: Viewport) -> None:
    shown = scene(layer(strokes(), LineLook()), layer(sheet(), SurfaceLook()))
    assert port.show(shown) == Changes(made=2, fed=2, dressed=2)
    before = props(port)
    assert port.show(shown) == Changes(same=2)
    assert port.show(replace(shown, layers=tuple(shown.layers))) == Changes(same=2)
    assert props(port) == before


def test_a_new_look_sets_properties_and_leaves_the_data(port: Viewport) -> None:
    shape, other = strokes(), layer(sheet(), SurfaceLook())
    port.show(scene(layer(shape, LineLook(width=1.0)), other))
    actor = props(port)[0]
    data = actor.GetMapper().GetInput()
    assert port.show(scene(layer(shape, LineLook(width=3.0, colour="#ff0000")), other)) == Changes(same=1, dressed=1)
    assert props(port)[0] is actor and actor.GetMapper().GetInput() is data
    assert actor.GetProperty().GetLineWidth() == 3.0
    assert actor.GetProperty().GetColor() == (1.0, 0.0, 0.0)


def test_a_new_shape_gives_the_same_actor_new_data(port: Viewport) -> None:
    other = layer(sheet(), SurfaceLook())
    port.show(scene(layer(strokes(), LineLook()), other))
    actor = props(port)[0]
    changes = port.show(scene(layer(strokes(y=1.0), LineLook()), other))
    assert (changes.same, changes.made, changes.fed, changes.removed) == (1, 0, 1, 0)
    assert props(port)[0] is actor
    assert actor.GetMapper().GetInput().GetBounds()[2] == 1.0


def test_a_layer_that_goes_takes_its_actors_with_it_and_the_others_stay(port: Viewport) -> None:
    one, two, three = layer(strokes(), LineLook()), layer(strokes(1.0), LineLook()), layer(strokes(2.0), PointLook())
    port.show(scene(one, two, three))
    assert port.show(scene(three, one)) == Changes(same=2, removed=1)
    assert port.show(scene(two, three, one)) == Changes(same=2, made=1, fed=1, dressed=1)
    assert len(props(port)) == port.plotter.renderer.GetViewProps().GetNumberOfItems()


def test_a_new_theme_dresses_all_and_feeds_only_what_has_its_colours_in_the_data(port: Viewport) -> None:
    shown = [lines(strokes()), image(Samples.from_array(np.eye(4), accuracy=EXACT), show="relief")]
    port.show(view(shown, theme="light"))
    changes = port.show(view(shown, theme="dark"))
    assert (changes.dressed, changes.fed, changes.made) == (2, 1, 0)
    assert port.plotter.renderer.GetBackground() == pytest.approx(theme("dark").rgb("view"))


def test_many_layers_and_one_change(port: Viewport) -> None:
    shown = [layer(strokes(float(i)), LineLook()) for i in range(20)]
    port.show(scene(*shown))
    shown[7] = layer(shown[7].shape, LineLook(width=4.0))
    assert port.show(scene(*shown)) == Changes(same=19, dressed=1)


def test_a_flat_view_is_seen_from_above_and_cannot_be_turned(port: Viewport) -> None:
    port.show(scene(layer(strokes(), LineLook())))
    camera = port.camera
    assert camera["parallel"] and camera["up"] == [0.0, 1.0, 0.0]
    assert camera["position"][:2] == pytest.approx(camera["focal"][:2])
    aside = {"position": [50.0, -80.0, 20.0], "up": [0.0, 0.0, 1.0], "focal": [1.0, 2.0, 0.0], "parallel": False}
    port.camera = {**camera, **aside}
    turned = port.camera
    assert turned["parallel"] and turned["up"] == [0.0, 1.0, 0.0]
    assert turned["position"][:2] == turned["focal"][:2] == [1.0, 2.0]


def test_flat_layers_are_stacked_in_their_order(port: Viewport) -> None:
    low = image(Samples.from_array(np.zeros((5, 5)), accuracy=EXACT), show="relief")
    port.show(scene(low, layer(strokes(), LineLook()), layer(strokes(), PointLook())))
    heights = [drawn.props[0].GetPosition()[2] for drawn in port._drawn]
    assert heights[0] < heights[1] < heights[2]
    port.show(scene(low, layer(strokes(), LineLook()), dimensions=3, exaggeration=4.0))
    assert [drawn.props[0].GetPosition()[2] for drawn in port._drawn] == [0.0, 0.0]
    assert [drawn.props[0].GetScale()[2] for drawn in port._drawn] == [4.0, 4.0]


def test_the_camera_is_plain_data_and_comes_back(port: Viewport) -> None:
    port.show(scene(layer(sheet(), SurfaceLook()), dimensions=3))
    there = {"position": [9.0, -7.0, 5.0], "focal": [2.0, 2.0, 0.5], "up": [0.0, 0.0, 1.0], "angle": 40.0, "height": 6.0}
    port.camera = json.loads(json.dumps({**there, "parallel": False}))
    again = json.loads(json.dumps(port.camera))
    for name, value in there.items():
        assert again[name] == pytest.approx(value)


def test_a_fitted_view_in_space_holds_every_corner(port: Viewport) -> None:
    port.show(scene(layer(sheet(), SurfaceLook()), dimensions=3, exaggeration=3.0))
    corners = np.array([[x, y, z] for x in (0, 4) for y in (0, 4) for z in (0, 3)], float)
    seen = port.project(corners)
    assert ((seen > 0) & (seen < 1)).all()
    assert (seen.max(axis=0) + seen.min(axis=0)) / 2 == pytest.approx([0.5, 0.5], abs=0.03)


def test_the_sides_of_the_box_that_are_near_are_left_out_and_follow_the_camera(port: Viewport) -> None:
    port.show(scene(layer(sheet(), SurfaceLook()), dimensions=3))
    data = port._box.GetMapper().GetInput()
    assert data.GetNumberOfLines() == 9
    port.camera = {**port.camera, "position": [20.0, 30.0, 20.0]}
    port.pixels()
    assert port._box.GetMapper().GetInput() is not data


def test_values_on_points_cells_and_segments_give_colours(port: Viewport) -> None:
    for by, cells in (("level", 3), ("bend", 12)):
        port.show(scene(layer(strokes(), LineLook(colouring=Colouring(by=by, map=colour_map())))))
        mapper = props(port)[0].GetMapper()
        assert mapper.GetScalarVisibility()
        assert mapper.GetInput().GetCellData().GetScalars().GetNumberOfTuples() == cells
    with pytest.raises(ValueError, match="which its geometry has not"):
        port.show(scene(layer(strokes(), LineLook(colouring=Colouring(by="speed", map=colour_map())))))


def test_a_logarithmic_and_a_discrete_map_reach_the_table(port: Viewport) -> None:
    steps = Colouring(by="height", map=colour_map("values", steps=4), range=(0.0, 4.0))
    port.show(scene(layer(sheet(), SurfaceLook(colouring=steps))))
    table = props(port)[0].GetMapper().GetLookupTable()
    colours = {tuple(np.round(table.GetTableValue(i)[:3], 3)) for i in range(table.GetNumberOfTableValues())}
    assert len(colours) == 4
    decades = Colouring(by="height", map=colour_map("values", scale="logarithmic"), range=(0.1, 10.0))
    port.show(scene(layer(sheet(), SurfaceLook(colouring=decades))))
    assert props(port)[0].GetMapper().GetLookupTable().GetScale() == 1


def test_every_major_level_is_thicker(port: Viewport) -> None:
    port.show(scene(layer(strokes(n=3), LineLook(width=1.0, major=2))))
    thin, thick = props(port)
    assert (thin.GetMapper().GetInput().GetNumberOfLines(), thick.GetMapper().GetInput().GetNumberOfLines()) == (1, 2)
    assert thick.GetProperty().GetLineWidth() > thin.GetProperty().GetLineWidth()
    port.show(scene(layer(strokes(n=3), LineLook(dashed=True))))
    assert props(port)[0].GetMapper().GetInput().GetNumberOfLines() > 3


def test_primitives_are_drawn_as_facets(port: Viewport) -> None:
    values = {
        "sphere": {"centre": [1.0, 2.0, 3.0], "radius": [2.0]},
        "box": {"low": [0.0, 0.0, 0.0], "high": [1.0, 2.0, 3.0]},
        "plane": {"origin": [0.0, 0.0, 1.0], "normal": [0.0, 0.0, 1.0], "size": [2.0]},
        "line": {"start": [0.0, 0.0, 0.0], "end": [1.0, 1.0, 1.0]},
    }
    bounds = {
        "sphere": (-1, 3, 0, 4, 1, 5), "box": (0, 1, 0, 2, 0, 3), "plane": (-1, 1, -1, 1, 1, 1), "line": (0, 1, 0, 1, 0, 1),
    }  # fmt: skip
    for kind, given in values.items():
        one = Primitive(kind=kind, values={n: np.array(v) for n, v in given.items()}, accuracy=EXACT)
        shape = Geometry(points=np.zeros((0, 3)), primitives=(one,), accuracy=EXACT)
        port.show(scene(layer(shape, SurfaceLook()), dimensions=3))
        assert props(port)[0].GetMapper().GetInput().GetBounds() == pytest.approx(bounds[kind], abs=0.02)
    odd = Primitive(kind="torus", values={"centre": np.zeros(3)}, accuracy=EXACT)
    with pytest.raises(ValueError, match="no primitive 'torus'"):
        port.show(scene(layer(Geometry(points=np.zeros((1, 3)), primitives=(odd,), accuracy=EXACT), SurfaceLook())))


def test_every_look_can_be_drawn(port: Viewport) -> None:
    table = Table(columns={"t": np.arange(5.0), "v": np.arange(5.0) ** 2}, accuracy=unknown("test"))
    block = Samples.from_array(np.random.default_rng(1).random((4, 5, 6)), accuracy=EXACT)
    cloud = VolumeLook(colouring=Colouring(by="", map=colour_map()))
    shown = [
        layer(strokes(), LineLook()), layer(strokes(), PointLook()), layer(sheet(), SurfaceLook(relief=True, edges=True)),
        image(Samples.from_array(np.eye(4), accuracy=EXACT), show="both"), layer(block, cloud), labels(strokes()),
        *(layer(table, ChartLook(kind=kind)) for kind in ("curve", "bars", "scatter")),
    ]  # fmt: skip
    assert port.show(scene(*shown, dimensions=3)).made == len(shown)
    assert port.pixels().std() > 0


def test_holes_of_an_image_are_clear(port: Viewport) -> None:
    values = np.zeros((6, 6))
    values[:, 3:] = np.nan
    port.show(view([image(Samples.from_array(values, accuracy=EXACT), low=0.0, high=1.0)], theme="dark"))
    pixels = port.pixels()
    height, width = pixels.shape[:2]
    ground = np.round(np.array(theme("dark").rgb("view")) * 255)
    assert np.abs(pixels[height // 2, int(width * 0.62)] - ground).max() <= 2
    assert np.abs(pixels[height // 2, int(width * 0.35)] - ground).max() > 20


# --- surfaces: what has no value, light, wire; other dress


def hilly(n: Any = 6) -> Any:
    """Squares of two triangles with a value a triangle, some not known."""
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.column_stack([a, a + 1, a + n]), np.column_stack([a + 1, a + n + 1, a + n])])
    values = np.linspace(0, 1, len(triangles))
    values[::5] = np.nan
    corner = np.linspace(0, 1, n * n)
    corner[7] = np.nan
    return Geometry(
        points=np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)]).astype(float), polygons=Cells.of(triangles),
        values={"error": Field(values, "cell", "m"), "height": Field(corner)}, accuracy=EXACT,
    )  # fmt: skip


@pytest.mark.parametrize("by", ["error", "height"])
@pytest.mark.parametrize("relief", [False, True])
def test_what_has_no_value_is_hatched_and_the_rest_keeps_its_colours(port: Viewport, by: str, relief: bool) -> None:
    shape = hilly()
    colouring = Colouring(by=by, map=colour_map("values"), range=(0.0, 1.0))
    look = SurfaceLook(colouring=colouring, relief=relief, lit=False, smooth=by == "height")
    port.show(scene(layer(shape, look), axes=False))
    values = np.asarray(shape.values[by].values)
    unknown = np.isnan(values) if by == "error" else np.isnan(values[shape.triangles]).any(axis=1)
    surface, hatch = props(port)
    assert hatch.GetVisibility() and hatch.GetMapper().GetInput().GetNumberOfPolys() == unknown.sum()
    assert surface.GetMapper().GetInput().GetNumberOfPolys() == len(unknown) - unknown.sum()
    pixels = port.pixels()
    size = (pixels.shape[1], pixels.shape[0])
    middles = shape.points[shape.triangles].mean(axis=1)
    at = np.rint(port.project(middles) * size - 0.5).astype(int)
    greys = [np.round(np.array(theme("light").rgb(role)) * 255) for role in ("text 3", "divider")]
    seen = pixels[at[:, 1], at[:, 0]].astype(float)
    low, high = np.minimum(*greys) - 3, np.maximum(*greys) + 3
    assert ((seen[unknown] >= low) & (seen[unknown] <= high)).all(axis=1).all()
    if by == "error":
        table = colour_map("values").colours
        places = np.linspace(0, 1, len(table))
        wanted = np.stack([np.interp(values[~unknown], places, table[:, c]) for c in range(3)], axis=1) * 255
        assert np.abs(seen[~unknown] - wanted).max() < 6, "colours of what is not lit are those of the bar"


def test_hatches_are_stripes_on_every_side_of_a_box() -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    from app.draw import meshes

    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    shape = Geometry(points=corners, polygons=Cells.of(sides), accuracy=EXACT)
    data = meshes.hatched(shape, np.ones(6, bool), 0.1)
    along = vtk_to_numpy(data.GetPointData().GetTCoords())[:, 0].reshape(6, 4)
    assert (np.ptp(along, axis=1) > 10).all()
    assert meshes.hatched(shape, np.zeros(6, bool), 0.1).GetNumberOfPolys() == 0


def test_the_legend_says_how_much_has_no_value() -> None:
    from app.legend import legend

    shape = hilly()
    colouring = Colouring(by="error", map=colour_map("values"), title="distance", unit="m")
    told = legend(scene(layer(shape, SurfaceLook(colouring=colouring))))
    (entry,) = told.drawn[0].entries
    assert entry.sign == "?" and entry.words == "distance not known at 10 of 50 cells, hatched"


def test_without_light_a_colour_is_what_it_is_however_it_is_turned(port: Viewport) -> None:
    shown = scene(layer(sheet(), SurfaceLook(lit=False, colour="#336699")), dimensions=3, axes=False)
    port.show(shown)
    for position in ([20.0, -8.0, 9.0], [-9.0, 20.0, 3.0]):
        port.camera = {**port.camera, "position": position}
        pixels = port.pixels().reshape(-1, 3)
        assert (pixels == [0x33, 0x66, 0x99]).all(axis=1).sum() > 50


def test_a_wireframe_shows_the_view_between_its_lines(port: Viewport) -> None:
    shape = hilly(4)
    port.show(scene(layer(shape, SurfaceLook()), axes=False))
    full = (port.pixels() == 255).all(axis=2).mean()
    port.show(scene(layer(shape, SurfaceLook(wire=True, lit=False)), axes=False))
    assert (port.pixels() == 255).all(axis=2).mean() > full + 0.2


def test_another_dress_keeps_layers_that_it_does_not_change_and_gives_the_same_ones_again(port: Viewport) -> None:
    from app.draw.styles import Wardrobe, common, drawn_as

    values = Colouring(by="height", map=colour_map("values"), range=(0.0, 3.0), title="height")
    one, two = layer(sheet(), SurfaceLook(colouring=values)), layer(strokes(), LineLook())
    shown, wardrobe = scene(one, two, dimensions=3), Wardrobe()
    assert wardrobe.dressed(shown) is shown
    wired: Any = wardrobe.dressed(shown, "wireframe")
    assert wired.layers[1] is two and wired.layers[0].look.wire and wired.layers[0].shape is one.shape
    assert all(a is b for a, b in zip(wardrobe.dressed(shown, "wireframe").layers, wired.layers, strict=True))
    port.show(shown)
    assert port.show(wired) == Changes(same=1, dressed=1)
    assert drawn_as(shown, "no such way") is shown
    wider = scene(layer(sheet(), SurfaceLook(colouring=replace(values, range=(-5.0, 1.0)))))
    ranges = common([shown, wider])
    assert list(ranges.values()) == [(-5.0, 3.0)]
    shared: Any = wardrobe.dressed(shown, ranges=ranges)
    assert shared.layers[0].look.colouring.range == (-5.0, 3.0)


def test_numbers_stand_along_the_box_when_asked_for(port: Viewport) -> None:
    port.show(scene(layer(sheet(), SurfaceLook()), dimensions=3))
    bare = port.pixels()
    port.numbers = True
    numbered = port.pixels()
    assert (bare != numbered).any()
    port.numbers = False
    assert (port.pixels() == bare).all()


def luminance(colour: Any) -> Any:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))


def contrast(one: Any, other: Any) -> Any:
    a, b = sorted((luminance(one), luminance(other)))
    return (b + 0.05) / (a + 0.05)


DEUTERANOPIA = np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]])
"""Machado and others 2009, severity 1, on linear light."""


def deuteranopic(colour: Any) -> Any:
    linear = np.array([c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour])
    seen = np.clip(DEUTERANOPIA @ linear, 0, 1)
    return np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("eye", [lambda c: c, deuteranopic], ids=["in grey", "deuteranopia"])
def test_lines_and_dust_stand_out_by_lightness_alone(name: str, eye: Any) -> None:
    colours = theme(name)
    for mark, ground, least in (
        ("line", "view", 12), ("line", "relief flat", 8), ("line", "relief shadow", 7), ("line", "relief light", 7),
        ("dust", "view", 3), ("dust", "relief flat", 3), ("dust", "relief shadow", 2), ("dust", "relief light", 3),
        ("line on clay", "clay", 7), ("dust on clay", "clay", 3),
        ("text", "panel", 10), ("text 2", "panel", 4.5), ("text 3", "panel", 4.5), ("brass", "panel", 4.5),
        ("flag", "panel", 4.5), ("edge", "panel", 3),
    ):  # fmt: skip
        assert contrast(eye(colours.rgb(mark)), eye(colours.rgb(ground))) >= least, (mark, ground)


def test_a_colour_that_is_none_is_refused() -> None:
    with pytest.raises(KeyError, match="there is no colour 'mauve'"):
        theme("light")["mauve"]
    with pytest.raises(ValueError, match="write #rrggbb"):
        rgb("#12345")
    with pytest.raises(KeyError, match="themes are dark, light"):
        theme("sepia")
