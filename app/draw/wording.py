"""Labels of a window: placed anew before each frame, from the same rules as in a picture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import placing
from app.theme import Theme
from modules.data.scene import LabelLook, Scene, Text

MOST = 120
"""Labels of one view."""
TRIED = 1500
"""Places tried for a frame: the straightest come first."""
WIDE = 0.62
"""Width of a character, as a share of its size."""


class Wording:
    """The labels of one renderer.

    Parameters
    ----------
    renderer : where they are drawn
    scale : pixels of the window for one at 100 %
    """

    def __init__(self, renderer: Any, scale: float) -> None:
        self._renderer, self._scale = renderer, scale
        self._actors: list[Any] = []

    def update(self, scene: Scene, theme: Theme, project: placing.Project, size: tuple[int, int]) -> list[placing.Placed]:
        """Place the words of all label layers; `project` gives pixels from the upper left."""
        taken: list[placing.Placed] = []
        for layer in scene.layers:
            if not isinstance(layer.look, LabelLook) or not isinstance(layer.shape, Text):
                continue
            text, look = layer.shape, layer.look
            few = Text(text.words[:TRIED], text.at[:TRIED], text.along[:TRIED], text.room[:TRIED], text.corner)
            height = look.size * self._scale
            found = placing.place(
                few, project, lambda words, height=height: (WIDE * height * len(words), height),  # type: ignore[misc]  # bound now
                (0, 0, *size), pad=3 * self._scale, apart=150 * self._scale, taken=taken,
            )  # fmt: skip
            for one in found[: MOST - len(taken)]:
                self._draw(len(taken), one, look, theme, size[1])
                taken.append(one)
        for left in self._actors[len(taken) :]:
            left.VisibilityOff()
        return taken

    def _draw(self, i: int, label: placing.Placed, look: LabelLook, theme: Theme, height: int) -> None:
        from vtkmodules.vtkRenderingCore import vtkTextActor

        if i == len(self._actors):
            made = vtkTextActor()
            made.PickableOff()
            self._renderer.AddViewProp(made)
            self._actors.append(made)
        actor = self._actors[i]
        actor.SetInput(label.words)
        actor.SetPosition(label.x, height - label.y)
        style = actor.GetTextProperty()
        style.SetFontFamilyToArial()
        style.SetFontSize(max(6, round(look.size * self._scale)))
        style.SetOrientation(label.angle)
        style.SetJustificationToCentered()
        style.SetVerticalJustificationToCentered()
        style.SetColor(*theme.rgb(look.colour))
        style.SetBackgroundColor(*theme.rgb("view"))
        style.SetBackgroundOpacity(0.7)
        actor.VisibilityOn()


def in_pixels(share: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
    """Places in a window, from shares of its width and height."""
    return np.asarray(share * np.asarray(size, float))
