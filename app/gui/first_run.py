"""The first page: what can be done, what was open before, examples as pictures; and what a killed process left."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QPen, QPixmap
from PySide6.QtWidgets import QFrame, QGridLayout, QHBoxLayout, QLabel, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from app import paths
from app.gui import icons, style
from app.gui.actions import by_id
from app.gui.recovery import Lost
from app.gui.widgets.parts import button, line

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow

EXAMPLES = (
    ("jacksboro-detail", "Contours with their dust", "How far may each line lie?", "≤"),
    ("jacksboro-relief", "The same on its relief", "Lines and dust on the surface", "~"),
    ("thesis-3-12-background", "Error as a background", "Where is the line least certain?", "~"),
)
SIGNS = (("=", "exact"), ("≤", "proven"), ("~", "estimated"), ("n=", "sampled"), ("?", "not known"))
LETTERS = 44
PICTURE = QSize(298, 216)


class FirstRun(QScrollArea):
    """The page."""

    def __init__(self, window: MainWindow, lost: list[Lost]) -> None:
        super().__init__(window)
        self.owner = window
        self.lost = list(lost)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        style.watch().changed.connect(self.build)
        self.build()

    def build(self) -> None:
        """Make it anew."""
        body = QWidget()
        body.setProperty("kind", "panel")
        outer = QHBoxLayout(body)
        outer.setContentsMargins(64, 44, 64, 32)
        outer.setSpacing(64)
        outer.addStretch(1)
        outer.addLayout(self._left())
        outer.addLayout(self._right())
        outer.addStretch(1)
        self.setWidget(body)

    # --- left

    def _left(self) -> QVBoxLayout:
        column = QVBoxLayout()
        column.setSpacing(6)
        column.addLayout(self._name())
        column.addSpacing(24)
        for one in self.lost:
            column.addWidget(RecoveryCard(self.owner, one, self._settled))
            column.addSpacing(14)
        column.addWidget(style.labelled("Start", "heading"))
        for name in ("new", "open", "open_data"):
            column.addWidget(StartRow(self.owner, name))
        recent = [p for p in self.owner.commands.recent() if p.exists()][:5]
        if recent:
            column.addSpacing(20)
            column.addWidget(style.labelled("Recent", "heading"))
        for path in recent:
            column.addWidget(line())
            column.addWidget(RecentRow(self.owner, path))
        column.addStretch(1)
        return column

    def _name(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(16)
        mark = QLabel()
        mark.setPixmap(icons.application().pixmap(48, 48))
        words = QVBoxLayout()
        words.setSpacing(0)
        words.addWidget(style.labelled("Nonius Explorer", "page"))
        words.addWidget(style.labelled("Pictures that say how far they may be trusted", "quiet"))
        row.addWidget(mark)
        row.addLayout(words)
        row.addStretch(1)
        return row

    def _settled(self, one: Lost) -> None:
        self.lost.remove(one)
        self.build()

    # --- right

    def _right(self) -> QVBoxLayout:
        column = QVBoxLayout()
        column.setSpacing(14)
        column.addSpacing(76)
        column.addWidget(style.labelled("Examples", "heading"))
        grid = QGridLayout()
        grid.setSpacing(24)
        there = paths.networks()
        shown = [one for one in EXAMPLES if one[0] in there]
        for i, (name, title, words, sign) in enumerate(shown):
            grid.addWidget(Example(self.owner, there[name], title, words, sign), i // 2, i % 2)
        if len(shown) % 2:
            grid.addWidget(self._more(there, {one[0] for one in shown}), len(shown) // 2, 1)
        column.addLayout(grid)
        column.addWidget(line())
        column.addLayout(_signs())
        column.addStretch(1)
        return column

    def _more(self, there: dict[str, Path] | object, shown: set[str]) -> QWidget:
        made = QWidget()
        column = QVBoxLayout(made)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        names = [n for n in paths.networks() if n not in shown]
        column.addWidget(style.labelled("More examples", "title"))
        for name in names[:7]:
            open_it = paths.networks()[name]
            link = button(_title(open_it), lambda p=open_it: self.owner.commands.open_path(p), link=True)  # type: ignore[misc]
            link.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Fixed)
            column.addWidget(link)
        left = len(names) - 7
        if left > 0:
            column.addWidget(style.labelled(f"and {left} more in the librarian", "small"))
        column.addStretch(1)
        return made


class Row(QWidget):
    """A row that can be clicked, and reached with the keyboard."""

    clicked = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Click."""
        if self.rect().contains(event.position().toPoint()):
            self.clicked.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Enter and Space click."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space):
            self.clicked.emit()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Lighter under the pointer; a ring with the focus."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.underMouse():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(style.colour("raised"))
            painter.drawRoundedRect(QRectF(self.rect()), 5, 5)
        if self.hasFocus():
            painter.setPen(QPen(style.colour("action"), 1.5))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), 5, 5)


class StartRow(Row):
    """Something to begin with."""

    def __init__(self, window: MainWindow, name: str) -> None:
        super().__init__()
        action = by_id()[name]
        self.setAccessibleName(action.words)
        self.clicked.connect(lambda: window.commands(name))
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 6, 6, 6)
        row.setSpacing(14)
        drawing = QLabel()
        drawing.setPixmap(icons.pixmap(action.icon, ratio=self.devicePixelRatioF()))
        words = QVBoxLayout()
        words.setSpacing(0)
        words.addWidget(style.labelled(action.words.rstrip("…")))
        words.addWidget(style.labelled(action.tip, "small"))
        row.addWidget(drawing)
        row.addLayout(words, 1)
        row.addWidget(style.labelled(action.keys, "boxed"))


