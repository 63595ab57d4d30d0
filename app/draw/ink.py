"""What draws words and lines in pixels: a sheet of a picture, the painter of the window, text over a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from app.theme import Theme

WIDE = 0.56
"""Width of a digit of a sans serif, as a share of its size."""


class Ink(Protocol):
    """Sizes and widths are of 100 %; places are pixels from the upper left corner."""

    def px(self, value: float) -> float:
        """Pixels of a length at 100 %."""

    def extent(self, words: str, size: float, bold: bool = False) -> tuple[float, float]:
        """Width and height of words, in pixels."""

    def text(
        self, x: float, y: float, words: str, *, size: float = 11.0, role: str = "text", bold: bool = False,
        across: str = "left", up: str = "baseline", angle: float = 0.0, halo: str = "",
    ) -> None:  # fmt: skip
        """Words at a place."""

    def line(self, points: Sequence[Sequence[float]], *, role: str = "text", width: float = 1.0, dashed: bool = False) -> None:
        """A line through points."""

    def box(
        self, x: float, y: float, width: float, height: float, *, fill: str = "", edge: str = "", radius: float = 0.0,
        line: float = 1.0,
    ) -> None:  # fmt: skip
        """A rectangle from its upper left corner."""


class Overlay:
    """Words over a scene as actors of its renderer; they are used again from frame to frame.

    Parameters
    ----------
    renderer : where they are drawn
    scale : pixels of the window for one at 100 %
    """

    def __init__(self, renderer: Any, scale: float) -> None:
        self._renderer, self.scale = renderer, scale
        self._actors: list[Any] = []
        self._used = 0
        self._theme: Theme | None = None
        self._height = 0

    def begin(self, theme: Theme, height: int) -> None:
        """A new frame of a window so many pixels high."""
        self._theme, self._height, self._used = theme, height, 0

    def end(self) -> None:
        """What this frame did not use is not seen."""
        for left in self._actors[self._used :]:
            left.VisibilityOff()

    def px(self, value: float) -> float:
        """Pixels of a length at 100 %."""
        return value * self.scale

    def extent(self, words: str, size: float, bold: bool = False) -> tuple[float, float]:
        """About the width and height of words."""
        return WIDE * self.px(size) * len(words), self.px(size)

    def text(
        self, x: float, y: float, words: str, *, size: float = 11.0, role: str = "text", bold: bool = False,
        across: str = "left", up: str = "baseline", angle: float = 0.0, halo: str = "",
    ) -> None:  # fmt: skip
        """Words at a place."""
        from vtkmodules.vtkRenderingCore import vtkTextActor

        assert self._theme is not None
        if self._used == len(self._actors):
            made = vtkTextActor()
            made.PickableOff()
            self._renderer.AddViewProp(made)
            self._actors.append(made)
        actor = self._actors[self._used]
        self._used += 1
        actor.SetInput(words)
        actor.SetPosition(x, self._height - y)
        style = actor.GetTextProperty()
        style.SetFontFamilyToArial()
        style.SetFontSize(max(6, round(self.px(size))))
        style.SetOrientation(angle)
        style.SetJustification({"left": 0, "center": 1, "right": 2}[across])
        style.SetVerticalJustificationToBottom()
        style.SetColor(*self._theme.rgb(role))
        actor.VisibilityOn()

    def line(self, points: Sequence[Sequence[float]], *, role: str = "text", width: float = 1.0, dashed: bool = False) -> None:
        """None: the sides of the box are there."""

    def box(
        self, x: float, y: float, width: float, height: float, *, fill: str = "", edge: str = "", radius: float = 0.0,
        line: float = 1.0,
    ) -> None:  # fmt: skip
        """None."""
