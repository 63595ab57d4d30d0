"""Quick-add: a line to type in, what is meant below it, and what it does at the right."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from PySide6.QtCore import (
    QAbstractListModel,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QRect,
    QRectF,
    QSettings,
    QSize,
    Qt,
)
from PySide6.QtGui import QFontMetrics, QKeyEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QFrame,
    QLineEdit,
    QListView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from app.gui import edits, glyphs, rows
from app.gui.edits import Held
from app.gui.glyphs import Look, font
from app.gui.page_view import PageView
from app.gui.ranking import Match, rank
from modules.declare import Module

if TYPE_CHECKING:
    from app.gui.canvas import Canvas

WIDTH, HEIGHT = 720, 466
TOP, FOOT, LIST, ROW = 52, 44, 420, 48
Index = QModelIndex | QPersistentModelIndex


class Matches(QAbstractListModel):
    """What is meant, the likeliest first."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.found: list[Match] = []

    def show(self, found: list[Match]) -> None:
        """Take other matches."""
        self.beginResetModel()
        self.found = found
        self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        """How many."""
        return len(self.found)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """The title, for readers of the screen."""
        return self.found[index.row()].module.title if role == Qt.ItemDataRole.DisplayRole else None


class Rows(QStyledItemDelegate):
    """Draws a match."""

    def __init__(self, look: Look, parent: QWidget) -> None:
        super().__init__(parent)
        self.look = look

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw it."""
        model = index.model()
        assert isinstance(model, Matches)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box: QRect = option.rect
        state: QStyle.StateFlag = option.state
        chosen = bool(state & QStyle.StateFlag.State_Selected)
        rows.row(painter, model.found[index.row()], QRectF(box), self.look, chosen=chosen)
        painter.restore()

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        """One row."""
        return QSize(LIST, ROW)


class QuickAdd(QWidget):
    """The popup. Enter adds, Esc closes; with a wire in the hand only what fits it is offered.

    Attributes
    ----------
    beside : the module goes beside the selected node and is wired to it, since the pointer is elsewhere

    Parameters
    ----------
    at : place of the canvas's window
    held : the wire in the hand, None for a module by itself
    """

    def __init__(self, canvas: Canvas, at: QPoint, held: Held | None = None) -> None:
        super().__init__(canvas.window(), Qt.WindowType.Popup | Qt.WindowType.FramelessWindowHint)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.canvas, self.at, self.held, self.look = canvas, at, held, canvas.look
        self.beside = False
        self.setFixedSize(WIDTH, HEIGHT)
        self.field = QLineEdit(self, placeholderText="Name, alias or room of a module")
        self.field.setStyleSheet("QLineEdit { background: transparent; border: 0; }")
        self.field.setFont(font(16))
        self.field.setGeometry(44, 8, WIDTH - 44 - (190 if held else 16), TOP - 16)
        self.matches = Matches(self)
        self.list = QListView(self)
        self.list.setModel(self.matches)
        self.list.setItemDelegate(Rows(self.look, self))
        self.list.setFrameShape(QFrame.Shape.NoFrame)
        self.list.setStyleSheet("QListView { background: transparent; border: 0; }")
        self.list.setUniformItemSizes(True)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setGeometry(1, TOP + 6, LIST - 2, HEIGHT - TOP - FOOT - 34)
        self.page = PageView(self.look, self)
        self.page.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.page.setGeometry(LIST + 20, TOP + 14, WIDTH - LIST - 32, HEIGHT - TOP - FOOT - 24)
        self.field.setFocus()
        self.setFocusProxy(self.field)
        self.field.installEventFilter(self)
        self.field.textChanged.connect(self._look_up)
        self.list.clicked.connect(lambda _: self.take())
        self.list.selectionModel().currentChanged.connect(lambda *_: self._describe())
        self.fitting = self.offered()
        self._look_up("")

    def offered(self) -> list[Module]:
        """The modules to choose from."""
        session = self.canvas.session
        everything = list(session.catalogue)
        held = self.held
        if held is None:
            return everything
        return [m for m in everything if edits.fits_held(m, held, session.network, session.catalogue)]

    def open(self) -> None:
        """Show it beside the pointer, inside the screen."""
        place = self.canvas.viewport().mapToGlobal(self.at) + QPoint(4, -TOP // 2)
        screen = self.canvas.screen().availableGeometry()
        x = min(max(place.x(), screen.left()), screen.right() - WIDTH)
        y = min(max(place.y(), screen.top()), screen.bottom() - HEIGHT)
        self.move(x, y)
        self.show()
        self.field.setFocus(Qt.FocusReason.PopupFocusReason)

    # --- what is meant

    def ranked(self, typed: str) -> list[Match]:
        """What is meant."""
        return rank(self.fitting, typed, used())

    def _look_up(self, typed: str) -> None:
        self.matches.show(self.ranked(typed))
        if self.matches.found:
            self.list.setCurrentIndex(self.matches.index(0))
        self._describe()
        self.update()

    @property
    def current(self) -> Match | None:
        """The match that Enter takes."""
        row = self.list.currentIndex().row()
        return self.matches.found[row] if 0 <= row < len(self.matches.found) else None

    def _describe(self) -> None:
        match = self.current
        if match is not None:
            self.page.show_page(rows.page(match.module, self.look, short=True))
        else:
            self.page.show_page("")

    def take(self, wired: bool = True) -> None:
        """Add the chosen module, wired to what is in the hand."""
        match = self.current
        if match is None:
            return
        canvas, held = self.canvas, self.held if wired else None
        place = canvas.mapToScene(self.at)
        self.close()
        shift = QPoint(0, -44) if held and held.out else QPoint(-150, -44) if held else QPoint(-75, -14)
        if canvas.hands.add(match.module.id, None if self.beside else place + shift, held):
            count(match.module.id)
        canvas.setFocus()

    # --- keys

    def eventFilter(self, watched: Any, event: Any) -> bool:
        """Arrows choose while the line is typed in."""
        if isinstance(event, QKeyEvent) and event.type() == QKeyEvent.Type.KeyPress:
            return self._key(event)
        return super().eventFilter(watched, event)

    def _key(self, event: QKeyEvent) -> bool:
        steps = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 6, Qt.Key.Key_PageUp: -6, Qt.Key.Key_Tab: 1}
        key = Qt.Key(event.key())
        if key in steps:
            last = len(self.matches.found) - 1
            row = min(max(self.list.currentIndex().row() + steps[key], 0), last)
            self.list.setCurrentIndex(self.matches.index(row))
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.take(not event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        elif key == Qt.Key.Key_Escape:
            self.close()
        elif key == Qt.Key.Key_F1 and self.current is not None:
            self.canvas.helpRequested.emit(self.current.module.id)
            self.close()
        else:
            return False
        return True

    # --- drawing

    def paintEvent(self, event: QPaintEvent) -> None:
        """Panel, lines, what is filtered, and the keys."""
        look, painter = self.look, QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), look["panel"])
        painter.setPen(QPen(look["divider"], 1))
        painter.drawLine(1, TOP, WIDTH - 1, TOP)
        painter.drawLine(1, HEIGHT - FOOT, WIDTH - 1, HEIGHT - FOOT)
        painter.drawLine(LIST, TOP, LIST, HEIGHT - FOOT)
        glyphs.room(painter, "search", QRectF(18, TOP / 2 - 8, 16, 16).topLeft(), look["text 2"])
        if self.held is not None:
            self._chip(painter)
        painter.setPen(look["text 3"])
        painter.setFont(font(11))
        words = QFontMetrics(font(11)).elidedText(self.said(), Qt.TextElideMode.ElideRight, LIST - 32)
        painter.drawText(QRectF(16, HEIGHT - FOOT - 28, LIST - 32, 24), rows.MIDDLE, words)
        x = 16.0
        for key, what in self.hints():
            x = self._hint(painter, key, what, x)
        self._hint(painter, "Esc", "close", WIDTH - 92.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(look["edge"], 1))
        painter.drawRect(QRectF(0.5, 0.5, WIDTH - 1, HEIGHT - 1))

    def said(self) -> str:
        """How many modules are offered."""
        every, found = len(list(self.canvas.session.catalogue)), len(self.matches.found)
        if not found:
            return "Nothing of that name" + (" fits this wire" if self.held else "") + ": try another word"
        return f"{found} of {every} modules fit this wire" if self.held else f"{found} of {every} modules"

    def hints(self) -> list[tuple[str, str]]:
        """Keys, and what they do."""
        keys = [("Enter", "add and wire" if self.held else "add"), ("↑ ↓", "choose"), ("F1", "help page")]
        if self.held:
            keys.insert(1, ("Shift Enter", "add only"))
        return keys

    def _chip(self, painter: QPainter) -> None:
        held = self.held
        assert held is not None
        kind = glyphs.TYPES.get(held.kind, held.kind)
        text = f"{'takes' if held.out else 'gives'} {kind}"
        wide = QFontMetrics(font(12)).horizontalAdvance(text) + 40
        box = QRectF(WIDTH - wide - 16, TOP / 2 - 13, wide, 26)
        painter.setPen(QPen(self.look["edge"], 1))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRoundedRect(box, 4, 4)
        glyphs.port(painter, held.kind, QRectF(box.left() + 16, box.center().y(), 0, 0).topLeft(), self.look, scale=0.8)
        painter.setFont(font(12))
        painter.setPen(self.look["text"])
        painter.drawText(box.adjusted(28, 0, 0, -1), rows.MIDDLE, text)

    def _hint(self, painter: QPainter, key: str, what: str, x: float) -> float:
        y = HEIGHT - FOOT / 2
        painter.setFont(font(11))
        wide = QFontMetrics(font(11)).horizontalAdvance(key) + 12
        painter.setPen(QPen(self.look["divider"], 1))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRoundedRect(QRectF(x, y - 9, wide, 18), 3, 3)
        painter.setPen(self.look["text"])
        painter.drawText(QRectF(x, y - 9, wide, 17), Qt.AlignmentFlag.AlignCenter, key)
        painter.setPen(self.look["text 2"])
        painter.drawText(QRectF(x + wide + 6, y - 9, 140, 17), rows.MIDDLE, what)
        return x + wide + 6 + QFontMetrics(font(11)).horizontalAdvance(what) + 18


def used() -> dict[str, int]:
    """How often each module was taken on this computer."""
    kept = QSettings().value("quick add/used", {})
    return rows.counts(kept) if isinstance(kept, dict) else {}


def count(module: str) -> None:
    """Remember that a module was taken."""
    QSettings().setValue("quick add/used", {**used(), module: used().get(module, 0) + 1})
