"""One table: look -> how its actors are made, fed with a shape, and dressed.

`Kind.made` gives bare props; `Kind.key` names all that their data depends on; `Kind.feed` turns shape into data and is
called only when the key changed; `Kind.dress` sets properties and is called when the layer or the style changed.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import charts, meshes, relief, surfaces
from app.draw.dressing import Kind, Props, Style, actor, by, field_of, flat, paint, texture
from modules.data.geometry import Geometry
from modules.data.scene import (
    ChartLook,
    ImageLook,
    LabelLook,
    Layer,
    LineLook,
    PointLook,
    SurfaceLook,
    VolumeLook,
)
from modules.data.wires import Samples, Table

THICK = 2.0
"""Lines of a major level are so many times as wide."""
DASHES = 110.0
"""Dashes along the longest side of the picture."""


# --- lines


def _line_props() -> Props:
    return [actor(), actor()]


def _line_key(layer: Layer, style: Style) -> Hashable:
    look: LineLook = layer.look  # type: ignore[assignment]  # the table gives each kind its own look
    return (*by(layer), look.major, look.dashed, style.extent if look.dashed else 0.0)


def _line_feed(props: Props, layer: Layer, style: Style) -> None:
    look, shape = layer.look, layer.shape
    assert isinstance(look, LineLook) and isinstance(shape, Geometry)
    thick = majors(shape, look.major)
    for one, keep in zip(props, (~thick, thick), strict=True):
        part = keep if look.major else None
        data = _lines(layer, shape, look, part, style)
        one.GetMapper().SetInputData(data)
    props[1].SetVisibility(bool(thick.any()))


def _lines(layer: Layer, shape: Geometry, look: LineLook, keep: NDArray[np.bool_] | None, style: Style) -> Any:
    if look.dashed:
        return meshes.dashes_of(shape, style.extent / DASHES)
    if look.colouring is None:
        return meshes.lines_of(shape, keep)
    values, place = field_of(layer, look.colouring)
    if place == "segment":
        data = meshes.segments_of(shape)
        meshes.attach(data, values, "cell")
        return data
    data = meshes.lines_of(shape, keep)
    if place == "cell":
        start = len(shape.vertices)
        values = values[start : start + len(shape.lines)]
        meshes.attach(data, values if keep is None else values[keep], "cell")
    else:
        meshes.attach(data, values, "point")
    return data


def majors(shape: Geometry, major: int) -> NDArray[np.bool_]:
    """(lines,) whether a line's level is one of every `major`-th: a multiple of the wide step, or in order if uneven."""
    none = np.zeros(len(shape.lines), bool)
    if not major or "level" not in shape.values:
        return none
    values, place = np.asarray(shape.values["level"].values, float), shape.values["level"].place
    if place == "point":
        values = values[shape.lines.connectivity[shape.lines.offsets[:-1]]]
    elif place == "cell":
        values = values[len(shape.vertices) : len(shape.vertices) + len(shape.lines)]
    else:
        return none
    levels = np.unique(values)
    steps = np.diff(levels)
    order = np.searchsorted(levels, values)
    if len(steps) and np.allclose(steps, steps[0], rtol=1e-6):
        order = np.rint(values / steps[0]).astype(int)
    return np.asarray(order % major == 0)


def _line_dress(props: Props, layer: Layer, style: Style) -> None:
    look = layer.look
    assert isinstance(look, LineLook)
    values = field_of(layer, look.colouring)[0] if look.colouring else None
    for one, width in zip(props, (look.width, look.width * THICK), strict=True):
        prop = one.GetProperty()
        flat(prop, style.theme.on(look.colour, style.ground), look.opacity)
        prop.SetLineWidth(width * style.scale)
        mapper = one.GetMapper()
        paint(mapper, look.colouring, values, style.theme.rgb("text 3"))
        mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -8.0)


# --- points


def _point_feed(props: Props, layer: Layer, style: Style) -> None:
    look, shape = layer.look, layer.shape
    assert isinstance(look, PointLook) and isinstance(shape, Geometry)
    data = meshes.points_of(shape)
    if look.colouring is not None:
        values, place = field_of(layer, look.colouring)
        on = "cell" if place == "cell" and len(shape.vertices) else "point"
        meshes.attach(data, values[: len(shape.vertices)] if on == "cell" else values, on)
    props[0].GetMapper().SetInputData(data)


