"""The read-out beside a picked place: what was met, what is known of its accuracy, what one can do with the place."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QPoint, QPointF, Qt, Signal
from PySide6.QtGui import QGuiApplication, QMouseEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from app.gui import icons, style
from app.gui.widgets.parts import tool
from app.readout import Line, Readout

WIDE = 372
GAP = 22

SPACE = "\u00a0"

Deed = tuple[str, str, Callable[[], object]]
"""Words of a button, its tip, what it does."""


class PickBox(QFrame):
    """A panel over the picture. Its words can be selected; it can be dragged aside."""

    closed = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.readout: Readout | None = None
        self._from: QPointF | None = None
        self._free = False
        self.setProperty("kind", "readout")
        self.setAccessibleName("Read-out")
        self.setFixedWidth(WIDE)
        self.title = style.labelled("", "section")
        self.title.setWordWrap(True)
        self.copy = tool("copy", "Copy the read-out as text", self._copy)
        self.close_tool = tool("close", "Close (Esc)", self.closed.emit)
        head = QHBoxLayout()
        head.setSpacing(2)
        head.addWidget(self.title, 1)
        head.addWidget(self.copy, 0, Qt.AlignmentFlag.AlignTop)
        head.addWidget(self.close_tool, 0, Qt.AlignmentFlag.AlignTop)
        self.body = QScrollArea()
        self.body.setWidgetResizable(True)
        self.body.setFrameShape(QFrame.Shape.NoFrame)
        self.body.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.foot = QHBoxLayout()
        self.foot.setSpacing(8)
        column = QVBoxLayout(self)
        column.setContentsMargins(14, 10, 8, 12)
        column.setSpacing(4)
        column.addLayout(head)
        column.addWidget(self.body, 1)
        column.addLayout(self.foot)
        self.hide()

    def wait(self, words: str) -> None:
        """Say what is being done, or that nothing is there."""
        self.readout = None
        self._fill(words, _column([_label(words, "quiet")]), ())

    def tell(self, readout: Readout, deeds: Sequence[Deed] = ()) -> None:
        """Show what is known of a place."""
        self.readout = readout
        parts: list[QWidget] = [_label(readout.place, "small")]
        if readout.values:
            parts.append(_label("   ".join(f"{name} {number}".replace(" ", SPACE) for name, number in readout.values), "small"))
        summary = _label(readout.summary)
        summary.setContentsMargins(0, 5, 0, 5)
        parts.append(summary)
        if readout.lines:
            parts.append(_lines(readout.lines))
        if any(one.number.startswith("±") for one in readout.lines):
            parts.append(_label(f"± is k = {readout.k:g} standard deviations", "faint"))
        if readout.flags:
            parts += [_rule(), *(_flag(words) for words in readout.flags)]
        self._fill(readout.title, _column(parts), deeds)
        self.setAccessibleDescription(readout.text())

    def _fill(self, title: str, body: QWidget, deeds: Sequence[Deed]) -> None:
        self.title.setText(title)
        self.copy.setVisible(self.readout is not None)
        self.body.setWidget(body)
        while (item := self.foot.takeAt(0)) is not None:
            widget = item.widget()
            if widget is not None:
                widget.deleteLater()
        for words, tip, do in deeds:
            button = QPushButton(words)
            button.setProperty("compact", True)
            button.setToolTip(tip)
            button.clicked.connect(lambda _=False, do=do: do())
            self.foot.addWidget(button)
        if deeds:
            self.foot.addStretch(1)
        self.show()
        self.raise_()
        self.arrange()

    def arrange(self) -> None:
        """As high as it needs to be, and within the parent."""
        parent, body = self.parentWidget(), self.body.widget()
        if parent is None or body is None:
            return
        column = body.layout()
        inside = column.heightForWidth(WIDE - 26) if column is not None else body.sizeHint().height()
        head = max(26, self.title.heightForWidth(WIDE - 90))
        foot = 38 if self.foot.count() else 0
        self.setFixedHeight(min(parent.height() - 16, inside + head + foot + 34))
        self._inside(self.pos())

    def beside(self, at: QPointF) -> None:
        """Stand beside a place of the parent, unless it was dragged somewhere."""
        parent = self.parentWidget()
        if self._free or parent is None:
            return
        right = at.x() + GAP + self.width() <= parent.width()
        x = at.x() + GAP if right else at.x() - GAP - self.width()
        self._inside(QPoint(round(x), round(at.y() - 40)))

    def _inside(self, at: QPoint) -> None:
        parent = self.parentWidget()
        if parent is not None:
            room = parent.size() - self.size()
            self.move(max(8, min(at.x(), room.width() - 8)), max(8, min(at.y(), room.height() - 8)))

    def release(self) -> None:
        """Follow places again."""
        self._free = False

    def _copy(self) -> None:
        if self.readout is not None:
            QGuiApplication.clipboard().setText(self.readout.text())

    def restyle(self) -> None:
        """In another theme."""
        for one in (self.copy, self.close_tool):
            one.setIcon(icons.icon(str(one.property("drawing")), "text 2"))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to move it."""
        self._from = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move it."""
        if self._from is not None:
            self._free = True
            self._inside(self.mapToParent(event.position() - self._from).toPoint())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Leave it there."""
        self._from = None


def _column(parts: Sequence[QWidget]) -> QWidget:
    made = QWidget()
    made.setProperty("kind", "panel")
    column = QVBoxLayout(made)
    column.setContentsMargins(0, 0, 6, 0)
    column.setSpacing(3)
    for part in parts:
        column.addWidget(part)
    column.addStretch(1)
    return made


def _label(words: str, kind: str = "") -> QLabel:
    made = style.labelled(words, kind)
    made.setWordWrap(True)
    made.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    return made


def _lines(lines: Sequence[Line]) -> QWidget:
    """A row a source: sign, number, words; below them what it is of and where it arose."""
    made = QWidget()
    grid = QGridLayout(made)
    grid.setContentsMargins(0, 0, 0, 0)
    grid.setHorizontalSpacing(10)
    grid.setVerticalSpacing(0)
    grid.setColumnMinimumWidth(0, 20)
    grid.setColumnMinimumWidth(1, 72)
    grid.setColumnStretch(2, 1)
    top = Qt.AlignmentFlag.AlignTop
    for i, one in enumerate(lines):
        sign = _plain(one.sign, "" if one.sign in "=?" else "sign")
        sign.setToolTip(one.rigour)
        number = _plain(one.number, "title")
        words = _label(one.words)
        words.setToolTip(one.rule)
        grid.addWidget(sign, 2 * i, 0, top)
        if one.number:
            grid.addWidget(number, 2 * i, 1, top)
        grid.addWidget(words, 2 * i, 2 if one.number else 1, 1, 1 if one.number else 2)
        if one.stage:
            origin = _plain(f"{one.quantity}, {one.stage}", "faint")
            origin.setContentsMargins(0, 0, 0, 4)
            grid.addWidget(origin, 2 * i + 1, 2)
    return made


def _plain(words: str, kind: str) -> QLabel:
    made = style.labelled(words, kind)
    made.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    return made


def _flag(words: str) -> QWidget:
    made = QWidget()
    row = QHBoxLayout(made)
    row.setContentsMargins(0, 2, 0, 2)
    row.setSpacing(8)
    picture = QLabel()
    picture.setPixmap(icons.pixmap("flag", "flag"))
    row.addWidget(picture, 0, Qt.AlignmentFlag.AlignTop)
    row.addWidget(_label(words), 1)
    return made


def _rule() -> QFrame:
    made = QFrame()
    made.setProperty("kind", "line")
    return made
