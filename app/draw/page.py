"""Where things stand on a page: title, plot, axes, scale bar, legend. All in pixels from the upper left corner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from app.draw import charts, numbers
from app.draw.extent import Box
from app.draw.ink import Ink
from app.draw.panel import WIDTH, Panel, fitted
from app.draw.parts import Legend
from app.draw.pen import Pen
from modules.data.grid import Frame
from modules.data.scene import SceneLook
from modules.data.units import is_length

MARGIN = 22.0
TICK = 4.0
TITLE = 15.0
INSET = 12.0
"""Of panels in a corner of the plot."""


@dataclass(frozen=True)
class Rect:
    """A rectangle in pixels; y downwards."""

    x: int
    y: int
    width: int
    height: int

    @property
    def right(self) -> int:
        """First column beyond it."""
        return self.x + self.width

    @property
    def bottom(self) -> int:
        """First row beyond it."""
        return self.y + self.height


@dataclass(frozen=True)
class Axis:
    """One axis of a flat picture: where its ticks stand in data, and what is written there."""

    name: str
    at: tuple[float, ...]
    words: tuple[str, ...]


@dataclass(frozen=True)
class Plan:
    """A page laid out.

    Parameters
    ----------
    plot : where the scene is drawn
    panel, at : the legend and its upper left corner
    """

    plot: Rect
    panel: Panel
    at: tuple[float, float]


def axis(name: str, unit: str, low: float, high: float, pixels: float, every: float, log: bool = False) -> Axis:
    """Ticks about `every` pixels apart at round places; many metres are told in kilometres.

    Parameters
    ----------
    log : `low` and `high` are exponents of ten
    """
    if log:
        places, told = charts.ticks(low, high, max(2, round(pixels / every)))
        return Axis(f"{name} ({unit})" if unit else name, tuple(places), tuple(told))
    shown, by = numbers.display_unit(unit, max(abs(low), abs(high), high - low) if unit == "m" else 0.0)
    wanted = max(2, round(pixels / every))
    at = numbers.ticks(low / by, high / by, wanted)
    words = numbers.labels(at)
    title = f"{name} ({shown})" if shown else name
    return Axis(title, tuple(v * by for v in at), tuple(words))


def plan(
    pen: Pen,
    look: SceneLook,
    legend: Legend,
    box: Box,
    frame: Frame,
    *,
    aspect: float | None,
    ground: str,
    logs: charts.Logs = charts.PLAIN,
) -> Plan:
    """Lay out a page.

    Parameters
    ----------
    aspect : width over height of the plot, kept exactly; None to fill the page
    ground : what is drawn on, for the samples in the legend
    logs : which axes are logarithmic
    """
    margin, width, height = pen.px(MARGIN), pen.width, pen.height
    top = margin + (pen.px(TITLE + 15) if look.title else 0.0)
    beside = look.legend == "right"
    column = min(pen.px(WIDTH), 0.42 * width) if beside else 0.0
    panel = fitted(legend, pen, column or min(pen.px(WIDTH), 0.5 * width), height - top - margin, on=ground, boxed=not beside)
    left, below = margin, margin
    if look.dimensions == 2 and look.axes:
        widest = _widest_label(pen, box, frame, height, logs[1])
        left, below = margin + widest + pen.px(TICK + 4 + 20), margin + pen.px(TICK + 16 + 18)
    gap = pen.px(24) if beside else 0.0
    room = (width - left - margin - column - gap, height - top - below)
    wide, high = room
    if aspect is not None:
        wide, high = (wide, wide / aspect) if wide / aspect <= high else (high * aspect, high)
    spare = (room[0] - wide) / 2
    plot = Rect(round(left + spare), round(top), max(16, round(wide)), max(16, round(high)))
    if aspect is not None and high < room[1] and look.dimensions == 2:
        plot = Rect(plot.x, round(top + min((room[1] - high) / 2, 0.5 * margin)), plot.width, plot.height)
    return Plan(plot, panel, _legend_place(pen, look, plot, panel, gap, beside))


def _widest_label(pen: Pen, box: Box, frame: Frame, height: float, log: bool) -> float:
    upright = axis(frame.axes[1], frame.units[1], box.low[1], box.high[1], height, pen.px(70), log)
    return max((pen.extent(w, 10.5)[0] for w in upright.words), default=0.0)


def _legend_place(pen: Pen, look: SceneLook, plot: Rect, panel: Panel, gap: float, beside: bool) -> tuple[float, float]:
    if beside:
        return plot.right + gap, float(plot.y)
    inset = pen.px(INSET)
    x = plot.x + inset if look.legend.endswith("left") else plot.right - inset - panel.width
    y = plot.y + inset if look.legend.startswith("top") else plot.bottom - inset - panel.height
    return float(round(x)), float(round(y))


def title(pen: Pen, look: SceneLook, plan: Plan) -> None:
    """The title, over the left edge of the plot."""
    if look.title:
        pen.text(plan.plot.x, pen.px(MARGIN + 12), look.title, size=TITLE, bold=True)


def flat_axes(pen: Ink, plot: Rect, view: Box, frame: Frame, logs: charts.Logs = charts.PLAIN) -> None:
    """Frame, ticks, numbers and names of a flat picture; `view` is the part of the plane that is seen."""
    edge = 0.5
    corners = [(plot.x - edge, plot.y - edge), (plot.right + edge, plot.y - edge), (plot.right + edge, plot.bottom + edge)]
    pen.line([*corners, (plot.x - edge, plot.bottom + edge), corners[0]], role="edge")
    tick = pen.px(TICK)
    across = axis(frame.axes[0], frame.units[0], view.low[0], view.high[0], plot.width, pen.px(95), logs[0])
    base = plot.bottom + tick + pen.px(13)
    for at, words in zip(across.at, across.words, strict=True):
        x = plot.x + (at - view.low[0]) / (view.sides[0] or 1.0) * plot.width
        pen.line([(x, plot.bottom), (x, plot.bottom + (tick if words else tick / 2))], role="edge")
        pen.text(x, base, words, size=10.5, role="text 2", across="center")
    pen.text(plot.x + plot.width / 2, base + pen.px(18), across.name, size=11, role="text 2", across="center")
    upright = axis(frame.axes[1], frame.units[1], view.low[1], view.high[1], plot.height, pen.px(70), logs[1])
    widest = max((pen.extent(w, 10.5)[0] for w in upright.words), default=0.0)
    for at, words in zip(upright.at, upright.words, strict=True):
        y = plot.bottom - (at - view.low[1]) / (view.sides[1] or 1.0) * plot.height
        pen.line([(plot.x - (tick if words else tick / 2), y), (plot.x, y)], role="edge")
        pen.text(plot.x - tick - pen.px(4), y + pen.px(3.8), words, size=10.5, role="text 2", across="right")
    x = plot.x - tick - pen.px(4) - widest - pen.px(8)
    pen.text(x, plot.y + plot.height / 2, upright.name, size=11, role="text 2", across="center", angle=90)


def scale_bar(pen: Ink, plot: Rect, view: Box, frame: Frame, cell: float | None, taken: str) -> None:
    """A bar of round length, in the lower corner that the legend leaves free; with the cells that it spans."""
    unit = frame.units[0]
    if not is_length(unit) or frame.units[1] != unit or not view.sides[0]:
        return
    across = plot.width / view.sides[0]
    length, words = _bar_of(pen, view.sides[0], across, unit, cell)
    wide = length * across + pen.px(24)
    high = pen.px(34)
    left = plot.x + pen.px(INSET) if taken != "bottom left" else plot.right - pen.px(INSET) - wide
    top = plot.bottom - pen.px(INSET) - high
    pen.box(left, top, wide, high, fill="panel", edge="edge", radius=4)
    start, base, rise = left + pen.px(12), top + high - pen.px(9), pen.px(4)
    end = start + length * across
    pen.line([(start, base - rise), (start, base), (end, base), (end, base - rise)], role="text", width=1.3)
    pen.text(start, top + pen.px(15), "0", size=10.5, role="text 2")
    pen.text(end, top + pen.px(15), words, size=10.5, role="text 2", across="right")


def _bar_of(pen: Ink, span: float, across: float, unit: str, cell: float | None) -> tuple[float, str]:
    """The shortest round length under whose bar its words have room, and the words; the cells are left out of narrow maps."""
    power = 10.0 ** math.floor(math.log10(0.05 * span))
    lengths = [m * power for m in (1.0, 2.0, 5.0, 10.0, 20.0, 50.0) if m * power <= 0.8 * span]
    for cells in (cell, None):
        for length in lengths:
            shown, by = numbers.display_unit(unit, 5 * length)
            words = numbers.with_unit(numbers.labels([length / by])[0], shown)
            if cells:
                words += f", {numbers.significant(length / cells, 3)}{numbers.SPACE}cells"
            if length * across >= pen.extent(f"0     {words}", 10.5)[0]:
                return length, words
    return lengths[-1], words


def corner_words(pen: Pen, plot: Rect, corner: str, lines: tuple[str, ...], size: float, role: str) -> None:
    """Words in a corner of the plot."""
    x = plot.x + pen.px(INSET) if corner.endswith("left") else plot.right - pen.px(INSET)
    across = "left" if corner.endswith("left") else "right"
    for i, line in enumerate(lines):
        up = i if corner.startswith("top") else i - len(lines) + 1
        y = plot.y + pen.px(INSET + size) if corner.startswith("top") else plot.bottom - pen.px(INSET)
        pen.text(x, y + up * pen.px(1.5 * size), line, size=size, role=role, across=across, halo="view")


Project = Callable[[float, float, float], tuple[float, float]]
"""A point of the world to pixels of the page."""
