"""The legend as it stands in a picture: measured first, then drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.draw import numbers
from app.draw.parts import Bar, Entry, Legend, Swatch
from app.draw.pen import Pen
from app.draw.relief import table
from modules.data.scene import ColourMap

TEXT = 11.0
LEADING = 17.0
PAD = 12.0
GUTTER = 24.0
"""Column of signs and samples."""
GAP = 9.0
WIDTH = 292.0
SMALLEST = 0.55

Ink = Callable[[float, float], None]


@dataclass(frozen=True)
class Row:
    """A piece of the panel: its height, and what draws it when its upper left corner is known."""

    height: float
    ink: Ink | None = None


class Panel:
    """A legend set in a column of a width, all in pixels.

    Parameters
    ----------
    ground : what lines and dust lie on, for the samples of their colours
    boxed : whether it has a ground and a border
    """

    def __init__(
        self, legend: Legend, pen: Pen, width: float, *, shrink: float = 1.0, on: str = "view", boxed: bool = True
    ) -> None:
        self.pen, self.legend, self.width = pen, legend, width
        self.unit = pen.scale * shrink
        self.shrink, self.on, self.boxed = shrink, on, boxed
        self.inset = PAD * self.unit if boxed else 0.0
        everything = [*(e for b in legend.drawn for e in b.entries), *legend.not_drawn]
        widest = max((self._wide(e.number) for e in everything), default=0.0)
        self.words = GUTTER * self.unit + (widest + 12 * self.unit if widest else 0.0)
        self.rows = self._rows()

    @property
    def height(self) -> float:
        """In pixels."""
        return sum(r.height for r in self.rows) + 2 * self.inset

    def draw(self, x: float, y: float) -> None:
        """Draw it with its upper left corner at x, y."""
        if self.boxed:
            self.pen.box(x, y, self.width, self.height, fill="panel", edge="edge", radius=4)
        y += self.inset
        for row in self.rows:
            if row.ink:
                row.ink(x + self.inset, y)
            y += row.height

    # --- rows

    def _rows(self) -> list[Row]:
        rows: list[Row] = []
        for i, block in enumerate(self.legend.drawn):
            rows += [self._gap(8)] if i else []
            rows += self._title(block.title, block.swatch) if block.title else []
            rows += self._bar(block.bar) if block.bar else []
            rows += [row for entry in block.entries for row in self._entry(entry)]
            rows += [self._boxed(words, self.words if block.entries else 0.0) for words in block.boxes]
        if self.legend.not_drawn:
            rows += [self._rule()] if rows else []
            rows.append(self._plain("Not drawn", "text 2"))
            rows += [row for entry in self.legend.not_drawn for row in self._entry(entry)]
        if self.legend.flags:
            rows += [self._gap(8)] if rows else []
            rows += [row for words in self.legend.flags for row in self._flag(words)]
        if self.legend.footer:
            rows.append(self._gap(8))
            rows += [self._plain(line, "text 3", 10.5) for line in self._wrap(self.legend.footer, 0.0, 10.5)]
        return rows

    def _gap(self, height: float) -> Row:
        return Row(height * self.unit)

    def _rule(self) -> Row:
        def ink(x: float, y: float) -> None:
            at = round(y + 10 * self.unit) + 0.5
            self.pen.line([(x, at), (x + self.width - 2 * self.inset, at)], role="divider")

        return Row(20 * self.unit, ink)

    def _plain(self, words: str, role: str, size: float = TEXT) -> Row:
        return Row(LEADING * self.unit, lambda x, y: self._write(x, y, words, role=role, size=size))

    def _title(self, title: str, swatch: Swatch | None) -> list[Row]:
        start = (GUTTER + 4) * self.unit if swatch else 0.0
        lines = self._wrap(title, start, 12.0, bold=True)
        rows: list[Row] = []
        for i, line in enumerate(lines):

            def ink(x: float, y: float, line: str = line, first: bool = i == 0) -> None:
                self._write(x + start, y, line, bold=True, size=12.0)
                if swatch and first:
                    self._sample(x, y + 0.52 * LEADING * self.unit, swatch)

            rows.append(Row((LEADING + 1) * self.unit, ink))
        return rows

    def _entry(self, entry: Entry) -> list[Row]:
        start = self.words if entry.number else GUTTER * self.unit
        rows = []
        for i, line in enumerate(self._wrap(entry.words, start)):

            def ink(x: float, y: float, line: str = line, first: bool = i == 0) -> None:
                if first:
                    self._sign(x, y, entry)
                    self._write(x + GUTTER * self.unit, y, entry.number)
                self._write(x + start, y, line)

            rows.append(Row(LEADING * self.unit, ink))
        notes = [line for note in entry.notes for line in self._wrap(note, start)]
        for i, line in enumerate(notes):

            def note_ink(x: float, y: float, line: str = line, last: bool = i == len(notes) - 1) -> None:
                self._write(x + start, y, line, role="text 2")
                if last and entry.swatch:
                    self._sample(x + GUTTER * self.unit, y + 0.52 * LEADING * self.unit, entry.swatch)

            rows.append(Row(LEADING * self.unit, note_ink))
        return rows

    def _boxed(self, words: str, start: float) -> Row:
        def ink(x: float, y: float) -> None:
            wide = self._wide(words, bold=True) + 12 * self.unit
            left = min(x + start, x + self.width - 2 * self.inset - wide)
            self.pen.box(left, y + 2 * self.unit, wide, 18 * self.unit, edge="text", radius=4 * self.shrink)
            self._write(left + 6 * self.unit, y + 2.5 * self.unit, words, bold=True)

        return Row(23 * self.unit, ink)

    def _flag(self, words: str) -> list[Row]:
        rows = []
        for i, line in enumerate(self._wrap(words, GUTTER * self.unit)):

            def ink(x: float, y: float, line: str = line, first: bool = i == 0) -> None:
                if first:
                    self._pennant(x, y)
                self._write(x + GUTTER * self.unit, y, line)

            rows.append(Row(LEADING * self.unit, ink))
        return rows

    # --- pieces

    def _wrap(self, words: str, start: float, size: float = TEXT, bold: bool = False) -> list[str]:
        room = self.width - 2 * self.inset - start
        return self.pen.wrapped(words, size * self.shrink, max(room, 40 * self.unit), bold)

    def _wide(self, words: str, size: float = TEXT, bold: bool = False) -> float:
        return self.pen.extent(words, size * self.shrink, bold)[0]

    def _write(self, x: float, y: float, words: str, *, role: str = "text", size: float = TEXT, bold: bool = False) -> None:
        self.pen.text(x, y + 12.5 * self.unit, words, size=size * self.shrink, role=role, bold=bold)

    def _sign(self, x: float, y: float, entry: Entry) -> None:
        role = "text" if entry.rigour in ("exact", "unknown") else "brass"
        size = TEXT * (1.35 if entry.sign == "~" else 1.0)
        drop = 1.2 * self.unit if entry.sign == "~" else 0.0
        self._write(x, y + drop, entry.sign, role=role, size=size, bold=True)

    def _pennant(self, x: float, y: float) -> None:
        u = self.unit
        pole, top = x + 2 * u, y + 3.5 * u
        shape = ((0, 11), (0, 0), (9, 0), (6, 3), (9, 6), (0, 6))
        self.pen.line([(pole + a * u, top + b * u) for a, b in shape], role="flag", width=1.4 * self.shrink)

    def _sample(self, x: float, y: float, swatch: Swatch) -> None:
        u, role = self.unit, self._role(swatch.colour)
        if swatch.kind == "line":
            self.pen.line([(x, y), (x + 20 * u, y)], role=role, width=max(1.0, swatch.size), dashed=swatch.dashed)
        elif swatch.kind == "surface":
            self.pen.box(x, y - 6 * u, 18 * u, 12 * u, fill=role, edge="edge", line=0.8)
        else:
            places = SPECKS if swatch.kind == "dust" else SPECKS[:1]
            size = min(5.0, max(2.0, swatch.size))
            self.pen.dots([(x + a * u, y + b * u) for a, b in places], role=role, size=size)

    def _role(self, colour: str) -> str:
        return self.pen.theme.on(colour, "clay" if self.on == "clay" and self.pen.theme.name == "light" else "view")

    def _bar(self, bar: Bar) -> list[Row]:
        colours = Row(16 * self.unit, lambda x, y: self._colours(x, y, bar))
        return [colours, Row(18 * self.unit, lambda x, y: self._ticks(x, y, bar))]

    def _length(self) -> float:
        return min(self.width - 2 * self.inset, 240 * self.unit)

    def _colours(self, x: float, y: float, bar: Bar) -> None:
        map = ColourMap(bar.title, np.asarray(bar.colours), bar.scale, bar.steps)
        length, top = self._length(), y + 6 * self.unit
        n = max(2, round(length))
        colours = table(map, n)
        pixels = np.empty((max(1, round(8 * self.unit)), n, 4), np.uint8)
        pixels[..., :3], pixels[..., 3] = np.rint(colours * 255), 255
        left, upper = round(x), round(top)
        self.pen.stamp(pixels, left, upper)
        self.pen.box(left, upper, n, pixels.shape[0], edge="edge", line=0.8)

    def _ticks(self, x: float, y: float, bar: Bar) -> None:
        length, left = self._length(), round(x)
        if bar.scale == "logarithmic":
            at = numbers.decades(bar.low, bar.high)
            places = np.log(np.array(at) / bar.low) / np.log(bar.high / bar.low)
            words = [numbers.significant(v) for v in at]
        else:
            at = [bar.low, (bar.low + bar.high) / 2, bar.high]
            places = np.array([0.0, 0.5, 1.0])
            words = numbers.along(at)
        words = self._ended(words, bar)
        for word, place in zip(words, places, strict=True):
            mark = left + float(place) * length
            self.pen.line([(mark, y - 2 * self.unit), (mark, y + 1.5 * self.unit)], role="edge")
            wide = self._wide(word, 10.5)
            start = min(max(mark - wide / 2, left), left + length - wide)
            self._write(start, y, word, role="text 2", size=10.5)

    def _ended(self, words: list[str], bar: Bar) -> list[str]:
        """The last number with its unit, and a plus where values lie beyond the end."""
        words = list(words)
        if words:
            words[-1] = numbers.with_unit(words[-1], bar.unit) + ("\u00a0+" if bar.over else "")
            words[0] = f"<\u00a0{words[0]}" if bar.under else words[0]
        return words


SPECKS = ((5.0, -1.5), (9.0, 3.0), (12.5, -3.5), (15.5, 1.0), (19.5, -1.0), (8.0, -3.8), (13.0, 4.2))


def fitted(legend: Legend, pen: Pen, width: float, height: float, *, on: str, boxed: bool) -> Panel:
    """The panel at full size, or as much smaller as it must be to fit a height; nothing of it is ever left out."""
    shrink = 1.0
    while True:
        panel = Panel(legend, pen, width, shrink=shrink, on=on, boxed=boxed)
        if panel.height <= height or shrink <= SMALLEST:
            return panel
        shrink = max(SMALLEST, shrink - 0.06)
