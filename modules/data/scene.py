"""What a picture shows: layers with their looks, gathered in the scene of one view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Accuracy
from modules.data.geometry import Shown

Colour = str
"""A role ("line", "clay", "dust" ...) that the theme turns into a colour, or "#rrggbb"."""


@dataclass(frozen=True, eq=False)
class ColourMap:
    """Value -> colour. It carries no accuracy.

    Parameters
    ----------
    name : for legend and choice
    colours : (n, 3) float in [0, 1], from low to high
    scale : linear or logarithmic
    steps : number of discrete colours, 0 for a continuous map
    """

    FACTS: ClassVar[tuple[str, ...]] = ("name",)

    name: str
    colours: NDArray[np.float64]
    scale: Literal["linear", "logarithmic"] = "linear"
    steps: int = 0

    def facts(self) -> dict[str, Any]:
        """Its name."""
        return {"name": self.name}


@dataclass(frozen=True)
class Text:
    """Words in a picture: at places in space, or in a corner of the view.

    Parameters
    ----------
    words : one label each
    at : where its middle lies; () with a corner
    along : direction in which it runs; () for level. It is always drawn upright
    room : length in world units in which it has to find room; () where it needs none. What has no room is left out,
        and what would lie over a label before it: the best places come first
    corner : of the view, for words that belong to no place
    """

    words: tuple[str, ...]
    at: tuple[tuple[float, float, float], ...] = ()
    along: tuple[tuple[float, float, float], ...] = ()
    room: tuple[float, ...] = ()
    corner: Literal["", "top left", "top right", "bottom left", "bottom right"] = ""


@dataclass(frozen=True, kw_only=True)
class Colouring:
    """Colour by a value.

    Parameters
    ----------
    by : name of a field of the shape; "" for one colour
    map : colour map
    range : ends; None for the data's own
    """

    by: str
    map: ColourMap
    range: tuple[float, float] | None = None
    title: str = ""
    unit: str = ""


@dataclass(frozen=True, kw_only=True)
class SurfaceLook:
    """Polygons.

    Parameters
    ----------
    edges, wire : whether the edges of polygons are drawn too, or alone
    smooth : light runs on over the edges
    lit : whether a light falls on it; colours of what is not lit are those of the bar
    relief : lit from the north-west as on a map, slopes taken `light` times as steep
    """

    colour: Colour = "clay"
    colouring: Colouring | None = None
    opacity: float = 1.0
    edges: bool = False
    smooth: bool = True
    relief: bool = False
    light: float = 1.0
    lit: bool = True
    wire: bool = False


@dataclass(frozen=True, kw_only=True)
class LineLook:
    """Lines of a width in pixels at 100 %; every `major`-th level is drawn thicker."""

    colour: Colour = "line"
    colouring: Colouring | None = None
    width: float = 1.2
    opacity: float = 1.0
    dashed: bool = False
    major: int = 0


@dataclass(frozen=True, kw_only=True)
class PointLook:
    """Points of a size in pixels at 100 %."""

    colour: Colour = "dust"
    colouring: Colouring | None = None
    size: float = 2.0
    opacity: float = 1.0


@dataclass(frozen=True, kw_only=True)
class VolumeLook:
    """A volume by its transfer function: opacity at the ends of equal steps of the range."""

    colouring: Colouring
    opacity: tuple[float, ...] = (0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class ImageLook:
    """Samples on a plane: as a colour map, as relief lit from the north-west, or both.

    Parameters
    ----------
    relief : whether slopes are shaded, taken `exaggeration` times as steep
    interpolate : between samples; False shows each as a box of its own
    """

    colouring: Colouring | None = None
    relief: bool = False
    exaggeration: float = 1.0
    opacity: float = 1.0
    interpolate: bool = True


@dataclass(frozen=True, kw_only=True)
class ChartLook:
    """A curve, bars or a scatter of two columns; a band or bars of error between y and a third one, `upper`."""

    kind: Literal["curve", "bars", "scatter", "band", "error bars"] = "curve"
    x: str = ""
    y: str = ""
    upper: str = ""
    x_scale: Literal["linear", "logarithmic"] = "linear"
    y_scale: Literal["linear", "logarithmic"] = "linear"
    colour: Colour = "line"


@dataclass(frozen=True, kw_only=True)
class LabelLook:
    """Text, in points at 100 %."""

    size: float = 11.0
    colour: Colour = "text"


Look = SurfaceLook | LineLook | PointLook | VolumeLook | ImageLook | ChartLook | LabelLook


@dataclass(frozen=True, eq=False, kw_only=True)
class Layer:
    """A shape and how it looks; what it shows of an accuracy goes with it.

    Parameters
    ----------
    shape : Geometry, Samples, Table or Text
    look : one of the looks
    title : what is drawn, for the legend: "Contour lines every 100 m"
    shows : errors that the layer shows
    accuracy : of the shape
    """

    FACTS: ClassVar[tuple[str, ...]] = ("title", "bounds", "names")

    shape: Any
    look: Look
    title: str = ""
    shows: tuple[Shown, ...] = ()
    accuracy: Accuracy

    def facts(self) -> dict[str, Any]:
        """Title, and the shape's bounds and names."""
        inner = self.shape.facts() if hasattr(self.shape, "facts") else {}
        return {"title": self.title, "bounds": inner.get("bounds"), "names": inner.get("names", ())}


@dataclass(frozen=True, kw_only=True)
class SceneLook:
    """How a view is laid out; the camera is view data of the node and not here.

    Parameters
    ----------
    dimensions : 2 (from above, parallel) or 3
    theme : light or dark
    title : above the picture
    axes, legend : whether axes are drawn, and which corner the legend takes
    """

    dimensions: int = 2
    theme: Literal["light", "dark"] = "light"
    title: str = ""
    axes: bool = True
    legend: Literal["top left", "top right", "bottom left", "bottom right", "right"] = "right"
    exaggeration: float = 1.0
    """Of heights, in three dimensions."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """The layers of one view, in the order in which they are drawn.

    Parameters
    ----------
    layers : back to front in two dimensions
    look : layout and theme
    accuracy : of the scene itself; each layer has its own
    """

    FACTS: ClassVar[tuple[str, ...]] = ("layers", "dimensions")

    layers: tuple[Layer, ...]
    look: SceneLook
    accuracy: Accuracy

    def facts(self) -> dict[str, Any]:
        """Number of layers, dimensions."""
        return {"layers": len(self.layers), "dimensions": self.look.dimensions}
