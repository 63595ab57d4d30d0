"""What a layer says that it is, when nobody gave it a title."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from modules.data.geometry import Geometry
from modules.data.scene import ImageLook
from modules.data.wires import Samples


def number(value: float) -> str:
    """A number for words: real minus, thin space between thousands, no needless digits."""
    text = f"{value:.10g}"
    if "e" in text:
        return text.replace("-", "−")
    whole, dot, rest = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", "\u2009")
    return ("−" if value < 0 else "") + whole + dot + rest


def with_unit(text: str, unit: str) -> str:
    """Unit after a space that does not break."""
    return f"{text}\u00a0{unit}" if unit else text


def rounded(value: float) -> float:
    """The nearest of 1, 1.5, 2, 3, 5, 7 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return min((m * power for m in (1, 1.5, 2, 3, 5, 7, 10)), key=lambda m: abs(math.log(m / value)))


def levels_of(geometry: Geometry) -> list[float]:
    """The levels that a geometry was drawn at, ascending."""
    field = geometry.values.get("level")
    return [] if field is None else [float(v) for v in np.unique(np.asarray(field.values, float)) if math.isfinite(v)]


def at_levels(levels: Sequence[float], unit: str, one: str, many: str) -> str:
    """"Contour lines every 100 m", "Contour line at 0.5", "Contour lines at 1, 2 and 5 m" or "... at 12 levels"."""
    if len(levels) == 1:
        return f"{one} at {with_unit(number(levels[0]), unit)}"
    steps = np.diff(levels)
    if len(levels) > 2 and np.allclose(steps, step := round(float(np.median(steps)), 12), rtol=1e-6):
        return f"{many} every {with_unit(number(step), unit)}"
    if len(levels) <= 4:
        named = [number(v) for v in levels]
        return f"{many} at {', '.join(named[:-1])} and {with_unit(named[-1], unit)}"
    return f"{many} at {len(levels)} levels"


def of_lines(geometry: Geometry) -> str:
    """Of lines: their levels, else the geometry's name; nothing when they show an error, whose own words stand there."""
    levels = levels_of(geometry)
    if not levels:
        return "" if geometry.shows else headed(geometry.name) or "Lines"
    return at_levels(levels, geometry.values["level"].unit, "Contour line", "Contour lines")


def of_surface(geometry: Geometry, relief: bool, light: float) -> str:
    """Of a surface: its levels, else the geometry's name; and the light of the relief."""
    levels = levels_of(geometry)
    words = headed(geometry.name) or "Surface"
    if levels:
        words = at_levels(levels, geometry.values["level"].unit, "Surface", "Surfaces")
    return f"{words}, {lit(light)}" if relief else words


def of_points(geometry: Geometry) -> str:
    """Of points: nothing when they show an error, whose own words stand in the legend."""
    return "" if geometry.shows else headed(geometry.name) or "Points"


def of_image(samples: Samples, look: ImageLook) -> str:
    """Of an image: what it shows, and the light of the relief."""
    name = headed(samples.name)
    if look.colouring is None:
        return f"Relief{f' of {samples.name}' if samples.name else ''}, {lit(look.exaggeration)}"
    return f"{name or 'Values'}, {lit(look.exaggeration)}" if look.relief else name or "Values"


def headed(name: str) -> str:
    """A name as it stands at the head of a line."""
    return name[:1].upper() + name[1:]


def lit(factor: float) -> str:
    """Where the light comes from, and what was done to the slopes for it."""
    slopes = "" if factor == 1 else f", slopes ×{number(factor)}"
    return f"lit from the north-west{slopes}"
