"""A sheet in pixels, drawn on with matplotlib's objects: no pyplot, nothing global, one sheet a thread."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.theme import FONTS, Theme

DPI = 100.0


@cache
def families() -> tuple[str, ...]:
    """The fonts of pictures that this machine has, in order of choice."""
    from matplotlib import font_manager

    there = {font.name for font in font_manager.fontManager.ttflist}
    return tuple(name for name in FONTS if name in there) or FONTS[-1:]


@cache
def heavy() -> int:
    """Weight of headings: semibold where the first font has it, else bold."""
    from matplotlib import font_manager

    weights = {font.weight for font in font_manager.fontManager.ttflist if font.name == families()[0]}
    return 600 if weights & {600, "semibold"} else 700


class Pen:
    """Draws in pixels from the upper left corner; sizes and widths are of 100 % and grow with `scale`.

    Parameters
    ----------
    size : width and height in pixels
    theme : colours by role
    scale : pixels for one at 100 %
    """

    def __init__(self, size: tuple[int, int], theme: Theme, scale: float) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.transforms import Affine2D

        self.width, self.height = size
        self.theme, self.scale = theme, scale
        self.figure = Figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI, facecolor=theme["view"])
        self.canvas = FigureCanvasAgg(self.figure)
        self._transform = Affine2D().scale(1.0, -1.0).translate(0.0, self.height)
        self._order = 10.0

    def px(self, value: float) -> float:
        """Pixels of a length at 100 %."""
        return value * self.scale

    def _add(self, artist: Any) -> None:
        self._order += 0.001
        artist.set_zorder(self._order)
        artist.set_transform(self._transform)
        self.figure.add_artist(artist)

    def _font(self, size: float, bold: bool) -> Any:
        from matplotlib.font_manager import FontProperties

        weight = heavy() if bold else 400
        return FontProperties(family=list(families()), size=self.px(size) * 72 / DPI, weight=weight)

    def extent(self, words: str, size: float, bold: bool = False) -> tuple[float, float]:
        """Width and height of words, in pixels."""
        if not words:
            return 0.0, 0.0
        renderer: Any = self.canvas.get_renderer()
        width, height, _ = renderer.get_text_width_height_descent(words, self._font(size, bold), False)
        return float(width), float(height)

    def wrapped(self, words: str, size: float, width: float, bold: bool = False) -> list[str]:
        """Words in lines that are at most so many pixels wide; a longer word is not broken."""
        lines: list[str] = []
        for word in words.split(" "):
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.extent(longer, size, bold)[0] <= width:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines

    def text(
        self,
        x: float,
        y: float,
        words: str,
        *,
        size: float = 11.0,
        role: str = "text",
        bold: bool = False,
        across: str = "left",
        up: str = "baseline",
        angle: float = 0.0,
        halo: str = "",
    ) -> None:
        """Words at a place; `halo` is the role of the ground that keeps them free of lines."""
        from matplotlib import patheffects
        from matplotlib.text import Text

        if not words:
            return
        text = Text(
            x, y, words, fontproperties=self._font(size, bold), color=self.theme[role], ha=across, va=up,
            rotation=angle, rotation_mode="anchor", parse_math=False,
        )  # fmt: skip
        if halo:
            text.set_path_effects([patheffects.withStroke(linewidth=self.px(3.2) * 72 / DPI, foreground=self.theme[halo])])
        self._add(text)

    def line(self, points: Sequence[Sequence[float]], *, role: str = "text", width: float = 1.0, dashed: bool = False) -> None:
        """A line through points."""
        from matplotlib.lines import Line2D

        xs, ys = zip(*points, strict=True)
        style: Any = (0, (4.0, 3.0)) if dashed else "-"
        thick = self.px(width) * 72 / DPI
        self._add(Line2D(xs, ys, color=self.theme[role], linewidth=thick, linestyle=style, solid_capstyle="butt"))

    def dots(self, points: Sequence[Sequence[float]], *, role: str, size: float) -> None:
        """Dots at points, of a size in pixels at 100 %."""
        from matplotlib.patches import Circle

        for x, y in points:
            self._add(Circle((x, y), self.px(size) / 2, facecolor=self.theme[role], edgecolor="none"))

    def box(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        *,
        fill: str = "",
        edge: str = "",
        radius: float = 0.0,
        line: float = 1.0,
    ) -> None:
        """A rectangle from its upper left corner, with round corners if wanted."""
        from matplotlib.patches import FancyBboxPatch, Rectangle

        colours: dict[str, Any] = {
            "facecolor": self.theme[fill] if fill else "none",
            "edgecolor": self.theme[edge] if edge else "none",
            "linewidth": self.px(line) * 72 / DPI if edge else 0.0,
        }
        if radius:
            style = f"round,pad=0,rounding_size={self.px(radius)}"
            self._add(FancyBboxPatch((x, y), width, height, boxstyle=style, mutation_aspect=1.0, **colours))
        else:
            self._add(Rectangle((x, y), width, height, **colours))

    def image(self, pixels: NDArray[Any], x: int, y: int) -> None:
        """Pixels placed as they are, their upper left corner at whole x, y; under all that is drawn."""
        self.figure.figimage(pixels, x, self.height - y - pixels.shape[0], origin="upper", zorder=1)

    def stamp(self, pixels: NDArray[Any], x: int, y: int) -> None:
        """Pixels placed as they are, over what was drawn before."""
        self._order += 0.001
        self.figure.figimage(pixels, x, self.height - y - pixels.shape[0], origin="upper", zorder=self._order)

    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 4) the sheet."""
        self.canvas.draw()
        return np.asarray(self.canvas.buffer_rgba(), dtype=np.uint8).copy()