def _point_dress(props: Props, layer: Layer, style: Style) -> None:
    look = layer.look
    assert isinstance(look, PointLook)
    (one,) = props
    prop, mapper = one.GetProperty(), one.GetMapper()
    flat(prop, style.theme.on(look.colour, style.ground), look.opacity)
    prop.SetPointSize(look.size * style.scale)
    prop.SetRenderPointsAsSpheres(True)
    values = field_of(layer, look.colouring)[0] if look.colouring else None
    paint(mapper, look.colouring, values, style.theme.rgb("text 3"))
    mapper.SetRelativeCoincidentTopologyPointOffsetParameter(-12.0)


# --- images


def _image_key(layer: Layer, style: Style) -> Hashable:
    return (id(layer.shape), layer.look, style.theme.name)


def _image_feed(props: Props, layer: Layer, style: Style) -> None:
    look, shape = layer.look, layer.shape
    assert isinstance(look, ImageLook) and isinstance(shape, Samples)
    image = relief.picture(shape, look, style.theme)
    props[0].GetMapper().SetInputData(meshes.quad(shape, *image.shape[:2]))
    props[0].SetTexture(texture(image, look.interpolate))


def _image_dress(props: Props, layer: Layer, style: Style) -> None:
    props[0].GetProperty().LightingOff()
    props[0].GetProperty().SetColor(1.0, 1.0, 1.0)
    props[0].GetMapper().SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)


# --- volumes


def _volume_props() -> Props:
    from vtkmodules.vtkRenderingCore import vtkVolume
    from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

    volume = vtkVolume()
    volume.SetMapper(vtkSmartVolumeMapper())
    return [volume]


def _volume_feed(props: Props, layer: Layer, style: Style) -> None:
    props[0].GetMapper().SetInputData(meshes.lattice(layer.shape))


def _volume_dress(props: Props, layer: Layer, style: Style) -> None:
    from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
    from vtkmodules.vtkRenderingCore import vtkColorTransferFunction

    look = layer.look
    assert isinstance(look, VolumeLook)
    values = np.asarray(layer.shape.values, float)
    low, high = look.colouring.range or (float(np.nanmin(values)), float(np.nanmax(values)))
    colours, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for place, colour in zip(np.linspace(low, high, 64), relief.table(look.colouring.map, 64), strict=True):
        colours.AddRGBPoint(float(place), *(float(c) for c in colour))
    for place, amount in zip(np.linspace(low, high, len(look.opacity)), look.opacity, strict=True):
        opacity.AddPoint(float(place), amount)
    prop = props[0].GetProperty()
    prop.SetColor(colours)
    prop.SetScalarOpacity(opacity)
    prop.SetInterpolationTypeToLinear()


# --- charts


BAND = 0.22
"""Opacity of a band of error, so that the curve in it and other bands are seen."""


def _chart_feed(props: Props, layer: Layer, style: Style) -> None:
    look, shape = layer.look, layer.shape
    assert isinstance(look, ChartLook) and isinstance(shape, Table)
    x, y = chart_columns(shape, look)
    props[0].GetMapper().SetInputData(meshes.chart_of(shape, x, y, look.kind, look.upper, charts.logs(look)))


def chart_columns(table: Table, look: ChartLook) -> tuple[str, str]:
    """The two columns that a chart draws: those named, else the first two."""
    names = [*table.columns, "", ""]
    return look.x or names[0], look.y or names[1]


def _chart_dress(props: Props, layer: Layer, style: Style) -> None:
    look = layer.look
    assert isinstance(look, ChartLook)
    prop = props[0].GetProperty()
    flat(prop, style.theme[look.colour], BAND if look.kind == "band" else 1.0)
    prop.SetLineWidth(1.5 * style.scale)
    prop.SetPointSize(4.0 * style.scale)
    prop.SetRenderPointsAsSpheres(True)


# --- labels: words are placed in pixels, after all else is drawn


def _nothing(props: Props, layer: Layer, style: Style) -> None:
    pass


KINDS: Mapping[type, Kind] = {
    SurfaceLook: Kind(surfaces.props, surfaces.key, surfaces.feed, surfaces.dress),
    LineLook: Kind(_line_props, _line_key, _line_feed, _line_dress),
    PointLook: Kind(lambda: [actor()], lambda layer, style: by(layer), _point_feed, _point_dress),
    ImageLook: Kind(lambda: [actor()], _image_key, _image_feed, _image_dress),
    VolumeLook: Kind(_volume_props, lambda layer, style: id(layer.shape), _volume_feed, _volume_dress),
    ChartLook: Kind(lambda: [actor()], lambda layer, style: (id(layer.shape), layer.look), _chart_feed, _chart_dress),
    LabelLook: Kind(list, lambda layer, style: id(layer.shape), _nothing, _nothing),
}
"""Each look has its row; a look without one is refused."""
