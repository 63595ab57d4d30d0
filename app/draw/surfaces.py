"""Surfaces as actors: the polygons with a value, lit as their look says, and hatched those whose value nobody knows."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import meshes, relief
from app.draw.dressing import Props, Style, actor, by, field_of, paint, texture
from app.theme import rgb
from modules.data.geometry import Geometry
from modules.data.scene import Layer, SurfaceLook

HATCHES = 70.0
"""Stripes along the longest side of the picture."""


def props() -> Props:
    """The surface, and the part of it that has no value."""
    return [actor(), actor()]


def key(layer: Layer, style: Style) -> Hashable:
    """What the data depend on."""
    look: SurfaceLook = layer.look  # type: ignore[assignment]  # the table gives each kind its own look
    lit = (look.light, look.colour, look.colouring, style.theme.name) if look.relief else ()
    return (*by(layer), look.smooth, look.relief, lit, style.extent)


def unknown(layer: Layer) -> NDArray[np.bool_]:
    """(polygons,) whether a polygon has no colour: its value, or that of one of its corners, is not a number."""
    shape, look = layer.shape, layer.look
    none = np.zeros(len(shape.polygons), bool)
    assert isinstance(look, SurfaceLook)
    if look.colouring is None or shape.primitives:
        return none
    values, place = field_of(layer, look.colouring)
    missing = np.isnan(values)
    if not missing.any():
        return none
    if place == "cell":
        return np.asarray(missing[len(shape.vertices) + len(shape.lines) :])
    corners = missing[shape.polygons.connectivity]
    return np.asarray(np.logical_or.reduceat(corners, shape.polygons.offsets[:-1])) if len(none) else none


def feed(props: Props, layer: Layer, style: Style) -> None:
    """Polygons with their normals and values."""
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    look, shape = layer.look, layer.shape
    assert isinstance(look, SurfaceLook) and isinstance(shape, Geometry)
    without = unknown(layer)
    data = meshes.surface_of(shape, None if not without.any() else ~without)
    values, on = None, ""
    if look.colouring is not None and not shape.primitives:
        values, place = field_of(layer, look.colouring)
        on = "cell" if place == "cell" else "point"
        if on == "cell":
            values = values[len(shape.vertices) + len(shape.lines) :][~without]
        meshes.attach(data, values, on)
    if not look.smooth or look.relief or not meshes.take_normals(data, shape):
        normals = vtkPolyDataNormals()
        normals.SetInputData(data)
        normals.SplittingOff()
        normals.ConsistencyOff()
        normals.SetComputePointNormals(look.smooth)
        normals.SetComputeCellNormals(not look.smooth or look.relief)
        normals.Update()
        data = normals.GetOutput()
    if look.relief:
        _light(data, look, values, on, style)
    props[0].GetMapper().SetInputData(data)
    props[1].GetMapper().SetInputData(meshes.hatched(shape, without, style.extent / HATCHES))
    props[1].SetVisibility(bool(without.any()))


def _light(data: Any, look: SurfaceLook, values: NDArray[Any] | None, where: str, style: Style) -> None:
    """Colours of the relief as values of the data: on points where it is smooth, on cells where not."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    on = "point" if look.smooth else "cell"
    place = data.GetPointData() if look.smooth else data.GetCellData()
    if place.GetNormals() is None:  # nothing is left
        return
    normals = vtk_to_numpy(place.GetNormals()).astype(float)
    normals = np.where(normals[:, 2:] < 0, -normals, normals) * [look.light, look.light, 1.0]
    light = relief.shading(normals)
    colours = relief.tones(style.theme.rgb(look.colour), light)
    if look.colouring is not None and values is not None and where == on:
        finite = values[np.isfinite(values)]
        span = look.colouring.range or (float(finite.min()), float(finite.max()))
        colours = relief.colours(values[-len(light) :], look.colouring.map, span)
        colours = np.clip(colours * np.interp(light, [0.0, 0.5, 1.0], [0.55, 1.0, 1.15])[:, None], 0.0, 1.0)
    meshes.attach(data, np.rint(colours * 255).astype(np.uint8), on)


def dress(props: Props, layer: Layer, style: Style) -> None:
    """Colour, light and edges."""
    look = layer.look
    assert isinstance(look, SurfaceLook)
    one, hatch = props
    prop, mapper = one.GetProperty(), one.GetMapper()
    lit = look.lit and not look.relief  # the light of a relief is in its colours
    prop.SetColor(*rgb(style.theme.on("line", "view") if look.wire else style.theme[look.colour]))
    prop.SetOpacity(look.opacity)
    prop.SetLighting(lit)
    prop.SetAmbient(0.22 if lit else 0.0)  # without light nothing is added to colours
    prop.SetDiffuse(0.86 if lit else 1.0)
    prop.SetSpecular(0.0)
    prop.SetInterpolation(2 if look.smooth else 0)
    prop.SetRepresentation(1 if look.wire else 2)
    prop.SetEdgeVisibility(look.edges)
    prop.SetEdgeColor(*rgb(style.theme.on("line", "clay")))
    prop.SetLineWidth((1.0 if look.wire else 0.6) * style.scale)
    one.SetTexture(texture(layer.shape.texture, True) if layer.shape.texture is not None else None)
    _dress_hatch(hatch, look, style)
    if look.relief:
        mapper.SetColorModeToDirectScalars()
        mapper.ScalarVisibilityOn()
        return
    coloured = look.colouring is not None and not layer.shape.primitives
    paint(mapper, look.colouring, field_of(layer, look.colouring)[0] if coloured and look.colouring else None)


def _dress_hatch(hatch: Any, look: SurfaceLook, style: Style) -> None:
    """Stripes of two greys: no colour of a map has them, in no colour vision."""
    stripes = np.empty((1, 16, 3), np.uint8)
    stripes[:] = np.rint(np.array(style.theme.rgb("text 3")) * 255)
    stripes[:, :9] = np.rint(np.array(style.theme.rgb("divider")) * 255)
    prop = hatch.GetProperty()
    prop.SetColor(1.0, 1.0, 1.0)
    prop.SetLighting(False)
    prop.SetAmbient(0.0)
    prop.SetDiffuse(1.0)
    prop.SetOpacity(look.opacity)
    hatch.SetTexture(texture(stripes, True, repeat=True))
