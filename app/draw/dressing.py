"""What all looks share: the style of a view, bare actors, colours by a table."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from app.draw import relief
from app.theme import Theme, rgb
from modules.data.geometry import Geometry
from modules.data.scene import Colouring, Layer


@dataclass(frozen=True)
class Style:
    """What a view adds to a layer's own look.

    Parameters
    ----------
    theme : of the view
    ground : what lines and points lie on: the bare view, or clay
    scale : of widths and sizes; pixels of the window for one at 100 %
    extent : longest side of the scene, for the length of dashes
    """

    theme: Theme
    ground: Literal["view", "clay"] = "view"
    scale: float = 1.0
    extent: float = 1.0


Props = list[Any]


@dataclass(frozen=True)
class Kind:
    """How one kind of look is drawn."""

    made: Callable[[], Props]
    key: Callable[[Layer, Style], Hashable]
    feed: Callable[[Props, Layer, Style], None]
    dress: Callable[[Props, Layer, Style], None]


def actor() -> Any:
    """An actor with a mapper, both bare."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    made, mapper = vtkActor(), vtkPolyDataMapper()
    mapper.ScalarVisibilityOff()
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    made.SetMapper(mapper)
    return made


def frame_actor(colour: tuple[float, float, float], width: float) -> Any:
    """The bare actor of the box around a scene."""
    box = actor()
    box.PickableOff()
    prop = box.GetProperty()
    prop.SetColor(*colour)
    prop.SetLineWidth(width)
    prop.LightingOff()
    return box


def by(layer: Layer) -> tuple[Hashable, ...]:
    """The shape, and the values that give its colours: what the data of most looks depends on."""
    colouring = getattr(layer.look, "colouring", None)
    return (id(layer.shape), colouring.by if colouring else "")


def field_of(layer: Layer, colouring: Colouring) -> tuple[NDArray[Any], str]:
    """The values of a geometry that give colours, and whether they lie on points, cells or segments.

    Raises
    ------
    ValueError : no such values
    """
    shape: Geometry = layer.shape
    if colouring.by not in shape.values:
        raise ValueError(f"{layer.title or 'a layer'} is coloured by {colouring.by!r}, which its geometry has not")
    found = shape.values[colouring.by]
    values = np.asarray(found.values, float)
    return (np.linalg.norm(values, axis=1) if values.ndim > 1 else values), found.place


def paint(
    mapper: Any, colouring: Colouring | None, values: NDArray[Any] | None, unknown: tuple[float, float, float] = (0.5, 0.5, 0.5)
) -> None:
    """Colours of the values, by a table; or none.

    Parameters
    ----------
    unknown : the colour of what has no value
    """
    if colouring is None or values is None:
        mapper.ScalarVisibilityOff()
        return
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkLookupTable

    finite = values[np.isfinite(values)]
    low, high = colouring.range or ((float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0))
    colours = relief.table(colouring.map)
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colours))
    rgba = np.rint(np.column_stack([colours, np.ones(len(colours))]) * 255).astype(np.uint8)
    table.SetTable(numpy_to_vtk(rgba, deep=True))
    table.SetNanColor(*unknown, 1.0)
    if colouring.map.scale == "logarithmic":
        table.SetScaleToLog10()
    table.SetTableRange(low, high)
    mapper.SetLookupTable(table)
    mapper.SetUseLookupTableScalarRange(True)
    mapper.SetColorModeToMapScalars()
    mapper.SetInterpolateScalarsBeforeMapping(True)
    mapper.ScalarVisibilityOn()


def flat(prop: Any, colour: str, opacity: float) -> None:
    """A colour that no light changes."""
    prop.SetColor(*rgb(colour))
    prop.SetOpacity(opacity)
    prop.LightingOff()


def texture(image: NDArray[np.uint8], smooth: bool, repeat: bool = False) -> Any:
    """An image, row 0 lowest, as a texture."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    height, width, channels = image.shape
    data, made = vtkImageData(), vtkTexture()
    data.SetDimensions(width, height, 1)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(image).reshape(-1, channels), deep=True))
    made.SetInputData(data)
    made.SetInterpolate(smooth)
    made.SetColorModeToDirectScalars()
    made.SetRepeat(repeat)
    if not repeat:
        made.EdgeClampOn()
    return made
