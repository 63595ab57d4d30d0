"""The librarian: all modules by room, example networks, the user's own; search, drag, double-click."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QEvent, QMimeData, QModelIndex, QPersistentModelIndex, QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QDrag, QFontMetricsF, QKeyEvent, QPainter, QPixmap
from PySide6.QtWidgets import (
    QFrame,
    QLineEdit,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app import paths
from app.gui import glyphs, rows, style
from app.gui.canvas import MODULE
from app.gui.glyphs import ROOMS, Look, font
from app.gui.ranking import Match, rank
from modules.declare import Module

if TYPE_CHECKING:
    from app.gui.session import Session

WHAT = Qt.ItemDataRole.UserRole
"""Of a row: a Match, a path (example), a Broken, or the name of a section."""
ROW, SECTION, WIDTH = 24, 30, 224
Index = QModelIndex | QPersistentModelIndex


class Drawing(QStyledItemDelegate):
    """Draws sections and rows."""

    def __init__(self, tree: Tree, look: Look) -> None:
        super().__init__(tree)
        self.tree, self.look = tree, look

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        """Sections are taller; a broken module has a line for its reason."""
        if not index.parent().isValid():
            return QSize(WIDTH, SECTION)
        return QSize(WIDTH, ROW if not isinstance(index.data(WHAT), tuple) else ROW + 32)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw one."""
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        rect: QRect = option.rect
        state: QStyle.StateFlag = option.state
        box = QRectF(0, rect.top(), self.tree.viewport().width(), rect.height())
        if state & QStyle.StateFlag.State_Selected:
            painter.fillRect(box, self.look["selected row"])
        elif state & QStyle.StateFlag.State_MouseOver:
            painter.fillRect(box, self.look["head"])
        if not index.parent().isValid():
            self._section(painter, box, index)
        else:
            self._row(painter, box, index.data(WHAT))
        painter.restore()

    def _section(self, painter: QPainter, box: QRectF, index: Index) -> None:
        look, y = self.look, box.center().y()
        model = index.model()
        unfolded = self.tree.isExpanded(model.index(index.row(), 0))
        painter.setPen(glyphs.pen(look["text 2"], 1.4))
        painter.save()
        painter.translate(15, y)
        painter.rotate(90 if unfolded else 0)
        painter.drawPolyline([QPointF(-2, -3.5), QPointF(2, 0), QPointF(-2, 3.5)])
        painter.restore()
        glyphs.room(painter, str(index.data(WHAT)), QPointF(27, y - 8), look["text 2"])
        painter.setFont(font(12, True))
        painter.setPen(look["text"])
        painter.drawText(box.adjusted(51, 0, -30, 0), rows.MIDDLE, index.data())
        painter.setFont(font(11))
        painter.setPen(look["text 3"])
        right = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight
        painter.drawText(box.adjusted(0, 0, -14, 0), right, str(model.rowCount(model.index(index.row(), 0))))

    def _row(self, painter: QPainter, box: QRectF, what: Any) -> None:
        look = self.look
        if isinstance(what, Match):
            begin = rows.ports(painter, what.module, box.right() - 12, box.center().y(), look, 14)
            name = box.adjusted(51, 0, 0, 0)
            name.setRight(begin - 4)
            rows.name(painter, what.module.title, what.letters, name, look)
            return
        if isinstance(what, tuple):
            name, why = what
            rows.name(painter, name, (), QRectF(51, box.top(), box.width() - 85, ROW), look, 12, "text 3")
            glyphs.state(painter, "failed", QPointF(box.right() - 20, box.top() + 12), look)
            painter.setFont(font(11))
            painter.setPen(look["text 3"])
            place = QRectF(51, box.top() + ROW - 2, box.width() - 63, 32)
            painter.drawText(place, Qt.TextFlag.TextWordWrap, f"not loaded: {why}")
            return
        painter.setFont(font(12))
        painter.setPen(look["text"])
        text = QFontMetricsF(font(12)).elidedText(Path(str(what)).stem, Qt.TextElideMode.ElideRight, box.width() - 63)
        painter.drawText(box.adjusted(51, 0, 0, 0), rows.MIDDLE, text)


