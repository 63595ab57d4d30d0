"""Places to look at: flags over the whole network and the worst places of a shape, each brought into view by a key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.commands.budget import reach
from app.draw import numbers
from app.gui import icons, style
from app.gui.session import Session
from app.gui.widgets.parts import button
from modules.data.accuracy import Flag
from modules.data.geometry import Geometry
from modules.data.places import where
from modules.data.wires import Samples, Table
from modules.progress import Progress

NAMES: Final = {"kappa": "Slope too small for the error"}
CELLS, PART = 16.0, 5.0
"""After a zoom to a place so many grid cells are seen from top to bottom, or such a part of the whole if that is less."""
SIDE = 232
WORST: Final = "accuracy_mappers.worst.worst"


@dataclass(frozen=True)
class Spot:
    """A place to go to: what a node gives, where, and how much of the world is to be seen there."""

    node: str
    point: tuple[float, float, float]
    seen: float


class Places(QWidget):
    """A list at the left; at the right what the chosen row says, and buttons that go to its places.

    `zoomAsked` gives a `Spot`. Enter or a double-click goes to the next place.
    """

    zoomAsked = Signal(object)

    def __init__(
        self, session: Session, heads: Sequence[str], stretch: int, empty: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.session = session
        self.list = QTreeWidget()
        self.list.setHeaderLabels(list(heads))
        self.list.setRootIsDecorated(False)
        self.list.setUniformRowHeights(True)
        self.list.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.list.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.list.header().setStretchLastSection(False)
        self.list.header().setSectionResizeMode(stretch, QHeaderView.ResizeMode.Stretch)
        self.list.header().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.list.setStyleSheet("QTreeView::item { padding: 3px 8px; }")
        self.empty = style.labelled(empty, "quiet")
        self.empty.setWordWrap(True)
        self.words = style.labelled("")
        self.place = style.labelled("", "small")
        for label in (self.words, self.place):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.zoom = button("Zoom to", lambda: self.go(1), tip="Bring the next place into the middle of the view (Enter)")
        self.zoom.setIcon(icons.icon("zoomto"))
        self.back = button("Previous", lambda: self.go(-1), tip="The place before")
        self._build()
        self.at = -1
        self.list.currentItemChanged.connect(lambda *_: self._chosen())
        self.list.itemActivated.connect(lambda *_: self.go(1))
        style.watch().changed.connect(self.restyle)

    def _build(self) -> None:
        tools = QHBoxLayout()
        tools.setSpacing(6)
        for one in (self.zoom, self.back):
            tools.addWidget(one)
        tools.addStretch(1)
        self.side = QVBoxLayout()
        self.side.setSpacing(6)
        for label in (self.words, self.place):
            self.side.addWidget(label)
        self.side.addLayout(tools)
        self.side.addStretch(1)
        self.right = QWidget()
        self.right.setProperty("kind", "panel")
        self.right.setLayout(self.side)
        self.right.setFixedWidth(SIDE)
        left = QVBoxLayout()
        left.addWidget(self.empty, 0, Qt.AlignmentFlag.AlignTop)
        left.addWidget(self.list, 1)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 8, 12, 8)
        row.setSpacing(16)
        row.addLayout(left, 1)
        row.addWidget(self.right)

    def restyle(self) -> None:
        """Icons in the theme in force."""
        self.zoom.setIcon(icons.icon("zoomto"))

    def spots(self) -> int:
        """How many places the chosen row has."""
        raise NotImplementedError

    def spot(self, index: int) -> Spot | None:
        """One of them."""
        raise NotImplementedError

    def about(self) -> tuple[str, str]:
        """What the chosen row says, and of which place."""
        raise NotImplementedError

    def go(self, step: int) -> None:
        """Go to the next place of the chosen row, or to the one before."""
        n = self.spots()
        if n:
            self.at = (self.at + step) % n if self.at >= 0 else 0 if step > 0 else n - 1
            if found := self.spot(self.at):
                self.zoomAsked.emit(found)
            self.tell()

    def _chosen(self) -> None:
        self.at = -1
        self.tell()

    def tell(self) -> None:
        """Say what is chosen."""
        words, place = self.about()
        self.words.setText(words)
        self.place.setText(place)
        n = self.spots()
        self.zoom.setEnabled(n > 0)
        self.back.setVisible(n > 1)

    def show_rows(self, some: bool) -> None:
        """Show the list, or why it is empty."""
        self.empty.setVisible(not some)
        self.list.setVisible(some)
        self.right.setVisible(some)
        if some and self.row < 0:
            self.choose(0)
        self.tell()

    @property
    def row(self) -> int:
        """The chosen row, -1 for none."""
        return self.list.currentIndex().row()

    def choose(self, row: int) -> None:
        """Choose a row."""
        self.list.setCurrentIndex(self.list.model().index(row, 0))


class FlagsPage(Places):
    """What to look at twice, over the whole network: each flag once, at the first module that says it."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        heads, empty = ("Flag", "Places", "Said by"), "No flags: nothing here asks to be looked at twice."
        super().__init__(session, heads, 0, empty, parent)
        self.list.setAccessibleName("Flags")
        self.flags: list[tuple[str, str, Flag]] = []
        self.list.itemClicked.connect(lambda *_: session.select([self.flags[self.row][0]]))
        session.waveDone.connect(lambda _: self.refresh())
        session.networkChanged.connect(self._edited)
        self.refresh()

    def restyle(self) -> None:
        """Icons in the theme in force."""
        super().restyle()
        self.refresh()

    @property
    def count(self) -> int:
        """How many flags there are."""
        return len(self.flags)

    def _edited(self) -> None:
        if any(node not in self.session.network.nodes for node, _, _ in self.flags):
            self.refresh()

    def refresh(self) -> None:
        """Gather the flags."""
        kept = self.row
        found: dict[tuple[str, str], tuple[str, str, Flag]] = {}
        for node in self.session.network.order:
            for output in self.session.outputs(node) or {}:
                accuracy = self.session.accuracy(node, output)
                for flag in accuracy.flags if accuracy else ():
                    found.setdefault((flag.name, flag.words), (node, output, flag))
        self.flags = list(found.values())
        self.list.clear()
        for node, _, flag in self.flags:
            name = NAMES.get(flag.name, flag.name[:1].upper() + flag.name[1:])
            places = numbers.count(flag.count) if flag.items is not None else "all"
            item = QTreeWidgetItem([name, places, node])
            item.setIcon(0, icons.icon("flag", "flag"))
            item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight)
            item.setToolTip(0, f"{flag.words}\nEnter goes to its places")
            self.list.addTopLevelItem(item)
        if 0 <= kept < len(self.flags):
            self.choose(kept)
        self.show_rows(bool(self.flags))

    def spots(self) -> int:
        """Places of the chosen flag that are known."""
        if not 0 <= self.row < len(self.flags):
            return 0
        node, output, flag = self.flags[self.row]
        if flag.items is None or not len(flag.items):
            return 0
        return len(flag.items) if where(self._value(node, output), flag.place, flag.items[:1]) is not None else 0

    def spot(self, index: int) -> Spot | None:
        """One of them."""
        node, output, flag = self.flags[self.row]
        assert flag.items is not None
        value = self._value(node, output)
        at = where(value, flag.place, flag.items[index : index + 1])
        return None if at is None else _spot(node, value, at[0])

    def _value(self, node: str, output: str) -> Any:
        return (self.session.outputs(node) or {}).get(output)

    def about(self) -> tuple[str, str]:
        """The sentence of the flag, and which of its places is shown."""
        if not 0 <= self.row < len(self.flags):
            return "", ""
        node, output, flag = self.flags[self.row]
        sentence = f"{flag.words[:1].upper()}{flag.words[1:]}{'' if flag.words.endswith('.') else '.'}"
        if not 0 <= self.at < self.spots():
            return sentence, "" if self.spots() else "It speaks of the whole."
        spot = self.spot(self.at)
        number = "" if flag.values is None else f": {numbers.significant(float(flag.values[self.at]), 3)}"
        words = f"Place {self.at + 1} of {numbers.count(self.spots())}{number}"
        return sentence, f"{words}\n{_coordinates(self._value(node, output), spot.point)}" if spot else words


