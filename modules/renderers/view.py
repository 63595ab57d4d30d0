"""Layers gathered in one view: a viewport in the window, a picture on the command line."""

from __future__ import annotations

from typing import Any

from modules.api import EXACT, Annotated, ChartLook, LabelLook, Layer, Literal, Range, Scene, SceneLook, renderer


@renderer("View", aliases=("render", "scene", "viewport", "picture", "display"), output="scene")
def view(
    layers: list[Layer],
    *,
    dimensions: Literal["auto", "2", "3"] = "auto",
    theme: Literal["light", "dark"] = "light",
    title: str = "",
    legend: Literal["right", "top left", "top right", "bottom left", "bottom right"] = "right",
    axes: bool = True,
    exaggeration: Annotated[float, Range(0.1, 100, log=True)] = 1.0,
) -> Scene:
    """The layers of one view, in the order of their wires: in two dimensions the last lies on top.

    Parameters
    ----------
    dimensions : 2 (from above, locked), 3, or automatic: 2 when all is flat
    theme : light for paper, dark for a screen
    title : above the picture
    legend : beside the picture, or in a corner of it; it cannot be hidden
    axes : whether axes with their numbers are drawn
    exaggeration : of heights in three dimensions; it stands in the legend when it is not 1

    Raises
    ------
    ValueError : the exaggeration is not above zero, or a logarithmic axis is to be shared with what is drawn on a linear one

    Accuracy: each layer goes on with its own; the view adds nothing to them. A picture adds half a pixel.
    """
    if not exaggeration > 0:
        raise ValueError(f"heights times {exaggeration:g} are no picture: give a number above zero")
    _share(layers)
    chosen = int(dimensions) if dimensions != "auto" else (2 if all(is_flat(layer) for layer in layers) else 3)
    look = SceneLook(
        dimensions=chosen,
        theme=theme,
        title=title,
        axes=axes,
        legend=legend,
        exaggeration=exaggeration if chosen == 3 else 1.0,
    )
    return Scene(layers=tuple(layers), look=look, accuracy=EXACT)


def _share(layers: list[Layer]) -> None:
    """Refuse what cannot be read off one pair of axes."""
    drawn = [one.look for one in layers if not isinstance(one.look, LabelLook)]
    scales = {(k.x_scale, k.y_scale) if isinstance(k, ChartLook) else ("linear", "linear") for k in drawn}
    if len(scales) > 1:
        raise ValueError(
            "a logarithmic axis cannot be shared with what is drawn on a linear one: give all charts the same scales, "
            "or each its own view"
        )


def is_flat(layer: Layer) -> bool:
    """Whether a layer lies in one plane z = const."""
    shape: Any = layer.shape
    grid = getattr(shape, "grid", None)
    if grid is not None:
        return bool(grid.dimensions < 3 and grid.bounds[4] == grid.bounds[5])
    if any(one.kind in ("sphere", "box") for one in getattr(shape, "primitives", ())):
        return False
    bounds = getattr(shape, "bounds", None)
    if bounds is not None:
        return bool(bounds[4] == bounds[5])
    return len({at[2] for at in getattr(shape, "at", ())}) <= 1