class Tree(QTreeWidget):
    """Rows that can be dragged onto the canvas."""

    def __init__(self, look: Look, parent: QWidget) -> None:
        super().__init__(parent)
        self.look = look
        self.setHeaderHidden(True)
        self.setIndentation(0)
        self.setRootIsDecorated(False)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setMouseTracking(True)
        self.setDragEnabled(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setExpandsOnDoubleClick(False)
        self.setStyleSheet("QTreeView { background: transparent; border: 0; }")
        self.setAccessibleName("Modules")

    def startDrag(self, actions: Qt.DropAction) -> None:
        """Carry the module's id."""
        item = self.currentItem()
        what = item.data(0, WHAT) if item else None
        if not isinstance(what, Match):
            return
        drag, data = QDrag(self), QMimeData()
        data.setData(MODULE, what.module.id.encode())
        data.setText(what.module.title)
        drag.setMimeData(data)
        drag.setPixmap(_card(what.module, self.look))
        drag.exec(Qt.DropAction.CopyAction)


def _card(module: Module, look: Look) -> QPixmap:
    """What hangs on the pointer."""
    pixmap = QPixmap(300, 56)
    pixmap.setDevicePixelRatio(2)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(look["node edge"])
    painter.setBrush(look["head"])
    painter.drawRoundedRect(QRectF(0.5, 0.5, 149, 27), 6, 6)
    glyphs.room(painter, module.room, QPointF(10, 6), look["text 2"])
    painter.setFont(font(12, True))
    painter.setPen(look["text"])
    painter.drawText(QRectF(32, 0, 114, 28), rows.MIDDLE, module.title)
    painter.end()
    return pixmap


class Librarian(QWidget):
    """All that can be put on the canvas.

    Signals
    -------
    addRequested : id of a module that was double-clicked
    openRequested : path of an example network
    helpRequested : id of a module
    brokenRequested : name of a module that did not load
    """

    addRequested = Signal(str)
    openRequested = Signal(str)
    helpRequested = Signal(str)
    brokenRequested = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.look = session, Look()
        self.field = QLineEdit(self, placeholderText="Search modules", clearButtonEnabled=True)
        self.field.setAccessibleName("Search modules")
        self.tree = Tree(self.look, self)
        self.tree.setItemDelegate(Drawing(self.tree, self.look))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 10, 0, 0)
        column.setSpacing(8)
        inner = QVBoxLayout()
        inner.setContentsMargins(12, 0, 12, 0)
        inner.addWidget(self.field)
        column.addLayout(inner)
        column.addWidget(self.tree)
        self.setMinimumWidth(180)
        self.closed = {"examples"}
        self.field.textChanged.connect(lambda _: self.fill())
        self.field.installEventFilter(self)
        self.tree.itemClicked.connect(self._clicked)
        self.tree.itemDoubleClicked.connect(self._double)
        self.tree.installEventFilter(self)
        style.watch().changed.connect(self.follow_theme)
        self.fill()

    def sizeHint(self) -> QSize:
        """As wide as the picture of the window has it."""
        return QSize(WIDTH, 600)

    def fill(self) -> None:
        """Show what there is, or what is meant by the search."""
        typed = self.field.text().strip()
        self.tree.clear()
        found = rank(self.session.catalogue, typed)
        if not typed:
            found = sorted(found, key=lambda m: m.module.title)
        theirs = [m for m in found if not m.module.digest]
        for name, title in ROOMS.items():
            self._section(name, title, [m for m in theirs if m.module.room == name], typed)
        others = [(Path(b.where).name, b.sentence) for b in self.session.catalogue.broken.values()]
        broken = [b for b in others if not typed or typed.casefold() in b[0].casefold()]
        self._section("mine", "My modules", [*(m for m in found if m.module.digest), *broken], typed)
        examples = [str(p) for n, p in paths.networks().items() if not typed or typed.casefold() in n.casefold()]
        self._section("examples", "Example networks", examples, typed)
        if typed and found:
            self._choose(found[0].module.id)

    def _section(self, name: str, title: str, contents: list[Any], typed: str) -> None:
        if not contents and (typed or name in ("mine", "examples")):
            return
        head = QTreeWidgetItem([title])
        head.setData(0, WHAT, name)
        head.setFlags(Qt.ItemFlag.ItemIsEnabled)
        self.tree.addTopLevelItem(head)
        for what in contents:
            text = what.module.title if isinstance(what, Match) else what[0] if isinstance(what, tuple) else Path(what).stem
            item = QTreeWidgetItem([text])
            item.setData(0, WHAT, what)
            item.setToolTip(0, _words(what))
            draggable = Qt.ItemFlag.ItemIsDragEnabled if isinstance(what, Match) else Qt.ItemFlag.NoItemFlags
            item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | draggable)
            head.addChild(item)
        head.setExpanded(bool(typed) or name not in self.closed)

    def _choose(self, module: str) -> None:
        for i in range(self.tree.topLevelItemCount()):
            head = self.tree.topLevelItem(i)
            for item in [head.child(j) for j in range(head.childCount())] if head else []:
                what = item.data(0, WHAT) if item else None
                if item and isinstance(what, Match) and what.module.id == module:
                    self.tree.setCurrentItem(item)
                    return

    # --- acting

    def _clicked(self, item: QTreeWidgetItem) -> None:
        name = item.data(0, WHAT)
        if item.parent() is None:
            item.setExpanded(not item.isExpanded())
            (self.closed.discard if item.isExpanded() else self.closed.add)(name)

    def _double(self, item: QTreeWidgetItem) -> None:
        what = item.data(0, WHAT)
        if item.parent() is None:
            return
        if isinstance(what, Match):
            self.addRequested.emit(what.module.id)
        elif isinstance(what, tuple):
            self.brokenRequested.emit(what[0])
        else:
            self.openRequested.emit(str(what))

    def eventFilter(self, watched: Any, event: Any) -> bool:
        """Enter adds, F1 helps, down goes from the search to the list."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            item = self.tree.currentItem()
            key = event.key()
            if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and item is not None:
                self._double(item) if item.parent() else self._clicked(item)
                return True
            if key == Qt.Key.Key_F1 and item is not None and isinstance(item.data(0, WHAT), Match):
                self.helpRequested.emit(item.data(0, WHAT).module.id)
                return True
            if watched is self.field and key == Qt.Key.Key_Down:
                self.tree.setFocus()
                return True
        return super().eventFilter(watched, event)

    def follow_theme(self) -> None:
        """Draw in the theme in force."""
        if self.look.set(glyphs.current()):
            self.tree.viewport().update()


def _words(what: Any) -> str:
    if isinstance(what, Match):
        return f"{rows.first_sentence(what.module)}.\nDrag it onto the canvas, or double-click; F1 opens its help"
    if isinstance(what, tuple):
        return f"{what[0]} did not load: {what[1]}\nMend the file and it comes back"
    return f"{Path(what).stem}\nDouble-click opens it"