class WorstPage(Places):
    """The largest errors of a shape as a table, by the module that lists them; it can be put into the network."""

    COUNT = 20

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        empty = "Known when a shape has run whose errors are given, such as contour lines or a surface."
        super().__init__(session, ("", "Error", "Source", "x", "y", "z"), 2, empty, parent)
        self.list.setAccessibleName("Worst places")
        self.of = QComboBox()
        self.of.setAccessibleName("Worst places of")
        self.side.insertWidget(0, self.of)
        self.keep = button("Add to the network", self.add, link=True, tip="Put the module that lists them behind this shape")
        self.side.insertWidget(self.side.count() - 1, self.keep, 0, Qt.AlignmentFlag.AlignLeft)
        self.given: Any = None
        self.table: Any = None
        self.note = ""
        self.of.activated.connect(lambda _: self.refresh())
        session.selectionChanged.connect(self._follow)
        session.resultChanged.connect(lambda _: self._offer() if self.isVisible() else None)
        session.networkChanged.connect(lambda: self._offer() if self.isVisible() else None)

    def showEvent(self, event: object) -> None:
        """What is not seen is not looked for."""
        self._offer()

    @property
    def shape(self) -> tuple[str, str] | None:
        """(node, output) that is listed."""
        found = self.of.currentData()
        return (str(found[0]), str(found[1])) if found else None

    def _offer(self) -> None:
        """The shapes whose errors are known, those that come first in the network first."""
        names = []
        for node in self.session.network.order:
            for output, value in (self.session.outputs(node) or {}).items():
                if isinstance(value, Geometry) and value.origin is None and value.accuracy.terms:
                    names.append((node, output))
        kept = self.shape
        if names != [tuple(self.of.itemData(i)) for i in range(self.of.count())]:
            self.of.clear()
            for node, output in names:
                self.of.addItem(f"{node}.{output}", [node, output])
            if kept in names:
                self.of.setCurrentIndex(names.index(kept))
            elif any(n in self.session.selection for n, _ in names):
                self._follow()
        self.of.setVisible(len(names) > 1)
        self.refresh()

    def _follow(self) -> None:
        chosen = self.session.selection[:1]
        for i in range(self.of.count()):
            if chosen and self.of.itemData(i)[0] == chosen[0]:
                self.of.setCurrentIndex(i)
                self.refresh()
                return

    def refresh(self) -> None:
        """Ask the module for its table."""
        shape, table = self.shape, None
        record = self.session.catalogue.get(WORST)
        value = (self.session.outputs(shape[0]) or {}).get(shape[1]) if shape else None
        if record is not None and isinstance(value, Geometry) and shape is not None:
            job = lambda: record.function(value, Progress(), count=self.COUNT).table  # noqa: E731  # short, said once
            table = self.session.look("worst", shape[0], shape[1], self.session.runs.key(shape[0]), job=job)
        self._show(table)

    def _show(self, table: Any) -> None:
        if table is self.given and table is not None:
            return
        kept = table if isinstance(table, Table) else None
        self.given, self.table = table, kept.columns if kept else None
        self.note = " ".join(f"{f.words[:1].upper()}{f.words[1:]}." for f in kept.accuracy.flags) if kept else ""
        self.list.clear()
        columns = self.table or {}
        for i in range(len(columns.get("rank", ()))):
            size = numbers.quantity(float(columns["size"][i]), str(columns["unit"][i]), up=columns["sign"][i] == "≤")
            told = f"{columns['sign'][i]} {size}" if np.isfinite(columns["size"][i]) else "no bound"
            xyz = [numbers.significant(float(columns[a][i]), 5) for a in "xyz"]
            cells = [str(columns["rank"][i]), told, str(columns["term"][i]), *xyz]
            item = QTreeWidgetItem(cells)
            for column in (0, 1, 3, 4, 5):
                item.setTextAlignment(column, Qt.AlignmentFlag.AlignRight)
            self.list.addTopLevelItem(item)
        self.list.setColumnHidden(5, not np.any(columns.get("z", 0)))
        if isinstance(table, Exception):
            self.empty.setText(f"{str(table)[:1].upper()}{str(table)[1:]}.")
        self.show_rows(bool(columns))
        self.keep.setEnabled(bool(columns))

    def spots(self) -> int:
        """Each row is one place."""
        return int(self.table is not None and self.row >= 0)

    def spot(self, index: int) -> Spot | None:
        """Of the chosen row."""
        shape = self.shape
        row = self.row
        if shape is None or self.table is None or row < 0:
            return None
        value = (self.session.outputs(shape[0]) or {}).get(shape[1])
        return _spot(shape[0], value, [self.table[a][row] for a in "xyz"])

    def about(self) -> tuple[str, str]:
        """What the numbers are."""
        if self.table is None or self.shape is None or not len(self.table["rank"]):
            return "", ""
        quantity = self.table["quantity"][0]
        words = f"Largest errors of {quantity} in {self.shape[0]}. {self.note}".strip()
        return words, "Single sources, standard deviations as they are (k = 1)."

    def add(self) -> None:
        """Put the module behind the shape: one edit."""
        if self.shape is None or self.session.catalogue.get(WORST) is None:
            return
        from app.gui import edits

        node, output = self.shape
        held = edits.Held(node, output, "Geometry", True)
        grown, fresh = edits.add(
            self.session.network, WORST, edits.after(self.session.network, node), self.session.catalogue, held
        )
        self.session.edit("Add Worst places", grown)
        self.session.select([fresh])


def _spot(node: str, value: Any, at: Sequence[Any]) -> Spot:
    """The place, with a few cells around it in sight."""
    edge = getattr(value, "cell", None)
    inner = getattr(value, "samples", value)
    size = reach(inner.grid) if isinstance(inner, Samples) else reach(value)
    seen = min(CELLS * float(edge) if edge else np.inf, size / PART)
    seen = seen if np.isfinite(seen) else 1.0
    return Spot(node, (float(at[0]), float(at[1]), float(at[2])), seen)


def _coordinates(value: Any, point: tuple[float, float, float]) -> str:
    frame = getattr(getattr(getattr(value, "samples", value), "grid", value), "frame", None)
    units = frame.units if frame is not None else ("", "", "")
    named = zip("xyz", point, units, strict=True)
    return ", ".join(f"{n} {numbers.with_unit(numbers.significant(v, 5), u)}" for n, v, u in named if n != "z" or v)