class RecentRow(Row):
    """A network that was open before."""

    def __init__(self, window: MainWindow, path: Path) -> None:
        super().__init__()
        self.setAccessibleName(f"Open {path.name}")
        self.clicked.connect(lambda: window.commands.open_path(path))
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 4, 6, 4)
        row.setSpacing(14)
        drawing = QLabel()
        drawing.setPixmap(icons.pixmap("folder", "text 2", ratio=self.devicePixelRatioF()))
        words = QVBoxLayout()
        words.setSpacing(0)
        words.addWidget(style.labelled(path.name))
        words.addWidget(style.labelled(str(path.parent), "faint"))
        row.addWidget(drawing)
        row.addLayout(words, 1)
        row.addWidget(style.labelled(time.strftime("%d %B", time.localtime(path.stat().st_mtime)), "faint"))


class Example(Row):
    """A network with its picture."""

    def __init__(self, window: MainWindow, path: Path, title: str, words: str, sign: str) -> None:
        super().__init__()
        self.setAccessibleName(f"Open the example {title}")
        self.clicked.connect(lambda: window.commands.open_path(path))
        column = QVBoxLayout(self)
        column.setContentsMargins(6, 6, 6, 8)
        column.setSpacing(2)
        picture = QLabel()
        picture.setPixmap(_picture(path.stem, self.devicePixelRatioF()))
        column.addWidget(picture)
        row = QHBoxLayout()
        row.addWidget(style.labelled(title, "title"))
        row.addStretch(1)
        row.addWidget(style.labelled(sign, "sign"))
        column.addLayout(row)
        column.addWidget(style.labelled(words, "small"))


class RecoveryCard(QFrame):
    """What a process that did not close left: restore, restore frozen, discard."""

    def __init__(self, window: MainWindow, one: Lost, settled: object) -> None:
        super().__init__()
        self.owner, self.one, self.settled = window, one, settled
        self.setProperty("kind", "recovery")
        self.setMinimumWidth(380)
        edits = f"{one.edits} edit{'' if one.edits == 1 else 's'} after the last save, the last one at "
        when = time.strftime("%H:%M on %d %B", time.localtime(one.at))
        words = style.labelled(f"{one.name}, {edits}{when}. Your file is as you saved it.", "quiet")
        words.setWordWrap(True)
        self.restore = button("Restore", lambda: self._restore(False), primary=True)
        self.frozen = button("Restore frozen", lambda: self._restore(True), tip="Nothing runs until you unfreeze it")
        self.discard = button("Discard…", self._discard)
        row = QHBoxLayout()
        row.addWidget(self.restore)
        row.addWidget(self.frozen)
        row.addStretch(1)
        row.addWidget(self.discard)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 12, 14, 12)
        column.setSpacing(8)
        column.addWidget(style.labelled("The last session ended without closing", "title"))
        column.addWidget(words)
        column.addLayout(row)

    def _restore(self, frozen: bool) -> None:
        self.owner.restore(self.one, frozen)
        if callable(self.settled):
            self.settled(self.one)

    def _discard(self) -> None:
        if self.discard.text() == "Discard…":
            self.discard.setText("Really discard")
            return
        self.one.discard()
        if callable(self.settled):
            self.settled(self.one)


def _title(path: Path) -> str:
    """Of a network, in few words; its file's name where it has none."""
    try:
        found = json.loads(path.read_bytes()).get("settings", {}).get("title", "")
    except (OSError, ValueError, AttributeError):
        found = ""
    words = str(found) or path.stem
    return words if len(words) <= LETTERS else words[: LETTERS - 1].rstrip() + "…"


def _signs() -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(8)
    row.addWidget(style.labelled("On every wire and in every legend:", "quiet"))
    row.addSpacing(12)
    for sign, words in SIGNS:
        row.addWidget(style.labelled(sign, "title" if sign in "=?" else "sign"))
        row.addWidget(style.labelled(words))
        row.addSpacing(12)
    row.addStretch(1)
    return row


def _picture(name: str, ratio: float) -> QPixmap:
    """The picture of an example with round corners; its name where there is none."""
    made = QPixmap(PICTURE * ratio)
    made.setDevicePixelRatio(ratio)
    made.fill(Qt.GlobalColor.transparent)
    painter = QPainter(made)
    painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
    frame = QRectF(0.5, 0.5, PICTURE.width() - 1, PICTURE.height() - 1)
    path = QPainterPath()
    path.addRoundedRect(frame, 4, 4)
    painter.setClipPath(path)
    file = paths.data("resources") / "examples" / f"{name}-{style.present().name}.png"
    source = QPixmap(str(file))
    if source.isNull():
        painter.fillRect(frame, style.colour("view"))
    else:
        fitted = source.scaled(PICTURE * ratio, Qt.AspectRatioMode.KeepAspectRatioByExpanding,
                               Qt.TransformationMode.SmoothTransformation)  # fmt: skip
        fitted.setDevicePixelRatio(ratio)
        painter.drawPixmap(0, 0, fitted)
    painter.setClipping(False)
    painter.setPen(QPen(style.colour("divider"), 1))
    painter.drawPath(path)
    painter.end()
    return made
